"""Shooting against closed forms, and motion that returns to stable orbits and leaves others."""

import numpy as np
import pytest
from folding_joint import DAMPING, WINDOW, make_folding_joint
from periodic_orbits import find_orbit
from small_joint import make_joint

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.folds import find_folds
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.verification.time_integration import Integration

FORCE = 5.0


def period(joint, components, x, samples=2000):
    """A period of the modal coordinates in one harmonic."""
    phase = 2 * np.pi * np.arange(samples) / samples
    waves = {"bias": np.ones(samples), "sin": np.sin(phase), "cos": np.cos(phase)}
    parts = zip(components, x.reshape(len(components), -1), strict=True)
    return sum(np.outer(waves[name], amplitude) for name, amplitude in parts)


def of_branch(solution):
    """A solution of the folded branch: joint, frequency and a period of motion."""
    joint = make_folding_joint()
    branch = solve_branch(joint, FORCE, damping=DAMPING, resonance=Resonance(1, WINDOW))
    first, last = find_folds(branch.frequency).at
    i = {"unstable": (first + last) // 2, "stable": last + 20}[solution]
    return (
        joint,
        branch.frequency[i],
        period(joint, joint.law.components, branch.modal_coordinate[i]),
    )


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_what_sticks_has_the_multipliers_of_a_linear_structure(law):
    joint, frequency, force = make_joint(4, law=law), 130.0, 1e-4
    balance = HarmonicBalance(joint, DAMPING, force)
    x = balance.stuck_solution(2 * np.pi * frequency)
    # from the wrong amplitude
    start = 1.2 * period(joint, balance.components, x)
    found = find_orbit(joint, frequency, force, DAMPING, start, steps=4000)
    w = 2 * np.pi * joint.natural_frequency
    stiffness = np.diag(w**2) + joint.stuck_stiffness()
    damping = np.diag(2 * DAMPING.damping_ratios[0] * w)
    state = np.block([[np.zeros((3, 3)), np.eye(3)], [-stiffness, -damping]])
    exact = np.exp(np.linalg.eigvals(state) / frequency)
    assert found.converged
    # sliders that rest have none; what the two steps remember decays at once
    largest = found.multipliers[:6]
    assert abs(found.multipliers[6:]).max() < 1e-6
    # to the square of the step; the fastest mode has several periods in one
    distance = abs(largest[:, None] - exact)
    assert distance.min(axis=1).max() < 0.01
    assert distance.min(axis=0).max() < 0.01
    slowest = np.sort(distance.min(axis=1))[:2]
    assert slowest.max() < 1e-4
    expected = period(joint, balance.components, x, samples=4000)
    np.testing.assert_allclose(found.motion, expected, atol=1e-3 * abs(expected).max())


def test_orbits_do_not_depend_on_the_step():
    joint, frequency, start = of_branch("unstable")
    coarse, fine = (
        find_orbit(joint, frequency, FORCE, DAMPING, start, steps=steps) for steps in (1000, 4000)
    )
    assert coarse.converged
    assert fine.converged
    assert abs(fine.multipliers[0]) > 1.1
    assert abs(coarse.multipliers[0]) == pytest.approx(abs(fine.multipliers[0]), abs=5e-3)
    np.testing.assert_allclose(coarse.motion, fine.motion[::4], atol=1e-3 * abs(fine.motion).max())


@pytest.mark.parametrize("solution", ["unstable", "stable"])
def test_motion_leaves_unstable_orbits_and_returns_to_stable_ones(solution):
    joint, frequency, start = of_branch(solution)
    orbit = find_orbit(joint, frequency, FORCE, DAMPING, start)
    assert orbit.converged
    size = abs(orbit.motion).max()
    ends = []
    for factor in (0.999, 1.001):
        integration = Integration.of(joint, frequency, FORCE, DAMPING, len(orbit.motion))
        integration.follow(factor * orbit.motion)
        for _ in range(100):
            integration.advance()
        ends.append(integration.history.copy())
    distance = [abs(end - orbit.motion).max() / size for end in ends]
    if solution == "stable":
        assert abs(orbit.multipliers[0]) < 1
        assert max(distance) < 1e-5
    else:
        # to the two stable orbits at this frequency, below and above
        assert abs(orbit.multipliers[0]) > 1
        assert min(distance) > 0.1
        lower, higher = sorted(abs(end).max() / size for end in ends)
        assert lower < 0.9
        assert higher > 1.1


def test_a_search_that_does_not_converge_says_so():
    joint, frequency, start = of_branch("unstable")
    found = find_orbit(joint, frequency, FORCE, DAMPING, start, steps=200, maximum_iterations=1)
    assert not found.converged
    assert found.change > 1e-10
