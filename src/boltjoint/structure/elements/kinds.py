"""Kinds of solid elements by their names in Abaqus and CalculiX.

What a kind is, is data: its shape functions, its faces, where it is integrated, and how pictures
hold it. Two kinds of bricks have more than that: incompatible modes, or uniform strain with a
stiffness of hourglass modes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.elements import parent_elements as rules
from boltjoint.structure.elements import parent_elements as shapes
from boltjoint.structure.elements.parent_elements import IntegrationRule, ShapeFunctions

#: corners of the faces S1, S2, ... seen from outside: normals point outward
_FACES_OF_TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
_FACES_OF_WEDGE = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_FACES_OF_CUBE = (
    *((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4)),
    *((1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
)

#: nodes of wedges in VTK, which sees the first triangle from outside
_WEDGE_OF_VTK = (0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13)

#: of a face, by its number of nodes
FACE_FUNCTIONS = {
    3: shapes.TRIANGLE_3,
    4: shapes.QUADRILATERAL_4,
    6: shapes.TRIANGLE_6,
    8: shapes.QUADRILATERAL_8,
}


@dataclass(frozen=True, eq=False)
class ElementKind:
    """A kind of solid element.

    Attributes
    ----------
    name
        In Abaqus and CalculiX.
    functions
        Its shape functions.
    corners_of_faces
        Corners of its faces S1, S2, ... seen from outside.
    stiffness_rule
        Integration of the stiffness.
    mass_rule
        Integration of the consistent mass: exact where opposite faces are parallel, and that of
        the volume of any shape.
    reduced_mass_rule
        That of CalculiX.
    has_incompatible_modes
        Whether quadratic displacements internal to the element let it bend.
    has_uniform_strain
        Whether it knows the mean strain alone, and hourglass modes get a stiffness of their own.
    vtk_type
        Number of the cell in VTK.
    """

    name: str
    functions: ShapeFunctions
    corners_of_faces: tuple[tuple[int, ...], ...]
    stiffness_rule: IntegrationRule
    mass_rule: IntegrationRule
    reduced_mass_rule: IntegrationRule
    vtk_type: int
    has_incompatible_modes: bool = False
    has_uniform_strain: bool = False

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.functions.node)

    @property
    def corners(self) -> int:
        """Number of nodes at corners, which come first."""
        return len(self.functions.corner)

    @property
    def vtk_order(self) -> NDArray[np.int64]:
        """Nodes in the order of VTK, shape (nodes,)."""
        is_wedge = self.corners_of_faces is _FACES_OF_WEDGE
        return np.array(_WEDGE_OF_VTK[: self.nodes]) if is_wedge else np.arange(self.nodes)

    @cached_property
    def faces(self) -> tuple[NDArray[np.int64], ...]:
        """Nodes of the faces S1, S2, ...: corners seen from outside, then middles of edges."""
        middle = {frozenset(edge): self.corners + i for i, edge in enumerate(self.functions.edges)}
        faces = []
        for corners in self.corners_of_faces:
            edges = zip(corners, (*corners[1:], corners[0]), strict=True)
            middles = [middle[frozenset(edge)] for edge in edges] if middle else []
            faces.append(np.array([*corners, *middles]))
        return tuple(faces)

    def face(self, label: str) -> NDArray[np.int64]:
        """Nodes of a face by its label in a deck, S1 to S6.

        Raises
        ------
        ValueError
            If the kind has no such face.
        """
        labels = {f"S{i + 1}": nodes for i, nodes in enumerate(self.faces)}
        if label not in labels:
            raise ValueError(f"{self.name} has no face {label!r}: allowed are {', '.join(labels)}")
        return labels[label]


_BRICK = shapes.HEXAHEDRON_8, _FACES_OF_CUBE
_BRICK_20 = shapes.HEXAHEDRON_20, _FACES_OF_CUBE
_POINTS_8, _POINTS_27 = rules.HEXAHEDRON_8_POINTS, rules.HEXAHEDRON_27_POINTS
_POINT_1 = rules.HEXAHEDRON_1_POINT

#: by name
KINDS = {
    kind.name: kind
    for kind in (
        ElementKind(
            "C3D4",
            shapes.TETRAHEDRON_4,
            _FACES_OF_TETRAHEDRON,
            rules.TETRAHEDRON_1_POINT,
            rules.TETRAHEDRON_4_POINTS,
            rules.TETRAHEDRON_1_POINT,
            10,
        ),
        ElementKind(
            "C3D10",
            shapes.TETRAHEDRON_10,
            _FACES_OF_TETRAHEDRON,
            rules.TETRAHEDRON_4_POINTS,
            rules.TETRAHEDRON_15_POINTS,
            rules.TETRAHEDRON_4_POINTS,
            24,
        ),
        ElementKind(
            "C3D6",
            shapes.WEDGE_6,
            _FACES_OF_WEDGE,
            rules.WEDGE_2_POINTS,
            rules.WEDGE_6_POINTS,
            rules.WEDGE_2_POINTS,
            13,
        ),
        ElementKind(
            "C3D15",
            shapes.WEDGE_15,
            _FACES_OF_WEDGE,
            rules.WEDGE_9_POINTS,
            rules.WEDGE_21_POINTS,
            rules.WEDGE_9_POINTS,
            26,
        ),
        ElementKind("C3D8", *_BRICK, _POINTS_8, _POINTS_8, _POINTS_8, 12),
        ElementKind(
            "C3D8I", *_BRICK, _POINTS_8, _POINTS_8, _POINTS_8, 12, has_incompatible_modes=True
        ),
        ElementKind("C3D8R", *_BRICK, _POINTS_8, _POINTS_8, _POINT_1, 12, has_uniform_strain=True),
        ElementKind("C3D20", *_BRICK_20, _POINTS_27, _POINTS_27, _POINTS_27, 25),
        ElementKind("C3D20R", *_BRICK_20, _POINTS_8, _POINTS_27, _POINTS_8, 25),
    )
}


#: of the parent element
CORNERS_OF_HEXAHEDRON = np.array(
    [
        [-1, -1, -1],
        [1, -1, -1],
        [1, 1, -1],
        [-1, 1, -1],
        [-1, -1, 1],
        [1, -1, 1],
        [1, 1, 1],
        [-1, 1, 1],
    ],
    dtype=float,
)
#: corners of the six faces, seen from outside
FACES_OF_HEXAHEDRON = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)
