"""Modal bases of an assembly: modes without contact, or a contact-adapted basis.

The contact between the bars is removed; the bolts, their pretension sections closed, hold the bars
together. Families of modes are distinguished by kinetic energy. A contact-adapted basis
(``structure.basis``) also holds what modes without contact cannot, and is used like modes.
"""

import logging
import re
from collections.abc import Callable

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.joint.io import free_mode_quantities
from boltjoint.structure.basis.pod import basis_of_pod_modes, estimated_errors
from boltjoint.structure.constraints import (
    ConstrainedStructure,
    assemble_assembly,
    factorise,
    relative_displacements,
)
from boltjoint.structure.mode_families import Modes, classify_modes
from boltjoint.structure.symmetry import antisymmetric_half, symmetric_half

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: points of an assembly that must move, and the problem where they do not
_POINTS = {
    "response": "the output point does not move in the selected modes",
    "excitation": "this force does not excite the selected modes",
}

#: bending modes up to which lateral and torsional ones, which are not symmetric, are found as well
_MOST_BESIDE_OTHERS = 12

#: families of bases
_FAMILIES = ("free", "all", "enriched")


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def find_modes(
    assembly: xr.Dataset, family: str, pod_modes: xr.Dataset | None = None
) -> xr.Dataset:
    """Modal basis of an assembly, as ``modes.nc`` holds it.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    family
        ``free-N``: the first N bending modes with the contact removed. ``all-N``: the first N of
        any family, bending, lateral, torsional or axial. ``enriched-N``: the contact-adapted basis
        of N vectors, orthonormal in mass and diagonal in stiffness. ``enriched-auto``: as many
        vectors as reach the tolerances of the POD modes.
    pod_modes
        As from ``find_pod_modes``, for the same assembly; ``enriched-N`` takes the first N of them,
        ``free-N`` and ``all-N`` need none.

    Returns
    -------
    Dataset
        ``natural_frequency`` (mode) [Hz]; mass-normalised [kg^-1/2]: ``mode_shape`` (node, axis,
        mode), ``relative_mode`` (pair, axis, mode) of side A minus side B, ``response_mode``
        (mode), positive where it does not vanish, ``excitation_mode`` (mode), both where a
        case gives no point; ``base_excitation_mode`` (axis, mode) [kg^1/2]; ``position`` (pair,
        axis) [m]; ``area`` (pair) [m2]. With ``free-N`` and ``all-N``, of every mode that was
        solved for, for large N of ``free-N`` symmetric ones only: ``candidate_frequency``
        (candidate) [Hz], ``candidate_family`` (candidate), and the shares of kinetic energy that
        decided it, ``energy_share`` (candidate, axis) and ``symmetric_share`` (candidate). With
        ``enriched-N``, of bending modes without contact, ``free_frequency`` (free_mode) [Hz] and
        ``free_participation`` (free_mode, mode), phi^T M of them times the vectors [-]. With
        ``enriched-auto``, and where they are known with ``enriched-N``, the attributes
        ``estimated_frequency_error`` and ``estimated_amplitude_error``: largest relative errors of
        peaks that are due to the basis.

    Raises
    ------
    ValueError
        If there is no such family, the mesh has not as many modes or is not symmetric about y = 0;
        if ``enriched-N`` gets no POD modes, too few, or those of another mesh; or if the force
        excites none of the modes, or the output point moves in none, as in the clamp, or across the
        width.
    RuntimeError
        If a natural frequency is no number or zero within rounding: the assembly is not held.
    """
    checks.instance("assembly", assembly, xr.Dataset)
    kind, number = _parse(family)
    attributes: dict[str, str | float] = {"modes": family}
    if kind in _WITHOUT_CONTACT:
        modes, chosen = _WITHOUT_CONTACT[kind](assembly, number)
        frequency, shape = modes.frequency[chosen], modes.shape[..., chosen]
    else:
        if pod_modes is None:
            raise ValueError(f"{family} needs POD modes of the assembly, from find_pod_modes")
        number = pod_modes.attrs["automatic_vectors"] if number is None else number
        attributes |= {"vectors": number, **estimated_errors(pod_modes, number)}
        basis = basis_of_pod_modes(assembly, pod_modes, number)
        frequency, shape = basis.frequency, basis.shape
    response, excitation = (_at_point(assembly, point, shape) for point in _POINTS)
    largest = abs(shape).max(axis=(0, 1))
    for (point, problem), found in zip(_POINTS.items(), (response, excitation), strict=True):
        if np.all(abs(found) <= checks.ROUNDING_OF_MODES * largest):
            raise ValueError(
                f"{problem}: {point}_node of the assembly moves in none of {family} along "
                f"{assembly[f'{point}_node'].attrs['direction']}"
            )
    sign = _signs(response, shape)
    shape = shape * sign
    if kind in _WITHOUT_CONTACT:
        of_family = _candidates(modes)
    else:
        of_family = free_mode_quantities(basis.free_frequency, basis.free_participation * sign)
    relative = relative_displacements(assembly) @ shape.reshape(-1, number)
    logger.info("modes %s: %s Hz", family, ", ".join(f"{f:.6g}" for f in frequency))
    per_mass = "kg^-1/2"
    return xr.Dataset(
        {
            "natural_frequency": quantity("mode", frequency, "Hz", "natural frequency"),
            "mode_shape": quantity(
                ("node", "axis", "mode"), shape, per_mass, "mass-normalised mode"
            ),
            "relative_mode": quantity(
                ("pair", "axis", "mode"),
                relative.reshape(-1, 3, number),
                per_mass,
                "mode of the contact pair, side A minus side B",
            ),
            "response_mode": quantity(
                "mode", response * sign, per_mass, "mode where the response is observed"
            ),
            "excitation_mode": quantity(
                "mode", excitation * sign, per_mass, "mode where the force acts"
            ),
            "base_excitation_mode": quantity(
                ("axis", "mode"),
                _base_excitation(assembly, shape),
                "kg^1/2",
                "modal force of a unit acceleration of the clamp along the axis",
            ),
            "position": assembly["position"].variable,
            "area": assembly["area"].variable,
            **of_family,
        },
        coords={"axis": assembly["axis"].variable},
        attrs=attributes,
    )


def _free_bending(assembly: xr.Dataset, number: int) -> tuple[Modes, NDArray[np.int64]]:
    """Modes with the contact removed up to the N-th bending one, and which of them bend."""
    _, M = assemble_assembly(assembly)

    def is_bending(squared: Array, shape: Array) -> NDArray[np.bool_]:
        return classify_modes(assembly, M, np.sqrt(squared), shape).family == "bending"

    # in a slender bar most symmetric modes bend in the plane
    squared, shape = _modes_until(
        symmetric_half(assembly),
        number + 2,
        lambda *found: np.count_nonzero(is_bending(*found)) >= number,
    )
    if np.count_nonzero(is_bending(squared, shape)) < number:
        raise ValueError(f"free-{number}: the mesh has not as many bending modes")
    if number <= _MOST_BESIDE_OTHERS:
        others = _modes_until(
            antisymmetric_half(assembly), 2 * number, lambda found, _: found[-1] > squared[-1]
        )
        below = others[0] <= squared[-1]
        squared = np.concatenate([squared, others[0][below]])
        shape = np.concatenate([shape, others[1][..., below]], axis=-1)
        order = np.argsort(squared)
        squared, shape = squared[order], shape[..., order]
    modes = classify_modes(assembly, M, np.sqrt(squared) / (2 * np.pi), shape)
    return modes, np.flatnonzero(modes.family == "bending")[:number]


def _free_of_any_family(assembly: xr.Dataset, number: int) -> tuple[Modes, NDArray[np.int64]]:
    """The first modes with the contact removed, and which of them: all."""
    _, M = assemble_assembly(assembly)
    halves = [
        _modes_until(half(assembly), number, lambda found, _: found.size >= number)
        for half in (symmetric_half, antisymmetric_half)
    ]
    squared = np.concatenate([found for found, _ in halves])
    if squared.size < number:
        raise ValueError(f"all-{number}: the mesh has not as many modes")
    order = np.argsort(squared)[:number]
    shape = np.concatenate([found for _, found in halves], axis=-1)[..., order]
    modes = classify_modes(assembly, M, np.sqrt(squared[order]) / (2 * np.pi), shape)
    return modes, np.arange(number)


#: modes with the contact removed, by the family of bases
_WITHOUT_CONTACT = {"free": _free_bending, "all": _free_of_any_family}


def _modes_until(
    structure: ConstrainedStructure, count: int, enough: Callable[[Array, Array], bool]
) -> tuple[Array, Array]:
    """Squared frequencies and shapes (nodes, 3, modes) of the first modes, at best of enough."""
    K = structure.stiffness
    factors, most = factorise(K), K.shape[0] - 2
    while True:
        count = min(count, most)
        squared, q = structure.modes(factors, K, count)
        shape = (structure.displacement @ q).reshape(-1, 3, count)
        if count == most or enough(squared, shape):
            return squared, shape
        count *= 2


def _candidates(modes: Modes) -> dict[str, xr.Variable]:
    """All modes that were solved for, and the energies that distinguish their families."""
    return {
        "candidate_frequency": quantity(
            "candidate", modes.frequency, "Hz", "natural frequencies met in the search"
        ),
        "candidate_family": quantity("candidate", modes.family, "1", "what the mode does"),
        "energy_share": quantity(
            ("candidate", "axis"), modes.energy_share, "1", "kinetic energy along each axis"
        ),
        "symmetric_share": quantity(
            "candidate",
            modes.symmetric_share,
            "1",
            "kinetic energy on the middle plane that is symmetric about it",
        ),
    }


def _parse(family: str) -> tuple[str, int | None]:
    """Kind and number of vectors of a family of bases, None where POD modes know it."""
    text = family if isinstance(family, str) else ""
    if text == "enriched-auto":
        return "enriched", None
    match = re.fullmatch(r"([a-z]+)-([1-9][0-9]*)", text)
    if match is None or match[1] not in _FAMILIES:
        allowed = ", ".join(f"{name}-N" for name in _FAMILIES)
        raise ValueError(
            f"family {family!r} is not known; allowed: {allowed}, N being their number, "
            "enriched-auto"
        )
    return match[1], int(match[2])


def _at_point(assembly: xr.Dataset, point: str, shape: Array) -> Array:
    node = assembly[f"{point}_node"]
    axis = assembly["axis"].to_numpy().tolist().index(node.attrs["direction"])
    return shape[node.item(), axis]


def _base_excitation(assembly: xr.Dataset, shape: Array) -> Array:
    """``-Phi^T M r`` for a unit acceleration r of the clamp along each axis, (axes, modes).

    In the frame of the clamp its acceleration a is the inertia force ``-M r a`` on all nodes.
    """
    _, M = assemble_assembly(assembly)
    r = np.tile(np.eye(3), (shape.shape[0], 1))
    return -(M @ r).T @ shape.reshape(-1, shape.shape[-1])


def _signs(response: Array, shape: Array) -> Array:
    """+1 or -1 for each mode, to make the response positive, or the largest entry without one."""
    flat = shape.reshape(-1, shape.shape[-1])
    largest = flat[np.argmax(abs(flat), axis=0), np.arange(flat.shape[1])]
    reference = np.where(abs(response) > 1e-6 * abs(largest), response, largest)
    return np.where(reference < 0, -1.0, 1.0)
