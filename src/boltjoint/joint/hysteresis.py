"""Loading curves and hysteresis loops of Jenkins elements in parallel, and how far they differ.

The elements of a region see one displacement, so their forces add up (Iwan model): on first loading
they carry ``F(u) = sum min(k u, mu N)``. Their steady loops follow from this curve (Masing's rule):
each half of a loop is the loading curve, twice as large and turned around.

References
----------
G. Masing: Eigenspannungen und Verfestigung beim Messing. Proceedings of the Second International
Congress of Applied Mechanics, Zurich (1926) 332-335.
W. D. Iwan: A distributed-element model for hysteresis and its steady-state dynamic response.
Journal of Applied Mechanics 33 (1966) 893-900.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.options import Options

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FitOptions(Options):
    """What of the hysteresis is compared in fits of a few elements, or of one Iwan element.

    Half or twice of any of them moves the peaks of the joints ``elements=7``, ``harmonic=7`` and
    ``iwan`` of the default study (``free-4``, three and four bolts, 1, 10 and 50 N) by at most 3e-4
    in frequency and 4e-3 in amplitude: several fits are about equally good.

    Parameters
    ----------
    loop_samples
        Points along half a loop at which forces are compared, evenly in phase.
    compared_amplitudes
        Amplitudes up to full slip at which describing functions, and loops for their mean error,
        are compared, evenly in their logarithm.
    curve_samples
        Displacements at which the loading curve of an Iwan element, which has no corners, is
        compared beside the corners of that of the region. Only the errors that are stated depend on
        it.
    lowest_amplitude
        Smallest amplitude at which describing functions are compared, over that of the first slip:
        a fit must not slip before the region.
    loss_weight
        Weight of relative errors of small losses, against errors of force over the slip force;
        times the square of the number of elements, with whose inverse errors of force fall.
    hidden_loss
        Loss, over the total stiffness, below which the structure's own damping hides that of the
        contact, as light structural damping does.
    sharpnesses
        Sharpness of the minimax loading curves from which the fit of describing functions starts:
        the smaller, the more weight small amplitudes have.

    Raises
    ------
    ValueError
        If one of them is not positive, a number of samples is not whole, or there is no sharpness.
    """

    loop_samples: int = 64
    compared_amplitudes: int = 120
    curve_samples: int = 400
    lowest_amplitude: float = 0.8
    loss_weight: float = 0.0023
    hidden_loss: float = 1e-3
    sharpnesses: tuple[float, ...] = (8.0, 16.0, 32.0, 128.0)

    def __post_init__(self) -> None:
        """Refuse options with which nothing can be compared."""
        for name in ("loop_samples", "compared_amplitudes", "curve_samples"):
            checks.whole(name, getattr(self, name), at_least=2)
        for name in ("lowest_amplitude", "loss_weight", "hidden_loss"):
            checks.number(name, getattr(self, name), above=0)
        checks.numbers("sharpnesses", self.sharpnesses)


def loading_curve(displacement: Array, stiffness: Array, slip_force: Array) -> Array:
    """Force of elements in parallel on first loading by ``displacement`` [N], of its shape."""
    displacement = checks.array("displacement", displacement)
    return force_on_loading_curve(
        displacement, *checked_elements("stiffness", stiffness, slip_force)
    )


def force_on_loading_curve(displacement: Array, stiffness: Array, slip_force: Array) -> Array:
    """As ``loading_curve``, of arguments that were checked before."""
    stuck = np.multiply.outer(displacement, stiffness)
    return np.minimum(stuck, slip_force).sum(axis=-1)


def unloading_branch(
    amplitude: float, displacement: Array, stiffness: Array, slip_force: Array
) -> Array:
    """Force on the branch from ``amplitude`` down to ``displacement`` of the steady loop [N].

    By Masing's rule; the other half of the loop is the same with both signs changed.
    """
    amplitude = checks.number("amplitude", amplitude, above=0)
    displacement = checks.array(
        "displacement", displacement, at_least=-amplitude, at_most=amplitude
    )
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    top = force_on_loading_curve(np.array(amplitude), stiffness, slip_force)
    return top - 2 * force_on_loading_curve((amplitude - displacement) / 2, stiffness, slip_force)


def amplitude_of_load(fraction: float, stiffness: Array, slip_force: Array) -> float:
    """Displacement [m] at which first loading reaches a fraction of the total slip force."""
    fraction = checks.number("fraction", fraction, above=0, at_most=1)
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    corners = np.append(0.0, np.sort(slip_force / stiffness))
    load = force_on_loading_curve(corners, stiffness, slip_force)
    return float(np.interp(fraction * slip_force.sum(), load, corners))


@dataclass(frozen=True)
class LoopError:
    """Force differences between loops over the total slip force: largest, and root mean square."""

    largest: float
    rms: float


def loop_error(
    stiffness: Array,
    slip_force: Array,
    fitted_stiffness: Array,
    fitted_slip_force: Array,
    options: FitOptions = FitOptions(),
) -> LoopError:
    """Error of the loops of fitted elements against those of a region, at all amplitudes.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    fitted_stiffness, fitted_slip_force
        Stiffness and slip force of the fitted elements, with the same total slip force, shape
        (few,).
    options
        Amplitudes and points of the loops whose mean error is found.

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
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    fitted_stiffness, fitted_slip_force = checked_elements(
        "fitted_stiffness", fitted_stiffness, fitted_slip_force
    )
    onset = slip_force / stiffness
    corner = np.unique(np.concatenate([[0.0], onset, fitted_slip_force / fitted_stiffness]))
    few = force_on_loading_curve(corner, fitted_stiffness, fitted_slip_force)
    return loop_error_of_curve(corner, few, stiffness, slip_force, options)


def loop_error_of_curve(
    corner: Array,
    force: Array,
    stiffness: Array,
    slip_force: Array,
    options: FitOptions = FitOptions(),
) -> LoopError:
    """As ``loop_error``, of a loading curve that is straight between displacements.

    Parameters
    ----------
    corner, force
        Displacements from 0 that hold all corners of both curves [m], and the force there [N].
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    options
        As for ``loop_error``.
    """
    checks.instance("options", options, FitOptions)
    onset = slip_force / stiffness
    difference = (force - force_on_loading_curve(corner, stiffness, slip_force)) / slip_force.sum()
    # d(A) - 2 d(v) with v up to A (Masing) is linear in both between corners
    above = difference - 2 * np.minimum.accumulate(difference)
    below = 2 * np.maximum.accumulate(difference) - difference
    amplitude = np.geomspace(onset.min(), onset.max(), options.compared_amplitudes)
    phase = np.pi * (np.arange(options.loop_samples) + 0.5) / options.loop_samples
    half_drop = np.outer(amplitude, (1 - np.cos(phase)) / 2)
    top = np.interp(amplitude, corner, difference)[:, None]
    along = top - 2 * np.interp(half_drop, corner, difference)
    return LoopError(float(max(above.max(), below.max())), float(np.sqrt(np.mean(along**2))))


def checked_elements(name: str, stiffness: Array, slip_force: Array) -> tuple[Array, Array]:
    """Stiffness, by its name, and slip force of at least one element."""
    stiffness = checks.array(name, stiffness, ("elements",), above=0)
    if not stiffness.size:
        raise ValueError(f"{name} is empty: there must be at least one element")
    slip_name = name.replace("stiffness", "slip_force")
    return stiffness, checks.array(slip_name, slip_force, stiffness.shape, above=0)


#: relative difference below which corners of a loading curve are one: rounding
_SAME_CORNER = 1e-9


def minimax_loading_curve(
    stiffness: Array,
    slip_force: Array,
    count: int,
    sharpness: float = np.inf,
    *,
    hidden_loss: float = FitOptions.hidden_loss,
) -> tuple[Array, Array, float]:
    """The ``count`` elements whose loading curve has the smallest largest error against many.

    With F the region's curve and K its total stiffness, the largest ratio of the difference to
    ``min(F, sharpness (K u - F + hidden_loss K u))`` is minimised: the relative error of force, and
    where little slips that of the force lost by slip. Loading curves are concave and piecewise
    linear. The one with the fewest corners between two bounds follows each line until it meets the
    upper bound, and from there the tangent to the lower bound. The bounds are brought together
    until there are as many corners as elements.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    count
        Number of elements.
    sharpness
        The smaller, the more weight small amplitudes have. The result is the nearest curve where
        the ratio found is below the inverse of the sharpness: then the upper bound is concave.
    hidden_loss
        As of ``FitOptions``.

    Returns
    -------
    stiffness, slip_force : ndarray
        In the order in which the elements slip [N/m], [N], shape (count,).
    ratio : float
        The largest ratio.

    Raises
    ------
    ValueError
        If a stiffness or slip force, the number, the sharpness or the hidden loss is not positive.
    """
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    count = checks.whole("count", count, at_least=1)
    if sharpness != np.inf:
        sharpness = checks.number("sharpness", sharpness, above=0)
    hidden_loss = checks.number("hidden_loss", hidden_loss, above=0)
    onset = np.sort(slip_force / stiffness)
    onset = onset[np.diff(onset, prepend=0.0) > _SAME_CORNER * onset]
    u = np.append(0.0, onset)
    force = np.append(0.0, force_on_loading_curve(onset, stiffness, slip_force))
    if onset.size <= count:
        return *_elements_of_corners(onset, force[1:], count), 0.0
    stuck = stiffness.sum() * onset
    lost = sharpness * (stuck - force[1:] + hidden_loss * stuck)
    allowed = np.append(0.0, np.minimum(force[1:], lost))
    # within the largest bounds is one element of the same totals
    low, high = 0.0, float(np.max((stuck - force[1:]) / allowed[1:]))
    while high - low > 1e-12 * high:
        ratio = (low + high) / 2
        if _fewest_corners(u, force, ratio * allowed, count) is None:
            low = ratio
        else:
            high = ratio
    corners = _fewest_corners(u, force, high * allowed, count)
    onset, force = np.array(corners, dtype=np.float64).T
    return *_elements_of_corners(onset, force, count), high


def _elements_of_corners(displacement: Array, force: Array, count: int) -> tuple[Array, Array]:
    """Stiffness and slip force by the corners of a loading curve.

    At a corner the slope drops by the stiffness of the element that begins to slip. Where there are
    fewer corners than elements, the last element is divided into equal parts.
    """
    slope = np.diff(force, prepend=0.0) / np.diff(displacement, prepend=0.0)
    k = -np.diff(slope, append=0.0)
    parts = np.ones(k.size, dtype=np.int64)
    parts[-1] += count - k.size
    k, at = np.repeat(k / parts, parts), np.repeat(displacement, parts)
    return k, k * at


def _fewest_corners(
    u: Array, force: Array, allowed: Array, maximum: int
) -> list[tuple[float, float]] | None:
    """Corners of a concave polyline within bounds around a loading curve; None above ``maximum``.

    The polyline keeps the curve's first slope and last force. After each line it reaches a larger
    displacement than any other polyline of as many lines.
    """
    top = force[-1]
    upper, lower = force + allowed, _concave_hull(u, force - allowed)
    # beyond this displacement the polyline may be at the top
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
        if len(corners) >= maximum:
            return None
        # slopes from here that stay below the upper bound and above the lower one
        ahead = int(np.searchsorted(u, at, side="right"))
        run = u[ahead:] - at
        steepest = (upper[ahead:] - height) / run
        steepest[max(last - ahead, 0) :] = (top - height) / (reach - at)
        steepest = np.minimum.accumulate(steepest)
        flattest = np.maximum.accumulate((lower[ahead:] - height) / run)
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


def _concave_hull(u: Array, values: Array) -> Array:
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
