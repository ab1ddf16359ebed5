"""A cube on a cube, which four bolts hold: a maker of structures in a package of its own."""

from itertools import product
from typing import Literal

import numpy as np
from scipy import sparse

from boltjoint.config.described import Described, MeshSize
from boltjoint.config.types import Count, Positive
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.elasticity import assemble
from boltjoint.structure.geometry import Geometry
from boltjoint.structure.model import Bolt, Row, Structure, unit_row

CORNER = np.array(list(product((0, 1), repeat=3)))[[0, 4, 6, 2, 1, 5, 7, 3]]

PAGE = __name__
MEANING = "A cube on a cube."


class Description(Described):
    """Two cubes; the lower one stands on the ground."""

    HAS_MESH = False

    type: Literal["cubes"]
    edge_mm: Positive
    elements: Count
    bolt_stiffness: Positive
    preload_N: Positive | None = None  # noqa: N815

    @property
    def bolt_count(self):
        return 4

    @property
    def size(self):
        side = self.elements + 1
        return MeshSize(2 * side**3, 2 * self.elements**3, side**2)

    @property
    def has_initial_gap(self):
        return False

    @property
    def input_names(self):
        return ("top",)

    output_names = input_names

    @property
    def surface_names(self):
        return ("between cubes",)

    def conflicts_of_point(self, point):
        yield (), "must be an input or output: the cubes have no other places"


def facts_of(description):
    return {"edge of the cubes (mm)": description.edge_mm, "bolts": description.bolt_count}


def make(description, folder):
    n, edge = description.elements, 1e-3 * description.edge_mm
    side = n + 1
    place = np.array(list(product(range(side), repeat=3)))
    node = np.concatenate([place + np.array([0, 0, shift]) for shift in (0, n)]) * edge / n

    def number(at, cube):
        return at @ [side**2, side, 1] + cube * side**3

    first = np.array(list(product(range(n), repeat=3)))
    cell = np.concatenate([number(first[:, None] + CORNER, cube) for cube in (0, 1)])
    K, M = assemble(node, cell, 2e11, 0.3, 7800.0)
    corners = [np.array([x, y, z]) for x, y in product((0, n), repeat=2) for z in (n,)]
    on_ground = np.flatnonzero(node[:, 2] == 0)
    tops = [number(each, 1) for each in corners]
    # heads of bolts on top, which the ground holds
    K = K.tolil()
    for top in tops:
        for axis in range(3):
            K[3 * top + axis, 3 * top + axis] += description.bolt_stiffness
    held = (3 * on_ground[:, None] + np.arange(3)).ravel()
    free = np.setdiff1d(np.arange(3 * len(node)), held)
    T = sparse.eye_array(3 * len(node), format="csc")[:, free]
    touching = np.array(list(product(range(side), repeat=2)))
    pair = [
        number(np.column_stack([touching, np.full(side**2, level)]), cube)
        for cube, level in ((0, n), (1, 0))
    ]
    ends = [np.where((touching == 0) | (touching == n), 0.5, 1.0).prod(axis=1)]
    relative = sparse.eye_array(3 * len(node), format="csr")
    relative = (relative[_dofs(pair[0])] - relative[_dofs(pair[1])]) @ T
    points = len(touching)
    contact = ContactPoints(
        relative=relative.tocsr(),
        position=node[pair[0]],
        frame=np.broadcast_to(np.eye(3), (points, 3, 3)),
        area=ends[0] * (edge / n) ** 2,
        surface=np.array("between cubes"),
        gap=np.zeros(points),
        penalty=np.full(points, 1e14),
        friction_coefficient=np.full(points, 0.2),
    )
    bolts = tuple(
        Bolt(f"bolt {i + 1}", -unit_row(3 * top + 2, 3 * len(node)) @ T, axis=np.eye(3)[2])
        for i, top in enumerate(tops)
    )
    top = {"top": Row(unit_row(3 * tops[-1], 3 * len(node)) @ T, "x")}
    geometry = Geometry(node, T.tocsc(), cell, np.repeat([0, 1], n**3))
    stiffness, mass = ((T.T @ each @ T).tocsc() for each in (K, M))
    return Structure(stiffness, mass, contact, bolts, top, top, geometry=geometry, maker="cubes")


def _dofs(node):
    return (3 * node[:, None] + np.arange(3)).ravel()
