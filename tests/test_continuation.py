import numpy as np
import pytest

from boltjoint.continuation import StepControl, newton, trace


class Curve:
    """Equations of one unknown given by functions, that never change their meaning."""

    residual_scale = 1.0
    basis = None
    looks_ahead = repeats_steps = False

    def __init__(self, residual, by_x, by_p):
        self._residual, self._by_x, self._by_p = residual, by_x, by_p

    def evaluate(self, x, p):
        return np.array([self._residual(x[0], p)]), lambda: np.array([[self._by_x(x[0], p)]])

    def parameter_derivative(self, x, p):
        return np.array([self._by_p(x[0], p)])

    def renew(self, x, p, along, ahead):
        return None

    def to_fixed(self, x):
        return x


# p = x^3 - 3 x folds at x = -1 (p = 2) and x = 1 (p = -2)
FOLDED = Curve(lambda x, p: x**3 - 3 * x - p, lambda x, p: 3 * x**2 - 3, lambda x, p: -1.0)
NO_WAY_ON = Curve(lambda x, p: x**2 + p - 1, lambda x, p: 2 * x, lambda x, p: 1.0)


class Turning(Curve):
    """The folded curve in two unknowns whose axes turn after every solution."""

    def __init__(self):
        self.angle = 0.0

    def _axes(self):
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]])

    def evaluate(self, x, p):
        a, b = self._axes() @ x
        jacobian = np.array([[3 * a**2 - 3, 0.0], [-1.0, 1.0]])
        return np.array([a**3 - 3 * a - p, b - a - 1]), lambda: jacobian @ self._axes()

    def parameter_derivative(self, x, p):
        return np.array([-1.0, 0.0])

    def renew(self, x, p, along, ahead):
        fixed = self._axes() @ x, self._axes() @ along
        self.angle += 0.3
        return self._axes().T @ fixed[0], self._axes().T @ fixed[1]

    def to_fixed(self, x):
        return self._axes() @ x


class Counting(Curve):
    """The folded curve, that counts how often its derivative is formed."""

    formed = 0

    def evaluate(self, x, p):
        residual, form = super().evaluate(x, p)

        def counted():
            self.formed += 1
            return form()

        return residual, counted


def test_derivatives_are_formed_where_corrections_need_them():
    curve = Counting(FOLDED._residual, FOLDED._by_x, FOLDED._by_p)
    solution, jacobian = newton(curve, np.array([2.3]), 2.0, StepControl())
    assert solution.converged
    assert curve.formed == solution.iterations > 1
    # that of the last correction, which led from less than a thousandth away
    assert jacobian[0, 0] == pytest.approx(3 * 2.0**2 - 3, rel=1e-3)
    assert jacobian[0, 0] != 3 * solution.x[0] ** 2 - 3
    curve.formed = 0
    path = trace(curve, np.array([-2.0]), (-3.0, 3.0), StepControl(), scale=1.0)
    assert path.complete
    tried_in_vain = curve.formed - sum(max(s.iterations, 1) for s in path.solutions)
    assert tried_in_vain < len(path.solutions) / 2


def test_newton_converges_quadratically_to_a_root():
    solution, jacobian = newton(FOLDED, np.array([3.0]), 2.0, StepControl(tolerance=1e-12))
    assert solution.converged
    assert solution.iterations <= 6
    assert solution.x[0] == pytest.approx(2.0)
    assert jacobian[0, 0] == pytest.approx(9.0)


def test_newton_without_a_root_says_so():
    solution, _ = newton(NO_WAY_ON, np.array([0.5]), 3.0, StepControl())
    assert not solution.converged


def test_no_residual_is_asked_for_below_the_rounding_of_its_terms():
    # forces ten orders above what excites, as at a sharp resonance
    stiff = Curve(lambda x, p: 1e10 * (x**2 - p), lambda x, p: 2e10 * x, lambda x, p: -1e10)
    path = trace(stiff, np.array([1.4]), (2.0, 3.0), StepControl(tolerance=1e-9), scale=1.0)
    assert path.complete
    for solution in path.solutions:
        assert solution.x[0] == pytest.approx(np.sqrt(solution.p), rel=1e-12)


@pytest.mark.parametrize("equations", [FOLDED, Turning()])
def test_path_passes_both_turning_points(equations):
    start = np.array([-2.5]) if equations is FOLDED else np.array([-2.5, -1.5])
    control = StepControl(largest_step=0.05)
    path = trace(equations, start, (-8.0, 8.0), control, scale=4.0)
    assert path.complete
    assert path.reason == ""
    x = np.array([solution.x[0] for solution in path.solutions])
    p = np.array([solution.p for solution in path.solutions])
    np.testing.assert_allclose(x**3 - 3 * x, p, atol=1e-8)
    assert np.all(np.diff(x) > 0)  # never turns back on itself
    assert p[0] == -8.0
    assert p[-1] == 8.0
    assert np.any(np.diff(p) < 0)  # it did go around the folds


def test_path_runs_backwards_too():
    path = trace(FOLDED, np.array([2.5]), (8.0, -8.0), StepControl(), scale=4.0)
    assert path.complete
    assert path.solutions[-1].x[0] < -2


def test_events_are_located_at_the_fold():
    def rises(x, dx):
        return dx[0] * (3 * x[0] ** 2 - 3)  # dp along the path

    path = trace(FOLDED, np.array([-2.5]), (-8.0, 8.0), StepControl(), scale=4.0, event=rises)
    (located,) = [solution for solution in path.solutions if solution.located]
    # located within 1e-6 of a step; p is stationary there, x is not
    assert located.p == pytest.approx(2.0, abs=1e-8)
    assert located.x[0] == pytest.approx(-1.0, abs=1e-5)


def test_a_path_without_a_start_is_told_not_raised():
    path = trace(NO_WAY_ON, np.array([1.0]), (2.0, 3.0), StepControl(), scale=1.0)
    assert not path.complete
    assert "start of the window" in path.reason
    assert [solution.converged for solution in path.solutions] == [False]


def test_a_path_that_returns_is_told():
    path = trace(NO_WAY_ON, np.array([1.4]), (-1.0, 3.0), StepControl(), scale=1.0)
    assert not path.complete
    assert path.reason == "the path returned to the start of the window"
    assert all(solution.converged for solution in path.solutions)


def test_a_path_that_ends_is_told():
    # x = sqrt(1 - p) with a residual that is undefined beyond p = 1
    ends = Curve(
        lambda x, p: x - np.sqrt(1 - p) if p < 1 else np.nan,
        lambda x, p: 1.0,
        lambda x, p: 0.5 / np.sqrt(1 - p) if p < 1 else np.nan,
    )
    path = trace(ends, np.array([1.0]), (0.0, 2.0), StepControl(), scale=1.0)
    assert not path.complete
    assert path.reason == "no solution found near the last one"


def test_a_path_may_not_grow_without_end():
    path = trace(FOLDED, np.array([-2.5]), (-8.0, 8.0), StepControl(most_solutions=7), scale=4.0)
    assert len(path.solutions) == 7
    assert path.reason == "the path has more solutions than allowed"


class Jumping(Curve):
    """x = 1 + p / 100 until a renewal beyond p = 1 lifts the whole curve to where it cannot be."""

    basis = 0.0

    def evaluate(self, x, p):
        return np.array([x[0] - 1 - p / 100 - self.basis]), lambda: np.array([[1.0]])

    def parameter_derivative(self, x, p):
        return np.array([-0.01])

    def renew(self, x, p, along, ahead):
        if p > 1:
            self.basis = 0.5
            return x, along
        return None


def test_a_path_that_would_jump_ends():
    path = trace(Jumping(None, None, None), np.ones(1), (0.0, 2.0), StepControl(), scale=1.0)
    assert not path.complete
    assert path.reason == "the path would jump or turn back"
    x = np.array([solution.x[0] for solution in path.solutions])
    assert np.all(np.abs(np.diff(x)) < 0.01)


class Swinging(Curve):
    """x = 1 + p / 100, turned round by the first renewal beyond p = 1."""

    def renew(self, x, p, along, ahead):
        if p > 1 and self.basis is None:
            self.basis = "turned"
            return x, -along
        return None


def test_a_path_that_would_turn_back_ends():
    # steeper in x than in p, so that the direction of x decides which way leads on
    line = Swinging(lambda x, p: x - 1 - p, lambda x, p: 1.0, lambda x, p: -1.0)
    path = trace(line, np.ones(1), (0.0, 2.0), StepControl(), scale=100.0)
    assert not path.complete
    assert path.reason == "the path would jump or turn back"
    p = np.array([solution.p for solution in path.solutions])
    farthest = np.maximum.accumulate(p)
    assert farthest[-1] > 1
    # it may waver by an arc of 0.02, here a change of x by that share
    assert np.all(farthest - p < 0.02 * (1 + farthest))


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
    path = trace(curve, np.array([0.5]), window, control, scale=scale)
    assert path.complete, path.reason
    x = np.array([solution.x[0] for solution in path.solutions])
    p = np.array([solution.p for solution in path.solutions])
    np.testing.assert_allclose(p_of(x), p, atol=1e-8)
    assert np.all(np.diff(x) > 0)  # never turns back on itself
    ways = np.column_stack([np.diff(x) / x[:-1], np.diff(p) / scale])
    steps = np.linalg.norm(ways, axis=1)
    # a longer one would turn by more than a right angle
    turned = np.einsum("ij,ij->i", ways[1:], ways[:-1]) < 0
    assert not np.any(turned & (steps[1:] > 1e-3))
    at_a_turn = np.minimum(abs(x[1:] - 2), abs(x[1:] - 3)) < 0.3
    assert steps[at_a_turn].min() < largest / 10
    # elsewhere only the first and the last step are shorter, but for the two after each turn in
    # which the length doubles back
    assert np.sum(steps[~at_a_turn] < 0.9 * largest) <= 2 + 2


class Expecting(Curve):
    """x = f(p), a bell with its top at p = 0.1, as seen from where the path is expected to be.

    Equations in renewed terms err by a share of how far f is from what was expected, a share that
    varies with p, so that the top is where it should be only in terms renewed there. Where the
    share is negative, what is found answers what is expected with the opposite sign.
    """

    def __init__(self, share, looks_ahead):
        self._share, self.basis = share, 1.0
        self.looks_ahead = self.repeats_steps = looks_ahead

    @staticmethod
    def f(p):
        return 1 + 2 * np.exp(-(((p - 0.1) / 0.3) ** 2))

    def _seen(self, p):
        return self.f(p) + self._share * (1 + p / 2) * (self.basis - self.f(p))

    def evaluate(self, x, p):
        return x - self._seen(p), lambda: np.eye(1)

    def parameter_derivative(self, x, p):
        slope = -2 * (p - 0.1) / 0.3**2 * (self.f(p) - 1)
        by_share = self._share / 2 * (self.basis - self.f(p))
        return np.array([-slope * (1 - self._share * (1 + p / 2)) - by_share])

    def renew(self, x, p, along, ahead):
        self.basis = ahead[0][0] if self.looks_ahead else x[0]
        return np.array([self._seen(p)]), along


def slope_of(x, dx):
    return float(dx[0])


def along_the_bell(share, step, looks_ahead=True):
    control = StepControl(largest_step=step, first_step=step)
    equations = Expecting(share, looks_ahead)
    path = trace(equations, np.ones(1), (-1.0, 1.0), control, scale=1.0, event=slope_of)
    assert path.complete
    return path.solutions


@pytest.mark.parametrize("share", [-1.0, -0.6, -0.2])
@pytest.mark.parametrize("step", [0.16, 0.04])
def test_where_renewals_look_ahead_an_event_is_located_in_terms_of_itself(share, step):
    (top,) = [solution for solution in along_the_bell(share, step) if solution.located]
    # looked at 8 times, each halving what is missing or better, or until 1e-6 of x is
    assert top.p == pytest.approx(0.1, abs=1e-6)
    assert top.x[0] == pytest.approx(3.0, rel=3e-5)


@pytest.mark.parametrize("share", [-1.0, -0.6, -0.2])
@pytest.mark.parametrize("step", [0.16, 0.04])
def test_where_renewals_look_ahead_a_step_leads_to_where_it_was_expected(share, step):
    begin, *others = along_the_bell(share, step)
    # twice the 3e-3 within which what is expected and what is found agree
    for solution in others:
        assert solution.x[0] == pytest.approx(Expecting.f(solution.p), rel=6e-3)
    # a start is renewed until nothing changes by more than 1e-6
    assert begin.x[0] == pytest.approx(Expecting.f(-1.0), rel=1e-5)


def test_renewals_that_look_ahead_lag_less(step=0.08):
    ahead, after = (
        max(
            abs(solution.x[0] / Expecting.f(solution.p) - 1)
            for solution in along_the_bell(-0.6, step, looks_ahead)
        )
        for looks_ahead in (True, False)
    )
    assert ahead < after / 5


@pytest.mark.parametrize("wrong", [{"tolerance": 0.0}, {"most_iterations": 0}])
def test_impossible_step_control_is_refused(wrong):
    with pytest.raises(ValueError, match="must be positive"):
        StepControl(**wrong)


@pytest.mark.parametrize("largest", [0.03, 0.005])
def test_steps_are_no_longer_than_allowed(largest):
    control = StepControl(largest_step=largest)
    path = trace(FOLDED, np.array([-2.5]), (-8.0, 1.5), control, scale=4.0)
    x = np.array([solution.x[0] for solution in path.solutions])
    p = np.array([solution.p for solution in path.solutions])
    steps = np.hypot(np.diff(x) / x[:-1], np.diff(p) / 4.0)
    # a solution counts as on the sphere when it is within 1e-3 of its radius
    assert steps.max() <= largest * 1.001
