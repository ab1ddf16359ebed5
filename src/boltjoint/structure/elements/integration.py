"""Integration rules of parent elements.

References
----------
A. H. Stroud: Approximate calculation of multiple integrals (1971), rules T2:2-1, T2:5-1, T3:2-1 and
T3:5-1.
"""

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


def _simplex(volume: float, *orbits: tuple[Array, float]) -> IntegrationRule:
    """Points that are permutations of barycentric coordinates, with the share of each in volume."""
    point, weight = [], []
    for barycentric, share in orbits:
        permutations = {tuple(each) for each in _permutations(list(barycentric))}
        for each in sorted(permutations):
            point.append(each[1:])
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
