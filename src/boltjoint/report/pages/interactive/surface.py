"""The outer surface of a structure and its contact, as a page draws them in space."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.report.figures.outlines import ContactSurface, outer_faces, positions_of
from boltjoint.report.pages.interactive.packing import pack

Array = NDArray[np.float64]

#: nodes of the surface, whose numbers have sixteen bits
_MOST_NODES = 2**16 - 1
#: of an element whose faces are known
_CORNERS = 8
_MM = 1e3
#: largest number of fifteen bits
_LARGEST = 32767


@dataclass(frozen=True)
class Surface:
    """Nodes and faces of the outer surface.

    Parameters
    ----------
    node
        Numbers of the nodes in the mesh, shape (nodes,).
    position
        Their places [m], shape (nodes, 3).
    face
        Corners of the faces by their place among the nodes, shape (faces, 4).
    part
        Values of each face, shape (faces,).
    """

    node: NDArray[np.int64]
    position: Array
    face: NDArray[np.int64]
    part: NDArray[np.int64]

    @classmethod
    def of(cls, assembly: xr.Dataset) -> "Surface | None":
        """The surface of an assembly without its contact; None without a mesh, or a fine one."""
        if "connectivity" not in assembly or assembly.sizes["corner"] != _CORNERS:
            return None
        faces, part = outer_faces(assembly)
        node, face = np.unique(faces, return_inverse=True)
        if node.size > _MOST_NODES:
            return None
        face = face.reshape(-1, 4)
        if "pair_node" in assembly:
            # the contact is drawn by its pairs
            drawn = ~np.isin(faces, assembly["pair_node"]).all(axis=1)
            face, part = face[drawn], part[drawn]
        return cls(node, positions_of(assembly, "coordinate", "node")[node], face, part)

    def packed(self, assembly: xr.Dataset) -> dict[str, Any]:
        """Places [mm], faces, edges and parts, as JSON can hold them."""
        names = _names_of_parts(assembly)
        parts = []
        for number in np.unique(self.part).tolist():
            faces = self.face[self.part == number]
            parts.append(
                {
                    "words": names.get(number, f"part {number}"),
                    "faces": pack(faces, "<u2"),
                    "edges": pack(_edges(faces), "<u2"),
                }
            )
        return {"nodes": pack(self.position * _MM), "parts": parts}


def packed_displacement(displacement: Array) -> dict[str, Any]:
    """A displacement, shape (nodes, 3), in whole numbers of a unit that suits it."""
    largest = float(np.abs(displacement).max()) or 1.0
    numbers = np.rint(displacement / largest * _LARGEST)
    return {"values": pack(numbers, "<i2"), "unit": largest / _LARGEST}


def packed_contact(assembly: xr.Dataset, surface: Surface | None) -> dict[str, Any]:
    """Pairs, and the cells of the contact surface that belong to each, as JSON can hold them.

    The place of a corner of a cell is the mean of four pairs, so that it moves with them. Of
    contact points without a mesh there are no cells.
    """
    contact = ContactSurface.of(assembly)
    content: dict[str, Any] = {"places": pack(contact.position * _MM)}
    if len(contact.facet):
        facet = contact.facet
        pairs = np.arange(len(contact.position))
        # as ``ContactSurface`` numbers them: pairs, middles of edges, centres of facets
        edges = np.stack([facet, np.roll(facet, -1, axis=1)], axis=-1).reshape(-1, 2)
        edge = np.unique(np.sort(edges), axis=0)
        corners = np.concatenate(
            [np.repeat(pairs[:, None], 4, axis=1), np.tile(edge, (1, 2)), facet]
        )
        content |= {
            "corners": pack(corners, "<u2"),
            "cells": pack(contact.share, "<u2"),
            "owners": pack(contact.owner, "<u2"),
        }
    if surface is not None and "pair_node" in assembly:
        of_pair = assembly["pair_node"].transpose("pair", "side").to_numpy()[:, 0]
        place = np.searchsorted(surface.node, of_pair)
        is_there = surface.node[np.minimum(place, surface.node.size - 1)] == of_pair
        if is_there.all():
            content["nodes"] = pack(place, "<u2")
    return content


def _names_of_parts(assembly: xr.Dataset) -> Mapping[int, str]:
    attributes = assembly["part"].attrs
    if "flag_meanings" not in attributes:
        return {}
    words = [name.replace("_", " ") for name in attributes["flag_meanings"].split()]
    return dict(zip(np.atleast_1d(attributes["flag_values"]).tolist(), words, strict=True))


def _edges(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Edges of faces, each once, shape (edges, 2)."""
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.unique(np.sort(edges), axis=0)
