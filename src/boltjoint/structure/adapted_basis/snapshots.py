"""Snapshots of a contact-adapted basis, modes of a contact that sticks in part, and options.

A snapshot is a motion that the basis is to hold and, for each quantity of interest, its adjoint
solution. The error of the quantity in a basis is at most the product of the distances of the two
from the basis in the norm of strain energy (Becker and Rannacher 2001), so either may be held badly
where the other is held well.

References
----------
R. Becker, R. Rannacher: An optimal control approach to a posteriori error estimation in finite
element methods. Acta Numerica 10 (2001) 1-102.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.options import Options
from boltjoint.structure.adapted_basis.candidates import Candidates, SpringContact


@dataclass(frozen=True)
class PODOptions(Options):
    """Snapshots by stick patterns, and weights that balance the errors of all.

    Fewer or more modes, and half or twice of any other, move the peaks of three bolts under
    constant load in ``enriched-40`` (1, 10 and 50 N) by at most 1.1e-4 in frequency and 2.2e-3 in
    amplitude. ``enriched-auto`` has from 24 to 64 vectors then, all within the tolerances by their
    estimate.

    Parameters
    ----------
    first_modes
        Modes of each contact that the first basis holds, at most ``free_modes``. Later bases are
        made from its errors.
    load_shares
        Shares of the load of the pairs that stick around the bolts in the stick patterns: from most
        of the contact down to the pressure under the heads.
    iterations
        Decompositions after which the weights are final; the best is kept.
    least_weight
        Share of the mean weight below which none falls, so that what is held well can come back.

    Raises
    ------
    ValueError
        If there are no modes, iterations or shares, a share is not between 0 and 1, or the least
        weight is not between 0 and 1.
    """

    first_modes: int = 8
    load_shares: tuple[float, ...] = (0.75, 0.4, 0.15)
    iterations: int = 40
    least_weight: float = 1e-3

    def __post_init__(self) -> None:
        """Refuse options without a basis, a pattern or a decomposition."""
        checks.whole("first_modes", self.first_modes, at_least=1)
        checks.whole("iterations", self.iterations, at_least=1)
        checks.number("least_weight", self.least_weight, above=0, below=1)
        checks.numbers("load_shares", self.load_shares)
        checks.array("load_shares", self.load_shares, ("shares",), at_most=1)


Array = NDArray[np.float64]


@dataclass(frozen=True)
class Snapshot:
    """A motion in candidates, and adjoint solutions of what is asked of it.

    Attributes
    ----------
    motion
        Shape (candidates, components).
    adjoints
        Adjoints of each quantity of interest over its tolerance, shape (candidates, components)
        each.
    """

    motion: Array
    adjoints: tuple[Array, ...]


def initial_guess(candidates: Candidates) -> Array:
    """Vector from which modes are searched for, the same in every run."""
    return np.random.default_rng(0).standard_normal(len(candidates.mass))


def uniform_modes(candidates: Candidates, stiffness: Array, count: int) -> Array:
    """Modes with the contact open, with all loaded pairs held in the plane, and along normals too.

    In the plane they are held along the first tangent, and the second where candidates hold that.

    Parameters
    ----------
    candidates
        The candidate vectors.
    stiffness
        Stiffness of each pair where it is held [N/m], shape (pairs,).
    count
        Modes of each contact.

    Returns
    -------
    ndarray
        Of unit strain energy, shape (candidates, 3 * count).
    """
    start, spring = initial_guess(candidates), stiffness * candidates.loaded
    none = np.zeros_like(spring)
    held = ((none, none), (spring, none), (spring, spring))
    vectors = [_stuck(candidates, *springs).modes(count, start)[1] for springs in held]
    return np.concatenate(vectors, axis=1)


def pattern_snapshots(
    candidates: Candidates,
    stiffness: Array,
    resonances: int,
    tolerance: float,
    load_shares: Sequence[float] = PODOptions.load_shares,
) -> Iterator[Snapshot]:
    """Modes while a part of the loaded pairs sticks and the others are released.

    All loaded pairs, those in either half along the first tangent, those nearest to the bolts,
    those under the highest pressure, and those farthest from the bolts, with springs in the plane
    only and along the normal too. A resonance is an extremum of the energy, so its relative error
    is half of the squared distance of the mode, which is its own adjoint.

    Parameters
    ----------
    candidates
        The candidate vectors.
    stiffness
        Stiffness of each pair where it sticks [N/m], shape (pairs,).
    resonances
        Modes of each pattern.
    tolerance
        Tolerance of the frequencies, relative.
    load_shares
        As of ``PODOptions``.
    """
    start, x = initial_guess(candidates), candidates.along
    grades = candidates.to_bolts, -candidates.pressure
    inner = [
        grade <= load_quantile(candidates, grade, share)
        for grade in grades
        for share in load_shares
    ]
    parts = np.ones(len(x), dtype=bool), x < 0, x > 0, *inner, ~inner[0]
    for part in parts:
        spring = stiffness * (candidates.loaded & part)
        for normal in (np.zeros_like(spring), spring):
            modes = _stuck(candidates, spring, normal).modes(resonances, start)[1]
            for mode in modes.T:
                yield Snapshot(mode[:, None], (0.5 / tolerance * mode[:, None],))


def _stuck(candidates: Candidates, in_plane: Array, normal: Array) -> SpringContact:
    """Springs along the tangents that the candidates hold, and along the normal."""
    lateral = None if candidates.lateral is None else in_plane
    return SpringContact(candidates, in_plane, normal, lateral)


def load_quantile(candidates: Candidates, grade: Array, share: float) -> float:
    """The value of ``grade`` up to which pairs carry a share of the load."""
    order = np.argsort(grade, kind="stable")
    carried = np.cumsum((candidates.normal_load * candidates.weight)[order])
    # the last sum misses the total by rounding only
    reached = np.searchsorted(carried, share * carried[-1] * (1 - 1e-12))
    return float(grade[order[reached]])
