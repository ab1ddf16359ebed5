"""Branches in a basis that changes along them, in fixed coordinates."""

import numpy as np
import pytest
from curves import FOLDED, Curve, First

from boltjoint.solvers import arc_length
from boltjoint.solvers.lagged_basis import BasisPrediction, LaggedEquations
from boltjoint.solvers.lagged_continuation import trace
from boltjoint.solvers.step_control import StepControl


class Lagged(LaggedEquations):
    """Equations of one unknown whose basis is a number; it is the fixed coordinate itself."""

    residual_scale = 1.0
    predictive = implicit = False
    full_equations = None
    basis = 0.0

    def update(self, q, p):
        pass

    def from_fixed(self, q):
        return q

    def to_fixed(self, x):
        return x

    change_from_fixed, change_to_fixed = from_fixed, to_fixed


class Turning(Lagged):
    """The folded curve in two unknowns whose axes turn after every solution."""

    def _axes(self):
        c, s = np.cos(self.basis), np.sin(self.basis)
        return np.array([[c, -s], [s, c]])

    def evaluate(self, x, p):
        a, b = self._axes() @ x
        jacobian = np.array([[3 * a**2 - 3, 0.0], [-1.0, 1.0]])
        return np.array([a**3 - 3 * a - p, b - a - 1]), lambda: jacobian @ self._axes()

    def parameter_derivative(self, x, p):
        return np.array([-1.0, 0.0])

    def update(self, q, p):
        self.basis += 0.3

    def from_fixed(self, q):
        return self._axes().T @ q

    def to_fixed(self, x):
        return self._axes() @ x

    change_from_fixed, change_to_fixed = from_fixed, to_fixed


def test_branch_passes_turning_points_while_axes_turn():
    control = StepControl(largest_step=0.05)
    branch = trace(Turning(), np.array([-2.5, -1.5]), (-8.0, 8.0), control, scale=4.0)
    assert branch.complete
    x, y = np.array([solution.x for solution in branch.solutions]).T
    p = np.array([solution.p for solution in branch.solutions])
    np.testing.assert_allclose(x**3 - 3 * x, p, atol=1e-8)
    np.testing.assert_allclose(y, x + 1, atol=1e-8)
    assert np.all(np.diff(x) > 0)  # never turns back on itself
    assert np.any(np.diff(p) < 0)  # it did go around the folds


class Jumping(Lagged):
    """x = 1 + p / 100 until an update beyond p = 1 moves the curve away."""

    def evaluate(self, x, p):
        return np.array([x[0] - 1 - p / 100 - self.basis]), lambda: np.array([[1.0]])

    def parameter_derivative(self, x, p):
        return np.array([-0.01])

    def update(self, q, p):
        self.basis = 0.5 * (p > 1)


def test_a_branch_that_would_jump_ends():
    branch = trace(Jumping(), np.ones(1), (0.0, 2.0), StepControl(), scale=1.0)
    assert not branch.complete
    assert branch.reason == "the branch would jump or turn back"
    x = np.array([solution.x[0] for solution in branch.solutions])
    assert np.all(np.abs(np.diff(x)) < 0.01)


class Reversing(Lagged):
    """x = 1 + p, whose direction the first update beyond p = 1 reverses."""

    turned = False

    def evaluate(self, x, p):
        return np.array([x[0] - 1 - p]), lambda: np.array([[1.0]])

    def parameter_derivative(self, x, p):
        return np.array([-1.0])

    def update(self, q, p):
        self.basis = float(p > 1 and not self.turned)
        self.turned = self.turned or p > 1

    def change_from_fixed(self, dq):
        return dq * (1 - 2 * self.basis)


def test_a_branch_that_would_turn_back_ends():
    # steeper in x than in p, so that the direction of x decides the sense of the tangent
    branch = trace(Reversing(), np.ones(1), (0.0, 2.0), StepControl(), scale=100.0)
    assert not branch.complete
    assert branch.reason == "the branch would jump or turn back"
    p = np.array([solution.p for solution in branch.solutions])
    farthest = np.maximum.accumulate(p)
    assert farthest[-1] > 1
    # it may fall back by an arc of 0.02, here a change of x by that share
    assert np.all(farthest - p < 0.02 * (1 + farthest))


class Bell(Curve):
    """x = f(p), a bell with its top at p = 0.1."""

    def __init__(self):
        super().__init__(lambda x, p: x - self.f(p), lambda x, p: 1.0, lambda x, p: -self.slope(p))

    @staticmethod
    def f(p):
        return 1 + 2 * np.exp(-(((p - 0.1) / 0.3) ** 2))

    @classmethod
    def slope(cls, p):
        return -2 * (p - 0.1) / 0.3**2 * (cls.f(p) - 1)


class Expecting(Lagged):
    """The bell in a basis that is that of the predicted point.

    The error in an updated basis is a share of the distance of f from the update point, a share
    that varies with p, so that the top is where it should be only in the basis of itself. Where the
    share is negative, what is found answers what is expected with the opposite sign.
    """

    basis = 1.0

    def __init__(self, share, predictive):
        self._share = share
        self.predictive = self.implicit = predictive

    def _seen(self, p):
        return Bell.f(p) + self._share * (1 + p / 2) * (self.basis - Bell.f(p))

    def evaluate(self, x, p):
        return x - self._seen(p), lambda: np.eye(1)

    def parameter_derivative(self, x, p):
        by_share = self._share / 2 * (self.basis - Bell.f(p))
        return np.array([-Bell.slope(p) * (1 - self._share * (1 + p / 2)) - by_share])

    def update(self, q, p):
        self.basis = q[0]


def along_the_bell(equations, step):
    control = StepControl(largest_step=step, first_step=step)
    branch = trace(equations, np.ones(1), (-1.0, 1.0), control, scale=1.0, maximise=First())
    assert branch.complete
    return branch.solutions


@pytest.mark.parametrize("share", [-1.0, -0.6, -0.2])
@pytest.mark.parametrize("step", [0.16, 0.04])
def test_a_maximum_is_located_in_the_basis_of_itself(share, step):
    solutions = along_the_bell(Expecting(share, True), step)
    (top,) = [solution for solution in solutions if solution.located]
    assert top.x[0] == max(solution.x[0] for solution in solutions)
    # there is no slope to tell where a flat top is highest
    assert top.p == pytest.approx(0.1, abs=1e-4)
    assert top.x[0] == pytest.approx(3.0, rel=1e-8)


@pytest.mark.parametrize("share", [-1.0, -0.6, -0.2])
@pytest.mark.parametrize("step", [0.16, 0.04])
def test_an_implicit_basis_belongs_to_its_solution(share, step):
    begin, *others = along_the_bell(Expecting(share, True), step)
    # twice the twentieth of the step within which what is expected and what is found agree
    for solution in others:
        assert solution.x[0] == pytest.approx(Bell.f(solution.p), rel=0.1 * step)
    # a start is updated until nothing changes by more than 1e-6
    assert begin.x[0] == pytest.approx(Bell.f(-1.0), rel=1e-5)


def test_a_predicted_basis_lags_less(step=0.08):
    ahead, after = (
        max(
            abs(solution.x[0] / Bell.f(solution.p) - 1)
            for solution in along_the_bell(Expecting(-0.6, predictive), step)
        )
        for predictive in (True, False)
    )
    assert ahead < after / 5


def predicted(full, basis, start, window, scale):
    """The branch of full equations whose solutions are predicted in a basis."""
    control = StepControl(largest_step=0.05)
    prediction = BasisPrediction(basis, control, lambda _: scale)
    options = {"scale": scale, "maximise": First(), "prediction": prediction}
    return arc_length.trace(full, start, window, control, **options)


@pytest.mark.parametrize("share", [-1.0, -0.6, -0.2])
def test_solutions_predicted_in_a_basis_are_those_of_the_full_equations(share):
    branch = predicted(Bell(), Expecting(share, True), np.ones(1), (-1.0, 1.0), 1.0)
    assert branch.complete, branch.reason
    for solution in branch.solutions:
        assert solution.x[0] == pytest.approx(Bell.f(solution.p), rel=1e-8)
    (top,) = [solution for solution in branch.solutions if solution.located]
    assert top.p == pytest.approx(0.1, abs=1e-6)
    steps = [solution for solution in branch.solutions[1:-1] if not solution.located]
    assert np.mean([solution.reduced for solution in steps]) > 0.8


class Folding(Lagged):
    """The folded curve; there is no solution where x is within a window."""

    def evaluate(self, x, p):
        if -1.5 < x[0] < -0.5:
            return np.array([np.nan]), lambda: np.array([[np.nan]])
        return FOLDED.evaluate(x, p)

    def parameter_derivative(self, x, p):
        return FOLDED.parameter_derivative(x, p)


def test_where_the_basis_predicts_nothing_a_step_is_along_the_tangent():
    branch = predicted(FOLDED, Folding(), np.array([-2.5]), (-8.0, 8.0), 4.0)
    assert branch.complete, branch.reason
    x = np.array([solution.x[0] for solution in branch.solutions])
    p = np.array([solution.p for solution in branch.solutions])
    np.testing.assert_allclose(x**3 - 3 * x, p, atol=1e-8)
    assert np.all(np.diff(x) > 0)
    inside = (-1.5 < x) & (x < -0.5)
    is_predicted = np.array([solution.reduced for solution in branch.solutions])
    assert np.sum(inside) > 10 and not np.any(is_predicted[inside])
    assert np.any(is_predicted[x < -1.5]) and np.any(is_predicted[x > -0.5])
    alone = trace(Folding(), np.array([-2.5]), (-8.0, 8.0), StepControl(), scale=4.0)
    assert not alone.complete
    assert alone.solutions[-1].x[0] == pytest.approx(-1.5, abs=1e-6)
