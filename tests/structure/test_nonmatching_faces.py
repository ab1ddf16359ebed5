"""Contact points by segments: patch tests, curved surfaces, pairs of nodes as a case of them."""

from dataclasses import replace

import numpy as np
import pytest
from decks import public
from element_meshes import box_of, faces_where
from scipy import sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.elements import parent_elements
from boltjoint.structure.elements.assembly import ElementBlock, assemble
from boltjoint.structure.elements.kinds import FACE_FUNCTIONS, FACES_OF_HEXAHEDRON, KINDS
from boltjoint.structure.elements.matrices import IsotropicMaterial
from boltjoint.structure.makers.deck.content import Reference
from boltjoint.structure.makers.deck.lines import Place
from boltjoint.structure.makers.deck.reader import read_deck
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.nonmatching_faces.overlap import clip_polygons, polygon_areas
from boltjoint.structure.nonmatching_faces.weighted_points import weighted_points
from boltjoint.structure.preload import apply_preload

LINEAR = ("C3D4", "C3D6", "C3D8", "C3D8I", "C3D8R")
SOFT = IsotropicMaterial(1.0, 0.0, 1.0)
TURN = Rotation.from_euler("y", 45, degrees=True).as_matrix()


def on_plane(axis, value):
    return lambda x: np.isclose(x[..., axis], value)


class Blocks:
    """Two cubes, one upon the other, of meshes that need not match."""

    def __init__(self, names, divisions, distortion=0.0):
        self.node, self.blocks = np.zeros((0, 3)), []
        for level, (name, count) in enumerate(zip(names, divisions, strict=True)):
            node, block = box_of(name, (count, count, 1), material=SOFT)
            x, y = node[:, :2].T
            wave = np.sin(np.pi * x) * np.sin(np.pi * y)
            node[:, :2] += distortion / count * wave[:, None] * np.stack([y + 0.3, -x], 1)
            connectivity = block.connectivity + len(self.node)
            self.blocks.append(ElementBlock(block.kind, connectivity, SOFT))
            self.node = np.concatenate([self.node, node + np.array([0, 0, level])])
        self.sides = [faces_where(self.node, each, on_plane(2, 1.0)) for each in self.blocks]

    def points(self, **options):
        return weighted_points(self.node, *self.sides, [1.0, 0.0, 0.0], **options)


def tractions_under_pressure(blocks, turn, stiffness, **options):
    """Normal tractions where the upper cube is pressed on the lower one by a pressure of one."""
    turned = blocks.node @ turn.T
    points = weighted_points(turned, *blocks.sides, turn[:, 0], **options)
    K, _ = assemble(turned, blocks.blocks)
    normal = points.contact_points().relative[2::3]
    K = K + normal.T @ sparse.diags_array(stiffness * points.area) @ normal
    force = np.zeros(blocks.node.shape)
    for nodes in faces_where(blocks.node, blocks.blocks[1], on_plane(2, 2.0)):
        functions = FACE_FUNCTIONS[nodes.shape[1]]
        rule = (
            parent_elements.TRIANGLE_7_POINTS
            if len(functions.corner) == 3
            else parent_elements.gauss(3, 2)
        )
        slopes = np.einsum("qia,fak->fqik", functions.slopes(rule.point), blocks.node[nodes])
        area = np.cross(slopes[:, :, 0], slopes[:, :, 1]) * rule.weight[:, None]
        on_nodes = np.einsum("fqk,qa->fak", area, functions.values(rule.point))
        np.add.at(force, nodes, -on_nodes)
    # sides slide on walls
    held = np.isclose(blocks.node, 0.0)
    free = ~held.ravel()
    T = sparse.kron(sparse.eye_array(len(blocks.node)), turn)
    K = (T.T @ K @ T).tocsc()
    u = np.zeros(free.size)
    u[free] = spsolve(K[free][:, free], force.ravel()[free])
    return points, stiffness * (normal @ (T @ u))


#: kinds of elements, kinds of points that their faces have, and meshes; of fine ones one of a face
PATCHES = [
    (name, weighting, divisions)
    for name in KINDS
    for weighting in (("face", "dual") if name in LINEAR else ("face",))
    for divisions in ((2, 3), (3, 2), (8, 12))
    if divisions != (8, 12) or name in ("C3D4", "C3D8", "C3D10", "C3D20")
]


@pytest.mark.parametrize(("name", "weighting", "divisions"), PATCHES)
@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["flat", "at 45 degrees"])
def test_patch_test_of_contact(name, weighting, divisions, turn):
    blocks = Blocks((name, name), divisions)
    points, pressure = tractions_under_pressure(blocks, turn, 100.0, weighting=weighting)
    np.testing.assert_allclose(pressure, 1, atol=1e-10)
    assert pressure @ points.area == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize(
    "names", [("C3D8", "C3D4"), ("C3D10", "C3D8"), ("C3D6", "C3D20"), ("C3D20", "C3D10")]
)
def test_patch_test_between_kinds_of_faces(names):
    points, pressure = tractions_under_pressure(Blocks(names, (3, 4)), TURN, 1e3)
    np.testing.assert_allclose(pressure, 1, atol=1e-10)
    assert pressure @ points.area == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("weighting", ["face", "dual"])
def test_patch_test_on_distorted_faces(weighting):
    blocks = Blocks(("C3D8", "C3D8"), (4, 6), distortion=0.6)
    points, pressure = tractions_under_pressure(blocks, TURN, 100.0, weighting=weighting)
    # places on faces without parallel edges are roots, not polynomials: their integrals are nearly
    # exact
    np.testing.assert_allclose(pressure, 1, atol=2e-10)
    assert pressure @ points.area == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("divisions", [(3, 3), (2, 3)])
def test_rigid_motion_opens_nothing_and_forces_are_in_equilibrium(name, divisions):
    blocks = Blocks((name, name), divisions)
    points = blocks.points()
    rigid = [np.broadcast_to(axis, blocks.node.shape) for axis in np.eye(3)]
    rigid += [np.cross(axis, blocks.node) for axis in np.eye(3)]
    for motion in rigid:
        np.testing.assert_allclose(points.rows @ motion, 0, atol=1e-14)
    assert points.area.sum() == pytest.approx(1, rel=1e-12)
    assert not points.gap.any()
    assert len(points.area) == sum(len(each) for each in blocks.sides[0])
    np.testing.assert_array_equal(points.frame, np.broadcast_to(np.eye(3), points.frame.shape))


@pytest.mark.parametrize("name", LINEAR)
def test_dual_points_of_coincident_faces_are_pairs_of_nodes(name):
    blocks = Blocks((name, name), (4, 4))
    points = blocks.points(weighting="dual")
    lower, upper = (np.unique(np.concatenate([f.ravel() for f in s])) for s in blocks.sides)
    rows = np.zeros((len(lower), len(blocks.node)))
    partner = [
        upper[np.argmin(np.sum((blocks.node[upper] - x) ** 2, 1))] for x in blocks.node[lower]
    ]
    rows[np.arange(len(lower)), lower] = 1
    rows[np.arange(len(lower)), partner] = -1
    assert points.rows.nnz == 2 * len(lower)
    np.testing.assert_allclose(points.rows.toarray(), rows, atol=1e-13)
    np.testing.assert_allclose(points.position, blocks.node[lower], atol=1e-14)


def sides_of_lap(assembly):
    """Faces of both bars on the interface."""
    face = assembly["connectivity"].to_numpy()[:, FACES_OF_HEXAHEDRON].reshape(-1, 4)
    on_sides = [np.isin(face, nodes).all(axis=1) for nodes in assembly["pair_node"].to_numpy().T]
    return [[face[on]] for on in on_sides]


def test_dual_points_of_a_lap_are_its_contact_pairs(assembly, structure):
    node, sides = assembly["coordinate"].to_numpy(), sides_of_lap(assembly)
    points = weighted_points(node, *sides, [1, 0, 0], weighting="dual")
    order = np.argsort(assembly["pair_node"].to_numpy()[:, 0])
    own, expected = points.contact_points(structure.geometry.displacement), structure.contact
    scale = np.repeat(np.argsort(order), 3) * 3 + np.tile(np.arange(3), len(order))
    assert own.relative.nnz == expected.relative.nnz
    assert abs(own.relative[scale] - expected.relative).max() < 1e-12
    np.testing.assert_allclose(own.area, expected.area[order], rtol=1e-12)
    np.testing.assert_allclose(own.position, expected.position[order], atol=1e-15)
    np.testing.assert_allclose(own.frame, expected.frame[order], atol=1e-15)
    assert not own.gap.any()


def moved_within_surface(assembly):
    """The same bars, with inner nodes of side A moved by up to a third of their distances."""
    faces, node = sides_of_lap(assembly)[0][0], assembly["coordinate"].to_numpy().copy()
    edges = np.sort(np.concatenate([faces[:, [i - 1, i]] for i in range(4)]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    length = np.full(len(node), np.inf)
    for end in edges.T:
        np.minimum.at(length, end, np.linalg.norm(node[edges[:, 0]] - node[edges[:, 1]], axis=1))
    inner = np.setdiff1d(faces, edges[count == 1])
    way = np.random.default_rng(0).uniform(-1, 1, (len(inner), 2)) / 3
    node[inner, :2] += length[inner, None] * way
    return assembly.assign(coordinate=assembly["coordinate"].copy(data=node))


def loads_on_areas(preload, side=0.01):
    """Normal loads on areas of 1 cm2 that pass into each other, over the largest."""
    x, load = preload["position"].to_numpy(), preload["normal_load"].to_numpy()
    hats = [
        np.maximum(0, 1 - abs(x[:, [axis]] - np.arange(low, high + side / 2, side)) / side)
        for axis, (low, high) in enumerate(((0.09, 0.16), (-0.01, 0.01)))
    ]
    return np.einsum("p,pi,pj->ij", load, *hats)


def test_a_lap_whose_nodes_do_not_match_is_nearly_the_same(assembly, structure, preload):
    moved = moved_within_surface(assembly)
    points = weighted_points(
        moved["coordinate"].to_numpy(), *sides_of_lap(moved), [1, 0, 0], weighting="dual"
    )
    assert len(points.area) == len(structure.contact)
    assert np.diff(points.rows.indptr).max() > 4
    other = structure_of(moved)
    contact = points.contact_points(
        other.geometry.displacement,
        penalty=structure.contact.penalty[0],
        friction_coefficient=structure.contact.friction_coefficient[0],
    )
    other = replace(other, contact=contact, symmetry=None)
    tightened = apply_preload(other, 8e3)
    assert tightened["normal_load"].sum() == pytest.approx(16e3, rel=1e-9)
    expected = loads_on_areas(preload)
    np.testing.assert_allclose(
        loads_on_areas(tightened), expected, atol=0.02 * expected.max(), rtol=0
    )
    peaks = [
        solve_response(
            connect_nodes(find_modes(each, "free-4"), tight, 1e8, 0.1),
            [2.0, 20.0],
            damping=2e-3,
        )
        for each, tight in ((structure, preload), (other, tightened))
    ]
    for name, tolerance in (("peak_frequency", 2e-3), ("peak_amplitude", 2e-2)):
        np.testing.assert_allclose(*(each[name] for each in peaks), rtol=tolerance)


@pytest.mark.parametrize("weighting", ["face", "dual"])
def test_a_partial_overlap_has_its_own_area_and_gap(weighting):
    blocks = Blocks(("C3D8", "C3D8"), (3, 4))
    upper = blocks.blocks[1].connectivity
    is_upper = np.isin(np.arange(len(blocks.node)), upper)
    node = blocks.node + np.outer(is_upper, [0.45, 0.0, 0.01])
    points = weighted_points(node, *blocks.sides, [1, 0, 0], weighting=weighting)
    assert points.area.sum() == pytest.approx(0.55, rel=1e-12)
    assert points.area.min() > 0
    np.testing.assert_allclose(points.gap, 0.01, rtol=1e-9)
    np.testing.assert_allclose(points.rows.sum(axis=1), 0, atol=1e-13)
    # no point reaches beyond its faces by more than a few times their motion
    assert abs(points.rows.data).max() < 5
    with pytest.raises(ValueError, match="the surfaces do not meet"):
        weighted_points(node, *blocks.sides, [1, 0, 0], largest_gap=0.005)
    closed = weighted_points(
        blocks.node - np.outer(is_upper, [0, 0, 1e-3]), *blocks.sides, [1, 0, 0]
    )
    np.testing.assert_allclose(closed.gap, -1e-3, rtol=1e-9)
    assert not closed.contact_points().gap.any()


def test_a_sliver_of_a_face_moves_with_it():
    blocks = Blocks(("C3D8", "C3D8"), (2, 2))
    is_upper = np.isin(np.arange(len(blocks.node)), blocks.blocks[1].connectivity)
    node = blocks.node + np.outer(is_upper, [0.495, 0.495, 0.0])
    points = weighted_points(node, *blocks.sides, [1, 0, 0], weighting="dual")
    assert points.area.sum() == pytest.approx(0.505**2, rel=1e-12)
    assert abs(points.rows.data).max() < 2


def ring(name, divisions, radii, length=0.5):
    """Nodes and elements of a closed ring around z."""
    box, block = box_of(name, divisions)
    angle, radius = -2 * np.pi * box[:, 0], radii[0] + (radii[1] - radii[0]) * box[:, 1]
    node = np.stack([radius * np.cos(angle), radius * np.sin(angle), length * box[:, 2]], axis=1)
    _, first, merged = np.unique(np.round(node, 9), axis=0, return_index=True, return_inverse=True)
    return node[first], ElementBlock(block.kind, merged.ravel()[block.connectivity], SOFT)


@pytest.mark.parametrize(
    ("weighting", "names", "counts"),
    [
        ("face", ("C3D8", "C3D8"), (24, 24)),
        ("dual", ("C3D8", "C3D8"), (24, 24)),
        ("face", ("C3D8", "C3D4"), (24, 36)),
        ("dual", ("C3D8", "C3D4"), (24, 36)),
        ("dual", ("C3D6", "C3D15"), (36, 24)),
        ("face", ("C3D20", "C3D20"), (16, 24)),
        ("face", ("C3D10", "C3D20"), (24, 16)),
    ],
)
def test_pressure_in_a_closed_ring_is_in_equilibrium(weighting, names, counts):
    inner, block = ring(names[0], (counts[0], 1, 2), (0.8, 1.0))
    outer, other = ring(names[1], (counts[1], 1, 3), (1.0, 1.2))
    node = np.concatenate([inner, outer])
    around = lambda x: np.isclose(np.hypot(x[..., 0], x[..., 1]), 1.0)  # noqa: E731
    sides = [
        faces_where(inner, block, around),
        [each + len(inner) for each in faces_where(outer, other, around)],
    ]
    points = weighted_points(node, *sides, [0, 0, 1], weighting=weighting)
    force = points.rows.T @ (points.area[:, None] * points.frame[:, 2])
    for own in (slice(0, len(inner)), slice(len(inner), None)):
        np.testing.assert_allclose(force[own].sum(axis=0), 0, atol=1e-10)
        np.testing.assert_allclose(np.cross(node[own], force[own]).sum(axis=0), 0, atol=1e-10)
        # and pressure is what it is
        radial = np.sum(force[own] * node[own], axis=1)[np.hypot(*node[own, :2].T) > 0.9].sum()
        assert abs(radial) == pytest.approx(np.pi, rel=0.012)
    chord = np.cos(np.pi / counts[0])
    if names[0] in LINEAR:
        sides_of_polygon = 2 * counts[0] * np.sin(np.pi / counts[0]) * 0.5
        assert points.area.sum() == pytest.approx(sides_of_polygon, rel=1e-10)
        assert abs(points.gap).max() < 1 - chord
        normal = points.position[:, :2] / np.linalg.norm(points.position[:, :2], axis=1)[:, None]
        np.testing.assert_allclose(points.frame[:, 2, :2], normal, atol=1e-10)
    else:
        # arcs of parabolas
        assert points.area.sum() == pytest.approx(np.pi, rel=5e-5)
        assert abs(points.gap).max() < 1e-4


def surface_of(deck, name):
    """Faces of a surface of bricks."""
    elements = deck.elements[0]
    where = {place: row for row, place in enumerate(elements.place.tolist())}
    faces = []
    for piece in deck.surface(Reference(name, "", Place("test", 0))).pieces:
        for place in deck.elements_of(piece.reference).tolist():
            faces.append(elements.node[where[place]][KINDS[elements.kind].faces[piece.face - 1]])
    return [np.array(faces)]


@pytest.mark.parametrize("weighting", ["face", "dual"])
def test_telescoping_tubes(weighting):
    deck = read_deck(*public("tubes/solve.inp"))
    sides = [surface_of(deck, name) for name in ("Sdep", "Sind")]
    points = weighted_points(deck.coordinate, *sides, [1, 0, 0], weighting=weighting)
    # 30 % of 900 faces, on the half circle of 18 chords
    assert len(points.area) == {"face": 270, "dual": 304}[weighting]
    assert points.area.sum() == pytest.approx(150 * 2 * 45 * 18 * np.sin(np.pi / 36), rel=1e-9)
    assert not points.gap.any()
    assert set(np.diff(points.rows.indptr)) == {{"face": 8, "dual": 2}[weighting]}
    force = points.rows.T @ (points.area[:, None] * points.frame[:, 2])
    scale = abs(force).sum()
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-10 * scale)
    np.testing.assert_allclose(
        np.cross(deck.coordinate, force).sum(axis=0) / 45, 0, atol=1e-10 * scale
    )
    own = force[np.unique(sides[0][0])].sum(axis=0)
    # the half tube and its mirror image
    np.testing.assert_allclose(own[[0, 2]], 0, atol=1e-10 * scale)
    if weighting == "face":
        assert abs(own[1]) == pytest.approx(150 * 2 * 45, rel=1e-10)


def test_common_parts_of_polygons():
    square = np.array([[[0.0, 0], [2, 0], [2, 2], [0, 2]]])
    triangle = np.array([[[1.0, 1], [3, 1], [1, 3], [1, 3]]])
    for one, other, area in (
        (square, square, 4.0),
        (square, square + 1, 1.0),
        (square, square + np.array([2, 0]), 0.0),
        (square, square + 5, 0.0),
        (square, triangle, 1.0),
        (triangle, square, 1.0),
        (square, 0.5 * square + 0.5, 1.0),
        (0.5 * square + 0.5, square, 1.0),
    ):
        assert polygon_areas(clip_polygons(one, other))[0] == pytest.approx(area, abs=1e-14)
    random = np.random.default_rng(0)
    turn = Rotation.random(50, rng=random).as_matrix()[:, :2, :2]
    # areas of the common part do not depend on which polygon clips
    pairs = square - 1 + random.uniform(-1, 1, (50, 1, 2)), (square - 1) @ turn
    pairs = (
        pairs[0],
        np.where(polygon_areas(pairs[1])[:, None, None] > 0, pairs[1], pairs[1][:, ::-1]),
    )
    np.testing.assert_allclose(
        polygon_areas(clip_polygons(*pairs)), polygon_areas(clip_polygons(*pairs[::-1])), atol=1e-13
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"side_a": []}, "side_a is empty"),
        ({"side_b": [np.zeros((1, 5), int)]}, r"side_b\[0\] has faces of 5 nodes"),
        ({"side_b": [np.full((1, 4), 10**6)]}, r"side_b\[0\]"),
        ({"along": [0, 0, 1]}, r"is normal to the surface at \("),
        ({"along": [0, 0, 0]}, "along is zero"),
        ({"weighting": "node"}, "weighting 'node' is not known; allowed: face, dual"),
        ({"largest_gap": 0.0}, "largest_gap"),
    ],
)
def test_wrong_surfaces_are_refused(change, message):
    blocks = Blocks(("C3D8", "C3D8"), (1, 1))
    valid = {"coordinate": blocks.node, "along": [1, 0, 0]}
    valid |= dict(zip(("side_a", "side_b"), blocks.sides, strict=True))
    with pytest.raises(ValueError, match=message):
        weighted_points(**valid | change)


def test_surfaces_that_look_away_and_dual_points_of_quadratic_faces_are_refused():
    blocks = Blocks(("C3D20", "C3D20"), (1, 1))
    inside_out = [blocks.sides[1][0][:, [0, 3, 2, 1, 7, 6, 5, 4]]]
    with pytest.raises(ValueError, match="look away from each other"):
        weighted_points(blocks.node, blocks.sides[0], inside_out, [1, 0, 0])
    with pytest.raises(ValueError, match="weighting 'dual' is of faces without middle nodes"):
        blocks.points(weighting="dual")
