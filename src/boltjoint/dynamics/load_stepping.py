"""Load stepping: homotopy in the excitation force at a fixed frequency."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.linear_modes import LinearModes
from boltjoint.solvers.equations import Equations, LazyJacobian


class LoadStepping(Equations):
    """The equations of linear modes, or modes of the solution, while the excitation grows.

    The parameter is the logarithm of the share of the excitation that acts, at one frequency.

    Parameters
    ----------
    equations
        Those whose share is varied.
    w
        The frequency [rad/s].
    """

    def __init__(self, equations: LinearModes, w: float) -> None:
        self._equations, self._w = equations, w
        self.residual_scale = equations.residual_scale

    @property
    def tracked(self) -> object:
        """As of the equations."""
        return self._equations.tracked

    @tracked.setter
    def tracked(self, tracked: object) -> None:
        self._equations.tracked = tracked

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual under exp(p) of the excitation, and what forms its Jacobian."""
        self._equations.share = np.exp(p)
        found = self._equations.evaluate(x, self._w)
        self._equations.share = 1.0
        return found

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the share."""
        return np.exp(p) * self._equations.share_derivative(x)

    def accept(self, x: NDArray[np.float64]) -> None:
        """As of the equations."""
        self._equations.accept(x)
