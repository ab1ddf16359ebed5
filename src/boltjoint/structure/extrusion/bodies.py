"""The structure of two bodies with bolts: elements, pretension, contact, supports and points."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.contact_points import ContactPoints, relative_of_pairs
from boltjoint.structure.elements.assembly import ElementBlock, assemble
from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.elements.matrices import IsotropicMaterial
from boltjoint.structure.extrusion.blocks import Blocks
from boltjoint.structure.extrusion.bolt_mesh import BoltLevels, add_bolt, radii_of, washer_levels
from boltjoint.structure.extrusion.bolt_plan import bolt_plan
from boltjoint.structure.extrusion.grid_plan import BoltPlace, GridPlan
from boltjoint.structure.extrusion.motion import bodies_of_nodes, dofs, free_motion, reflection
from boltjoint.structure.extrusion.plan import Labels, tributary_area
from boltjoint.structure.geometry import CellMaterial, Geometry
from boltjoint.structure.model import Bolt, Reflection, Row, Structure, unit_row

if TYPE_CHECKING:
    from boltjoint.config.bolted_bodies import BoltedBodies
    from boltjoint.config.bolts import Material
    from boltjoint.config.excitation import NamedPoint

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: elements of all bodies: bricks that bend, of one layer too
KIND = KINDS["C3D8I"]
#: parts: the bodies, then each bolt, then the washers of each
LOWER, UPPER, FIRST_OF_BOLTS = 0, 1, 2

_MM, _GPA = 1e-3, 1e9


@dataclass(frozen=True, eq=False)
class BoltedMesh:
    """Mesh of two bodies and their bolts.

    Attributes
    ----------
    coordinate
        Nodes, shape (nodes, 3) [m].
    hexahedron, part
        Nodes and part of the bricks, shapes (bricks, 8) and (bricks,).
    pair
        Nodes of the lower and of the upper body that meet, shape (pairs, 2).
    area
        Tributary areas of the pairs [m2].
    section, bolt_of_pair
        Nodes on the nut's and on the head's side of all pretension sections, shape (pairs, 2), and
        the bolt of each of these pairs.
    bolt_position
        Where the axes of the bolts cross the contact [m], shape (bolts, 3).
    held
        Nodes that do not move.
    """

    coordinate: Array
    hexahedron: Labels
    part: Labels
    pair: Labels
    area: Array
    section: Labels
    bolt_of_pair: Labels
    bolt_position: Array
    held: Labels

    @property
    def of_bodies(self) -> Labels:
        """Nodes of both bodies, without those of bolts and washers alone."""
        return np.unique(self.hexahedron[self.part < FIRST_OF_BOLTS])


def levels_of(thickness_mm: tuple[float, float], layers: tuple[int, int]) -> tuple[Array, Array]:
    """Heights of the layers of the lower and of the upper body, which meet at 0 [m].

    Shapes (layers + 1,), ascending.
    """
    (low, high), (under, above) = thickness_mm, layers
    return np.linspace(-_MM * low, 0.0, under + 1), np.linspace(0.0, _MM * high, above + 1)


def rings_of(described: "BoltedBodies") -> tuple[int, int, int, int]:
    """Rings of elements as ``grid_plan`` takes them."""
    mesh = described.mesh
    rings = mesh.rings_in_shank, mesh.rings_under_head, mesh.rings_head_to_cell_edge
    return *rings, described.rings_of_rim


def add_bolts(
    blocks: Blocks,
    described: "BoltedBodies",
    bolts: tuple[BoltPlace, ...],
    levels: tuple[Array, Array],
    faces: tuple[Labels, Labels],
) -> list[Labels]:
    """Add all bolts with their washers; labels of their pretension sections.

    Parameters
    ----------
    blocks
        What the bodies were added to.
    described
        Dimensions and divisions.
    bolts
        Their places in the plan of both bodies.
    levels
        Of the lower and of the upper body [m].
    faces
        Nodes of the plan under nuts and under heads, shape (points,).
    """
    dimensions, layers = described.bolts, described.layers_in_washer
    radii = radii_of(dimensions)
    along = BoltLevels.of_stack(
        levels,
        (washer_levels(dimensions, "nut", layers), washer_levels(dimensions, "head", layers)),
        (_MM * dimensions.nut_height_mm, _MM * dimensions.head_height_mm),
        described.mesh.layers_in_head,
    )
    sections = []
    for number, bolt in enumerate(bolts):
        plan = bolt_plan(radii, bolt.divisions, bolt.edge).moved(*map(float, bolt.axis))
        parts = FIRST_OF_BOLTS + number, FIRST_OF_BOLTS + len(bolts) + number
        seats = faces[0][bolt.seat], faces[1][bolt.seat]
        sections.append(add_bolt(blocks, plan, along, seats, parts))
    return sections


def joined_mesh(
    blocks: Blocks,
    plan: GridPlan,
    faces: tuple[Labels, Labels],
    sections: list[Labels],
    held: Labels,
) -> BoltedMesh:
    """The mesh of what was added to blocks.

    Pairs are ordered by x, then y.

    Parameters
    ----------
    blocks
        Bodies and bolts.
    plan
        Of both bodies where they meet.
    faces
        Nodes of the lower and of the upper body there, shape (points,).
    sections
        As from ``add_bolts``.
    held
        Nodes that do not move.
    """
    coordinate, hexahedron, part, label = blocks.joined()
    pair = label[np.stack(faces, axis=-1)]
    # to a picometre: nodes on one line have the same x but for rounding
    along, across, _ = np.round(coordinate[pair[:, 0]], 12).T
    order = np.lexsort([across, along])
    return BoltedMesh(
        coordinate=coordinate,
        hexahedron=hexahedron,
        part=part,
        pair=pair[order],
        area=tributary_area(plan.plan)[order],
        section=label[np.concatenate(sections)],
        bolt_of_pair=np.repeat(np.arange(len(sections)), [len(section) for section in sections]),
        bolt_position=np.array([[*bolt.axis, 0.0] for bolt in plan.bolts]),
        held=np.unique(label[held]),
    )


def structure_of_bodies(described: "BoltedBodies", mesh: BoltedMesh) -> Structure:
    """The structure of two bodies with bolts.

    Parameters
    ----------
    described
        Materials, contact, support, points and symmetry.
    mesh
        Of bodies and bolts.

    Raises
    ------
    ValueError
        If a point is held, or the mesh has not the symmetry that is asked for.
    """
    bolts, nodes = len(mesh.bolt_position), len(mesh.coordinate)
    held = mesh.held if described.has_support else mesh.held[:0]
    T = free_motion(nodes, mesh.section, mesh.bolt_of_pair, held, bolts)
    E, nu, density = _constants(described, mesh)
    of_cells = CellMaterial(E, nu, _yield_strength(described, mesh))
    material = IsotropicMaterial(E, nu, density)
    K, M = assemble(mesh.coordinate, [ElementBlock(KIND, mesh.hexahedron, material)])
    rows = {point.name: _row(point, mesh, T) for point in described.points}
    support = -(T.T @ (M @ np.tile(np.eye(3), (nodes, 1)))).T
    structure = Structure(
        stiffness=(T.T @ K @ T).tocsc(),
        mass=(T.T @ M @ T).tocsc(),
        contact=_contact(described, mesh, T),
        bolts=_bolts(described, mesh, T.shape[1]),
        inputs=rows,
        outputs=rows,
        support=support if described.has_support else None,
        geometry=Geometry(mesh.coordinate, T, mesh.hexahedron, mesh.part, of_cells),
        maker=described.type,
    )
    if described.symmetry != "none":
        structure = replace(structure, symmetry=_symmetry(mesh, T, rows))
    if not described.has_support:
        structure = structure.with_rigid_motions()
    logger.info(
        "%s: %d nodes, %d bricks, %d contact pairs, %d rigid-body motions",
        described.type,
        nodes,
        len(mesh.hexahedron),
        len(mesh.pair),
        structure.rigid_body_motions.shape[1],
    )
    return structure


def _constants(described: "BoltedBodies", mesh: BoltedMesh) -> list[Array]:
    """Young's modulus [Pa], Poisson's ratio and density of the bricks, by their parts."""
    bolts = len(mesh.bolt_position)
    of_parts: list[Material] = [described.material] * FIRST_OF_BOLTS
    of_parts += [described.bolt_material] * bolts + [described.washer_material] * bolts
    keys = {"youngs_modulus_GPa": _GPA, "poissons_ratio": 1.0, "density_kg_per_m3": 1.0}
    return [
        np.array([factor * getattr(material, key) for material in of_parts])[mesh.part]
        for key, factor in keys.items()
    ]


def _yield_strength(described: "BoltedBodies", mesh: BoltedMesh) -> Array:
    """Of the bricks [Pa]; washers have none."""
    bolts = len(mesh.bolt_position)
    of_bodies, of_bolts = described.bolts.yield_strengths(described.material)
    strengths = [of_bodies] * FIRST_OF_BOLTS + [of_bolts] * bolts + [np.nan] * bolts
    return np.array(strengths)[mesh.part]


def _contact(described: "BoltedBodies", mesh: BoltedMesh, T: sparse.csc_array) -> ContactPoints:
    # the lower body is side A: lower minus upper along z closes
    frame = np.broadcast_to(np.eye(3), (len(mesh.pair), 3, 3))
    sides = [dofs(side).reshape(-1, 3) for side in mesh.pair.T]
    relative = relative_of_pairs(sides[0], sides[1], 3 * len(mesh.coordinate), frame) @ T
    (surface,) = described.surface_names
    return ContactPoints(
        relative=relative.tocsr(),
        position=mesh.coordinate[mesh.pair[:, 0]],
        frame=frame,
        area=mesh.area,
        surface=np.array(surface),
        gap=np.zeros(len(mesh.pair)),
        penalty=np.full(len(mesh.pair), described.contact.penalty_N_per_m3),
        friction_coefficient=np.full(len(mesh.pair), described.contact.friction_coefficient),
    )


def _bolts(described: "BoltedBodies", mesh: BoltedMesh, size: int) -> tuple[Bolt, ...]:
    """The bolts, whose shortening are the last degrees of freedom."""
    first = size - len(mesh.bolt_position)
    section, modulus, strength = described.shank
    return tuple(
        Bolt(
            name=f"bolt {number + 1}",
            load=unit_row(first + number, size),
            locked=first + number,
            axis=np.array([0.0, 0.0, 1.0]),
            position=position,
            section=section,
            youngs_modulus=modulus,
            yield_strength=strength,
            hole_clearance=_MM * described.bolts.hole_clearance_mm,
        )
        for number, position in enumerate(mesh.bolt_position)
    )


def _row(point: "NamedPoint", mesh: BoltedMesh, T: sparse.csc_array) -> Row:
    """Displacement of the node of the bodies that is nearest to a point."""
    candidates = mesh.of_bodies
    apart = mesh.coordinate[candidates] - _MM * np.array(point.near_mm)
    node = int(candidates[np.argmin(np.linalg.norm(apart, axis=1))])
    row = T[[3 * node + "xyz".index(point.direction)]].toarray()[0]
    if not row.any():
        raise ValueError(f"point {point.name}: the node nearest to it is held")
    return Row(row, point.direction)


def _symmetry(mesh: BoltedMesh, T: sparse.csc_array, rows: Mapping[str, Row]) -> Reflection:
    """The reflection at the plane of x and z."""
    # bolts on both sides are images of each other, whatever their numbers
    bolts = len(mesh.bolt_position)
    kind = np.minimum(mesh.part, FIRST_OF_BOLTS) + (mesh.part >= FIRST_OF_BOLTS + bolts)
    body = bodies_of_nodes(len(mesh.coordinate), mesh.hexahedron, kind, mesh.section[:, 1])
    found = reflection(mesh.coordinate, body, T, mesh.bolt_position, mesh.pair[:, 0])
    if found is None:
        raise ValueError("symmetry: xz: the mesh is not symmetric about the plane of x and z")
    for name, point in rows.items():
        if not np.array_equal(point.row, found.sign * point.row[found.image]):
            raise ValueError(
                f"symmetry: xz: the node nearest to point {name} is not on the plane of x and z"
            )
    return found
