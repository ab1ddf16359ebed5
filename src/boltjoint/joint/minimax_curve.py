"""The loading curve of few Jenkins elements with the smallest largest error."""

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.joint.masing import HIDDEN_LOSS, checked_elements, force_on_loading_curve

#: corners of a loading curve are one if they differ by less than this share: rounding
_SAME_CORNER = 1e-9


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
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    count = checks.whole("count", count, at_least=1)
    if sharpness != np.inf:
        sharpness = checks.number("sharpness", sharpness, above=0)
    onset = np.sort(slip_force / stiffness)
    onset = onset[np.diff(onset, prepend=0.0) > _SAME_CORNER * onset]
    u = np.append(0.0, onset)
    force = np.append(0.0, force_on_loading_curve(onset, stiffness, slip_force))
    if onset.size <= count:
        return *_elements_of_corners(onset, force[1:], count), 0.0
    stuck = stiffness.sum() * onset
    lost = sharpness * (stuck - force[1:] + HIDDEN_LOSS * stuck)
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
