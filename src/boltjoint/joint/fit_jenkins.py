"""Fit of a few Jenkins elements to the hysteresis of the many of a region.

The elements of a region see one displacement, so their loops add up. A few elements are sought with
the same total stiffness and the same total slip force, and either the same loops at three
amplitudes (eq. 3.3) or the same describing function at all amplitudes.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 3.1.1.4.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import softmax

from boltjoint import checks
from boltjoint.joint.hysteresis import (
    FitOptions,
    amplitude_of_load,
    checked_elements,
    force_on_loading_curve,
    minimax_loading_curve,
)

Array = NDArray[np.float64]

#: what of the hysteresis is fitted
Method = Literal["loops", "describing-function"]


@dataclass(frozen=True)
class Fit:
    """Elements fitted to those of a region.

    ``tangential_stiffness`` [N/m] and ``slip_force`` [N] have the shape (elements,), ``amplitude``
    [m] that of the loops of eq. 3.3; ``cost`` [N^2] is that equation, minimised or not.
    """

    tangential_stiffness: Array
    slip_force: Array
    amplitude: Array
    cost: float


def fit_elements(
    stiffness: Array,
    slip_force: Array,
    count: int,
    *,
    method: Method = "loops",
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
    options: FitOptions = FitOptions(),
) -> Fit:
    """Fit ``count`` elements to the hysteresis of many.

    ``loops`` minimises the squared force difference over the loops at the amplitudes where the
    region carries ``load_fractions`` of its slip force (eq. 3.3).

    ``describing-function`` minimises the squared difference of the first-harmonic force at all
    amplitudes up to full slip, evenly in their logarithm, over the slip force; its part in phase
    with velocity also over the loss itself where that is small, since small losses limit a
    resonance too. The search starts from minimax loading curves (``nearest_loading_curve``).

    Both are local least squares with the analytic Jacobian. Stiffness and slip force are shares
    (softmax) of the region's totals, so the totals hold and every parameter stays positive.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    count
        Number of elements to fit.
    method
        ``loops`` or ``describing-function``.
    load_fractions
        One for each loop of eq. 3.3, between 0 and 1.
    starts
        Number of deterministic initial guesses of ``loops``, of which the best result is taken.
    options
        What of the hysteresis is compared.

    Returns
    -------
    Fit
        Elements in the order in which they start to slip.

    Raises
    ------
    ValueError
        If the region has fewer than ``count`` elements, a stiffness or slip force is not positive,
        a fraction is not between 0 and 1, or the method is not known.
    """
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    if not 1 <= checks.whole("count", count) <= stiffness.size:
        raise ValueError(
            f"count is {count}: cannot fit {count} elements to the {stiffness.size} of a region"
        )
    fractions = check_fit_options(method, load_fractions, starts)
    checks.instance("options", options, FitOptions)
    amplitude = np.array([amplitude_of_load(f, stiffness, slip_force) for f in fractions])
    loops = LoopMisfit(stiffness, slip_force, amplitude, options.loop_samples)
    shares = rounded_shares(stiffness), rounded_shares(slip_force)
    if method == "loops":
        at = np.array([amplitude_of_load(f, *shares) for f in fractions])
        misfit: LoopMisfit | DescribingFunctionMisfit = LoopMisfit(
            *shares, at, options.loop_samples
        )
        guesses = _guesses_of_loops(*shares, count, starts)
    else:
        weight = options.loss_weight * count**2
        misfit = DescribingFunctionMisfit(*shares, weight, options)
        guesses = _guesses_of_describing_function(*shares, count, options)
    tolerances = {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    best = min(
        (least_squares(misfit.residual, guess, misfit.jacobian, **tolerances) for guess in guesses),
        key=lambda result: result.cost,
    )
    k, s = loops.elements(best.x)
    order = np.argsort(s / k, kind="stable")
    # both halves of a loop are compared in eq. 3.3, one is computed
    difference = loops.residual(best.x)
    cost = 2 * (difference @ difference) * slip_force.sum() ** 2
    return Fit(k[order], s[order], amplitude, float(cost))


def check_fit_options(method: Method, load_fractions: Sequence[float], starts: int) -> Array:
    """Refuse options of a fit; the fractions of the load as an array."""
    checks.choice("method", method, get_args(Method))
    checks.whole("starts", starts, at_least=1)
    return checks.array("load_fractions", load_fractions, ("loops",), above=0, at_most=1)


def rounded_shares(values: Array) -> Array:
    """Shares of the total, to 33 binary digits.

    Regions whose elements differ by a factor and by rounding then have the same fit, where the
    search for it would take another way and end in another of several that are equally good.
    """
    mantissa, exponent = np.frexp(values / values.sum())
    return np.ldexp(np.round(np.ldexp(mantissa, 33)), exponent - 33)


class ElementShares:
    """Elements by unknowns x = (a, b): ``k = K softmax(a)``, ``mu N = S softmax(b)``.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region, whose totals are K and S [N/m], [N],
        shape (many,).
    """

    def __init__(self, stiffness: Array, slip_force: Array) -> None:
        self.total_stiffness, self.total_slip = stiffness.sum(), slip_force.sum()

    def elements(self, unknown: Array) -> tuple[Array, Array]:
        """Stiffness and slip force of the elements, each of shape (elements,)."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def by_unknown(self, k: Array, s: Array, by_k: Array, by_s: Array) -> Array:
        """Derivatives by x from those by stiffness and slip force, by the chain rule."""
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return np.hstack([by_a, by_b])


class LoopMisfit(ElementShares):
    """Force differences between loops of a region and of a few elements, over the slip force.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    amplitude
        Amplitude of the loops [m], shape (loops,).
    samples
        Points along half a loop.
    """

    def __init__(
        self,
        stiffness: Array,
        slip_force: Array,
        amplitude: Array,
        samples: int = FitOptions.loop_samples,
    ) -> None:
        super().__init__(stiffness, slip_force)
        drop = np.outer(amplitude, 1 - np.cos(np.linspace(0, np.pi, samples))) / 2
        # top of the loop less twice the loading curve over half the drop (Masing)
        self.displacement = np.concatenate([amplitude, drop.ravel()])
        top = np.repeat(np.arange(amplitude.size), samples)
        self._combine = np.zeros((top.size, self.displacement.size))
        self._combine[np.arange(top.size), top] = 1.0
        self._combine[np.arange(top.size), amplitude.size + np.arange(top.size)] = -2.0
        self._target = self._combine @ force_on_loading_curve(
            self.displacement, stiffness, slip_force
        )

    def residual(self, unknown: Array) -> Array:
        """Differences along all loops, shape (loops * samples,)."""
        force = self._combine @ force_on_loading_curve(self.displacement, *self.elements(unknown))
        return (force - self._target) / self.total_slip

    def jacobian(self, unknown: Array) -> Array:
        """Their derivatives by the unknowns."""
        k, s = self.elements(unknown)
        sticks = np.multiply.outer(self.displacement, k) < s
        by_k = np.where(sticks, self.displacement[:, None], 0.0)
        by_s = np.where(sticks, 0.0, 1.0)
        return self._combine @ self.by_unknown(k, s, by_k, by_s) / self.total_slip


def _guesses_of_loops(
    stiffness: Array, slip_force: Array, count: int, starts: int
) -> Iterator[Array]:
    """Elements grouped in the order in which they slip, with small groups first or last."""
    order = np.argsort(slip_force / stiffness, kind="stable")
    rank = np.linspace(0, 1, stiffness.size, endpoint=False)
    for bias in np.linspace(0.5, 2.0, starts):
        group = np.floor(count * rank**bias).astype(np.int64)
        k = np.bincount(group, stiffness[order], minlength=count)
        s = np.bincount(group, slip_force[order], minlength=count)
        filled = np.where(k > 0, k, k.max() / stiffness.size), np.where(s > 0, s, s.max() / s.size)
        yield np.log(np.concatenate([filled[0] / k.sum(), filled[1] / s.sum()]))


class DescribingFunctionMisfit(ElementShares):
    """Weighted differences between the describing functions of a region and of a few elements.

    With r = mu N / (k A), a slipping element has k f(r) in phase with displacement and k g(r) with
    velocity, ``f = (theta - sin theta cos theta) / pi``, ``g = 4 r (1 - r) / pi`` (see
    ``friction.constant``).

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    loss_weight
        Weight of relative errors of small losses.
    options
        Amplitudes that are compared, and which losses are small.
    """

    def __init__(
        self,
        stiffness: Array,
        slip_force: Array,
        loss_weight: float,
        options: FitOptions = FitOptions(),
    ) -> None:
        super().__init__(stiffness, slip_force)
        onset = slip_force / stiffness
        self.amplitude = np.geomspace(
            options.lowest_amplitude * onset.min(), onset.max(), options.compared_amplitudes
        )
        self._target = self._describing_function(stiffness, slip_force)
        force = self.amplitude / self.total_slip
        loss = self._target[options.compared_amplitudes :] / self.total_stiffness
        hidden = options.hidden_loss
        small = loss_weight * hidden / (loss + hidden) ** 2 / self.total_stiffness
        self._weight = np.concatenate([force, np.hypot(force, small)])

    def residual(self, unknown: Array) -> Array:
        """Differences in phase with displacement, then with velocity, at all amplitudes."""
        return self.difference(self._describing_function(*self.elements(unknown)))

    def difference(self, describing_function: Array) -> Array:
        """Weighted difference of a describing function, both parts [N/m], from the region's."""
        return self._weight * (describing_function - self._target)

    def jacobian(self, unknown: Array) -> Array:
        """Their derivatives by the unknowns."""
        k, s = self.elements(unknown)
        ratio, sine, f, g = self._of_elements(k, s)
        df, dg = 4 / np.pi * sine, np.where(ratio < 1, 4 / np.pi * (1 - 2 * ratio), 0.0)
        by_k = np.vstack([f - ratio * df, g - ratio * dg])
        by_s = np.vstack([df, dg]) / np.tile(self.amplitude, 2)[:, None]
        return self._weight[:, None] * self.by_unknown(k, s, by_k, by_s)

    def _describing_function(self, k: Array, s: Array) -> Array:
        _, _, f, g = self._of_elements(k, s)
        return np.concatenate([f @ k, g @ k])

    def _of_elements(self, k: Array, s: Array) -> tuple[Array, ...]:
        """r, sin theta, f and g of every element at every amplitude."""
        ratio = np.minimum(s / np.outer(self.amplitude, k), 1.0)
        sine = 2 * np.sqrt(ratio * (1 - ratio))
        theta = 2 * np.arctan2(np.sqrt(ratio), np.sqrt(1 - ratio))
        return ratio, sine, (theta - sine * (1 - 2 * ratio)) / np.pi, sine * sine / np.pi


def _guesses_of_describing_function(
    stiffness: Array, slip_force: Array, count: int, options: FitOptions = FitOptions()
) -> Iterator[Array]:
    """Minimax loading curves with more or less weight on small amplitudes."""
    for sharpness in options.sharpnesses:
        k, s, _ = minimax_loading_curve(
            stiffness, slip_force, count, sharpness, hidden_loss=options.hidden_loss
        )
        yield np.log(np.concatenate([k / k.sum(), s / s.sum()]))
