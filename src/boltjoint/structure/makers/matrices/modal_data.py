"""Modes in place of stiffness and mass: coordinates of a structure, and displacements by them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.config.matrices import Matrices
from boltjoint.config.matrix_modes import MatrixModes
from boltjoint.structure.contact_points import DIRECTIONS
from boltjoint.structure.makers.matrices.reader import Reader

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModalData:
    """Modes of unit modal mass, whose coordinates are the degrees of freedom of a structure.

    Attributes
    ----------
    frequency
        Natural frequencies [Hz], 0 of rigid-body modes, shape (modes,).
    shape
        Displacements of the degrees of freedom in which the rest is described, shape (dofs, modes);
        None where these are the modal coordinates.
    node, position
        Numbers of nodes, whose x, y, z are the rows of the shape, shape (nodes,), and where they
        are, in the unit of the file, shape (nodes, 3); None where not known.
    """

    frequency: Array
    shape: Array | None = None
    node: NDArray[np.int64] | None = None
    position: Array | None = None

    def matrices(self, unit_mass: float) -> tuple[sparse.csc_array, sparse.csc_array]:
        """Stiffness [N/m] and mass [kg] of a unit modal mass [kg], diagonal, (modes, modes)."""
        diagonals = (2 * np.pi * self.frequency) ** 2, np.ones(self.frequency.size)
        stiffness, mass = (
            sparse.diags_array(unit_mass * diagonal, format="csc") for diagonal in diagonals
        )
        return stiffness, mass

    def rows(self, of_dofs: sparse.sparray | Array) -> sparse.sparray | Array:
        """Rows by modal coordinates, (rows, modes), of rows by degrees of freedom, (rows, dofs)."""
        return of_dofs if self.shape is None else of_dofs @ self.shape


def sizes_of_modes(modes: MatrixModes, reader: Reader) -> tuple[int, int]:
    """Number of modes, and of the degrees of freedom in which the rest is described.

    Raises
    ------
    ValueError
        If a variable is not there, or sizes do not fit.
    """
    name, shape = modes.natural_frequency, modes.variable("mode_shape")
    size = reader.size(name)
    if not size.is_vector or not size.stored:
        raise ValueError(f"{reader.place(name)} has shape {size.shape}: it must be a vector")
    dofs = count = size.stored
    if shape is not None:
        found = reader.size(shape)
        if len(found.shape) != 2 or found.shape[1] != count:
            expected = f"expected {count} columns, as {name} has modes"
            raise ValueError(f"{reader.place(shape)} has shape {found.shape}, {expected}")
        dofs = found.shape[0]
    if (node := modes.variable("node")) is not None:
        found = reader.size(node)
        if DIRECTIONS * found.stored != dofs:
            raise ValueError(
                f"{reader.place(node)} has {found.stored} numbers: {shape} has {dofs} rows, and "
                "needs three of each node"
            )
    return count, dofs


def read_modal_data(modes: MatrixModes, reader: Reader) -> ModalData:
    """The modes that files hold.

    Raises
    ------
    ValueError
        If a variable is not finite, of another size, a frequency is negative, or a node appears
        twice.
    """
    count, dofs = sizes_of_modes(modes, reader)
    frequency = reader.array(modes.natural_frequency, (count,), at_least=0)
    names = [modes.variable(key) for key in ("mode_shape", "node", "node_position")]
    shape, node, position = names
    number = None
    if node is not None:
        number = reader.whole_numbers(node, (dofs // DIRECTIONS,))
        values, times = np.unique(number, return_counts=True)
        if times.max() > 1:
            twice = values[times > 1][0]
            raise ValueError(f"{reader.place(node)} holds node {twice} twice")
    return ModalData(
        frequency,
        None if shape is None else reader.array(shape, (dofs, count)),
        number,
        None if position is None else reader.array(position, (dofs // DIRECTIONS, DIRECTIONS)),
    )


def dofs_of_nodes(numbers: NDArray[np.int64], data: ModalData, what: str, node: str) -> NDArray:
    """Degrees of freedom along x, y, z of nodes, (nodes, 3), by their numbers.

    Raises
    ------
    ValueError
        If there is no such node: ``what`` names it, ``node`` is the place of the nodes there are.
    """
    known = np.zeros(0, np.int64) if data.node is None else data.node
    order = np.argsort(known)
    place = np.searchsorted(known, numbers, sorter=order)
    found = order[np.minimum(place, known.size - 1)]
    if (missing := np.flatnonzero(known[found] != numbers)).size:
        raise ValueError(f"{what} is node {numbers[missing[0]]}, which {node} does not hold")
    return DIRECTIONS * found[:, None] + np.arange(DIRECTIONS)


def damping_ratios(described: Matrices, folder: str | Path) -> tuple[float, ...]:
    """Viscous damping ratios of the elastic modes, in the order of the file.

    Parameters
    ----------
    described, folder
        As for ``structure_of_matrices``, with ``modes.damping_ratio``.

    Raises
    ------
    ValueError
        If one is negative, 1 or more, or all are 0; or as for ``read_modal_data``.
    """
    modes, reader = described.modes, Reader(described, folder)
    if modes is None or (name := modes.damping_ratio) is None:
        return ()
    count, _ = sizes_of_modes(modes, reader)
    frequency = reader.array(modes.natural_frequency, (count,), at_least=0)
    ratio = reader.array(name, (count,), at_least=0, below=1)[frequency > 0]
    if not ratio.any():
        raise ValueError(f"{reader.place(name)} is zero: elastic modes have damping")
    return tuple(ratio.tolist())
