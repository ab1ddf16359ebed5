"""Modal bases of an assembly: modes without contact, or a contact-adapted basis.

The contact between the bars is removed; the bolts, their pretension sections closed, hold the bars
together. Families of modes are distinguished by kinetic energy. A contact-adapted basis
(``structure.adapted_basis``) also holds what modes without contact cannot, and is used like modes.
"""

import logging
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.joint.io import free_mode_quantities
from boltjoint.structure.adapted_basis.pod import Basis, basis_of_pod_modes, estimated_errors
from boltjoint.structure.makers.registry import Families, families_of, structure_of, that_respond
from boltjoint.structure.model import Row, Structure
from boltjoint.structure.modes_at_limits import modes_at_limits
from boltjoint.structure.subspaces import Subspace, antisymmetric, symmetric, whole

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: rows whose first one must move, and the problem where it does not
_DEFAULTS = {
    "outputs": "the output point does not move in the selected modes",
    "inputs": "this force does not excite the selected modes",
}

#: bending modes up to which lateral and torsional ones, which are not symmetric, are found as well
_MOST_BESIDE_OTHERS = 12

#: families of bases
_FAMILIES = ("free", "all", "enriched")


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def find_modes(
    assembly: xr.Dataset | Structure, family: str, pod_modes: xr.Dataset | None = None
) -> xr.Dataset:
    """Modal basis of an assembly, as ``modes.nc`` holds it.

    Parameters
    ----------
    assembly
        A structure, or an assembly of a maker.
    family
        ``free-N``: the first N modes with the contact removed, of bending where the maker tells
        families apart, else those that inputs and outputs take part in. ``all-N``: the first N
        of any family, bending, lateral, torsional or axial. ``enriched-N``: the contact-adapted
        basis of N vectors, orthonormal in mass and diagonal in stiffness. ``enriched-auto``: as
        many vectors as reach the tolerances of the POD modes. Rigid-body modes come first, at 0 Hz,
        where the structure has some.
    pod_modes
        As from ``find_pod_modes``, for the same assembly; ``enriched-N`` takes the first N of them,
        ``free-N`` and ``all-N`` need none.

    Returns
    -------
    Dataset
        ``natural_frequency`` (mode) [Hz]; mass-normalised [kg^-1/2]: ``mode_shape`` (node, axis,
        mode), ``relative_mode`` (pair, axis, mode) of side A minus side B, ``response_mode``
        (mode), positive where it does not vanish, ``excitation_mode`` (mode), both where a
        case gives no point; ``input_mode`` (input, mode) and ``output_mode`` (output, mode);
        ``base_excitation_mode`` (axis, mode) [kg^1/2] where it is held; ``position`` (pair,
        axis) [m]; ``area`` (pair) [m2]; and what
        ``modes_at_limits`` gives. With ``free-N`` and ``all-N``, of every mode that was
        solved for, for large N of ``free-N`` symmetric ones only: ``candidate_frequency``
        (candidate) [Hz], ``candidate_family`` (candidate), and the shares of kinetic energy that
        decided it, ``energy_share`` (candidate, axis) and ``symmetric_share`` (candidate). With
        ``enriched-N`` of bending modes without contact, and where degrees of freedom are modes that
        were given of these, ``free_frequency`` (free_mode) [Hz] and ``free_participation``
        (free_mode, mode), phi^T M of them times the vectors [-]. With ``enriched-auto``, and where
        they are known with ``enriched-N``, the attributes ``estimated_frequency_error`` and
        ``estimated_amplitude_error``: largest relative errors of peaks that are due to the basis.

    Raises
    ------
    ValueError
        If there is no such family, or the mesh has not as many modes; if ``enriched-N`` gets no POD
        modes, too few, or those of another mesh; or if the force excites none of the modes, or the
        output point moves in none, as where it is held, or across a plane of symmetry.
    RuntimeError
        If a natural frequency is no number or zero within rounding: the assembly is not held.
    """
    structure = structure_of(assembly)
    kind, number = _parse(family)
    attributes: dict[str, str | float] = {"modes": family}
    if kind in _WITHOUT_CONTACT:
        modes, chosen = _WITHOUT_CONTACT[kind](structure, number)
        frequency, q = modes.frequency[chosen], modes.q[:, chosen]
    else:
        if pod_modes is None:
            raise ValueError(f"{family} needs POD modes of the assembly, from find_pod_modes")
        number = number or pod_modes.attrs["automatic_vectors"]
        attributes |= {"vectors": number, **estimated_errors(pod_modes, number)}
        basis = basis_of_pod_modes(structure, pod_modes, number)
        frequency, q = basis.frequency, basis.q
    frequency, q = _with_rigid_modes(structure, frequency, q)
    largest = abs(q).max(axis=0)
    response, excitation = (
        _default(getattr(structure, rows), q, largest, problem, family)
        for rows, problem in _DEFAULTS.items()
    )
    sign = _signs(response, q)
    q = q * sign
    if kind in _WITHOUT_CONTACT:
        of_family = _candidates(modes) | _among_given_modes(structure, q)
    else:
        of_family = _participation(basis, sign)
    logger.info("modes %s: %s Hz", family, ", ".join(f"{f:.6g}" for f in frequency))
    variables = {
        "natural_frequency": quantity("mode", frequency, "Hz", "natural frequency"),
        **_variables(structure, q, response * sign, excitation * sign),
        **of_family,
    }
    return xr.Dataset(variables, coords=_axes(structure), attrs=attributes)


def _axes(structure: Structure) -> dict[str, Any]:
    return {
        "axis": ["x", "y", "z"],
        "input": np.array(list(structure.inputs), dtype=object),
        "output": np.array(list(structure.outputs), dtype=object),
    }


def _among_given_modes(structure: Structure, q: Array) -> dict[str, xr.Variable]:
    """Given modes in the basis, where degrees of freedom are their coordinates; else none."""
    K, M = structure.stiffness.tocoo(), structure.mass.tocoo()
    if structure.held.size or any(np.any(matrix.row != matrix.col) for matrix in (K, M)):
        return {}
    stiffness, mass = structure.stiffness.diagonal(), structure.mass.diagonal()
    # what no mass moves in is no mode
    w, root = np.sqrt(stiffness[mass > 0] / mass[mass > 0]), np.sqrt(mass[mass > 0])
    return free_mode_quantities(w / (2 * np.pi), root[:, None] * q[mass > 0])


def _participation(basis: Basis, sign: Array) -> dict[str, xr.Variable]:
    """Free modes in a contact-adapted basis, whose vectors come after rigid-body modes."""
    # rigid-body modes have no part in elastic ones
    rigid = sign.size - basis.frequency.size
    participation = np.pad(basis.free_participation, [(0, 0), (rigid, 0)]) * sign
    return free_mode_quantities(basis.free_frequency, participation)


def _variables(
    structure: Structure, q: Array, response: Array, excitation: Array
) -> dict[str, xr.Variable]:
    """The modes q at all places, as ``modes.nc`` holds them."""
    per_mass = "kg^-1/2"
    relative = structure.contact.relative @ q
    return {
        **_mode_shape(structure, q),
        "relative_mode": quantity(
            ("pair", "axis", "mode"),
            relative.reshape(-1, 3, q.shape[1]),
            per_mass,
            "mode of the contact pair along its tangents and normal, side A minus side B",
        ),
        "response_mode": quantity(
            "mode", response, per_mass, "mode where the response is observed"
        ),
        "excitation_mode": quantity("mode", excitation, per_mass, "mode where the force acts"),
        **_base_excitation(structure, q),
        **_at_rows("input", structure.inputs, q),
        **_at_rows("output", structure.outputs, q),
        **structure.contact.variables(),
        **modes_at_limits(structure, q),
    }


def _with_rigid_modes(structure: Structure, frequency: Array, q: Array) -> tuple[Array, Array]:
    """Frequencies and motion with rigid-body modes, at 0 Hz, before those of elastic ones."""
    motions = structure.rigid_body_motions.shape[1]
    if not motions:
        return frequency, q
    logger.info("%d rigid-body modes", motions)
    part = whole(structure, tightened=False)
    return np.append(np.zeros(motions), frequency), np.hstack([part.basis @ part.rigid, q])


class _Modes(NamedTuple):
    """Modes with the contact removed: frequency [Hz], motion (dofs, modes), their families."""

    frequency: Array
    q: Array
    families: Families


def _free(structure: Structure, number: int) -> tuple[_Modes, NDArray[np.int64]]:
    """Modes with the contact removed up to the N-th of the family, and which of them are of it.

    Of bending modes where the maker tells families apart, else of those that the input and the
    output take part in.
    """
    # in a slender bar most symmetric modes bend in the plane
    squared, q = _modes_until(
        symmetric(structure),
        number + 2,
        lambda _, found: bool(np.count_nonzero(that_respond(structure, found)) >= number),
    )
    if np.count_nonzero(that_respond(structure, q)) < number:
        raise ValueError(
            f"free-{number}: there are not as many bending modes, or modes that respond"
        )
    other_half = antisymmetric(structure) if number <= _MOST_BESIDE_OTHERS else None
    if other_half is not None:
        others = _modes_until(other_half, 2 * number, lambda found, _: found[-1] > squared[-1])
        below = others[0] <= squared[-1]
        squared = np.concatenate([squared, others[0][below]])
        q = np.concatenate([q, others[1][:, below]], axis=1)
        order = np.argsort(squared)
        squared, q = squared[order], q[:, order]
    modes = _Modes(np.sqrt(squared) / (2 * np.pi), q, families_of(structure, q))
    return modes, np.flatnonzero(that_respond(structure, q))[:number]


def _of_any_family(structure: Structure, number: int) -> tuple[_Modes, NDArray[np.int64]]:
    """The first modes with the contact removed, and which of them: all."""
    halves = [
        _modes_until(half, number, lambda found, _: found.size >= number)
        for half in (symmetric(structure), antisymmetric(structure))
        if half is not None
    ]
    squared = np.concatenate([found for found, _ in halves])
    if squared.size < number:
        raise ValueError(f"all-{number}: the mesh has not as many modes")
    order = np.argsort(squared)[:number]
    q = np.concatenate([found for _, found in halves], axis=1)[:, order]
    modes = _Modes(np.sqrt(squared[order]) / (2 * np.pi), q, families_of(structure, q))
    return modes, np.arange(number)


#: modes with the contact removed, by the family of bases
_WITHOUT_CONTACT = {"free": _free, "all": _of_any_family}


def _modes_until(
    part: Subspace, count: int, enough: Callable[[Array, Array], bool]
) -> tuple[Array, Array]:
    """Squared frequencies and motion (dofs, modes) of the first modes, at best of enough."""
    K = part.stiffness
    factors, most = part.factors(K), part.most_modes
    while True:
        count = min(count, most)
        squared, x = part.modes(factors, K, count)
        q = part.basis @ x
        if count == most or enough(squared, q):
            return squared, q
        count *= 2


def _candidates(modes: _Modes) -> dict[str, xr.Variable]:
    """All modes that were solved for, and the energies that distinguish their families."""
    families = modes.families
    variables = {
        "candidate_frequency": quantity(
            "candidate", modes.frequency, "Hz", "natural frequencies met in the search"
        ),
        "candidate_family": quantity("candidate", families.family, "1", "what the mode does"),
    }
    if families.energy_share is not None:
        variables["energy_share"] = quantity(
            ("candidate", "axis"), families.energy_share, "1", "kinetic energy along each axis"
        )
        variables["symmetric_share"] = quantity(
            "candidate",
            families.symmetric_share,
            "1",
            "kinetic energy on the middle plane that is symmetric about it",
        )
    return variables


def _parse(family: str) -> tuple[str, int]:
    """Kind and number of vectors of a family of bases, 0 where POD modes know it."""
    text = family if isinstance(family, str) else ""
    if text == "enriched-auto":
        return "enriched", 0
    match = re.fullmatch(r"([a-z]+)-([1-9][0-9]*)", text)
    if match is None or match[1] not in _FAMILIES:
        allowed = ", ".join(f"{name}-N" for name in _FAMILIES)
        raise ValueError(
            f"family {family!r} is not known; allowed: {allowed}, N being their number, "
            "enriched-auto"
        )
    return match[1], int(match[2])


def _default(rows: Mapping[str, Row], q: Array, largest: Array, problem: str, family: str) -> Array:
    """Modes at the first of the rows, (modes,)."""
    if not rows:
        return np.zeros(q.shape[1])
    name, first = next(iter(rows.items()))
    mode = first.row @ q
    if np.all(abs(mode) <= checks.ROUNDING_OF_MODES * largest):
        raise ValueError(f"{problem}: {name} moves in none of {family} along {first.direction}")
    return mode


def _mode_shape(structure: Structure, q: Array) -> dict[str, xr.Variable]:
    if structure.geometry is None:
        return {}
    shape = structure.geometry.shape(q)
    dims = ("node", "axis", "mode")
    return {"mode_shape": quantity(dims, shape, "kg^-1/2", "mass-normalised mode")}


def _at_rows(kind: str, rows: Mapping[str, Row], q: Array) -> dict[str, xr.Variable]:
    """Modes at the inputs or outputs."""
    at_rows = np.array([row.row @ q for row in rows.values()]).reshape(len(rows), q.shape[1])
    what = f"mode at the {kind}"
    return {f"{kind}_mode": quantity((kind, "mode"), at_rows, "kg^-1/2", what)}


def _base_excitation(structure: Structure, q: Array) -> dict[str, xr.Variable]:
    """Modal forces of a unit acceleration of the supports along each axis."""
    if structure.support is None:
        return {}
    what = "modal force of a unit acceleration of the supports along the axis"
    rows = structure.support @ q
    return {"base_excitation_mode": quantity(("axis", "mode"), rows, "kg^1/2", what)}


def _signs(response: Array, q: Array) -> Array:
    """+1 or -1 for each mode, to make the response positive, or the largest entry without one."""
    largest = q[np.argmax(abs(q), axis=0), np.arange(q.shape[1])]
    reference = np.where(abs(response) > 1e-6 * abs(largest), response, largest)
    return np.where(reference < 0, -1.0, 1.0)
