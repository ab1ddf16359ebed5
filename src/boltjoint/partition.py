"""Which contact pairs move together, and in how many regions? Dividing a contact surface.

How far regions are from the pairs they stand for is known before any response is solved: from the
resonance while ever more of the contact slips (``region_error``).
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.cluster.vq import ClusterError, kmeans2
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import eigh, eigvalsh
from scipy.spatial import KDTree

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.joint import Joint, merge_points

#: how a contact surface is divided
Division = Literal["equal-load", "equal-middle-load", "inner-outer", "clusters"]

#: how a region moves: as the mean of its pairs, as that weighted by the load they carry, or as a
#: straight line along the bar
Motion = Literal["mean", "load-weighted", "linear"]

#: shares of the load that has let go in the states of slip by which regions are made and judged
_LET_GO = np.arange(9) / 8

#: shares of the load that slips at the amplitudes of these states, within the ends: where the very
#: last element slips depends on how near it is to rest
_SLIPS = (np.arange(9) + 0.5) / 9

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
        If there are fewer places than regions, or no pair carries load.
    """
    position, load = _profile(position, "load", load)
    count = checks.whole("count", count)
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
    _refuse_empty(region, count)
    return region


def inner_and_outer_regions(
    position: NDArray[np.float64], load: NDArray[np.float64], count: int
) -> NDArray[np.int64]:
    """Divide pairs as ``regions_of_equal_load``, and each region across the width in two.

    Parameters
    ----------
    position, load
        As for ``regions_of_equal_load``.
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
    region = 2 * regions_of_equal_load(position, load, count // 2)
    from_middle = _ranks(np.abs(position[:, 1]))
    for band in range(0, count, 2):
        mine = region == band
        at_place = np.bincount(from_middle[mine], load[mine])
        middle = np.cumsum(at_place) - at_place / 2
        region[mine] += middle[from_middle[mine]] > at_place.sum() / 2
    _refuse_empty(region, count)
    return region


def regions_of_like_motion(joint: Joint, count: int, *, resonances: int = 1) -> NDArray[np.int64]:
    """Gather the pairs that move alike while a resonance passes from stick to slip.

    The stiffness that regions lose is that of the springs under the scatter of the motion in each
    region. So pairs are clustered by their relative displacement in the modes of the joint, stuck,
    without contact, and with the pairs of least load let go in between: by Ward's method, which
    merges what adds least to the scatter, and from there by k-means.

    Parameters
    ----------
    joint
        Node-to-node joint.
    count
        Number of regions.
    resonances
        Number of resonances whose modes count, from the first.

    Returns
    -------
    ndarray
        Region of every pair, in the order of their centres from the clamped end, shape (pairs,).

    Raises
    ------
    ValueError
        If there are fewer pairs than regions, or fewer modes than resonances.
    """
    checks.instance("joint", joint, Joint)
    return _LikeMotion(joint, _slip_states(joint, resonances)).regions(count)


def partition_regions(
    joint: Joint,
    preload: xr.Dataset,
    count: int | None,
    division: Division = "equal-load",
    motion: Motion = "mean",
    *,
    tolerance: float | None = None,
    resonances: int = 1,
) -> Joint:
    """Reduce a node-to-node joint to regions, each moving as one artificial point.

    Parameters
    ----------
    joint
        Node-to-node joint.
    preload
        The contact under bolt preload that it was made from (``preload.nc``).
    count
        Number of regions; None for the fewest within the tolerance (``choose_count``).
    division
        ``equal-load``: bands along the bar that carry equal shares of the normal load.
        ``equal-middle-load``: bands that hold equal shares of the pressure along the middle of the
        width. ``inner-outer``: half as many bands as for ``equal-load``, the pairs near the middle
        of the width apart from those near the edges. ``clusters``: pairs that move alike, wherever
        they are.
    motion
        ``mean``: as the mean of the pairs (eq. 3.1, 3.2). ``load-weighted``: as their mean weighted
        by the load they carry, which keeps the friction of a contact that slips all over; a region
        without load moves as the mean. ``linear``: every pair on the straight line along the bar
        that is nearest to the motion of its region; all points stay.
    tolerance
        As for ``choose_count``, where no number is given.
    resonances
        For ``clusters``, as for ``regions_of_like_motion``.

    Raises
    ------
    ValueError
        If there are not enough pairs for so many regions, or neither a number nor a tolerance; or
        if division or motion are not known.
    """
    partition = _Partition(joint, preload, division, motion, resonances)
    if count is None:
        if tolerance is None:
            raise ValueError("regions need a number, or a tolerance that chooses it")
        count = choose_count(joint, preload, tolerance, division, motion, resonances=resonances)
    return partition.joint(count)


def region_error(joint: Joint, regions: Joint, *, resonances: int = 1) -> float:
    """How far regions put the resonance from where the pairs have it, at most, over states of slip.

    The states are nested: elements let go in the order of the load they carry, from none to all.
    In each, two frequencies of the regions are compared with those of the pairs: of the joint whose
    remaining elements stick, and the apparent one (Rayleigh's quotient with the harmonic forces of
    all elements) in the pairs' mode, at an amplitude at which about that share of the load slips.

    Parameters
    ----------
    joint
        Node-to-node joint.
    regions
        A joint of regions with the same elements.
    resonances
        Number of resonances that count, from the first.

    Returns
    -------
    float
        The largest error of a frequency, relative.

    Raises
    ------
    ValueError
        If the two differ in their number of elements, or there are fewer modes than resonances.
    """
    for name, each in (("joint", joint), ("regions", regions)):
        checks.instance(name, each, Joint)
    if regions.law.point_of_element.size != joint.law.point_of_element.size:
        raise ValueError("regions must have the elements of the joint they are compared with")
    return _largest_error(_slip_states(joint, resonances), joint, regions)


def tabulate_region_errors(
    joint: Joint,
    preload: xr.Dataset,
    counts: Sequence[int],
    division: Division = "equal-load",
    motion: Motion = "mean",
    *,
    resonances: int = 1,
) -> xr.Dataset:
    """``region_error`` against the number of regions, without solving for any response.

    Parameters
    ----------
    joint, preload, division, motion, resonances
        As for ``partition_regions``.
    counts
        Numbers of regions.

    Returns
    -------
    Dataset
        ``count(partition)`` and ``region_error(partition)``.

    Raises
    ------
    ValueError
        As for ``partition_regions``.
    """
    partition = _Partition(joint, preload, division, motion, resonances)
    return xr.Dataset(
        {
            "count": quantity("partition", np.array(counts), "1", "number of regions"),
            "region_error": quantity(
                "partition",
                np.array([partition.error(count) for count in counts]),
                "1",
                "largest relative error of the resonance over states of slip",
            ),
        },
        attrs={"division": division, "motion": motion, "resonances": resonances},
    )


def choose_count(
    joint: Joint,
    preload: xr.Dataset,
    tolerance: float,
    division: Division = "equal-load",
    motion: Motion = "mean",
    *,
    resonances: int = 1,
    most: int = 64,
) -> int:
    """Fewest regions whose ``region_error`` is within a tolerance.

    Parameters
    ----------
    joint, preload, division, motion, resonances
        As for ``partition_regions``.
    tolerance
        Largest relative error of the resonance over states of slip.
    most
        Largest number of regions tried.

    Raises
    ------
    ValueError
        If the tolerance is not positive, or no number of regions up to ``most`` meets it.
    """
    tolerance = checks.number("tolerance", tolerance, above=0)
    most = checks.whole("most", most, at_least=1)
    partition = _Partition(joint, preload, division, motion, resonances)
    best, at = np.inf, 0
    for count in range(1, min(most, joint.points) + 1):
        error = partition.error(count)
        if error <= tolerance:
            return count
        if error < best:
            best, at = error, count
    raise ValueError(
        f"up to {most} regions ({division}, {motion}) have an error of {best:.2g} at best, with "
        f"{at}: more than the tolerance of {tolerance:g}"
    )


@dataclass(frozen=True)
class _SlipStates:
    """A joint while its elements let go one after another, those of least load first.

    ``sticks`` has the shape (states, elements), ``mode`` (states, resonances, modes), ``frequency``
    [rad/s] and ``amplitude`` (states, resonances); modes are of unit length, and at the amplitude
    [kg^1/2 m] about as much of the load slips in the mode as has let go.
    """

    sticks: NDArray[np.bool_]
    frequency: NDArray[np.float64]
    mode: NDArray[np.float64]
    amplitude: NDArray[np.float64]


class _LikeMotion:
    """Clusters of the points of a joint, for any count from one tree."""

    def __init__(self, joint: Joint, states: _SlipStates) -> None:
        self._position = joint.position
        # scaled so that scatter is the loss of squared frequency, relative, of each mode
        modes = (states.mode / states.frequency[..., None]).reshape(
            -1, joint.natural_frequency.size
        )
        self._motion = np.hstack(
            [
                np.sqrt(k)[:, None] * (B @ modes.T)
                for B, k in zip(joint.rows, _stiffness(joint), strict=True)
            ]
        )
        self._tree = linkage(self._motion, "ward")

    def regions(self, count: int) -> NDArray[np.int64]:
        points = len(self._motion)
        if not 1 <= checks.whole("count", count) <= points:
            raise ValueError(f"{points} pairs do not divide into {count} regions")
        # the first merges of the tree, by their order: equal heights would merge too many at once
        merges = np.arange(points - 1, dtype=float)
        found = fcluster(self._tree, points - count - 1, "monocrit", monocrit=merges) - 1
        centres = _centres(self._motion, found)
        # k-means may empty a region where pairs move the same: then the tree's stay
        with suppress(ClusterError):
            found = kmeans2(self._motion, centres, 50, minit="matrix", missing="raise")[1]
        first = np.lexsort(_centres(self._position, found).T[::-1])
        rank = np.empty(count, dtype=np.int64)
        rank[first] = np.arange(count)
        return rank[found]


class _Partition:
    """One way to divide a joint, for any number of regions."""

    def __init__(
        self,
        joint: Joint,
        preload: xr.Dataset,
        division: Division,
        motion: Motion,
        resonances: int,
    ) -> None:
        checks.instance("joint", joint, Joint)
        checks.choice("division", division, get_args(Division))
        checks.choice("motion", motion, get_args(Motion))
        _check_resonances(joint, resonances)
        self._joint, self._preload = joint, preload
        self._division, self._motion, self._resonances = division, motion, resonances

    @cached_property
    def _states(self) -> _SlipStates:
        return _slip_states(self._joint, self._resonances)

    @cached_property
    def _like_motion(self) -> _LikeMotion:
        return _LikeMotion(self._joint, self._states)

    def joint(self, count: int) -> Joint:
        joint, region = self._joint, self._regions(count)
        if self._motion == "linear":
            return _on_lines(joint, region)
        if self._motion == "mean":
            return merge_points(joint, region)
        load = self._load
        unloaded = np.bincount(region, load)[region] == 0
        return merge_points(joint, region, np.where(unloaded, 1.0, load))

    @property
    def _load(self) -> NDArray[np.float64]:
        law = self._joint.law
        return np.bincount(law.point_of_element, law.slip_force, self._joint.points)

    def error(self, count: int) -> float:
        return _largest_error(self._states, self._joint, self.joint(count))

    def _regions(self, count: int) -> NDArray[np.int64]:
        joint = self._joint
        if self._division == "clusters":
            return self._like_motion.regions(count)
        if self._division in _BY_LOAD:
            return _BY_LOAD[self._division](joint.position[:, :2], self._load, count)
        # of all pairs, since between those that a joint has elements on the surface may be open
        surface = checks.variable("preload", self._preload, "position", ("pair", "axis"))
        load = checks.variable("preload", self._preload, "normal_load", ("pair",), at_least=0)
        pressure = load / checks.variable("preload", self._preload, "area", ("pair",), above=0)
        region = regions_of_equal_middle_load(surface[:, :2], pressure, count)
        region = region[KDTree(surface).query(joint.position)[1]]
        _refuse_empty(region, count)
        return region


#: divisions by position and load alone
_BY_LOAD = {"equal-load": regions_of_equal_load, "inner-outer": inner_and_outer_regions}


def _on_lines(joint: Joint, region: NDArray[np.int64]) -> Joint:
    """All points, each moving with the straight line along the bar nearest to its region."""
    moved = [np.empty_like(B) for B in joint.rows]
    for mine in (region == each for each in range(region.max() + 1)):
        x = joint.position[mine, 0]
        line = np.column_stack([np.ones(x.size), x - x.mean()])
        for B, on_line in zip(joint.rows, moved, strict=True):
            on_line[mine] = line @ np.linalg.lstsq(line, B[mine], rcond=None)[0]
    names = ("tangential_mode", "normal_mode")
    return replace(joint, **dict(zip(names, moved, strict=False)))


def _slip_states(joint: Joint, resonances: int) -> _SlipStates:
    _check_resonances(joint, resonances)
    modes = joint.natural_frequency.size
    load = joint.law.slip_force
    if not load.any():
        raise ValueError("no element of the joint carries load: there is nothing to slip")
    order = np.argsort(load, kind="stable")
    let_go = np.cumsum(load[order]) / load.sum()
    # by a threshold, so that elements with the same load let go together
    threshold = np.append(load[order][np.searchsorted(let_go, _LET_GO[:-1], "right")], np.inf)
    sticks = (load >= threshold[:, None]) & (load > 0)
    shape = (len(sticks), resonances)
    frequency, amplitude = np.empty(shape), np.empty(shape)
    mode = np.empty((*shape, modes))
    loaded = load > 0
    limit = load[loaded] / joint.law.tangential_stiffness[loaded]
    on = joint.law.point_of_element[loaded]
    for i, stuck in enumerate(sticks):
        square, vectors = eigh(_stiffness_where(joint, stuck), subset_by_index=[0, resonances - 1])
        frequency[i], mode[i] = np.sqrt(square), vectors.T
        for r in range(resonances):
            moved = np.abs(joint.tangential_mode @ mode[i, r])[on]
            slips_at = limit / np.maximum(moved, np.finfo(float).tiny)
            by_amplitude = np.argsort(slips_at, kind="stable")
            share = np.cumsum(load[loaded][by_amplitude]) / load.sum()
            amplitude[i, r] = slips_at[by_amplitude[np.searchsorted(share, _SLIPS[i])]]
    return _SlipStates(sticks, frequency, mode, amplitude)


def _largest_error(states: _SlipStates, joint: Joint, regions: Joint) -> float:
    """Largest relative error of a frequency in any state, and of the apparent frequency."""
    resonances = states.frequency.shape[1]
    errors = []
    for i, stuck in enumerate(states.sticks):
        square = eigvalsh(_stiffness_where(regions, stuck), subset_by_index=[0, resonances - 1])
        errors.extend(np.sqrt(square) / states.frequency[i] - 1)
        for r in range(resonances):
            q = states.amplitude[i, r] * states.mode[i, r]
            errors.append(_apparent_frequency(regions, q) / _apparent_frequency(joint, q) - 1)
    return float(np.max(np.abs(errors)))


def _apparent_frequency(joint: Joint, q: NDArray[np.float64]) -> float:
    """Rayleigh's quotient of the harmonic motion q sin(wt) [rad/s]."""
    components = joint.law.components
    sin = components.index("sin")
    rows = joint.rows
    motion = np.zeros((joint.points, len(rows), len(components)))
    for d, B in enumerate(rows):
        motion[:, d, sin] = B @ q
    force = joint.law.force(motion.reshape(joint.points, -1)).reshape(motion.shape)
    work = np.sum(force[..., sin] * motion[..., sin])
    elastic = np.sum((2 * np.pi * joint.natural_frequency * q) ** 2)
    return float(np.sqrt((elastic + work) / np.sum(q**2)))


def _stiffness_where(joint: Joint, stuck: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Modal stiffness of a joint where only some elements stick [s^-2], shape (modes, modes)."""
    total = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    for B, k in zip(joint.rows, _stiffness(joint, stuck), strict=True):
        total += B.T @ (k[:, None] * B)
    return total


def _stiffness(joint: Joint, counts: NDArray[np.bool_] | None = None) -> list[NDArray[np.float64]]:
    """Stiffness of all elements that count, at each point and by direction [N/m], (points,)."""
    law = joint.law
    of_elements = [getattr(law, f"{direction}_stiffness") for direction in law.directions]
    return [
        np.bincount(law.point_of_element, k if counts is None else k * counts, joint.points)
        for k in of_elements
    ]


def _centres(values: NDArray[np.float64], region: NDArray[np.int64]) -> NDArray[np.float64]:
    """Mean of every column of values over each region, shape (regions, columns)."""
    size = np.bincount(region)
    return np.column_stack([np.bincount(region, column) / size for column in values.T])


def _check_resonances(joint: Joint, resonances: int) -> None:
    checks.whole("resonances", resonances, at_least=1, at_most=joint.natural_frequency.size)


def _profile(
    position: NDArray[np.float64], name: str, load: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place and load of pairs, by which they are divided."""
    position = checks.array("position", position, ("pairs", 2))
    load = checks.array(name, load, position.shape[:1], at_least=0)
    if not load.any():
        raise ValueError(f"{name} is zero on every pair: no part of it can be equal to another")
    return position, load


def _refuse_empty(region: NDArray[np.int64], count: int) -> None:
    if np.unique(region).size != count:
        raise ValueError(f"{region.size} pairs do not divide into {count} regions along the bar")


def _ranks(distance: NDArray[np.float64]) -> NDArray[np.int64]:
    """Order of distances, the same for those that differ only by rounding."""
    order = np.argsort(distance, kind="stable")
    rank = np.empty(order.size, dtype=np.int64)
    rank[order] = np.cumsum(np.diff(distance[order], prepend=distance[order[:1]]) > _SAME_PLACE)
    return rank
