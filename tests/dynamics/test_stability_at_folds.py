"""Stability marks at folds of random joints, beside motions in time found by shooting."""

import numpy as np
import pytest
from periodic_orbits import find_orbit
from stability_at_folds import compare_marks, folding_joint

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.folds import FoldedBranch, find_folds
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.stability import largest_multiplier

SEED = 88431


@pytest.mark.parametrize("index", [17, 20])
def test_marks_are_those_of_the_motion_in_time(index):
    rows = compare_marks(SEED, index)
    assert rows
    for row in rows:
        assert (row["in_time"] < 1) == (row["stable"] == 1)
        assert row["harmonics"] == 15
        # the motion is the same
        assert row["moved"] < 0.01
        assert row["multiplier"] == pytest.approx(row["in_time"], abs=0.01)


def test_motions_of_many_unknowns_are_those_with_all_jacobians(monkeypatch):
    joint, force, damping = folding_joint(np.random.default_rng([20271, 15]))
    branch = solve_branch(joint, force, damping=damping)
    folds = find_folds(branch.frequency)
    balance = HarmonicBalance(joint, damping, force)
    places = range(folds.at[0], folds.at[-1], 8)
    monkeypatch.setattr("boltjoint.dynamics.response.folds._MOST_UNKNOWNS", 0)
    found = []
    for large in (1000, 0):
        monkeypatch.setattr("boltjoint.dynamics.response.folds.LARGE", large)
        at = FoldedBranch(balance, branch.frequency, branch.modal_coordinate, folds, 15, 1024)
        found.append([at.motion_of(place) for place in places])
    both = [pair for pair in zip(*found, strict=True) if all(one is not None for one in pair)]
    assert len(both) == sum(one is not None for one in found[0]) > 0
    for dense, krylov in both:
        np.testing.assert_allclose(krylov, dense, rtol=0, atol=1e-5 * np.abs(dense).max())


def test_a_motion_whose_period_doubles_is_unstable(monkeypatch):
    joint, force, damping = folding_joint(np.random.default_rng([20271, 15]))
    branch = solve_branch(joint, force, damping=damping)
    solutions = branch.frequency, branch.modal_coordinate
    folds = find_folds(branch.frequency)
    # motions from the solutions alone
    monkeypatch.setattr("boltjoint.dynamics.response.folds._MOST_UNKNOWNS", 0)
    balance = HarmonicBalance(joint, damping, force)
    finer = FoldedBranch(balance, *solutions, folds, 15, 1024)
    components = finer.balance.components
    found = 0
    for place in range(folds.at[0], folds.at[-1], 4):
        motion = finer.motion_of(place)
        if motion is None:
            continue
        frequency = branch.frequency[place]
        start = PeriodicMotion(components, motion.reshape(len(components), -1)).in_time(2000)
        exact = find_orbit(joint, frequency, force, damping, start)
        if not exact.converged or exact.multipliers[0].real > 0:
            continue
        found += 1
        assert exact.multipliers[0].real < -2
        largest = largest_multiplier(finer.balance, motion, 2 * np.pi * frequency)
        # the delay of sliders is linear in the exponent
        assert largest == pytest.approx(abs(exact.multipliers[0]), rel=0.05)
    assert found
