"""Numerical options: described, listed, stored."""

import json
import runpy
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest
from small_joint import make_joint, make_preload

from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.windows import WindowMargins, frequency_window
from boltjoint.joint.clusters import SlipStateOptions, cluster_by_motion, find_slip_states
from boltjoint.joint.hysteresis import FitOptions
from boltjoint.joint.partition import partition_regions, region_error
from boltjoint.joint.reductions import reduce_joint
from boltjoint.options import Options
from boltjoint.solvers.step_control import LaggedControl, StepControl

DOCS = Path(__file__).parents[1] / "docs"


@dataclass(frozen=True)
class _Example(Options):
    """An example.

    Parameters
    ----------
    first, second
        Two numbers,
        on two lines.
    third
        One.

    Raises
    ------
    ValueError
        Never.
    """

    first: float = 1.0
    second: int = 2
    third: str = "x"


def test_descriptions_are_those_of_the_docstring():
    assert list(_Example.descriptions()) == [
        (["first", "second"], "Two numbers, on two lines."),
        (["third"], "One."),
    ]


@pytest.mark.parametrize("options", runpy.run_path(str(DOCS / "options.py"))["classes"]())
def test_every_option_is_described(options):
    described = [name for names, _ in options.descriptions() for name in names]
    assert described == [field.name for field in fields(options)]


def test_the_page_lists_every_option_of_the_library():
    written = (DOCS / "options.md").read_text(encoding="utf-8")
    made = runpy.run_path(str(DOCS / "options.py"))["page"]()
    assert written == made, "run: make reference"


@pytest.mark.parametrize("coordinates", ["linear", "backbone"])
def test_a_response_stores_what_it_was_solved_with(joint, coordinates):
    control = StepControl(peak_tolerance=1e-5, lagged=LaggedControl(maximum_iterations=7))
    found = solve_response(joint, [1.0], method=coordinates, damping=0.01, control=control)
    stored = json.loads(found.attrs["options"])
    assert stored["peak_tolerance"] == 1e-5
    assert stored["lagged"]["maximum_iterations"] == 7
    assert set(stored) == {field.name for field in fields(StepControl)}


def test_a_backbone_stores_what_it_was_traced_with(joint):
    control = StepControl(amplitude_scale=4.0)
    window = frequency_window(joint)
    found = find_backbone(joint, [1.0], damping=0.01, window=window, control=control)
    assert json.loads(found.attrs["options"])["amplitude_scale"] == 4.0


@pytest.mark.parametrize(
    ("reduction", "changed"),
    [
        ("elements", {"loop_samples": 16}),
        ("harmonic", {"lowest_amplitude": 0.1}),
        ("harmonic", {"hidden_loss": 0.1}),
        ("iwan", {"compared_amplitudes": 12}),
    ],
)
def test_fits_follow_and_store_their_options(reduction, changed):
    nodes = make_joint()
    regions = partition_regions(nodes, make_preload(nodes), 2)
    given = {} if reduction == "iwan" else {"count": 3}
    usual, fit = reduce_joint(regions, reduction, **given)
    assert json.loads(fit.attrs["options"])["sharpnesses"] == [8.0, 16.0, 32.0, 128.0]
    other, fit = reduce_joint(regions, reduction, options=FitOptions(**changed), **given)
    assert json.loads(fit.attrs["options"]).items() >= changed.items()
    found, known = (
        [getattr(each.law, name) for name in each.law.quantities] for each in (other, usual)
    )
    assert not np.allclose(found, known, rtol=1e-6)


@pytest.mark.parametrize("name", [field.name for field in fields(FitOptions)])
def test_options_of_fits_are_positive(name):
    with pytest.raises(ValueError, match=name):
        FitOptions(**{name: () if name == "sharpnesses" else 0})


def test_regions_are_made_and_judged_by_as_many_slip_states_as_asked_for():
    joint, few = make_joint(200), SlipStateOptions(states=3)
    states = find_slip_states(joint, 1, few)
    load = joint.law.slip_force
    stuck_load = np.array([load[stuck].sum() for stuck in states.stick]) / load.sum()
    # pairs of the same load are released together, and one pair carries little of it
    assert stuck_load == pytest.approx([1.0, 0.5, 0.0], abs=3 * load.max() / load.sum())
    args = joint, make_preload(joint), None, "clusters"
    counts = [
        partition_regions(*args, tolerance=0.0035, options=SlipStateOptions(n)).points
        for n in (3, 9)
    ]
    # fewer regions are within a tolerance that is asked for in fewer states
    assert counts[0] < counts[1]
    regions = partition_regions(*args[:2], 6, "clusters")
    assert region_error(joint, regions, options=few) < 0.8 * region_error(joint, regions)
    # pairs that move alike in one state do not in another
    mode = np.random.default_rng(0).normal(size=joint.tangential_mode.shape)
    scattered = replace(joint, tangential_mode=mode)
    clusters = cluster_by_motion(scattered, 4, options=few)
    assert not np.array_equal(clusters, cluster_by_motion(scattered, 4))
    regions = partition_regions(scattered, make_preload(joint), 4, "clusters", options=few)
    np.testing.assert_array_equal(regions.law.point_of_element, clusters)
    with pytest.raises(ValueError, match="states"):
        SlipStateOptions(states=1)


def test_margins_of_a_window(joint):
    low, high = frequency_window(joint)
    wider = frequency_window(joint, margins=WindowMargins(below=0.5, above=1.5))
    assert wider == pytest.approx((low / 0.85 * 0.5, high / 1.05 * 1.5))


@pytest.mark.parametrize("name", [field.name for field in fields(LaggedControl)])
def test_options_of_a_lagged_basis_are_positive(name):
    with pytest.raises(ValueError, match=name):
        LaggedControl(**{name: 0})
