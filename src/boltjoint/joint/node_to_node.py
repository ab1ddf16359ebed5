"""Node-to-node joints: one friction element on each contact pair, of any law.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: eq. 3.4.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.combined import elements_of_pairs
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.declarations import AXES, is_per_area
from boltjoint.friction.element_law import ContactPairs, ElementLaw
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.io import optional_fields
from boltjoint.joint.model import Joint
from boltjoint.joint.surface_places import SurfacePlaces, surfaces_of


def connect_nodes(
    modes: xr.Dataset,
    preload: xr.Dataset,
    tangential_stiffness: float | NDArray[np.float64],
    friction_coefficient: float | NDArray[np.float64],
    normal_stiffness: float | NDArray[np.float64] | None = None,
) -> Joint:
    """Joint with one Coulomb friction element on each contact pair.

    Without a normal stiffness, the pairs that carry load have elements under constant normal load.
    With it, all pairs have elements under variable normal load; the load of an open one is
    ``-k_v gap`` (eq. 3.4), so that it may close. For any law there is ``connect_pairs``.

    Parameters
    ----------
    modes, preload
        As from ``find_modes`` and ``apply_preload``, for the same pairs.
    tangential_stiffness
        k_u of every pair [N/m], or of each, shape (pairs,): one per area times ``area(pair)``.
    friction_coefficient
        mu of every pair [-], or of each, shape (pairs,).
    normal_stiffness
        k_v of every pair [N/m], or of each, shape (pairs,).

    Returns
    -------
    Joint
        With an element on each pair that has one.

    Raises
    ------
    ValueError
        As for ``connect_pairs``.
    """
    k_u, mu = tangential_stiffness, friction_coefficient
    if normal_stiffness is None:
        return connect_pairs(
            modes, preload, ConstantLoad, tangential_stiffness=k_u, friction_coefficient=mu
        )
    return connect_pairs(
        modes,
        preload,
        VariableLoad,
        tangential_stiffness=k_u,
        friction_coefficient=mu,
        normal_stiffness=normal_stiffness,
    )


def connect_pairs(
    modes: xr.Dataset,
    preload: xr.Dataset,
    law: type[ElementLaw] | str,
    surfaces: Mapping[str, Mapping[str, Any]] | None = None,
    **keys: float | NDArray[np.float64],
) -> Joint:
    """Joint with one element of a friction law on each contact pair that the law gives one.

    Parameters
    ----------
    modes, preload
        As from ``find_modes`` and ``apply_preload``, for the same pairs.
    law
        One of ``friction.registry.LAWS``, or its name.
    surfaces
        By the names of surfaces of the preload, those keys whose values replace those of all there,
        of each pair or per area; and ``law``, where the surface has another one.
    keys
        As for ``from_contact`` of the law, in SI units; or per area, as
        ``tangential_stiffness_per_area`` [N/m3], which is multiplied by ``area(pair)`` of the
        preload.

    Raises
    ------
    ValueError
        If the two datasets do not hold the same pairs, finite numbers, or no pair carries load; if
        a key is out of its range, or given for each pair and per area; or if there is no such
        surface, it has a key that is not given for all, or none that its own law needs.
    """
    position, other = (
        checks.variable(name, dataset, "position", ("pair", "axis"))
        for name, dataset in (("modes", modes), ("preload", preload))
    )
    if not np.array_equal(position, other):
        raise ValueError("modes and preload were found on different contact pairs")
    normal_load, gap = (
        checks.variable("preload", preload, name, ("pair",), at_least=0)
        for name in ("normal_load", "gap")
    )
    if not np.any(normal_load > 0):
        raise ValueError("no contact pair carries load")
    checks.variable("modes", modes, "relative_mode", ("axis", "pair", "mode"))
    relative = modes["relative_mode"].transpose("axis", "pair", "mode")
    contact = ContactPairs(normal_load, gap, position)
    if surfaces or any(map(is_per_area, keys)):
        area = checks.variable("preload", preload, "area", ("pair",), above=0)
        surface = surfaces_of("preload", preload, "pair")
        contact = ContactPairs(normal_load, gap, position, area, surface)
    elements, pairs = elements_of_pairs(contact, law, surfaces, **keys)
    rows = {
        direction: relative.sel(axis=AXES[direction]).to_numpy()[pairs]
        for direction in elements.directions
    }
    return Joint(
        natural_frequency=checks.variable("modes", modes, "natural_frequency", ("mode",)),
        excitation_mode=checks.variable("modes", modes, "excitation_mode", ("mode",)),
        response_mode=checks.variable("modes", modes, "response_mode", ("mode",)),
        **optional_fields("modes", modes),
        tangential_mode=rows["tangential"],
        lateral_mode=rows.get("lateral"),
        normal_mode=rows.get("normal"),
        position=position[pairs],
        places=SurfacePlaces.of("preload", preload).at(pairs),
        law=elements,
        element_position=position[pairs][elements.point_of_element],
    )
