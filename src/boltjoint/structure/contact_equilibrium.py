"""Equilibrium of an elastic body with unilateral, frictional contact, and the law of its pairs."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import brentq
from scipy.sparse.linalg import LinearOperator, gmres

from boltjoint import checks
from boltjoint.structure.factors import Factors, factorise

Array = NDArray[np.float64]


def contact_force(
    relative: Array,
    stiffness: Array,
    friction_coefficient: float | Array,
    gap: Array | None = None,
) -> tuple[Array, Array]:
    """Force of each contact pair and its derivative by the relative displacement.

    With u in the plane, v along the normal (closing positive), k the penalty, g the initial gap::

        n = k max(v - g, 0)
        t = k u                where k |u| <= mu n  (stick)
        t = mu n u / |u|       elsewhere            (slip)

    Parameters
    ----------
    relative
        Shape (pairs, 3): along both tangents and the normal [m].
    stiffness
        k, shape (pairs,) [N/m].
    friction_coefficient
        mu [-], of all pairs or of each, shape (pairs,).
    gap
        g, shape (pairs,) [m]; 0 by default.

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
    mu = checks.of_each("friction_coefficient", friction_coefficient, stiffness.shape, at_least=0)
    gap = np.zeros(len(stiffness)) if gap is None else checks.array("gap", gap, stiffness.shape)
    return coulomb_contact(relative, stiffness, mu, gap)


def coulomb_contact(
    relative: Array,
    stiffness: Array,
    friction_coefficient: Array,
    gap: Array,
    tension: float = 0.0,
) -> tuple[Array, Array]:
    """As ``contact_force``, without checks; open pairs are springs of ``tension`` times k."""
    k, mu = stiffness, friction_coefficient
    u, v = relative[:, :2], relative[:, 2] - gap
    distance = np.linalg.norm(u, axis=1)
    closed = v > 0
    slip = closed & (distance > mu * v)
    stick = closed & ~slip

    force = np.zeros((len(k), 3))
    force[:, 2] = np.where(closed, k * v, 0.0)
    force[stick, :2] = k[stick, None] * u[stick]
    direction = u[slip] / distance[slip, None]
    force[slip, :2] = mu[slip, None] * force[slip, 2:] * direction

    derivative = np.zeros((len(k), 3, 3))
    derivative[closed, 2, 2] = k[closed]
    derivative[stick, 0, 0] = derivative[stick, 1, 1] = k[stick]
    if tension:
        force[~closed, 2] = tension * (k * v)[~closed]
        derivative[~closed, 2, 2] = tension * k[~closed]
    turning = np.eye(2) - direction[:, :, None] * direction[:, None, :]
    derivative[slip, :2, :2] = (mu[slip] * force[slip, 2] / distance[slip])[:, None, None] * turning
    derivative[slip, :2, 2] = mu[slip, None] * k[slip, None] * direction
    return force, derivative


def closed_and_sticking(
    stiffness: Array, friction_coefficient: Array, gap: Array
) -> tuple[Array, Array]:
    """Initial guess: force and stiffness of pairs that stick and are held closed, if by tension."""
    in_plane = np.where(friction_coefficient > 0, stiffness, 0.0)
    derivative = np.stack([in_plane, in_plane, stiffness], axis=-1)[:, :, None] * np.eye(3)
    force = np.zeros((len(stiffness), 3))
    force[:, 2] = -stiffness * gap
    return force, derivative


logger = logging.getLogger(__name__)


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
    stiffness, mu, gap = _checked_pairs(stiffness, friction_coefficient, gap)
    body = _Body.of(K, C, force, stiffness.size)
    tolerance = checks.number("tolerance", tolerance, above=0)
    maximum_iterations = checks.whole("maximum_iterations", maximum_iterations, at_least=1)
    unilateral = partial(coulomb_contact, stiffness=stiffness, friction_coefficient=mu, gap=gap)
    # of flat surfaces no iterate is far from the contact
    law = partial(unilateral, tension=_TENSION) if gap.any() else unilateral
    q = np.zeros(body.force.size)
    contact, tangent = closed_and_sticking(stiffness, mu, gap)
    residual: list[float] = []
    factors = None
    while True:
        unbalanced = body.unbalanced(q, contact)
        residual.append(float(abs(unbalanced).max() / abs(body.force).max()))
        if law is not unilateral and residual[-1] <= tolerance:
            residual.pop()
            law = unilateral
            contact, tangent = law(body.relative(q))
            continue
        # what is no number is not between them either
        if not tolerance < residual[-1] < np.inf or len(residual) > maximum_iterations:
            break
        J = body.jacobian(tangent)
        correction, factors = _solve_with_old_factors(J, unbalanced, factors, factorisation)
        q = q + correction * body.step_length(q, correction, law)
        contact, tangent = law(body.relative(q))
        logger.debug("correction %d: residual was %.2e", len(residual), residual[-1])
    converged = residual[-1] <= tolerance
    return ContactEquilibrium(q, body.relative(q), contact, np.array(residual), converged)


@dataclass(frozen=True)
class _Body:
    """An elastic body under forces, whose contact pairs see its motion by C."""

    K: sparse.csc_array
    C: sparse.csr_array
    force: Array

    @classmethod
    def of(cls, K: sparse.csc_array, C: sparse.csr_array, force: Array, pairs: int) -> "_Body":
        """The body, after a check of its matrices and forces."""
        force = checks.array("force", force, ("unknowns",))
        if not force.any():
            raise ValueError("force is zero: there is nothing to be in equilibrium with")
        _check_sparse("K", K, (force.size, force.size))
        _check_sparse("C", C, (3 * pairs, force.size))
        return cls(K, C, force)

    def relative(self, q: Array) -> Array:
        """Relative displacements of the pairs [m], shape (pairs, 3)."""
        return (self.C @ q).reshape(-1, 3)

    def unbalanced(self, q: Array, contact: Array) -> Array:
        """Applied less elastic and contact forces [N], shape (unknowns,)."""
        return self.force - self.K @ q - self.C.T @ contact.ravel()

    def jacobian(self, tangent: Array) -> sparse.csc_array:
        """Stiffness with that of the contact, from its derivative (pairs, 3, 3) [N/m]."""
        return (self.K + self.C.T @ _block_diagonal(tangent) @ self.C).tocsc()

    def step_length(
        self, q: Array, correction: Array, law: Callable[[Array], tuple[Array, Array]]
    ) -> float:
        """Factor of a Newton step by line search: 1, or where the unbalanced force does no work.

        Weak friction reverses when a step overshoots, and full steps may then cycle. So where the
        work of the unbalanced force at the end of the step is negative and more than half of that
        at its start, the step ends where the work is zero (Matthies and Strang 1979). The elastic
        forces are linear along the step, so only the contact is evaluated.
        """
        # of elastic and applied forces at the factor s: force - s stiffness
        force, stiffness = (
            correction @ (self.force - self.K @ q),
            correction @ (self.K @ correction),
        )
        relative, step = self.relative(q), self.relative(correction)

        def work(s: float) -> float:
            return force - s * stiffness - np.sum(law(relative + s * step)[0] * step)

        start, end = work(0.0), work(1.0)
        # not either where the work is no number
        if not (start > 0 and end < -start / 2):
            return 1.0
        return float(brentq(work, 0.0, 1.0, xtol=1e-3))


def _checked_pairs(
    stiffness: Array, friction_coefficient: float | Array, gap: Array | None
) -> tuple[Array, Array, Array]:
    """Penalty, friction coefficient and initial gap of each pair."""
    stiffness = checks.array("stiffness", stiffness, ("pairs",), above=0)
    mu = checks.of_each("friction_coefficient", friction_coefficient, stiffness.shape, at_least=0)
    gap = np.zeros(stiffness.size) if gap is None else gap
    return stiffness, mu, checks.array("gap", gap, stiffness.shape, at_least=0)


def _check_sparse(name: str, matrix: Any, shape: tuple[int, int]) -> None:  # noqa: ANN401
    if not sparse.issparse(matrix):
        raise ValueError(f"{name} is of type {type(matrix).__name__}: it must be sparse")
    if matrix.shape != shape:
        raise ValueError(f"{name} has shape {matrix.shape}, expected {shape}")
    checks.array(f"data of {name}", matrix.data)


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
