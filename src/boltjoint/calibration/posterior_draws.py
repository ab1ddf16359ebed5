"""Posterior draws by importance resampling, with Pareto k.

The first density is the normal approximation of the least squares, or one along a curved valley
(``ridge``). Where few of its draws count, rounds of draws correct centre and covariance.

References
----------
J.-M. Cornuet, J.-M. Marin, A. Mira, C. P. Robert: Adaptive multiple importance sampling.
Scandinavian Journal of Statistics 39 (2012) 798-812.
A. Vehtari, D. Simpson, A. Gelman, Y. Yao, J. Gabry: Pareto smoothed importance sampling. Journal of
Machine Learning Research 25 (2024) 72: draws are reliable where k is below 0.7.
J. Zhang, M. A. Stephens: A new and efficient estimation method for the generalized Pareto
distribution. Technometrics 51 (2009) 316-325.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from boltjoint.calibration.forked_map import forked_map

Array = NDArray[np.float64]

#: Pareto k above which draws do not stand for the posterior
LARGEST_PARETO_K = 0.7

#: degrees of freedom of the proposal: its tails are heavier than those of a normal distribution
_FREEDOM = 7
#: what the cost may rise by along an axis, 1/2 by one standard deviation
_RISE = 2.0
#: rounds of draws, and Pareto k at which they end
_FEWEST_ROUNDS, _MOST_ROUNDS, _SMALL_ENOUGH = 3, 8, 0.6
#: draws of the first rounds, at most: they tell where those of all others should be
_TRIED = 5000
#: further draws over those that are needed
_MARGIN = 1.1
#: effective draws by parameter of which a covariance is taken
_EFFECTIVE = 5
#: effective share of draws below which a proposal is left
_SHARE = 0.2
#: axes over those of the draws: a posterior along a curve has little weight where they end
_WIDER = 1.5
#: axis over the bounds, shortening of one, and power of weights that are no smaller
_SMALLEST = 1e-6


@dataclass(frozen=True)
class ImportanceDraws:
    """Draws of parameters in their scales.

    Attributes
    ----------
    scaled
        Resampled draws, (draws, parameters); none where all proposals lie beyond the bounds.
    pareto_k
        Shape of the tail of the weights: above ``LARGEST_PARETO_K`` the draws do not stand for the
        posterior.
    effective
        Effective number of draws.
    """

    scaled: Array
    pareto_k: float
    effective: float


class Proposal(Protocol):
    """A density of which draws are made."""

    def draw(self, count: int, random: np.random.Generator) -> Array:
        """Draws, (count, parameters)."""
        ...

    def log_density(self, draws: Array) -> Array:
        """Logarithm of the density at each draw, (draws,)."""
        ...


def importance_draws(
    cost: Callable[[Array], float],
    proposal: Proposal,
    bounds: tuple[Array, Array],
    count: int,
    seed: int,
    processes: int = 1,
) -> ImportanceDraws:
    """Draws of a proposal, resampled by exp(-cost) over its density.

    Parameters
    ----------
    cost
        Half the sum of squares; a ``ValueError`` where the model has no mode.
    proposal
        The first density; where few of its draws count, normal distributions take its place.
    bounds
        Beyond which the posterior is zero.
    count, seed
        Of the draws.
    processes
        Among which the costs of draws are shared (``forked_map``).
    """
    random = np.random.default_rng(seed)
    drawn = _Draws(cost, bounds, processes)
    few = min(count // 2, _TRIED)
    drawn.add(proposal, few, random)
    is_left = False
    for n in range(1, _MOST_ROUNDS):
        weight = drawn.weights()
        is_enough = pareto_shape(weight) < _SMALL_ENOUGH and _effective(weight) > count / 2
        if n >= _FEWEST_ROUNDS and is_enough:
            break
        is_left = is_left or _effective(weight) < _SHARE * weight.size
        # one round at least reaches where the proposal may not
        is_normal = is_left or n == 1
        number = few if n == 1 else drawn.still_needed(count // 2, few)
        drawn.add(drawn.density() if is_normal else proposal, number, random)
    weight = drawn.weights()
    if not weight.any():
        return ImportanceDraws(np.empty((0, bounds[0].size)), np.inf, 0.0)
    chosen = random.choice(weight.size, count, p=weight)
    return ImportanceDraws(drawn.draws[chosen], pareto_shape(weight), _effective(weight))


def of_least_squares(
    cost: Callable[[Array], float], centre: Array, covariance: Array, bounds: tuple[Array, Array]
) -> Proposal:
    """The normal approximation with axes as long as the cost says, with heavier tails."""
    width = bounds[1] - bounds[0]
    squared, vectors = np.linalg.eigh(covariance / np.outer(width, width))
    deviations = np.clip(np.sqrt(np.maximum(squared, 0.0)), _SMALLEST, 0.5)
    axes = width[:, None] * vectors * deviations
    return _Normal(centre, axes * _lengths(cost, centre, axes, bounds))


def _lengths(
    cost: Callable[[Array], float], centre: Array, axes: Array, bounds: tuple[Array, Array]
) -> Array:
    """How far along each axis the cost rises as one standard deviation does, at most the axis.

    Beyond the bounds it is not asked for.
    """
    least, lengths = cost(centre), np.ones(axes.shape[1])
    for n, axis in enumerate(axes.T):
        for sign in (-1, 1):
            while lengths[n] > _SMALLEST:
                at = centre + sign * lengths[n] * axis
                if np.any(at < bounds[0]) or np.any(at > bounds[1]):
                    break
                try:
                    rise = cost(at) - least
                except ValueError:
                    rise = np.inf
                if rise <= _RISE:
                    break
                lengths[n] /= 2
    return lengths


@dataclass(frozen=True)
class _Normal:
    """A multivariate t distribution: its centre, and axes of one standard deviation by column."""

    centre: Array
    axes: Array

    def draw(self, count: int, random: np.random.Generator) -> Array:
        """Draws, (count, parameters)."""
        return self.centre + student_draws(count, self.centre.size, random) @ self.axes.T

    def log_density(self, draws: Array) -> Array:
        """Logarithm of the density."""
        standard = np.asarray(np.linalg.solve(self.axes, (draws - self.centre).T).T, float)
        return student_log_density(standard) - np.linalg.slogdet(self.axes)[1]


def student_draws(count: int, size: int, random: np.random.Generator) -> Array:
    """Draws of the standard multivariate t distribution, (count, size)."""
    normal = random.standard_normal((count, size))
    return normal * np.sqrt(_FREEDOM / random.chisquare(_FREEDOM, count))[:, None]


def student_log_density(standard: Array) -> Array:
    """Logarithm of its density at each draw, (draws,)."""
    size = standard.shape[1]
    constant = gammaln((_FREEDOM + size) / 2) - gammaln(_FREEDOM / 2)
    constant -= size / 2 * np.log(np.pi * _FREEDOM)
    tail = np.log1p(np.sum(standard**2, axis=1) / _FREEDOM)
    return constant - 0.5 * (_FREEDOM + size) * tail


class _Draws:
    """Draws of several densities, with what the cost is there."""

    def __init__(
        self, cost: Callable[[Array], float], bounds: tuple[Array, Array], processes: int = 1
    ) -> None:
        self._cost, self._bounds, self._processes = cost, bounds, processes
        #: densities, and logarithms of the numbers of their draws
        self._densities: list[tuple[Proposal, float]] = []
        self.draws = np.empty((0, bounds[0].size))
        self._costs = np.empty(0)

    def add(self, density: Proposal, count: int, random: np.random.Generator) -> None:
        """Further draws; beyond the bounds, or where the model has no mode, cost has no limit."""
        draws, costs = density.draw(count, random), np.full(count, np.inf)
        inside = np.all((draws >= self._bounds[0]) & (draws <= self._bounds[1]), axis=1)
        costs[inside] = list(forked_map(self._cost_at, draws[inside], self._processes))
        self._densities.append((density, float(np.log(count))))
        self.draws = np.concatenate([self.draws, draws])
        self._costs = np.concatenate([self._costs, costs])

    def still_needed(self, effective: int, few: int) -> int:
        """Further draws until so many are effective, if these are as those before; some at least.

        At most as many as should be effective.
        """
        weight = self.weights()
        before = _effective(weight)
        if before == 0:
            return effective
        needed = _MARGIN * (effective - before) * weight.size / before
        return int(np.clip(np.ceil(needed), few, effective))

    def _cost_at(self, draw: Array) -> float:
        try:
            return self._cost(draw)
        except ValueError:
            return np.inf

    def weights(self, power: float = 1.0) -> Array:
        """exp(-cost) over the density of all draws, to a power; 1 in all, or 0 everywhere."""
        log_densities = [
            density.log_density(self.draws) + number for density, number in self._densities
        ]
        log_weight = -self._costs - np.logaddexp.reduce(log_densities)
        if not np.isfinite(log_weight).any():
            return np.zeros(log_weight.size)
        weight = np.exp(power * (log_weight - log_weight.max()))
        return weight / weight.sum()

    def density(self) -> Proposal:
        """With the centre and the covariance of the draws.

        Where few of them carry the weight, of a power of it that more carry.
        """
        size, power = self.draws.shape[1], 1.0
        while _effective(self.weights(power)) < _EFFECTIVE * size and power > _SMALLEST:
            power /= 2
        weight = self.weights(power)
        if not weight.any():
            return self._densities[-1][0]
        centre = weight @ self.draws
        off = self.draws - centre
        width = self._bounds[1] - self._bounds[0]
        squared, vectors = np.linalg.eigh((weight[:, None] * off).T @ off / np.outer(width, width))
        deviations = np.sqrt(np.maximum(squared, _SMALLEST**2))
        return _Normal(centre, _WIDER * width[:, None] * vectors * deviations)


def _effective(weight: Array) -> float:
    return float(weight.sum() ** 2 / (weight**2).sum()) if weight.any() else 0.0


def pareto_shape(weight: Array) -> float:
    """Shape k of a generalised Pareto distribution of the largest weights (Zhang and Stephens)."""
    count = weight.size
    tail = int(np.ceil(min(0.2 * count, 3 * np.sqrt(count))))
    ordered = np.sort(weight)
    x = ordered[-tail:] - ordered[-tail - 1]
    x = x[x > 0]
    n = x.size
    if n < 5:
        return np.inf
    m = 30 + int(np.sqrt(n))
    quartile = x[int(n / 4 + 0.5) - 1]
    b = 1 / x[-1] + (1 - np.sqrt(m / (np.arange(1, m + 1) - 0.5))) / (3 * quartile)
    k = np.log1p(-b[:, None] * x).mean(axis=1)
    likelihood = n * (np.log(-b / k) - k - 1)
    share = np.exp(likelihood - likelihood.max())
    best = float((b * share).sum() / share.sum())
    shape = float(np.log1p(-best * x).mean())
    # a weak prior at 0.5, as if of ten values
    return (n * shape + 10 * 0.5) / (n + 10)
