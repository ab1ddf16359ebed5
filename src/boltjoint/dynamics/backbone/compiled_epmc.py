"""The nonlinear mode (``backbone.epmc``) as equations of ``solvers.compiled_arc_length``."""

from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.balance.compiled_balance import (
    BalanceArrays,
    add_modal_force,
    balance_arrays,
    evaluate_balance,
    form_jacobian_of_balance,
)
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.solvers.compiled_steps import System

Array = NDArray[np.float64]


def epmc_system(equations: EPMCEquations) -> System | None:
    """The equations of a nonlinear mode; None where its law has no kernel."""
    arrays = balance_arrays(equations.balance, float(equations.scale))
    return None if arrays is None else System.of(_FUNCTIONS, arrays)


@kept_loop
def _evaluate(arrays: BalanceArrays, x: Array, p: float, residual: Array) -> None:
    """Residual at the modal amplitude exp(p)."""
    a, n, modes, scale = exp(p), x.size - 2, arrays.response.size, arrays.scale
    for i in range(n):
        arrays.coordinates[i] = a * x[i]
    evaluate_balance(arrays, arrays.coordinates, 0.0, residual[:n])
    real, imaginary = x[n], x[n + 1]
    for i in range(n):
        residual[i] /= a * scale
    residual[n], residual[n + 1] = -1.0, 0.0
    sin, cos = n - 2 * modes, n - modes
    for m in range(modes):
        s, c = x[sin + m], x[cos + m]
        residual[sin + m] -= real * s - imaginary * c
        residual[cos + m] -= real * c + imaginary * s
        residual[n] += s * s + c * c
        residual[n + 1] += s * c
    w = sqrt(abs(real) * scale)
    for k in range(arrays.power.size):
        factor = w ** arrays.power[k] / scale
        for i in range(n):
            for j in range(n):
                residual[i] += factor * arrays.varying[k, i, j] * x[j]


@kept_loop
def _evaluate_each(arrays: BalanceArrays, unknowns: Array, residuals: Array) -> None:
    """Residuals at several unknowns with logarithms of the amplitude."""
    for i in range(len(unknowns)):
        _evaluate(arrays, unknowns[i, :-1], unknowns[i, -1], residuals[i])


@kept_loop
def _form_jacobian(arrays: BalanceArrays, x: Array, p: float, jacobian: Array) -> None:
    """Jacobian where the residual was evaluated last."""
    n, modes, scale = x.size - 2, arrays.response.size, arrays.scale
    form_jacobian_of_balance(arrays, arrays.coordinates, 0.0, arrays.jacobian)
    real, imaginary = x[n], x[n + 1]
    for i in range(n):
        for j in range(n):
            jacobian[i, j] = arrays.jacobian[i, j] / scale
        for j in range(2):
            jacobian[i, n + j] = jacobian[n + j, i] = 0.0
    for i in range(2):
        for j in range(2):
            jacobian[n + i, n + j] = 0.0
    sin, cos = n - 2 * modes, n - modes
    for m in range(modes):
        s, c = x[sin + m], x[cos + m]
        jacobian[sin + m, sin + m] -= real
        jacobian[sin + m, cos + m] += imaginary
        jacobian[cos + m, sin + m] -= imaginary
        jacobian[cos + m, cos + m] -= real
        jacobian[sin + m, n], jacobian[sin + m, n + 1] = -s, c
        jacobian[cos + m, n], jacobian[cos + m, n + 1] = -c, -s
        jacobian[n, sin + m], jacobian[n, cos + m] = 2 * s, 2 * c
        jacobian[n + 1, sin + m], jacobian[n + 1, cos + m] = c, s
    w = sqrt(abs(real) * scale)
    for k in range(arrays.power.size):
        power, varying = arrays.power[k], arrays.varying[k]
        factor = w**power / scale
        # by the real part of lambda, on which w depends
        change = np.sign(real) / (2 * w) * power * w ** (power - 1.0)
        for i in range(n):
            for j in range(n):
                jacobian[i, j] += factor * varying[i, j]
                jacobian[i, n] += change * varying[i, j] * x[j]


@kept_loop
def _form_parameter_derivative(
    arrays: BalanceArrays, x: Array, p: float, derivative: Array
) -> None:
    """Derivative by the logarithm of the amplitude: of f(a x) / a, what is not linear in a."""
    motion, force, tangent = arrays.motion, arrays.force, arrays.tangent
    points, columns = motion.shape
    factor = 1 / (exp(p) * arrays.scale)
    change = np.zeros_like(force)
    for point in range(points):
        for i in range(columns):
            total = -force[point, i]
            for j in range(columns):
                total += tangent[point, i, j] * motion[point, j]
            change[point, i] = factor * total
    derivative[:] = 0.0
    add_modal_force(arrays.rows, change, arrays.column, derivative)


@kept_loop
def _observe(arrays: BalanceArrays, x: Array, dx: Array, observed: Array) -> None:
    """Nothing: a backbone has no maxima to be located."""
    observed[0], observed[1] = 0.0, -1.0


_FUNCTIONS = _evaluate, _form_jacobian, _form_parameter_derivative, _observe


class CompiledMode:
    """The equations of a nonlinear mode, evaluated one by one by their compiled functions.

    Parameters
    ----------
    arrays
        Of the equations; evaluations write into them.
    """

    def __init__(self, arrays: BalanceArrays) -> None:
        self._arrays = arrays

    @classmethod
    def of(cls, balance: HarmonicBalance, scale: float) -> "CompiledMode | None":
        """Those of a balance without excitation, over a scale; None where its law has no kernel."""
        arrays = balance_arrays(balance, float(scale))
        return None if arrays is None else cls(arrays)

    def residuals(self, unknowns: Array) -> Array:
        """As of ``EPMCEquations``."""
        residuals = np.empty((len(unknowns), unknowns.shape[1] - 1))
        _evaluate_each(self._arrays, unknowns, residuals)
        return residuals

    def residual(self, x: Array, p: float) -> Array:
        """Residual at the modal amplitude exp(p)."""
        residual = np.empty(x.size)
        _evaluate(self._arrays, x, p, residual)
        return residual

    def derivatives(self, x: Array, p: float) -> tuple[Array, Array]:
        """Jacobian and derivative by p where the residual was evaluated last."""
        jacobian, by_parameter = np.empty((x.size, x.size)), np.empty(x.size)
        _form_jacobian(self._arrays, x, p, jacobian)
        _form_parameter_derivative(self._arrays, x, p, by_parameter)
        return jacobian, by_parameter
