"""What the makers of structures make, by their names, and the families of modes they tell."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.described import Described
from boltjoint.config.makers import DEFAULT, maker
from boltjoint.structure.model import Structure
from boltjoint.structure.structure_file import contact_to_dataset

#: family of modes of which nothing else is told
ELASTIC = "elastic"


class Families(NamedTuple):
    """Families of modes and the kinetic energies that decided them.

    ``family`` (modes,); ``energy_share`` (modes, 3): along x, y, z over all of it;
    ``symmetric_share`` (modes,): of motion that is symmetric. The last two are None where the maker
    does not tell families apart.
    """

    family: NDArray[np.str_]
    energy_share: NDArray[np.float64] | None = None
    symmetric_share: NDArray[np.float64] | None = None


def make(description: Described, folder: Path) -> tuple[xr.Dataset, Structure]:
    """The assembly as ``assembly.nc`` holds it, and its structure.

    Parameters
    ----------
    description
        Description of the assembly.
    folder
        Folder of the study, in which the files of the description lie.

    Raises
    ------
    ValueError
        If it is no structure.
    """
    own, name = maker(description.type), description.type
    outcome = own.make(description, folder)
    if isinstance(outcome, Structure):
        structure = outcome if outcome.maker else replace(outcome, maker=name)
        return contact_to_dataset(structure), structure
    structure = own.structure_of(outcome)
    return outcome if name == DEFAULT else outcome.assign_attrs(maker=name), structure


def structure_of(assembly: xr.Dataset | Structure) -> Structure:
    """A structure, or that of an assembly that a maker has meshed.

    Raises
    ------
    ValueError
        If it is neither, or as for ``structure_of`` of the maker.
    """
    checks.instance("assembly", assembly, xr.Dataset, Structure)
    if isinstance(assembly, Structure):
        return assembly
    name = assembly.attrs.get("maker", DEFAULT)
    of_mesh = getattr(maker(name), "structure_of", None)
    if of_mesh is None:
        raise ValueError(f"assembly of type {name} has no mesh: give its structure")
    return of_mesh(assembly)


def loaded_nodes(assembly: xr.Dataset) -> np.ndarray:
    """Numbers of the nodes where forces may act: all where the maker says nothing."""
    own = getattr(maker(assembly.attrs.get("maker", DEFAULT)), "loaded_nodes", None)
    return own(assembly) if own else np.arange(assembly.sizes["node"])


def load_on_surface(assembly: xr.Dataset, surface: str) -> np.ndarray:
    """Nodal forces of an even load of one newton on a surface, shape (nodes,).

    Raises
    ------
    ValueError
        If the maker of the assembly knows no such surface.
    """
    name = assembly.attrs.get("maker", DEFAULT)
    own = getattr(maker(name), "load_on_surface", None)
    if own is None:
        raise ValueError(f"assembly of type {name} has no surface called {surface}")
    return own(assembly, surface)


def families_of(structure: Structure, q: np.ndarray) -> Families:
    """Families of elastic modes q, shape (dofs, modes)."""
    own = getattr(maker(structure.maker), "families_of", None) if structure.maker else None
    return own(structure, q) if own else Families(np.full(q.shape[1], ELASTIC))


def that_respond(structure: Structure, q: np.ndarray) -> np.ndarray:
    """Which of some elastic modes q (dofs, modes) resonances of a case are, shape (modes,).

    Bending modes where the maker tells families apart, else those in which an input and an output
    move, where there are any.
    """
    family = families_of(structure, q).family
    if not np.any(family == ELASTIC):
        return family == "bending"
    rows = (structure.inputs, structure.outputs)
    return move_in(abs(q).max(axis=0), *([point.row @ q for point in of.values()] for of in rows))


def move_in(largest: np.ndarray, *places: Sequence[np.ndarray]) -> np.ndarray:
    """Modes in which one of each group of places moves at least, shape (modes,).

    Parameters
    ----------
    largest
        Motion of each mode where it is largest, shape (modes,).
    places
        Places of each group, the modes at its places, shape (places, modes); without places all do.
    """
    moving = np.ones(largest.shape, dtype=bool)
    for group in places:
        if len(group):
            moving &= abs(np.asarray(group)).max(axis=0) > checks.ROUNDING_OF_MODES * largest
    return moving
