"""Solid elements: shape functions, integration, stiffness and mass, also against CalculiX."""

from itertools import product
from math import factorial

import numpy as np
import pytest
from element_meshes import STEEL, box_of
from matrix_storage import matrices_of_calculix
from scipy.linalg import eigh
from scipy.sparse.linalg import eigsh, spsolve
from scipy.spatial.transform import Rotation

from boltjoint.structure import elasticity
from boltjoint.structure.elements import parent_elements
from boltjoint.structure.elements.assembly import ElementBlock, assemble, mass, volume
from boltjoint.structure.elements.kinds import FACE_FUNCTIONS, KINDS
from boltjoint.structure.elements.matrices import (
    ElementOptions,
    IsotropicMaterial,
    element_matrices,
    element_volumes,
    smallest_jacobian,
)
from boltjoint.structure.elements.suitability import LAYERS, brick_layers, element_warnings

UNIT = IsotropicMaterial(1.0, 0.3, 1.0)
LINEAR = ("C3D4", "C3D6", "C3D8", "C3D8I", "C3D8R")
every_kind = pytest.mark.parametrize("name", KINDS)


def curved(kind, amount=0.05):
    """Nodes of one element of any shape, (1, nodes, 3)."""
    random = np.random.default_rng(kind.nodes).uniform(-amount, amount, (kind.nodes, 3))
    return (kind.functions.node @ [[1.0, 0.2, 0.0], [0.0, 1.1, 0.3], [0.1, 0.0, 0.9]] + random)[
        None
    ]


def rigid_motions(node):
    motions = [np.tile(axis, len(node)) for axis in np.eye(3)]
    return np.transpose(motions + [np.cross(axis, node).ravel() for axis in np.eye(3)])


@pytest.mark.parametrize(
    "functions",
    [*(kind.functions for kind in KINDS.values()), *FACE_FUNCTIONS.values()],
)
def test_shape_functions_are_one_at_their_node_and_sum_to_one(functions):
    nodes, axes = functions.node.shape
    np.testing.assert_allclose(functions.values(functions.node), np.eye(nodes), atol=1e-14)
    point = np.random.default_rng(0).uniform(0, 0.3, (4, axes))
    np.testing.assert_allclose(functions.values(point).sum(axis=1), 1, atol=1e-14)
    step = 1e-6
    for axis, shift in enumerate(step * np.eye(axes)):
        change = (functions.values(point + shift) - functions.values(point - shift)) / (2 * step)
        np.testing.assert_allclose(functions.slopes(point)[:, axis], change, atol=1e-9)


def integral_of_monomial(exponent, shape):
    """Over a simplex, a wedge or a cube."""
    axes = {"simplex": len(exponent), "wedge": 2, "cube": 0}[shape]
    in_simplex, along = exponent[:axes], exponent[axes:]
    # Dirichlet's formula
    value = np.prod([factorial(e) for e in in_simplex]) / factorial(sum(in_simplex) + axes)
    return value * np.prod([0.0 if e % 2 else 2 / (e + 1) for e in along])


@pytest.mark.parametrize(
    ("rule", "shape", "degree"),
    [
        ("TRIANGLE_1_POINT", "simplex", 1),
        ("TRIANGLE_3_POINTS", "simplex", 2),
        ("TRIANGLE_7_POINTS", "simplex", 5),
        ("TETRAHEDRON_1_POINT", "simplex", 1),
        ("TETRAHEDRON_4_POINTS", "simplex", 2),
        ("TETRAHEDRON_15_POINTS", "simplex", 5),
        ("WEDGE_2_POINTS", "wedge", 1),
        ("WEDGE_6_POINTS", "wedge", 2),
        ("WEDGE_9_POINTS", "wedge", 2),
        ("WEDGE_21_POINTS", "wedge", 5),
        ("HEXAHEDRON_1_POINT", "cube", 1),
        ("HEXAHEDRON_8_POINTS", "cube", 3),
        ("HEXAHEDRON_27_POINTS", "cube", 5),
    ],
)
def test_rules_are_exact_to_their_degree(rule, shape, degree):
    point, weight = getattr(parent_elements, rule)
    for exponent in product(range(degree + 2), repeat=point.shape[1]):
        if sum(exponent) <= degree:
            exact = integral_of_monomial(exponent, shape)
            assert weight @ np.prod(point**exponent, axis=1) == pytest.approx(exact, abs=1e-14)
    beyond = (degree + 1, *(point.shape[1] - 1) * [0])
    exact = integral_of_monomial(beyond, shape)
    assert abs(weight @ np.prod(point**beyond, axis=1) - exact) > 1e-5


@every_kind
def test_faces_are_seen_from_outside_and_close_the_element(name):
    kind = KINDS[name]
    node = kind.functions.node
    total, enclosed = np.zeros(3), 0.0
    for nodes in kind.faces:
        functions = FACE_FUNCTIONS[len(nodes)]
        triangle = functions.corner.shape[0] == 3
        rule = parent_elements.TRIANGLE_7_POINTS if triangle else parent_elements.gauss(3, 2)
        tangents = np.einsum("qia,ak->qik", functions.slopes(rule.point), node[nodes])
        area = rule.weight[:, None] * np.cross(tangents[:, 0], tangents[:, 1])
        total += area.sum(axis=0)
        enclosed += np.sum(area * (functions.values(rule.point) @ node[nodes])) / 3
    # Gauss's theorem: no flux of a constant, three times the volume of x
    np.testing.assert_allclose(total, 0, atol=1e-14)
    assert enclosed == pytest.approx(kind.mass_rule.weight.sum(), rel=1e-14)
    np.testing.assert_array_equal(kind.face("S2"), kind.faces[1])
    with pytest.raises(ValueError, match=f"{name} has no face 'S7': allowed are S1, S2, "):
        kind.face("S7")


def test_faces_have_the_numbers_of_abaqus():
    # of the manual, there seen from inside: the same nodes in another order
    for name, faces in {
        "C3D10": ("1235 6 7", "1425 9 8", "2436 9 10", "3417 8 10"),
        "C3D15": ("1237 8 9", "45610 11 12"),
        "C3D20": ("12349 10 11 12", "567813 14 15 16", "12569 13 17 18"),
    }.items():
        kind = KINDS[name]
        for i, text in enumerate(faces):
            corners = FACE_FUNCTIONS[len(kind.faces[i])].corner.shape[0]
            numbers = [*text[:corners], *text[corners:].split()]
            assert sorted(kind.faces[i] + 1) == sorted(map(int, numbers)), name
    sides = [{1, 2, 5, 4, 7, 14, 10, 13}, {2, 3, 6, 5, 8, 15, 11, 14}, {3, 1, 4, 6, 9, 13, 12, 15}]
    assert [set((KINDS["C3D15"].faces[i] + 1).tolist()) for i in (2, 3, 4)] == sides


@every_kind
def test_six_rigid_modes_and_no_others(name):
    # a reduced quadratic brick, and a wedge of two points, have others alone but not together
    node, block = box_of(name, (2, 2, 2), material=UNIT, amount=0.2)
    K, _ = assemble(node, [block])
    stiffness = np.linalg.eigvalsh(K.toarray())
    np.testing.assert_allclose(K @ rigid_motions(node), 0, atol=1e-14)
    assert np.sum(stiffness < 1e-12) == 6
    assert stiffness[6] > 1e-5


@every_kind
def test_stiffness_turns_with_the_element(name):
    x = curved(KINDS[name])
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    T = np.kron(np.eye(x.shape[1]), turn)
    (K, M), (K_turned, M_turned) = (
        element_matrices(KINDS[name], each, UNIT) for each in (x, x @ turn.T)
    )
    np.testing.assert_allclose(K_turned[0], T @ K[0] @ T.T, atol=1e-13)
    np.testing.assert_allclose(M_turned, M, atol=1e-14)


@every_kind
def test_patch_test_on_a_distorted_mesh(name):
    node, block = box_of(name, (3, 3, 3), material=UNIT, amount=0.15)
    inside = np.all((node > 0) & (node < 1), axis=1)
    K, _ = assemble(node, [block])
    gradient = np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.4], [0.1, 0.6, 0.9]])
    exact = node @ gradient.T
    free = np.repeat(inside, 3)
    u = np.where(free, 0.0, exact.ravel())
    u[free] = spsolve(K[free][:, free], -(K @ u)[free])
    # constant strain is met to rounding, whatever the shape of the elements
    np.testing.assert_allclose(u.reshape(-1, 3), exact, atol=1e-13)


@every_kind
def test_mass_and_moments_of_inertia(name):
    size = np.array([1.0, 0.7, 0.4])
    node, block = box_of(name, (2, 3, 2), size, amount=0.15)
    exact = 7850.0 * np.prod(size)
    for rule in ("consistent", "reduced"):
        M = assemble(node, [block], ElementOptions(mass_rule=rule))[1]
        if rule == "consistent" or name != "C3D8R":
            # one point in the middle sees no part of the volume of a skewed brick
            assert M.sum() / 3 == pytest.approx(exact, rel=1e-12)
    assert mass(node, [block]) == pytest.approx(exact, rel=1e-12)
    assert volume(node, [block]) == pytest.approx(np.prod(size), rel=1e-12)
    # of straight elements products of linear displacements are exact too
    node, block = box_of(name, (2, 3, 2), size)
    M = assemble(node, [block])[1]
    for axis in range(3):
        u = np.zeros((len(node), 3))
        u[:, axis] = node[:, 0]
        assert u.ravel() @ M @ u.ravel() == pytest.approx(exact / 3, rel=1e-12)


@every_kind
def test_volume_of_curved_elements(name):
    kind = KINDS[name]
    x = curved(kind)
    rule = {4: "TETRAHEDRON_15_POINTS", 6: "WEDGE_21_POINTS", 8: "HEXAHEDRON_27_POINTS"}
    point, weight = getattr(parent_elements, rule[kind.corners])
    J = np.einsum("qia,ak->qik", kind.functions.slopes(point), x[0])
    assert element_volumes(kind, x)[0] == pytest.approx(weight @ np.linalg.det(J), rel=1e-13)
    M = element_matrices(kind, x, UNIT)[1]
    assert M.sum() == pytest.approx(element_volumes(kind, x)[0], rel=1e-13)


def first_frequency(name, divisions):
    """Of a box between frictionless walls, over the exact one.

    Its first mode is ``u_x = sin(pi x / a) cos(pi y / b)``, u_y such that its volume stays:
    shear waves of the wave numbers pi / a and pi / b.
    """
    size = np.array([1.0, 1.1, 0.3])
    node, block = box_of(name, divisions, size, UNIT)
    # of C3D8R such that errors of stiffness and mass do not cancel
    K, M = assemble(node, [block], ElementOptions(hourglass_factor=0.0125))
    free = ~np.any([node == 0, np.isclose(node, size)], axis=0).ravel()
    K, M = K[free][:, free], M[free][:, free]
    exact = 1 / 2.6 * np.pi**2 * np.sum(1 / size[:2] ** 2)
    # of a coarse mesh hourglass modes may lie below
    squared = eigsh(K, k=1, M=M, sigma=exact, v0=np.ones(free.sum()))[0][0]
    return np.sqrt(squared / exact)


@every_kind
def test_frequencies_converge_with_twice_the_order_of_the_elements(name):
    order, count = (2, 8) if name in LINEAR else (4, 4)
    error = [abs(first_frequency(name, (n, n, 1)) - 1) for n in (count, 2 * count)]
    rate = np.log2(error[0] / error[1])
    # Gauss points of a regular mesh are points of superconvergence
    assert rate > 7 if name == "C3D20R" else rate == pytest.approx(order, abs=0.25)
    assert error[1] < (0.011 if name in LINEAR else 3e-4)


def test_incompatible_modes_are_those_of_the_brick_of_bars():
    x = curved(KINDS["C3D8I"])
    K, M = element_matrices(KINDS["C3D8I"], x, STEEL)
    D = elasticity.elasticity_matrix(STEEL.youngs_modulus, STEEL.poissons_ratio)
    scale = abs(K).max()
    np.testing.assert_allclose(K / scale, elasticity.element_stiffness(x, D) / scale, atol=1e-14)
    np.testing.assert_allclose(M, elasticity.element_mass(x, STEEL.density), rtol=1e-13)


def test_hourglass_modes_get_a_stiffness_and_linear_displacements_none():
    kind, x = KINDS["C3D8R"], curved(KINDS["C3D8R"])
    (K, _), (K_stiffer, _) = (
        element_matrices(kind, x, UNIT, ElementOptions(hourglass_factor=c))
        for c in (0.00125, 0.0025)
    )
    added = (K_stiffer - K)[0]
    linear = np.concatenate([np.ones((8, 1)), x[0]], axis=1)
    np.testing.assert_allclose(added @ np.kron(linear, np.eye(3)), 0, atol=1e-15)
    assert np.sum(np.linalg.eigvalsh(added) > 1e-6) == 12
    # what is left without it knows the mean strain alone
    one = np.linalg.eigvalsh((2 * K - K_stiffer)[0])
    assert np.sum(abs(one) < 1e-14) == 18


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("name", ["C3D4", "C3D6", "C3D8", "C3D10", "C3D15", "C3D20", "C3D20R"])
def test_matrices_equal_those_of_calculix_entry_by_entry(name, tmp_path):
    node, block = box_of(name, (2, 2, 2), (1.0, 0.8, 0.7), amount=0.15)
    # no straight line is left
    node = np.round(node + 0.02 * np.sin(3 * node[:, [1, 2, 0]]), 10)
    others = matrices_of_calculix(node, block, tmp_path)
    matrices = assemble(node, [block], ElementOptions(mass_rule="reduced"))
    for own, other in zip(matrices, others, strict=True):
        # CalculiX writes 14 digits
        assert abs(own - other).max() < 1e-12 * abs(other).max()
    consistent = assemble(node, [block])[1]
    same = abs(consistent - others[1]).max() < 1e-12 * abs(others[1]).max()
    assert same == (name in ("C3D8", "C3D20"))


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("poissons_ratio", [0.1, 0.3])
def test_uniform_strain_equals_that_of_calculix_in_regular_meshes(poissons_ratio, tmp_path):
    # of skewed bricks it takes the strain of the middle, not the mean, and other hourglass modes
    material = IsotropicMaterial(206e9, poissons_ratio, 7850.0)
    node, block = box_of("C3D8R", (2, 3, 2), (1.0, 0.8, 0.7), material)
    # its stiffness of hourglass modes goes with Young's modulus
    options = ElementOptions("reduced", 0.001 * (1 + poissons_ratio))
    others = matrices_of_calculix(node, block, tmp_path)
    for own, other in zip(assemble(node, [block], options), others, strict=True):
        assert abs(own - other).max() < 1e-12 * abs(other).max()


@pytest.mark.usefixtures("installed")
def test_frequencies_with_incompatible_modes_are_near_those_of_calculix(tmp_path):
    node, block = box_of("C3D8I", (6, 2, 2), (1.0, 0.2, 0.2), amount=0.1)
    others = [each.toarray() for each in matrices_of_calculix(node, block, tmp_path)]
    own = [each.toarray() for each in assemble(node, [block])]
    free = np.repeat(node[:, 0] > 0, 3)
    internal = np.arange(len(others[0])) >= free.size
    kept = np.flatnonzero(np.concatenate([free, internal[free.size :]]))
    # internal unknowns have no mass: their motion follows by statics
    inside, outside = kept[kept >= free.size], kept[kept < free.size]
    K = others[0]
    condensed = K[np.ix_(outside, outside)] - K[np.ix_(outside, inside)] @ np.linalg.solve(
        K[np.ix_(inside, inside)], K[np.ix_(inside, outside)]
    )
    theirs = eigh(condensed, others[1][np.ix_(outside, outside)], eigvals_only=True)[:6]
    ours = eigh(*(each[np.ix_(outside, outside)] for each in own), eigvals_only=True)[:6]
    np.testing.assert_allclose(np.sqrt(ours / theirs), 1, atol=1e-3)


@every_kind
def test_pieces_of_blocks_and_blocks_of_kinds_are_the_same_body(name, monkeypatch):
    node, block = box_of(name, (3, 2, 2), amount=0.1)
    half = len(block.connectivity) // 2
    E = np.full(len(block.connectivity), 206e9)
    parts = [
        ElementBlock(block.kind, block.connectivity[own], IsotropicMaterial(E[own], 0.3, 7850.0))
        for own in (slice(0, half), slice(half, None))
    ]
    whole = assemble(node, [block])
    monkeypatch.setattr("boltjoint.structure.elements.assembly._ENTRIES", 5 * 9 * 64)
    for one, other in zip(whole, assemble(node, parts), strict=True):
        assert abs(one - other).max() < 1e-14 * abs(one).max()
        assert abs(one - one.T).max() == 0


def test_an_inverted_element_is_named_by_its_number_and_place():
    node, block = box_of("C3D8", (2, 1, 1), amount=0.0)
    turned = block.connectivity.copy()
    turned[1] = turned[1][[4, 5, 6, 7, 0, 1, 2, 3]]
    wrong = ElementBlock(block.kind, turned, STEEL, label=np.array([17, 42]))
    with pytest.raises(ValueError, match=r"1 elements C3D8 are turned .* 42 at \(0.75, 0.5, 0.5\)"):
        assemble(node, [wrong])
    assert (smallest_jacobian(block.kind, node[turned]) > 0).tolist() == [True, False]


def test_a_collapsed_brick_is_folded_at_corners_alone():
    node, block = box_of("C3D8", (1, 1, 1))
    collapsed = block.connectivity[:, [0, 1, 2, 2, 4, 5, 6, 6]]
    assert smallest_jacobian(block.kind, node[collapsed])[0] > 0
    assert smallest_jacobian(block.kind, node[collapsed], at_corners=True)[0] <= 0
    wedge = box_of("C3D6", (1, 1, 1))[1].connectivity[:1]
    assert element_volumes(KINDS["C3D6"], node[wedge])[0] == pytest.approx(
        element_volumes(block.kind, node[collapsed])[0]
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"connectivity": np.zeros((1, 4), int)}, "connectivity has shape"),
        ({"material": IsotropicMaterial(-1.0, 0.3, 1.0)}, "youngs_modulus"),
        ({"material": IsotropicMaterial(1.0, 0.5, 1.0)}, "poissons_ratio"),
        ({"material": IsotropicMaterial(1.0, 0.3, np.ones(3))}, "density has shape"),
        ({"label": np.arange(3)}, "label has shape"),
        ({"kind": "C3D8"}, "kind is of type str"),
    ],
)
def test_wrong_blocks_are_refused(change, message):
    valid = {"kind": KINDS["C3D8"], "connectivity": np.arange(8)[None], "material": STEEL}
    with pytest.raises(ValueError, match=message):
        ElementBlock(**valid | change)


def test_wrong_bodies_are_refused():
    node, block = box_of("C3D8", (1, 1, 1))
    with pytest.raises(ValueError, match=r"connectivity of blocks\[0\]"):
        assemble(node[:7], [block])
    with pytest.raises(ValueError, match="blocks are empty"):
        assemble(node, [])
    with pytest.raises(ValueError, match="mass_rule 'lumped' is not known"):
        ElementOptions(mass_rule="lumped")
    with pytest.raises(ValueError, match="hourglass_factor"):
        ElementOptions(hourglass_factor=0.0)


@pytest.mark.parametrize("divisions", [(6, 5, 3), (6, 2, 5), (1, 6, 6), (4, 4, 4)])
def test_layers_through_the_thickness(divisions):
    node, block = box_of("C3D8R", divisions)
    # corners in any order that turns around as they do
    turned = block.connectivity.copy()
    turned[::2] = turned[::2][:, [1, 5, 6, 2, 0, 4, 7, 3]]
    blocks = [ElementBlock(block.kind, turned, STEEL)]
    assert (smallest_jacobian(block.kind, node[turned]) > 0).all()
    assert set(brick_layers(blocks)) == {min(LAYERS, *divisions)}
    told = element_warnings(blocks)
    assert len(told) == (min(divisions) < LAYERS)
    if told:
        fewest = min(divisions)
        assert told[0].startswith(
            f"100% of {len(turned)} elements C3D8R lie in fewer than 4 layers"
        )
        assert f"down to {fewest}:" in told[0]


def test_layers_go_on_in_elements_of_other_kinds():
    _, block = box_of("C3D8R", (8, 8, 4))
    upper = block.connectivity.reshape(8, 8, 4, 8)[:, :, 2:].reshape(-1, 8)
    lower = block.connectivity.reshape(8, 8, 4, 8)[:, :, :2].reshape(-1, 8)
    bricks = ElementBlock(KINDS["C3D8R"], lower, STEEL)
    assert set(brick_layers([bricks])) == {2}
    assert set(brick_layers([bricks, ElementBlock(KINDS["C3D8I"], upper, STEEL)])) == {4}
    assert brick_layers([ElementBlock(KINDS["C3D8I"], upper, STEEL)]).size == 0


def test_tetrahedra_of_four_nodes_are_told():
    assert element_warnings([box_of("C3D4", (2, 2, 2))[1]])[0].startswith("48 elements C3D4: ")
    for name in ("C3D8I", "C3D10", "C3D20R"):
        assert element_warnings([box_of(name, (2, 1, 1))[1]]) == []
