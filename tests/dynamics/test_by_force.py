"""Responses and branches as notebooks use them."""

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.response_file import by_force

FORCES = [1.0, 20.0]


@pytest.fixture(scope="module")
def joint():
    return make_joint(12)


@pytest.fixture(scope="module")
def response(joint):
    return solve_response(joint, FORCES, damping=0.01)


def test_a_level_is_selected_by_its_force(joint, response):
    arranged = by_force(response, joint)
    assert arranged["force"].to_numpy().tolist() == FORCES
    for force in FORCES:
        here = arranged.sel(force=force).dropna("point", subset=["frequency"])
        mine = (response["excitation_force"] == force) & (response["converged"] == 1)
        expected = response["response_amplitude"].to_numpy()[mine]
        np.testing.assert_array_equal(here["response_amplitude"], expected)
        assert float(here["peak_amplitude"]) == expected.max()
        # the output point is the only sensor
        motion = here["complex_amplitude"].sel(sensor="output").to_numpy()
        np.testing.assert_allclose(abs(motion), expected, rtol=1e-12)
        # the motion falls behind the force, and is a quarter of a period behind at the peak
        phase = np.degrees(np.angle(motion))
        peak = int(expected.argmax())
        assert 0 > phase[0] > phase[peak] > phase[-1] > -180
        assert abs(phase[peak] + 90) < 10


def test_branches_of_other_lengths_end_with_not_a_number(response):
    arranged = by_force(response)
    counts = [int((response["excitation_force"] == force).sum()) for force in FORCES]
    assert arranged.sizes["point"] == max(counts)
    assert np.isfinite(arranged["frequency"]).sum("point").to_numpy().tolist() == counts
    assert "complex_amplitude" not in arranged


def test_a_response_of_another_joint_is_refused(response):
    joint = make_joint(12)
    fewer = make_joint(12).__class__(
        **{
            **{name: getattr(joint, name) for name in ("position", "law", "element_position")},
            **{
                name: getattr(joint, name)[..., :2]
                for name in (
                    *("natural_frequency", "excitation_mode", "response_mode"),
                    "tangential_mode",
                )
            },
        }
    )
    with pytest.raises(ValueError, match="the response has 3 modes, the joint 2"):
        by_force(response, fewer)


def test_a_branch_becomes_a_dataset_and_a_drawing(joint):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    branch = solve_branch(joint, 1.0, damping=0.01)
    stored = branch.to_dataset()
    assert float(stored["response_amplitude"].max()) == branch.amplitude.max()
    (line,) = branch.plot(color="black")
    np.testing.assert_array_equal(line.get_xdata(), branch.frequency[branch.converged])
    assert line.axes.get_yscale() == "log"
