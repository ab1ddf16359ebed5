"""Partition of a contact surface into regions, each of which moves as one point.

The error of regions is known before any response is solved: from the resonance while an increasing
slip fraction of the contact is released (``region_error``).
"""

from dataclasses import replace
from functools import cached_property
from typing import Literal, NamedTuple, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import eigvalsh
from scipy.spatial import KDTree

from boltjoint import checks
from boltjoint.harmonics import Components
from boltjoint.joint.bands import (
    bands_of_equal_load,
    bands_of_equal_middle_load,
    inner_and_outer_bands,
    on_each_surface,
    refuse_empty_regions,
)
from boltjoint.joint.clusters import (
    MotionClusters,
    SlipStateOptions,
    SlipStates,
    check_resonances,
    find_slip_states,
    modal_stiffness_where,
)
from boltjoint.joint.derived import merge_points
from boltjoint.joint.model import Joint
from boltjoint.joint.surface_places import SurfacePlaces

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

#: how a contact surface is divided
Division = Literal["equal-load", "equal-middle-load", "inner-outer", "clusters"]

#: how a region moves: as the mean of its pairs, as that weighted by their slip forces, or as a
#: straight line along the first tangent
Motion = Literal["mean", "load-weighted", "linear"]

#: divisions by position and load alone
_BY_LOAD = {"equal-load": bands_of_equal_load, "inner-outer": inner_and_outer_bands}


def partition_regions(
    joint: Joint,
    preload: xr.Dataset,
    count: int | None,
    division: Division = "equal-load",
    motion: Motion = "mean",
    *,
    tolerance: float | None = None,
    resonances: int = 1,
    options: SlipStateOptions = SlipStateOptions(),
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
        Each region lies on one surface; surfaces have regions in proportion to the slip forces,
        friction coefficient times load, of their pairs. ``equal-load``: bands along the surface
        that carry equal shares of the slip force. ``equal-middle-load``: bands that hold equal
        shares of the pressure along the middle of the width. ``inner-outer``: half as many bands as
        for ``equal-load``, the pairs near the middle of the width apart from those near the edges.
        ``clusters``: pairs of similar motion, anywhere on the surface.
    motion
        Along each direction of the points. ``mean``: as the mean of the pairs (``merge_points``).
        ``load-weighted``: as their mean weighted by their slip forces, which keeps the friction
        force in full slip; a region without load moves as the mean. ``linear``: every pair on the
        straight line along the first tangent that is nearest to the motion of its region; all
        points stay.
    tolerance
        As for ``choose_count``, where no number is given.
    resonances, options
        For ``clusters``, as for ``cluster_by_motion``; for ``tolerance``, as for ``region_error``.

    Returns
    -------
    Joint
        With a point for each region, on which its elements act; with all points for ``linear``.

    Raises
    ------
    ValueError
        If there are fewer pairs than regions, fewer regions than surfaces, neither a number nor a
        tolerance is given, division or motion are not known, or the preload does not describe a
        contact.
    """
    partition = _Partition(joint, preload, division, motion, resonances, options)
    if count is None:
        if tolerance is None:
            raise ValueError("regions need a number, or a tolerance that chooses it")
        count = choose_count(
            joint, preload, tolerance, division, motion, resonances=resonances, options=options
        )
    return partition.joint(count)


def region_error(
    joint: Joint,
    regions: Joint,
    *,
    resonances: int = 1,
    options: SlipStateOptions = SlipStateOptions(),
) -> float:
    """Largest relative error of the resonance of regions over nested slip states.

    Elements are released as one displacement of all makes them slip, from none to all. In each, two
    frequencies of the regions are compared with those of the pairs: of the joint whose remaining
    elements stick, and the apparent one (Rayleigh's quotient with the harmonic forces of all
    elements) in the pairs' mode, at an amplitude with about that slip fraction.

    Parameters
    ----------
    joint
        Node-to-node joint.
    regions
        A joint of regions with the same elements.
    resonances
        Number of resonances that are compared, from the first.
    options
        Number of slip states.

    Returns
    -------
    float
        The largest error of a frequency, relative.

    Raises
    ------
    ValueError
        If the two differ in their number of elements, or there are fewer modes than resonances.
    """
    for name, argument in (("joint", joint), ("regions", regions)):
        checks.instance(name, argument, Joint)
    if regions.law.point_of_element.size != joint.law.point_of_element.size:
        raise ValueError("regions must have the elements of the joint they are compared with")
    return _largest_error(find_slip_states(joint, resonances, options), joint, regions)


def choose_count(
    joint: Joint,
    preload: xr.Dataset,
    tolerance: float,
    division: Division = "equal-load",
    motion: Motion = "mean",
    *,
    resonances: int = 1,
    maximum: int = 64,
    options: SlipStateOptions = SlipStateOptions(),
) -> int:
    """Fewest regions whose ``region_error`` is within a tolerance.

    Parameters
    ----------
    joint, preload, division, motion, resonances, options
        As for ``partition_regions``.
    tolerance
        Largest relative error of the resonance over states of slip.
    maximum
        Largest number of regions tried.

    Raises
    ------
    ValueError
        If the tolerance is not positive, or no number of regions up to ``maximum`` meets it.
    """
    tolerance = checks.number("tolerance", tolerance, above=0)
    maximum = checks.whole("maximum", maximum, at_least=1)
    partition = _Partition(joint, preload, division, motion, resonances, options)
    best, at = np.inf, 0
    fewest = int(joint.surface_places.number.max()) + 1
    for count in range(fewest, min(maximum, joint.points) + 1):
        error = partition.error(count)
        if error <= tolerance:
            return count
        if error < best:
            best, at = error, count
    raise ValueError(
        f"up to {maximum} regions ({division}, {motion}) have an error of {best:.2g} at best, with "
        f"{at}: more than the tolerance of {tolerance:g}"
    )


class _Surface(NamedTuple):
    """Position [m], surface and contact pressure [Pa] of all pairs under preload."""

    position: Array
    places: SurfacePlaces
    pressure: Array

    @classmethod
    def of(cls, preload: xr.Dataset) -> "_Surface":
        """Of a contact under preload (``preload.nc``)."""
        position = checks.variable("preload", preload, "position", ("pair", "axis"))
        load = checks.variable("preload", preload, "normal_load", ("pair",), at_least=0)
        area = checks.variable("preload", preload, "area", ("pair",), above=0)
        checks.array("position of preload", position, ("pairs", 3))
        return cls(position, SurfacePlaces.of("preload", preload), load / area)


class _Partition:
    """Regions of a joint by one division and motion, for any number."""

    def __init__(
        self,
        joint: Joint,
        preload: xr.Dataset,
        division: Division,
        motion: Motion,
        resonances: int,
        options: SlipStateOptions,
    ) -> None:
        checks.instance("joint", joint, Joint)
        checks.choice("division", division, get_args(Division))
        checks.choice("motion", motion, get_args(Motion))
        check_resonances(joint, resonances)
        self._joint, self._surface = joint, _Surface.of(preload)
        self._division, self._motion, self._resonances = division, motion, resonances
        self._options = options

    @cached_property
    def _states(self) -> SlipStates:
        return find_slip_states(self._joint, self._resonances, self._options)

    @cached_property
    def _clusters(self) -> MotionClusters:
        return MotionClusters(self._joint, self._states)

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
    def _load(self) -> Array:
        """Slip force at each point [N]."""
        law = self._joint.law
        points = self._joint.points
        return np.asarray(np.bincount(law.point_of_element, law.slip_force, points), float)

    def error(self, count: int) -> float:
        return _largest_error(self._states, self._joint, self.joint(count))

    def _regions(self, count: int) -> Labels:
        joint = self._joint
        if self._division == "clusters":
            return self._clusters.regions(count)
        if self._division in _BY_LOAD:
            places = joint.surface_places
            of_points = places.number, places.place, self._load
            return on_each_surface(_BY_LOAD[self._division], *of_points, count)
        # of all pairs, since the surface may be open between those that have elements
        pair, places = self._pair_of_points, self._surface.places
        share = np.bincount(places.number[pair], self._load, places.number.max() + 1)
        region = on_each_surface(
            bands_of_equal_middle_load,
            places.number,
            places.place,
            self._surface.pressure,
            count,
            np.asarray(share, float),
        )[pair]
        refuse_empty_regions(region, count)
        return region

    @cached_property
    def _pair_of_points(self) -> Labels:
        """The pair that each point of the joint is, of those on its surface."""
        surface, places = self._surface, self._joint.surface_places
        pair = np.empty(self._joint.points, dtype=np.int64)
        for name in np.unique(places.name):
            mine, own = places.name == name, np.flatnonzero(surface.places.name == name)
            if not own.size:
                raise ValueError(f"the preload has no pairs on the surface {name} of the joint")
            nearest = KDTree(surface.position[own]).query(self._joint.position[mine])[1]
            pair[mine] = own[nearest]
        return pair


def _on_lines(joint: Joint, region: Labels) -> Joint:
    """All points, each moving on the straight line along its surface nearest to its region."""

    def on_lines(B: Array) -> Array:
        moved = np.empty_like(B)
        for mine in (region == label for label in range(region.max() + 1)):
            x = joint.surface_places.place[mine, 0]
            line = np.column_stack([np.ones(x.size), x - x.mean()])
            moved[mine] = line @ np.linalg.lstsq(line, B[mine], rcond=None)[0]
        return moved

    return replace(joint, **joint.moved_as(on_lines))


def _largest_error(states: SlipStates, joint: Joint, regions: Joint) -> float:
    """Largest relative error of a frequency in any state, and of the apparent frequency."""
    resonances = states.frequency.shape[1]
    places = [joint.place_of(1), joint.place_of(resonances)]
    errors = []
    for i, stuck in enumerate(states.stick):
        square = eigvalsh(modal_stiffness_where(regions, stuck), subset_by_index=places)
        errors.extend(np.sqrt(square) / states.frequency[i] - 1)
        for r in range(resonances):
            q = states.amplitude[i, r] * states.mode[i, r]
            errors.append(_apparent_frequency(regions, q) / _apparent_frequency(joint, q) - 1)
    return float(np.max(np.abs(errors)))


def _apparent_frequency(joint: Joint, q: Array) -> float:
    """Rayleigh's quotient of the harmonic motion q sin(wt) [rad/s]."""
    components = Components(joint.law.components)
    sin = components.sin()
    rows = joint.rows
    motion = np.zeros((joint.points, len(rows), len(components)))
    for d, B in enumerate(rows):
        motion[:, d, sin] = B @ q
    force = joint.law.force(motion.reshape(joint.points, -1)).reshape(motion.shape)
    work = np.sum(force[..., sin] * motion[..., sin])
    elastic = np.sum((2 * np.pi * joint.natural_frequency * q) ** 2)
    return float(np.sqrt((elastic + work) / np.sum(q**2)))
