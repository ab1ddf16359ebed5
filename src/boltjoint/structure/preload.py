"""Static equilibrium under bolt preload: normal load and gap of every contact pair.

Each shank is cut in its middle and its ends overlap until the bolt carries its preload. The bars
are in unilateral, frictional (Coulomb) node-to-node contact. Both laws are made single-valued by a
stiff penalty, and the equilibrium is found by the semismooth Newton method, for which an open, a
sticking and a slipping pair are three branches of one piecewise smooth law. Assembly and preload
are symmetric about the middle of the width, so half of the unknowns are enough.

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

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import brentq
from scipy.sparse.linalg import LinearOperator, SuperLU, gmres
from scipy.spatial import ConvexHull
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.bolts import yield_warning
from boltjoint.structure.constraints import (
    assemble_assembly,
    factorise,
    relative_displacements,
)
from boltjoint.structure.symmetry import symmetric_displacements

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: reduction of the linear residual in one Newton iteration; the next iteration reduces it further,
#: so that half or twice moves normal loads by less than 1e-8 of the largest
_LINEAR_TOLERANCE = 1e-4

#: solutions with old factors that cost about as much as new factors; no load depends on it
_MAXIMUM_LINEAR_ITERATIONS = 60


@dataclass(frozen=True)
class ContactEquilibrium:
    """Equilibrium of an elastic body with frictional contact, or the last iterate.

    ``unknown`` (unknowns,); ``relative`` (pairs, 3) [m] and ``force`` (pairs, 3) [N] of the contact
    along x, y and the normal; ``residual`` (iterations + 1,): largest unbalanced force before each
    iteration and after the last, relative to the largest applied one.
    """

    unknown: Array
    relative: Array
    force: Array
    residual: Array
    converged: bool


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def apply_preload(
    assembly: xr.Dataset,
    preload: float | Sequence[float],
    *,
    tolerance: float = 1e-10,
    maximum_iterations: int = 40,
) -> xr.Dataset:
    """Contact under the preload of all bolts, as ``preload.nc`` holds it.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
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
        ``friction_force`` (pair, plane) [N] on side B; ``position`` (pair, axis) [m]; ``area``
        (pair) [m2]; ``shank_shortening`` (bolt) [m]; ``displacement`` (node, axis) [m];
        ``residual`` (iterate) and ``iterations``; attribute ``preload_N``, of all bolts or of each.

    Raises
    ------
    ValueError
        If preload, tolerance or iterations are not positive, bolts and preloads are not as many, a
        variable of the assembly is missing, or the mesh is not symmetric about y = 0.
    RuntimeError
        If no equilibrium is found.
    """
    T = symmetric_displacements(assembly, tightened=True)
    bolts = assembly.sizes["bolt"]
    tension = _tension(preload, bolts)
    largest = float(tension.max())
    K, _ = assemble_assembly(assembly)
    C = relative_displacements(assembly) @ T
    modulus = assembly["youngs_modulus"].item()
    if sentence := yield_warning(largest, _shank_area(assembly), modulus):
        logger.warning(sentence)
    force = np.zeros(T.shape[1])
    # The work of the bolt force on the shortening of its shank. All grows with the preload, so that
    # one of 1 N has the same iterates for all: only the ratios of the bolts matter.
    force[-bolts:] = tension / largest

    area = checks.variable("assembly", assembly, "area", ("pair",), above=0)
    found = solve_contact(
        (T.T @ K @ T).tocsc(),
        C,
        assembly["contact_penalty"].item() * area,
        assembly["friction_coefficient"].item(),
        force,
        tolerance=tolerance,
        maximum_iterations=maximum_iterations,
    )
    if not found.converged:
        raise RuntimeError(
            f"preload {largest:g} N: no equilibrium after {len(found.residual) - 1} corrections, "
            f"the largest unbalanced force is {found.residual[-1]:.1e} of the preload: choose "
            "contact.penalty_N_per_m3 of the assembly nearer to 1e15, or the material nearer to "
            "steel, since stiffnesses too far apart are lost in rounding"
        )
    unknown, relative, contact = (
        largest * each for each in (found.unknown, found.relative, found.force)
    )
    normal_load = contact[:, 2]
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
            "gap": quantity("pair", np.maximum(-relative[:, 2], 0.0), "m", "opening"),
            "friction_force": quantity(
                ("pair", "plane"), contact[:, :2], "N", "friction force on side B"
            ),
            "position": assembly["position"].variable,
            "area": assembly["area"].variable,
            "shank_shortening": quantity(
                "bolt", unknown[-bolts:], "m", "shortening of the shank by tightening"
            ),
            "displacement": quantity(
                ("node", "axis"), (T @ unknown).reshape(-1, 3), "m", "displacement"
            ),
            "residual": quantity(
                "iterate", found.residual, "1", "largest unbalanced force over preload"
            ),
            "iterations": quantity((), len(found.residual) - 1, "1", "Newton corrections"),
        },
        coords={"axis": assembly["axis"].variable, "plane": ["x", "y"]},
        attrs={"preload_N": preload},
    )


def solve_contact(
    K: sparse.csc_array,
    C: sparse.csr_array,
    stiffness: Array,
    friction_coefficient: float,
    force: Array,
    *,
    tolerance: float = 1e-10,
    maximum_iterations: int = 40,
) -> ContactEquilibrium:
    """Equilibrium of an elastic body with unilateral, frictional node-to-node contact.

    Finds q with ``K q + C^T g(C q) = force``, g the ``contact_force``, by the semismooth Newton
    method with a line search, starting with all pairs closed and sticking. The linear equations of
    the later iterations are solved by GMRES with the factors of the first, since they differ by
    the few pairs that open or slip; new factors are computed when that takes too long.

    Parameters
    ----------
    K
        Stiffness without contact, shape (unknowns, unknowns), positive definite.
    C
        Relative displacements of the pairs along x, y and the normal (closing positive), pair by
        pair, shape (3 * pairs, unknowns).
    stiffness
        Penalty of the pairs, shape (pairs,) [N/m]; the same along the normal and in the plane.
    friction_coefficient
        mu [-].
    force
        Applied forces, shape (unknowns,).
    tolerance
        Largest unbalanced force relative to the largest applied one.
    maximum_iterations
        Newton iterations after which the search ends.

    Raises
    ------
    ValueError
        If shapes do not fit each other, a number is out of range, or no force is applied.
    """
    force = checks.array("force", force, ("unknowns",))
    if not force.any():
        raise ValueError("force is zero: there is nothing to be in equilibrium with")
    stiffness = checks.array("stiffness", stiffness, ("pairs",), above=0)
    friction_coefficient = checks.number("friction_coefficient", friction_coefficient, at_least=0)
    tolerance = checks.number("tolerance", tolerance, above=0)
    maximum_iterations = checks.whole("maximum_iterations", maximum_iterations, at_least=1)
    for name, matrix, rows in (("K", K, force.size), ("C", C, 3 * stiffness.size)):
        if matrix.shape != (rows, force.size):
            raise ValueError(f"{name} has shape {matrix.shape}, expected {(rows, force.size)}")
        checks.array(f"data of {name}", matrix.data)
    pairs = len(stiffness)
    q = np.zeros(len(force))
    relative = np.zeros((pairs, 3))
    contact, tangent = _closed_and_sticking(stiffness, friction_coefficient)
    residual: list[float] = []
    factors = None
    while True:
        unbalanced = force - K @ q - C.T @ contact.ravel()
        residual.append(float(abs(unbalanced).max() / abs(force).max()))
        finite = np.isfinite(residual[-1])
        if residual[-1] <= tolerance or not finite or len(residual) > maximum_iterations:
            break
        J = (K + C.T @ _block_diagonal(tangent) @ C).tocsc()
        correction, factors = _solve_with_old_factors(J, unbalanced, factors)
        step = (C @ correction).reshape(pairs, 3)
        q = q + correction * _step_length(
            correction @ (force - K @ q),
            correction @ (K @ correction),
            relative,
            step,
            lambda at: _contact_force(at, stiffness, friction_coefficient)[0],
        )
        relative = (C @ q).reshape(pairs, 3)
        contact, tangent = _contact_force(relative, stiffness, friction_coefficient)
        logger.debug("correction %d: residual was %.2e", len(residual), residual[-1])
    return ContactEquilibrium(
        q, relative, contact, np.array(residual), converged=residual[-1] <= tolerance
    )


def contact_force(
    relative: Array, stiffness: Array, friction_coefficient: float
) -> tuple[Array, Array]:
    """Force of each contact pair and its derivative by the relative displacement.

    With u in the plane, v along the normal (closing positive), k the penalty::

        n = k max(v, 0)
        t = k u                where k |u| <= mu n  (stick)
        t = mu n u / |u|       elsewhere            (slip)

    Parameters
    ----------
    relative
        Shape (pairs, 3): along x, y and the normal [m].
    stiffness
        k, shape (pairs,) [N/m].
    friction_coefficient
        mu [-].

    Returns
    -------
    tuple
        Force (pairs, 3) [N] and its derivative (pairs, 3, 3) [N/m].

    Raises
    ------
    ValueError
        If shapes do not fit each other, or a number is out of range.
    """
    relative = checks.array("relative", relative, ("pairs", 3))
    stiffness = checks.array("stiffness", stiffness, relative.shape[:1], above=0)
    mu = checks.number("friction_coefficient", friction_coefficient, at_least=0)
    return _contact_force(relative, stiffness, mu)


def _contact_force(
    relative: Array, stiffness: Array, friction_coefficient: float
) -> tuple[Array, Array]:
    k, mu = stiffness, friction_coefficient
    u, v = relative[:, :2], relative[:, 2]
    distance = np.linalg.norm(u, axis=1)
    closed = v > 0
    slip = closed & (distance > mu * v)
    stick = closed & ~slip

    force = np.zeros((len(k), 3))
    force[:, 2] = np.where(closed, k * v, 0.0)
    force[stick, :2] = k[stick, None] * u[stick]
    direction = u[slip] / distance[slip, None]
    force[slip, :2] = mu * force[slip, 2:] * direction

    derivative = np.zeros((len(k), 3, 3))
    derivative[closed, 2, 2] = k[closed]
    derivative[stick, 0, 0] = derivative[stick, 1, 1] = k[stick]
    turning = np.eye(2) - direction[:, :, None] * direction[:, None, :]
    derivative[slip, :2, :2] = (mu * force[slip, 2] / distance[slip])[:, None, None] * turning
    derivative[slip, :2, 2] = mu * k[slip, None] * direction
    return force, derivative


def _tension(preload: float | Sequence[float], bolts: int) -> Array:
    """Tension of each bolt [N]."""
    if np.ndim(preload) == 0:
        return np.full(bolts, checks.number("preload", preload, above=0))
    tension = checks.array("preload", preload, (bolts,), at_least=0)
    if not tension.any():
        raise ValueError("preload is 0 for all bolts: one must be tightened")
    return tension


def _shank_area(assembly: xr.Dataset) -> float:
    """Cross-section of the first shank [m2], by the nodes of its pretension section."""
    of_first = assembly["section_bolt"].to_numpy() == 0
    node = assembly["section_node"].to_numpy()[of_first, 0]
    # the volume of a hull in the plane is its area
    return float(ConvexHull(assembly["coordinate"].to_numpy()[node, :2]).volume)


def _closed_and_sticking(stiffness: Array, friction_coefficient: float) -> tuple[Array, Array]:
    """Initial guess: no force, and the stiffness of pairs that are closed and stick."""
    in_plane = stiffness if friction_coefficient > 0 else np.zeros_like(stiffness)
    derivative = np.stack([in_plane, in_plane, stiffness], axis=-1)[:, :, None] * np.eye(3)
    return np.zeros((len(stiffness), 3)), derivative


def _step_length(
    force: float, stiffness: float, relative: Array, step: Array, contact: Callable[[Array], Array]
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
        Contact forces from relative displacements.
    """

    def work(s: float) -> float:
        return force - s * stiffness - np.sum(contact(relative + s * step) * step)

    start, end = work(0.0), work(1.0)
    # not either where the work is no number
    if not (start > 0 and end < -start / 2):
        return 1.0
    return float(brentq(work, 0.0, 1.0, xtol=1e-3))


def _block_diagonal(blocks: Array) -> sparse.bsr_array:
    n = len(blocks)
    return sparse.bsr_array((blocks, np.arange(n), np.arange(n + 1)), shape=(3 * n, 3 * n))


def _solve_with_old_factors(
    J: sparse.csc_array, right_side: Array, factors: SuperLU | None
) -> tuple[Array, SuperLU]:
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
    factors = factorise(J)
    return factors.solve(right_side), factors
