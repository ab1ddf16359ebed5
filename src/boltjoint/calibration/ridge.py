"""Density along a curved valley of a cost, from which posterior draws are proposed.

Where parameters go together, the posterior lies along a curve that no normal distribution follows.
One parameter is held at points of a grid and all others are fitted beside it, as for its profile;
at each point the others are taken as normally distributed, with the covariance of the least squares
there. That is the nested approximation by Laplace, with one parameter outside.

References
----------
H. Rue, S. Martino, N. Chopin: Approximate Bayesian inference for latent Gaussian models by using
integrated nested Laplace approximations. Journal of the Royal Statistical Society B 71 (2009)
319-392.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from boltjoint.calibration.posterior_draws import student_draws, student_log_density

Array = NDArray[np.float64]

#: points on each side of the best fit, and their reach over that of the 95 % interval
_POINTS, _REACH = 10, 2.0
#: cells in which the density along the valley is constant
_CELLS = 400
#: logarithm of the least density along the valley, so that it is nowhere zero
_LEAST_LOGARITHM = -500.0
#: density along the valley, and deviations beside it, are wider than those of the approximation
_POWER, _WIDER = 0.6, 1.7
#: length of a side over the bounds, below which there is none
_SHORTEST = 1e-3
#: deviation beside the valley, over the bounds, at most
_WIDEST = 0.5


@dataclass(frozen=True)
class Ridge:
    """The density along a valley of the cost.

    Parameters
    ----------
    parameter
        Place of the one along which it lies.
    at
        Its values, ascending, shape (points,).
    path
        All parameters at the least cost beside each value, (points, parameters).
    costs
        That cost, (points,).
    roots
        Matrices whose product with their transpose is the covariance of the others there, (points,
        others, others).
    """

    parameter: int
    at: Array
    path: Array
    costs: Array
    roots: Array

    @classmethod
    def along(
        cls,
        parameter: int,
        best: Array,
        cost: float,
        ends: tuple[float, float],
        bounds: tuple[Array, Array],
        fitted_beside: Callable[[float, Array], tuple[Array, float]],
        jacobian: Callable[[Array], Array],
    ) -> "Ridge":
        """The valley through the best fit.

        Parameters
        ----------
        parameter
            Place of the one along which it lies.
        best, cost
            All of them at the best fit, and the cost there.
        ends
            Of its 95 % interval.
        bounds
            Of all parameters.
        fitted_beside
            All parameters and the cost at a value of it, by a guess; a ``ValueError`` where there
            are none.
        jacobian
            Of the residual, (values, parameters).
        """
        low, high = bounds
        found = [(float(best[parameter]), best, cost)]
        for end in ends:
            last = best[parameter] + _REACH * (end - best[parameter])
            last = np.clip(last, low[parameter], high[parameter])
            if abs(last - best[parameter]) < _SHORTEST * (high - low)[parameter]:
                continue  # the best fit lies at a bound
            guess = best
            for at in np.linspace(best[parameter], last, _POINTS + 1)[1:]:
                try:
                    guess, at_least = fitted_beside(float(at), guess)
                except ValueError:
                    break
                found.append((float(at), guess, at_least))
        found.sort(key=lambda point: point[0])
        others = np.arange(best.size) != parameter
        width, roots = (high - low)[others], []
        for _, x, _ in found:
            # in shares of the bounds, beyond which no direction reaches
            _, s, Vt = np.linalg.svd(jacobian(x)[:, others] * width, full_matrices=False)
            roots.append(_WIDER * width[:, None] * Vt.T / np.maximum(s, 1 / _WIDEST))
        at, path, costs = (np.array(each) for each in zip(*found, strict=True))
        return cls(parameter, at, path, costs, np.array(roots))

    @cached_property
    def _curve(self) -> PchipInterpolator:
        return PchipInterpolator(self.at, self.path)

    @cached_property
    def _cells(self) -> tuple[Array, Array]:
        """Edges of the cells, and the probability of each."""
        edges = np.linspace(self.at[0], self.at[-1], _CELLS + 1)
        # volume of the others beside it, by Laplace
        log_density = np.linalg.slogdet(self.roots)[1] - self.costs
        middle = (edges[1:] + edges[:-1]) / 2
        lower = np.interp(middle, self.at, log_density) - log_density.max()
        own = np.exp(np.maximum(_POWER * lower, _LEAST_LOGARITHM))
        return edges, own / own.sum()

    @cached_property
    def _others(self) -> NDArray[np.bool_]:
        """Which parameters lie beside the valley."""
        return np.arange(self.path.shape[1]) != self.parameter

    def _nearest(self, at: Array) -> NDArray[np.intp]:
        return np.argmin(abs(at[:, None] - self.at), axis=1)

    def draw(self, count: int, random: np.random.Generator) -> Array:
        """Draws, (count, parameters)."""
        edges, share = self._cells
        cell = random.choice(_CELLS, count, p=share)
        at = random.uniform(edges[cell], edges[cell + 1])
        standard = student_draws(count, self.path.shape[1] - 1, random)
        drawn = self._curve(at)
        drawn[:, self._others] += np.einsum("dij,dj->di", self.roots[self._nearest(at)], standard)
        drawn[:, self.parameter] = at
        return drawn

    def log_density(self, draws: Array) -> Array:
        """Logarithm of the density."""
        edges, share = self._cells
        at = draws[:, self.parameter]
        inside = (at >= edges[0]) & (at <= edges[-1])
        clipped = np.clip(at, edges[0], edges[-1])
        cell = np.clip(np.searchsorted(edges, clipped, "right") - 1, 0, _CELLS - 1)
        along = np.log(share[cell] / (edges[1] - edges[0]))
        off = (draws - self._curve(clipped))[:, self._others]
        roots = self.roots[self._nearest(clipped)]
        standard = np.linalg.solve(roots, off[:, :, None])[:, :, 0]
        beside = student_log_density(standard) - np.linalg.slogdet(roots)[1]
        return np.where(inside, along + beside, -np.inf)
