"""Result of a calibration: parameters, how well they are determined, and predictive bands."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from boltjoint import checks
from boltjoint.calibration.ensemble_walk import EnsembleDraws, ensemble_draws
from boltjoint.calibration.measured_backbone import Measurement, curves_of
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.posterior_draws import ImportanceDraws, importance_draws
from boltjoint.calibration.prediction import PredictedCurve, predict_curves
from boltjoint.calibration.profile import Profiles
from boltjoint.calibration.residual_checks import CurveCheck, check_curve

Array = NDArray[np.float64]

#: singular values of the Jacobian, over the largest, below which a direction is not determined
_SMALLEST_SINGULAR = 1e-10

#: a fit at a bound is within this share of its width
_AT_BOUND = 1e-3


class Undetermined(ValueError):
    """A parameter that the measurement does not tell."""


@dataclass(frozen=True)
class Calibration:
    """Parameters that were fitted, their uncertainty, and the curves of the model.

    Standard errors are those that the stated deviations of the measurement make. ``value`` refuses
    parameters that are not determined.

    Attributes
    ----------
    compared
        Model and measurement.
    scaled
        Parameters in their scales at the least sum of squares.
    costs
        Half the sum of squares at the end of each start; infinite where it could not be solved.
    loss, robust_scale
        The loss of the fit and its scale.
    determined_share
        As of ``CalibrationOptions``.
    """

    compared: ModelCurves
    scaled: Array
    costs: Array
    loss: str
    robust_scale: float
    determined_share: float

    def __post_init__(self) -> None:
        """Refuse what is none of a fit."""
        checks.instance("compared", self.compared, ModelCurves)
        checks.array("scaled", self.scaled, (len(self.names),))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return self.compared.space.names

    @property
    def best_values(self) -> dict[str, float]:
        """Values at the least sum of squares, of all parameters, determined or not."""
        return self.compared.space.values(self.scaled)

    @cached_property
    def residual_and_jacobian(self) -> tuple[Array, Array]:
        """In standard deviations, at the least sum of squares."""
        return self.compared.residual_and_jacobian(self.scaled)

    @cached_property
    def covariance_root(self) -> Array:
        """A matrix whose product with its transpose is the covariance."""
        _, jacobian = self.residual_and_jacobian
        _, s, Vt = np.linalg.svd(jacobian, full_matrices=False)
        return Vt.T / np.maximum(s, _SMALLEST_SINGULAR * s[0])

    @property
    def covariance(self) -> Array:
        """Of the parameters in their scales; directions that nothing determines have no limit."""
        return self.covariance_root @ self.covariance_root.T

    @property
    def standard_error(self) -> Array:
        """Of each parameter in its scale."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """Of the parameters."""
        error = self.standard_error
        return self.covariance / np.outer(error, error)

    @cached_property
    def condition(self) -> float:
        """Condition number of the Jacobian whose columns have unit length."""
        _, jacobian = self.residual_and_jacobian
        length = np.linalg.norm(jacobian, axis=0)
        return float(np.linalg.cond(jacobian / np.where(length > 0, length, 1.0)))

    @cached_property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters whose interval is as wide as half of the bounds, or that ends at one."""
        low, high = self.compared.space.bounds
        ends = self._profiles.intervals.T
        wide = np.ptp(ends, axis=0) > self.determined_share * (high - low)
        names = zip(self.names, wide | _is_at_bound(ends, low, high).any(axis=0), strict=True)
        return tuple(name for name, is_open in names if is_open)

    def value(self, name: str) -> float:
        """A parameter that is determined.

        Raises
        ------
        Undetermined
            If the measurement does not tell it.
        ValueError
            If there is none of this name.
        """
        checks.choice("parameter", name, self.names)
        if name in self.undetermined:
            raise Undetermined(f"{name} cannot be told by this measurement: {self.reason(name)}")
        return self.best_values[name]

    def interval(self, name: str) -> tuple[float, float]:
        """95 % interval of a parameter; refused as ``value`` is.

        By the covariance where the sum of squares is the parabola that it stands for, else by the
        profile.
        """
        self.value(name)
        n = self.names.index(name)
        parameter = self.compared.space.parameters[n]
        low, high = (parameter.value(end) for end in self._profiles.intervals[n])
        return low, high

    def reason(self, name: str) -> str:
        """In words, why a parameter is not determined; empty where it is."""
        checks.choice("parameter", name, self.names)
        if name not in self.undetermined:
            return ""
        return _reason(self, self.names.index(name), self._profiles.intervals)

    def profile(self, name: str) -> tuple[float, float]:
        """95 % interval by the profile likelihood: all others are fitted anew beside the parameter.

        Returns
        -------
        tuple
            An end is that of the bounds where the profile does not close before.
        """
        checks.choice("parameter", name, self.names)
        n = self.names.index(name)
        parameter = self.compared.space.parameters[n]
        low, high = (parameter.value(end) for end in self._profiles.ends(n))
        return low, high

    @cached_property
    def _profiles(self) -> Profiles:
        return Profiles(self.compared, self.scaled, self.loss, self.robust_scale, self.covariance)

    def draws(self, count: int = 400, seed: int = 1, processes: int = 1) -> ImportanceDraws:
        """Posterior draws: an approximation, resampled by the true sum of squares.

        It is normal where the sum of squares is a parabola, else one along a curved valley
        (``ridge``). The prior is uniform within the bounds, in the scale of each parameter, times
        stated priors. ``processes`` share them, with the same results.
        """
        checks.whole("processes", processes, above=0)
        count = checks.whole("count", count, at_least=20)
        seed = checks.whole("seed", seed, at_least=0)
        bounds = self.compared.space.bounds
        profiles = self._profiles
        return importance_draws(profiles.cost, profiles.proposal(), bounds, count, seed, processes)

    def walk(self, count: int = 4000, seed: int = 1) -> EnsembleDraws:
        """Draws by walkers (emcee), where Pareto k is too large: twice as many evaluations.

        Raises
        ------
        ValueError
            If an argument is out of range, or emcee is not installed.
        """
        count = checks.whole("count", count, at_least=400)
        seed = checks.whole("seed", seed, at_least=0, at_most=2**32 - 1)
        of_space = self.scaled, self.standard_error, self.compared.space.bounds
        return ensemble_draws(self._profiles.cost, *of_space, count, seed)

    def predict(
        self,
        measured: Sequence[Measurement] | Measurement,
        count: int = 400,
        seed: int = 1,
        processes: int = 1,
        drawn: Array | None = None,
    ) -> tuple[PredictedCurve, ...]:
        """Curves that were held aside from the fit, with 95 % bands by posterior draws.

        Parameters
        ----------
        measured
            Of other modes, sensors or amplitudes of the same joint; ``amplitude_scale`` multiplies
            theirs too.
        count, seed, processes
            Of the draws; processes share them, with the same results.
        drawn
            Parameters in their scales in place of these draws, as of ``walk``, (draws, parameters).

        Raises
        ------
        ValueError
            If an argument is out of range, a mode is not in the model, or no process can be forked.
        """
        checks.whole("processes", processes, above=0)
        compared = replace(self.compared, measured=curves_of(measured))
        if drawn is None:
            drawn = self.draws(count, seed, processes).scaled
        drawn = checks.array("drawn", drawn, ("draws", len(self.names)))
        return predict_curves(compared, self.scaled, drawn, seed, processes)

    def curves(self, amplitudes: Sequence[Array] | None = None) -> list[Array]:
        """Values of each curve, (points, quantities), at measured amplitudes.

        Frequency [Hz] and damping ratio of a backbone; those of ``MeasuredResponse.values``.
        """
        return list(self._curves if amplitudes is None else self._curves_at(amplitudes))

    @cached_property
    def _curves(self) -> list[Array]:
        return self._curves_at()

    def _curves_at(self, amplitudes: Sequence[Array] | None = None) -> list[Array]:
        points = self.compared.curves_at(self.scaled, amplitudes, slopes=False)
        return [curves for curves, _ in points]

    def bands(self, amplitudes: Sequence[Array] | None = None) -> list[Array]:
        """Standard deviation of the values of each curve by that of the parameters.

        The scatter of a new measurement is not in it.
        """
        points = self.compared.curves_at(self.scaled, amplitudes)
        return [np.linalg.norm(slopes @ self.covariance_root, axis=-1) for _, slopes in points]

    @property
    def rms_errors(self) -> list[tuple[float, ...]]:
        """Root mean square of the errors of each curve by its quantities, of phases in rad."""
        pairs = zip(self.compared.measured, self.curves(), strict=True)
        return [curve.rms_errors(model) for curve, model in pairs]

    @cached_property
    def checks_of_curves(self) -> tuple[CurveCheck, ...]:
        """Of each curve, whether the model can be right."""
        pairs = zip(self.compared.measured, self.curves(), strict=True)
        return tuple(check_curve(curve, curves) for curve, curves in pairs)

    @property
    def p_value(self) -> float:
        """Probability of so large a sum of squares if the model and its deviations are right."""
        residual, _ = self.residual_and_jacobian
        freedom = max(residual.size - self.scaled.size, 1)
        return float(chi2.sf(residual @ residual, freedom))

    @property
    def refusals(self) -> tuple[str, ...]:
        """Why the model cannot be right, a sentence each; empty where nothing speaks against it."""
        return tuple(sentence for check in self.checks_of_curves for sentence in check.sentences)

    def summary(self) -> str:
        """All of it in words, what the model cannot be first."""
        return "\n".join(_sentences(self))


def _in_words(curve: Measurement, errors: Sequence[float]) -> str:
    """Errors of a curve, by its quantities."""
    pairs = zip(errors, curve.quantities, strict=True)
    told = [
        f"{error:.2g} rad rms in phase" if of == "phase" else f"{error:.2g} rms in {of}, relative"
        for error, of in pairs
    ]
    return " and ".join(told)


def _reason(calibration: Calibration, n: int, intervals: Array) -> str:
    """Why a parameter is not determined, by its place and the intervals of all, in their scales."""
    space, scaled, name = calibration.compared.space, calibration.scaled, calibration.names[n]
    parameter, middle = space.parameters[n], sum(bound[n] for bound in space.bounds) / 2
    for word, at in (
        ("the best fit lies at", scaled[n]),
        ("its 95 % interval ends at", intervals[n, 0]),
        ("its 95 % interval ends at", intervals[n, 1]),
    ):
        if _is_at_bound(at, *(bound[n] for bound in space.bounds)):
            bound = parameter.low if at < middle else parameter.high
            return f"{word} its bound {bound:.4g}"
    others = np.delete(abs(calibration.correlation[n]), n)
    names = [other for other in calibration.names if other != name]
    told = ""
    if others.size and others.max() > 0.95:
        told = f", it goes with {names[int(np.argmax(others))]}"
    share = 100 * calibration.determined_share
    return f"its 95 % interval is wider than {share:g} % of its bounds{told}"


def _is_at_bound(scaled: Array, low: Array, high: Array) -> NDArray[np.bool_]:
    """Whether parameters in their scales lie at a bound or beyond."""
    return np.minimum(scaled - low, high - scaled) < _AT_BOUND * (high - low)


def _sentences(calibration: Calibration) -> list[str]:
    """What cannot be, parameters with their intervals, and errors of each curve."""
    lines = [f"The model cannot be right: {sentence}." for sentence in calibration.refusals]
    for name, value in calibration.best_values.items():
        if name in calibration.undetermined:
            lines.append(f"{name} cannot be told: {calibration.reason(name)}.")
        else:
            low, high = calibration.interval(name)
            lines.append(f"{name} = {value:.4g} (95 %: {low:.4g} to {high:.4g})")
    for curve, errors in zip(calibration.compared.measured, calibration.rms_errors, strict=True):
        lines.append(f"{curve.name}: {_in_words(curve, errors)}")
    return lines
