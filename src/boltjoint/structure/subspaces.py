"""Parts of the motion of a structure: all of it, or what is symmetric or antisymmetric.

Where forces, preload and initial gap share the symmetry of a structure, bending needs the unknowns
of symmetric motion only: half as many.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh, qr
from scipy.sparse.linalg import LinearOperator, eigsh

from boltjoint.structure.contact_points import as_sparse
from boltjoint.structure.factors import Factors, check_held, factorise, highest_frequency
from boltjoint.structure.model import Structure

Array = NDArray[np.float64]

#: size of a rigid-body motion within a subspace, over all of it, below which it is none of it
_OUTSIDE = 1e-6

#: modes fewer than there are, of which Arnoldi's method finds as many at most
_BEYOND_ARNOLDI = 2
#: modes up to which all are found where unknowns have no mass: Arnoldi's method breaks down where
#: its vectors are more
_FEW = 200


@dataclass(frozen=True, eq=False)
class Subspace:
    """The motion ``q = S x`` of a structure.

    Attributes
    ----------
    structure
        The whole.
    basis
        S, shape (dofs, unknowns): each unknown moves degrees of freedom of its own by +1 or -1.
    tightened
        Whether the shortening of bolts is an unknown: nothing is in contact then, not even the
        springs of the base.
    """

    structure: Structure
    basis: sparse.csc_array
    tightened: bool = False

    @property
    def is_half(self) -> bool:
        """Whether one side moves as the other does."""
        return bool(np.any(np.diff(self.basis.indptr) > 1))

    @cached_property
    def stiffness(self) -> sparse.csc_array:
        """K of the unknowns."""
        structure = self.structure
        K = structure.stiffness if self.tightened else structure.base_stiffness
        return (self.basis.T @ K @ self.basis).tocsc()

    @cached_property
    def mass(self) -> sparse.csc_array:
        """M of the unknowns."""
        return (self.basis.T @ self.structure.mass @ self.basis).tocsc()

    @cached_property
    def relative(self) -> sparse.csr_array:
        """Relative displacement of the contact points, shape (3 * points, unknowns)."""
        return (self.structure.contact.relative @ self.basis).tocsr()

    @cached_property
    def rigid(self) -> Array:
        """Rigid-body motions in this subspace, orthonormal in mass, shape (unknowns, motions)."""
        # of each motion the part that lies inside
        counts = np.diff(self.basis.indptr)
        x = (self.basis.T @ self.structure.rigid) / counts[:, None]
        if not x.size:
            return x
        share, turn = eigh(x.T @ (self.mass @ x))
        kept = share > _OUTSIDE * share.max(initial=0.0)
        return x @ (turn[:, kept] / np.sqrt(share[kept]))

    def modes(
        self, factors: Factors, stiffness: sparse.csc_array, count: int
    ) -> tuple[Array, Array]:
        """The first elastic modes with a stiffness: squared frequencies and vectors.

        Parameters
        ----------
        factors
            Factors of the stiffness, as from ``factors``.
        stiffness
            K, or K with springs of the contact.
        count
            Number of modes.

        Raises
        ------
        RuntimeError
            If one of the frequencies is no number or zero within rounding.
        """
        moved = np.count_nonzero(self.mass.diagonal()) - self.rigid.shape[1]
        has_massless = moved < self.most_modes
        if count > self.most_modes - _BEYOND_ARNOLDI or (has_massless and moved <= _FEW):
            return self._all_modes(stiffness, count)
        # a fixed start that no mode is orthogonal to repeats the result
        start = np.random.default_rng(0).standard_normal(stiffness.shape[0])
        if self.rigid.shape[1]:
            start = factors.solve(start)
        inverse = LinearOperator(stiffness.shape, factors.solve, dtype=float)
        squared, q = eigsh(stiffness, k=count, M=self.mass, sigma=0.0, OPinv=inverse, v0=start)
        check_held(squared, stiffness, self.mass)
        order = np.argsort(squared)
        return squared[order], q[:, order]

    @property
    def most_modes(self) -> int:
        """Number of elastic modes, of which those that no mass moves in are none."""
        return self.stiffness.shape[0] - self.rigid.shape[1]

    def _all_modes(self, stiffness: sparse.csc_array, count: int) -> tuple[Array, Array]:
        """As ``modes``, of full matrices: of a structure with few degrees of freedom."""
        K, M = stiffness.toarray(), self.mass.toarray()
        moved = self.mass @ self.rigid
        inertia = moved @ moved.T
        # rigid-body motion gets stiffness and loses its mass: like massless unknowns it has none
        # of the largest ratios
        ratio, q = eigh(M - inertia, K + highest_frequency(stiffness, self.mass) * inertia)
        ratio, q = ratio[::-1], q[:, ::-1]
        has_mass = ratio > np.finfo(float).eps * len(ratio) * ratio[0]
        ratio, q = ratio[has_mass][:count], q[:, has_mass][:, :count]
        check_held(1 / ratio, stiffness, self.mass)
        return 1 / ratio, q / np.sqrt(ratio)

    def factors(self, stiffness: sparse.csc_array) -> Factors:
        """Factors of a stiffness; of its elastic part where there is rigid-body motion."""
        if not self.rigid.shape[1]:
            return factorise(stiffness, self.structure.factor_method)
        return _ElasticFactors(self, stiffness)

    def force(self, force: Array) -> Array:
        """Forces on the unknowns, shape (unknowns,), of forces on the structure (dofs,)."""
        return self.basis.T @ force

    @cached_property
    def supported(self) -> NDArray[np.int64] | None:
        """Unknowns that remain where as many as there are rigid-body motions are held.

        Forces in equilibrium with themselves move the others as without supports, but for
        rigid-body motion. None where the structure is held.
        """
        motions = self.rigid.shape[1]
        if not motions:
            return None
        # those whose rows are farthest from depending on each other
        first = qr(self.rigid.T, mode="r", pivoting=True)[1][:motions]
        return np.delete(np.arange(len(self.rigid)), first)

    def unsupported(self, x: Array) -> Array:
        """All unknowns of those ``supported``, without rigid-body motion, (unknowns, ...)."""
        if self.supported is None:
            return x
        motion = np.zeros((len(self.rigid), *x.shape[1:]))
        motion[self.supported] = x
        return motion - self.rigid @ (self.rigid.T @ (self.mass @ motion))


class _ElasticFactors:
    """The elastic response of a structure with rigid-body motion to forces.

    What forces have in excess of equilibrium accelerates it as a whole, which is left out.
    """

    def __init__(self, part: Subspace, stiffness: sparse.csc_array) -> None:
        self._part, self._moved = part, part.mass @ part.rigid
        supported = stiffness[part.supported][:, part.supported].tocsc()
        self._factors = factorise(supported, part.structure.factor_method)

    def solve(self, force: Array) -> Array:
        """Displacements without rigid-body motion of forces, shape (unknowns, ...)."""
        balanced = force - self._moved @ (self._part.rigid.T @ force)
        return self._part.unsupported(self._factors.solve(balanced[self._part.supported]))


def whole(structure: Structure, *, tightened: bool) -> Subspace:
    """All motion of a structure, with or without that of locked bolts."""
    moving = np.arange(structure.dofs) if tightened else structure.moving
    columns = np.arange(moving.size)
    shape = structure.dofs, moving.size
    basis = sparse.csc_array((np.ones(moving.size), (moving, columns)), shape=shape)
    return Subspace(structure, as_sparse("basis", basis, sparse.csc_array), tightened)


def symmetric(structure: Structure, *, tightened: bool = False) -> Subspace:
    """Motion symmetric about the plane of symmetry; all of it where there is none.

    Parameters
    ----------
    structure
        The whole.
    tightened
        Whether the shortening of bolts is an unknown; otherwise it is held.
    """
    if structure.symmetry is None:
        return whole(structure, tightened=tightened)
    return Subspace(structure, _half(structure, 1.0, tightened), tightened)


def part_that_moves(
    structure: Structure, *of_points: Array | NDArray[np.bool_] | NDArray[np.int64]
) -> Subspace:
    """Symmetric motion where quantities of the contact points (points,) are symmetric, else all."""
    if structure.has_mirrored(*of_points):
        return symmetric(structure)
    return whole(structure, tightened=False)


def antisymmetric(structure: Structure) -> Subspace | None:
    """Motion of one side as the negative mirror image of the other; None without symmetry."""
    if structure.symmetry is None:
        return None
    return Subspace(structure, _half(structure, -1.0, tightened=False))


def _half(structure: Structure, sense: float, tightened: bool) -> sparse.csc_array:
    """The basis of symmetric motion, or with the sense -1 of antisymmetric motion."""
    symmetry = structure.symmetry
    if symmetry is None:
        raise ValueError("the structure has no symmetry")
    image, sign = symmetry.image, sense * symmetry.sign
    own = np.arange(structure.dofs)
    # on the plane of symmetry nothing moves across it, or nothing moves along it
    is_kept = (own < image) | ((own == image) & (sign > 0))
    if not tightened:
        is_kept[structure.held] = False
    kept = np.flatnonzero(is_kept)
    column = np.arange(kept.size)
    two = image[kept] != kept
    basis = sparse.csc_array(
        (
            np.concatenate([np.ones(kept.size), sign[kept][two]]),
            (np.concatenate([kept, image[kept][two]]), np.concatenate([column, column[two]])),
        ),
        shape=(structure.dofs, kept.size),
    )
    return as_sparse("basis", basis, sparse.csc_array)
