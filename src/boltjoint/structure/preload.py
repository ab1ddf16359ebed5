"""Static equilibrium under bolt preload: normal load and gap of every contact pair.

Each shank is cut in its middle and its ends overlap until the bolt carries its preload. The bars
are in unilateral, frictional (Coulomb) node-to-node contact, after an initial gap if there is one.
Both laws are made single-valued by a stiff penalty, and the equilibrium is found by the semismooth
Newton method, for which an open, a sticking and a slipping pair are three branches of one piecewise
smooth law. Where structure, preload and initial gap are symmetric, half of the unknowns are enough.

References
----------
P. Alart, A. Curnier: A mixed formulation for frictional contact problems prone to Newton like
solution methods. Computer Methods in Applied Mechanics and Engineering 92 (1991) 353-375.
H. Matthies, G. Strang: The solution of nonlinear finite element equations. International Journal
for Numerical Methods in Engineering 14 (1979) 1613-1626.
"""

import logging
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.bolt_tension import share_of_yield, tension_of, yield_warning
from boltjoint.structure.contact_equilibrium import ContactEquilibrium, solve_contact
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.model import Structure
from boltjoint.structure.subspaces import Subspace, symmetric, whole

logger = logging.getLogger(__name__)


Array = NDArray[np.float64]

_SHORTENING = "shortening of the shank by tightening"


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def apply_preload(
    assembly: xr.Dataset | Structure,
    preload: float | Sequence[float],
    *,
    tolerance: float = 1e-10,
    maximum_iterations: int = 40,
) -> xr.Dataset:
    """Contact under the preload of all bolts, as ``preload.nc`` holds it.

    Normal loads that the contact points have already are taken as they are, and tension of bolts
    and equilibrium are not asked for.

    Parameters
    ----------
    assembly
        A structure, or an assembly of a maker. Points with an initial gap meet when that is closed.
    preload
        Tension of the bolts [N]: a number for all, or one for each, of which some may be 0.
    tolerance
        Largest unbalanced force relative to the largest preload.
    maximum_iterations
        Newton iterations after which the search ends.

    Returns
    -------
    Dataset
        ``normal_load`` (pair) [N], 0 where open; ``gap`` (pair) [m], 0 where closed;
        ``friction_force`` (pair, plane) [N] on side B along the first and the second tangent;
        ``position`` (pair, axis) [m]; ``area`` (pair) [m2]; ``shank_shortening`` (bolt) [m];
        ``displacement`` (node, axis) [m]; ``residual`` (iterate) and ``iterations``; attribute
        ``preload_N``, of all bolts or of each; ``initial_gap`` (pair) [m] where the assembly has
        one.

    Raises
    ------
    ValueError
        If preload, tolerance or iterations are not positive, bolts and preloads are not as many,
        or a variable of the assembly is missing.
    RuntimeError
        If no equilibrium is found.
    """
    structure = structure_of(assembly)
    contact = structure.contact
    if contact.normal_load is not None:
        return _as_given(contact, contact.normal_load, checks.number("preload", preload, above=0))
    tension = tension_of(preload, len(structure.bolts))
    if not structure.bolts:
        raise ValueError("the structure has no bolts that could be tightened")
    largest = float(tension.max())
    _warn_of_yield(structure, tension)
    # The work of the bolt forces on the shortening of their shanks. All grows with preload and
    # initial gap, so that a preload of 1 N has the same iterates: only ratios to it matter.
    force = sum(
        load / largest * bolt.load for load, bolt in zip(tension, structure.bolts, strict=True)
    )
    gap = contact.gap / largest

    part = _part_of(structure, force)
    equilibrium = _equilibrium(structure, part, force, gap, tolerance, maximum_iterations)
    corrections, residual = len(equilibrium.residual) - 1, equilibrium.residual[-1]
    if not equilibrium.converged:
        raise RuntimeError(
            f"preload {largest:g} N: no equilibrium after {corrections} corrections, the largest "
            f"unbalanced force is {residual:.1e} of the preload: choose contact.penalty_N_per_m3 "
            "of the assembly nearer to 1e15, or the material nearer to steel, since stiffnesses "
            "too far apart are lost in rounding"
        )
    opening = largest * np.maximum(gap - equilibrium.relative[:, 2], 0.0)
    q = part.basis @ part.unsupported(largest * equilibrium.unknown)
    contact_force = largest * equilibrium.force
    normal_load = contact_force[:, 2]
    logger.info(
        "preload %s N: equilibrium after %d corrections, residual %.1e; %d of %d pairs carry %g N",
        preload,
        corrections,
        residual,
        np.count_nonzero(normal_load),
        len(normal_load),
        normal_load.sum(),
    )
    variables = _variables(structure, q, contact_force, opening, equilibrium.residual)
    return _dataset(variables, preload)


def _as_given(contact: ContactPoints, load: Array, preload: float) -> xr.Dataset:
    """What ``preload.nc`` holds of loads that are given: of no bolts, without friction."""
    if not load.any():
        raise ValueError("normal_load of the contact points is zero: nothing is pressed together")
    logger.info(
        "%d of %d pairs carry %g N, as given", np.count_nonzero(load), load.size, load.sum()
    )
    friction = np.zeros((load.size, 2))
    variables = {
        **_of_pairs(contact, load, contact.gap, friction),
        "shank_shortening": quantity("bolt", np.zeros(0), "m", _SHORTENING),
        **_newton(np.zeros(0), 0),
    }
    return _dataset(variables, preload)


def _of_pairs(
    contact: ContactPoints, normal_load: Array, gap: Array, friction_force: Array
) -> dict[str, xr.Variable]:
    """Normal load, gap, friction and places of all pairs."""
    friction = ("pair", "plane"), friction_force, "N", "friction force on side B"
    return {
        "normal_load": quantity("pair", normal_load, "N", "normal load of the contact pair"),
        "gap": quantity("pair", gap, "m", "opening"),
        "friction_force": quantity(*friction),
        **contact.variables(),
    }


def _newton(residual: Array, corrections: int) -> dict[str, xr.Variable]:
    """How the equilibrium was found; nothing where it was not sought."""
    return {
        "residual": quantity("iterate", residual, "1", "largest unbalanced force over preload"),
        "iterations": quantity((), corrections, "1", "Newton corrections"),
    }


def _dataset(variables: dict[str, xr.Variable], preload: float | Sequence[float]) -> xr.Dataset:
    axes = {"axis": ["x", "y", "z"], "plane": ["x", "y"]}
    return xr.Dataset(variables, coords=axes, attrs={"preload_N": preload})


def _equilibrium(
    structure: Structure,
    part: Subspace,
    force: Array,
    gap: Array,
    tolerance: float,
    maximum_iterations: int,
) -> ContactEquilibrium:
    """The equilibrium of a part of the motion under forces, held where nothing else holds it."""
    contact = structure.contact
    stiffness, relative = part.stiffness, part.relative
    # where nothing is held, as many unknowns as there are rigid-body motions
    supported = part.supported
    if supported is not None:
        stiffness, relative = stiffness[supported][:, supported], relative[:, supported]
    return solve_contact(
        stiffness,
        relative,
        contact.penalty * contact.area,
        contact.friction_coefficient,
        part.force(force)[slice(None) if supported is None else supported],
        gap=gap,
        tolerance=tolerance,
        maximum_iterations=maximum_iterations,
        factorisation=structure.factor_method,
    )


def _variables(
    structure: Structure, q: Array, force: Array, opening: Array, residual: Array
) -> dict[str, xr.Variable]:
    """What ``preload.nc`` holds, of unknowns q, and of forces and openings of the pairs."""
    contact = structure.contact
    return {
        **_of_pairs(contact, force[:, 2], opening, force[:, :2]),
        "shank_shortening": quantity(
            "bolt",
            [np.nan if bolt.locked is None else q[bolt.locked] for bolt in structure.bolts],
            "m",
            _SHORTENING,
        ),
        **_displacement(structure, q),
        **_newton(residual, len(residual) - 1),
        **_initial_gap(contact),
    }


def _warn_of_yield(structure: Structure, tension: Array) -> None:
    """Tell which bolt the preload strains farthest beyond yield, if any."""
    shanks = [
        (float(load), bolt.section, bolt.youngs_modulus, bolt.yield_strength)
        for load, bolt in zip(tension, structure.bolts, strict=True)
        if bolt.section is not None and bolt.youngs_modulus is not None
    ]
    if shanks:
        largest = max(shanks, key=lambda shank: share_of_yield(*shank))
        if sentence := yield_warning(*largest):
            logger.warning(sentence)


def _part_of(structure: Structure, force: Array) -> Subspace:
    """The symmetric part of the motion where forces and contact are symmetric, else all of it."""
    if not structure.is_symmetric(force):
        return whole(structure, tightened=True)
    return symmetric(structure, tightened=True)


def _displacement(structure: Structure, q: Array) -> dict[str, xr.Variable]:
    if structure.geometry is None:
        return {}
    displacement = structure.geometry.shape(q[:, None])[..., 0]
    return {"displacement": quantity(("node", "axis"), displacement, "m", "displacement")}


def _initial_gap(contact: ContactPoints) -> dict[str, xr.Variable]:
    if not contact.gap.any():
        return {}
    return {"initial_gap": quantity("pair", contact.gap, "m", "initial gap")}
