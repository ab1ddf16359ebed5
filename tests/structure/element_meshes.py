"""Small meshes of every kind of element."""

import numpy as np

from boltjoint.structure.elements.assembly import ElementBlock
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.elements.matrices import IsotropicMaterial

STEEL = IsotropicMaterial(206e9, 0.3, 7850.0)

#: wedges and tetrahedra in a brick by its corners, whose sides match those of its neighbours
_WEDGES = ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7))
_TETRAHEDRA = (
    *((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6)),
    *((0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)),
)
_PARTS = {4: _TETRAHEDRA, 6: _WEDGES, 8: (tuple(range(8)),)}


def box_of(name, divisions, size=(1.0, 1.0, 1.0), material=STEEL, amount=0.0):
    """Nodes and elements of a box from the origin.

    Corners inside are moved by up to ``amount`` of the distance between them.
    """
    kind = KINDS[name]
    counts = np.array(divisions) + 1
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1)
    grid = grid.reshape(-1, 3)
    number = np.arange(len(grid)).reshape(counts)
    square = ((0, 0), (1, 0), (1, 1), (0, 1))
    nx, ny, nz = divisions
    bricks = np.stack(
        [number[i : nx + i, j : ny + j, k : nz + k].ravel() for k in range(2) for i, j in square],
        axis=1,
    )
    corners = np.concatenate([bricks[:, list(part)] for part in _PARTS[kind.corners]])
    inside = np.all((grid > 0) & (grid < divisions), axis=1)
    random = np.random.default_rng(0).uniform(-amount, amount, grid.shape)
    # so that a deck holds every digit
    node = np.round((grid + inside[:, None] * random) / divisions * size, 10)
    if kind.functions.edges:
        ends = np.sort(corners[:, np.array(kind.functions.edges)], axis=2)
        unique, place = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
        middles = len(node) + place.reshape(len(corners), -1)
        node = np.concatenate([node, node[unique].mean(axis=1)])
        corners = np.concatenate([corners, middles], axis=1)
    return node, ElementBlock(kind, corners, material)


def faces_where(node, block, is_on):
    """Faces of a block all of whose nodes are on a surface, outward, by their number of nodes."""
    faces = {}
    for face in block.kind.faces:
        nodes = block.connectivity[:, face]
        on = is_on(node[nodes]).all(axis=1)
        faces.setdefault(len(face), []).append(nodes[on])
    return [found for each in faces.values() if len(found := np.concatenate(each))]
