"""What a joint is to the solver: contact points with their modal rows, and friction elements.

Node-to-node contact, regions and reduced joints are three ways to make the same thing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import dataset
from boltjoint.dataset import quantity
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.sampled import SampledInTime
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.friction.variable import VariableLoad

#: the laws that a joint can have, by their name
LAWS = {law.name: law for law in (ConstantLoad, VariableLoad, TabulatedLoad)}


@dataclass(frozen=True)
class Joint:
    """A structure in modal coordinates and the friction elements that act on it.

    Parameters
    ----------
    natural_frequency
        Of the structure without contact [Hz], shape (modes,).
    excitation_mode, response_mode
        Mass-normalised modes at the excited and the observed point [kg^-1/2], shape (modes,).
    tangential_mode
        Relative modal displacement, side A minus side B, along the bar at every contact point
        [kg^-1/2], shape (points, modes): u = tangential_mode @ q.
    position
        Of every contact point [m], shape (points, 3).
    law
        The friction elements and which point each acts on.
    element_position
        Of every element [m], shape (elements, 3): its contact pair, or its region's centre.
    normal_mode
        As ``tangential_mode``, across the contact and positive when closing, where the law needs
        it: v = normal_mode @ q.

    Raises
    ------
    ValueError
        If the shapes do not fit each other or an element sits on a point that does not exist.
    """

    natural_frequency: NDArray[np.float64]
    excitation_mode: NDArray[np.float64]
    response_mode: NDArray[np.float64]
    tangential_mode: NDArray[np.float64]
    position: NDArray[np.float64]
    law: ConstantLoad | VariableLoad | SampledInTime
    element_position: NDArray[np.float64]
    normal_mode: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        """Refuse parts that do not fit each other."""
        modes = self.natural_frequency.size
        points, elements = len(self.position), self.law.point_of_element.size
        expected = {
            "natural_frequency": (modes,),
            "excitation_mode": (modes,),
            "response_mode": (modes,),
            "tangential_mode": (points, modes),
            "position": (points, 3),
            "element_position": (elements, 3),
        }
        needs_normal = "normal" in self.law.directions
        if needs_normal != (self.normal_mode is not None):
            verb = "needs" if needs_normal else "has no use for"
            raise ValueError(f"the law {self.law.name!r} {verb} a normal mode")
        if needs_normal:
            expected["normal_mode"] = (points, modes)
        for name, shape in expected.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ValueError(f"{name} has shape {found}, expected {shape}")
        on = self.law.point_of_element
        if elements == 0 or on.min() < 0 or on.max() >= points:
            raise ValueError(f"elements must sit on points 0 to {points - 1}")

    @property
    def points(self) -> int:
        """Number of contact points."""
        return len(self.position)

    @property
    def rows(self) -> tuple[NDArray[np.float64], ...]:
        """Modal rows of each direction the law needs, each (points, modes)."""
        if self.normal_mode is None:
            return (self.tangential_mode,)
        return self.tangential_mode, self.normal_mode

    def stuck_stiffness(self) -> NDArray[np.float64]:
        """Modal stiffness the contact adds while nothing slips [s^-2], shape (modes, modes)."""
        stiffness = self.law.stuck_stiffness(self.points)
        return sum(B.T @ (k[:, None] * B) for B, k in zip(self.rows, stiffness.T, strict=True))


def connect_nodes(
    modes: xr.Dataset,
    preload: xr.Dataset,
    tangential_stiffness: float,
    friction_coefficient: float,
    normal_stiffness: float | None = None,
) -> Joint:
    """Put a friction element on the contact pairs: one each.

    Without a normal stiffness, elements under constant load sit on the pairs that carry load. With
    it, elements under variable load sit on all pairs; the load of an open one is
    ``-k_v gap`` (eq. 3.4), so that it may close.

    Parameters
    ----------
    modes, preload
        As written by ``structure.modes`` and ``structure.statics``, for the same pairs.
    tangential_stiffness
        k_u of every pair [N/m].
    friction_coefficient
        mu [-].
    normal_stiffness
        k_v of every pair [N/m].

    Raises
    ------
    ValueError
        If the two datasets do not hold the same pairs, or no pair carries load.
    """
    position = modes["position"].transpose("pair", "axis").to_numpy()
    if not np.array_equal(position, preload["position"].transpose("pair", "axis").to_numpy()):
        raise ValueError("modes and preload were found on different contact pairs")
    normal_load = preload["normal_load"].to_numpy()
    if not np.any(normal_load > 0):
        raise ValueError("no contact pair carries load")
    relative = modes["relative_mode"].transpose("axis", "pair", "mode")
    # bar A lies below bar B: A minus B along z closes
    along_bar, closing = (relative.sel(axis=axis).to_numpy() for axis in ("x", "z"))
    pairs = (
        np.flatnonzero(normal_load > 0) if normal_stiffness is None else np.arange(len(position))
    )
    each = np.ones(pairs.size)
    common = {
        "point_of_element": np.arange(pairs.size),
        "tangential_stiffness": tangential_stiffness * each,
    }
    if normal_stiffness is None:
        law = ConstantLoad(**common, slip_force=friction_coefficient * normal_load[pairs])
    else:
        law = VariableLoad(
            **common,
            normal_stiffness=normal_stiffness * each,
            normal_load=normal_load - normal_stiffness * preload["gap"].to_numpy(),
            friction_coefficient=friction_coefficient * each,
        )
    return Joint(
        natural_frequency=modes["natural_frequency"].to_numpy(),
        excitation_mode=modes["excitation_mode"].to_numpy(),
        response_mode=modes["response_mode"].to_numpy(),
        tangential_mode=along_bar[pairs],
        position=position[pairs],
        law=law,
        element_position=position[pairs],
        normal_mode=None if normal_stiffness is None else closing[pairs],
    )


def merge_points(
    joint: Joint, region: NDArray[np.int64], weight: NDArray[np.float64] | None = None
) -> Joint:
    """Let the points of a region move as one artificial point, their mean (eq. 3.1, 3.2).

    Every element stays; those of a region all see the displacement of its point.

    Parameters
    ----------
    joint
        A joint with any number of points.
    region
        Region of every point, from 0 without gaps, shape (points,).
    weight
        Of every point in the mean of its region, shape (points,); alike by default.

    Raises
    ------
    ValueError
        If the regions do not fit the points, a number is left out, or a weight is negative or all
        weights of a region are zero.
    """
    size = np.bincount(region)
    if region.shape != (joint.points,) or np.any(size == 0):
        raise ValueError("every point needs a region, and regions count from 0 without gaps")
    if weight is None:
        share = 1 / size[region]
    else:
        total = np.bincount(region, weight)
        if np.any(weight < 0) or np.any(total == 0):
            raise ValueError("weights must not be negative, nor all zero in a region")
        share = weight / total[region]
    mean = np.zeros((size.size, joint.points))
    mean[region, np.arange(joint.points)] = share
    return replace(
        joint,
        tangential_mode=mean @ joint.tangential_mode,
        normal_mode=None if joint.normal_mode is None else mean @ joint.normal_mode,
        position=mean @ joint.position,
        law=replace(joint.law, point_of_element=region[joint.law.point_of_element]),
    )


def to_dataset(joint: Joint) -> xr.Dataset:
    """The joint as the result files keep it (``joint.nc``)."""
    law = joint.law
    stored = {
        "natural_frequency": quantity(
            "mode", joint.natural_frequency, "Hz", "natural frequency without contact"
        ),
        "excitation_mode": quantity(
            "mode", joint.excitation_mode, "kg^-1/2", "mode at the excited point"
        ),
        "response_mode": quantity(
            "mode", joint.response_mode, "kg^-1/2", "mode at the observed point"
        ),
        "tangential_mode": quantity(
            ("point", "mode"),
            joint.tangential_mode,
            "kg^-1/2",
            "relative mode along the bar, side A minus side B",
        ),
        "position": quantity(("point", "axis"), joint.position, "m", "contact point"),
        "point_of_element": quantity(
            "element", law.point_of_element, "1", "contact point of the element, from 0"
        ),
        "element_position": quantity(
            ("element", "axis"), joint.element_position, "m", "position of the element"
        ),
    }
    if joint.normal_mode is not None:
        meaning = "relative mode across the contact, positive when closing"
        stored["normal_mode"] = quantity(("point", "mode"), joint.normal_mode, "kg^-1/2", meaning)
    for name, (unit, meaning) in law.quantities.items():
        stored[name] = quantity("element", getattr(law, name), unit, meaning)
    return xr.Dataset(stored, coords={"axis": ["x", "y", "z"]}, attrs={"law": law.name})


def load(path: str | Path, sampling: Mapping[str, int] | None = None) -> Joint:
    """The joint in a file; its friction exact, or sampled in time.

    Parameters
    ----------
    path
        ``joint.nc``.
    sampling
        ``harmonics`` and ``samples`` of ``friction.sampled.SampledInTime``; exact without.
    """
    found = from_dataset(dataset.load(path))
    return found if sampling is None else replace(found, law=SampledInTime(found.law, **sampling))


def from_dataset(stored: xr.Dataset) -> Joint:
    """The joint that ``joint.nc`` describes.

    Raises
    ------
    ValueError
        If the law is one this version does not know.
    """
    name = stored.attrs["law"]
    if name not in LAWS:
        raise ValueError(f"law {name!r} is not known; allowed: {', '.join(LAWS)}")
    law = LAWS[name]
    stored = stored.transpose("point", "element", ..., "axis", "mode", missing_dims="ignore")
    quantities = {name: stored[name].to_numpy() for name in law.quantities}
    return Joint(
        natural_frequency=stored["natural_frequency"].to_numpy(),
        excitation_mode=stored["excitation_mode"].to_numpy(),
        response_mode=stored["response_mode"].to_numpy(),
        tangential_mode=stored["tangential_mode"].to_numpy(),
        position=stored["position"].to_numpy(),
        law=law(point_of_element=stored["point_of_element"].to_numpy(), **quantities),
        element_position=stored["element_position"].to_numpy(),
        normal_mode=stored["normal_mode"].to_numpy() if "normal_mode" in stored else None,
    )
