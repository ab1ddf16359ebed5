"""Joints as netCDF datasets (``joint.nc``)."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import xarray as xr

from boltjoint import checks, dataset
from boltjoint.dataset import quantity
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint

#: the laws that a joint can have, by their name
LAWS = {law.name: law for law in (ConstantLoad, VariableLoad, TabulatedLoad)}


def joint_to_dataset(joint: Joint) -> xr.Dataset:
    """The dataset of a joint.

    Raises
    ------
    ValueError
        If friction is evaluated by AFT: files hold the law itself.
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


def load_joint(path: str | Path, sampling: Mapping[str, int] | None = None) -> Joint:
    """The joint in a file, with its friction law in closed form or by AFT.

    Parameters
    ----------
    path
        ``joint.nc``.
    sampling
        ``harmonics`` and ``samples`` of ``AlternatingFrequencyTime``; closed form without.

    Raises
    ------
    ValueError
        As for ``joint_from_dataset`` and ``AlternatingFrequencyTime``.
    """
    found = joint_from_dataset(dataset.load(path))
    if sampling is None:
        return found
    for name in sampling:
        checks.choice("sampling", name, ("harmonics", "samples"))
    return replace(found, law=AlternatingFrequencyTime(found.law, **sampling))


def joint_from_dataset(stored: xr.Dataset) -> Joint:
    """The joint that a dataset describes.

    Raises
    ------
    ValueError
        If the law is not known, or the dataset does not describe a joint.
    """
    checks.instance("stored", stored, xr.Dataset)
    values = partial(checks.variable, "stored", stored)
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
        law=law(on, **{name: values(name, ("element",)) for name in law.quantities}),
        **{name: values(name, of_name) for name, of_name in dims.items()},
    )
