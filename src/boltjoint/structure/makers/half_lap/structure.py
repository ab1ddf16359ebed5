"""The structure of a half lap: clamp, pretension, contact, and where forces may act.

The degrees of freedom are the displacements of the nodes that are neither in the clamp nor on the
head's side of a pretension section, and after them the shortening of each shank.
"""

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import ConvexHull

from boltjoint import checks
from boltjoint.structure.contact_points import ContactPoints
from boltjoint.structure.elasticity import assemble, check_mesh
from boltjoint.structure.elements.kinds import FACES_OF_HEXAHEDRON
from boltjoint.structure.extrusion.motion import bodies_of_nodes, dofs, free_motion, reflection
from boltjoint.structure.geometry import CellMaterial, Geometry
from boltjoint.structure.makers.half_lap.parts import FIRST_BOLT, element_materials
from boltjoint.structure.model import Bolt, Reflection, Row, Structure, unit_row

Array = NDArray[np.float64]


def free_displacements(assembly: xr.Dataset, *, tightened: bool) -> sparse.csc_array:
    """The matrix T of ``u = T q`` that holds the clamp and joins the pretension sections.

    A node on the nut's side of a section is free, the node facing it on the head's side follows::

        u_head = u_nut - shortening e_z

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    tightened
        Whether the shortening of each shank is an unknown; they are the last ones of q.
        Otherwise the sections stay closed.

    Returns
    -------
    csc_array
        T, shape (3 * nodes, unknowns).

    Raises
    ------
    ValueError
        If the assembly has no clamp or sections, or a node of them does not exist.
    """
    nodes = len(checks.variable("assembly", assembly, "coordinate", ("node", "axis")))
    section = _nodes(assembly, "section_node", ("section_pair", "section_side"))
    held = _nodes(assembly, "clamped_node", ("clamped",))
    bolts = assembly.sizes["bolt"] if tightened else 0
    return free_motion(nodes, section, assembly["section_bolt"].to_numpy(), held, bolts)


def relative_displacements(assembly: xr.Dataset) -> sparse.csr_array:
    """The matrix that takes nodal displacements to those of side A minus side B.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.

    Returns
    -------
    csr_array
        Shape (3 * pairs, 3 * nodes), pair by pair; positive along z is closing.

    Raises
    ------
    ValueError
        If the assembly has no pairs, or a node of them does not exist.
    """
    side_a, side_b = (dofs(node) for node in _nodes(assembly, "pair_node", ("pair", "side")).T)
    row = np.arange(side_a.size)
    return sparse.csr_array(
        (
            np.concatenate([np.ones(row.size), np.full(row.size, -1.0)]),
            (np.concatenate([row, row]), np.concatenate([side_a, side_b])),
        ),
        shape=(row.size, 3 * assembly.sizes["node"]),
    )


def assemble_assembly(assembly: xr.Dataset) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Stiffness [N/m] and mass [kg] of all nodes of an assembly, none held, nothing in contact.

    Raises
    ------
    ValueError
        If the assembly has no mesh or material, or as for ``elasticity.assemble`` and
        ``element_materials``.
    """
    return assemble(
        *_mesh_variables(assembly),
        *element_materials(assembly),
    )


def mesh_of(assembly: xr.Dataset) -> tuple[Array, NDArray[np.int64]]:
    """Nodes and hexahedra of an assembly (``elasticity.check_mesh``)."""
    return check_mesh(*_mesh_variables(assembly))


def _mesh_variables(assembly: xr.Dataset) -> tuple[Array, NDArray[np.int64]]:
    return (
        checks.variable("assembly", assembly, "coordinate", ("node", "axis")),
        checks.index_variable("assembly", assembly, "connectivity", ("element", "corner")),
    )


def _nodes(assembly: xr.Dataset, name: str, dims: tuple[str, ...]) -> NDArray[np.int64]:
    checks.instance("assembly", assembly, xr.Dataset)
    count = assembly.sizes.get("node", 0)
    return checks.index_variable("assembly", assembly, name, dims, count=count)


#: of the maker
NAME = "half_lap"


def structure_of(assembly: xr.Dataset) -> Structure:
    """The structure of an assembly.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.

    Raises
    ------
    ValueError
        If a variable of the assembly is missing, not finite or out of range.
    """
    T = free_displacements(assembly, tightened=True)
    K, M = assemble_assembly(assembly)
    relative = relative_displacements(assembly) @ T
    reflection = _reflection(assembly, T)
    coordinate = assembly["coordinate"].to_numpy()
    is_held = assembly.sizes["clamped"] > 0
    # in the frame of the clamp its acceleration a is the inertia force -M r a on all nodes
    support = -(T.T @ (M @ np.tile(np.eye(3), (len(coordinate), 1)))).T
    structure = Structure(
        stiffness=(T.T @ K @ T).tocsc(),
        mass=(T.T @ M @ T).tocsc(),
        contact=_contact(assembly, relative.tocsr()),
        bolts=_bolts(assembly, T.shape[1]),
        inputs={"excitation": _row(assembly, "excitation", T)},
        outputs={"output": _row(assembly, "response", T)},
        support=support if is_held else None,
        symmetry=reflection,
        geometry=Geometry(
            coordinate,
            T,
            assembly["connectivity"].transpose("element", "corner").to_numpy().astype(np.int64),
            assembly["part"].to_numpy().astype(np.int64),
            _cell_material(assembly),
        ),
        maker=NAME,
    )
    return structure if is_held else structure.with_rigid_motions()


def _cell_material(assembly: xr.Dataset) -> CellMaterial | None:
    if "part_yield_strength" not in assembly:
        return None
    material = element_materials(assembly)
    strength = assembly["part_yield_strength"].to_numpy()[assembly["part"].to_numpy()]
    return CellMaterial(material.youngs_modulus, material.poissons_ratio, strength)


def _contact(assembly: xr.Dataset, relative: sparse.csr_array) -> ContactPoints:
    area = checks.variable("assembly", assembly, "area", ("pair",), above=0)
    gap = np.zeros(len(area))
    if "initial_gap" in assembly:
        gap = checks.variable("assembly", assembly, "initial_gap", ("pair",), at_least=0)
    mu = checks.variable("assembly", assembly, "friction_coefficient", (), at_least=0)
    return ContactPoints(
        relative=relative,
        position=checks.variable("assembly", assembly, "position", ("pair", "axis")),
        # bar A lies below bar B: A minus B along z closes
        frame=np.broadcast_to(np.eye(3), (len(area), 3, 3)),
        area=area,
        surface=np.array("lap"),
        gap=gap,
        penalty=np.full(len(area), checks.variable("assembly", assembly, "contact_penalty", ())),
        friction_coefficient=np.full(len(area), mu),
    )


def _bolts(assembly: xr.Dataset, dofs: int) -> tuple[Bolt, ...]:
    """The bolts, whose shortening are the last degrees of freedom."""
    position = checks.variable("assembly", assembly, "bolt_position", ("bolt", "axis"))
    first = dofs - len(position)
    clearance = float(assembly["hole_clearance"]) if "hole_clearance" in assembly else None
    bolts = []
    for number, at in enumerate(position):
        bolts.append(
            Bolt(
                name=f"bolt {number + 1}",
                load=unit_row(first + number, dofs),
                locked=first + number,
                axis=np.array([0.0, 0.0, 1.0]),
                position=at,
                section=_shank_area(assembly, number),
                youngs_modulus=_shank_modulus(assembly, number),
                yield_strength=_shank_strength(assembly, number),
                hole_clearance=clearance,
            )
        )
    return tuple(bolts)


def _section_nodes(assembly: xr.Dataset, bolt: int) -> NDArray[np.int64]:
    of_bolt = assembly["section_bolt"].to_numpy() == bolt
    return assembly["section_node"].to_numpy()[of_bolt]


def _shank_area(assembly: xr.Dataset, bolt: int) -> float:
    """Cross-section of a shank [m2], by the nodes of its pretension section."""
    node = _section_nodes(assembly, bolt)[:, 0]
    # the volume of a hull in the plane is its area
    return float(ConvexHull(assembly["coordinate"].to_numpy()[node, :2]).volume)


def _shank_modulus(assembly: xr.Dataset, bolt: int) -> float:
    """Young's modulus of a shank [Pa]: of the elements at its pretension section."""
    in_section = np.zeros(assembly.sizes["node"], dtype=bool)
    in_section[_section_nodes(assembly, bolt)] = True
    connectivity = assembly["connectivity"].transpose("element", "corner").to_numpy()
    element = np.flatnonzero(in_section[connectivity].any(axis=1))
    return float(element_materials(assembly).youngs_modulus[element[0]])


def _shank_strength(assembly: xr.Dataset, bolt: int) -> float | None:
    """Yield strength of a shank [Pa]; None of files without strengths."""
    if "part_yield_strength" not in assembly:
        return None
    return float(assembly["part_yield_strength"][FIRST_BOLT + bolt])


def _row(assembly: xr.Dataset, point: str, T: sparse.csc_array) -> Row:
    """Displacement of the default point of excitation or response."""
    node = assembly[f"{point}_node"]
    direction = node.attrs["direction"]
    axis = assembly["axis"].to_numpy().tolist().index(direction)
    row = T[[3 * node.item() + axis]].toarray()[0]
    return Row(row, direction)


def _reflection(assembly: xr.Dataset, T: sparse.csc_array) -> Reflection | None:
    """The reflection at y = 0, None where the mesh is not symmetric."""
    coordinate = assembly["coordinate"].to_numpy()
    body = bodies_of_nodes(
        len(coordinate),
        assembly["connectivity"].transpose("element", "corner").to_numpy(),
        assembly["part"].to_numpy().astype(np.int64),
        assembly["section_node"].to_numpy()[:, 1],
    )
    side_a = assembly["pair_node"].transpose("pair", "side").to_numpy()[:, 0]
    return reflection(coordinate, body, T, assembly["bolt_position"].to_numpy(), side_a)


#: outer surfaces of the bars: axis along which they lie at the end, and which end
_SURFACES = {"top": (2, 1), "bottom": (2, -1), "free-end": (0, 1), "left": (1, 1), "right": (1, -1)}


def nodes_of_bars(assembly: xr.Dataset) -> NDArray[np.int64]:
    """Numbers of the nodes of the bars."""
    return np.unique(assembly["connectivity"].to_numpy()[_of_bars(assembly)])


def load_on_surface(assembly: xr.Dataset, surface: str) -> Array:
    """Consistent nodal forces of an even load of one newton on an outer surface, (nodes,)."""
    coordinate, connectivity = mesh_of(assembly)
    faces = connectivity[:, FACES_OF_HEXAHEDRON].reshape(-1, 4)
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
