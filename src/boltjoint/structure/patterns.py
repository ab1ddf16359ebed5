"""Verification of a modal basis against the full model while parts of the contact stick.

The full finite-element model gets a linear spring on each pair that sticks and none on the others.
Its resonances are the reference for the same springs in any modal basis.
"""

import logging
from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from threadpoolctl import threadpool_limits

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.joint.surface_places import SurfacePlaces
from boltjoint.structure.bolt_tension import distance_to_bolts
from boltjoint.structure.makers.registry import move_in, structure_of, that_respond
from boltjoint.structure.model import Structure
from boltjoint.structure.subspaces import Subspace, part_that_moves

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: modes among which each one that responds is sought, at most
_MOST_SOUGHT = 16
#: names of the springs' directions: along the first tangent of a point, under constant load, and
#: along its normal too
SPRINGS = ("x", "xz")


def stuck_patterns(
    assembly: xr.Dataset | Structure,
    preload: xr.Dataset,
    radii: tuple[float, ...] | None = None,
) -> dict[str, NDArray[np.bool_]]:
    """Parts of the loaded pairs that may stick while the others slip.

    Parameters
    ----------
    assembly, preload
        An assembly of a maker or a structure, and its preload as from ``apply_preload``.
    radii
        Distances from the nearest bolt axis [m] within which pairs stick, the largest first; by
        default those of ``bolt_radii``.

    Returns
    -------
    dict
        By name, the pairs that stick, shape (pairs,): all loaded ones, those near the bolts, those
        beyond the largest radius, those in the left half of their surface, along the first tangent,
        and those under more than half of the largest pressure. Where no radius or no axis of a bolt
        is known, there are none near the bolts or beyond.

    Raises
    ------
    ValueError
        If the two do not hold the same pairs, or there is no radius, or one that is not positive.
    """
    sizes = bolt_radii(assembly) if radii is None else checks.numbers("radii", radii)
    structure = structure_of(assembly)
    contact = structure.contact
    places = SurfacePlaces.in_planes(contact.position, contact.frame, contact.surface)
    x = places.from_middle
    load = checks.variable("preload", preload, "normal_load", ("pair",), at_least=0)
    checks.array("normal_load of preload", load, x.shape)
    pressure = load / contact.area
    parts = {"all": np.ones(len(x), dtype=bool)}
    distance = distance_to_bolts(structure.bolts, contact.position)
    if sizes and distance is not None:
        # of wide heads the radius is the larger one
        ordered = sorted(sizes, reverse=True)
        parts |= {f"within {1e3 * radius:g} mm": distance < radius for radius in ordered}
        parts[f"beyond {1e3 * ordered[0]:g} mm"] = distance > ordered[0]
    parts["left half"] = x < 0
    parts["above half of the pressure"] = pressure > pressure.max() / 2
    return {name: part & (load > 0) for name, part in parts.items()}


def bolt_radii(assembly: xr.Dataset | Structure) -> tuple[float, ...]:
    """Diameter of the holes and radius of the heads [m]; none where an assembly tells none."""
    if not isinstance(assembly, xr.Dataset) or "hole_diameter" not in assembly:
        return ()
    hole, head = (
        checks.variable("assembly", assembly, name, ()).item()
        for name in ("hole_diameter", "head_diameter")
    )
    return hole, head / 2


# one thread: sums in another order would change the last digits from machine to machine
@threadpool_limits.wrap(limits=1, user_api="blas")
def resonances(
    assembly: xr.Dataset | Structure,
    preload: xr.Dataset,
    stiffness: float = 0.0,
    patterns: dict[str, NDArray[np.bool_]] | None = None,
    number: int = 2,
    stiffness_per_area: float = 0.0,
) -> xr.Dataset:
    """First resonances of the full model for each pattern of sticking pairs.

    They are those of modes that respond (``registry.that_respond``), of a half lap bending ones.

    Parameters
    ----------
    assembly, preload
        An assembly of a maker or its structure, and its preload as from ``apply_preload``.
    stiffness
        Stiffness of the spring on each sticking pair, along its first tangent, or along that and
        its normal [N/m].
    patterns
        By name, the pairs that stick, the same on both sides of a plane of symmetry; by default
        ``stuck_patterns`` of the assembly.
    number
        Resonances.
    stiffness_per_area
        Stiffness of the spring, times the area of the pair [N/m3], where that is stiffer.

    Returns
    -------
    Dataset
        ``frequency`` (pattern, springs, resonance) [Hz]; ``stuck`` (pattern, pair), 1 where the
        pair sticks; ``stiffness`` [N/m] of a pair, or with a stiffness per area of each (pair);
        ``position`` (pair, axis) [m]; ``pattern`` and ``springs`` are their names.

    Raises
    ------
    ValueError
        If a pattern has too few modes that respond among the first ones, or if a stiffness is
        negative or the number of resonances not positive.
    """
    stiffness = checks.number("stiffness", stiffness, at_least=0)
    per_area = checks.number("stiffness_per_area", stiffness_per_area, at_least=0)
    number = checks.whole("number", number, at_least=1)
    structure = structure_of(assembly)
    if patterns is None:
        patterns = stuck_patterns(structure, preload, bolt_radii(assembly) or None)
    contact, pairs = structure.contact, (len(structure.contact),)
    patterns = {
        name: checks.flags(f"{name!r} of patterns", stuck, pairs)
        for name, stuck in patterns.items()
    }
    springs_of_pairs = quantity((), stiffness, "N/m", "stiffness of a sticking pair")
    if per_area > 0:
        of_each = np.maximum(stiffness, per_area * contact.area)
        springs_of_pairs = quantity("pair", of_each, "N/m", "stiffness of each sticking pair")
    half = part_that_moves(structure, *patterns.values())
    C = half.relative
    frequency = np.empty((len(patterns), len(SPRINGS), number))
    for i, (name, stuck) in enumerate(patterns.items()):
        for j, springs in enumerate(SPRINGS):
            acting = np.outer(springs_of_pairs.to_numpy() * stuck, [1.0, 0.0, springs == "xz"])
            springs_of_part = C.T @ sparse.diags_array(acting.ravel()) @ C
            frequency[i, j] = _resonances((half.stiffness + springs_of_part).tocsc(), half, number)
            frequencies = ", ".join(f"{f:.6g}" for f in frequency[i, j])
            logger.info("%s stuck, springs along %s: %s Hz", name, springs, frequencies)
    springs_and_places = {
        "stiffness": springs_of_pairs,
        "position": contact.variables()["position"],
    }
    return _resonances_to_dataset(frequency, patterns, springs_and_places)


def _resonances_to_dataset(
    frequency: Array,
    patterns: Mapping[str, NDArray[np.bool_]],
    of_pairs: Mapping[str, xr.Variable],
) -> xr.Dataset:
    """Resonances [Hz], shape (patterns, springs, resonances), with the pairs that stick.

    ``of_pairs`` are further variables of the pairs.
    """
    return xr.Dataset(
        {
            "frequency": quantity(
                ("pattern", "springs", "resonance"),
                frequency,
                "Hz",
                "resonance of the full model",
            ),
            "stuck": quantity(
                ("pattern", "pair"),
                np.array(list(patterns.values()), dtype=np.int8),
                "1",
                "1 where the pair sticks",
            ),
            **of_pairs,
        },
        coords={
            "pattern": list(patterns),
            "springs": list(SPRINGS),
            "axis": ["x", "y", "z"],
        },
    )


def resonances_in(modes: xr.Dataset, patterns: xr.Dataset) -> xr.Dataset:
    """The resonances of the same patterns in a modal basis, and their errors.

    The n-th frequency of the basis, of motion in which excitation and output point take part, is
    compared with the n-th one of the full model. This holds as long as no axial mode of a half lap,
    which a basis may or may not have, comes between: those of a slender bar lie far above its first
    two bending modes.

    Parameters
    ----------
    modes
        As from ``find_modes``.
    patterns
        As from ``resonances``, for the same pairs.

    Returns
    -------
    Dataset
        ``frequency`` (pattern, springs, resonance) [Hz], and ``error`` of the same shape: over the
        frequency of the full model, less 1. Not less than zero but for rounding, since a
        basis can only be too stiff.

    Raises
    ------
    ValueError
        If the pairs differ, or the basis has fewer vectors than there are resonances.
    """
    position, other = (
        checks.variable(name, stored, "position", ("pair", "axis"))
        for name, stored in (("modes", modes), ("patterns", patterns))
    )
    if not np.array_equal(position, other):
        raise ValueError("modes and patterns were found on different contact pairs")
    dims = ("pattern", "springs", "resonance")
    reference = checks.variable("patterns", patterns, "frequency", dims)
    natural = checks.variable("modes", modes, "natural_frequency", ("mode",))
    checks.variable("modes", modes, "relative_mode", ("axis", "pair", "mode"))
    of_springs = tuple(map(str, patterns["stiffness"].dims)) if "stiffness" in patterns else ()
    stiffness = checks.variable("patterns", patterns, "stiffness", of_springs)
    stuck_pairs = checks.indices(
        "stuck of patterns", patterns["stuck"].transpose("pattern", "pair").to_numpy()
    )
    # rigid-body modes, in which the contact rests, are no resonances
    modes = modes.isel(mode=np.flatnonzero(natural > 0))
    natural = natural[natural > 0]
    if modes.sizes["mode"] < reference.shape[-1]:
        raise ValueError(
            f"{modes.sizes['mode']} modes cannot show {reference.shape[-1]} resonances"
        )
    free = np.diag((2 * np.pi * natural) ** 2)
    relative = modes["relative_mode"].transpose("axis", "pair", "mode")
    frequency = np.empty_like(reference)
    stiffness = np.broadcast_to(stiffness, len(position))
    # as shares of the largest: springs that are alike leave the rows as they are, to the bit
    largest = max(stiffness.max(), np.finfo(float).tiny)
    root = np.sqrt(stiffness / largest)[:, None]
    for i, stuck in enumerate(stuck_pairs > 0):
        for j, springs in enumerate(patterns["springs"].to_numpy()):
            rows = [(root * relative.sel(axis=axis).to_numpy())[stuck] for axis in springs]
            matrix = free + largest * sum(B.T @ B for B in rows)
            frequency[i, j] = _resonances_in(matrix, modes, reference.shape[-1])
    dims = ("pattern", "springs", "resonance")
    return xr.Dataset(
        {
            "frequency": quantity(dims, frequency, "Hz", "resonance in the basis"),
            "error": quantity(dims, frequency / reference - 1, "1", "relative to the full model"),
        },
        coords={"pattern": patterns["pattern"], "springs": patterns["springs"]},
    )


def _resonances(stiffness: sparse.csc_array, part: Subspace, number: int) -> Array:
    """Frequencies of the first modes that respond [Hz]."""
    factors, count = part.factors(stiffness), 2 * number
    most = min(_MOST_SOUGHT * number, stiffness.shape[0] - 2)
    while True:
        squared, x = part.modes(factors, stiffness, min(count, most))
        responds = that_respond(part.structure, part.basis @ x)
        if np.count_nonzero(responds) >= number:
            return np.sqrt(squared[responds][:number]) / (2 * np.pi)
        if count >= most:
            raise ValueError(f"fewer than {number} of the first {most} modes respond")
        count *= 2


def _resonances_in(matrix: Array, modes: xr.Dataset, number: int) -> Array:
    """Frequencies of the first motions of a basis that respond [Hz]."""
    squared, x = np.linalg.eigh(matrix)
    kinds = (kind for kind in ("input", "output") if f"{kind}_mode" in modes)
    places = [modes[f"{kind}_mode"].transpose(kind, "mode").to_numpy() @ x for kind in kinds]
    # of masses of one the largest motion of all vectors together
    largest = np.full(len(squared), max((abs(at).max() for at in places if at.size), default=0.0))
    responds = move_in(largest, *places)
    if np.count_nonzero(responds) < number:
        raise ValueError(f"{len(squared)} modes cannot show {number} resonances")
    return np.sqrt(squared[responds][:number]) / (2 * np.pi)
