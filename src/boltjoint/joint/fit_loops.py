"""Least-squares fit of few Jenkins elements to the hysteresis loops of many."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import softmax

from boltjoint import checks
from boltjoint.joint.fit_describing_function import DescribingFunctionMisfit
from boltjoint.joint.masing import (
    Fit,
    Method,
    amplitude_of_load,
    check_fit_options,
    checked_elements,
    force_on_loading_curve,
)
from boltjoint.joint.minimax_curve import nearest_loading_curve

#: points along each loop at which forces are compared, evenly in phase over half a period
_SAMPLES = 64


#: weight of relative errors of such small losses, against errors of force over the slip force;
#: times the square of the number of elements, by whose inverse errors of force fall
_LOSS_WEIGHT = 0.0023


#: how much the starts of the search favour small amplitudes, the less the larger
_SHARPNESS = (8.0, 16.0, 32.0, 128.0)


def fit_elements(
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    count: int,
    *,
    method: Method = "loops",
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
) -> Fit:
    """Find ``count`` elements with the hysteresis of many.

    ``loops`` minimises the squared force difference over the loops at the amplitudes where the
    region carries ``load_fractions`` of its slip force (eq. 3.3).

    ``describing-function`` minimises the squared difference of the first-harmonic force at all
    amplitudes up to full slip, evenly in their logarithm, over the slip force; its part in phase
    with velocity also over the loss itself where that is small, since small losses limit a
    resonance too. The search starts from the nearest loading curves (``nearest_loading_curve``).

    Both are least squares with the exact Jacobian, and local. Stiffness and slip force are shares
    (softmax) of the region's totals, so the totals hold and every parameter is positive wherever
    the search goes.

    Parameters
    ----------
    stiffness, slip_force
        Of the elements of a region [N/m], [N], shape (many,).
    count
        Number of elements to fit.
    method
        ``loops`` or ``describing-function``.
    load_fractions
        One for each loop of eq. 3.3, between 0 and 1.
    starts
        Number of deterministic starts of ``loops``, of which the best result is taken.

    Returns
    -------
    Fit
        Elements in the order in which they start to slip.

    Raises
    ------
    ValueError
        If fewer than ``count`` elements are there to be replaced, a stiffness or slip force is not
        positive, a fraction is not between 0 and 1, or the method is not known.
    """
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    if not 1 <= checks.whole("count", count) <= stiffness.size:
        raise ValueError(
            f"count is {count}: cannot fit {count} elements to the {stiffness.size} of a region"
        )
    load_fractions = check_fit_options(method, load_fractions, starts)
    amplitude = np.array([amplitude_of_load(f, stiffness, slip_force) for f in load_fractions])
    loops = LoopMisfit(stiffness, slip_force, amplitude)
    if method == "loops":
        problem = loops
        begin = _starts(stiffness, slip_force, count, starts)
    else:
        problem = DescribingFunctionMisfit(stiffness, slip_force, _LOSS_WEIGHT * count**2)
        begin = _near_starts(stiffness, slip_force, count)
    best = min(
        (
            least_squares(
                problem.residual, start, problem.jacobian, xtol=1e-12, ftol=1e-12, gtol=1e-12
            )
            for start in begin
        ),
        key=lambda result: result.cost,
    )
    k, s = loops.elements(best.x)
    order = np.argsort(s / k, kind="stable")
    # both halves of a loop are compared in eq. 3.3, one is computed
    difference = loops.residual(best.x)
    cost = 2 * (difference @ difference) * slip_force.sum() ** 2
    return Fit(k[order], s[order], amplitude, float(cost))


class LoopMisfit:
    """Force differences between loops of a region and of a few elements, over the slip force."""

    def __init__(
        self,
        stiffness: NDArray[np.float64],
        slip_force: NDArray[np.float64],
        amplitude: NDArray[np.float64],
    ) -> None:
        self.total_stiffness, self.total_slip = stiffness.sum(), slip_force.sum()
        drop = np.outer(amplitude, 1 - np.cos(np.linspace(0, np.pi, _SAMPLES))) / 2
        # top of the loop less twice the loading curve over half the drop (Masing)
        self.displacement = np.concatenate([amplitude, drop.ravel()])
        top = np.repeat(np.arange(amplitude.size), _SAMPLES)
        self._combine = np.zeros((top.size, self.displacement.size))
        self._combine[np.arange(top.size), top] = 1.0
        self._combine[np.arange(top.size), amplitude.size + np.arange(top.size)] = -2.0
        self._target = self._combine @ force_on_loading_curve(
            self.displacement, stiffness, slip_force
        )

    def elements(
        self, unknown: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and slip force of the elements from the logarithms of their shares."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def residual(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        force = self._combine @ force_on_loading_curve(self.displacement, *self.elements(unknown))
        return (force - self._target) / self.total_slip

    def jacobian(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        k, s = self.elements(unknown)
        sticks = np.multiply.outer(self.displacement, k) < s
        by_k = np.where(sticks, self.displacement[:, None], 0.0)
        by_s = np.where(sticks, 0.0, 1.0)
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return self._combine @ np.hstack([by_a, by_b]) / self.total_slip


def _starts(
    stiffness: NDArray[np.float64], slip_force: NDArray[np.float64], count: int, starts: int
) -> Iterator[NDArray[np.float64]]:
    """Elements grouped in the order in which they slip, in ways that favour early or late ones."""
    order = np.argsort(slip_force / stiffness, kind="stable")
    rank = np.linspace(0, 1, stiffness.size, endpoint=False)
    for bias in np.linspace(0.5, 2.0, starts):
        group = np.floor(count * rank**bias).astype(np.int64)
        k = np.bincount(group, stiffness[order], minlength=count)
        s = np.bincount(group, slip_force[order], minlength=count)
        filled = np.where(k > 0, k, k.max() / stiffness.size), np.where(s > 0, s, s.max() / s.size)
        yield np.log(np.concatenate([filled[0] / k.sum(), filled[1] / s.sum()]))


def _near_starts(
    stiffness: NDArray[np.float64], slip_force: NDArray[np.float64], count: int
) -> Iterator[NDArray[np.float64]]:
    """Nearest loading curves that favour small amplitudes more or less."""
    for sharpness in _SHARPNESS:
        k, s, _ = nearest_loading_curve(stiffness, slip_force, count, sharpness)
        yield np.log(np.concatenate([k / k.sum(), s / s.sum()]))
