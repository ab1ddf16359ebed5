"""Equations given by functions, whose solutions are known curves."""

import numpy as np

from boltjoint.solvers.equations import Derivative, Equations

#: unknowns of Bratu's equation
SIZE = 400


class Curve(Equations):
    """Equations of one unknown given by functions."""

    residual_scale = 1.0

    def __init__(self, residual, by_x, by_p):
        self._residual, self._by_x, self._by_p = residual, by_x, by_p

    def evaluate(self, x, p):
        return np.array([self._residual(x[0], p)]), lambda: np.array([[self._by_x(x[0], p)]])

    def parameter_derivative(self, x, p):
        return np.array([self._by_p(x[0], p)])


# p = x^3 - 3 x folds at x = -1 (p = 2) and x = 1 (p = -2)
FOLDED = Curve(lambda x, p: x**3 - 3 * x - p, lambda x, p: 3 * x**2 - 3, lambda x, p: -1.0)
PARABOLA = Curve(lambda x, p: x**2 + p - 1, lambda x, p: 2 * x, lambda x, p: 1.0)


class First:
    """The first unknown, observed along a branch."""

    def value(self, x):
        return float(x[0])

    def slope(self, x, dx):
        return float(dx[0])


class Combustion(Equations):
    """Bratu's equation ``u'' + p exp(u) = 0`` by differences, counting its Jacobians."""

    residual_scale = 1.0

    def __init__(self):
        step = 1 / (SIZE + 1)
        neighbours = np.eye(SIZE, k=1) + np.eye(SIZE, k=-1)
        self._second = (neighbours - 2 * np.eye(SIZE)) / step**2
        self.jacobians = 0

    def evaluate(self, x, p):
        def jacobian(precision):
            self.jacobians += 1
            return (self._second + np.diag(p * np.exp(x))).astype(precision)

        def along(dx):
            return self._second @ dx + p * np.exp(x) * dx

        return self._second @ x + p * np.exp(x), Derivative(jacobian, along)

    def parameter_derivative(self, x, p):
        return np.exp(x)
