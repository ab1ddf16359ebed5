"""Node-to-node joints: one friction element on each contact pair.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: eq. 3.4.
"""

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint, optional_fields


def connect_nodes(
    modes: xr.Dataset,
    preload: xr.Dataset,
    tangential_stiffness: float,
    friction_coefficient: float,
    normal_stiffness: float | None = None,
) -> Joint:
    """Joint with one friction element on each contact pair.

    Without a normal stiffness, the pairs that carry load have elements under constant normal load.
    With it, all pairs have elements under variable normal load; the load of an open one is
    ``-k_v gap`` (eq. 3.4), so that it may close.

    Parameters
    ----------
    modes, preload
        As from ``find_modes`` and ``apply_preload``, for the same pairs.
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
        **optional_fields("modes", modes),
        tangential_mode=along_bar[pairs],
        position=position[pairs],
        law=law,
        element_position=position[pairs],
        normal_mode=None if normal_stiffness is None else closing[pairs],
    )
