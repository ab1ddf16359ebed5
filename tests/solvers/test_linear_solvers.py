"""Branches with many unknowns, followed with the factors of earlier Jacobians."""

from dataclasses import replace

import numpy as np
import pytest
from curves import SIZE, Combustion
from scipy.optimize import brentq
from small_joint import make_joint

from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.solvers import arc_length, linear_solvers
from boltjoint.solvers.step_control import StepControl

CONTROL = StepControl(tolerance=1e-8)
#: the closed form ``u = 2 ln(cosh(t) / cosh(t (1 - 2 s)))``, ``p = 8 (t / cosh(t))^2`` of Bratu's
#: equation folds where ``t tanh(t) = 1``: the parameter, and the solution in the middle
_T = brentq(lambda t: t * np.tanh(t) - 1, 1.0, 2.0)
FOLD, MIDDLE = 8 * (_T / np.cosh(_T)) ** 2, 2 * np.log(np.cosh(_T))


@pytest.fixture(params=["few", "all"])
def branch(request, monkeypatch):
    """Bratu's equation followed past its fold, with few Jacobians or with all, and their number."""
    monkeypatch.setattr(linear_solvers, "LARGE", SIZE if request.param == "few" else SIZE + 1)
    equations = Combustion()
    found = arc_length.trace(equations, np.zeros(SIZE), (0.5, 4.0), CONTROL, scale=1.0)
    return equations, found.solutions, request.param


def test_a_branch_is_followed_past_its_fold(branch):
    equations, solutions, which = branch
    for each in solutions:
        assert np.linalg.norm(equations.evaluate(each.x, each.p)[0]) < 1e-6
    last = max(solutions, key=lambda each: each.p)
    assert last.p == pytest.approx(FOLD, abs=2e-3)
    assert last.x.max() == pytest.approx(MIDDLE, rel=0.05)
    assert solutions[-1].x.max() > 2 * MIDDLE
    if which == "few":
        assert equations.jacobians < len(solutions) / 4
    else:
        assert equations.jacobians > len(solutions)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_responses_are_those_with_all_jacobians(law, monkeypatch):
    joint = make_joint(law=law)
    joint = replace(joint, law=AlternatingFrequencyTime(joint.law, harmonics=5, samples=128))
    found = []
    for large in (1, 10**6):
        monkeypatch.setattr(linear_solvers, "LARGE", large)
        found.append(solve_branch(joint, 20.0, damping=0.01))
    few, every = found
    assert few.complete
    assert every.complete
    amplitudes, frequencies = (
        [getattr(each, name)[each.peak] for each in found] for name in ("amplitude", "frequency")
    )
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=1e-6)
    # near its top a peak is as high to the square of that
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-5)
