"""A look at matrices or modes before anything is solved: what moves, what meets, what holds."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.matrices import Matrices
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.makers.matrices.structure import structure_of_matrices
from boltjoint.structure.model import Bolt, Row, Structure
from boltjoint.structure.model_facts import (
    MM,
    contact_in_words,
    direction_in_words,
    doubts_of_size,
)
from boltjoint.structure.subspaces import whole

Array = NDArray[np.float64]

_NO_BOLTS = "none, since normal loads are given"
#: natural frequencies that are told
_FREQUENCIES = 4
#: first natural frequencies of assemblies [Hz], extents of their contact [m]
_LOWEST, _EXTENTS = (1.0, 1e5), (1e-4, 10.0)
#: area of the contact points over the square of their extent
_COVERED = 1e-5, 1e2


def check_of(described: Matrices, folder: str | Path) -> tuple[dict[str, str], list[str]]:
    """What files describe, by words, and what to look at, in a line each.

    Parameters
    ----------
    described, folder
        As for ``structure_of_matrices``.

    Raises
    ------
    ValueError
        As for ``structure_of_matrices``.
    """
    structure = structure_of_matrices(described, folder)
    contact, rigid = structure.contact, structure.rigid_body_motions.shape[1]
    frequency = _natural_frequencies(described, structure)
    facts = {
        "degrees of freedom": str(structure.dofs),
        "rigid-body motions without contact": str(rigid),
        "natural frequencies without contact (Hz)": ", ".join(f"{f:.6g}" for f in frequency),
        "contact": "; ".join(
            contact_in_words(name, contact.area[on], contact.gap[on])
            for name, on in ((name, contact.surface == name) for name in described.surface_names)
            if on.any()
        ),
    }
    if (load := contact.normal_load) is not None:
        facts["normal loads"] = f"{load.sum():.6g} N on {np.count_nonzero(load)} points"
    facts["bolts"] = "; ".join(map(_bolt_in_words, structure.bolts)) or _NO_BOLTS
    facts["inputs"], facts["outputs"] = map(_rows_in_words, (structure.inputs, structure.outputs))
    return facts, list(_doubts(described, contact, frequency))


def _natural_frequencies(described: Matrices, structure: Structure) -> Array:
    """The first elastic ones [Hz]."""
    part = whole(structure, tightened=False)
    K = part.stiffness
    try:
        squared, _ = part.modes(part.factors(K), K, min(_FREQUENCIES, part.most_modes))
    except RuntimeError as error:
        raise ValueError(f"{', '.join(described.named_files)}: {error}") from error
    return np.sqrt(squared) / (2 * np.pi)


def _bolt_in_words(bolt: Bolt) -> str:
    """Name, how its load acts, and what is known of its shank."""
    words = [bolt.name, "a dead load" if bolt.locked is None else "held once tight"]
    if bolt.axis is not None:
        words.append(f"axis {direction_in_words(bolt.axis)}")
    if bolt.section is not None:
        words.append(f"shank of {1e6 * bolt.section:.4g} mm²")
    return ", ".join(words)


def _rows_in_words(rows: Mapping[str, Row]) -> str:
    """Names and directions."""
    named = (f"{name} ({row.direction})" if row.direction else name for name, row in rows.items())
    return ", ".join(named) or "none"


def _doubts(described: Matrices, contact: ContactPoints, frequency: Array) -> Iterator[str]:
    """Numbers that no joint has, as they may be in other units."""
    yield from doubts_of_size(
        "extent of the contact points", contact.position, _EXTENTS, "length_unit"
    )
    extent, area = np.ptp(contact.position, axis=0).max(), contact.area.sum()
    if extent and not _COVERED[0] <= area / extent**2 <= _COVERED[1]:
        yield (
            f"an area of {1e4 * area:.4g} cm² of contact points within {MM * extent:.4g} mm is "
            "unusual: is contact.area in the square of length_unit?"
        )
    if not _LOWEST[0] <= frequency[0] <= _LOWEST[1]:
        question = "do stiffness and mass go together, as N/m with kg or N/mm with t?"
        if described.modes is not None:
            question = f"is {described.modes.natural_frequency} in Hz?"
        yield f"a first natural frequency of {frequency[0]:.4g} Hz is unusual: {question}"


MEANING = (
    "Stiffness and mass matrices, or modes, of another program, with the contact points and bolts "
    "they have."
)


def facts_of(described: Matrices) -> dict[str, float | str | tuple[float, ...]]:
    """Files, bolts, inputs and outputs, by what they are called."""
    names = {"inputs": described.input_names, "outputs": described.output_names}
    files = ", ".join(described.named_files)
    return {
        f"{'modes' if described.has_modes_only else 'matrices'} from": files,
        "bolts": described.bolt_count or _NO_BOLTS,
        **{kind: ", ".join(values) or "none" for kind, values in names.items()},
    }
