"""Common parts of convex polygons in the plane, many pairs at a time.

References
----------
I. E. Sutherland, G. W. Hodgman: Reentrant polygon clipping. Communications of the ACM 17 (1974)
32-42.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def clip_polygons(subject: Array, window: Array) -> Array:
    """The common part of convex polygons, counter-clockwise.

    All polygons of an array have as many vertices: shorter ones repeat a vertex.

    Parameters
    ----------
    subject, window
        Shapes (pairs, m, 2) and (pairs, n, 2).

    Returns
    -------
    ndarray
        Shape (pairs, m + n, 2); where the polygons have nothing in common, all vertices are one.
    """
    polygon = subject
    for edge in range(window.shape[1]):
        polygon = _beside(polygon, window[:, edge - 1], window[:, edge])
    return polygon


def _beside(polygon: Array, start: Array, end: Array) -> Array:
    """The part of polygons left of lines, with one more vertex."""
    pairs, count, _ = polygon.shape
    along = end - start
    apart = polygon - start[:, None]
    distance = along[:, None, 0] * apart[..., 1] - along[:, None, 1] * apart[..., 0]
    following = np.roll(polygon, -1, axis=1)
    distance_after = np.roll(distance, -1, axis=1)
    crosses = (distance >= 0) != (distance_after >= 0)
    change = np.where(crosses, distance - distance_after, 1.0)
    crossing = polygon + (distance / change)[..., None] * (following - polygon)
    # of each side: its start where that is inside, then where it crosses the line
    vertex = np.stack([polygon, crossing], axis=2).reshape(pairs, 2 * count, 2)
    is_kept = np.stack([distance >= 0, crosses], axis=2).reshape(pairs, 2 * count)
    order = np.argsort(~is_kept, axis=1, kind="stable")[:, : count + 1]
    vertex = np.take_along_axis(vertex, order[..., None], axis=1)
    is_kept = np.take_along_axis(is_kept, order, axis=1)
    # what is left over repeats the first vertex
    return np.where(is_kept[..., None], vertex, vertex[:, :1])


def polygon_areas(polygon: Array) -> Array:
    """Areas of polygons, positive where counter-clockwise, shape (pairs,), of (pairs, n, 2)."""
    apart = polygon[:, 1:] - polygon[:, :1]
    one, other = apart[:, :-1], apart[:, 1:]
    return np.sum(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0], axis=1) / 2


def fans(polygon: Array) -> Array:
    """Triangles of convex polygons from their first vertex, shape (pairs, n - 2, 3, 2)."""
    first = np.broadcast_to(polygon[:, :1], polygon[:, 1:-1].shape)
    return np.stack([first, polygon[:, 1:-1], polygon[:, 2:]], axis=2)
