"""Constraints of decks: ties, couplings, equations, sections of bolts, and what they leave."""

import re

import numpy as np
import pytest
from decks import NOT_KEPT, TWO_CUBES, public
from scipy import sparse
from scipy.linalg import null_space
from scipy.sparse.linalg import eigsh

from boltjoint.structure.elements.kinds import FACE_FUNCTIONS
from boltjoint.structure.elements.matrices import ElementOptions
from boltjoint.structure.makers.deck import beams_springs_masses, constraint_rows, distributing
from boltjoint.structure.makers.deck.assembled import constrain, matrices
from boltjoint.structure.makers.deck.content import Reference
from boltjoint.structure.makers.deck.lines import Place
from boltjoint.structure.makers.deck.mesh import Faces, mesh_of
from boltjoint.structure.makers.deck.projection import motion, project
from boltjoint.structure.makers.deck.reader import read_deck
from boltjoint.structure.makers.deck.unknowns import Rows, eliminate

AT = Place("test", 0)
#: the top of the lower cube and the bottom of the upper one
SURFACES = "TOP OF LOWER", "BOTTOM OF UPPER"
TIE = "*TIE, NAME=glue\nBOTTOM OF UPPER, TOP OF LOWER\n"
REFERENCES = "*NODE\n100, .5, .5, 3.\n101, .5, .5, 3.\n"
COUPLINGS = (
    REFERENCES
    + "*COUPLING, CONSTRAINT NAME=one, REF NODE=100, SURFACE=BOTTOM OF UPPER\n*DISTRIBUTING\n"
    "*COUPLING, CONSTRAINT NAME=other, REF NODE=101, SURFACE=TOP OF LOWER\n*DISTRIBUTING\n"
)
HELD = "*BOUNDARY\n" + "".join(f"{node}, 1, 3\n" for node in (1, 2, 3, 4))


@pytest.fixture
def constrained(tmp_path):
    """The bodies of a text with their constraints."""

    def of_text(text, **options):
        (tmp_path / "joint.inp").write_text(text)
        deck = read_deck(tmp_path, "joint.inp")
        return constrain(mesh_of(deck), boundaries=deck.boundaries, **options)

    return of_text


def zero_modes(assembled):
    """Motions of bodies that constraints allow, and whether the stiffness knows more."""
    motions = constraint_rows.motions_of_bodies(
        assembled.mesh, assembled.unknowns, constraint_rows.bodies(assembled.mesh)
    )
    return constraint_rows.allowed(motions, assembled.rows, assembled.held).shape[1]


def zero_eigenvalues(assembled):
    """Of the stiffness of the free unknowns that elements move."""
    K, _ = matrices(assembled, ElementOptions())
    T = assembled.elimination.transformation
    K = (T.T @ K @ T).toarray()
    K = K[np.ix_(K.diagonal() > 0, K.diagonal() > 0)]
    return int(np.count_nonzero(np.linalg.eigvalsh(K) < 1e-9 * np.diag(K).max()))


def test_constraints_leave_the_null_space_of_their_rows():
    rng = np.random.default_rng(1)
    G = sparse.random_array((12, 40), density=0.15, rng=rng).toarray()
    G[:, :12] += np.eye(12)
    # a chain, a repetition, and rows that prefer an unknown that is taken
    G = np.vstack([G, G[2] + G[3], np.zeros(40)])
    pivot = np.array([*range(8), 0, 1, -1, -1, 5, 6])
    held, kept = np.zeros((2, 40), bool)
    held[[38, 39]], kept[20] = True, True
    found = eliminate([Rows(sparse.csr_array(G), pivot, "rows")], held, kept)
    T = found.transformation.toarray()
    expected = null_space(np.vstack([G, np.eye(40)[held]]))
    assert T.shape == expected.shape
    assert abs(G @ T).max() < 1e-13
    assert np.linalg.matrix_rank(T) == T.shape[1]
    assert 20 in found.free
    assert found.repeated == 1


def test_constraints_in_a_circle_are_refused():
    G = sparse.csr_array(np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]]))
    free = np.zeros(3, bool)
    with pytest.raises(ValueError, match="constraints go in a circle"):
        eliminate([Rows(G, np.array([0, 1]), "ties")], free, free)


@pytest.mark.parametrize("count", [3, 4, 6, 8])
def test_points_move_with_faces_as_rigid_bodies_and_linear_fields_do(count):
    rng = np.random.default_rng(count)
    corner = np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.1]])[
        : 3 if count % 3 == 0 else 4
    ]
    middle = (corner + np.roll(corner, -1, axis=0)) / 2 + [0, 0, 0.03]
    coordinate = np.concatenate([corner, middle])[:count]
    node = np.full((1, 8), -1)
    node[0, :count] = np.arange(count)
    faces = Faces(np.zeros(1, int), np.zeros(1, int), node)
    point = np.array([[0.3, 0.4, 0.2], [0.25, 0.1, -0.1], [-0.2, 0.3, 0.05]])
    found = project(point, faces, coordinate)
    # no other place on the face is nearer
    within = (
        rng.dirichlet(np.ones(3), 4000)[:, :2] if count % 3 == 0 else rng.uniform(-1, 1, (4000, 2))
    )
    others = FACE_FUNCTIONS[count].values(within) @ coordinate
    for place, distance in zip(point[:2], found.distance[:2], strict=True):
        assert np.linalg.norm(others - place, axis=1).min() >= distance * (1 - 1e-12)
    follows, normal = motion(point, found, faces, coordinate)
    turn, shift = rng.standard_normal((2, 3))
    for field in (np.cross(turn, coordinate) + shift,):
        assert np.allclose(
            (follows @ field.ravel()).reshape(-1, 3), np.cross(turn, point) + shift, atol=1e-13
        )
    assert np.allclose(np.linalg.norm(normal, axis=1), 1)


def test_two_cubes_fall_apart_without_a_tie_and_are_one_body_with_it(constrained):
    apart, tied = constrained(TWO_CUBES), constrained(TWO_CUBES + TIE)
    assert zero_modes(apart) == zero_eigenvalues(apart) == 12
    assert zero_modes(tied) == zero_eigenvalues(tied) == 6
    assert tied.ties[0].node.tolist() == [8, 9, 10, 11]
    held = constrained(TWO_CUBES + TIE + HELD)
    assert zero_modes(held) == zero_eigenvalues(held) == 0
    # four nodes held, four others tied
    assert held.elimination.free.size == 3 * 8


def test_slaves_near_the_master_are_moved_onto_it_and_others_keep_their_offset(constrained):
    raised = TWO_CUBES.replace(", 0., 0., 1.\n12,", ", 0., 0., 1.04\n12,")
    tied = constrained(raised + TIE)
    assert tied.mesh.coordinate[8].tolist() == [0, 0, 1]
    assert tied.ties[0].moved == pytest.approx(0.04)
    raised = TWO_CUBES.replace(", 0., 0., 1.\n12,", ", 0., 0., 1.2\n12,")
    far = constrained(raised + TIE, tolerance=0.3)
    assert far.mesh.coordinate[8].tolist() == [0, 0, 1.2]
    assert zero_modes(far) == zero_eigenvalues(far) == 6
    moved = constrained(raised + TIE, tolerance=0.3, adjust="all")
    assert moved.mesh.coordinate[8].tolist() == [0, 0, 1]
    kept = constrained(raised + TIE.replace("glue", "glue, ADJUST=NO"), tolerance=0.3, adjust="all")
    assert kept.mesh.coordinate[8].tolist() == [0, 0, 1.2]
    left = constrained(raised + TIE)
    assert (left.ties[0].apart, len(left.ties[0].node)) == (1, 3)


def test_ties_may_follow_each_other(constrained):
    third = (
        "*NODE\n"
        + "".join(f"{20 + i}, {x}., {y}., {z}.\n" for i, (x, y, z) in enumerate(CORNERS_ABOVE))
        + "*ELEMENT, TYPE=C3D8, ELSET=THIRD\n3, 20, 21, 22, 23, 24, 25, 26, 27\n"
        "*SOLID SECTION, ELSET=THIRD, MATERIAL=STEEL\n*SURFACE, NAME=SIDE OF THIRD\n3, S6\n"
        "*SURFACE, NAME=SIDES\n1, S4\n2, S4\n"
    )
    chained = constrained(TWO_CUBES + third + TIE + "*TIE, NAME=second\nSIDE OF THIRD, SIDES\n")
    assert zero_modes(chained) == zero_eigenvalues(chained) == 6
    # nodes 23 and 27, 20 and 24 of the third follow the upper cube, whose bottom follows the lower
    assert chained.elimination.free.size == 3 * (24 - 4 - 4)


CORNERS_ABOVE = [
    *((1, 0, 1), (2, 0, 1), (2, 1, 1), (1, 1, 1)),
    *((1, 0, 2), (2, 0, 2), (2, 1, 2), (1, 1, 2)),
]


def test_a_mean_moves_as_rigid_bodies_do_and_spreads_forces_that_are_equivalent(constrained):
    coupled = constrained(TWO_CUBES + COUPLINGS)
    unknowns, T = coupled.unknowns, coupled.elimination.transformation
    # both parts are free of each other still
    assert zero_modes(coupled) == 12
    reference = 16
    assert coupled.mesh.coordinate[reference].tolist() == [0.5, 0.5, 3]
    moment = np.array([0.3, -0.7, 1.1])
    force = np.zeros(unknowns.size)
    force[unknowns.translations(np.array(reference))] = [1.0, 2.0, -3.0]
    force[unknowns.rotations(reference)] = moment
    full = np.zeros(unknowns.size)
    full[coupled.elimination.free] = T.T @ force
    spread = full[: 3 * 16].reshape(-1, 3)
    place = coupled.mesh.coordinate[:16]
    assert np.allclose(spread.sum(axis=0), [1, 2, -3], atol=1e-14)
    about = np.cross(place - place[0], spread).sum(axis=0)
    expected = np.cross(np.array([0.5, 0.5, 3.0]) - place[0], [1, 2, -3]) + moment
    assert np.allclose(about, expected, atol=1e-13)
    assert set(np.flatnonzero(abs(spread).sum(axis=1) > 1e-14)) <= {8, 9, 10, 11}


def test_equations_between_reference_nodes_leave_one_motion(constrained):
    equations = "".join(
        f"*EQUATION\n2\n100, {dof}, 1., 101, {dof}, -1.\n" for dof in (1, 2, 4, 5, 6)
    )
    coupled = constrained(TWO_CUBES + COUPLINGS + equations)
    assert zero_modes(coupled) == zero_eigenvalues(coupled) == 7
    repeated = constrained(TWO_CUBES + COUPLINGS + equations + equations)
    assert repeated.elimination.repeated == 5
    assert zero_eigenvalues(repeated) == 7


def test_a_kinematic_coupling_and_a_rigid_body_move_as_one(constrained):
    text = TWO_CUBES + REFERENCES
    surface = constrained(
        f"{text}*COUPLING, REF NODE=100, SURFACE=BOTTOM OF UPPER\n*KINEMATIC\n1, 3\n"
        "*COUPLING, REF NODE=100, SURFACE=TOP OF LOWER\n*KINEMATIC\n"
    )
    whole = constrained(f"{text}*RIGID BODY, ELSET=UPPER, REF NODE=100\n{TIE}")
    for each in (surface, whole):
        assert zero_modes(each) == zero_eigenvalues(each) == 6


def test_transformed_nodes_are_held_along_their_own_directions(constrained):
    held = constrained(
        TWO_CUBES + TIE + "*TRANSFORM, NSET=ALL\n1., 1., 0., -1., 1., 0.\n*BOUNDARY\n1, 2\n"
    )
    T = held.elimination.transformation.toarray()
    # node 1 moves along (1, 1, 0) and z alone
    assert abs(T[0] - T[1]).max() < 1e-15
    assert zero_modes(held) == 5


BAR = 6


def bar(section="", beyond=""):
    """A bar of cubes of the side 1 along x, of which a section may lie in the middle."""
    nodes = [
        f"{4 * i + j + 1}, {i}., {y}., {z}.\n"
        for i in range(BAR + 1)
        for j, (y, z) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)])
    ]
    cubes = [
        f"{i + 1}, " + ", ".join(str(4 * i + j + 1) for j in range(8)) + "\n" for i in range(BAR)
    ]
    return (
        "*NODE, NSET=ALL\n" + "".join(nodes) + f"{4 * BAR + 5}, 0., 0., 0.\n"
        "*ELEMENT, TYPE=C3D8, ELSET=BAR\n" + "".join(cubes) + "*MATERIAL, NAME=M\n*ELASTIC\n"
        "200., 0.\n*DENSITY\n1.\n*SOLID SECTION, ELSET=BAR, MATERIAL=M\n*SURFACE, NAME=MIDDLE\n"
        f"3, S2\n*PRE-TENSION SECTION, SURFACE=MIDDLE, NODE={4 * BAR + 5}\n{section}" + beyond
    )


@pytest.mark.parametrize("normal", ["", "1., 0., 0.\n", "-1., 0., 0.\n"])
def test_a_section_parts_a_bar_that_its_shortening_stretches(constrained, normal):
    ends = "".join(f"{node}, 1, 3\n" for node in (1, 2, 3, 4, *range(4 * BAR + 1, 4 * BAR + 5)))
    parted = constrained(bar(normal, f"*BOUNDARY\n{ends}"))
    cut = parted.cuts[0]
    assert np.allclose(cut.normal, [1, 0, 0])
    assert np.allclose(cut.centre, [3, 0.5, 0.5])
    assert cut.area == pytest.approx(1)
    assert parted.mesh.node_count == 4 * (BAR + 1) + 1 + 4
    K, _ = matrices(parted, ElementOptions())
    T = parted.elimination.transformation
    K = (T.T @ K @ T).tocsc()
    acting = np.flatnonzero(K.diagonal())
    own = parted.elimination.free[acting] == parted.unknowns.shortening(0)
    q = np.linalg.solve(K.toarray()[np.ix_(acting, acting)], own.astype(float))
    # a tension of 1 shortens the shank by L / (E A)
    assert q[own] == pytest.approx(BAR / 200, rel=1e-12)
    u = T[:, acting] @ q
    tension = 200 * (u[3 * 4] - u[0]) / 1.0
    assert tension == pytest.approx(1, rel=1e-12)


def test_a_section_of_a_beam_tightens_two_couplings(constrained):
    ends = "".join(f"{node}, 1, 3\n" for node in (1, 2, 3, 4, 15, 16, 17, 18))
    text = (
        TWO_CUBES + REFERENCES.replace("101, .5, .5, 3.", "101, .5, .5, 1.") + "102, 0., 0., 0.\n"
        "*COUPLING, REF NODE=100, SURFACE=BOTTOM OF UPPER\n*DISTRIBUTING\n"
        "*COUPLING, REF NODE=101, SURFACE=TOP OF LOWER\n*DISTRIBUTING\n"
        "*ELEMENT, TYPE=B31, ELSET=BOLT\n50, 101, 100\n*BEAM SECTION, ELSET=BOLT, MATERIAL=STEEL, "
        "SECTION=CIRC\n.1\n*PRE-TENSION SECTION, ELEMENT=50, NODE=102\n0., 0., 1.\n"
        f"*BOUNDARY\n{ends}"
    )
    bolted = constrained(text)
    K, _ = matrices(bolted, ElementOptions())
    T = bolted.elimination.transformation
    K = (T.T @ K @ T).toarray()
    acting = np.flatnonzero(K.diagonal())
    own = bolted.elimination.free[acting] == bolted.unknowns.shortening(0)
    q = np.linalg.solve(K[np.ix_(acting, acting)], own.astype(float))
    u = T[:, acting] @ q
    pulled = u[bolted.unknowns.translations(np.array([16, 17]))[:, 2]]
    # elongation and shortening of a bar of the length 2 at a tension of 1
    stretch = (pulled[0] - pulled[1] + q[own][0]) * 210e3 * np.pi * 0.01 / 2
    assert stretch == pytest.approx(1, rel=1e-9)
    # the cubes are pulled together
    assert pulled[0] < 0 < pulled[1]


#: two reference nodes joined by a bolt of the length 2, along z
BEAM = (
    TWO_CUBES + "*NODE\n100, .5, .5, 3.\n101, .5, .5, 1.\n102, 0., 0., 0.\n"
    "*COUPLING, REF NODE=100, SURFACE=BOTTOM OF UPPER\n*KINEMATIC\n"
    "*COUPLING, REF NODE=101, SURFACE=TOP OF LOWER\n*KINEMATIC\n"
    "*ELEMENT, TYPE=B31, ELSET=BOLT\n50, 101, 100\n*BEAM SECTION, ELSET=BOLT, MATERIAL=STEEL, "
    "SECTION={section}\n*PRE-TENSION SECTION, ELEMENT=50, NODE=102\n0., 0., 1.\n"
)


@pytest.mark.parametrize(
    ("section", "axis", "area", "moments", "shear_factor"),
    [
        ("CIRC\n.2", (1, 0), 0.04 * np.pi, 2 * [np.pi / 4 * 0.2**4], 0.89),
        ("PIPE\n.2, .1\n0., 1., 0.", (0, 1), 0.03 * np.pi, 2 * [np.pi / 4 * 15e-4], 0.53),
        # widths .4 along the axis that is given and .2 across it
        ("RECT\n.4, .2\n1., 0., 0.", (1, 0), 0.08, [0.2 * 0.4**3 / 12, 0.4 * 0.2**3 / 12], 0.85),
        ("RECT\n.4, .2\n3., 4., 1.", (0.6, 0.8), 0.08, [32e-4 / 3, 8e-4 / 3], 0.85),
    ],
)
def test_a_beam_bends_and_shears_as_its_section_lies(
    constrained, section, axis, area, moments, shear_factor
):
    held = constrained(BEAM.format(section=section))
    E, ratio = held.mesh.deck.materials["STEEL"].elasticity
    K = beams_springs_masses.stiffness(held.beams, held.unknowns, held.mesh, 1.0)
    end = held.mesh.deck.node_of(held.mesh.deck.couplings[0].reference)
    moved = np.concatenate([*held.unknowns.translations([end]), held.unknowns.rotations(end)])
    # of the far end, as the other and the shortening are held
    compliance = np.linalg.inv(K[moved][:, moved].toarray())[:2, :2]
    along = np.array([axis, (-axis[1], axis[0])])
    length, G = 2.0, E / (2 * (1 + ratio))
    bending = length**3 / (3 * E * np.array(moments))
    expected = bending + length / (shear_factor * G * area)
    assert np.allclose(along @ compliance @ along.T, np.diag(expected), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("section", "line"),
    [
        ("RECT\n.4, .2", "*BEAM SECTION: its first axis (0.0, 0.0, -1.0) is along the beam"),
        ("RECT\n.4, .2\n0., 0., 0.", "the first axis of the section has no direction"),
    ],
)
def test_a_section_whose_place_is_not_known_is_refused(constrained, section, line):
    with pytest.raises(ValueError, match=re.escape(line)) as refused:
        constrained(BEAM.format(section=section))
    assert str(refused.value).startswith("joint.inp, line ")


def block_whose_mean_is_held(count, layers=2):
    """A block of some bricks along its edges, of whose top a node that is held has the mean."""
    row, level = count + 1, (count + 1) ** 2
    first = [
        i + row * j + level * k for k in range(layers) for j in range(count) for i in range(count)
    ]
    corners = np.add.outer(first, [0, 1, row + 1, row]) + 1
    place = np.argwhere(np.ones((layers + 1, row, row)))[:, ::-1] / count
    lines = [f"{label}, {x}, {y}, {z}" for label, (x, y, z) in enumerate(place.tolist(), 1)]
    bricks = np.hstack([corners, corners + level]).tolist()
    elements = [", ".join(map(str, (n, *each))) for n, each in enumerate(bricks, 1)]
    return "\n".join(
        [
            "*NODE",
            *lines,
            "90000, .5, .4, .2",
            "*ELEMENT, TYPE=C3D8, ELSET=BLOCK",
            *elements,
            "*ELSET, ELSET=UPPER, GENERATE",
            f"{count**2 * (layers - 1) + 1}, {count**2 * layers}, 1",
            "*SURFACE, NAME=TOP",
            "UPPER, S2",
            "*MATERIAL, NAME=M",
            "*ELASTIC",
            "200., .3",
            "*DENSITY",
            "1.",
            "*SOLID SECTION, ELSET=BLOCK, MATERIAL=M",
            "*COUPLING, REF NODE=90000, SURFACE=TOP",
            "*DISTRIBUTING",
            "*BOUNDARY",
            "90000, 1, 6",
        ]
    )


def test_a_held_mean_of_many_nodes_fills_no_stiffness(constrained, monkeypatch):
    text = block_whose_mean_is_held(22)
    in_groups = constrained(text)
    monkeypatch.setattr(distributing, "MANY", 10**6)
    at_once = constrained(text)
    assert in_groups.unknowns.sums.shape[0] and not at_once.unknowns.sums.shape[0]
    matrices_of = []
    for held in (in_groups, at_once):
        T = held.elimination.transformation
        assert zero_modes(held) == 0
        matrices_of.append([(T.T @ each @ T).tocsc() for each in matrices(held, ElementOptions())])
    # entries of the stiffness, and how many unknowns a node follows from
    assert matrices_of[0][0].nnz < 0.6 * matrices_of[1][0].nnz
    most = [
        np.diff(each.elimination.transformation.tocsr().indptr).max()
        for each in (in_groups, at_once)
    ]
    assert most[0] < 0.25 * most[1]
    # rigid-body motions are those of sums too
    monkeypatch.undo()
    free = constrained(text.replace("*BOUNDARY\n90000, 1, 6", ""))
    assert free.unknowns.sums.shape[0] and zero_modes(free) == 6
    values = [eigsh(K, 6, M, sigma=0, return_eigenvectors=False) for K, M in matrices_of]
    assert np.allclose(*values, rtol=1e-9)


@pytest.mark.parametrize("first", ["\n", "1, 1\n"])
def test_springs_between_nodes_and_masses_of_nodes_are_added(constrained, first):
    added = (
        "*ELEMENT, TYPE=SPRINGA, ELSET=SPRINGS\n50, 1, 7\n*SPRING, ELSET=SPRINGS\n"
        f"{first}30.\n*ELEMENT, TYPE=MASS, ELSET=POINTS\n51, 7\n*MASS, ELSET=POINTS\n2.\n"
    )
    without, those = (constrained(TWO_CUBES + more) for more in ("", added))
    (K, M), (stiffer, heavier) = (matrices(each, ElementOptions()) for each in (without, those))
    ends = np.array([0, 6])  # of a diagonal of the lower cube
    along = np.subtract(*those.mesh.coordinate[ends[::-1]])
    length = np.linalg.norm(along)
    assert length == pytest.approx(np.sqrt(3), rel=1e-12)
    row = np.zeros(K.shape[0])
    row[(3 * ends[:, None] + np.arange(3)).ravel()] = np.concatenate([-along, along]) / length
    np.testing.assert_allclose((stiffer - K).toarray(), 30 * np.outer(row, row), atol=1e-9)
    expected = np.zeros(M.shape)
    expected[18:21, 18:21] = 2 * np.eye(3)
    np.testing.assert_allclose((heavier - M).toarray(), expected, atol=1e-12)


SECTION = "*PRE-TENSION SECTION, SURFACE={}, NODE=1\n"
BAD = {
    TIE + TIE.replace("glue", "again"): "*TIE again: node 11 is a slave of tie glue already",
    TIE.replace("BOTTOM OF UPPER, TOP OF LOWER", "NONE, TOP OF LOWER"): "there is no *SURFACE NONE",
    "*SURFACE, NAME=FAR\n2, S2\n*TIE, NAME=far\nFAR, TOP OF LOWER\n": (
        "line 38: *TIE far: no slave lies within 50 mm of the master: the nearest is 1000 mm"
    ),
    "*SURFACE, NAME=N, TYPE=NODE\nALL\n*TIE, NAME=n\nBOTTOM OF UPPER, N\n": (
        "line 35: *SURFACE N is one of nodes: faces of elements are needed at joint.inp, line 38"
    ),
    "*SURFACE, NAME=NONE\n*TIE, NAME=n\nBOTTOM OF UPPER, NONE\n": "*SURFACE NONE has no faces",
    SECTION.format("TOP OF LOWER"): "has elements on one side only at 1 of 1 faces",
    "*NODE\n100, 0., 0., 0.\n*EQUATION\n2\n100, 4, 1., 1, 1, -1.\n": "node 100 has no rotation 4",
    "*EQUATION\n2\nALL, 1, 1., LOWERS, 1, -1.\n*NSET, NSET=LOWERS\n1, 2\n": (
        "line 36: *EQUATION: its sets have 16, 2 nodes"
    ),
    "*NODE\n100, 0., 0., 0.\n*SURFACE, NAME=LINE, TYPE=NODE\n1\n2\n*COUPLING, REF NODE=100, "
    "SURFACE=LINE\n*DISTRIBUTING\n": "its nodes lie on a line: they have no mean rotation",
    "*NODE\n100, 0., 0., 0.\n101, 1., 0., 0.\n*ELEMENT, TYPE=B31\n9, 100, 101\n": (
        "element 9 (B31) is no bolt"
    ),
}


@pytest.mark.parametrize("lines", BAD)
def test_constraints_that_make_no_sense_are_told_by_file_and_line(constrained, lines):
    with pytest.raises(ValueError) as refused:
        constrained(TWO_CUBES + lines)
    assert str(refused.value).startswith("joint.inp")
    assert BAD[lines] in str(refused.value)


def test_a_cut_that_parts_nothing_is_refused(constrained):
    # two bars side by side, of which the section crosses one
    double = bar().split("*MATERIAL")
    beside = "".join(
        f"{100 + 4 * i + j}, {i}., {y}., {z}.\n"
        for i in range(BAR + 1)
        for j, (y, z) in enumerate([(2, 0), (2, 1)])
    )
    nodes = lambda i: (4 * i + 2, 100 + 4 * i, 100 + 4 * i + 1, 4 * i + 3)  # noqa: E731
    cubes = "".join(
        f"{20 + i}, " + ", ".join(map(str, (*nodes(i), *nodes(i + 1)))) + "\n" for i in range(BAR)
    )
    text = f"{double[0]}*NODE\n{beside}*ELEMENT, TYPE=C3D8, ELSET=BAR\n{cubes}*MATERIAL{double[1]}"
    with pytest.raises(ValueError, match="MIDDLE parts nothing: beside it elements of both sides"):
        constrained(text)


# volume and mass in units of the deck, from their README
SIZES = {
    "tubes/solve.inp": (703275.115, 1.898843e-3),
    "plate_with_hole_3D/plate_with_hole_3D.inp": (1799214.80, None),
    "abaqusreader_jl/beam.inp": (10000.0, None),
    f"{NOT_KEPT}/brake_reuss_beam.inp": (4.71024e-4, 3.67399),
    f"{NOT_KEPT}/SB1.inp": (877932.0, 6.87685e-3),
    f"{NOT_KEPT}/bolt_pret.inp": (2.0514153e-3, 16.1036),
    f"{NOT_KEPT}/Boltedjoint.inp": (299570.0, None),
    f"{NOT_KEPT}/Bolt_mm.inp": (1.0262651e8, None),
    f"{NOT_KEPT}/jclamp.inp": (36.6687, None),
}


@pytest.mark.parametrize("name", SIZES)
def test_public_decks_have_their_volume_and_mass_and_are_closed(name):
    volume, mass = SIZES[name]
    mesh = mesh_of(read_deck(*public(name)))
    # the numbers have six to eight digits
    assert mesh.volume == pytest.approx(volume, rel=2e-6)
    if mass is not None:
        assert sum(
            float(each @ block.material.density)
            for each, block in zip(mesh.volumes, mesh.blocks(1.0, 1.0), strict=True)
        ) == pytest.approx(mass, rel=2e-6)
    faces = mesh.outer_faces
    areas = faces.area_vectors(mesh.coordinate)
    assert abs(areas.sum(axis=0)).max() < 1e-12 * np.linalg.norm(areas, axis=1).sum()
    # normals are outward: the divergence theorem gives the volume
    if all(each.kind.nodes in (4, 8) for each in mesh.solids):
        outward = np.sum(areas * faces.centres(mesh.coordinate)) / 3
        assert outward == pytest.approx(mesh.volume, rel=1e-2)


def test_the_constraints_of_the_brake_reuss_beam():
    deck = read_deck(*public(f"{NOT_KEPT}/brake_reuss_beam.inp"))
    beam = constrain(mesh_of(deck), boundaries=[], tolerance=1e-4)
    assert sum(len(each.node) for each in beam.ties) == 597
    assert sum(each.apart for each in beam.ties) == 96
    assert max(each.moved for each in beam.ties) == pytest.approx(74e-6, rel=0.01)
    T = beam.elimination.transformation
    assert T.shape[1] == 120147
    assert abs(sparse.vstack([each.matrix for each in beam.rows]) @ T).max() < 1e-12
    # six, and the one that parts the bars
    assert zero_modes(beam) == 7


def test_the_section_of_sb1():
    deck = read_deck(*public(f"{NOT_KEPT}/SB1.inp"))
    held = [each for each in deck.boundaries if each.step == 0]
    found = constrain(mesh_of(deck, 1e-3), boundaries=held)
    assert len(found.cuts[0].node) == 97
    assert found.mesh.node_count - len(deck.nodes) == 97
    assert len(mesh_of(deck).faces(Reference("B01-PR", "", AT))) == 84
