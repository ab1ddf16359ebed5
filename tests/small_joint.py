"""A joint small enough for tests, with loads and relative modes that vary along it."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.registry import LAWS
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint
from boltjoint.joint.node_to_node import connect_pairs

FRICTION = 0.1


def make_joint(pairs: int = 60, seed: int = 1, law: str = "constant") -> Joint:
    """A bar with three modes and many pairs whose loads and relative modes vary along it.

    Of the elements under variable load, those between two of the three bolts are open.
    """
    random = np.random.default_rng(seed)
    x = np.sort(random.uniform(0.0, 0.1, pairs))
    y = random.uniform(-0.01, 0.01, pairs)
    along = np.column_stack([0.04 + 0.3 * x, -0.1 + 1.5 * x, 0.1 * np.sin(60 * x)])
    across = np.column_stack([0.03 - 0.2 * x, 0.05 + 0.4 * x, -0.08 * np.cos(40 * x)])
    load = 300.0 / pairs * (1.2 + np.cos(2 * np.pi * x / 0.033)) * random.uniform(0.5, 1.5, pairs)
    position = np.column_stack([x, y, np.zeros(pairs)])
    points, stiffness = np.arange(pairs), np.full(pairs, 3e8 / pairs)
    laws = {
        "constant": ConstantLoad(points, stiffness, load),
        "variable": VariableLoad(
            points,
            stiffness,
            2 * stiffness,
            (load - 0.5 * load.mean()) / FRICTION,
            np.full(pairs, FRICTION),
        ),
        "iwan": FourParameterIwan(
            points, stiffness, load, np.linspace(-0.8, 0.0, pairs), np.linspace(0.0, 2.0, pairs)
        ),
    }
    return Joint(
        natural_frequency=np.array([70.0, 360.0, 950.0]),
        excitation_mode=np.array([2.0, -1.9, 1.8]),
        response_mode=np.array([2.0, -1.9, 1.8]),
        tangential_mode=along,
        position=position,
        law=laws[law],
        element_position=position,
        normal_mode=across if law == "variable" else None,
    )


def make_preload(joint: Joint) -> xr.Dataset:
    """The contact under bolt preload that a joint of ``make_joint`` may have been made from."""
    law = joint.law
    open_by = np.zeros(joint.points)
    if isinstance(law, VariableLoad):
        open_by = np.maximum(-law.normal_load, 0) / law.normal_stiffness
    return xr.Dataset(
        {
            "normal_load": ("pair", law.slip_force / FRICTION),
            "gap": ("pair", open_by),
            "area": ("pair", np.full(joint.points, 1e-6)),
            "position": (("pair", "axis"), joint.position),
        },
        coords={"axis": ["x", "y", "z"]},
    )


def make_two_pairs() -> tuple[xr.Dataset, xr.Dataset]:
    """One mode, and a preload, at two contact pairs of which one is open."""
    axes, position = {"axis": ["x", "y", "z"]}, (("pair", "axis"), np.zeros((2, 3)))
    modes = {
        "natural_frequency": ("mode", [50.0]),
        "excitation_mode": ("mode", [1.0]),
        "response_mode": ("mode", [1.0]),
        "relative_mode": (("axis", "pair", "mode"), np.ones((3, 2, 1))),
        "position": position,
    }
    carried = {
        "normal_load": ("pair", [1.0, 0.0]),
        "gap": ("pair", [0.0, 1e-6]),
        "position": position,
    }
    return xr.Dataset(modes, axes), xr.Dataset(carried, axes)


def connect_small(
    law: str,
    keys: Mapping[str, float],
    preload_ratio: float = 1.0,
    surface: Sequence[str] | None = None,
) -> tuple[Joint, xr.Dataset]:
    """The same bar with any contact of its pairs under a preload, and that preload.

    The areas of the pairs differ. They lie on one ``surface``, or on one each.
    """
    joint = make_joint(law="variable")
    preload = make_preload(joint)
    preload["area"] = ("pair", np.linspace(0.5e-6, 2e-6, joint.points))
    if surface is not None:
        preload["surface"] = ("pair", np.array(surface, dtype=object))
    for name in ("normal_load", "gap"):
        preload[name] = preload_ratio * preload[name]
    relative = np.stack([joint.tangential_mode, 0 * joint.tangential_mode, joint.normal_mode])
    of_modes = {
        name: ("mode", getattr(joint, name))
        for name in ("natural_frequency", "excitation_mode", "response_mode")
    }
    modes = xr.Dataset(
        {
            **of_modes,
            "relative_mode": (("axis", "pair", "mode"), relative),
            "position": preload["position"],
        },
        coords={"axis": ["x", "y", "z"]},
    )
    return connect_pairs(modes, preload, LAWS[law], **keys), preload
