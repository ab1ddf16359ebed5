"""Contact-adapted basis: POD modes of snapshots, and the snapshot weights that hold all equally.

Proper orthogonal decomposition (POD) in the norm of strain energy keeps the vectors that weighted
snapshots have most in common. Any first N of these POD modes make the basis ``enriched-N``. The
weights are those of a minimax problem: the largest error of all that the basis is made for is to be
as small as possible. It is solved by multiplicative weights: what is held worst counts more in the
next decomposition.

References
----------
G. Berkooz, P. Holmes, J. L. Lumley: The proper orthogonal decomposition in the analysis of
turbulent flows. Annual Review of Fluid Mechanics 25 (1993) 539-575.
S. Arora, E. Hazan, S. Kale: The multiplicative weights update method: a meta-algorithm and
applications. Theory of Computing 8 (2012) 121-164.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import eigh

from boltjoint import checks
from boltjoint.structure.adapted_basis.candidates import (
    DEPENDENT_SHARE,
    Candidates,
    stuck_spring_stiffness,
)
from boltjoint.structure.adapted_basis.snapshots import PODOptions, Snapshot
from boltjoint.structure.factors import check_held
from boltjoint.structure.model import Structure
from boltjoint.structure.subspaces import symmetric, whole

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PODModes:
    """POD modes of weighted snapshots, and how well they hold each snapshot.

    Attributes
    ----------
    vector
        Orthonormal in strain energy, by decreasing energy, shape (candidates, POD modes).
    energy_share
        Energy of the weighted snapshots along each over all of it, shape (POD modes,).
    error_bound
        Largest error bound of all quantities of interest, over their tolerances, in the number of
        vectors that the weights are for.
    """

    vector: Array
    energy_share: Array
    error_bound: float


class EnergyCoordinates:
    """Vectors in coordinates that are orthonormal in strain energy with the contact stuck.

    The error of a resonance is about the squared error of its mode in that norm.

    Parameters
    ----------
    candidates
        The space of the vectors.
    vectors
        Shape (candidates, vectors); each counts alike, whatever its size.
    contact_stiffness
        Stiffness of the springs along t1 and normal, which all loaded pairs have [N/m], shape
        (pairs,).
    """

    def __init__(self, candidates: Candidates, vectors: Array, contact_stiffness: Array) -> None:
        moved = candidates.rows @ vectors
        spring = stuck_spring_stiffness(candidates, contact_stiffness)
        norm = np.sqrt((vectors**2).sum(axis=0) + spring @ moved**2)
        self._vectors, self._norm = vectors, np.where(norm > 0, norm, 1.0)
        self._moved, self._spring = moved, spring

    @cached_property
    def _decomposition(self) -> tuple[Array, Array]:
        scaled, moved = self._vectors / self._norm, self._moved / self._norm
        energy, turn = eigh(scaled.T @ scaled + moved.T @ (self._spring[:, None] * moved))
        independent = energy > DEPENDENT_SHARE * energy[-1]
        return np.sqrt(energy[independent]), turn[:, independent]

    @property
    def basis(self) -> Array:
        """Orthonormal vectors that span the given ones, shape (candidates, rank)."""
        root, turn = self._decomposition
        return (self._vectors / self._norm) @ (turn / root)

    @property
    def coordinate(self) -> Array:
        """The given vectors in that basis, shape (rank, vectors)."""
        root, turn = self._decomposition
        return (turn * root).T * self._norm


def balanced_pod_modes(
    candidates: Candidates,
    snapshots: Sequence[Snapshot],
    number: int,
    maximum: int,
    contact_stiffness: Array,
    iterations: int = PODOptions.iterations,
    least_weight: float = PODOptions.least_weight,
) -> PODModes:
    """POD modes of snapshots whose weights make the largest error bound as small as possible.

    With the distances a of a motion and b of an adjoint from the span of the first N modes, the
    error bound is ``a b``. In the weighted sum ``sum l a b`` of all bounds, a decomposition weighs
    the square of a by ``l b / a`` and that of b by ``l a / b``. After each decomposition, l grows
    by the root of the bound over the largest one. The best of all decompositions is kept.

    Parameters
    ----------
    candidates
        The space of the snapshots.
    snapshots
        At least one.
    number
        N.
    maximum
        POD modes kept, or as many as the snapshots span if those are fewer.
    contact_stiffness
        Stiffness of the norm, as for ``EnergyCoordinates``.
    iterations, least_weight
        As of ``PODOptions``.
    """
    snapshots = list(snapshots)
    columns = [part for snapshot in snapshots for part in (snapshot.motion, *snapshot.adjoints)]
    coordinates = EnergyCoordinates(candidates, np.concatenate(columns, axis=1), contact_stiffness)
    coordinate = coordinates.coordinate
    # of every part, a motion or an adjoint, its first column; of every product, its two parts
    first = np.cumsum([0, *(part.shape[1] for part in columns)])
    counts = [1 + len(snapshot.adjoints) for snapshot in snapshots]
    start = np.cumsum([0, *counts[:-1]])
    motion = np.repeat(start, [count - 1 for count in counts])
    adjoint = np.delete(np.arange(len(columns)), start)

    def distances(outside: Array) -> Array:
        return np.sqrt(np.add.reduceat((outside**2).sum(axis=0), first[:-1]))

    lowest = max(len(coordinate) - maximum, 0)
    distance = distances(coordinate)
    importance = np.full(len(adjoint), 1.0 / len(adjoint))
    best: tuple[float, Array, Array] | None = None
    for _ in range(iterations):
        a, b = (np.maximum(distance[part], np.finfo(float).tiny) for part in (motion, adjoint))
        weight = np.bincount(motion, importance * b / a, len(columns))
        weight[adjoint] = importance * a / b
        by_column = np.repeat(weight, np.diff(first))
        correlation = (coordinate * by_column) @ coordinate.T
        energy, vectors = eigh(correlation, subset_by_index=(lowest, len(correlation) - 1))
        energy, vectors = energy[::-1], vectors[:, ::-1]
        kept = vectors[:, :number]
        distance = distances(coordinate - kept @ (kept.T @ coordinate))
        bound = distance[motion] * distance[adjoint]
        largest = bound.max()
        if best is None or largest < best[0]:
            best = largest, vectors, np.maximum(energy, 0.0) / np.trace(correlation)
        if largest <= 0:
            break
        importance = importance * np.sqrt(bound / largest)
        importance = np.maximum(importance / importance.sum(), least_weight / len(adjoint))
    if best is None:
        raise ValueError("POD modes need an iteration")
    largest, vectors, share = best
    return PODModes(coordinates.basis @ vectors, share, float(largest))


class Basis(NamedTuple):
    """Vectors that are used like modes, orthonormal in M and diagonal in K.

    ``frequency`` (vectors,) [Hz], ascending; ``q`` (dofs, vectors) [kg^-1/2];
    ``free_frequency`` (free modes,) [Hz] of modes without contact, and ``free_participation`` (free
    modes, vectors), phi^T M of them times the vectors [-].
    """

    frequency: Array
    q: Array
    free_frequency: Array
    free_participation: Array


def basis_of_pod_modes(structure: Structure, pod_modes: xr.Dataset, number: int) -> Basis:
    """The first POD modes of a structure as a basis that is used like modes.

    Parameters
    ----------
    structure, pod_modes
        A structure and, for the same, POD modes as from ``find_pod_modes``.
    number
        Number of vectors.

    Raises
    ------
    ValueError
        If the POD modes are of another mesh, or there are fewer of them.
    RuntimeError
        If a frequency is no number or zero within rounding: the assembly is not held.
    """
    number = checks.whole("number", number, at_least=1)
    position = checks.variable("pod_modes", pod_modes, "position", ("pair", "axis"))
    # of the symmetric part, or of all motion where the preload is not symmetric
    parts = symmetric(structure), whole(structure, tightened=False)
    unknowns = pod_modes.sizes.get("unknown")
    part = next((subspace for subspace in parts if subspace.basis.shape[1] == unknowns), None)
    if part is None or not np.array_equal(position, structure.contact.position):
        raise ValueError("the POD modes were found on a different mesh")
    if number > pod_modes.sizes["pod_mode"]:
        raise ValueError(
            f"enriched-{number}: there are {pod_modes.sizes['pod_mode']} POD modes: take as many "
            "or fewer, or keep more (maximum_vectors), which more states may span (states)"
        )
    vector = pod_modes["pod_mode_motion"].transpose("unknown", "pod_mode")[:, :number].to_numpy()
    squared, share = eigh(vector.T @ (part.stiffness @ vector), vector.T @ (part.mass @ vector))
    check_held(squared, part.stiffness, part.mass)
    participation = pod_modes["free_participation"].transpose("free_mode", "pod_mode")
    return Basis(
        frequency=np.sqrt(squared) / (2 * np.pi),
        q=part.basis @ (vector @ share),
        free_frequency=pod_modes["free_frequency"].to_numpy(),
        free_participation=participation.to_numpy()[:, :number] @ share,
    )


def estimated_errors(pod_modes: xr.Dataset, number: int) -> dict[str, float]:
    """Attributes with the estimated errors of peaks in the first POD modes, where they are known.

    They are those of as many vectors, or of the most that were tried of fewer: vectors are nested,
    so that more err less.

    Parameters
    ----------
    pod_modes
        As from ``find_pod_modes``.
    number
        Number of vectors.
    """
    vectors = pod_modes["trial_vectors"].to_numpy()
    if not np.any(vectors <= number):
        return {}
    trial = np.where(vectors <= number, vectors, 0).argmax()
    return {
        f"estimated_{what}_error": float(pod_modes[f"{what}_error"][trial])
        for what in ("frequency", "amplitude")
    }
