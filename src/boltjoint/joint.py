"""What a joint is to the solver: contact points with their modal rows, and friction elements.

Node-to-node contact, regions and reduced joints are three ways to make the same thing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks, dataset
from boltjoint.dataset import quantity
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.law import FrictionLaw
from boltjoint.friction.sampled import SampledInTime
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.friction.variable import VariableLoad

#: the laws that a joint can have, by their name
LAWS = {law.name: law for law in (ConstantLoad, VariableLoad, TabulatedLoad)}

#: relative difference of squared frequencies below which modes are any combination of each other
_SAME_FREQUENCY = 1e-9


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
        If an entry is not a finite number, a natural frequency is negative, the shapes do not fit
        each other, or an element sits on a point that does not exist.
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
        checks.instance("law", self.law, FrictionLaw)
        frequency = checks.array(
            "natural_frequency", self.natural_frequency, ("modes",), at_least=0
        )
        position = checks.array("position", self.position, ("points", 3))
        on = self.law.point_of_element
        modes, points, elements = frequency.size, len(position), on.size
        expected = {
            "natural_frequency": (modes,),
            "excitation_mode": (modes,),
            "response_mode": (modes,),
            "tangential_mode": (points, modes),
            "position": (points, 3),
            "element_position": (elements, 3),
        }
        if modes == 0:
            raise ValueError("natural_frequency is empty: a structure has at least one mode")
        needs_normal = "normal" in self.law.directions
        if needs_normal != (self.normal_mode is not None):
            verb = "needs" if needs_normal else "has no use for"
            raise ValueError(f"the law {self.law.name!r} {verb} a normal mode")
        if needs_normal:
            expected["normal_mode"] = (points, modes)
        for name, shape in expected.items():
            object.__setattr__(self, name, checks.array(name, getattr(self, name), shape))
        if elements == 0 or on.max() >= points:
            raise ValueError(
                f"point_of_element of the law: elements must sit on points 0 to {points - 1}"
            )

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

    def check_resonance(self, resonance: int) -> int:
        """The number of a resonance, from 1, refused where there are not as many modes."""
        return checks.whole("resonance", resonance, at_least=1, at_most=self.natural_frequency.size)

    def check_excitation(self, resonance: int) -> None:
        """Refuse a resonance that the force does not excite, and a response that is zero.

        The participation ``phi . excitation_mode`` of the stuck mode phi is compared with the modes
        at the excited and at the observed point, whichever are larger: across the width of a
        symmetric structure, or in its clamp, it is nothing but rounding.

        Parameters
        ----------
        resonance
            Which resonance is followed, from 1.

        Raises
        ------
        ValueError
            If the force does not excite it, or the observed point moves in no mode.
        """
        resonance = self.check_resonance(resonance)
        excited, observed = map(np.linalg.norm, (self.excitation_mode, self.response_mode))
        rounding = checks.ROUNDING_OF_MODES * max(excited, observed)
        stiffness = np.diag((2 * np.pi * self.natural_frequency) ** 2) + self.stuck_stiffness()
        squared, vectors = np.linalg.eigh(stiffness)
        own = squared[resonance - 1]
        alike = vectors[:, abs(squared - own) <= _SAME_FREQUENCY * own]
        participation = np.linalg.norm(self.excitation_mode @ alike)
        if participation <= rounding:
            raise ValueError(
                "this force does not excite the modes asked for: excitation_mode has a share of "
                f"{participation:.1g} kg^-1/2 in resonance {resonance}"
            )
        if observed <= rounding:
            raise ValueError(
                "the observed point does not move in the modes asked for: response_mode is at "
                f"most {abs(self.response_mode).max():.1g} kg^-1/2"
            )


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
        If the two datasets do not hold the same pairs, finite numbers, or no pair carries load; or
        if a stiffness or the friction coefficient is not positive.
    """
    tangential_stiffness = checks.number("tangential_stiffness", tangential_stiffness, above=0)
    friction_coefficient = checks.number("friction_coefficient", friction_coefficient, above=0)
    if normal_stiffness is not None:
        normal_stiffness = checks.number("normal_stiffness", normal_stiffness, above=0)
    position, other = (
        checks.variable(name, each, "position", ("pair", "axis"))
        for name, each in (("modes", modes), ("preload", preload))
    )
    if not np.array_equal(position, other):
        raise ValueError("modes and preload were found on different contact pairs")
    normal_load = checks.variable("preload", preload, "normal_load", ("pair",), at_least=0)
    if not np.any(normal_load > 0):
        raise ValueError("no contact pair carries load")
    checks.variable("modes", modes, "relative_mode", ("axis", "pair", "mode"))
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
            normal_load=normal_load
            - normal_stiffness * checks.variable("preload", preload, "gap", ("pair",), at_least=0),
            friction_coefficient=friction_coefficient * each,
        )
    return Joint(
        **{
            name: checks.variable("modes", modes, name, ("mode",))
            for name in ("natural_frequency", "excitation_mode", "response_mode")
        },
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
    checks.instance("joint", joint, Joint)
    region = checks.indices("region", region, (joint.points,))
    size = np.bincount(region)
    if np.any(size == 0):
        raise ValueError(f"region must count from 0 without gaps: no point has {np.argmin(size)}")
    if weight is None:
        share = 1 / size[region]
    else:
        weight = checks.array("weight", weight, region.shape, at_least=0)
        total = np.bincount(region, weight)
        if np.any(total == 0):
            raise ValueError(f"weight is zero in all of region {np.argmin(total)}")
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
    """The joint as the result files keep it (``joint.nc``).

    Raises
    ------
    ValueError
        If its friction is sampled in time, which is no law of its own.
    """
    checks.instance("joint", joint, Joint)
    law = joint.law
    checks.instance("law of the joint", law, *LAWS.values())
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

    Raises
    ------
    ValueError
        As for ``from_dataset`` and ``SampledInTime``.
    """
    found = from_dataset(dataset.load(path))
    if sampling is None:
        return found
    for name in sampling:
        checks.choice("sampling", name, ("harmonics", "samples"))
    return replace(found, law=SampledInTime(found.law, **sampling))


def from_dataset(stored: xr.Dataset) -> Joint:
    """The joint that ``joint.nc`` describes.

    Raises
    ------
    ValueError
        If the law is one this version does not know, or the dataset does not describe a joint.
    """
    checks.instance("stored", stored, xr.Dataset)
    law = LAWS[checks.choice("law", stored.attrs.get("law"), LAWS)]
    on = checks.index_variable("stored", stored, "point_of_element", ("element",))
    of_points = ("tangential_mode", *(["normal_mode"] if "normal_mode" in stored else []))
    dims = {
        **dict.fromkeys(("natural_frequency", "excitation_mode", "response_mode"), ("mode",)),
        **dict.fromkeys(of_points, ("point", "mode")),
        "position": ("point", "axis"),
        "element_position": ("element", "axis"),
    }
    return Joint(
        law=law(on, **{name: _stored(stored, name, ("element",)) for name in law.quantities}),
        **{name: _stored(stored, name, of_name) for name, of_name in dims.items()},
    )


def _stored(stored: xr.Dataset, name: str, dims: tuple[str, ...]) -> NDArray[np.float64]:
    return checks.variable("stored", stored, name, dims)
