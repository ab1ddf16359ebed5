"""Methods by which responses are found: their names, and one that is not of this package."""

import inspect
from dataclasses import dataclass, replace

import numpy as np
import pytest
from random_joints import random_joint
from small_joint import make_joint

from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.response.branch import ErrorLimits
from boltjoint.dynamics.response.frequency_response import (
    as_method,
    method_of,
    solve_branch,
    solve_response,
)
from boltjoint.dynamics.response.methods import LinearModes, Method, ResponseDependentModes
from boltjoint.dynamics.response.synthesis import ModalSynthesis
from boltjoint.dynamics.response.windows import Resonance, frequency_window

LOSS = 0.01


@pytest.mark.parametrize(
    ("method", "name", "words"),
    [
        (LinearModes(), "linear", {}),
        (LinearModes(jacobian="forward-difference"), "linear", {"jacobian": "forward-difference"}),
        (ResponseDependentModes(2), "rdnm-2", {}),
        (ResponseDependentModes(3, is_lagged=True), "rdnm-3", {"basis_update": "lagged"}),
        (
            ResponseDependentModes(1, is_complex=True, quasi_static_correction=False),
            "complex-rdnm-1",
            {"quasi_static_correction": False},
        ),
        (
            ResponseDependentModes(2, limits=ErrorLimits(0.1), has_fallback=True),
            "rdnm-2",
            {"largest_error": 0.1, "fallback": "linear"},
        ),
        (ModalSynthesis(), "backbone", {}),
    ],
)
def test_words_of_files_give_the_method(method, name, words):
    assert method_of(name, **words) == method
    assert method.name == name
    if not words:
        assert as_method(name) == as_method(method) == method


def test_a_branch_that_breaks_off_is_followed_again_unless_that_is_not_asked_for():
    joint, force, loss_factor = random_joint("constant", 1)
    lagged = ResponseDependentModes(1, is_lagged=True)
    branches = [
        solve_branch(joint, force, method, damping=loss_factor)
        for method in (lagged, replace(lagged, repeats=False))
    ]
    assert [branch.complete for branch in branches] == [True, False]
    assert branches[1].reason == "the branch would jump or turn back"


@pytest.mark.parametrize("name", ["linear", "rdnm-2", "complex-rdnm-1", "backbone"])
def test_a_response_is_that_of_branches_by_the_same_method(name):
    joint, resonance = make_joint(), Resonance(1, (60.0, 200.0))
    response = solve_response(joint, [1.0, 20.0], name, damping=LOSS, resonance=resonance)
    assert response.attrs["coordinates"] == name
    np.testing.assert_array_equal(response.attrs["window_Hz"], (60.0, 200.0))
    for place, force in enumerate((1.0, 20.0)):
        branch = solve_branch(joint, force, method_of(name), damping=LOSS, resonance=resonance)
        # a backbone for one force ends elsewhere than that for both
        tolerance = 1e-6 if name == "backbone" else 0
        peak = response["peak_amplitude"][place].item()
        assert branch.peak_amplitude == pytest.approx(peak, rel=tolerance)


def test_a_synthesis_takes_a_backbone_of_a_file_or_of_the_library():
    joint, forces = make_joint(), [5.0]
    stored = find_backbone(joint, forces, damping=LOSS, window=frequency_window(joint))
    found = solve_branch(joint, 5.0, ModalSynthesis(stored), damping=LOSS)
    traced = solve_branch(joint, 5.0, ModalSynthesis(), damping=LOSS)
    assert found.peak_amplitude == pytest.approx(traced.peak_amplitude, rel=1e-8)


@dataclass(frozen=True, kw_only=True)
class Twice(Method):
    """Linear modes whose amplitudes are twice too large."""

    @property
    def name(self):
        return "twice"

    def solve(self, problem, force, start=None):
        branch = LinearModes().solve(problem, force, start)
        doubled = {
            "amplitude": 2 * branch.amplitude,
            "modal_coordinate": 2 * branch.modal_coordinate,
        }
        return replace(branch, **doubled)


def test_another_method_is_one_class():
    joint, force = make_joint(), 20.0
    linear = solve_response(joint, [force], damping=LOSS)
    response = solve_response(joint, [force], Twice(), damping=LOSS)
    assert response["peak_amplitude"].item() == 2 * linear["peak_amplitude"].item()
    # its error is estimated, and the fallback replaces it
    assert response["wrong"].item() == 1
    replaced = solve_response(joint, [force], Twice(has_fallback=True), damping=LOSS)
    assert replaced["fell_back"].item() == 1
    assert replaced["peak_amplitude"].item() == linear["peak_amplitude"].item()


def test_solve_response_has_six_parameters():
    assert len(inspect.signature(solve_response).parameters) == 6
