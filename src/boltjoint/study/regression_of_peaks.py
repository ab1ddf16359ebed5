"""Peaks with all harmonics of many designs from those of some, by regression.

A peak with all harmonics takes more than ten times as long as one with one harmonic. What harmonics
change is a smooth function of the design and of its peak with one, but where a superharmonic
resonance begins. Some designs spread over all tell it, and leaving out a fifth of these at a time
tells how well.

References
----------
A. Forrester, A. Sobester, A. Keane: Multi-fidelity optimization via surrogate modelling.
Proceedings of the Royal Society A 463 (2007) 3251-3269.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.linalg import qr
from scipy.optimize import minimize

from boltjoint import checks
from boltjoint.config.sweep import LEAST_BY_VARIABLE
from boltjoint.dataset import quantity
from boltjoint.options import CONVERGING
from boltjoint.structure.model_limits import LIMITS
from boltjoint.study.designs import varied
from boltjoint.study.errors_of_sweep import QUANTITIES

Array = NDArray[np.float64]

_SEED = 1
#: parts of the solved designs, each of which is predicted by the others
_FOLDS = 5
#: of weights, which need not be exact
_SEARCH = {"maxfev": 300, "xatol": 0.1, "fatol": np.inf}
#: first step of their logarithms
_FIRST = 1.0
#: share of the errors of designs that were left out within the one that is told
_WITHIN = 0.95
#: of the radial basis functions: the smoothest through all designs but for their roughness, which
#: lets two of them be the same
_KERNEL, _SMOOTHING = "thin_plate_spline", 1e-3
#: part of a variable that does not follow from others, over the largest: below it is rounding
_DEPENDENT = 1e-6

logger = logging.getLogger(__name__)


def spread_designs(designs: xr.Dataset, number: int | None) -> NDArray[np.bool_]:
    """Which designs are taken, shape (designs,): so many of the possible ones, spread over all.

    Each is the one farthest from those before, so that no part of the designs is without any.

    Parameters
    ----------
    designs
        As from ``list_designs``.
    number
        How many of the possible designs; all, if there are not more, or with None.
    """
    possible = np.flatnonzero(designs["reason"].to_numpy() == "")
    taken = np.zeros(designs["reason"].size, bool)
    if number is None or number >= possible.size:
        taken[possible] = True
        return taken
    values = np.column_stack([_scaled(designs[name].to_numpy()) for name in varied(designs)])
    values = values[possible]
    # the first is the one in the middle
    chosen = int(np.argmin(np.linalg.norm(values, axis=1)))
    distance = np.full(possible.size, np.inf)
    # where several designs are the same there are fewer
    for _ in range(number):
        taken[possible[chosen]] = True
        distance = np.minimum(distance, np.linalg.norm(values - values[chosen], axis=1))
        chosen = int(np.argmax(distance))
    return taken


def harmonics_of_designs(
    designs: xr.Dataset, numbers: Mapping[int, int] | None
) -> NDArray[np.int64]:
    """Highest harmonic with which each design is solved, shape (designs,), 0 with one only.

    Parameters
    ----------
    designs
        As from ``list_designs``.
    numbers
        Of how many designs, by the highest harmonic, which ascends while they do not: those with
        more harmonics are among those with fewer. All possible ones with None.
    """
    if numbers is None:
        return np.where(spread_designs(designs, None), CONVERGING[-1], 0)
    highest = np.zeros(designs["reason"].size, np.int64)
    for harmonics, number in sorted(numbers.items()):
        highest[spread_designs(designs, number)] = harmonics
    return highest


def is_predicted(designs: xr.Dataset, highest: NDArray[np.int64], chunk: range) -> xr.Variable:
    """Which designs of a chunk are possible and not among those with most harmonics.

    ``highest``: as from ``harmonics_of_designs``.
    """
    possible = designs["reason"].to_numpy() == ""
    rows = (possible & (highest < highest.max()))[chunk.start : chunk.stop].astype(np.int8)
    meaning = "1 where peaks with all harmonics follow from those of other designs"
    return quantity("design", rows, "1", meaning)


def with_predicted_peaks(sweep: xr.Dataset, values: Iterable[Array]) -> xr.Dataset:
    """A sweep with the peaks with all harmonics of designs whose peaks are to be predicted.

    Where fewer designs are solved with more harmonics, each number of these is predicted from the
    peaks with the number before.

    Parameters
    ----------
    sweep
        By ``design`` and ``force``, with ``is_predicted`` and, by ``harmonics`` too, the peaks
        ``harmonic_peak_frequency`` and ``harmonic_peak_amplitude`` of designs that are solved.
    values
        Of each quantity that varies, by design, and what the peaks depend on most: beside the keys
        of ``three_bolt_uncertainty`` the slip force over the excitation halves the errors.

    Returns
    -------
    Dataset
        With the peaks of all designs that have one with one harmonic, shares of limits by these
        amplitudes, and by ``force`` ``peak_frequency_regression_error`` and
        ``peak_amplitude_regression_error``: 95 % of the relative errors of designs that were left
        out lie within, those of several numbers of harmonics one after another; not a number where
        too few were solved.
    """
    checks.instance("sweep", sweep, xr.Dataset)
    along = "design", "force"
    single = {what: sweep[f"peak_{what}"].transpose(*along) for what in QUANTITIES}
    solved = {
        what: sweep[f"harmonic_peak_{what}"].transpose(*along, "harmonics").to_numpy()
        for what in QUANTITIES
    }
    names = {what: f"peak_{what}_converged" for what in QUANTITIES}
    peaks = {what: sweep[name].transpose(*along).copy() for what, name in names.items()}
    predicted = sweep["is_predicted"].to_numpy().astype(bool)
    errors = {what: np.full(sweep.sizes["force"], np.nan) for what in QUANTITIES}
    of_design = [_scaled(column) for column in values]
    for level in range(sweep.sizes["force"]):
        single_peaks: dict[str, Array] = {
            what: peak.to_numpy()[:, level] for what, peak in single.items()
        }
        of_level: dict[str, Array] = {what: each[:, level] for what, each in solved.items()}
        try:
            found, within = _with_more_harmonics(of_design, single_peaks, of_level)
        except _TooFew as error:
            logger.warning("level %d: %s", level + 1, error)
            continue
        for what, peak in peaks.items():
            peak[predicted, level] = found[what][predicted]
            errors[what][level] = within[what]
    ratio = (peaks["amplitude"] / single["amplitude"]).where(predicted[:, None], 1.0).fillna(1.0)
    limits = [f"peak_{limit.name}" for limit in LIMITS if f"peak_{limit.name}" in sweep]
    return sweep.assign(
        {names[what]: peak for what, peak in peaks.items()}
        | {name: (sweep[name] * ratio).assign_attrs(sweep[name].attrs) for name in limits}
        | {
            f"peak_{what}_regression_error": quantity(
                "force",
                *(error, "1", f"95 % of the relative errors of a predicted {what} lie within"),
            )
            for what, error in errors.items()
        }
    )


class _TooFew(Exception):
    """Too few designs are solved."""


def _with_more_harmonics(
    of_design: Sequence[Array], peaks: Mapping[str, Array], solved: Mapping[str, Array]
) -> tuple[Mapping[str, Array], dict[str, float]]:
    """Peaks of all designs with most harmonics, and their relative errors.

    Parameters
    ----------
    of_design
        What varies, by design.
    peaks
        Frequencies and amplitudes with one harmonic, by design.
    solved
        With more, shape (designs, numbers of harmonics); not a number where they are not solved.
    """
    within = dict.fromkeys(peaks, 1.0)
    for step in range(solved["amplitude"].shape[1]):
        known_peaks = {what: each[:, step] for what, each in solved.items()}
        variables = np.column_stack([*of_design, *(_scaled(peak) for peak in peaks.values())])
        has_peak = np.isfinite(variables).all(axis=1)
        known = has_peak & np.isfinite(known_peaks["amplitude"])
        wanted, next_peaks = has_peak & ~known, {}
        if not wanted.any():
            peaks = known_peaks
            continue
        if known.sum() < LEAST_BY_VARIABLE * variables.shape[1]:
            raise _TooFew(
                f"{known.sum()} designs have a peak with more harmonics, too few to predict that "
                "of others: more converged_designs are needed"
            )
        for what, peak in peaks.items():
            change = np.log(known_peaks[what][known] / peak[known])
            regression = _Regression(variables[known], change)
            next_peaks[what] = np.where(known, known_peaks[what], np.nan)
            next_peaks[what][wanted] = peak[wanted] * np.exp(regression(variables[wanted]))
            within[what] *= 1 + _error(regression, variables[known], change)
        peaks = next_peaks
    return peaks, {what: factor - 1 for what, factor in within.items()}


def _scaled(values: Array) -> Array:
    """Values with the mean 0 and the deviation 1, of their logarithms where all are positive."""
    known = values[np.isfinite(values)]
    if known.size and known.min() > 0:
        values, known = np.log(values), np.log(known)
    spread = known.std() if known.size else 0.0
    return (values - known.mean()) / spread if spread else np.zeros(values.shape)


class _Regression:
    """Change by variables, which weigh so that designs left out are predicted best."""

    def __init__(self, variables: Array, change: Array) -> None:
        self._variables, self._change = variables, change
        start = np.zeros(variables.shape[1])
        simplex = np.vstack([start, _FIRST * np.eye(start.size)])
        search = {**_SEARCH, "initial_simplex": simplex}
        found = minimize(self._sum_of_squares, start, method="Nelder-Mead", options=search)
        self._weight = np.exp(found.x)
        self._fitted = _through(variables * self._weight, change)

    def __call__(self, variables: Array) -> Array:
        """Predicted change."""
        return self._fitted(variables * self._weight)

    def errors(self, weight: Array | None = None) -> Array:
        """Errors of designs that the others predict."""
        weighted = self._variables * (self._weight if weight is None else weight)
        errors = np.empty(len(self._change))
        for fold in _folds(len(errors)):
            predicted = _through(weighted[~fold], self._change[~fold])(weighted[fold])
            errors[fold] = predicted - self._change[fold]
        return errors

    def _sum_of_squares(self, log_weight: Array) -> float:
        errors = self.errors(np.exp(log_weight))
        return float(errors @ errors)


def _through(variables: Array, change: Array) -> Callable[[Array], Array]:
    """Radial basis functions of the variables that do not follow from each other."""
    triangle, order = qr(variables - variables.mean(axis=0), mode="r", pivoting=True)
    size = abs(np.diag(triangle))
    kept = order[: np.count_nonzero(size > _DEPENDENT * size.max(initial=0.0))]
    if not kept.size:
        return lambda at: np.full(len(at), change.mean())
    own = variables[:, kept]
    fitted = RBFInterpolator(own, change, smoothing=_SMOOTHING, kernel=_KERNEL, degree=1)
    return lambda at: np.asarray(fitted(at[:, kept]), float) if len(at) else np.zeros(0)


def _folds(count: int) -> Iterator[NDArray[np.bool_]]:
    """Parts of some designs, drawn at random."""
    fold = np.random.default_rng(_SEED).permutation(count) % _FOLDS
    return (fold == part for part in range(_FOLDS))


def _error(regression: _Regression, variables: Array, change: Array) -> float:
    """Relative error of peaks, within which those of designs that were left out lie.

    Its weights are chosen without these too: the larger of both counts.
    """
    errors = np.empty((2, len(change)))
    errors[0] = regression.errors()
    for left_out in _folds(len(change)):
        without = _Regression(variables[~left_out], change[~left_out])
        errors[1, left_out] = without(variables[left_out]) - change[left_out]
    return float(np.quantile(abs(np.expm1(errors)), _WITHIN, axis=1).max())
