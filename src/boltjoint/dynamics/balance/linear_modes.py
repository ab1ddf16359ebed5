"""Harmonic balance in linear modal coordinates, the modes of the structure without contact.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 2.1.2, eq. 2.38.
"""

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.compiled_balance import balance_system
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.solvers.compiled_steps import System
from boltjoint.solvers.equations import Equations, LazyJacobian

Jacobian = Literal["analytic", "forward-difference"]

#: step of forward differences over the size of the unknown: the square root of rounding
_DIFFERENCE = float(np.sqrt(np.finfo(float).eps))


class BalanceEquations(Equations):
    """The harmonic balance as equations of the solvers, with all linear modes as coordinates.

    Parameters
    ----------
    balance
        The modal equations.
    jacobian
        ``analytic``, or ``forward-difference`` as in eq. 2.38.

    Raises
    ------
    ValueError
        If the kind of Jacobian is not known.
    """

    def __init__(self, balance: HarmonicBalance, jacobian: Jacobian = "analytic") -> None:
        checks.instance("balance", balance, HarmonicBalance)
        checks.choice("jacobian", jacobian, get_args(Jacobian))
        self.balance = balance
        self.residual_scale = float(np.linalg.norm(balance.modal_force))
        self.is_analytic = jacobian == "analytic"

    def compiled_system(self) -> System | None:
        """The equations as compiled loops follow them; None where the general ones are needed."""
        return balance_system(self.balance) if self.is_analytic else None

    def in_all_modes(self, reduced: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Solutions of the balance in all linear modes, by whether each is one of a basis."""
        return ~reduced

    def evaluate(
        self, x: NDArray[np.float64], p: float, load_factor: float = 1.0
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian at the frequency p [rad/s], under a part of the excitation."""
        if self.is_analytic:
            residual, jacobian = self.balance.residual_and_jacobian(x, p)
        else:
            residual, jacobian = self._with_differences(x, p)
        return residual + (1 - load_factor) * self.balance.modal_force, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the frequency."""
        return self.balance.frequency_derivative(x, p)

    def load_factor_derivative(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the residual by the load factor."""
        return -self.balance.modal_force

    def _residual(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Residual under the whole excitation."""
        return self.balance.residual(x, p)

    def _with_differences(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        residual = self._residual(x, p)

        def jacobian() -> NDArray[np.float64]:
            columns = np.empty((x.size, x.size))
            size = np.linalg.norm(x) / np.sqrt(x.size) or 1.0
            for j in range(x.size):
                step = _DIFFERENCE * max(abs(x[j]), size)
                moved = x.copy()
                moved[j] += step
                columns[:, j] = (self._residual(moved, p) - residual) / (moved[j] - x[j])
            return columns

        return residual, jacobian
