"""Constraints of a half lap: from its degrees of freedom to nodal and relative displacements."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.structure.elasticity import assemble, check_mesh
from boltjoint.structure.makers.half_lap.parts import element_materials

Array = NDArray[np.float64]

_AXES = np.arange(3)


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
    dims = ("section_pair", "section_side")
    nut_side, head_side = _nodes(assembly, "section_node", dims).T
    leader = np.arange(nodes)
    leader[head_side] = nut_side
    is_free = np.ones(nodes, dtype=bool)
    is_free[head_side] = False
    is_free[_nodes(assembly, "clamped_node", ("clamped",))] = False

    column = np.cumsum(is_free) - 1
    moving = np.flatnonzero(is_free[leader])
    row = dofs(moving)
    unknown = dofs(column[leader[moving]])
    value = np.ones(row.size)
    size = 3 * np.count_nonzero(is_free)
    if tightened:
        row = np.concatenate([row, 3 * head_side + 2])
        unknown = np.concatenate([unknown, size + assembly["section_bolt"].to_numpy()])
        value = np.concatenate([value, np.full(head_side.size, -1.0)])
        size += assembly.sizes["bolt"]
    return sparse.csc_array((value, (row, unknown)), shape=(3 * nodes, size))


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


def dofs(node: NDArray[np.integer]) -> NDArray[np.integer]:
    """Displacements of nodes along x, y, z, one node after another, shape (3 * nodes,)."""
    return (3 * np.asarray(node)[:, None] + _AXES).ravel()


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
