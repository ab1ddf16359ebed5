"""Parent elements: integration rules, and shape functions of bodies and faces from monomials.

The shape functions of an element span a set of monomials of the parent coordinates and are one at
one node and zero at the others: with the monomials p(x), their coefficients are the columns of the
inverse of Vandermonde's matrix, ``N(x) = p(x) V^-1``, ``V_ij = p_j(x_i)``.

Nodes are in the order of Abaqus and CalculiX: corners, then the middles of edges.

References
----------
A. H. Stroud: Approximate calculation of multiple integrals (1971), rules T2:2-1, T2:5-1, T3:2-1 and
T3:5-1.

O. C. Zienkiewicz, R. L. Taylor: The finite element method, volume 1, 5th edition (2000), chapter 8.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class IntegrationRule(NamedTuple):
    """Points in parent coordinates (points, axes), and weights (points,)."""

    point: Array
    weight: Array


def gauss(points: int, axes: int) -> IntegrationRule:
    """Gauss-Legendre points along each axis from -1 to 1, exact to degree 2 points - 1 in each."""
    x, w = np.polynomial.legendre.leggauss(points)
    grid = np.stack(np.meshgrid(*axes * [x], indexing="ij"), axis=-1).reshape(-1, axes)
    weight = np.prod(np.meshgrid(*axes * [w], indexing="ij"), axis=0).ravel()
    return IntegrationRule(grid, weight)


def _simplex(volume: float, *orbits: tuple[Sequence[float], float]) -> IntegrationRule:
    """Points that are permutations of barycentric coordinates, with the share of each in volume."""
    point, weight = [], []
    for barycentric, share in orbits:
        permutations = {tuple(permutation) for permutation in _permutations(list(barycentric))}
        for permutation in sorted(permutations):
            point.append(permutation[1:])
            weight.append(share * volume)
    return IntegrationRule(np.array(point), np.array(weight))


def _permutations(values: list[float]) -> list[list[float]]:
    if len(values) < 2:
        return [values]
    return [
        [first, *rest]
        for i, first in enumerate(values)
        for rest in _permutations([*values[:i], *values[i + 1 :]])
    ]


def _wedge(triangle: IntegrationRule, points: int) -> IntegrationRule:
    """A rule of the triangle at Gauss points along the axis."""
    along = gauss(points, 1)
    point = [(*p, *z) for z in along.point for p in triangle.point]
    weight = np.outer(along.weight, triangle.weight).ravel()
    return IntegrationRule(np.array(point), weight)


_ROOT = np.sqrt(15)

#: exact to degree 1, 2 and 5
TRIANGLE_1_POINT = _simplex(1 / 2, ((1 / 3, 1 / 3, 1 / 3), 1.0))
TRIANGLE_3_POINTS = _simplex(1 / 2, ((2 / 3, 1 / 6, 1 / 6), 1 / 3))
TRIANGLE_7_POINTS = _simplex(
    1 / 2,
    ((1 / 3, 1 / 3, 1 / 3), 9 / 40),
    *(
        ((1 - 2 * a, a, a), w)
        for a, w in (
            ((6 - _ROOT) / 21, (155 - _ROOT) / 1200),
            ((6 + _ROOT) / 21, (155 + _ROOT) / 1200),
        )
    ),
)
#: exact to degree 1, 2 and 5
TETRAHEDRON_1_POINT = _simplex(1 / 6, ((0.25, 0.25, 0.25, 0.25), 1.0))
TETRAHEDRON_4_POINTS = _simplex(
    1 / 6, ((1 - 3 * (5 - np.sqrt(5)) / 20, *3 * [(5 - np.sqrt(5)) / 20]), 1 / 4)
)
TETRAHEDRON_15_POINTS = _simplex(
    1 / 6,
    ((0.25, 0.25, 0.25, 0.25), 16 / 135),
    *(
        ((1 - 3 * a, a, a, a), w)
        for a, w in (
            ((7 - _ROOT) / 34, (2665 + 14 * _ROOT) / 37800),
            ((7 + _ROOT) / 34, (2665 - 14 * _ROOT) / 37800),
        )
    ),
    ((*2 * [(10 - 2 * _ROOT) / 40], *2 * [(10 + 2 * _ROOT) / 40]), 10 / 189),
)
WEDGE_2_POINTS = _wedge(TRIANGLE_1_POINT, 2)
WEDGE_6_POINTS = _wedge(TRIANGLE_3_POINTS, 2)
WEDGE_9_POINTS = _wedge(TRIANGLE_3_POINTS, 3)
WEDGE_21_POINTS = _wedge(TRIANGLE_7_POINTS, 3)
HEXAHEDRON_1_POINT = gauss(1, 3)
HEXAHEDRON_8_POINTS = gauss(2, 3)
HEXAHEDRON_27_POINTS = gauss(3, 3)


#: corners of parents: triangles and tetrahedra have area coordinates from 0 to 1, squares and cubes
#: and the axis of wedges reach from -1 to 1
_TRIANGLE = ((0, 0), (1, 0), (0, 1))
_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))
_TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
_WEDGE = tuple((*corner, z) for z in (-1, 1) for corner in _TRIANGLE)
_CUBE = tuple((*corner, z) for z in (-1, 1) for corner in _SQUARE)

#: edges in the order of their middles
_EDGES_OF_TRIANGLE = ((0, 1), (1, 2), (2, 0))
_EDGES_OF_SQUARE = ((0, 1), (1, 2), (2, 3), (3, 0))
_EDGES_OF_TETRAHEDRON = (*_EDGES_OF_TRIANGLE, (0, 3), (1, 3), (2, 3))
_EDGES_OF_WEDGE = (*_EDGES_OF_TRIANGLE, (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
_EDGES_OF_CUBE = (
    *_EDGES_OF_SQUARE,
    *((4, 5), (5, 6), (6, 7), (7, 4)),
    *((0, 4), (1, 5), (2, 6), (3, 7)),
)


@dataclass(frozen=True, eq=False)
class ShapeFunctions:
    """Shape functions of one parent element.

    Attributes
    ----------
    corner
        Parent coordinates of the corners, shape (corners, axes).
    edges
        Corners of the edges whose middles are nodes after the corners, in their order.
    exponent
        Of the monomials that the functions span, shape (nodes, axes).
    """

    corner: Array
    edges: tuple[tuple[int, int], ...]
    exponent: NDArray[np.int64]

    @cached_property
    def node(self) -> Array:
        """Parent coordinates of the nodes, shape (nodes, axes)."""
        middles = [self.corner[list(edge)].mean(axis=0) for edge in self.edges]
        return np.array([*self.corner, *middles])

    @cached_property
    def _coefficient(self) -> Array:
        return np.asarray(np.linalg.inv(_monomials(self.node, self.exponent)), float)

    def values(self, point: Array) -> Array:
        """N at points (points, axes), shape (points, nodes)."""
        return _monomials(point, self.exponent) @ self._coefficient

    def slopes(self, point: Array) -> Array:
        """Derivatives of N by the parent coordinates, shape (points, axes, nodes)."""
        axes = self.exponent.shape[1]
        of_axes = []
        for axis in range(axes):
            lower = self.exponent.copy()
            lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
            of_axes.append(self.exponent[:, axis] * _monomials(point, lower))
        return np.stack(of_axes, axis=1) @ self._coefficient


def _monomials(point: Array, exponent: NDArray[np.int64]) -> Array:
    """Products of powers of the coordinates, shape (points, monomials)."""
    point = np.asarray(point, dtype=float)
    powers = np.stack([np.ones_like(point), point, point**2])
    product_of_powers = np.ones((len(point), len(exponent)))
    for axis in range(point.shape[1]):
        product_of_powers *= powers[exponent[:, axis], :, axis].T
    return product_of_powers


def _of_degree(degree: int, axes: int) -> list[tuple[int, ...]]:
    """Exponents of all monomials up to a degree."""
    return [powers for powers in product(range(degree + 1), repeat=axes) if sum(powers) <= degree]


def _serendipity(axes: int) -> list[tuple[int, ...]]:
    """Exponents up to 2, of which one at most is 2."""
    return [powers for powers in product(range(3), repeat=axes) if powers.count(2) <= 1]


def _functions(
    corner: Sequence[tuple[int, ...]],
    edges: Sequence[tuple[int, int]],
    exponent: Sequence[tuple[int, ...]],
) -> ShapeFunctions:
    return ShapeFunctions(np.array(corner, dtype=float), tuple(edges), np.array(exponent))


TRIANGLE_3 = _functions(_TRIANGLE, (), _of_degree(1, 2))
TRIANGLE_6 = _functions(_TRIANGLE, _EDGES_OF_TRIANGLE, _of_degree(2, 2))
QUADRILATERAL_4 = _functions(_SQUARE, (), list(product(range(2), repeat=2)))
QUADRILATERAL_8 = _functions(_SQUARE, _EDGES_OF_SQUARE, _serendipity(2))
TETRAHEDRON_4 = _functions(_TETRAHEDRON, (), _of_degree(1, 3))
TETRAHEDRON_10 = _functions(_TETRAHEDRON, _EDGES_OF_TETRAHEDRON, _of_degree(2, 3))
WEDGE_6 = _functions(_WEDGE, (), [(*e, z) for e in _of_degree(1, 2) for z in range(2)])
#: quadratic in the triangle, linear times quadratic along the axis
WEDGE_15 = _functions(
    _WEDGE,
    _EDGES_OF_WEDGE,
    [
        *((*e, z) for e in _of_degree(2, 2) for z in range(2)),
        *((*e, 2) for e in _of_degree(1, 2)),
    ],
)
HEXAHEDRON_8 = _functions(_CUBE, (), list(product(range(2), repeat=3)))
HEXAHEDRON_20 = _functions(_CUBE, _EDGES_OF_CUBE, _serendipity(3))
