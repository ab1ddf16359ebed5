"""Maxima of an observed quantity along a branch, whatever its slope says."""

import numpy as np
import pytest
from curves import Curve, First

from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.step_control import StepControl


def graph(f, slope):
    """x = f(p)."""
    return Curve(lambda x, p: x - f(p), lambda x, p: 1.0, lambda x, p: -slope(p))


WAVES = graph(lambda p: 2 + np.sin(p), np.cos)


class Wrong(First):
    """The first unknown with a wrong slope."""

    def __init__(self, slope):
        self._slope = slope

    def slope(self, x, dx):
        return self._slope(dx)


def located(branch):
    return [(solution.p, solution.x[0]) for solution in branch.solutions if solution.located]


@pytest.mark.parametrize("towards", [1, -1])
def test_every_maximum_is_located_and_no_minimum(towards):
    window = (0.0, 4 * np.pi)[::towards]
    branch = trace(WAVES, np.array([2.0]), window, StepControl(), scale=5.0, maximise=First())
    assert branch.complete
    expected = [(np.pi / 2, 3.0), (5 * np.pi / 2, 3.0)][::towards]
    # located within 1e-6 of a step
    np.testing.assert_allclose(located(branch), expected, atol=1e-6)
    p = [solution.p for solution in branch.solutions]
    assert p == sorted(p, reverse=towards < 0)


@pytest.mark.parametrize("slope", [lambda dx: 1.0, lambda dx: -1.0, lambda dx: -dx[0]])
def test_a_sample_above_its_neighbours_is_refined_whatever_its_slope(slope):
    observe = Wrong(slope)
    branch = trace(WAVES, np.array([2.0]), (0.0, 4.0), StepControl(), scale=5.0, maximise=observe)
    value = np.array([solution.x[0] for solution in branch.solutions])
    p, highest = max(located(branch), key=lambda each: each[1])
    assert highest == value.max()
    # by values alone a flat maximum is known to the square root of their rounding
    assert highest == pytest.approx(3.0, rel=1e-12)
    assert p == pytest.approx(np.pi / 2, abs=1e-5)


def test_a_maximum_between_the_last_two_solutions_counts():
    end = np.pi / 2 + 1e-3
    branch = trace(WAVES, np.array([2.0]), (0.0, end), StepControl(), scale=5.0, maximise=First())
    assert located(branch) == [pytest.approx((np.pi / 2, 3.0), abs=1e-6)]


def test_the_highest_solution_at_an_end_is_no_maximum():
    branch = trace(WAVES, np.array([2.0]), (0.0, 1.5), StepControl(), scale=5.0, maximise=First())
    assert branch.complete
    assert not located(branch)


def test_a_plateau_is_no_maximum():
    flat = graph(lambda p: 1.0, lambda p: 0.0)
    branch = trace(flat, np.array([1.0]), (0.0, 1.0), StepControl(), scale=1.0, maximise=First())
    assert branch.complete
    assert not located(branch)
