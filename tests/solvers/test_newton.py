"""Newton's method at a fixed parameter."""

import numpy as np
import pytest
from curves import FOLDED, PARABOLA, Curve

from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl


class Counting(Curve):
    """The folded curve, counting the evaluations of its Jacobian."""

    evaluated = 0

    def evaluate(self, x, p):
        residual, jacobian_at = super().evaluate(x, p)

        def counted():
            self.evaluated += 1
            return jacobian_at()

        return residual, counted


def test_jacobians_are_evaluated_only_for_corrections():
    curve = Counting(FOLDED._residual, FOLDED._by_x, FOLDED._by_p)
    solution, jacobian = newton(curve, np.array([2.3]), 2.0, StepControl())
    assert solution.converged
    assert curve.evaluated == solution.iterations > 1
    # that of the last correction, which changed x by less than a thousandth
    assert jacobian[0, 0] == pytest.approx(3 * 2.0**2 - 3, rel=1e-3)
    assert jacobian[0, 0] != 3 * solution.x[0] ** 2 - 3
    curve.evaluated = 0
    branch = trace(curve, np.array([-2.0]), (-3.0, 3.0), StepControl(), scale=1.0)
    assert branch.complete
    tried_in_vain = curve.evaluated - sum(max(s.iterations, 1) for s in branch.solutions)
    assert tried_in_vain < len(branch.solutions) / 2


def test_newton_converges_quadratically_to_a_root():
    solution, jacobian = newton(FOLDED, np.array([3.0]), 2.0, StepControl(tolerance=1e-12))
    assert solution.converged
    assert solution.iterations <= 6
    assert solution.x[0] == pytest.approx(2.0)
    assert jacobian[0, 0] == pytest.approx(9.0)


def test_newton_without_a_root_does_not_converge():
    solution, _ = newton(PARABOLA, np.array([0.5]), 3.0, StepControl())
    assert not solution.converged


def test_the_residual_converges_to_the_rounding_of_its_terms():
    # forces ten orders above what excites, as at a sharp resonance
    stiff = Curve(lambda x, p: 1e10 * (x**2 - p), lambda x, p: 2e10 * x, lambda x, p: -1e10)
    branch = trace(stiff, np.array([1.4]), (2.0, 3.0), StepControl(tolerance=1e-9), scale=1.0)
    assert branch.complete
    for solution in branch.solutions:
        assert solution.x[0] == pytest.approx(np.sqrt(solution.p), rel=1e-12)
