"""Minimax loading curve: a few Jenkins elements with the smallest largest error of force."""

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.joint.fit_options import FitOptions
from boltjoint.joint.masing import checked_elements, force_on_loading_curve

Array = NDArray[np.float64]

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
    return *_elements_of_corners(*np.transpose(corners), count), high


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
