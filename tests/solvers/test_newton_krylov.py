"""Newton's method with the factors of an earlier Jacobian."""

import numpy as np
import pytest
from curves import SIZE, Combustion
from scipy.optimize import root
from scipy.sparse.linalg import gmres

from boltjoint.solvers import newton
from boltjoint.solvers.equations import Derivative
from boltjoint.solvers.newton import KeptFactors, NewtonKrylov
from boltjoint.solvers.step_control import StepControl

CONTROL = StepControl(tolerance=1e-8, maximum_iterations=30)


def test_one_jacobian_serves_solutions_near_each_other():
    equations = Combustion()
    solver, x = NewtonKrylov(equations, CONTROL), np.zeros(SIZE)
    for p in np.linspace(1.0, 3.0, 9):
        found = solver.solve(x, p)
        assert found.converged
        x = found.x
        expected = root(lambda u, p=p: equations.evaluate(u, p)[0], x + 0.01, tol=1e-12).x
        np.testing.assert_allclose(x, expected, rtol=1e-9)
    assert equations.jacobians < 4


def test_what_has_no_solution_does_not_converge():
    # beyond p = 3.514 there is none
    assert not NewtonKrylov(Combustion(), CONTROL).solve(np.zeros(SIZE), 4.0).converged


@pytest.mark.filterwarnings("ignore::scipy.linalg.LinAlgWarning")
@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_singular_jacobian_gives_no_correction(value):
    class Singular(Combustion):
        def evaluate(self, x, p):
            matrix = np.full((SIZE, SIZE), value)
            return np.ones(SIZE), Derivative(
                lambda precision: matrix.astype(precision), lambda dx: matrix @ dx
            )

    solver = NewtonKrylov(Singular(), CONTROL)
    assert not solver.solve(np.zeros(SIZE), 1.0).converged


@pytest.mark.filterwarnings("error")
def test_a_correction_beyond_all_numbers_ends_without_a_warning():
    class Steep(Combustion):
        """exp(x) + 1 has no root: from above corrections lead to ever larger residuals."""

        evaluations = 0

        def evaluate(self, x, p):
            self.evaluations += 1
            slope = -1e-4 * np.eye(SIZE)
            return np.exp(x) + 1, Derivative(
                lambda precision: slope.astype(precision), lambda dx: slope @ dx
            )

    equations = Steep()
    assert not NewtonKrylov(equations, CONTROL).solve(np.zeros(SIZE), 1.0).converged
    # the first guess, and one correction at four lengths
    assert equations.evaluations == 5


def test_a_residual_just_above_the_tolerance_asks_for_no_new_factors(monkeypatch):
    """As rounding leaves it where GMRES has come below by its own account, and doubts it."""
    monkeypatch.setattr(newton, "gmres", lambda *args, **kwargs: (gmres(*args, **kwargs)[0], 1))
    random = np.random.default_rng(5)
    matrix, asked, factors = random.normal(size=(60, 60)), [], KeptFactors()
    for change in (0.0, 1e-3, 2e-3):
        near, right = matrix + change * random.normal(size=(60, 60)), random.normal(size=60)

        def jacobian(precision, near=near):
            asked.append(precision)
            return near.astype(precision)

        solution = factors.solve(lambda x, near=near: near @ x, jacobian, right, 1e-3)
        assert np.linalg.norm(near @ solution - right) < 2e-3 * np.linalg.norm(right)
    assert len(asked) == 1


OUTLIER = np.append(np.geomspace(1, 1e-2, 599), 1e-9)
VALUES = {1e-2: np.geomspace(1, 1e-2, 600), 1e-9: OUTLIER} | {
    smallest: np.geomspace(1, smallest, 600) for smallest in (1e-6, 1e-7, 1e-12)
}


@pytest.mark.parametrize("tolerance", [0.1, 1e-5])
@pytest.mark.parametrize("smallest", VALUES)
def test_a_matrix_that_single_precision_does_not_hold_is_solved_as_well(smallest, tolerance):
    # as near a sharp resonance, where terms cancel
    random = np.random.default_rng(3)
    turn = np.linalg.qr(random.normal(size=(600, 600)))[0]
    matrix = turn @ np.diag(VALUES[smallest]) @ turn.T
    factors, asked = KeptFactors(), []

    def jacobian(precision):
        asked.append(precision)
        return matrix.astype(precision)

    for _ in range(2):
        right = random.normal(size=600)
        solution = factors.solve(lambda x: matrix @ x, jacobian, right, tolerance)
        assert np.linalg.norm(matrix @ solution - right) < 1.2 * tolerance * np.linalg.norm(right)
    # the factors are kept, those in double precision where single does not do
    assert asked == [np.float32, np.float64][: 1 + (smallest * tolerance < 1e-8)]
