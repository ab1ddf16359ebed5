"""Profile likelihood of fitted parameters: all others are fitted anew beside one that is held."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, least_squares
from scipy.stats import norm

from boltjoint.calibration.model_curves import Evaluator, ModelCurves
from boltjoint.calibration.posterior_draws import Proposal, of_least_squares
from boltjoint.calibration.ridge import Ridge

Array = NDArray[np.float64]

#: two standard deviations as they are used here: 95 %
QUANTILE = float(norm.ppf(0.975))

#: what the cost at the ends of an interval is off by from that of a parabola, over it, at most
_NEAR_PARABOLA = 0.3

#: accuracy of the end of a profile, over its distance
_PROFILE_ACCURACY = 0.02

#: steps of a profile on each side, at most: each is twice as long as that before
_WIDEST_PROFILE = 12

#: losses of ``scipy.optimize.least_squares``, by squares over that of their scale
_LOSSES: dict[str, Callable[[Array], Array]] = {
    "linear": lambda z: z,
    "soft_l1": lambda z: 2 * (np.sqrt(1 + z) - 1),
    "huber": lambda z: np.where(z <= 1, z, 2 * np.sqrt(z) - 1),
    "cauchy": np.log1p,
    "arctan": np.arctan,
}


@dataclass(frozen=True)
class Profiles:
    """Costs near the best fit, and the profiles through it.

    Attributes
    ----------
    compared, scaled, loss, robust_scale
        As of ``Calibration``.
    covariance
        Of the parameters in their scales: deviations are the steps of a profile.
    """

    compared: ModelCurves
    scaled: Array
    loss: str
    robust_scale: float
    covariance: Array

    @property
    def standard_error(self) -> Array:
        """Of each parameter in its scale."""
        return np.sqrt(np.diag(self.covariance))

    def cost(self, scaled: Array) -> float:
        """What the fit made least: half the sum of squares, of those that its loss counts less."""
        square = (self.compared.residual(scaled) / self.robust_scale) ** 2
        return 0.5 * self.robust_scale**2 * float(np.sum(_LOSSES[self.loss](square)))

    @cached_property
    def least(self) -> float:
        """The cost at the best fit."""
        return self.cost(self.scaled)

    @cached_property
    def intervals(self) -> Array:
        """Ends of the 95 % interval of each parameter in its scale, (parameters, 2).

        By the covariance where the cost is the parabola that it stands for, else by the profile.
        """
        reach = QUANTILE * self.standard_error
        ends = np.stack([self.scaled - reach, self.scaled + reach], axis=1)
        for n in self._curved:
            ends[n] = self.ends(n)
        return ends

    @cached_property
    def _curved(self) -> list[int]:
        """Parameters at whose ends by the covariance the cost is not that of a parabola."""
        return [n for n in range(self.scaled.size) if not self._is_parabola(n)]

    def _is_parabola(self, n: int) -> bool:
        low, high = self.compared.space.bounds
        reach = QUANTILE * self.covariance[:, n] / self.standard_error[n]
        for at in (self.scaled - reach, self.scaled + reach):
            if np.any(at < low) or np.any(at > high):
                return False
            try:
                rise = 2 * (self.cost(at) - self.least)
            except ValueError:
                return False
            if abs(rise / QUANTILE**2 - 1) > _NEAR_PARABOLA:
                return False
        return True

    def proposal(self) -> Proposal:
        """A density of which posterior draws are made: normal, or along a curved valley."""
        bounds = self.compared.space.bounds
        if self._curved and self.scaled.size > 1:
            share = self.standard_error / np.subtract(*bounds[::-1])
            n = max(self._curved, key=lambda n: float(share[n]))
            ridge = Ridge.along(
                *(n, self.scaled, self.least, self.ends(n), bounds),
                lambda at, guess: self.fitted_beside(n, at, guess),
                lambda x: self.compared.residual_and_jacobian(x)[1],
            )
            if ridge.at.size > 1:
                return ridge
        return of_least_squares(self.cost, self.scaled, self.covariance, bounds)

    def ends(self, n: int) -> tuple[float, float]:
        """The interval by the profile, computed once."""
        if n not in self._profiled:
            self._profiled[n] = self.end(n, -1), self.end(n, 1)
        return self._profiled[n]

    @cached_property
    def _profiled(self) -> dict[int, tuple[float, float]]:
        """Those that were computed, by the places of their parameters."""
        return {}

    def end(self, n: int, side: int) -> float:
        """The end of the interval below (-1) or above (1), in the scale of the parameter.

        The bound where it does not close before, or cannot be followed further.
        """
        best = float(self.scaled[n])
        bound = float(self.compared.space.bounds[side > 0][n])
        farthest = abs(best - bound)
        step = float(self.standard_error[n])
        roots, fitted = {0.0: -QUANTILE}, {0.0: self.scaled}

        def root_less_quantile(distance: float) -> float:
            """Root of what the square rises by, less that at the end of the interval."""
            if distance not in roots:
                # from the last fit that is nearer to the best: one beyond may lie in another valley
                guess = fitted[max(nearer for nearer in fitted if nearer < distance)]
                fitted[distance], cost = self.fitted_beside(n, best + side * distance, guess)
                roots[distance] = float(np.sqrt(max(2 * (cost - self.least), 0.0)) - QUANTILE)
            return roots[distance]

        before = 0.0
        for _ in range(_WIDEST_PROFILE):
            distance = min(before + step, farthest)
            try:
                if root_less_quantile(distance) >= 0:
                    end = brentq(
                        root_less_quantile, before, distance, xtol=1e-12, rtol=_PROFILE_ACCURACY
                    )
                    return best + side * float(end)
            except ValueError:
                step /= 4  # no fit so far away
                continue
            if distance == farthest:
                break
            before, step = distance, 2 * step
        return bound

    def fitted_beside(self, n: int, at: float, guess: Array) -> tuple[Array, float]:
        """All other parameters fitted beside one that is held, and the least cost.

        A ``ValueError`` where the model refuses the guess.
        """
        free = np.arange(guess.size) != n

        def whole(x: Array) -> Array:
            joined = np.empty(guess.size)
            joined[free], joined[n] = x, at
            return joined

        if not free.any():
            return whole(guess[free]), self.cost(whole(guess[free]))
        low, high = self.compared.space.bounds
        inside = np.clip(guess, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
        evaluator = Evaluator(self.compared)
        evaluator.at(whole(inside[free]))
        fit = least_squares(
            lambda x: evaluator.residual(whole(x)),
            inside[free],
            jac=lambda x: evaluator.jacobian(whole(x))[:, free],
            bounds=(low[free], high[free]),
            x_scale="jac",
            loss=self.loss,
            f_scale=self.robust_scale,
            max_nfev=50,
        )
        return whole(fit.x), float(fit.cost)
