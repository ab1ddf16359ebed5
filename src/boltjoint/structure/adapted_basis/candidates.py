"""Candidate vectors of a contact-adapted basis: attachment modes of the contact and free modes.

Modes of the structure without contact cannot follow the compliance around a bolt. The candidates
are such modes and the attachment modes of the contact: the static shapes of unit forces on every
contact pair. Together they resolve whatever the contact does.

Slip is held along the first tangent of every point, whatever its direction in space, and opening
along the normal: that is all that laws of friction in one direction see. Of a structure with a
plane of symmetry only symmetric motion is held then, as are forces and preload. For laws in both
directions slip along the second tangents is held too, and all motion of the structure.

References
----------
R. R. Craig: Coupling of substructures for dynamic analyses: an overview. 41st AIAA Structures,
Structural Dynamics, and Materials Conference (2000), AIAA-2000-1573.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.sparse.linalg import LinearOperator, eigsh

from boltjoint import checks
from boltjoint.joint.surface_places import SurfacePlaces
from boltjoint.structure.adapted_basis.attachment_modes import (
    SolvedVectors,
    attachment_modes,
    symmetric_part,
)
from boltjoint.structure.bolt_tension import distance_to_bolts
from boltjoint.structure.makers.registry import ELASTIC, families_of
from boltjoint.structure.model import Structure
from boltjoint.structure.subspaces import part_that_moves, whole

Array = NDArray[np.float64]

#: share of the largest energy below which a candidate or a POD mode depends on the others
DEPENDENT_SHARE = 1e-12


@dataclass(frozen=True)
class Candidates:
    """Candidate vectors in coordinates a in which K is the unit matrix.

    Pairs are those on one side of the plane of symmetry and on it, all where there is none.

    Attributes
    ----------
    vector
        Modes and attachment modes, shape (unknowns, vectors), for products with combinations.
    coordinate
        Matrix from a to factors of the vectors, shape (vectors, candidates).
    mass
        M in these coordinates, shape (candidates, candidates).
    tangential, normal
        Relative displacement of the pairs along the first tangent and the normal, shape (pairs,
        candidates).
    lateral
        The same along the second tangent; None where laws do not need it.
    weight
        2 for a pair that also represents its mirror image, else 1, shape (pairs,).
    normal_load, gap
        Normal load and gap of the pairs after tightening [N], [m].
    area, surface
        [m2], and name of the surface.
    along
        Place along the first tangent from the middle of the surface [m], shape (pairs,).
    to_bolts
        Distance from the nearest bolt axis [m], shape (pairs,).
    assembly_position
        Positions of all pairs of the assembly [m], shape (pairs of the assembly, 3).
    pair_on_side
        The pair here that each pair of the assembly is, or is the mirror image of, shape (pairs of
        the assembly,).
    free_frequency
        Natural frequencies of modes without contact [Hz], shape (free modes,): those of bending,
        where the maker tells families apart and only they are held, else all.
    free_participation
        ``phi^T M`` of these modes, shape (free modes, candidates).
    """

    vector: Array | SolvedVectors
    coordinate: Array
    mass: Array
    tangential: Array
    normal: Array
    weight: Array
    normal_load: Array
    gap: Array
    area: Array
    surface: NDArray[np.str_]
    along: Array
    to_bolts: Array
    assembly_position: Array
    pair_on_side: NDArray[np.int64]
    free_frequency: Array
    free_participation: Array
    lateral: Array | None = None

    @property
    def by_direction(self) -> dict[str, Array]:
        """Relative displacement by its direction, shape (pairs, candidates) each."""
        one = {"tangential": self.tangential, "normal": self.normal}
        return one if self.lateral is None else one | {"lateral": self.lateral}

    @cached_property
    def rows(self) -> Array:
        """Tangential rows, then normal ones and lateral ones if any, (rows, candidates)."""
        return np.concatenate(list(self.by_direction.values()))

    @cached_property
    def flexibility(self) -> Array:
        """Relative displacements for unit forces [m/N], shape (rows, rows)."""
        return self.rows @ self.rows.T

    @property
    def pressure(self) -> Array:
        """Of the pairs after tightening [Pa]."""
        return self.normal_load / self.area

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """The pairs that carry load."""
        return self.normal_load > 0


class SpringContact:
    """The candidates with a linear spring on each pair.

    Parameters
    ----------
    candidates
        The candidate vectors.
    tangential, normal
        Stiffness of the pairs along the first tangent and the normal [N/m], shape (pairs,).
    lateral
        The same along the second tangent, where the candidates hold that.
    """

    def __init__(
        self,
        candidates: Candidates,
        tangential: Array,
        normal: Array,
        lateral: Array | None = None,
    ) -> None:
        self.candidates = candidates
        springs = [tangential, normal] if lateral is None else [tangential, normal, lateral]
        stiffness = np.concatenate(springs) * np.tile(candidates.weight, len(springs))
        # springs that are weak against all others only spoil the condition of the compliance
        acting = np.flatnonzero(stiffness > 1e-6 * stiffness.max(initial=0.0))
        self._acting = acting
        self._stiffness, self._rows = stiffness[acting], candidates.rows[acting]

    @cached_property
    def _factors(self) -> tuple[Array, bool]:
        """Factors of the compliance of the springs and of the structure between them."""
        compliance = self.candidates.flexibility[np.ix_(self._acting, self._acting)]
        compliance[np.diag_indices(self._acting.size)] += 1 / self._stiffness
        return cho_factor(compliance, overwrite_a=True)

    def displacement(self, force: Array) -> Array:
        """(1 + R^T D R)^-1 times a force, by Woodbury's formula over the springs that act."""
        if not (self._acting.size and force.any()):
            return force
        return force - self._rows.T @ cho_solve(self._factors, self._rows @ force)

    def modes(self, count: int, start: Array) -> tuple[Array, Array]:
        """Squared frequencies and modes of unit strain energy, from an initial vector."""
        n = len(self.candidates.mass)
        stiffness = LinearOperator(
            (n, n), lambda a: a + self._rows.T @ (self._stiffness * (self._rows @ a)), dtype=float
        )
        inverse = LinearOperator((n, n), self.displacement, dtype=float)
        # low modes have the largest ratio of mass to stiffness
        ratio, a = eigsh(
            self.candidates.mass,
            k=count,
            M=stiffness,
            Minv=inverse,
            v0=start,
            ncv=min(n, 2 * count + 8),
        )
        order = np.argsort(-ratio)
        return 1 / ratio[order], a[:, order]


def _stiffness(squared: Array, moved: Array) -> Array:
    """Stiffness of free modes, by their squared frequencies, and of attachment modes after them."""
    modes, vectors = squared.size, moved.shape[1]
    # K times an attachment mode is its force, and modes are orthogonal
    stiffness = np.empty((vectors, vectors))
    stiffness[:modes, :modes] = np.diag(squared)
    stiffness[modes:] = moved
    stiffness[:modes, modes:] = moved[:, :modes].T
    return symmetric_part(stiffness)


def _independent(stiffness: Array) -> Array:
    """Combinations of vectors of unit strain energy without those that depend on others."""
    scale = 1 / np.sqrt(np.diag(stiffness))
    share, turn = eigh(scale[:, None] * stiffness * scale)
    independent = share > DEPENDENT_SHARE * share[-1]
    return scale[:, None] * turn[:, independent] / np.sqrt(share[independent])


def find_candidates(
    structure: Structure, preload: xr.Dataset, free_modes: int, *, second_tangents: bool = False
) -> Candidates:
    """Modes without contact, and attachment modes of unit forces on every point, t1 and normal.

    Attachment modes make the contact's flexibility exact, modes the inertia at low frequency.

    Parameters
    ----------
    structure, preload
        The structure, and its preload as from ``apply_preload``.
    free_modes
        Number of modes.
    second_tangents
        Whether forces along the second tangents are held too, and with them all motion of the
        structure, symmetric or not.

    Raises
    ------
    ValueError
        If structure and preload do not hold the same points, or no point carries load.
    """
    contact = structure.contact
    if not np.array_equal(contact.position, preload["position"].to_numpy()):
        raise ValueError("assembly and preload have different contact pairs")
    if not np.any(preload["normal_load"] > 0):
        raise ValueError("no contact pair carries load")
    loads = (
        checks.variable("preload", preload, name, ("pair",)) for name in ("normal_load", "gap")
    )
    # mirror images on two surfaces may have another friction law
    surface = np.unique(contact.surface, return_inverse=True)[1]
    part = whole(structure, tightened=False)
    if not second_tangents:
        part = part_that_moves(structure, *loads, surface)
    own = np.arange(len(contact))
    symmetry = structure.symmetry
    image = symmetry.point if part.is_half and symmetry is not None else own
    # of two mirror images the later one
    point = np.flatnonzero(own >= image)
    K = part.stiffness
    directions = (0, 2, 1) if second_tangents else (0, 2)
    C = part.relative[np.concatenate([3 * point + direction for direction in directions])]

    factors = part.factors(K)
    squared, mode = part.modes(factors, K, free_modes)
    vector, moved, mass = attachment_modes(part, factors, mode, C)
    coordinate = _independent(_stiffness(squared, moved))
    frequency = np.sqrt(squared) / (2 * np.pi)
    family = families_of(structure, part.basis @ mode).family
    kept = np.flatnonzero((family == "bending") | (family == ELASTIC) | second_tangents)
    tangential, normal, *lateral = np.split(moved @ coordinate, len(directions))
    number = np.zeros(len(contact), dtype=np.int64)
    number[point] = np.arange(point.size)
    to_bolts = distance_to_bolts(structure.bolts, contact.position[point])
    return Candidates(
        vector=vector,
        coordinate=coordinate,
        mass=symmetric_part(coordinate.T @ mass @ coordinate),
        tangential=tangential,
        normal=normal,
        weight=np.where(image[point] != point, 2.0, 1.0),
        normal_load=preload["normal_load"].to_numpy()[point],
        gap=preload["gap"].to_numpy()[point],
        area=contact.area[point],
        surface=contact.surface[point],
        along=SurfacePlaces.in_planes(
            contact.position[point], contact.frame[point], contact.surface[point]
        ).from_middle,
        to_bolts=np.zeros(point.size) if to_bolts is None else to_bolts,
        assembly_position=contact.position,
        pair_on_side=number[np.maximum(own, image)],
        free_frequency=frequency[kept],
        free_participation=mass[kept] @ coordinate,
        lateral=lateral[0] if lateral else None,
    )


def stuck_spring_stiffness(candidates: Candidates, contact_stiffness: Array) -> Array:
    """Springs on all loaded pairs along each direction [N/m], (rows,), from those of all pairs."""
    springs = contact_stiffness * candidates.loaded * candidates.weight
    return np.tile(springs, len(candidates.by_direction))
