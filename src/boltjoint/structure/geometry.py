"""Nodes and cells of a structure: for pictures, directions in space, and stresses.

References
----------
R. von Mises: Mechanik der festen Koerper im plastisch-deformablen Zustand. Nachrichten von der
Gesellschaft der Wissenschaften zu Goettingen (1913) 582-592.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.elements.kinds import KINDS

Array = NDArray[np.float64]


class CellMaterial(NamedTuple):
    """Young's modulus [Pa], Poisson's ratio and yield strength [Pa] of cells, each (cells,).

    The strength is not a number where stresses are not compared with one.
    """

    youngs_modulus: Array
    poissons_ratio: Array
    yield_strength: Array


@dataclass(frozen=True, eq=False)
class Geometry:
    """Nodes and cells of a structure, for pictures and where directions in space matter.

    ``node`` (nodes, 3) [m]; ``displacement`` (3 * nodes, dofs) along x, y, z of the nodes, one node
    after another; ``cell`` (cells, corners) in the order of VTK, -1 where a cell has fewer corners;
    ``part`` (cells,), the number of the part that each belongs to; ``material`` of the cells, None
    where it is not known.
    """

    node: Array
    displacement: sparse.csc_array
    cell: NDArray[np.int64]
    part: NDArray[np.int64]
    material: CellMaterial | None = None

    def shape(self, q: Array) -> Array:
        """Displacements of the nodes, shape (nodes, 3, columns), of motion (dofs, columns)."""
        return (self.displacement @ q).reshape(len(self.node), 3, -1)


class _Alike(NamedTuple):
    """Cells of one kind: their places, nodes (cells, nodes) and what gives their strains.

    ``slope`` (cells, nodes, 3) has the derivatives of the shape functions by x, y, z.
    """

    place: NDArray[np.int64]
    node: NDArray[np.int64]
    slope: Array


class CentreStresses:
    """Stresses at the centres of cells, by the displacements of their nodes.

    Parameters
    ----------
    geometry
        With the material of its cells.
    cells
        Numbers of the cells: tetrahedra, wedges and bricks with linear or quadratic edges.

    Raises
    ------
    ValueError
        If the cells have no material, or are of another kind.
    """

    def __init__(self, geometry: Geometry, cells: NDArray[np.int64]) -> None:
        if geometry.material is None:
            raise ValueError("the geometry has no material")
        E, nu = (values[cells] for values in geometry.material[:2])
        self._shear_modulus = E / (2 * (1 + nu))
        self._alike = list(_alike(geometry, cells))

    def __call__(self, displacement: Array) -> Array:
        """Vectors whose length is the stress of von Mises [Pa], shape (cells, 6).

        That is ``sqrt(3/2 s : s)`` with the deviator s, twice the shear modulus times that of the
        strain.

        Parameters
        ----------
        displacement
            Of the nodes [m], shape (nodes, 3).
        """
        strain = np.zeros((self._shear_modulus.size, 3, 3))
        for place, node, slope in self._alike:
            gradient = np.einsum("cna,cnb->cab", displacement[node], slope)
            strain[place] = (gradient + gradient.transpose(0, 2, 1)) / 2
        mean = np.trace(strain, axis1=1, axis2=2) / 3
        normal = np.diagonal(strain, axis1=1, axis2=2) - mean[:, None]
        shear = np.sqrt(2) * strain[:, [0, 1, 2], [1, 2, 0]]
        factor = np.sqrt(6) * self._shear_modulus
        return np.asarray(factor[:, None] * np.hstack([normal, shear]), float)


def _alike(geometry: Geometry, cells: NDArray[np.int64]) -> Iterator[_Alike]:
    """Cells by their kind."""
    counts = np.count_nonzero(geometry.cell[cells] >= 0, axis=1)
    for count in np.unique(counts).tolist():
        kind, place = KINDS.get(f"C3D{count}"), np.flatnonzero(counts == count)
        if kind is None:
            raise ValueError(f"a cell has {count} nodes: stresses of such cells are not known")
        node = geometry.cell[cells[place], :count][:, np.argsort(kind.vtk_order)]
        (slope,) = kind.functions.slopes(kind.functions.corner.mean(axis=0, keepdims=True))
        jacobian = np.einsum("an,cnk->cak", slope, geometry.node[node])
        by_place = np.linalg.solve(jacobian, np.broadcast_to(slope, (place.size, *slope.shape)))
        yield _Alike(place, node, by_place.transpose(0, 2, 1))
