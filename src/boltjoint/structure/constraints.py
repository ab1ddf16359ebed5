"""Constraints of an assembly: from its unknowns to nodal and relative displacements.

A structure that is held has a nonsingular stiffness and no mode at 0 Hz; both are checked here.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu

from boltjoint import checks
from boltjoint.structure.elasticity import assemble, check_mesh
from boltjoint.structure.materials import element_materials

Array = NDArray[np.float64]

_AXES = np.arange(3)

#: advice where a structure is not held
_HELD = (
    "a part of the assembly is not held, or its stiffnesses are too far apart: check that its "
    "elements are not much longer than wide, and that its material is nearer to steel"
)

#: share of the mesh's highest squared frequency below which others are lost in rounding
_RIGID = 1e-13


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


@dataclass(frozen=True)
class ConstrainedStructure:
    """An assembly without contact in the unknowns q of its constraints.

    Attributes
    ----------
    displacement
        T of ``u = T q`` from the unknowns to all nodes, shape (3 * nodes, unknowns).
    stiffness, mass
        K and M of the unknowns.
    """

    displacement: sparse.csc_array
    stiffness: sparse.csc_array
    mass: sparse.csc_array

    def unknowns(self, displacement: Array) -> Array:
        """The unknowns of displacements that keep the constraints, shape (3 * nodes, columns)."""
        first = self.displacement.indptr[:-1]
        sign = self.displacement.data[first]
        return sign[:, None] * displacement[self.displacement.indices[first]]

    def modes(
        self, factors: SuperLU, stiffness: sparse.csc_array, count: int
    ) -> tuple[Array, Array]:
        """The first modes with a stiffness and its factors: squared frequencies and vectors.

        Raises
        ------
        RuntimeError
            If one of the frequencies is no number or zero within rounding.
        """
        # a fixed start that no mode is orthogonal to repeats the result
        start = np.random.default_rng(0).standard_normal(stiffness.shape[0])
        inverse = LinearOperator(stiffness.shape, factors.solve, dtype=float)
        squared, q = eigsh(stiffness, k=count, M=self.mass, sigma=0.0, OPinv=inverse, v0=start)
        check_held(squared, stiffness, self.mass)
        order = np.argsort(squared)
        return squared[order], q[:, order]


def constrain(assembly: xr.Dataset, displacement: sparse.csc_array) -> ConstrainedStructure:
    """The assembly in the unknowns of ``u = T q``."""
    T, (K, M) = displacement, assemble_assembly(assembly)
    return ConstrainedStructure(T, (T.T @ K @ T).tocsc(), (T.T @ M @ T).tocsc())


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


def factorise(matrix: sparse.csc_array) -> SuperLU:
    """LU factors of a sparse matrix that is symmetric, or nearly so, and needs no pivoting.

    Raises
    ------
    ValueError
        If the matrix is not sparse and square.
    RuntimeError
        If the matrix is singular.
    """
    if not (sparse.issparse(matrix) and matrix.ndim == 2 and matrix.shape[0] == matrix.shape[1]):
        raise ValueError("matrix must be sparse and square")
    # Pivots on the diagonal keep the fill of a symmetric ordering (SuperLU users' guide, 2.2).
    # Joining no columns into larger supernodes (relax) saves these matrices a tenth of the fill.
    try:
        return splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            relax=1,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise RuntimeError(f"the stiffness matrix is singular: {_HELD}") from error


def check_held(squared: Array, stiffness: sparse.csc_array, mass: sparse.csc_array) -> None:
    """Refuse natural frequencies that a structure which is held cannot have.

    Parameters
    ----------
    squared
        Squares of the natural circular frequencies [s^-2], shape (modes,).
    stiffness, mass
        K and M.

    Raises
    ------
    RuntimeError
        If one of them is no number, or zero within rounding, as of a rigid-body mode.
    """
    # an estimate from below of the largest eigenvalue, whose rounding all of them have
    highest = (stiffness.diagonal() / mass.diagonal()).max()
    lost = ~(squared > _RIGID * highest)
    if lost.any():
        raise RuntimeError(
            f"{np.count_nonzero(lost)} of {len(squared)} natural frequencies are zero within "
            f"rounding, or no numbers: {_HELD}"
        )


def _nodes(assembly: xr.Dataset, name: str, dims: tuple[str, ...]) -> NDArray[np.int64]:
    checks.instance("assembly", assembly, xr.Dataset)
    count = assembly.sizes.get("node", 0)
    return checks.index_variable("assembly", assembly, name, dims, count=count)
