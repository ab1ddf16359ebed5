"""Modes at the places that decide how far a model holds (``structure.model_limits``).

Modes are kept at the few places where one of them is largest: nodes, holes of bolts, and cells. So
what motions of several modes reach there is at least what they reach. The stress is nominal: that
at the centre of a cell, of cells none of whose nodes shares a degree of freedom with the contact.
"""

from typing import cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantity
from boltjoint.structure.bolt_tension import distance_to_bolts
from boltjoint.structure.geometry import CentreStresses, Geometry
from boltjoint.structure.model import Bolt, Structure
from boltjoint.structure.model_limits import DISPLACEMENT, SLIP, STRESS

Array = NDArray[np.float64]

#: contact points at the edge of a hole: their distance from the axis, over that of the nearest
_AT_EDGE = 1.1

#: stress of a mode over that of the most stressed one, below which it is none
_STRESSED = 1e-9


def modes_at_limits(structure: Structure, q: Array) -> dict[str, xr.Variable]:
    """What limits the model of a structure, with the modes at the places that decide.

    Parameters
    ----------
    structure
        Whose geometry, holes and strengths are compared, where they are known.
    q
        Its modes, shape (dofs, modes).

    Returns
    -------
    dict
        ``structure_length`` [m], the largest extent along an axis, and ``farthest_mode`` (farthest,
        axis, mode) [kg^-1/2] of one node for each mode, each node once. ``hole_clearance`` (hole)
        [m], and ``hole_mode`` (hole, tangent, mode) [kg^-1/2], side A minus side B along the
        tangents, the mean of the contact points at the edge. ``yield_strength`` (stressed) [Pa],
        and ``stress_mode`` (stressed, stress, mode) [Pa kg^-1/2 m^-1] of the cell that each mode
        stresses most, whose length is the stress of von Mises.
    """
    shape = None if structure.geometry is None else structure.geometry.shape(q)
    return {
        **_of_nodes(structure.geometry, shape),
        **_of_holes(structure, q),
        **_of_cells(structure, shape),
    }


def _of_nodes(geometry: Geometry | None, shape: Array | None) -> dict[str, xr.Variable]:
    if geometry is None or shape is None:
        return {}
    length = np.ptp(geometry.node, axis=0).max()
    farthest = np.unique(np.linalg.norm(shape, axis=1).argmax(axis=0))
    dims, meaning = ("farthest", "axis", "mode"), "mode of a node that moves most in one of them"
    return {
        DISPLACEMENT.limit: quantity((), float(length), "m", "largest extent of the structure"),
        DISPLACEMENT.modes: quantity(dims, shape[farthest], "kg^-1/2", meaning),
    }


def _of_holes(structure: Structure, q: Array) -> dict[str, xr.Variable]:
    bolts = [bolt for bolt in structure.bolts if bolt.hole_clearance is not None]
    if not bolts:
        return {}
    relative = (structure.contact.relative @ q).reshape(len(structure.contact), 3, -1)
    modes = np.array([_at_edge(bolt, structure, relative[:, :2]) for bolt in bolts])
    clearance = np.array([bolt.hole_clearance for bolt in bolts], float)
    dims, meaning = ("hole", "tangent", "mode"), "mean slip of the bodies at the edge of a hole"
    return {
        SLIP.modes: quantity(dims, modes, "kg^-1/2", meaning),
        SLIP.limit: quantity("hole", clearance, "m", "diameter of the hole less that of the shank"),
    }


def _at_edge(bolt: Bolt, structure: Structure, relative: Array) -> Array:
    """Mean of relative modes (points, tangents, modes) at the edge of a bolt's hole."""
    # a bolt with a clearance has an axis
    distance = cast(Array, distance_to_bolts([bolt], structure.contact.position))
    return np.asarray(relative[distance <= _AT_EDGE * distance.min()].mean(axis=0), float)


def _of_cells(structure: Structure, shape: Array | None) -> dict[str, xr.Variable]:
    geometry = structure.geometry
    if geometry is None or geometry.material is None or shape is None:
        return {}
    strength = geometry.material.yield_strength
    judged = np.flatnonzero(np.isfinite(strength) & ~_touch_contact(structure, geometry))
    if not judged.size:
        return {}
    modes, stresses = np.moveaxis(shape, 2, 0), CentreStresses(geometry, judged)
    share = [np.linalg.norm(stresses(mode), axis=1) / strength[judged] for mode in modes]
    # rigid-body modes have stresses of rounding
    least = _STRESSED * max(of_mode.max() for of_mode in share)
    stressed = judged[np.unique([one.argmax() for one in share if one.max() > least])]
    stresses = CentreStresses(geometry, stressed)
    dims, meaning = ("stressed", "stress", "mode"), "its length is the stress of von Mises"
    of_modes = np.stack([stresses(mode) for mode in modes], axis=-1)
    return {
        STRESS.modes: quantity(dims, of_modes, "Pa kg^-1/2 m^-1", meaning),
        STRESS.limit: quantity("stressed", strength[stressed], "Pa", "yield strength"),
    }


def _touch_contact(structure: Structure, geometry: Geometry) -> NDArray[np.bool_]:
    """Whether a node of each cell moves with the contact points, shape (cells,)."""
    moves_contact = np.zeros(structure.dofs, bool)
    moves_contact[structure.contact.relative.tocoo().coords[1]] = True
    moved = geometry.displacement.tocsr()[:, moves_contact]
    in_contact = np.diff(moved.indptr).reshape(-1, 3).any(axis=1)
    return np.asarray((in_contact[geometry.cell] & (geometry.cell >= 0)).any(axis=1), bool)
