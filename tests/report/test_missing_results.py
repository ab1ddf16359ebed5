import inspect
import re

import numpy as np
import pytest
from page_examples import CASE, edit, figure, overview_of, reduced_models_of, without_joints, write

from boltjoint.report.pages.content import RESOLUTION_IN_TIME
from boltjoint.verification.residual_in_time import residuals_in_time


def without_reference(frame):
    """No response is compared with another, and none of linear modes is there."""
    return without_errors(frame[frame["coordinates"] != "linear"])


def without_nodes(frame):
    """The same where no node-to-node joint is solved."""
    return without_errors(frame[frame["joint"] != "node-to-node"])


def with_broken_reference(frame):
    """The reference broke off at every force."""
    is_reference = (frame["joint"] == "node-to-node") & (frame["coordinates"] == "linear")
    reason = frame["reason"].where(~is_reference, "no solution found")
    return without_errors(frame).assign(complete=frame["complete"] & ~is_reference, reason=reason)


def without_errors(frame):
    errors = [name for name in frame if "_error_" in name]
    return frame.assign(**dict.fromkeys(errors, np.nan)).drop(columns="residual_in_time")


WITHOUT_REFERENCE = {
    "no linear modes": (without_reference, {"coordinates": ["rdnm-1"]}),
    "no node-to-node joint": (
        without_nodes,
        {"solve": without_joints(CASE["solve"], "node-to-node")},
    ),
    "a reference that broke off": (with_broken_reference, {}),
}


@pytest.mark.parametrize("situation", WITHOUT_REFERENCE)
def test_a_case_without_a_reference_has_its_page(artefacts, situation):
    change, changed = WITHOUT_REFERENCE[situation]
    edit("accuracy", change)
    edit("times", lambda frame: frame.assign(reduction_percent=np.nan))
    page = write(artefacts, **changed)
    assert 'id="accuracy-free-4"' in page
    assert "Errors of the peak against the reference" not in page
    assert not re.search(r"\bnan\b", re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL))
    if not changed:
        reference = figure(page, "response_mine_free-4_node-to-node_linear_resonance=1")
        assert "Broken off at 0.001, 50 N: no solution found." in reference


@pytest.mark.parametrize("situation", WITHOUT_REFERENCE)
def test_a_case_without_a_reference_stands_in_the_overview(artefacts, situation):
    change, changed = WITHOUT_REFERENCE[situation]
    edit("accuracy", change)
    # frequency and response at both forces, and their errors
    assert overview_of(artefacts, **changed)[1][4:12] == ["–"] * 8
    assert reduced_models_of(artefacts, **changed)[1][1] == "–"


@pytest.mark.parametrize(
    ("residual", "printed"), [(9.9e-7, "below 10⁻⁶"), (3.21e-4, "0.00032"), (np.nan, "–")]
)
def test_a_residual_in_time_is_no_smaller_than_its_resolution(artefacts, residual, printed):
    edit("accuracy", lambda frame: frame.assign(residual_in_time=residual))
    assert printed in write(artefacts).split('id="accuracy-free-4"')[1]
    assert overview_of(artefacts)[1][-1] == printed
    tolerance = inspect.signature(residuals_in_time).parameters["tolerance"]
    assert RESOLUTION_IN_TIME == tolerance.default


def test_peaks_of_branches_that_broke_off_are_left_out(artefacts):
    def break_off(frame):
        lost = frame["force_N"] == 50
        return frame.assign(complete=~lost, peak_frequency_Hz=71.5)

    edit("accuracy", break_off)
    peaks = re.search(
        r"Peaks of the node-to-node joint around resonance 1.*?</table>", write(artefacts), re.S
    )
    # frequency, response and error in linear modes and in one response-dependent mode
    assert re.findall(r"<td.*?>(.*?)</td>", peaks[0])[7:] == ["50", *["–"] * 6]
    untested = ["71.5", "not tested", "1.5", "not tested"]
    assert overview_of(artefacts)[1][4:12] == [*untested, *["–"] * 4]
    assert reduced_models_of(artefacts)[1][1] == "20.00"


def test_nothing_is_saved_where_no_joint_is_fitted(artefacts):
    assert reduced_models_of(artefacts)[1][-2:] == ["10.00", "40.00"]
    solve = without_joints(CASE["solve"], "regions=6/elements=4")
    assert reduced_models_of(artefacts, solve=solve)[1][-2:] == ["–", "–"]


def test_a_case_of_which_nothing_was_solved_has_its_pages(artefacts):
    def fail(frame):
        numbers = frame.select_dtypes("float").columns.difference(["force_N"])
        lost = frame.assign(**dict.fromkeys(numbers, np.nan), complete=False, turning_points=0)
        return lost.assign(reason="no solution found at the start of the window")

    edit("accuracy", fail)
    edit("times", lambda frame: frame.assign(complete=False))
    page = write(artefacts)
    reference = figure(page, "response_mine_free-4_node-to-node_linear_resonance=1")
    assert "Broken off at 0.001, 50 N: no solution found at the start of the window." in reference
    assert not re.search(r"\bnan\b", re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL))
    assert overview_of(artefacts)[1][4:12] == ["–"] * 8
