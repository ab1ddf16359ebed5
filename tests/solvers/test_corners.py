"""Branches of piecewise linear equations with corners of any angle."""

import numpy as np
import pytest
from curves import First

from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.equations import Equations
from boltjoint.solvers.step_control import StepControl


class Wedge(Equations):
    """A branch of two straight lines that meet in a corner at x = 2, p = 1, in several unknowns.

    The lines enclose the angle ``inside`` around an axis of some direction in the plane of x and p;
    further unknowns follow x, p and each other linearly.
    """

    residual_scale = 1.0

    def __init__(self, inside, axis, others=0, seed=1):
        self.axis = np.array([np.cos(axis), np.sin(axis)])
        self.across = np.array([-self.axis[1], self.axis[0]])
        self.slope = np.tan(inside / 2)
        random = np.random.default_rng(seed)
        self.follow = random.normal(size=(others, 2))
        # an invertible mixture of the equations and of the unknowns
        self.rows, self.columns = (
            np.eye(1 + others) + 0.3 * random.normal(size=(1 + others, 1 + others))
            for _ in range(2)
        )

    def plane(self, x, p):
        return np.array([(self.columns @ x)[0], p])

    def evaluate(self, x, p):
        y = self.columns @ x
        z = np.array([y[0] - 2.0, p - 1.0])
        wedge = abs(self.across @ z) - self.slope * self.axis @ z
        residual = np.append(wedge, y[1:] - self.follow @ z)
        by_z = np.sign(self.across @ z) * self.across - self.slope * self.axis
        self.by_p = self.rows @ np.append(by_z[1], -self.follow[:, 1])
        by_y = np.eye(y.size)
        by_y[0, 0], by_y[1:, 0] = by_z[0], -self.follow[:, 0]
        return self.rows @ residual, lambda: self.rows @ by_y @ self.columns

    def parameter_derivative(self, x, p):
        self.evaluate(x, p)
        return self.by_p

    def start(self, p):
        """The solution at p on the line that the branch starts from."""
        direction = self.lines()[0]
        z = direction * (p - 1.0) / direction[1]
        y = np.concatenate([[2.0 + z[0]], self.follow @ z])
        return np.linalg.solve(self.columns, y)

    def lines(self):
        """Directions of the two lines from the corner, the lower one first."""
        both = [self.axis + sign * self.slope * self.across for sign in (1, -1)]
        return sorted(both, key=lambda direction: direction[1])


@pytest.mark.parametrize("others", [0, 1, 5])
@pytest.mark.parametrize("turn", [70, 85, 90, 130, 170, 179, 179.9])
def test_a_corner_of_any_angle_is_turned(turn, others):
    """Up to where the branch turns back almost onto itself."""
    inside = np.radians(180 - turn)
    # so that the branch ascends on one line to the corner and on the other from it
    wedge = Wedge(inside, axis=inside / 4, others=others)
    down, up = wedge.lines()
    assert down[1] < 0 < up[1]
    branch = trace(wedge, wedge.start(0.999), (0.999, 1.001), StepControl(), scale=1.0)
    assert branch.complete, branch.reason
    z = np.array([wedge.plane(s.x, s.p) for s in branch.solutions]) - [2.0, 1.0]
    lower = z[:, 1] < 0
    # once along each line, and never back
    assert np.all(np.diff(lower.astype(int)) <= 0)
    for line, some in ((down, z[lower]), (up, z[~lower])):
        np.testing.assert_allclose(some @ [line[1], -line[0]], 0, atol=1e-8)


@pytest.mark.parametrize("others", [0, 5])
def test_a_maximum_at_a_corner_is_located(others):
    # x rises to the corner and falls again, both steeply
    wedge = Wedge(np.radians(20), axis=np.pi + 0.05, others=others)
    observe = First()
    observe.value = lambda x: float((wedge.columns @ x)[0])
    observe.slope = lambda x, dx: float((wedge.columns @ dx)[0])
    branch = trace(
        wedge, wedge.start(0.95), (0.95, 1.05), StepControl(), scale=0.3, maximise=observe
    )
    assert branch.complete, branch.reason
    (highest,) = [s for s in branch.solutions if s.located]
    value = [observe.value(s.x) for s in branch.solutions]
    assert observe.value(highest.x) == max(value)
    assert max(value) == pytest.approx(2.0, abs=1e-7)


class Star(Equations):
    """Four lines that meet at x = 1, p = 1, none of them the continuation of another.

    The residual is linear between the lines and directions halfway between them, where it is 1 and
    -1 by turns. One line ends soon.
    """

    residual_scale = 1.0
    angles = np.radians([-170.0, 120.0, 150.0, 175.0])

    def __init__(self, dead_end):
        self.dead_end = self.direction(self.angles[dead_end])
        halfway = (self.angles + np.append(self.angles[1:], self.angles[0] + 2 * np.pi)) / 2
        self.around = np.column_stack([self.angles, halfway]).ravel()
        self.values = np.array([0, 1, 0, -1, 0, 1, 0, -1])

    @staticmethod
    def direction(angle):
        return np.array([np.cos(angle), np.sin(angle)])

    def gradient(self, z):
        k = np.searchsorted(self.around, np.arctan2(z[1], z[0]), side="right") - 1
        cone = np.array([self.direction(self.around[i % 8]) for i in (k, k + 1)])
        return np.linalg.solve(cone, self.values[[k % 8, (k + 1) % 8]])

    def evaluate(self, x, p):
        z = np.array([x[0] - 1.0, p - 1.0])
        if z @ self.dead_end > 0.997 * np.linalg.norm(z) and np.linalg.norm(z) > 0.01:
            return np.array([np.nan]), lambda: np.array([[np.nan]])
        self.g = self.gradient(z)
        return np.array([self.g @ z]), lambda: self.g[:1, None]

    def parameter_derivative(self, x, p):
        return self.gradient(np.array([x[0] - 1.0, p - 1.0]))[1:]


@pytest.mark.parametrize(("dead_end", "reached"), [(2, 1), (3, 1), (1, 3)])
def test_where_one_continuation_ends_another_is_followed(dead_end, reached):
    """The lines beside the one that the branch comes from keep its sense, that between does not."""
    star = Star(dead_end)
    down = star.direction(star.angles[0])
    start = 1 + down[0] / down[1] * (0.9 - 1)
    branch = trace(star, np.array([start]), (0.9, 1.1), StepControl(), scale=1.0)
    assert branch.complete, branch.reason
    z = np.array([[s.x[0] - 1, s.p - 1] for s in branch.solutions])
    expected = star.direction(star.angles[reached])
    above = z[z[:, 1] > 1e-3]
    assert len(above) > 3
    np.testing.assert_allclose(above @ [expected[1], -expected[0]], 0, atol=1e-8)
    # no solution is left of the continuation that ended
    assert np.all(np.diff(z[:, 1]) > 0)


def test_where_all_continuations_end_the_first_is_kept():
    star = Star(2)
    star.evaluate = lambda x, p, inner=star.evaluate: (
        inner(x, p) if p < 1.01 else (np.array([np.nan]), lambda: np.array([[np.nan]]))
    )
    down = star.direction(star.angles[0])
    start = 1 + down[0] / down[1] * (0.9 - 1)
    branch = trace(star, np.array([start]), (0.9, 1.1), StepControl(), scale=1.0)
    assert not branch.complete
    assert branch.reason == "no solution found near the last one"
    # the one that turns least
    assert branch.solutions[-1].p == pytest.approx(1.01, abs=1e-6)
    assert branch.solutions[-1].x[0] == pytest.approx(1 - 0.01 / np.tan(np.radians(60)), abs=1e-6)


class WedgeBesideLine(Wedge):
    """A wedge, and beside the line that leads to its corner another branch parallel to it."""

    def __init__(self, inside, axis, distance):
        super().__init__(inside, axis)
        travel = -self.lines()[0]
        self.normal = np.array([-travel[1], travel[0]]) / np.linalg.norm(travel)
        # away from the line that the branch follows from the corner
        self.normal *= -np.sign(self.normal @ self.lines()[1])
        self.distance = distance

    def evaluate(self, x, p):
        (wedge,), by_x = super().evaluate(x, p)
        y = self.plane(x, p) - [2.0, 1.0]
        beside = self.normal @ y - self.distance
        by_columns = self.columns[0, 0]
        of_wedge, of_line = wedge / self.rows[0, 0], beside
        slope = by_x()[0, 0] / self.rows[0, 0]
        self.by_p = np.array([self.by_p[0] / self.rows[0, 0] * of_line + of_wedge * self.normal[1]])
        jacobian = slope * of_line + of_wedge * self.normal[0] * by_columns
        return np.array([of_wedge * of_line]), lambda: np.array([[jacobian]])


@pytest.mark.parametrize("turn", [100, 130, 160])
def test_a_step_beyond_a_corner_onto_another_branch_is_not_taken(turn):
    """The other branch lies straight ahead, and has the opposite orientation."""
    inside = np.radians(180 - turn)
    wedge = WedgeBesideLine(inside, axis=inside / 4, distance=3e-4)
    branch = trace(wedge, wedge.start(0.9), (0.9, 1.1), StepControl(), scale=1.0)
    assert branch.complete, branch.reason
    z = np.array([wedge.plane(s.x, s.p) for s in branch.solutions]) - [2.0, 1.0]
    up = wedge.lines()[1]
    # the residual is a product with the distance from the other branch
    np.testing.assert_allclose(z[z[:, 1] > 0] @ [up[1], -up[0]], 0, atol=1e-5)


def test_a_crossing_of_two_branches_is_passed():
    """The orientation is the opposite one beyond it, on either branch."""

    class Cross(Equations):
        residual_scale = 1.0

        def evaluate(self, x, p):
            a, b = x[0] - p, x[0] + p - 2.0
            return np.array([a * b]), lambda: np.array([[a + b]])

        def parameter_derivative(self, x, p):
            return np.array([(x[0] - p) - (x[0] + p - 2.0)])

        def accept(self, x):
            pass

        def state(self):
            return None

        def restore(self, state):
            pass

    branch = trace(Cross(), np.array([0.5]), (0.5, 1.5), StepControl(), scale=1.0)
    assert branch.complete, branch.reason
    assert abs(branch.solutions[-1].x[0] - 1.0) == pytest.approx(0.5, abs=1e-8)


class StarWithLoop(Star):
    """Two of the four lines are sides of a closed branch, whose far end is an inner corner."""

    middle = Star.direction(np.radians(162.5))
    apex, slope = 0.02, 2.0

    def __init__(self):
        super().__init__(0)
        self.dead_end = np.full(2, np.nan)
        self.across = np.array([-self.middle[1], self.middle[0]])

    def gradient(self, z):
        """Of the smaller of the star's residual and one that is negative beyond the apex."""
        star = super().gradient(z)
        beyond = self.slope * np.sign(self.across @ z) * self.across - self.middle
        self.offset = 0.0
        if beyond @ z + self.apex < star @ z:
            self.offset = self.apex
            return beyond
        return star

    def evaluate(self, x, p):
        z = np.array([x[0] - 1.0, p - 1.0])
        g = self.gradient(z)
        return np.array([g @ z + self.offset]), lambda: g[:1, None]


def test_a_closed_branch_that_meets_another_at_a_corner_is_followed_too():
    """The branch that turns less leads to the end of the window, the maximum is on the other."""
    star = StarWithLoop()
    down = star.direction(star.angles[0])
    start = 1 + down[0] / down[1] * (0.9 - 1)
    observe = First()
    observe.value = lambda x: -float(x[0])
    observe.slope = lambda x, dx: -float(dx[0])
    branch = trace(star, np.array([start]), (0.9, 1.1), StepControl(), scale=1.0, maximise=observe)
    assert branch.complete, branch.reason
    z = np.array([[s.x[0] - 1, s.p - 1] for s in branch.solutions])
    # the line by which it leaves
    leaves = star.direction(star.angles[1])
    assert abs(z[-1] @ [leaves[1], -leaves[0]]) < 1e-8
    # the sides of the closed branch are 12.5 degrees beside its middle
    side = np.tan(np.radians(12.5))
    along = star.apex / (1 - star.slope * side)
    corners = [along * (star.middle + sign * side * star.across) for sign in (1, -1)]
    farthest = max(-corner[0] for corner in corners)
    (highest,) = [s for s in branch.solutions if s.located]
    assert 1 - highest.x[0] == pytest.approx(farthest, rel=1e-6)
    # it is followed all around
    for side in (star.direction(star.angles[2]), star.direction(star.angles[3])):
        on_side = (abs(z @ [side[1], -side[0]]) < 1e-8) & (z @ side > 1e-3)
        assert on_side.any()
