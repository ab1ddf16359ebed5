"""Load stepping: homotopy in the excitation force at a fixed frequency."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.linear_modes import LinearModes
from boltjoint.solvers.equations import Equations, LazyJacobian


class LoadStepping(Equations):
    """Equations at a fixed frequency whose parameter is the logarithm of the load factor.

    Parameters
    ----------
    equations
        In linear modes or self-consistent RDNM, followed while their excitation grows.
    w
        The frequency [rad/s].
    """

    def __init__(self, equations: LinearModes, w: float) -> None:
        self._equations, self._w = equations, w
        self.residual_scale = equations.residual_scale

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian under exp(p) times the excitation."""
        return self._equations.evaluate(x, self._w, np.exp(p))

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the load factor."""
        return np.exp(p) * self._equations.load_factor_derivative(x)

    def accept(self, x: NDArray[np.float64]) -> None:
        """As of the equations."""
        self._equations.accept(x)

    def state(self) -> object:
        """As of the equations."""
        return self._equations.state()

    def restore(self, state: object) -> None:
        """As of the equations."""
        self._equations.restore(state)
