"""Joints as netCDF datasets (``joint.nc``)."""

import logging
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks, dataset
from boltjoint.dataset import quantity
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.combined import CombinedLaw
from boltjoint.friction.declarations import AND
from boltjoint.friction.element_law import ElementLaw
from boltjoint.friction.registry import LAWS
from boltjoint.joint.model import MODES, Joint
from boltjoint.joint.surface_places import SurfacePlaces, surfaces_of

logger = logging.getLogger(__name__)

#: the attribute of a dataset that stands for a joint which is impossible: its reason
_IMPOSSIBLE = "impossible"

#: relative mode in each direction of motion
_RELATIVE_MODES = {
    "tangential": "relative mode along the first tangent, side A minus side B",
    "lateral": "relative mode along the second tangent, side A minus side B",
    "normal": "relative mode along the normal, positive when closing",
}


#: what files of joints keep of those of modes: what tells where their model ends
_OF_LIMITS = (
    *("structure_length", "farthest_mode", "hole_clearance", "hole_mode"),
    *("yield_strength", "stress_mode"),
)
#: what files of reduced joints keep of those they were made from
_OF_MODES = ("basis_frequency_error", "basis_amplitude_error", *_OF_LIMITS)

#: sources of the errors of peaks that are estimated where a model is made, and the words on them
_ESTIMATED = {"basis": "of the basis", "weights": "of the weights of contact pairs"}


class ImpossibleJoint(ValueError):
    """A joint that cannot be made, with its reason."""


def save_joint(
    make: Callable[[], xr.Dataset],
    path: str | Path,
    parameters: Mapping[str, object],
    of_sweep: bool = False,
) -> None:
    """Write the dataset of a joint.

    Parameters
    ----------
    make
        Gives the dataset.
    path, parameters
        As for ``dataset.save``.
    of_sweep
        Whether only designs of sweeps have this joint: one that is impossible is written with its
        reason then, as which ``joint_from_dataset`` raises it, and other designs are solved.

    Raises
    ------
    ValueError
        As from ``make``, where the joint is not of sweeps alone.
    """
    try:
        stored = make()
    except ValueError as error:
        if not of_sweep:
            raise
        logger.warning("designs with this joint are impossible: %s", error)
        stored = xr.Dataset(attrs={_IMPOSSIBLE: str(error)})
    dataset.save(stored, path, parameters)


def joint_to_dataset(
    joint: Joint, reduced_from: xr.Dataset | None = None, fit: xr.Dataset | None = None
) -> xr.Dataset:
    """The dataset of a joint.

    Its ``resonance_range`` holds that of the joint which it was reduced from too, so that
    responses of both are solved in one frequency window.

    Parameters
    ----------
    joint
        The joint.
    reduced_from
        Dataset of the joint from which it was made, if it is a reduced one.
    fit
        How it was made, which the dataset holds too: as from ``weigh_pairs`` or ``reduce_joint``.

    Raises
    ------
    ValueError
        If friction is evaluated by AFT: files hold the law itself; or if the fit has a variable or
        attribute of the joint with another value.
    """
    law = checks.instance("joint", joint, Joint).contact.element_law
    between = joint.resonance_range()
    if reduced_from is not None:
        bounds = checks.variable(
            "reduced_from", reduced_from, "resonance_range", ("resonance", "bound")
        )
        lowest, highest = np.minimum(between, bounds)[:, 0], np.maximum(between, bounds)[:, 1]
        between = np.column_stack([lowest, highest])
    stored: dict[str, xr.Variable | xr.DataArray] = {
        "resonance_range": quantity(
            ("resonance", "bound"),
            between,
            "Hz",
            "resonance without contact, and while nothing slips",
        ),
        "natural_frequency": quantity(
            "mode", joint.natural_frequency, "Hz", "natural frequency without contact"
        ),
        **_excitation_and_sensors(joint),
        "tangential_mode": _relative_mode(joint, "tangential"),
        "position": quantity(("point", "axis"), joint.position, "m", "contact point"),
        **({} if joint.places is None else _places(joint.places)),
        "point_of_element": quantity(
            "element", law.point_of_element, "1", "contact point of the element, from 0"
        ),
        "element_position": quantity(
            ("element", "axis"), joint.element_position, "m", "position of the element"
        ),
    }
    further = [direction for direction in law.directions if direction != "tangential"]
    stored |= {MODES[direction]: _relative_mode(joint, direction) for direction in further}
    if joint.free_frequency is not None and joint.free_participation is not None:
        stored |= free_mode_quantities(joint.free_frequency, joint.free_participation)
    meaning = "slip force of the element in the assembled state"
    stored["slip_force"] = quantity("element", law.slip_force, "N", meaning)
    for name, (unit, meaning) in law.quantities.items():
        stored[name] = quantity("element", law.quantity(name), unit, meaning)
    if reduced_from is not None:
        stored |= {name: reduced_from[name] for name in _OF_MODES if name in reduced_from}
    if isinstance(law, CombinedLaw):
        meaning = "law of the element, by its place in the names of law"
        stored["law_of_element"] = quantity("element", law.part_of_element, "1", meaning)
    made = xr.Dataset(stored, coords={"axis": ["x", "y", "z"]}, attrs={"law": law.name})
    return made if fit is None else made.merge(fit, combine_attrs="no_conflicts")


def _places(places: SurfacePlaces) -> dict[str, xr.Variable]:
    """Surfaces of the contact points and their places there."""
    of_surface = {"units": "1", "long_name": "surface of the contact point"}
    meaning = "place of the contact point along the tangents of its surface"
    return {
        "surface": xr.Variable("point", places.name.astype(object), of_surface),
        "place": quantity(("point", "tangent"), places.place, "m", meaning),
    }


def _relative_mode(joint: Joint, direction: str) -> xr.Variable:
    """The relative modes of the contact points in a direction."""
    mode = getattr(joint, MODES[direction])
    return quantity(("point", "mode"), mode, "kg^-1/2", _RELATIVE_MODES[direction])


def basis_errors_and_limits(modes: xr.Dataset) -> dict[str, xr.Variable]:
    """Estimated errors of peaks by the basis, and limits of the model, as ``joint.nc`` holds them.

    Parameters
    ----------
    modes
        ``modes.nc``, with ``estimated_frequency_error`` and ``estimated_amplitude_error`` of a
        contact-adapted basis among its attributes, and variables of limits; none of those that it
        does not have.
    """
    limits = {name: modes[name].variable for name in _OF_LIMITS if name in modes}
    return limits | {
        f"basis_{what}_error": quantity(
            (), float(modes.attrs[attribute]), "1", "of a peak, relative"
        )
        for what in ("frequency", "amplitude")
        if (attribute := f"estimated_{what}_error") in modes.attrs
    }


def model_errors(stored: xr.Dataset) -> xr.Dataset:
    """Estimated errors of the peaks of a joint by its model, relative.

    Parameters
    ----------
    stored
        ``joint.nc``.

    Returns
    -------
    Dataset
        ``basis_frequency_error``, ``basis_amplitude_error``, ``weights_frequency_error`` and
        ``weights_amplitude_error``: not a number where nothing is estimated; those of the weights
        are 0 of a joint without.
    """
    errors = {}
    for what in ("frequency", "amplitude"):
        none = np.nan if "weight" in stored else 0.0
        estimates = {
            "basis": stored.get(f"basis_{what}_error", np.nan),
            "weights": stored.get(f"estimated_{what}_error", none),
        }
        for of, words in _ESTIMATED.items():
            meaning = f"estimated error {words} in peak_{what}, relative"
            errors[f"{of}_{what}_error"] = quantity((), float(estimates[of]), "1", meaning)
    return xr.Dataset(errors)


def free_mode_quantities(
    frequency: NDArray[np.float64],
    participation: NDArray[np.float64],
    of: str = "mode",
    unit: str = "1",
) -> dict[str, xr.Variable]:
    """Modes without contact in other vectors, as files hold them.

    Parameters
    ----------
    frequency
        Their natural frequencies [Hz], shape (free modes,).
    participation
        ``phi_r^T M`` times the vectors, shape (free modes, vectors).
    of, unit
        Dimension of the vectors, and unit of the participation.
    """
    meaning = "participation of the mode without contact in the vector, by mass"
    return {
        "free_frequency": quantity(
            "free_mode", frequency, "Hz", "natural frequency of a mode without contact"
        ),
        "free_participation": quantity(("free_mode", of), participation, unit, meaning),
    }


def _excitation_and_sensors(joint: Joint) -> dict[str, xr.Variable]:
    """Modes at the excitation, the output point and the sensors."""
    unit = "kg^-1/2" if joint.excitation_unit == "N" else "kg^1/2"
    parts = {"sine": joint.excitation_mode, "cosine": joint.excitation_mode_cos}
    names = {"sine": "excitation_mode", "cosine": "excitation_mode_cos"}
    stored = {
        names[part]: quantity("mode", mode, unit, f"mode at the excitation, {part} part")
        for part, mode in parts.items()
        if mode is not None
    }
    stored["excitation_mode"].attrs["level_units"] = joint.excitation_unit
    stored["response_mode"] = quantity(
        "mode", joint.response_mode, "kg^-1/2", "mode at the observed point"
    )
    if joint.sensor_mode is not None:
        at_sensors = ("sensor", "mode"), joint.sensor_mode, "kg^-1/2", "mode at the sensor"
        stored["sensor_mode"] = quantity(*at_sensors)
        stored["sensor"] = xr.Variable("sensor", list(joint.sensor_name))
    return stored


def load_joint(path: str | Path, sampling: Mapping[str, int] | None = None) -> Joint:
    """The joint in a file, with its friction law in closed form or by AFT.

    Parameters
    ----------
    path
        ``joint.nc``.
    sampling
        ``harmonics`` and ``samples`` of ``AlternatingFrequencyTime``; closed form without.

    Returns
    -------
    Joint
        As it was stored.

    Raises
    ------
    ValueError
        As for ``joint_from_dataset`` and ``AlternatingFrequencyTime``.
    """
    return joint_from_dataset(dataset.load(path), sampling)


def joint_from_dataset(stored: xr.Dataset, sampling: Mapping[str, int] | None = None) -> Joint:
    """The joint that a dataset describes, with its friction law in closed form or by AFT.

    Parameters
    ----------
    stored
        ``joint.nc``.
    sampling
        As for ``load_joint``.

    Raises
    ------
    ImpossibleJoint
        If ``save_joint`` wrote a reason in place of a joint.
    ValueError
        If the law is not known, the dataset does not describe a joint, or as for
        ``AlternatingFrequencyTime``.
    """
    checks.instance("stored", stored, xr.Dataset)
    if _IMPOSSIBLE in stored.attrs:
        raise ImpossibleJoint(stored.attrs[_IMPOSSIBLE])
    values = partial(checks.variable, "stored", stored)
    elements = _stored_elements(stored)
    if sampling is not None:
        checks.mapping("sampling", sampling, ("harmonics", "samples"))
    rows = {
        name: values(name, ("point", "mode"))
        for name in MODES.values()
        if name in stored or name == "tangential_mode"
    }
    return Joint(
        law=elements if sampling is None else AlternatingFrequencyTime(elements, **sampling),
        natural_frequency=values("natural_frequency", ("mode",)),
        excitation_mode=values("excitation_mode", ("mode",)),
        response_mode=values("response_mode", ("mode",)),
        tangential_mode=rows["tangential_mode"],
        lateral_mode=rows.get("lateral_mode"),
        normal_mode=rows.get("normal_mode"),
        position=values("position", ("point", "axis")),
        element_position=values("element_position", ("element", "axis")),
        **optional_fields("stored", stored),
        places=_stored_places(stored),
    )


def _stored_elements(stored: xr.Dataset) -> ElementLaw:
    """The friction elements of one law, or of several whose names stand one after another."""
    values = partial(checks.variable, "stored", stored)
    on = checks.index_variable("stored", stored, "point_of_element", ("element",))
    named: Any = stored.attrs.get("law")
    names = named.split(AND) if isinstance(named, str) else [named]
    laws = [LAWS[checks.choice("law", name, LAWS)] for name in names]
    if len(laws) == 1:
        return laws[0](on, **{name: values(name, ("element",)) for name in laws[0].quantities})
    part = checks.index_variable("stored", stored, "law_of_element", ("element",), count=len(laws))
    if np.any(np.diff(part) < 0):
        raise ValueError("law_of_element of stored must not fall: elements stand by their law")
    parts = []
    for number, law in enumerate(laws):
        mine = np.flatnonzero(part == number)
        of_part = stored.isel(element=mine)
        quantities = {
            name: checks.variable("stored", of_part, name, ("element",)) for name in law.quantities
        }
        parts.append(law(on[mine], **quantities))
    return CombinedLaw(tuple(parts))


def _stored_places(stored: xr.Dataset) -> SurfacePlaces | None:
    """What ``_places`` stored; None of files from before it did."""
    if "place" not in stored:
        return None
    place = checks.variable("stored", stored, "place", ("point", "tangent"))
    return SurfacePlaces(surfaces_of("stored", stored, "point"), place)


def optional_fields(name: str, stored: xr.Dataset) -> dict[str, Any]:
    """Fields of a joint with a default that a dataset of this name holds."""
    fields: dict[str, Any] = {}
    if "excitation_mode_cos" in stored:
        mode = checks.variable(name, stored, "excitation_mode_cos", ("mode",))
        fields["excitation_mode_cos"] = mode
    if "sensor_mode" in stored:
        fields["sensor_mode"] = checks.variable(name, stored, "sensor_mode", ("sensor", "mode"))
        fields["sensor_name"] = tuple(stored["sensor"].to_numpy().astype(str).tolist())
    if "level_units" in stored["excitation_mode"].attrs:
        fields["excitation_unit"] = stored["excitation_mode"].attrs["level_units"]
    if "free_participation" in stored:
        dims = {"free_frequency": ("free_mode",), "free_participation": ("free_mode", "mode")}
        fields |= {field: checks.variable(name, stored, field, dims[field]) for field in dims}
    return fields
