"""Which contact pairs move together? Dividing a contact surface into regions along the bar."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.joint import Joint, merge_points

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


def partition_regions(joint: Joint, count: int) -> Joint:
    """Reduce a node-to-node joint to regions of equal load, each moving as the mean of its pairs.

    Parameters
    ----------
    joint
        Node-to-node joint.
    count
        Number of regions.

    Raises
    ------
    ValueError
        If there are not enough pairs for so many regions.
    """
    return merge_points(
        joint, regions_of_equal_load(joint.position[:, :2], joint.law.slip_force, count)
    )


def _ranks(distance: NDArray[np.float64]) -> NDArray[np.int64]:
    """Order of distances, the same for those that differ only by rounding."""
    order = np.argsort(distance, kind="stable")
    rank = np.empty(order.size, dtype=np.int64)
    rank[order] = np.cumsum(np.diff(distance[order], prepend=distance[order[:1]]) > _SAME_PLACE)
    return rank
