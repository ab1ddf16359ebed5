"""How few elements show the hysteresis of many? Fitting reduced joints (section 3.1.1.4).

The elements of a region see one displacement, so their loops add up. A few elements are sought with
the same total stiffness and the same total slip force, and either the same loops at three
amplitudes or the same first harmonics at all of them. A table of those harmonics stands for any
number of elements.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import softmax

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint import Joint

#: what of the hysteresis is to agree
Method = Literal["loops", "describing-function"]

#: points along each loop at which forces are compared, evenly in phase over half a period
_SAMPLES = 64

#: amplitudes at which harmonics are compared, and at which loops are when a fit is judged
_AMPLITUDES = 120

#: lowest of them where harmonics are compared, over that of the first slip: a fit must not slip
#: before the region does
_LOWEST = 0.8

#: loss, over the total stiffness, below which the structure's own damping hides the contact's
_HIDDEN_LOSS = 1e-3

#: weight of relative errors of such small losses, against errors of force over the slip force;
#: times the square of the number of elements, by whose inverse errors of force fall
_LOSS_WEIGHT = 0.0023

#: how much the starts of the search favour small amplitudes, the less the larger
_SHARPNESS = (8.0, 16.0, 32.0, 128.0)

#: corners of a loading curve are one if they differ by less than this share: rounding
_SAME_CORNER = 1e-9


@dataclass(frozen=True)
class Fit:
    """A few elements that stand for many.

    ``tangential_stiffness`` [N/m] and ``slip_force`` [N] have the shape (elements,), ``amplitude``
    [m] that of the loops of eq. 3.3; ``cost`` [N^2] is that equation, minimised or not.
    """

    tangential_stiffness: NDArray[np.float64]
    slip_force: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    cost: float


def loading_curve(
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Force of elements in parallel on first loading by ``displacement`` [N], of its shape."""
    displacement = checks.array("displacement", displacement)
    return _loading_curve(displacement, *_elements("stiffness", stiffness, slip_force))


def _loading_curve(
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    stuck = np.multiply.outer(displacement, stiffness)
    return np.minimum(stuck, slip_force).sum(axis=-1)


def unloading_branch(
    amplitude: float,
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Force on the way from ``amplitude`` down to ``displacement`` in the steady loop [N].

    Masing's rule: the branch is the loading curve, twice as large and turned around. The other half
    of the loop is the same with both signs changed.
    """
    amplitude = checks.number("amplitude", amplitude, above=0)
    displacement = checks.array(
        "displacement", displacement, at_least=-amplitude, at_most=amplitude
    )
    stiffness, slip_force = _elements("stiffness", stiffness, slip_force)
    top = _loading_curve(np.array(amplitude), stiffness, slip_force)
    return top - 2 * _loading_curve((amplitude - displacement) / 2, stiffness, slip_force)


def amplitude_of_load(
    fraction: float, stiffness: NDArray[np.float64], slip_force: NDArray[np.float64]
) -> float:
    """Displacement [m] at which first loading reaches a fraction of the total slip force."""
    fraction = checks.number("fraction", fraction, above=0, at_most=1)
    stiffness, slip_force = _elements("stiffness", stiffness, slip_force)
    corners = np.append(0.0, np.sort(slip_force / stiffness))
    load = _loading_curve(corners, stiffness, slip_force)
    return float(np.interp(fraction * slip_force.sum(), load, corners))


@dataclass(frozen=True)
class LoopError:
    """Force differences between loops over the total slip force: largest, and root mean square."""

    largest: float
    rms: float


def loop_error(
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    fitted_stiffness: NDArray[np.float64],
    fitted_slip_force: NDArray[np.float64],
) -> LoopError:
    """How far the loops of fitted elements are from those of a region, at all amplitudes.

    Parameters
    ----------
    stiffness, slip_force
        Of the elements of a region [N/m], [N], shape (many,).
    fitted_stiffness, fitted_slip_force
        Of those that stand for them, with the same total slip force, shape (few,).

    Returns
    -------
    LoopError
        The largest of all loops, exact; and the mean over amplitudes from that of the first slip to
        that of full slip, evenly in their logarithm, and over the loop, evenly in phase.

    Raises
    ------
    ValueError
        If stiffnesses and slip forces differ in number or are not positive.
    """
    stiffness, slip_force = _elements("stiffness", stiffness, slip_force)
    fitted_stiffness, fitted_slip_force = _elements(
        "fitted_stiffness", fitted_stiffness, fitted_slip_force
    )
    onset = slip_force / stiffness
    corner = np.unique(np.concatenate([[0.0], onset, fitted_slip_force / fitted_stiffness]))
    few = _loading_curve(corner, fitted_stiffness, fitted_slip_force)
    difference = (few - _loading_curve(corner, stiffness, slip_force)) / slip_force.sum()
    # d(A) - 2 d(v) with v up to A (Masing) is linear in both between corners
    above = difference - 2 * np.minimum.accumulate(difference)
    below = 2 * np.maximum.accumulate(difference) - difference
    amplitude = np.geomspace(onset.min(), onset.max(), _AMPLITUDES)
    phase = np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    half_drop = np.outer(amplitude, (1 - np.cos(phase)) / 2)
    top = np.interp(amplitude, corner, difference)[:, None]
    along = top - 2 * np.interp(half_drop, corner, difference)
    return LoopError(float(max(above.max(), below.max())), float(np.sqrt(np.mean(along**2))))


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
    stiffness, slip_force = _elements("stiffness", stiffness, slip_force)
    if not 1 <= checks.whole("count", count) <= stiffness.size:
        raise ValueError(
            f"count is {count}: cannot fit {count} elements to the {stiffness.size} of a region"
        )
    load_fractions = _check_options(method, load_fractions, starts)
    amplitude = np.array([amplitude_of_load(f, stiffness, slip_force) for f in load_fractions])
    loops = _Loops(stiffness, slip_force, amplitude)
    if method == "loops":
        problem = loops
        begin = _starts(stiffness, slip_force, count, starts)
    else:
        problem = _Harmonics(stiffness, slip_force, _LOSS_WEIGHT * count**2)
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


def nearest_loading_curve(
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    count: int,
    sharpness: float = np.inf,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """The ``count`` elements whose loading curve is nearest to that of many: no others are nearer.

    With F the region's curve and K its total stiffness, the largest ratio of the difference to
    ``min(F, sharpness (K u - F + K u / 1000))`` is minimised: the relative error of force, and
    where little slips that of the force lost by slip. Loading curves are concave and piecewise
    linear, and one with the fewest corners between two bounds follows each line as far as it goes:
    until it meets the upper bound, and from there along the tangent to the lower one. The bounds
    are brought together until there are as many corners as elements.

    Parameters
    ----------
    stiffness, slip_force
        Of the elements of a region [N/m], [N], shape (many,).
    count
        Number of elements.
    sharpness
        The smaller, the more small amplitudes count. The result is the nearest where the ratio
        found is below its inverse, so that the upper bound is concave.

    Returns
    -------
    stiffness, slip_force : ndarray
        In the order in which the elements slip [N/m], [N], shape (count,).
    ratio : float
        The largest ratio.

    Raises
    ------
    ValueError
        If a stiffness or slip force, the number or the sharpness is not positive.
    """
    stiffness, slip_force = _elements("stiffness", stiffness, slip_force)
    count = checks.whole("count", count, at_least=1)
    if sharpness != np.inf:
        sharpness = checks.number("sharpness", sharpness, above=0)
    onset = np.sort(slip_force / stiffness)
    onset = onset[np.diff(onset, prepend=0.0) > _SAME_CORNER * onset]
    u = np.append(0.0, onset)
    force = np.append(0.0, _loading_curve(onset, stiffness, slip_force))
    if onset.size <= count:
        return *_elements_of_corners(onset, force[1:], count), 0.0
    stuck = stiffness.sum() * onset
    lost = sharpness * (stuck - force[1:] + _HIDDEN_LOSS * stuck)
    allowed = np.append(0.0, np.minimum(force[1:], lost))
    # with the largest, one element of the right totals is near enough
    low, high = 0.0, float(np.max((stuck - force[1:]) / allowed[1:]))
    while high - low > 1e-12 * high:
        ratio = (low + high) / 2
        if _fewest_corners(u, force, ratio * allowed, count) is None:
            low = ratio
        else:
            high = ratio
    corners = _fewest_corners(u, force, high * allowed, count)
    return *_elements_of_corners(*np.transpose(corners), count), high


def fit_reduced_joint(
    joint: Joint,
    count: int,
    *,
    method: Method = "loops",
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
) -> tuple[Joint, xr.Dataset]:
    """Replace the elements of every region by ``count`` fitted ones.

    Loops are those of constant normal load, whatever the law: elements that carry no load in the
    assembled state do not take part.

    Parameters
    ----------
    joint
        A joint of regions.
    count, method, load_fractions, starts
        As for ``fit_elements``.

    Raises
    ------
    ValueError
        If a region has fewer elements under load than ``count``, or as for ``fit_elements``.

    Returns
    -------
    joint : Joint
        On the same points, with ``count`` elements each.
    fit : Dataset
        Cost, loop errors, amplitudes and the loops of region and fit, by point.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law of the joint", joint.law, ConstantLoad, VariableLoad)
    count = checks.whole("count", count, at_least=1)
    load_fractions = _check_options(method, load_fractions, starts)
    law = joint.law
    fits, errors, of_region, of_fit, displacement = [], [], [], [], []
    phase = np.linspace(0, np.pi, _SAMPLES)
    for point in range(joint.points):
        mine = (law.point_of_element == point) & (law.slip_force > 0)
        k, s = law.tangential_stiffness[mine], law.slip_force[mine]
        if k.size < count:
            raise ValueError(
                f"cannot fit {count} elements to region {point + 1}, which has {k.size} under "
                "load: ask for fewer elements or fewer regions"
            )
        fit = fit_elements(k, s, count, method=method, load_fractions=load_fractions, starts=starts)
        fits.append(fit)
        errors.append(loop_error(k, s, fit.tangential_stiffness, fit.slip_force))
        u = np.outer(fit.amplitude, np.cos(phase))
        displacement.append(u)
        of_region.append(
            [unloading_branch(a, v, k, s) for a, v in zip(fit.amplitude, u, strict=True)]
        )
        of_fit.append(
            [
                unloading_branch(a, v, fit.tangential_stiffness, fit.slip_force)
                for a, v in zip(fit.amplitude, u, strict=True)
            ]
        )
    loop = ("point", "loop", "sample")
    dataset = xr.Dataset(
        {
            "fit_cost": quantity("point", [f.cost for f in fits], "N2", "cost of eq. 3.3"),
            "largest_loop_error": quantity(
                "point",
                [e.largest for e in errors],
                "1",
                "largest force difference of all loops over the slip force",
            ),
            "rms_loop_error": quantity(
                "point",
                [e.rms for e in errors],
                "1",
                "mean force difference of loops at all amplitudes over the slip force",
            ),
            "loop_amplitude": quantity(
                ("point", "loop"), [f.amplitude for f in fits], "m", "amplitude of a compared loop"
            ),
            "loop_displacement": quantity(
                loop, np.array(displacement), "m", "displacement along the unloading branch"
            ),
            "loop_force_of_region": quantity(
                loop, np.array(of_region), "N", "force of all elements of the region"
            ),
            "loop_force_of_fit": quantity(
                loop, np.array(of_fit), "N", "force of the fitted elements"
            ),
        }
    )
    point_of_element = np.repeat(np.arange(joint.points), count)
    reduced = replace(
        joint,
        law=law.replaced_by(
            point_of_element,
            np.concatenate([f.tangential_stiffness for f in fits]),
            np.concatenate([f.slip_force for f in fits]),
        ),
        element_position=joint.position[point_of_element],
    )
    return reduced, dataset


def tabulate_joint(joint: Joint) -> Joint:
    """The same elements, with forces from a table: as fast as with one element a point.

    Parameters
    ----------
    joint
        A joint of regions, or any other under constant normal load.

    Raises
    ------
    ValueError
        If the normal load varies: the force is then no function of one amplitude.
    """
    checks.instance("joint", joint, Joint)
    law = joint.law
    if not isinstance(law, ConstantLoad):
        raise ValueError(
            f"the law {law.name!r} of the joint cannot be tabulated: only constant normal load can"
        )
    elements = law.point_of_element, law.tangential_stiffness, law.slip_force
    return replace(joint, law=TabulatedLoad(*elements))


def _elements(
    name: str, stiffness: NDArray[np.float64], slip_force: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness, by its name, and slip force of at least one element."""
    stiffness = checks.array(name, stiffness, ("elements",), above=0)
    if not stiffness.size:
        raise ValueError(f"{name} is empty: there must be at least one element")
    slip_name = name.replace("stiffness", "slip_force")
    return stiffness, checks.array(slip_name, slip_force, stiffness.shape, above=0)


def _check_options(
    method: Method, load_fractions: Sequence[float], starts: int
) -> NDArray[np.float64]:
    """Refuse options of a fit; the fractions of the load as an array."""
    checks.choice("method", method, get_args(Method))
    checks.whole("starts", starts, at_least=1)
    return checks.array("load_fractions", load_fractions, ("loops",), above=0, at_most=1)


class _Loops:
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
        self._target = self._combine @ _loading_curve(self.displacement, stiffness, slip_force)

    def elements(
        self, unknown: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and slip force of the elements from the logarithms of their shares."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def residual(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        force = self._combine @ _loading_curve(self.displacement, *self.elements(unknown))
        return (force - self._target) / self.total_slip

    def jacobian(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        k, s = self.elements(unknown)
        sticks = np.multiply.outer(self.displacement, k) < s
        by_k = np.where(sticks, self.displacement[:, None], 0.0)
        by_s = np.where(sticks, 0.0, 1.0)
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return self._combine @ np.hstack([by_a, by_b]) / self.total_slip


class _Harmonics:
    """Weighted differences between the describing functions of a region and of a few elements.

    With r = mu N / (k A), a slipping element has k f(r) in phase with displacement and k g(r) with
    velocity, ``f = (theta - sin theta cos theta) / pi``, ``g = 4 r (1 - r) / pi`` (see
    ``friction.constant``).
    """

    def __init__(
        self,
        stiffness: NDArray[np.float64],
        slip_force: NDArray[np.float64],
        loss_weight: float,
    ) -> None:
        self.total_stiffness, self.total_slip = stiffness.sum(), slip_force.sum()
        onset = slip_force / stiffness
        self.amplitude = np.geomspace(_LOWEST * onset.min(), onset.max(), _AMPLITUDES)
        self._target = self._describing_function(stiffness, slip_force)
        force = self.amplitude / self.total_slip
        loss = self._target[_AMPLITUDES:] / self.total_stiffness
        small = loss_weight * _HIDDEN_LOSS / (loss + _HIDDEN_LOSS) ** 2 / self.total_stiffness
        self._weight = np.concatenate([force, np.hypot(force, small)])

    def elements(
        self, unknown: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and slip force of the elements from the logarithms of their shares."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def residual(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._weight * (self._describing_function(*self.elements(unknown)) - self._target)

    def jacobian(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        k, s = self.elements(unknown)
        ratio, sine, f, g = self._of_elements(k, s)
        df, dg = 4 / np.pi * sine, np.where(ratio < 1, 4 / np.pi * (1 - 2 * ratio), 0.0)
        by_k = np.vstack([f - ratio * df, g - ratio * dg])
        by_s = np.vstack([df, dg]) / np.tile(self.amplitude, 2)[:, None]
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return self._weight[:, None] * np.hstack([by_a, by_b])

    def _describing_function(
        self, k: NDArray[np.float64], s: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        _, _, f, g = self._of_elements(k, s)
        return np.concatenate([f @ k, g @ k])

    def _of_elements(
        self, k: NDArray[np.float64], s: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], ...]:
        ratio = np.minimum(s / np.outer(self.amplitude, k), 1.0)
        sine = 2 * np.sqrt(ratio * (1 - ratio))
        theta = 2 * np.arctan2(np.sqrt(ratio), np.sqrt(1 - ratio))
        return ratio, sine, (theta - sine * (1 - 2 * ratio)) / np.pi, sine * sine / np.pi


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


def _elements_of_corners(
    displacement: NDArray[np.float64], force: NDArray[np.float64], count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness and slip force by the corners of a loading curve; the last in equal parts if few.

    At a corner the slope drops by the stiffness of the element that begins to slip.
    """
    slope = np.diff(force, prepend=0.0) / np.diff(displacement, prepend=0.0)
    k = -np.diff(slope, append=0.0)
    parts = np.ones(k.size, dtype=np.int64)
    parts[-1] += count - k.size
    k, at = np.repeat(k / parts, parts), np.repeat(displacement, parts)
    return k, k * at


def _fewest_corners(
    u: NDArray[np.float64], force: NDArray[np.float64], allowed: NDArray[np.float64], most: int
) -> list[tuple[float, float]] | None:
    """Corners of a concave path within bounds around a loading curve; None if more than ``most``.

    The path keeps the curve's first slope and last force. It is farther along, after each line,
    than any other path of as many lines.
    """
    top = force[-1]
    upper, lower = force + allowed, _concave_hull(u, force - allowed)
    # beyond this place the path may be at the top
    last = int(np.argmax(upper >= top))
    share = (top - upper[last - 1]) / (upper[last] - upper[last - 1])
    reach = u[last - 1] + share * (u[last] - u[last - 1])
    at, height, slope = 0.0, 0.0, force[1] / u[1]
    above = np.flatnonzero(slope * u > upper)
    leaves = int(above[0]) if above.size else None
    corners: list[tuple[float, float]] = []
    while leaves is not None:
        rise = (upper[leaves] - upper[leaves - 1]) / (u[leaves] - u[leaves - 1])
        meets = (upper[leaves - 1] - rise * u[leaves - 1] - height + slope * at) / (slope - rise)
        if height + slope * (meets - at) >= top:
            break
        at, height = meets, height + slope * (meets - at)
        corners.append((at, height))
        if len(corners) >= most:
            return None
        # lines from here: below the steepest they leave below a bound, above the other above it
        ahead = int(np.searchsorted(u, at, side="right"))
        way = u[ahead:] - at
        steepest = (upper[ahead:] - height) / way
        steepest[max(last - ahead, 0) :] = (top - height) / (reach - at)
        steepest = np.minimum.accumulate(steepest)
        flattest = np.maximum.accumulate((lower[ahead:] - height) / way)
        closed = np.flatnonzero(flattest > steepest)
        if closed.size == 0:
            leaves = None
            slope = flattest[-1] if flattest[-1] > 0 else steepest[-1]
        elif closed[0] == 0:  # only where the upper bound is not concave
            return None
        else:
            leaves, slope = ahead + int(closed[0]), flattest[closed[0] - 1]
    corners.append((at + (top - height) / slope, top))
    return corners


def _concave_hull(u: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The lowest concave curve that is nowhere below the values, at u."""
    kept: list[int] = []
    for i in range(u.size):
        while len(kept) > 1:
            a, b = kept[-2:]
            if (values[b] - values[a]) * (u[i] - u[a]) > (values[i] - values[a]) * (u[b] - u[a]):
                break
            kept.pop()
        kept.append(i)
    return np.interp(u, u[kept], values[kept])
