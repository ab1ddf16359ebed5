"""Stiffness and consistent mass of a mesh of hexahedra.

The element is the eight-node brick with incompatible modes, corrected to pass the patch test: three
quadratic displacements, internal to the element, let it bend without shear locking. They are
condensed in the element and cost no unknowns.

References
----------
R. L. Taylor, P. J. Beresford, E. L. Wilson: A non-conforming element for stress analysis.
International Journal for Numerical Methods in Engineering 10 (1976) 1211-1219.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from boltjoint import checks
from boltjoint.structure.elements.kinds import CORNERS_OF_HEXAHEDRON

Array = NDArray[np.float64]

#: 2 x 2 x 2 Gauss points, all of weight one
_GAUSS = CORNERS_OF_HEXAHEDRON / np.sqrt(3)

#: elements whose matrices are in memory together
_CHUNK = 4096


def assemble(
    coordinate: Array,
    connectivity: NDArray[np.integer],
    youngs_modulus: ArrayLike,
    poissons_ratio: ArrayLike,
    density: ArrayLike,
) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Stiffness and consistent mass of a body of isotropic materials.

    Parameters
    ----------
    coordinate
        Nodes, shape (nodes, 3) [m].
    connectivity
        Hexahedra, shape (elements, 8), corners in the order of VTK.
    youngs_modulus, poissons_ratio, density
        E [Pa], nu [-], rho [kg/m3]: a number for all elements, or one for each, shape (elements,).

    Returns
    -------
    tuple
        K [N/m] and M [kg], shape (3 * nodes, 3 * nodes), symmetric; the unknown 3 i + a is the
        displacement of node i along axis a.

    Raises
    ------
    ValueError
        If shapes or material make no sense, a coordinate is not finite, a node does not exist, or
        an element is turned inside out.
    """
    coordinate, connectivity = check_mesh(coordinate, connectivity)
    elements = connectivity.shape[:1]
    density = checks.of_each("density", density, elements, above=0)
    E = checks.of_each("youngs_modulus", youngs_modulus, elements, above=0)
    nu = checks.of_each("poissons_ratio", poissons_ratio, elements, above=-1, below=0.5)
    stiffness, mass = [], []
    for start in range(0, len(connectivity), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        corners, D = coordinate[connectivity[chunk]], elasticity_matrix(E[chunk], nu[chunk])
        stiffness.append(_element_stiffness(corners, D).reshape(-1, 8, 3, 8, 3))
        mass.append(_element_mass(corners, density[chunk]))
    K_blocks = np.concatenate(stiffness).transpose(0, 1, 3, 2, 4).reshape(-1, 3, 3)
    return _sum_blocks(connectivity, len(coordinate), K_blocks, np.concatenate(mass).ravel())


def elasticity_matrix(youngs_modulus: ArrayLike, poissons_ratio: ArrayLike) -> Array:
    """Hooke's law of isotropic solids [Pa], shape (6, 6), or (elements, 6, 6).

    Strains in the order xx, yy, zz, xy, yz, zx, shear as engineering strain.

    Parameters
    ----------
    youngs_modulus, poissons_ratio
        E [Pa] and nu [-]: numbers, or of each element, shape (elements,).

    Raises
    ------
    ValueError
        If no elastic solid has such a modulus or ratio.
    """
    shape = np.shape(youngs_modulus) or np.shape(poissons_ratio)
    nu = checks.of_each("poissons_ratio", poissons_ratio, shape, above=-1, below=0.5)
    shear = checks.of_each("youngs_modulus", youngs_modulus, shape, above=0) / (2 * (1 + nu))
    D = np.zeros((*shape, 6, 6))
    D[..., :3, :3] = (2 * shear * nu / (1 - 2 * nu))[..., None, None]
    D[..., range(3), range(3)] += (2 * shear)[..., None]
    D[..., range(3, 6), range(3, 6)] = shear[..., None]
    return D


def element_stiffness(corners: Array, D: Array) -> Array:
    """Stiffness of eight-node bricks with incompatible modes.

    With strains B u + G a, u of the corners and a of the incompatible modes 1 - xi_i^2::

        K = int B^T D B - (int B^T D G) (int G^T D G)^-1 (int G^T D B)

    G is formed with the Jacobian of the element's centre, J_0, and scaled by det J_0 / det J. Its
    integral then vanishes, so that constant strain leaves the incompatible modes at rest: this is
    the patch test.

    Parameters
    ----------
    corners
        Shape (elements, 8, 3) [m].
    D
        Hooke's law [Pa], shape (6, 6), or of each element, shape (elements, 6, 6).

    Returns
    -------
    ndarray
        Shape (elements, 24, 24) [N/m], unknowns corner by corner.

    Raises
    ------
    ValueError
        If an array is not of this shape, or not finite, or an element is turned inside out.
    """
    corners = _right_side_out(corners)
    D = checks.array("D", D)
    D = checks.array("D", D, (6, 6) if D.ndim == 2 else (len(corners), 6, 6))
    return _element_stiffness(corners, D)


def _element_stiffness(corners: Array, D: Array) -> Array:
    n = len(corners)
    central = _jacobian(corners, np.zeros(3))
    K_uu, K_au, K_aa = np.zeros((n, 24, 24)), np.zeros((n, 9, 24)), np.zeros((n, 9, 9))
    for point in _GAUSS:
        J = _jacobian(corners, point)
        volume = np.linalg.det(J)
        B = _strain_matrix(np.asarray(np.linalg.solve(J, _slopes(point)), dtype=np.float64))
        bubble_slopes = np.broadcast_to(np.diag(-2 * point), (n, 3, 3))
        scale = np.linalg.det(central) / volume
        G = _strain_matrix(scale[:, None, None] * np.linalg.solve(central, bubble_slopes))
        DB, DG = volume[:, None, None] * (D @ B), volume[:, None, None] * (D @ G)
        K_uu += B.transpose(0, 2, 1) @ DB
        K_au += G.transpose(0, 2, 1) @ DB
        K_aa += G.transpose(0, 2, 1) @ DG
    K = K_uu - K_au.transpose(0, 2, 1) @ np.linalg.solve(K_aa, K_au)
    return (K + K.transpose(0, 2, 1)) / 2


def element_mass(corners: Array, density: ArrayLike) -> Array:
    """Consistent mass of eight-node bricks along one axis.

    Parameters
    ----------
    corners
        Shape (elements, 8, 3) [m].
    density
        rho [kg/m3]: a number, or of each element, shape (elements,).

    Returns
    -------
    ndarray
        Shape (elements, 8, 8) [kg].

    Raises
    ------
    ValueError
        If the corners are not of this shape or not finite, the density is not positive, or an
        element is turned inside out.
    """
    corners = _right_side_out(corners)
    return _element_mass(corners, checks.of_each("density", density, (len(corners),), above=0))


def _element_mass(corners: Array, density: Array) -> Array:
    mass = np.zeros((len(corners), 8, 8))
    for point in _GAUSS:
        shape = _shape(point)
        volume = np.linalg.det(_jacobian(corners, point))
        mass += (density * volume)[:, None, None] * np.outer(shape, shape)
    return mass


def smallest_jacobian(coordinate: Array, connectivity: NDArray[np.integer]) -> Array:
    """Smallest Jacobian determinant among corners and Gauss points of each element [m3].

    Shape (elements,); zero or negative where an element is turned inside out. A corner may be
    folded over where no Gauss point is.

    Parameters
    ----------
    coordinate, connectivity
        As for ``assemble``.

    Raises
    ------
    ValueError
        If they are not of these shapes, a coordinate is not finite or a node does not exist.
    """
    coordinate, connectivity = _mesh(coordinate, connectivity)
    return _smallest_jacobian(coordinate[connectivity])


def _smallest_jacobian(corners: Array) -> Array:
    points = np.concatenate([CORNERS_OF_HEXAHEDRON, _GAUSS])
    return np.min([np.linalg.det(_jacobian(corners, point)) for point in points], axis=0)


def _right_side_out(corners: Array) -> Array:
    """Corners of elements, shape (elements, 8, 3), refused where one is turned inside out."""
    corners = checks.array("corners", corners, ("elements", 8, 3))
    _refuse_inverted("corners", corners)
    return corners


def _refuse_inverted(name: str, corners: Array) -> None:
    inverted = _smallest_jacobian(corners) <= 0
    if inverted.any():
        raise ValueError(
            f"{name}: {np.count_nonzero(inverted)} elements are turned inside out, the first one "
            f"is {np.argmax(inverted)}: the determinant of its Jacobian is zero or less at a "
            "corner or integration point"
        )


def check_mesh(
    coordinate: Array, connectivity: NDArray[np.integer]
) -> tuple[Array, NDArray[np.int64]]:
    """Nodes and hexahedra of a body, none of them turned inside out.

    Parameters
    ----------
    coordinate, connectivity
        As for ``assemble``.

    Raises
    ------
    ValueError
        As for ``smallest_jacobian``, or if an element is turned inside out.
    """
    coordinate, connectivity = _mesh(coordinate, connectivity)
    _refuse_inverted("connectivity", coordinate[connectivity])
    return coordinate, connectivity


def _mesh(coordinate: Array, connectivity: NDArray[np.integer]) -> tuple[Array, NDArray[np.int64]]:
    """Nodes and hexahedra, at least one."""
    coordinate = checks.array("coordinate", coordinate, ("nodes", 3))
    shape = ("elements", 8)
    connectivity = checks.indices("connectivity", connectivity, shape, count=len(coordinate))
    if not len(connectivity):
        raise ValueError("connectivity is empty: a body has at least one element")
    return coordinate, connectivity


def _shape(point: Array) -> Array:
    return np.prod(1 + CORNERS_OF_HEXAHEDRON * point, axis=1) / 8


def _slopes(point: Array) -> Array:
    """Derivatives of the shape functions by the parent coordinates, shape (3, 8)."""
    factor = 1 + CORNERS_OF_HEXAHEDRON * point
    others = np.stack([np.prod(np.delete(factor, axis, 1), axis=1) for axis in range(3)])
    return CORNERS_OF_HEXAHEDRON.T * others / 8


def _jacobian(corners: Array, point: Array) -> Array:
    """Derivatives of x by the parent coordinates, shape (elements, parent axis, axis)."""
    return _slopes(point) @ corners


def _strain_matrix(slopes: Array) -> Array:
    """Strains from displacements whose derivatives are given, (n, 3, k) -> (n, 6, 3 k)."""
    n, _, k = slopes.shape
    B = np.zeros((n, 6, k, 3))
    x, y, z = slopes.transpose(1, 0, 2)
    B[:, 0, :, 0], B[:, 1, :, 1], B[:, 2, :, 2] = x, y, z
    B[:, 3, :, 0], B[:, 3, :, 1] = y, x
    B[:, 4, :, 1], B[:, 4, :, 2] = z, y
    B[:, 5, :, 2], B[:, 5, :, 0] = x, z
    return B.reshape(n, 6, 3 * k)


def _sum_blocks(
    connectivity: NDArray[np.integer], nodes: int, K_blocks: Array, M_entries: Array
) -> tuple[sparse.csc_array, sparse.csc_array]:
    """Sum the elements' node-to-node blocks; K and M have the same pairs of nodes."""
    pair = (connectivity[:, :, None].astype(np.int64) * nodes + connectivity[:, None, :]).ravel()
    order = np.argsort(pair, kind="stable")
    pair = pair[order]
    start = np.flatnonzero(np.concatenate([[True], pair[1:] != pair[:-1]]))
    row, column = np.divmod(pair[start], nodes)
    pointer = np.searchsorted(row, np.arange(nodes + 1))
    K_sum = np.add.reduceat(K_blocks[order], start, axis=0)
    M_sum = np.add.reduceat(M_entries[order], start)[:, None, None] * np.eye(3)
    shape = (3 * nodes, 3 * nodes)
    K, M = (
        sparse.bsr_array((blocks, column.astype(np.int32), pointer.astype(np.int32)), shape=shape)
        for blocks in (K_sum, M_sum)
    )
    M = M.tocsc()
    M.eliminate_zeros()
    return K.tocsc(), M
