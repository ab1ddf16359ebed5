"""A structure with contact: stiffness, mass, contact points, bolts, supports, inputs and outputs.

Whatever makes a structure, a mesh of a half lap or matrices of another program, later stages know
this description alone. Constraints are inside: a degree of freedom here is free, and displacements
of nodes are combinations of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.structure.contact_points import DIRECTIONS, ContactPoints, as_sparse
from boltjoint.structure.factors import AUTO, METHODS, chosen_method, rigid_motions
from boltjoint.structure.geometry import Geometry

Array = NDArray[np.float64]

#: largest difference of entries across the diagonal over the largest entry: rounding of a program
#: that writes ten digits
_ASYMMETRY = 1e-9

#: motion of the contact points in a rigid-body motion, over that, which is more than rounding
_APART = 1e-6
#: rigid-body motions of a body
_MOST_RIGID = 6


@dataclass(frozen=True, eq=False)
class Bolt:
    """A bolt by the forces of its tension.

    Attributes
    ----------
    name
        In tables and messages.
    load
        Forces of a tension of 1 N, in equilibrium with themselves, shape (dofs,).
    locked
        The degree of freedom that is the shortening of the shank, held after tightening; None for
        a dead load, which needs none.
    axis, position
        Direction, and a point on it [m], in x, y, z; None where not known.
    section, youngs_modulus, yield_strength
        Cross-section [m2], Young's modulus and yield strength [Pa] of the shank; None where not
        known.
    hole_clearance
        Diameter of the hole less that of the shank [m]; None where not known.
    """

    name: str
    load: Array
    locked: int | None = None
    axis: Array | None = None
    position: Array | None = None
    section: float | None = None
    youngs_modulus: float | None = None
    yield_strength: float | None = None
    hole_clearance: float | None = None

    def __post_init__(self) -> None:
        """Refuse a bolt that cannot be tightened."""
        load = checks.array(f"load of {self.name}", self.load, ("dofs",))
        if not load.any():
            raise ValueError(f"load of {self.name} is zero: a tension of 1 N has forces")
        object.__setattr__(self, "load", load)
        if self.yield_strength != self.yield_strength:  # not a number, as cells have it
            object.__setattr__(self, "yield_strength", None)
        if self.locked is not None:
            checks.whole(f"locked of {self.name}", self.locked, at_least=0)
            if self.locked >= load.size:
                raise ValueError(f"locked of {self.name} is {self.locked} of {load.size} dofs")
        if self.hole_clearance is not None:
            checks.number(f"hole_clearance of {self.name}", self.hole_clearance, above=0)
            if self.axis is None or self.position is None:
                raise ValueError(f"{self.name} has a hole_clearance, but no axis and position")


@dataclass(frozen=True, eq=False)
class Row:
    """Displacement of a place of the structure, or the force that acts there.

    ``row`` (dofs,) of the displacement; ``direction`` in words of the maker, as x.
    """

    row: Array
    direction: str = ""


@dataclass(frozen=True, eq=False)
class Reflection:
    """Mirror symmetry: a permutation of degrees of freedom and points, with signs.

    The mirror image of the displacements q is ``sign * q[image]``, that of point i the point
    ``point[i]``.
    """

    image: NDArray[np.int64]
    sign: Array
    point: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Structure:
    """A structure in degrees of freedom q, with the contact removed.

    Parameters
    ----------
    stiffness, mass
        K [N/m] and M [kg], symmetric, shape (dofs, dofs); K may be singular by rigid-body motion.
    contact
        The contact points.
    bolts
        Bolts in the order of their preloads.
    inputs, outputs
        Rows of shakers and sensors, by name.
    support
        Forces ``-M r`` of a unit acceleration of all supports along x, y, z [kg], shape (3, dofs);
        None where nothing is held.
    rigid
        Rigid-body motions, shape (dofs, up to 6); none where the structure is held.
    symmetry
        Where it has one.
    geometry
        Where it is known.
    maker
        What made it: its families of modes, words and figures.
    factorisation
        Method of the factors of its matrices, as of ``structure.factors.factorise``, or ``auto``.
    base_springs
        Normal stiffness of contact points that are closed under preload [N/m], shape (points,):
        modes and bases are those with these springs, where nothing else holds parts together. None
        where they are those without contact.

    Raises
    ------
    ValueError
        If a matrix is not sparse, square, finite and symmetric, M has a diagonal that is negative,
        or sizes do not fit.
    """

    stiffness: sparse.csc_array
    mass: sparse.csc_array
    contact: ContactPoints
    bolts: tuple[Bolt, ...]
    inputs: Mapping[str, Row] = field(default_factory=dict)
    outputs: Mapping[str, Row] = field(default_factory=dict)
    support: Array | None = None
    rigid: Array | None = None
    symmetry: Reflection | None = None
    geometry: Geometry | None = None
    maker: str = ""
    factorisation: str = AUTO
    base_springs: Array | None = None

    def __post_init__(self) -> None:
        """Refuse what is no structure."""
        for name in ("stiffness", "mass"):
            matrix = as_sparse(name, getattr(self, name), sparse.csc_array)
            object.__setattr__(self, name, _symmetric(name, matrix))
        if self.mass.shape != self.stiffness.shape:
            raise ValueError(f"mass has shape {self.mass.shape}, stiffness {self.stiffness.shape}")
        if self.mass.diagonal().min() < 0:
            raise ValueError("mass has a negative entry on its diagonal: it is not positive")
        checks.choice("factorisation", self.factorisation, (AUTO, *METHODS))
        checks.instance("contact", self.contact, ContactPoints)
        if self.contact.relative.shape[1] != self.dofs:
            raise ValueError(
                f"relative of the contact points has {self.contact.relative.shape[1]} columns, the "
                f"structure {self.dofs} degrees of freedom"
            )
        checks.sequence("bolts", self.bolts, Bolt)
        object.__setattr__(self, "bolts", tuple(self.bolts))
        for bolt in self.bolts:
            checks.array(f"load of {bolt.name}", bolt.load, (self.dofs,))
        for name in ("inputs", "outputs"):
            checks.mapping(name, getattr(self, name))
            for key, row in getattr(self, name).items():
                checks.instance(f"{key} of {name}", row, Row)
                checks.array(f"{key} of {name}", row.row, (self.dofs,))
        if self.support is not None:
            checks.array("support", self.support, (DIRECTIONS, self.dofs))
        for name, kind in (("symmetry", Reflection), ("geometry", Geometry)):
            if getattr(self, name) is not None:
                checks.instance(name, getattr(self, name), kind)
        rigid = checks.array("rigid", self.rigid_body_motions, (self.dofs, "motions"))
        if rigid.shape[1] > _MOST_RIGID:
            raise ValueError(
                f"the structure has {rigid.shape[1]} rigid-body motions: more than {_MOST_RIGID} "
                "are those of a mechanism, whose parts nothing connects"
            )
        object.__setattr__(self, "rigid", rigid)
        if rigid.size and abs(self.contact.relative @ rigid).max() > _APART * abs(rigid).max():
            raise ValueError(
                "parts of the structure are connected by the contact alone: without it they move "
                "as rigid bodies, and modes without contact do not exist"
            )
        for bolt in self.bolts:
            self._check_equilibrium(bolt)
        if self.base_springs is not None:
            points = (len(self.contact),)
            springs = checks.array("base_springs", self.base_springs, points, at_least=0)
            object.__setattr__(self, "base_springs", springs)

    @classmethod
    def from_matrices(
        cls,
        stiffness: sparse.sparray | Array,
        mass: sparse.sparray | Array,
        contact: ContactPoints,
        *,
        bolts: Mapping[str, int | Array] | None = None,
        inputs: Mapping[str, int | Array] | None = None,
        outputs: Mapping[str, int | Array] | None = None,
        support: Array | None = None,
        factorisation: str = AUTO,
    ) -> Self:
        """The structure of matrices from elsewhere, free or held, whole or reduced.

        Parameters
        ----------
        stiffness, mass
            K [N/m] and M [kg], shape (dofs, dofs).
        contact
            The contact points.
        bolts
            By name, the degree of freedom that is the shortening of the shank and held after
            tightening, or the forces of a tension of 1 N, shape (dofs,).
        inputs, outputs
            By name, a degree of freedom or the row of a displacement, shape (dofs,).
        support, factorisation
            As the attributes.
        """
        K, M = (
            matrix
            if sparse.issparse(matrix)
            else sparse.csc_array(checks.array(name, matrix, ("dofs", "dofs")))
            for name, matrix in (("stiffness", stiffness), ("mass", mass))
        )
        dofs = K.shape[0]
        for name, rows in (("bolts", bolts), ("inputs", inputs), ("outputs", outputs)):
            checks.mapping(name, {} if rows is None else rows)
        of_bolts = tuple(
            Bolt(
                name,
                _row_of(f"bolt {name}", load, dofs),
                checks.whole(f"bolt {name}", load) if checks.is_number(load) else None,
            )
            for name, load in (bolts or {}).items()
        )
        of_inputs, of_outputs = (
            {name: Row(_row_of(name, row, dofs), name) for name, row in (rows or {}).items()}
            for rows in (inputs, outputs)
        )
        structure = cls(
            K,
            M,
            contact,
            of_bolts,
            of_inputs,
            of_outputs,
            support=support,
            factorisation=factorisation,
        )
        return structure.with_rigid_motions()

    @property
    def dofs(self) -> int:
        """Number of degrees of freedom."""
        return self.stiffness.shape[0]

    @property
    def factor_method(self) -> str:
        """Method of the factors, which ``auto`` leaves to size and symmetry."""
        is_symmetric = self.symmetry is not None
        return chosen_method(self.factorisation, self.dofs, is_symmetric=is_symmetric)

    @property
    def rigid_body_motions(self) -> Array:
        """``rigid``, or none, shape (dofs, motions)."""
        return np.zeros((self.dofs, 0)) if self.rigid is None else self.rigid

    @cached_property
    def base_stiffness(self) -> sparse.csc_array:
        """K [N/m] of modes and bases: without contact, or with the springs of closed points."""
        if self.base_springs is None:
            return self.stiffness
        acting = np.flatnonzero(self.base_springs)
        normal = self.contact.relative[DIRECTIONS * acting + DIRECTIONS - 1]
        springs = normal.T @ (sparse.diags_array(self.base_springs[acting]) @ normal)
        return _symmetric("stiffness", sparse.csc_array(self.stiffness + springs))

    @cached_property
    def held(self) -> NDArray[np.int64]:
        """Degrees of freedom that are held once the bolts are tight."""
        return np.array([bolt.locked for bolt in self.bolts if bolt.locked is not None], np.int64)

    @cached_property
    def moving(self) -> NDArray[np.int64]:
        """Degrees of freedom that are not."""
        return np.setdiff1d(np.arange(self.dofs), self.held)

    def is_symmetric(self, force: Array) -> bool:
        """Whether the structure, its contact and forces (dofs,) have a plane of symmetry."""
        mirror, contact = self.symmetry, self.contact
        of_points = contact.gap, contact.penalty, contact.friction_coefficient, contact.area
        if mirror is None or not self.has_mirrored(*of_points):
            return False
        return _are_alike(force, mirror.sign * force[mirror.image])

    def has_mirrored(self, *of_points: Array | NDArray[np.bool_] | NDArray[np.int64]) -> bool:
        """Whether there is a symmetry that quantities of the points, (points,) each, have."""
        mirror = self.symmetry
        return mirror is not None and all(
            _are_alike(1.0 * values, 1.0 * values[mirror.point]) for values in of_points
        )

    def with_rigid_motions(self) -> Self:
        """The same structure with the rigid-body motions that it has."""
        K, M = (matrix[self.moving][:, self.moving] for matrix in (self.stiffness, self.mass))
        motion = rigid_motions(K, M, self.factor_method)
        rigid = np.zeros((self.dofs, motion.shape[1]))
        rigid[self.moving] = motion
        return replace(self, rigid=rigid)

    def without_symmetry(self) -> Self:
        """The same structure, whose symmetry is not used."""
        return replace(self, symmetry=None)

    def _check_equilibrium(self, bolt: Bolt) -> None:
        """Refuse a tension that would move the whole structure."""
        rigid = self.rigid_body_motions
        work = abs(rigid.T @ bolt.load)
        limit = _ASYMMETRY * (abs(rigid).T @ abs(bolt.load))
        if np.any(work > limit):
            raise ValueError(
                f"load of {bolt.name} is not in equilibrium with itself: it does work on a "
                "rigid-body motion of the structure"
            )


def _are_alike(one: NDArray[np.floating], other: NDArray[np.floating]) -> bool:
    """Whether two arrays differ by no more than rounding."""
    return bool(abs(one - other).max() <= _ASYMMETRY * abs(one).max())


def _row_of(name: str, value: int | Array, dofs: int) -> Array:
    """The row of a degree of freedom, or a row as it is given."""
    if not checks.is_number(value):
        return checks.array(name, value, (dofs,))
    place = checks.whole(name, value, at_least=0)
    if place >= dofs:
        raise ValueError(f"{name} is degree of freedom {place}: there are {dofs}")
    return unit_row(place, dofs)


def unit_row(place: int, dofs: int) -> Array:
    """The displacement of one degree of freedom, or a force of 1 on it, shape (dofs,)."""
    row = np.zeros(dofs)
    row[place] = 1.0
    return row


def mirrored(upper: sparse.csc_array) -> sparse.csc_array:
    """The symmetric matrix of an upper triangle."""
    return (upper + sparse.triu(upper, k=1, format="csc").T).tocsc()


def _symmetric(name: str, matrix: sparse.csc_array) -> sparse.csc_array:
    """A matrix that is symmetric to the bit, of one that is but for rounding."""
    if matrix.shape[0] != matrix.shape[1] or not matrix.shape[0]:
        raise ValueError(f"{name} has shape {matrix.shape}: it must be square")
    largest = abs(matrix.data).max(initial=0.0)
    if largest == 0:
        raise ValueError(f"{name} is zero")
    apart = abs(matrix - matrix.T).tocoo()
    worst = apart.data.max(initial=0.0)
    if worst > _ASYMMETRY * largest:
        place = apart.data.argmax()
        at = int(apart.row[place]), int(apart.col[place])
        raise ValueError(f"{name} is not symmetric: entries at {at} and {at[::-1]} differ")
    return mirrored(sparse.triu(matrix, format="csc")) if worst else matrix
