"""Sizes of what files describe, and the degrees of freedom in which they describe it."""

from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.matrices import Matrices
from boltjoint.structure.makers.matrices.modal_data import ModalData, dofs_of_nodes, sizes_of_modes
from boltjoint.structure.makers.matrices.reader import Reader

#: bytes of the factors over dofs^(4/3), the fill of a body in space, as measured for half laps
_FACTORS = 350


class Sizes(NamedTuple):
    """Numbers of degrees of freedom, contact points and bolts."""

    dofs: int
    points: int
    bolts: int


@dataclass(frozen=True, eq=False)
class Source:
    """Files, and the degrees of freedom in which contact, bolts and rows are described.

    ``dofs`` is their number, ``holder`` the variable that has them, and ``modes`` what moves them.
    """

    described: Matrices
    reader: Reader
    dofs: int
    holder: str
    modes: ModalData | None = None

    def rows(self, of_dofs: Any) -> Any:  # noqa: ANN401
        """Rows, or a row, by the degrees of freedom of the structure."""
        return of_dofs if self.modes is None else self.modes.rows(of_dofs)

    def dof(self, what: str, number: int | None) -> int:
        """A degree of freedom from 0, of its number."""
        first = self.described.first_number
        if number is None or not first <= number < first + self.dofs:
            raise ValueError(
                f"{self.reader.place(self.holder)} has degrees of freedom from {first} to "
                f"{first + self.dofs - 1}: {what} is {number}"
            )
        return number - first

    def dofs_of_nodes(self, what: str, numbers: NDArray[np.int64]) -> NDArray[np.int64]:
        """Degrees of freedom of nodes along x, y, z, (nodes, 3)."""
        return dofs_of_nodes(numbers, self.of_modes, what, self.reader.place(self.of_nodes))

    @property
    def of_modes(self) -> ModalData:
        """The modes, which there are."""
        if self.modes is None:
            raise ValueError("there are no modes")
        return self.modes

    @property
    def of_nodes(self) -> str:
        """Variable of the numbers of nodes; empty without any."""
        modes = self.described.modes
        return "" if modes is None else modes.variable("node") or ""


def sizes_of_matrices(described: Matrices, folder: str | Path) -> Sizes:
    """Sizes of a structure, of which only the heads of the files are read.

    Parameters
    ----------
    described, folder
        As for ``structure_of_matrices``.

    Raises
    ------
    ValueError
        If a variable is not there, K is not square, M or modes have another size, or a degree of
        freedom is not there.
    """
    return read_sizes(described, Reader(described, folder))[0]


def read_sizes(described: Matrices, reader: Reader) -> tuple[Sizes, Source]:
    """Sizes, and the source without its modes, which are not read yet."""
    if described.modes is None:
        holder = described.stiffness
        count = dofs = _dofs_of_matrices(described, reader)
    else:
        holder = described.modes.variable("mode_shape") or described.modes.natural_frequency
        count, dofs = sizes_of_modes(described.modes, reader)
    for variable in dict.fromkeys(described.variables.values()):
        reader.size(variable)
    points = prod(reader.size(described.contact.area).shape)
    source = Source(described, reader, dofs, holder)
    for bolt in described.bolts:
        if bolt.locked is not None:
            source.dof(f"locked of bolt {bolt.name}", bolt.locked)
    for row in (*described.inputs, *described.outputs):
        if row.dof is not None:
            source.dof(f"dof of {row.name}", row.dof)
    return Sizes(count, points, len(described.bolts)), source


def _dofs_of_matrices(described: Matrices, reader: Reader) -> int:
    """Degrees of freedom of K and M."""
    name = described.stiffness
    size = reader.size(name)
    if len(size.shape) != 2 or size.shape[0] != size.shape[1] or not size.shape[0]:
        raise ValueError(f"{reader.place(name)} has shape {size.shape}: it must be square")
    dofs = size.shape[0]
    needed = max(_FACTORS * dofs ** (4 / 3), 2 * size.memory)
    reader.require_memory(name, needed, f"has {dofs} degrees of freedom")
    mass = reader.size(described.mass)
    if mass.shape != size.shape:
        place = reader.place(described.mass)
        raise ValueError(f"{place} has shape {mass.shape}, expected {size.shape}")
    return dofs
