"""Arc-length continuation of known curves past turning points."""

from dataclasses import replace

import numpy as np
import pytest
from curves import FOLDED, PARABOLA, Curve

from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.step_control import StepControl


def test_branch_passes_both_turning_points():
    control = StepControl(largest_step=0.05)
    branch = trace(FOLDED, np.array([-2.5]), (-8.0, 8.0), control, scale=4.0)
    assert branch.complete
    assert branch.reason == ""
    x = np.array([solution.x[0] for solution in branch.solutions])
    p = np.array([solution.p for solution in branch.solutions])
    np.testing.assert_allclose(x**3 - 3 * x, p, atol=1e-8)
    assert np.all(np.diff(x) > 0)  # never turns back on itself
    assert p[0] == -8.0
    assert p[-1] == 8.0
    assert np.any(np.diff(p) < 0)  # it did go around the folds


def test_branch_is_followed_to_lower_parameters_too():
    branch = trace(FOLDED, np.array([2.5]), (8.0, -8.0), StepControl(), scale=4.0)
    assert branch.complete
    assert branch.solutions[-1].x[0] < -2


def test_no_step_deviates_from_the_tangent_by_more_than_allowed():
    solutions, control = {}, StepControl(first_step=0.4, largest_step=0.4)
    for limit in (0.5, 0.99):
        control = replace(control, smallest_cosine=limit)
        branch = trace(FOLDED, np.array([-2.5]), (-8.0, 8.0), control, scale=4.0)
        assert branch.complete
        solutions[limit] = branch.solutions[:-1]
    smallest = {key: min(map(_cosine, found, found[1:])) for key, found in solutions.items()}
    assert smallest[0.5] < 0.98
    assert smallest[0.99] >= 0.99 - 1e-3  # the radius holds within 1e-3
    with pytest.raises(ValueError, match="smallest_cosine"):
        StepControl(smallest_cosine=1.0)


def _cosine(before, after):
    """Of the angle between a step along the folded curve and the tangent at its start."""
    x, weights = before.x[0], np.array([1 / abs(before.x[0]), 1 / 4.0])
    step = weights * [after.x[0] - x, after.p - before.p]
    tangent = weights * [1.0, 3 * x**2 - 3]
    return abs(step @ tangent) / np.linalg.norm(step) / np.linalg.norm(tangent)


@pytest.mark.parametrize("begin", [-5.0, 0.0, 6.0])
def test_branch_may_start_within_the_window(begin):
    start = np.roots([1.0, 0.0, -3.0, -begin])
    lowest = min(start[abs(start.imag) < 1e-9].real)
    branch = trace(FOLDED, np.array([lowest]), (-8.0, 8.0), StepControl(), scale=4.0, begin=begin)
    assert branch.complete
    assert branch.solutions[0].p == begin
    # from the lower sheet around both folds, past where it started
    p = np.array([solution.p for solution in branch.solutions])
    assert (p.min() < begin) == (-2 < begin < 2)


def test_step_lengths_follow_a_scale_that_varies():
    control = StepControl(largest_step=0.05)
    line = Curve(lambda x, p: x - 1, lambda x, p: 1.0, lambda x, p: 0.0)
    branch = trace(line, np.ones(1), (1.0, 100.0), control, scale=lambda p: min(5.0, 0.1 * p))
    assert branch.complete
    p = np.array([solution.p for solution in branch.solutions[1:-1]])
    steps = np.diff(p) / np.minimum(5.0, 0.1 * p[:-1])
    # within 1e-3 of the radius; the first ones are growing
    np.testing.assert_allclose(steps[5:], 0.05, rtol=1e-3)


def test_a_failed_start_is_a_reason_not_an_exception():
    branch = trace(PARABOLA, np.array([1.0]), (2.0, 3.0), StepControl(), scale=1.0)
    assert not branch.complete
    assert "start of the window" in branch.reason
    assert [solution.converged for solution in branch.solutions] == [False]


def test_a_branch_that_returns_has_a_reason():
    branch = trace(PARABOLA, np.array([1.4]), (-1.0, 3.0), StepControl(), scale=1.0)
    assert not branch.complete
    assert branch.reason == "the branch returned to the start of the window"
    assert all(solution.converged for solution in branch.solutions)


def test_a_branch_that_ends_has_a_reason():
    # x = sqrt(1 - p) with a residual that is undefined beyond p = 1
    ends = Curve(
        lambda x, p: x - np.sqrt(1 - p) if p < 1 else np.nan,
        lambda x, p: 1.0,
        lambda x, p: 0.5 / np.sqrt(1 - p) if p < 1 else np.nan,
    )
    branch = trace(ends, np.array([1.0]), (0.0, 2.0), StepControl(), scale=1.0)
    assert not branch.complete
    assert branch.reason == "no solution found near the last one"


def test_the_number_of_solutions_is_limited():
    branch = trace(
        FOLDED, np.array([-2.5]), (-8.0, 8.0), StepControl(maximum_solutions=7), scale=4.0
    )
    assert len(branch.solutions) == 7
    assert branch.reason == "the branch has more solutions than allowed"


def hairpin(sharpness):
    """p(x) rises to a turn at x = 2, falls to one at x = 3 and rises again, straight elsewhere."""

    def p_of(x):
        return x - np.hypot(x - 2, sharpness) + np.hypot(x - 3, sharpness)

    def slope(x):
        return 1 - (x - 2) / np.hypot(x - 2, sharpness) + (x - 3) / np.hypot(x - 3, sharpness)

    return Curve(lambda x, p: p_of(x) - p, lambda x, p: slope(x), lambda x, p: -1.0), p_of


@pytest.mark.parametrize(("sharpness", "scale"), [(0.03, 0.2), (0.01, 0.3), (0.01, 0.5)])
def test_sharp_turns_are_passed_in_short_steps(sharpness, scale):
    curve, p_of = hairpin(sharpness)
    window, largest = (p_of(0.5), p_of(5.0)), 0.05
    control = StepControl(largest_step=largest)
    branch = trace(curve, np.array([0.5]), window, control, scale=scale)
    assert branch.complete, branch.reason
    x = np.array([solution.x[0] for solution in branch.solutions])
    p = np.array([solution.p for solution in branch.solutions])
    np.testing.assert_allclose(p_of(x), p, atol=1e-8)
    assert np.all(np.diff(x) > 0)  # never turns back on itself
    secants = np.column_stack([np.diff(x) / x[:-1], np.diff(p) / scale])
    steps = np.linalg.norm(secants, axis=1)
    # a longer one would turn by more than a right angle
    turned = np.einsum("ij,ij->i", secants[1:], secants[:-1]) < 0
    assert not np.any(turned & (steps[1:] > 1e-3))
    at_a_turn = np.minimum(abs(x[1:] - 2), abs(x[1:] - 3)) < 0.3
    assert steps[at_a_turn].min() < largest / 10
    # elsewhere only the first and the last step are shorter, but for the two after each turn in
    # which the length doubles back
    assert np.sum(steps[~at_a_turn] < 0.9 * largest) <= 2 + 2


@pytest.mark.parametrize(
    "wrong",
    [
        {"tolerance": 0.0},
        {"maximum_iterations": 0},
        {"smallest_step": 0.02},
        {"smallest_step": 0.01, "largest_step": 0.01},
    ],
)
def test_impossible_step_control_is_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        StepControl(**wrong)


@pytest.mark.parametrize("largest", [0.03, 0.005])
def test_steps_are_no_longer_than_allowed(largest):
    control = StepControl(largest_step=largest)
    branch = trace(FOLDED, np.array([-2.5]), (-8.0, 1.5), control, scale=4.0)
    x = np.array([solution.x[0] for solution in branch.solutions])
    p = np.array([solution.p for solution in branch.solutions])
    steps = np.hypot(np.diff(x) / x[:-1], np.diff(p) / 4.0)
    # a solution counts as on the sphere when it is within 1e-3 of its radius
    assert steps.max() <= largest * 1.001
