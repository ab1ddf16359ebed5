"""Which contact pairs move together? Dividing a contact surface into regions along the bar."""

from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.spatial import KDTree

from boltjoint.joint import Joint, merge_points

#: how a contact surface is divided
Division = Literal["equal-load", "equal-middle-load"]

#: pairs whose distances along the bar, or from its middle, differ by less [m] stand alike
_SAME_PLACE = 1e-9


def regions_of_equal_load(
    position: NDArray[np.float64], load: NDArray[np.float64], count: int
) -> NDArray[np.int64]:
    """Divide pairs into regions along the bar that carry as equal a load as the mesh allows.

    Pairs that mirror each other across the width stay together, so a region is as symmetric as the
    mesh is.

    Parameters
    ----------
    position
        Of every pair [m], along the bar (x) and across it (y) from the middle, shape (pairs, 2).
    load
        Of every pair, of any unit, shape (pairs,).
    count
        Number of regions.

    Returns
    -------
    ndarray
        Region of every pair, from 0 at the clamped end, shape (pairs,).

    Raises
    ------
    ValueError
        If there are fewer places than regions.
    """
    x, from_middle = _ranks(position[:, 0]), _ranks(np.abs(position[:, 1]))
    _, place = np.unique(np.column_stack([x, from_middle]), axis=0, return_inverse=True)
    at_place = np.bincount(place, load)
    if not 1 <= count <= at_place.size:
        raise ValueError(
            f"{load.size} pairs in {at_place.size} places along the bar "
            f"do not divide into {count} regions"
        )
    middle = np.cumsum(at_place) - at_place / 2
    first = np.searchsorted(middle, at_place.sum() * np.arange(count) / count)
    # where one place carries more than a region's share, the next region begins right after it
    each = np.arange(count)
    first = np.minimum(np.maximum.accumulate(first - each) + each, at_place.size - count + each)
    region = np.searchsorted(first, np.arange(at_place.size), side="right") - 1
    return region[place]


def regions_of_equal_middle_load(
    position: NDArray[np.float64], pressure: NDArray[np.float64], count: int
) -> NDArray[np.int64]:
    """Divide pairs across the bar where equal shares of the pressure along its middle lie between.

    The profile is taken along the middle of the width, straight across holes, as the source does
    for variable normal load (sections 3.2.1.1 and 3.2.2.1).

    Parameters
    ----------
    position
        Of every pair [m], along the bar (x) and across it (y) from the middle, shape (pairs, 2).
    pressure
        On every pair, of any unit, 0 where it is open, shape (pairs,).
    count
        Number of regions.

    Returns
    -------
    ndarray
        Region of every pair, from 0 at the clamped end, shape (pairs,).

    Raises
    ------
    ValueError
        If a region would hold no pair, or no pair along the middle carries load.
    """
    from_middle = np.abs(position[:, 1])
    middle = np.flatnonzero(from_middle <= from_middle.min() + _SAME_PLACE)
    middle = middle[np.argsort(position[middle, 0], kind="stable")]
    x = position[middle, 0]
    share = cumulative_trapezoid(pressure[middle], x, initial=0)
    if share[-1] == 0:
        raise ValueError("no pressure along the middle of the width by which to divide it")
    cuts = np.interp(share[-1] * np.arange(1, count) / count, share, x)
    region = np.searchsorted(cuts, position[:, 0] + _SAME_PLACE, side="right")
    _refuse_empty(region, count)
    return region


def partition_regions(
    joint: Joint, preload: xr.Dataset, count: int, division: Division = "equal-load"
) -> Joint:
    """Reduce a node-to-node joint to regions along the bar, each moving as the mean of its pairs.

    Parameters
    ----------
    joint
        Node-to-node joint.
    preload
        The contact under bolt preload that it was made from (``preload.nc``).
    count
        Number of regions.
    division
        ``equal-load``: regions carry equal shares of the normal load. ``equal-middle-load``: they
        hold equal shares of the pressure along the middle of the width.

    Raises
    ------
    ValueError
        If there are not enough pairs for so many regions.
    """
    if division == "equal-load":
        region = regions_of_equal_load(joint.position[:, :2], joint.law.slip_force, count)
    else:
        # of all pairs, since between those that a joint has elements on the surface may be open
        surface = preload["position"].transpose("pair", "axis").to_numpy()
        pressure = (preload["normal_load"] / preload["area"]).to_numpy()
        region = regions_of_equal_middle_load(surface[:, :2], pressure, count)
        region = region[KDTree(surface).query(joint.position)[1]]
        _refuse_empty(region, count)
    return merge_points(joint, region)


def _refuse_empty(region: NDArray[np.int64], count: int) -> None:
    if np.unique(region).size != count:
        raise ValueError(f"{region.size} pairs do not divide into {count} regions along the bar")


def _ranks(distance: NDArray[np.float64]) -> NDArray[np.int64]:
    """Order of distances, the same for those that differ only by rounding."""
    order = np.argsort(distance, kind="stable")
    rank = np.empty(order.size, dtype=np.int64)
    rank[order] = np.cumsum(np.diff(distance[order], prepend=distance[order[:1]]) > _SAME_PLACE)
    return rank
