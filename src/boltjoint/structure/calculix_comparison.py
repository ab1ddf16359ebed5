"""What this library and CalculiX find of the same structure, row by row of a table."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import dataset
from boltjoint.config.described import Described
from boltjoint.config.makers import description_of, maker
from boltjoint.structure.model import Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.structure.structure_file import load_structure

Array = NDArray[np.float64]

#: agreement of two fields: its value, what measures it, and its lower bound if there is one
Agreement = tuple[float | None, str, float | None]

#: modes under preload that are compared
PRESTRESSED_MODES = 6
#: frequency over the highest, below which a mode is one of a rigid body but for rounding
_RIGID = 1e-4


class Verified(NamedTuple):
    """An assembly that CalculiX solves too.

    ``folder`` of the study; ``assembly`` as in ``assembly.nc``, and its structure.
    """

    described: Described
    folder: Path
    assembly: xr.Dataset
    structure: Structure

    @classmethod
    def of_files(
        cls, content: Mapping[str, Any], folder: Path, assembly: str | Path, structure: str | Path
    ) -> Self:
        """The assembly of the content of its YAML file, ``assembly.nc`` and ``structure.nc``."""
        described = description_of(content).in_folder(folder)
        return cls(described, folder, dataset.load(assembly), load_structure(structure))

    @property
    def calculix(self) -> ModuleType:
        """Module of its maker that writes decks and compares what CalculiX finds.

        Raises
        ------
        ValueError
            If the maker has none.
        """
        kind = self.described.type
        name = getattr(maker(kind), "CALCULIX", None)
        if name is None:
            raise ValueError(f"no decks for CalculiX are written of an assembly of type {kind}")
        return import_module(name)


def row(
    name: str,
    unit: str,
    ours: float,
    theirs: float,
    maximum_difference: float | None = None,
    agreement: Agreement = (None, "", None),
) -> dict[str, object]:
    """A quantity from both programs: difference, agreement of fields, bounds and if they hold.

    What CalculiX did not find is not a number, and no bound is tested then.
    """
    ours, theirs = float(ours), float(theirs)
    likeness, measure, minimum = agreement
    difference = theirs / ours - 1
    bounds, holds = [], True
    if maximum_difference is not None:
        bounds.append(f"difference within {100 * maximum_difference:g} %")
        holds &= abs(difference) <= maximum_difference
    if minimum is not None and likeness is not None:
        bounds.append(f"likeness above {minimum:g}")
        holds &= float(likeness) > minimum
    return {
        "quantity": name,
        "unit": unit,
        "boltjoint": ours,
        "calculix": theirs,
        "difference_percent": 100 * difference,
        "likeness": None if likeness is None else float(likeness),
        "measured_by": measure if np.isfinite(theirs) else "CalculiX found none, see its log",
        "bound": ", ".join(bounds),
        "holds": bool(holds) if bounds else None,
    }


def elastic(frequency: Array) -> Array:
    """Frequencies [Hz] without those of rigid-body modes, in ascending order."""
    frequency = np.sort(frequency[np.isfinite(frequency)])
    return frequency[frequency > _RIGID * frequency.max(initial=0.0)]


def compare_frequencies(
    name: str, ours: Array, theirs: Array, bound: float | None = None
) -> Iterator[dict[str, object]]:
    """A row for each mode of ours, with the mode of the same number of CalculiX."""
    complete = np.concatenate([theirs, np.full(max(0, ours.size - theirs.size), np.nan)])
    for number, (own, other) in enumerate(zip(ours, complete, strict=False), 1):
        yield row(f"{name} {number}", "Hz", own, other, bound)


def prestressed_frequencies(structure: Structure, preload: float | tuple[float, ...]) -> Array:
    """Elastic natural frequencies [Hz] with the normal springs of points closed under preload.

    Contact is frictionless, in the preload too: neither program holds it along the surfaces.

    Parameters
    ----------
    structure
        With or without springs of a base.
    preload
        As for ``apply_preload``.
    """
    contact = structure.contact
    smooth = replace(
        structure,
        contact=replace(contact, friction_coefficient=np.zeros(len(contact))),
        base_springs=None,
    )
    closed = apply_preload(smooth, preload)["normal_load"].to_numpy() > 0
    springs = np.where(closed, contact.penalty * contact.area, 0.0)
    modes = find_modes(replace(smooth, base_springs=springs), f"all-{PRESTRESSED_MODES}")
    return elastic(modes["natural_frequency"].to_numpy())
