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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import brentq
from scipy.sparse.linalg import LinearOperator, gmres
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.bolts import tension_of, yield_warning
from boltjoint.structure.contact_law import closed_and_sticking, coulomb_contact
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.factors import Factors, factorise
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.model import Structure
from boltjoint.structure.subspaces import Subspace, symmetric, whole

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: reduction of the linear residual in one Newton iteration; the next iteration reduces it further,
#: so that half or twice moves normal loads by less than 1e-8 of the largest
_LINEAR_TOLERANCE = 1e-4

#: solutions with old factors that cost about as much as new factors; no load depends on it
_MAXIMUM_LINEAR_ITERATIONS = 60

#: stiffness of open pairs, over that of closed ones, in the first equilibrium of surfaces with an
#: initial gap; of the last one they have none
_TENSION = 1e-3


@dataclass(frozen=True)
class ContactEquilibrium:
    """Equilibrium of an elastic body with frictional contact, or the last iterate.

    ``unknown`` (unknowns,); ``relative`` (pairs, 3) [m] and ``force`` (pairs, 3) [N] of the contact
    along both tangents and the normal; ``residual`` (iterations + 1,): largest unbalanced force
    before each iteration and after the last, relative to the largest applied one.
    """

    unknown: Array
    relative: Array
    force: Array
    residual: Array
    converged: bool


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
    tension = tension_of(preload, len(structure.bolts))
    if not structure.bolts:
        raise ValueError("the structure has no bolts that could be tightened")
    largest = float(tension.max())
    _warn_of_yield(structure, tension)
    # The work of the bolt forces on the shortening of their shanks. All grows with preload and
    # initial gap, so that a preload of 1 N has the same iterates: only ratios to it matter.
    force = sum(
        each / largest * bolt.load for each, bolt in zip(tension, structure.bolts, strict=True)
    )
    gap = contact.gap / largest

    part = _part_of(structure, force)
    stiffness, relative = part.stiffness, part.relative
    # where nothing is held, as many unknowns as there are rigid-body motions
    supported = part.supported
    if supported is not None:
        stiffness, relative = stiffness[supported][:, supported], relative[:, supported]
    found = solve_contact(
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
    if not found.converged:
        raise RuntimeError(
            f"preload {largest:g} N: no equilibrium after {len(found.residual) - 1} corrections, "
            f"the largest unbalanced force is {found.residual[-1]:.1e} of the preload: choose "
            "contact.penalty_N_per_m3 of the assembly nearer to 1e15, or the material nearer to "
            "steel, since stiffnesses too far apart are lost in rounding"
        )
    opening = np.maximum(gap - found.relative[:, 2], 0.0)
    unknown, opening, force = (largest * each for each in (found.unknown, opening, found.force))
    q = part.basis @ part.unsupported(unknown)
    normal_load = force[:, 2]
    logger.info(
        "preload %s N: equilibrium after %d corrections, residual %.1e; %d of %d pairs carry %g N",
        preload,
        len(found.residual) - 1,
        found.residual[-1],
        np.count_nonzero(normal_load),
        len(normal_load),
        normal_load.sum(),
    )
    return xr.Dataset(
        {
            "normal_load": quantity("pair", normal_load, "N", "normal load of the contact pair"),
            "gap": quantity("pair", opening, "m", "opening"),
            "friction_force": quantity(
                ("pair", "plane"), force[:, :2], "N", "friction force on side B"
            ),
            **contact.variables(),
            "shank_shortening": quantity(
                "bolt",
                [np.nan if each.locked is None else q[each.locked] for each in structure.bolts],
                "m",
                "shortening of the shank by tightening",
            ),
            **_displacement(structure, q),
            "residual": quantity(
                "iterate", found.residual, "1", "largest unbalanced force over preload"
            ),
            "iterations": quantity((), len(found.residual) - 1, "1", "Newton corrections"),
            **_initial_gap(contact),
        },
        coords={"axis": ["x", "y", "z"], "plane": ["x", "y"]},
        attrs={"preload_N": preload},
    )


def _warn_of_yield(structure: Structure, tension: Array) -> None:
    """Tell which bolt the preload strains most, where that is beyond yield."""
    known = [
        (each / (bolt.section * bolt.youngs_modulus), each, bolt)
        for each, bolt in zip(tension, structure.bolts, strict=True)
        if bolt.section is not None and bolt.youngs_modulus is not None
    ]
    if known:
        _, of_bolt, bolt = max(known, key=lambda each: each[0])
        if sentence := yield_warning(of_bolt, bolt.section, bolt.youngs_modulus):
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


def solve_contact(
    K: sparse.csc_array,
    C: sparse.csr_array,
    stiffness: Array,
    friction_coefficient: float | Array,
    force: Array,
    *,
    gap: Array | None = None,
    tolerance: float = 1e-10,
    maximum_iterations: int = 40,
    factorisation: str = "superlu",
) -> ContactEquilibrium:
    """Equilibrium of an elastic body with unilateral, frictional node-to-node contact.

    Finds q with ``K q + C^T g(C q) = force``, g the ``contact_force``, by the semismooth Newton
    method with a line search, starting with all pairs closed, if by tension, and sticking. The
    linear equations of the later iterations are solved by GMRES with the factors of the first,
    since they differ by the few pairs that open or slip; new factors are computed when that takes
    too long. With an initial gap the bars may part on the way, and nothing would hold them: open
    pairs are weak springs first, and the equilibrium with these is the start to that without.
    Friction is that of the whole displacement, before a pair closes too.

    Parameters
    ----------
    K
        Stiffness without contact, shape (unknowns, unknowns), positive definite.
    C
        Relative displacements of the pairs along both tangents and the normal (closing positive),
        pair by pair, shape (3 * pairs, unknowns).
    stiffness
        Penalty of the pairs, shape (pairs,) [N/m]; the same along the normal and in the plane.
    friction_coefficient
        mu [-], of all pairs or of each, shape (pairs,).
    force
        Applied forces, shape (unknowns,).
    gap
        Initial gap of the pairs, shape (pairs,) [m]; 0 by default.
    tolerance
        Largest unbalanced force relative to the largest applied one.
    maximum_iterations
        Newton iterations after which the search ends.
    factorisation
        Method of the factors, as of ``structure.factors.factorise``.

    Raises
    ------
    ValueError
        If shapes do not fit each other, a number is out of range, or no force is applied.
    """
    force = checks.array("force", force, ("unknowns",))
    if not force.any():
        raise ValueError("force is zero: there is nothing to be in equilibrium with")
    stiffness = checks.array("stiffness", stiffness, ("pairs",), above=0)
    mu = np.broadcast_to(friction_coefficient, stiffness.shape)
    mu = checks.array("friction_coefficient", mu, stiffness.shape, at_least=0)
    tolerance = checks.number("tolerance", tolerance, above=0)
    maximum_iterations = checks.whole("maximum_iterations", maximum_iterations, at_least=1)
    for name, matrix, rows in (("K", K, force.size), ("C", C, 3 * stiffness.size)):
        if not sparse.issparse(matrix):
            raise ValueError(f"{name} is of type {type(matrix).__name__}: it must be sparse")
        if matrix.shape != (rows, force.size):
            raise ValueError(f"{name} has shape {matrix.shape}, expected {(rows, force.size)}")
        checks.array(f"data of {name}", matrix.data)
    pairs = len(stiffness)
    gap = np.zeros(pairs) if gap is None else checks.array("gap", gap, (pairs,), at_least=0)
    unilateral = partial(coulomb_contact, stiffness=stiffness, friction_coefficient=mu, gap=gap)
    # of flat surfaces no iterate is far from the contact
    law = partial(unilateral, tension=_TENSION) if gap.any() else unilateral
    q = np.zeros(len(force))
    relative = np.zeros((pairs, 3))
    contact, tangent = closed_and_sticking(stiffness, mu, gap)
    residual: list[float] = []
    factors = None
    while True:
        unbalanced = force - K @ q - C.T @ contact.ravel()
        residual.append(float(abs(unbalanced).max() / abs(force).max()))
        finite = np.isfinite(residual[-1])
        if law is not unilateral and residual[-1] <= tolerance:
            residual.pop()
            law = unilateral
            contact, tangent = law(relative)
            continue
        if residual[-1] <= tolerance or not finite or len(residual) > maximum_iterations:
            break
        J = (K + C.T @ _block_diagonal(tangent) @ C).tocsc()
        correction, factors = _solve_with_old_factors(J, unbalanced, factors, factorisation)
        step = (C @ correction).reshape(pairs, 3)
        q = q + correction * _step_length(
            correction @ (force - K @ q),
            correction @ (K @ correction),
            relative,
            step,
            law,
        )
        relative = (C @ q).reshape(pairs, 3)
        contact, tangent = law(relative)
        logger.debug("correction %d: residual was %.2e", len(residual), residual[-1])
    return ContactEquilibrium(
        q, relative, contact, np.array(residual), converged=residual[-1] <= tolerance
    )


def _step_length(
    force: float,
    stiffness: float,
    relative: Array,
    step: Array,
    contact: Callable[[Array], tuple[Array, Array]],
) -> float:
    """Factor of a Newton step by line search: 1, or where the work of the unbalanced force is zero.

    Weak friction reverses when a step overshoots, and full steps may then cycle. So where the work
    of the unbalanced force at the end of the step is negative and more than half of that at its
    start, the step ends where the work is zero (Matthies and Strang 1979). The elastic forces are
    linear along the step, so only the contact is evaluated.

    Parameters
    ----------
    force, stiffness
        Work of the elastic and applied forces on the step at the factor s: ``force - s stiffness``.
    relative, step
        Relative displacements before the step and their change, shape (pairs, 3).
    contact
        Contact forces and their derivative from relative displacements.
    """

    def work(s: float) -> float:
        return force - s * stiffness - np.sum(contact(relative + s * step)[0] * step)

    start, end = work(0.0), work(1.0)
    # not either where the work is no number
    if not (start > 0 and end < -start / 2):
        return 1.0
    return float(brentq(work, 0.0, 1.0, xtol=1e-3))


def _block_diagonal(blocks: Array) -> sparse.bsr_array:
    n = len(blocks)
    return sparse.bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(3 * n, 3 * n))


def _solve_with_old_factors(
    J: sparse.csc_array, right_side: Array, factors: Factors | None, factorisation: str
) -> tuple[Array, Factors]:
    """Solve J x = b by GMRES on J P^-1, P the matrix of the factors, or with new factors."""
    if factors is not None:
        through_factors = LinearOperator(J.shape, lambda y: J @ factors.solve(y), dtype=float)
        y, failed = gmres(
            through_factors,
            right_side,
            rtol=_LINEAR_TOLERANCE,
            restart=_MAXIMUM_LINEAR_ITERATIONS,
            maxiter=1,
        )
        if not failed:
            return factors.solve(y), factors
        # two sets of factors at once would double the peak of memory
        del through_factors, factors
    factors = factorise(J, factorisation)
    return factors.solve(right_side), factors
