"""Where forces may act on a half lap: nodes and outer surfaces of its bars."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.structure.hexahedron import HEXAHEDRON_FACES
from boltjoint.structure.makers.half_lap.constraints import mesh_of
from boltjoint.structure.makers.half_lap.parts import FIRST_BOLT

Array = NDArray[np.float64]

#: outer surfaces of the bars: axis along which they lie at the end, and which end
_SURFACES = {"top": (2, 1), "bottom": (2, -1), "free-end": (0, 1), "left": (1, 1), "right": (1, -1)}


def nodes_of_bars(assembly: xr.Dataset) -> NDArray[np.int64]:
    """Numbers of the nodes of the bars."""
    return np.unique(assembly["connectivity"].to_numpy()[_of_bars(assembly)])


def load_on_surface(assembly: xr.Dataset, surface: str) -> Array:
    """Consistent nodal forces of an even load of one newton on an outer surface, (nodes,)."""
    coordinate, connectivity = mesh_of(assembly)
    faces = connectivity[:, HEXAHEDRON_FACES].reshape(-1, 4)
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = faces[np.sort(first[(count == 1) & np.repeat(_of_bars(assembly), 6)[first]])]
    axis, end = _SURFACES[surface]
    of_bars = coordinate[nodes_of_bars(assembly)]
    level = (end * of_bars[:, axis]).max()
    on = end * coordinate[outer][:, :, axis] > level - 1e-9 * np.ptp(of_bars[:, 0])
    outer = outer[on.all(axis=1)]
    force = np.zeros(len(coordinate))
    for point in np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / np.sqrt(3):
        s, t = point
        N = np.array([(1 - s) * (1 - t), (1 + s) * (1 - t), (1 + s) * (1 + t), (1 - s) * (1 + t)])
        by_s = np.array([t - 1, 1 - t, 1 + t, -1 - t]) / 4
        by_t = np.array([s - 1, -1 - s, 1 + s, 1 - s]) / 4
        along = (np.einsum("c,fca->fa", by, coordinate[outer]) for by in (by_s, by_t))
        area = np.linalg.norm(np.cross(*along), axis=1)
        np.add.at(force, outer, area[:, None] * N / 4)
    return force / force.sum()


def _of_bars(assembly: xr.Dataset) -> NDArray[np.bool_]:
    return assembly["part"].to_numpy() < FIRST_BOLT
