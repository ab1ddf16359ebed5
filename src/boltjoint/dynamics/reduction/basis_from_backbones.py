"""Contact-adapted basis that is adapted to backbones and estimates the error of its own peaks.

The basis is found in candidates that resolve whatever the contact does. Backbones of the contact
conditions it is made for are traced in the basis at hand; its dual-weighted residuals give
snapshots of what it lacks, and POD modes of the snapshots, weighed so that all peaks are held
equally well, are the next basis. Solving the same states again in fewer and in all of its POD modes
gives the error of peaks by the number of vectors, before any response of the whole joint is solved.

References
----------
R. Becker, R. Rannacher: An optimal control approach to a posteriori error estimation in finite
element methods. Acta Numerica 10 (2001) 1-102.
"""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.sparse.linalg import ArpackError
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.damping import Damping
from boltjoint.dataset import quantity
from boltjoint.dynamics.backbone.epmc import ModalState
from boltjoint.dynamics.backbone.peak_force import PeakSensitivity, peak_sensitivities
from boltjoint.dynamics.reduction.candidate_backbone import CandidateBackbone
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.joint.io import free_mode_quantities
from boltjoint.joint.model import Joint
from boltjoint.names import FEWEST_AUTOMATIC
from boltjoint.structure.adapted_basis.candidates import Candidates, find_candidates
from boltjoint.structure.adapted_basis.pod import EnergyCoordinates, PODModes, balanced_pod_modes
from boltjoint.structure.adapted_basis.snapshots import (
    PODOptions,
    Snapshot,
    pattern_snapshots,
    uniform_modes,
)
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.model import Structure

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TracedBackbone:
    """States of a backbone in a basis, and the sensitivity of the peak at each of them."""

    mode: CandidateBackbone
    states: tuple[ModalState, ...]
    sensitivities: tuple[PeakSensitivity, ...]


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def find_pod_modes(
    assembly: xr.Dataset | Structure,
    preload: xr.Dataset,
    conditions: Sequence[ContactCondition],
    options: ContactAdaptedBasis | None = None,
    pod_options: PODOptions = PODOptions(),
) -> xr.Dataset:
    """POD modes of an assembly for the contact conditions of its cases.

    Parameters
    ----------
    assembly, preload
        A structure or an assembly of a maker, and its preload. Only the ratios of loads and gaps
        matter, not their size: amplitudes are scanned until all of the contact slips.
    conditions
        Contact and damping that the basis is made for, at least one.
    options
        Number of candidates and POD modes, tolerances, and the states at which errors are found;
        those of a study by default.
    pod_options
        Options of the snapshots and their decomposition.

    Returns
    -------
    Dataset
        ``pod_mode_motion`` (unknown, pod_mode) [m J^-1/2] in the unknowns of the symmetric part,
        or of all motion, by decreasing energy, orthonormal in strain energy (``v^T K v = 1``,
        K with springs on the loaded pairs); ``energy_share``
        (pod_mode): energy of the weighted snapshots along it, over all of theirs; ``position``
        (pair, axis) [m]; ``frequency_error``, ``amplitude_error`` (trial): largest relative errors
        of peaks in the first ``trial_vectors`` (trial) POD modes; ``free_frequency`` (free_mode)
        [Hz] of bending modes without contact, ``free_participation`` (free_mode, pod_mode): ``phi^T
        M`` of them times the POD modes [s]. Attribute
        ``automatic_vectors``: the fewest of them within the tolerances, or the most if none are.

    Raises
    ------
    ValueError
        If preload and assembly do not hold the same pairs, no pair carries load, there is no
        condition, or the structure has too few degrees of freedom for such a basis.
    RuntimeError
        If the assembly is not held, or the candidates are lost in rounding.
    """
    options = ContactAdaptedBasis() if options is None else options
    checks.sequence("conditions", conditions, ContactCondition)
    checks.instance("preload", preload, xr.Dataset)
    conditions = list(dict.fromkeys(conditions))
    if not conditions:
        raise ValueError("conditions are empty: a basis is made for at least one contact")
    structure = structure_of(assembly)
    second_tangents = any(at.needs_second_tangents for at in conditions)
    candidates = find_candidates(
        structure, preload, options.free_modes, second_tangents=second_tangents
    )
    shapes, first = len(candidates.mass), min(pod_options.first_modes, options.free_modes)
    if shapes <= first:
        raise ValueError(
            f"structure and contact have {shapes} shapes, too few for a contact-adapted basis, "
            f"which begins with {first} modes: take all-{shapes}"
        )
    connections = [(partial(at.connect, preload), at.damping) for at in conditions]
    of_pairs = candidates.area, candidates.surface
    of_conditions = [at.tangential_stiffness(*of_pairs) for at in conditions]
    stiffness = np.max(of_conditions, axis=0)
    with _refusing_rounding(conditions):
        basis = _adapted(candidates, connections, stiffness, options, pod_options)
        trials = _error_by_vectors(candidates, connections, basis.vector, options)
    vectors, errors = np.array([count for count, _ in trials]), np.array([e for _, e in trials])
    within = np.all(errors <= _tolerances(options), axis=1)
    automatic = int(vectors[np.argmax(within)] if within.any() else vectors[-1])
    reached = "are within" if within.any() else "are the most, and not within"
    logger.info("contact-adapted basis: %d vectors %s the tolerances", automatic, reached)
    attributes = {
        "automatic_vectors": automatic,
        "within_tolerances": int(within.any()),
        "options": pod_options.stored(),
    }
    variables = {
        **_of_modes(candidates, basis),
        **_of_trials(vectors, errors),
        "position": structure.contact.variables()["position"],
        **free_mode_quantities(
            candidates.free_frequency,
            candidates.free_participation @ basis.vector,
            of="pod_mode",
            unit="s",
        ),
    }
    return xr.Dataset(variables, coords={"axis": ["x", "y", "z"]}, attrs=attributes)


@contextmanager
def _refusing_rounding(conditions: Sequence[ContactCondition]) -> Iterator[None]:
    try:
        yield
    except (ArpackError, ValueError) as error:
        # SciPy's refusal of matrices that overflowed, or that rounding has made indefinite
        raise RuntimeError(
            f"the basis for {conditions!r} is lost in rounding ({error}): choose stiffnesses nearer"
            " to each other, or fewer contact_adapted_basis.free_modes"
        ) from error


def _of_modes(candidates: Candidates, basis: PODModes) -> dict[str, xr.Variable]:
    """The POD modes as their file holds them."""
    motion = candidates.vector @ (candidates.coordinate @ basis.vector)
    return {
        "pod_mode_motion": quantity(
            ("unknown", "pod_mode"),
            motion,
            "m J^-1/2",
            "POD mode, of unit strain energy with the contact stuck",
        ),
        "energy_share": quantity(
            "pod_mode",
            basis.energy_share,
            "1",
            "strain energy of the snapshots along it, over all of it",
        ),
    }


def _of_trials(vectors: NDArray[np.int64], errors: Array) -> dict[str, xr.Variable]:
    """The errors of bases of some vectors, as the file of POD modes holds them."""
    relative_error = "largest relative error of peak {} on the backbones it is made for"
    return {
        "trial_vectors": quantity("trial", vectors, "1", "vectors of a basis"),
        "frequency_error": quantity(
            "trial", errors[:, 0], "1", relative_error.format("frequencies")
        ),
        "amplitude_error": quantity(
            "trial", errors[:, 1], "1", relative_error.format("amplitudes")
        ),
    }


_Connections = Sequence[tuple[Callable[[xr.Dataset], Joint], Damping]]


def _tolerances(options: ContactAdaptedBasis) -> Array:
    return np.array([options.frequency_tolerance, options.amplitude_tolerance])


def _adapted(
    candidates: Candidates,
    connections: _Connections,
    stiffness: Array,
    options: ContactAdaptedBasis,
    pod_options: PODOptions,
) -> PODModes:
    """POD modes of snapshots in bases that are each made from the one before."""
    tolerances = _tolerances(options)
    first = uniform_modes(candidates, stiffness, min(pod_options.first_modes, options.free_modes))
    vectors = EnergyCoordinates(candidates, first, stiffness).basis
    of_patterns = options.resonances, options.pattern_tolerance, pod_options.load_shares
    patterns = list(pattern_snapshots(candidates, stiffness, *of_patterns))
    weighting = pod_options.iterations, pod_options.least_weight
    snapshots: list[Snapshot] = []
    for adaptation in range(options.adaptations):
        before, snapshots, errors = snapshots, [], [np.zeros(2)]
        for connect, damping in connections:
            traced = _trace(CandidateBackbone(candidates, vectors, connect, damping), options)
            for snapshot, error in _snapshots(traced, tolerances, options.states, adaptation):
                snapshots.append(snapshot)
                errors.append(abs(error))
        basis = balanced_pod_modes(
            candidates,
            [*patterns, *before, *snapshots],
            options.balanced_vectors,
            options.maximum_vectors,
            stiffness,
            *weighting,
        )
        largest = np.max(errors, axis=0)
        logger.info(
            "adaptation %d: %d snapshots in %d vectors, dual-weighted residual of peaks %.1e in "
            "frequency and %.1e in amplitude",
            *(adaptation + 1, len(snapshots), vectors.shape[1], *largest),
        )
        vectors = basis.vector
        if np.all(largest <= tolerances):
            break
    else:
        logger.warning(
            "errors of a contact-adapted basis may be larger than estimated: its "
            "residuals are not within the tolerances after %d adaptations "
            "(contact_adapted_basis: adaptations, maximum_vectors, resonances)",
            options.adaptations,
        )
    return basis


def _trace(mode: CandidateBackbone, options: ContactAdaptedBasis) -> TracedBackbone:
    """The backbone from the onset of slip until structural damping outweighs friction again."""
    backbone = mode.trace(options.lowest_amplitude, options.highest_amplitude)
    states = backbone.states
    if len(states) < 3:
        raise ValueError(f"the backbone ends after {len(states)} states: {backbone.reason}")
    if not backbone.complete:
        logger.warning("a backbone ends before all slips: %s", backbone.reason)
    return TracedBackbone(mode, states, peak_sensitivities(states, options.smallest_growth))


def _snapshots(
    traced: TracedBackbone, tolerances: Array, number: int, adaptation: int
) -> Iterator[tuple[Snapshot, Array]]:
    """Snapshots of some states with the dual-weighted residuals of their peaks.

    Every other adaptation takes the states between those of the one before.
    """
    last = len(traced.states) - 1
    spacing = last / max(number - 1, 1)
    at = spacing * (np.arange(number) + (adaptation % 2) / 2)
    for index in np.unique(np.minimum(at, last).round().astype(int)):
        correction = traced.mode.correct(traced.states[index], traced.sensitivities[index])
        adjoints = zip(correction.adjoints, tolerances, strict=True)
        yield (
            Snapshot(correction.motion, tuple(z / limit for z, limit in adjoints)),
            correction.errors,
        )


def _error_by_vectors(
    candidates: Candidates,
    connections: _Connections,
    vectors: Array,
    options: ContactAdaptedBasis,
) -> list[tuple[int, Array]]:
    """Number of vectors and largest errors of frequency and amplitude of the peaks in them.

    From few vectors on, until the errors are within the tolerances.
    """
    traced = [
        _trace(CandidateBackbone(candidates, vectors, connect, damping), options)
        for connect, damping in connections
    ]
    most = vectors.shape[1]
    trials = []
    for count in [*range(min(FEWEST_AUTOMATIC, most), most, options.trial_step), most]:
        errors = [
            _largest_errors(
                backbone, CandidateBackbone(candidates, vectors[:, :count], connect, damping)
            )
            for backbone, (connect, damping) in zip(traced, connections, strict=True)
        ]
        trials.append((count, np.max(errors, axis=0)))
        logger.info("%d vectors: errors of peaks %.1e and %.1e", count, *trials[-1][1])
        if np.all(trials[-1][1] <= _tolerances(options)):
            break
    return trials


def _largest_errors(reference: TracedBackbone, mode: CandidateBackbone) -> Array:
    """Largest relative errors of frequency and amplitude of the peaks of a mode in fewer vectors.

    Infinite where more than a tenth of the states are not found.
    """
    largest, found_states = np.zeros(2), 0
    difference: Array | float = 0.0
    transferred = mode.transfer(reference.mode)
    for state, sensitivity in zip(reference.states, reference.sensitivities, strict=True):
        projected = transferred(state)
        # a state lacks about what the one before lacks
        solution = mode.solve_near(projected + difference, state.log_amplitude)
        if solution is None:
            continue
        found_states += 1
        difference = solution.unknown - projected
        change = solution.eigenvalue - state.eigenvalue
        error = sensitivity.gradient @ [change.real, change.imag]
        largest = np.maximum(largest, abs(error))
    return largest if found_states >= 0.9 * len(reference.states) else np.full(2, np.inf)
