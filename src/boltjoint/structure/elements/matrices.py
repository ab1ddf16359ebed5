"""Stiffness and mass of solid elements of isotropic materials, many elements at a time.

With the gradients g_a of the shape functions and Lame's constants l and m, the stiffness between
nodes a and b is::

    K_ab = int l g_a g_b^T + m (g_b g_a^T + (g_a . g_b) 1) dV

so that all of it follows from the integrals of ``g_ai g_bj``: one product of matrices an element.
Incompatible modes are three functions without nodes, condensed in the element. Elements of uniform
strain have the means of the gradients in place of them, and a stiffness of the hourglass modes, of
which the mean strain vanishes.

References
----------
R. L. Taylor, P. J. Beresford, E. L. Wilson: A non-conforming element for stress analysis.
International Journal for Numerical Methods in Engineering 10 (1976) 1211-1219.
D. P. Flanagan, T. Belytschko: A uniform strain hexahedron and quadrilateral with orthogonal
hourglass control. International Journal for Numerical Methods in Engineering 17 (1981) 679-706.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from boltjoint import checks
from boltjoint.structure.elements.kinds import ElementKind
from boltjoint.structure.elements.parent_elements import IntegrationRule

Array = NDArray[np.float64]

#: rules of the mass: exact where opposite faces are parallel, or that of CalculiX
MASS_RULES = ("consistent", "reduced")

#: exponents of the modes of a brick whose mean strain vanishes
_HOURGLASS = ((1, 1, 0), (0, 1, 1), (1, 0, 1), (1, 1, 1))


@dataclass(frozen=True, eq=False)
class IsotropicMaterial:
    """A linear elastic, isotropic material of all elements, or of each.

    ``youngs_modulus`` [Pa], ``poissons_ratio`` [-] and ``density`` [kg/m3]: numbers, or shape
    (elements,) each.
    """

    youngs_modulus: ArrayLike
    poissons_ratio: ArrayLike
    density: ArrayLike

    def of_elements(self, elements: int) -> tuple[Array, Array, Array]:
        """Young's modulus, Poisson's ratio and density of each element, shapes (elements,).

        Raises
        ------
        ValueError
            If no elastic solid has such values.
        """
        limits: dict[str, checks.Limits] = {
            "youngs_modulus": {"above": 0},
            "poissons_ratio": {"above": -1, "below": 0.5},
            "density": {"above": 0},
        }
        values = []
        for name, within in limits.items():
            values.append(checks.of_each(name, getattr(self, name), (elements,), **within))
        modulus, ratio, density = values
        return modulus, ratio, density


@dataclass(frozen=True)
class ElementOptions:
    """How elements are integrated.

    Attributes
    ----------
    mass_rule
        ``consistent``, or ``reduced`` for the points of CalculiX.
    hourglass_factor
        Stiffness of the hourglass modes of C3D8R over the shear modulus [-]. That of Abaqus is
        0.005, with which frequencies of the Brake-Reuss beam, open and closed, are within 0.8 % of
        its own (Abaqus/Standard, C3D8R); that of CalculiX is 0.0013 at a Poisson's ratio of 0.3.
    """

    mass_rule: str = "consistent"
    hourglass_factor: float = 0.005

    def __post_init__(self) -> None:
        """Refuse a rule that does not exist, and hourglass modes without stiffness."""
        checks.choice("mass_rule", self.mass_rule, MASS_RULES)
        checks.number("hourglass_factor", self.hourglass_factor, above=0)


def element_matrices(
    kind: ElementKind,
    coordinate: Array,
    material: IsotropicMaterial,
    options: ElementOptions | None = None,
) -> tuple[Array, Array]:
    """Stiffness and mass of elements of one kind.

    Parameters
    ----------
    kind
        Of the elements.
    coordinate
        Their nodes, shape (elements, nodes, 3) [m].
    material
        Their material.
    options
        How they are integrated.

    Returns
    -------
    tuple
        K [N/m], shape (elements, 3 nodes, 3 nodes), unknowns node by node, and M along one axis
        [kg], shape (elements, nodes, nodes); both symmetric.

    Raises
    ------
    ValueError
        If shapes or the material make no sense, or an element is turned inside out.
    """
    checks.instance("kind", kind, ElementKind)
    checks.instance("material", material, IsotropicMaterial)
    options = ElementOptions() if options is None else options
    checks.instance("options", options, ElementOptions)
    coordinate = checks.array("coordinate", coordinate, ("elements", kind.nodes, 3))
    E, nu, density = material.of_elements(len(coordinate))
    refuse_inverted(kind, coordinate)
    shear = E / (2 * (1 + nu))
    return (
        _stiffness(kind, coordinate, 2 * shear * nu / (1 - 2 * nu), shear, options),
        _mass(kind, coordinate, density, options),
    )


def smallest_jacobian(kind: ElementKind, coordinate: Array, *, at_corners: bool = False) -> Array:
    """Smallest determinant of the Jacobian of each element over that of its parent, (elements,).

    The volume at an integration point over the weight of that point [m3]; zero or negative where
    an element is turned inside out.

    Parameters
    ----------
    kind, coordinate
        As for ``element_matrices``.
    at_corners
        Whether corners count too: a corner may be folded over where no integration point is, as of
        a brick two of whose corners are one.
    """
    points = [kind.stiffness_rule.point, kind.mass_rule.point]
    if at_corners:
        points.append(kind.functions.corner)
    return _jacobian(kind, np.concatenate(points), coordinate)[1].min(axis=1)


def refuse_inverted(
    kind: ElementKind, coordinate: Array, label: NDArray[np.integer] | None = None
) -> None:
    """Refuse elements whose Jacobian is not positive at each integration point.

    Parameters
    ----------
    kind, coordinate
        As for ``element_matrices``.
    label
        Numbers of the elements in messages, their places by default, shape (elements,).

    Raises
    ------
    ValueError
        If there are some.
    """
    inverted = np.flatnonzero(smallest_jacobian(kind, coordinate) <= 0)
    if not inverted.size:
        return
    first = inverted[0]
    place = ", ".join(f"{x:.6g}" for x in coordinate[first].mean(axis=0))
    raise ValueError(
        f"{inverted.size} elements {kind.name} are turned inside out, the first one is "
        f"{first if label is None else label[first]} at ({place}) m: the determinant of its "
        "Jacobian is zero or less at an integration point"
    )


def element_volumes(kind: ElementKind, coordinate: Array) -> Array:
    """Volumes of elements [m3], shape (elements,), of nodes (elements, nodes, 3) [m]."""
    return _point_volumes(kind, kind.mass_rule, coordinate).sum(axis=1)


def _stiffness(
    kind: ElementKind, coordinate: Array, first: Array, shear: Array, options: ElementOptions
) -> Array:
    """Stiffness from Lame's constants of the elements."""
    rule = kind.stiffness_rule
    normals, determinant = _jacobian(kind, rule.point, coordinate)
    gradient = normals.swapaxes(2, 3) @ kind.functions.slopes(rule.point)
    gradient /= determinant[..., None, None]
    volume = rule.weight * determinant
    if kind.has_uniform_strain:
        gradient = np.einsum("eq,eqka->eka", volume, gradient)[:, None]
        volume = volume.sum(axis=1, keepdims=True)
        gradient /= volume[..., None, None]
    functions = gradient
    if kind.has_incompatible_modes:
        # of 1 - xi^2, with the directions of the middle: constant strain leaves them at rest
        central = _jacobian(kind, np.zeros((1, 3)), coordinate)[0]
        bubbles = -2 * rule.point[:, None, :] * central.swapaxes(2, 3)
        functions = np.concatenate([gradient, bubbles / determinant[..., None, None]], axis=3)
    K = _isotropic(functions * np.sqrt(volume)[..., None, None], first, shear)
    if kind.has_incompatible_modes:
        K = _condensed(K, 3 * kind.nodes)
    if kind.has_uniform_strain:
        modulus = options.hourglass_factor * shear * volume[:, 0]
        K = K + _hourglass_stiffness(kind, coordinate, gradient[:, 0], modulus)
    return (K + K.transpose(0, 2, 1)) / 2


def _mass(kind: ElementKind, coordinate: Array, density: Array, options: ElementOptions) -> Array:
    rule = kind.mass_rule if options.mass_rule == "consistent" else kind.reduced_mass_rule
    shape = kind.functions.values(rule.point)
    squares = np.einsum("qa,qb->qab", shape, shape).reshape(len(shape), -1)
    M = density[:, None] * _point_volumes(kind, rule, coordinate) @ squares
    M = M.reshape(-1, kind.nodes, kind.nodes)
    return (M + M.transpose(0, 2, 1)) / 2


def _jacobian(kind: ElementKind, point: Array, coordinate: Array) -> tuple[Array, Array]:
    """Normals and determinant of the Jacobian J at points of the parent.

    The rows of J are the derivatives of x along the parent axes. Those of det J times the
    transpose of its inverse are the products of two of them: normals of the surfaces on which a
    parent coordinate is constant. Shapes (elements, points, parent axis, axis) and (elements,
    points).
    """
    J = np.einsum("qia,eak->eqik", kind.functions.slopes(point), coordinate, optimize=True)
    normals = np.cross(np.roll(J, -1, axis=2), np.roll(J, -2, axis=2))
    return normals, np.einsum("eqk,eqk->eq", J[:, :, 0], normals[:, :, 0])


def _point_volumes(kind: ElementKind, rule: IntegrationRule, coordinate: Array) -> Array:
    """Volume that each integration point stands for [m3], shape (elements, points)."""
    return rule.weight * _jacobian(kind, rule.point, coordinate)[1]


def _isotropic(gradient: Array, first: Array, shear: Array) -> Array:
    """Stiffness from gradients (elements, points, axis, functions), times roots of volumes."""
    elements, points, axes, functions = gradient.shape
    flat = gradient.reshape(elements, points, axes * functions)
    # of axes i, j and functions a, b: index (i, a, j, b)
    product = flat.transpose(0, 2, 1) @ flat
    product = product.reshape(elements, axes, functions, axes, functions)
    first, shear = (modulus[:, None, None, None, None] for modulus in (first, shear))
    K = first * product.transpose(0, 2, 1, 4, 3)
    K += shear * product.transpose(0, 2, 3, 4, 1)
    trace = shear[..., 0, 0] * np.einsum("eiaib->eab", product)
    for axis in range(axes):
        K[:, :, axis, :, axis] += trace
    return K.reshape(elements, axes * functions, axes * functions)


def _condensed(K: Array, kept: int) -> Array:
    """Stiffness of the first unknowns, the others following without forces."""
    across, own = K[:, kept:, :kept], K[:, kept:, kept:]
    return K[:, :kept, :kept] - across.transpose(0, 2, 1) @ np.linalg.solve(own, across)


def _hourglass_stiffness(
    kind: ElementKind, coordinate: Array, gradient: Array, modulus: Array
) -> Array:
    """Stiffness of the hourglass modes, orthogonal to all linear displacements.

    ``c m V (g_a . g_a)`` times the sum of h h^T over the four modes, which have +1 and -1 at
    the corners, minus their linear part.

    Parameters
    ----------
    kind, coordinate
        As for ``element_matrices``.
    gradient
        Mean gradients of the shape functions, shape (elements, 3, nodes).
    modulus
        c m V, shape (elements,).
    """
    corner = kind.functions.corner
    mode = np.array([np.prod(corner**power, axis=1) for power in _HOURGLASS])
    mode = mode - (mode @ coordinate) @ gradient
    weight = modulus * np.einsum("eka,eka->e", gradient, gradient)
    blocks = weight[:, None, None] * (mode.transpose(0, 2, 1) @ mode)
    stiffness = np.einsum("eab,ij->eaibj", blocks, np.eye(3))
    return stiffness.reshape(len(coordinate), 3 * kind.nodes, 3 * kind.nodes)
