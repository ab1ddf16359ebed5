"""Bands of a contact surface: regions side by side along it that carry equal loads.

A surface is divided along the first tangent of its points, which lies along the bar in a half lap.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: sections 3.1.1.3, 3.2.1.1 and 3.2.2.1.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from boltjoint import checks

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

#: difference of distances along a surface, or from its middle, below which pairs are at one place
#: [m]
_SAME_PLACE = 1e-9
#: relative difference of loads below which they are one
_SAME_LOAD = 1e-9


def on_each_surface(
    divide: Callable[[Array, Array, int], Labels],
    surface: Labels,
    position: Array,
    load: Array,
    count: int,
    share: Array | None = None,
) -> Labels:
    """Regions of several surfaces, each of which has as many as its share of the load asks for.

    Parameters
    ----------
    divide
        Divides one surface, as ``bands_of_equal_load``.
    surface
        Number of the surface of every pair, from 0, shape (pairs,).
    position, load
        As for ``divide``, of all pairs.
    count
        Number of regions.
    share
        Load of every surface, shape (surfaces,), by which they have regions; by default the sum of
        ``load``.

    Returns
    -------
    ndarray
        Region of every pair, those of one surface after those of another, shape (pairs,).

    Raises
    ------
    ValueError
        If there are fewer regions than surfaces, or as for ``divide``.
    """
    surface = checks.indices("surface", surface, ("pairs",))
    position = checks.array("position", position, (surface.size, 2))
    load = checks.array("load", load, surface.shape, at_least=0)
    count = checks.whole("count", count)
    # inner and outer regions come in pairs
    multiple = 2 if divide is inner_and_outer_bands else 1
    total = np.asarray(np.bincount(surface, load), dtype=np.float64)
    if share is not None:
        total = checks.array("share", share, total.shape, at_least=0)
    if total.size == 1 or count % multiple:
        return divide(position, load, count)
    region, first = np.empty(surface.size, dtype=np.int64), 0
    for number, own in enumerate(multiple * _shares(total, count // multiple)):
        mine = surface == number
        # a surface that is open all over is divided by the number of its pairs
        of_surface = load[mine] if load[mine].any() else np.ones(np.count_nonzero(mine))
        region[mine] = first + divide(position[mine], of_surface, int(own))
        first += own
    return region


def _shares(load: Array, count: int) -> Labels:
    """Numbers that add up to ``count``, at least 1 each, nearly in proportion to loads."""
    refuse_fewer_than_surfaces(count, load.size)
    number = np.ones(load.size, dtype=np.int64)
    for _ in range(count - load.size):
        # the largest load that a region would have; the first of those that differ by rounding
        of_region = load / number
        number[np.argmax(of_region >= (1 - _SAME_LOAD) * of_region.max())] += 1
    return number


def refuse_fewer_than_surfaces(count: int, surfaces: int) -> None:
    """Raise a ``ValueError`` where there are fewer regions than surfaces."""
    if checks.whole("count", count) < surfaces:
        raise ValueError(f"{count} regions do not lie on {surfaces} surfaces, one on each at least")


def bands_of_equal_load(position: Array, load: Array, count: int) -> Labels:
    """Bands along a surface that carry as equal a load as the mesh allows.

    Pairs that mirror each other across the width stay together: a band is as symmetric as the mesh.

    Parameters
    ----------
    position
        Position of every pair [m], along the surface and across it from the middle, shape (pairs,
        2).
    load
        Load of every pair, of any unit, shape (pairs,).
    count
        Number of bands.

    Returns
    -------
    ndarray
        Band of every pair, from 0 along the first tangent, shape (pairs,).

    Raises
    ------
    ValueError
        If there are fewer places than bands, or no pair carries load.
    """
    position, load = _profile(position, "load", load)
    count = checks.whole("count", count)
    x, from_middle = _ranks(position[:, 0]), _ranks(np.abs(position[:, 1]))
    _, place = np.unique(np.column_stack([x, from_middle]), axis=0, return_inverse=True)
    at_place = np.bincount(place, load)
    if not 1 <= count <= at_place.size:
        raise ValueError(
            f"{load.size} pairs in {at_place.size} places along the first tangent "
            f"do not divide into {count} regions"
        )
    middle = np.cumsum(at_place) - at_place / 2
    first = np.searchsorted(middle, at_place.sum() * np.arange(count) / count)
    # where one place carries more than a band's share, the next band begins right after it
    bands = np.arange(count)
    first = np.minimum(np.maximum.accumulate(first - bands) + bands, at_place.size - count + bands)
    region = np.searchsorted(first, np.arange(at_place.size), side="right") - 1
    return region[place]


def bands_of_equal_middle_load(position: Array, pressure: Array, count: int) -> Labels:
    """Bands along a surface that hold equal shares of the pressure along the middle of the width.

    The pressure is interpolated across holes, as in the thesis for variable normal load (sections
    3.2.1.1 and 3.2.2.1).

    Parameters
    ----------
    position
        Position of every pair [m], along the surface and across it from the middle, shape (pairs,
        2).
    pressure
        On every pair, of any unit, 0 where it is open, shape (pairs,).
    count
        Number of bands.

    Returns
    -------
    ndarray
        Band of every pair, from 0 along the first tangent, shape (pairs,).

    Raises
    ------
    ValueError
        If a band would hold no pair, or no pair along the middle carries load.
    """
    position, pressure = _profile(position, "pressure", pressure)
    count = checks.whole("count", count, at_least=1)
    from_middle = np.abs(position[:, 1])
    middle = np.flatnonzero(from_middle <= from_middle.min() + _SAME_PLACE)
    middle = middle[np.argsort(position[middle, 0], kind="stable")]
    x = position[middle, 0]
    share = cumulative_trapezoid(pressure[middle], x, initial=0)
    if share[-1] == 0:
        raise ValueError("no pressure along the middle of the width by which to divide it")
    cuts = np.interp(share[-1] * np.arange(1, count) / count, share, x)
    region = np.searchsorted(cuts, position[:, 0] + _SAME_PLACE, side="right")
    refuse_empty_regions(region, count)
    return region


def inner_and_outer_bands(position: Array, load: Array, count: int) -> Labels:
    """Bands of equal load, each divided into an inner and an outer region of equal load.

    Parameters
    ----------
    position, load
        As for ``bands_of_equal_load``.
    count
        Number of regions, even.

    Returns
    -------
    ndarray
        Region of every pair, shape (pairs,): the inner one of a band before the outer one.

    Raises
    ------
    ValueError
        If the number is odd, there are fewer places than regions, or no pair carries load.
    """
    position, load = _profile(position, "load", load)
    if checks.whole("count", count) % 2:
        raise ValueError(f"{count} regions are not an inner and an outer one in every band")
    region = 2 * bands_of_equal_load(position, load, count // 2)
    from_middle = _ranks(np.abs(position[:, 1]))
    for band in range(0, count, 2):
        mine = region == band
        at_place = np.bincount(from_middle[mine], load[mine])
        middle = np.cumsum(at_place) - at_place / 2
        region[mine] += middle[from_middle[mine]] > at_place.sum() / 2
    refuse_empty_regions(region, count)
    return region


def refuse_empty_regions(region: Labels, count: int) -> None:
    """Raise a ``ValueError`` where fewer than ``count`` regions hold a pair."""
    region = checks.indices("region", region, ("pairs",))
    if np.unique(region).size != count:
        raise ValueError(f"{region.size} pairs do not divide into {count} regions along them")


def _profile(position: Array, name: str, load: Array) -> tuple[Array, Array]:
    """Position and load of pairs, checked."""
    position = checks.array("position", position, ("pairs", 2))
    load = checks.array(name, load, position.shape[:1], at_least=0)
    if not load.any():
        raise ValueError(f"{name} is zero on every pair: no part of it can be equal to another")
    return position, load


def _ranks(distance: Array) -> Labels:
    """Order of distances, the same for those that differ only by rounding."""
    order = np.argsort(distance, kind="stable")
    rank = np.empty(order.size, dtype=np.int64)
    rank[order] = np.cumsum(np.diff(distance[order], prepend=distance[order[:1]]) > _SAME_PLACE)
    return rank
