"""Warnings of meshes whose elements bend too stiffly, or too softly.

Four-node tetrahedra know constant strain alone and are too stiff in bending, by a tenth in the
frequencies of coarse meshes. Bricks of uniform strain see no bending within an element: with few
layers through the thickness it is left to the stiffness of the hourglass modes, which is a choice.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.elements.assembly import ElementBlock
from boltjoint.structure.elements.kinds import KINDS

#: layers through the thickness with which uniform strain does
LAYERS = 4

#: share of the elements with fewer layers that is no more than rims
_RIMS = 0.05

#: in place of a neighbour: none, or an element of another kind
_NONE, _OTHER = -1, -2

#: faces of bricks across from each other
_ACROSS = np.array([1, 0, 4, 5, 2, 3])


def element_warnings(blocks: Sequence[ElementBlock]) -> list[str]:
    """Sentences on elements of a body that its bending is sensitive to.

    Parameters
    ----------
    blocks
        All elements of the body.
    """
    warnings = []
    if tetrahedra := sum(len(b.connectivity) for b in blocks if b.kind.name == "C3D4"):
        warnings.append(
            f"{tetrahedra} elements C3D4: tetrahedra of four nodes are too stiff in bending, by "
            "about a tenth in frequencies of coarse meshes; those of ten nodes (C3D10) are not"
        )
    layers = brick_layers(blocks)
    if layers.size and (share := np.mean(layers < LAYERS)) > _RIMS:
        warnings.append(
            f"{share:.0%} of {layers.size} elements C3D8R lie in fewer than {LAYERS} layers, down "
            f"to {layers.min()}: their bending depends on the hourglass factor; bricks with "
            "incompatible modes (C3D8I) need one layer"
        )
    return warnings


def brick_layers(blocks: Sequence[ElementBlock]) -> NDArray[np.int64]:
    """Layers of elements through the thickness at each C3D8R, up to ``LAYERS``, (elements,).

    The least number, of the three directions of a brick, of bricks between two faces that no other
    element shares.

    Parameters
    ----------
    blocks
        All elements of the body.
    """
    bricks = [block for block in blocks if block.kind.name == "C3D8R"]
    if not bricks:
        return np.zeros(0, dtype=np.int64)
    connectivity = np.concatenate([block.connectivity for block in bricks])
    neighbour = _neighbours(connectivity, [block for block in blocks if block not in bricks])
    element = np.arange(len(connectivity))
    layers = np.full(len(connectivity), LAYERS)
    for face in (0, 2, 3):
        count = np.ones(len(connectivity), dtype=np.int64)
        for outward in (face, _ACROSS[face]):
            place, side = element, np.full(len(connectivity), outward)
            goes_on = np.ones(len(connectivity), dtype=bool)
            for _ in range(LAYERS - 1):
                following = neighbour[place, side]
                # beyond an element of another kind the thickness is not known
                count = np.where(goes_on & (following == _OTHER), LAYERS, count)
                goes_on &= following >= 0
                count += goes_on
                place, entered = np.divmod(np.where(goes_on, following, 0), 6)
                side = _ACROSS[entered]
        layers = np.minimum(layers, count)
    return layers


def _neighbours(bricks: NDArray[np.int64], others: Sequence[ElementBlock]) -> NDArray[np.int64]:
    """Six times the brick beyond each face, plus the number of its face there, (elements, 6)."""
    own = np.sort(bricks[:, np.array(KINDS["C3D8R"].faces)].reshape(-1, 4), axis=1)
    foreign = [
        np.sort(block.connectivity[:, face[:4]], axis=1)
        for block in others
        for face, corners in zip(block.kind.faces, block.kind.corners_of_faces, strict=True)
        if len(corners) == 4
    ]
    _, face = np.unique(np.concatenate([own, *foreign]), axis=0, return_inverse=True)
    face = face.ravel()
    beyond = np.full(len(own), _NONE)
    order = np.argsort(face[: len(own)], kind="stable")
    twice = np.flatnonzero(np.diff(face[order]) == 0)
    one, other = order[twice], order[twice + 1]
    beyond[one], beyond[other] = other, one
    beyond[np.isin(face[: len(own)], face[len(own) :])] = _OTHER
    return beyond.reshape(-1, 6)
