"""Reading of decks: what each keyword says, and what is refused by file and line."""

import numpy as np
import pytest
from decks import NOT_KEPT, TWO_CUBES, public

from boltjoint.structure.makers.deck.content import Reference
from boltjoint.structure.makers.deck.lines import Place, included_files
from boltjoint.structure.makers.deck.reader import read_deck

AT = Place("test", 0)


@pytest.fixture
def read(tmp_path):
    """The deck of a text, and of files that it includes."""

    def of_text(text, **files):
        (tmp_path / "joint.inp").write_text(text)
        for name, content in files.items():
            (tmp_path / f"{name}.inc").write_text(content)
        return read_deck(tmp_path, "joint.inp")

    return of_text


def nodes(deck, name, scope=""):
    """Numbers of the nodes of a set."""
    return deck.nodes.label[deck.nodes_of(Reference(name, scope, AT))].tolist()


def elements(deck, name, scope=""):
    return deck.numbers.label[deck.elements_of(Reference(name, scope, AT))].tolist()


# nodes, elements by kind, sets of nodes and surfaces of the text, counted by other means
COUNTS = {
    "tubes/solve.inp": (3877, {"C3D8I": 1800}, {"Nfix": 38, "Nysym": 409}, 3),
    "plate_with_hole_3D/plate_with_hole_3D.inp": (27189, {"C3D8R": 23200}, {}, 1),
    "abaqusreader_jl/beam.inp": (298, {"C3D10": 120}, {"SUPPORT": 9}, 0),
    "abaqusreader_jl/tet4.inp": (116, {"C3D4": 264}, {}, 8),
    "abaqusreader_jl/cantilever_beam.inp": (26, {"C3D8": 2, "C3D20R": 1}, {"FIXED_END": 9}, 3),
    f"{NOT_KEPT}/brake_reuss_beam.inp": (
        40657,
        {"C3D8R": 31904},
        {"TOPS_NDS": 686, "BOTS_NDS": 686},
        32,
    ),
    f"{NOT_KEPT}/SB1.inp": (22899, {"C3D8": 19128}, {}, 13),
    f"{NOT_KEPT}/bolt_pret.inp": (16332, {"C3D10": 7886, "DCOUP3D": 2, "B31": 1}, {}, 8),
    f"{NOT_KEPT}/Boltedjoint.inp": (3549, {"C3D8": 2520, "C3D6": 185}, {"Ground": 20}, 7),
    f"{NOT_KEPT}/Bolt_mm.inp": (3872, {"C3D8": 2680, "C3D6": 72}, {"Ground": 40}, 5),
    f"{NOT_KEPT}/jclamp.inp": (13922, {"C3D20": 2368, "C3D15": 118}, {}, 7),
}


@pytest.mark.parametrize("name", COUNTS)
def test_public_decks_are_read_without_an_edit(name):
    count, kinds, sets, surfaces = COUNTS[name]
    deck = read_deck(*public(name))
    assert len(deck.nodes) == count
    assert dict(deck.kinds()) == kinds
    assert {each: len(nodes(deck, each)) for each in sets} == sets
    assert len(deck.surfaces) == surfaces
    # all members exist
    for each in (deck.node_sets, deck.element_sets):
        for members in each.members:
            each.places("", members, AT)


def test_the_brake_reuss_beam_has_its_size_in_the_coordinates_of_the_whole():
    deck = read_deck(*public(f"{NOT_KEPT}/brake_reuss_beam.inp"))
    used = np.unique(np.concatenate([each.node.ravel() for each in deck.elements]))
    size = np.ptp(deck.coordinate[used], axis=0)
    assert used.size == 40651
    assert np.allclose(size, [0.72, 0.0254, 0.0433], atol=2e-4)
    assert (len(deck.ties), len(deck.couplings), len(deck.equations)) == (12, 6, 15)
    # the interface is held within its steps alone
    assert not [each for each in deck.boundaries if each.step == 0]
    assert [each.step for each in deck.boundaries] == [1, 1]


def test_a_deck_of_two_cubes(read):
    deck = read(TWO_CUBES)
    assert len(deck.nodes) == 16
    assert nodes(deck, "all") == deck.nodes.label.tolist()
    assert elements(deck, "Lower") == [1]
    surface = deck.surface(Reference("bottom of upper", "", AT))
    assert [(each.reference.text, each.face) for each in surface.pieces] == [("2", 1)]
    steel = deck.materials["STEEL"]
    assert (steel.youngs_modulus, steel.poissons_ratio, steel.density) == (210e3, 0.3, 7.85e-9)
    assert deck.unused == {}


def test_numbers_of_fortran_missing_values_and_records_over_lines(read):
    deck = read(
        "*Node\n 1, 2.d10, 1.5D+0, -.5d-1\n 2, 1.,\n 3, ,2\n"
        + "".join(f"{i}, {i}., 0., 0.\n" for i in range(4, 24))
        + "*ELEMENT, TYPE=C3D20\n7, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14,\n 15, 16, 17, 18,\n"
        "19, 20, 21, 22, 23\n"
    )
    assert deck.coordinate[:3].tolist() == [[2e10, 1.5, -0.05], [1, 0, 0], [0, 2, 0]]
    assert deck.nodes.label[deck.elements[0].node[0]].tolist() == list(range(4, 24))


def test_sets_of_ranges_names_and_pieces(read):
    deck = read(
        TWO_CUBES + "*NSET, NSET=range, GENERATE\n1, 7, 2\n15, 18\n*NSET, NSET=names, UNSORTED\n"
        "range, 4, 2,\n3\n*nset,nset=Names\n 8\n*ELSET, ELSET=both\nLOWER, UPPER\n"
        "*NSET, NSET=of both, ELSET=both\n** a range may name numbers that are not there\n"
        "*ELSET, ELSET=all, GENERATE\n1, 9\n"
    )
    assert nodes(deck, "Range") == [1, 3, 5, 7, 15, 16, 17, 18]
    assert nodes(deck, "NAMES") == [1, 3, 5, 7, 15, 16, 17, 18, 4, 2, 8]
    assert elements(deck, "both") == elements(deck, "all") == [1, 2]
    assert len(nodes(deck, "of both")) == 16


def test_includes_stand_where_they_are_named(read, tmp_path):
    head, tail = TWO_CUBES.split("*ELASTIC\n")
    modulus, rest = tail.split("\n", 1)
    text = f"{head}*ELASTIC\n*INCLUDE, INPUT=modulus.inc\n{rest}"
    deck = read(text, modulus=f"** a number alone\n{modulus}\n")
    assert deck.materials["STEEL"].youngs_modulus == 210e3
    assert included_files(tmp_path, "joint.inp") == ("joint.inp", "modulus.inc")
    deck = read("*NODE, INPUT=nodes.inc\n*NODE\n2, 1., 1., 1.\n", nodes="1, 2., 3., 4.\n")
    assert deck.coordinate.tolist() == [[2, 3, 4], [1, 1, 1]]


def test_parts_stand_where_their_instances_are(read):
    part = TWO_CUBES.split("*MATERIAL")[0].replace("*HEADING\ntwo cubes\n", "")
    deck = read(
        f"*PART, NAME=cubes\n{part}*SOLID SECTION, ELSET=LOWER, MATERIAL=STEEL\n*END PART\n"
        "*ASSEMBLY, NAME=all\n*INSTANCE, NAME=first, PART=cubes\n*END INSTANCE\n"
        "*INSTANCE, NAME=second, PART=cubes\n10., 0., 0.\n10., 0., 0., 10., 0., 1., 90.\n"
        "*END INSTANCE\n*NSET, NSET=corner, INSTANCE=second\n2\n*NSET, NSET=both\n"
        "first.3, corner\n*ELSET, ELSET=_face, INTERNAL, INSTANCE=second, GENERATE\n1, 1, 1\n"
        "*SURFACE, TYPE=ELEMENT, NAME=face\n_face, S2\n*EQUATION\n2\nfirst.2, 1, 1.\n"
        "second.2, 1, -1.\n*END ASSEMBLY\n"
    )
    assert len(deck.nodes) == 32
    # moved by 10 along x, then a quarter turn about the line x = 10 in the plane xz
    assert np.allclose(
        deck.coordinate[deck.nodes_of(Reference("corner", "", AT))], [[10, 1, 0]], atol=1e-15
    )
    assert deck.nodes.name(deck.nodes_of(Reference("both", "", AT))[0]) == "node FIRST.3"
    assert len(nodes(deck, "second.all")) == 16
    assert elements(deck, "_face") == [1]
    assert len(deck.sections) == 2
    first, second = (deck.node_of(each.node) for each in deck.equations[0].terms)
    assert (first, second) == (1, 17)


def test_systems_of_coordinates(read):
    deck = read(
        "*SYSTEM\n1., 0., 0., 1., 1., 0.\n0., 1., 0.\n*NODE\n1, 1., 2., 3.\n*SYSTEM\n"
        "*NODE, SYSTEM=C\n2, 2., 90., 3.\n"
    )
    # x along the old y, y against the old x
    assert np.allclose(deck.coordinate, [[1 - 2, 1, 3], [0, 2, 3]], atol=1e-15)


def test_constraints_bolts_contact_and_steps(read):
    deck = read(
        TWO_CUBES + "*NODE\n100, .5, .5, 3.\n101, 0., 0., 0.\n"
        "*COUPLING, CONSTRAINT NAME=C, REF NODE=100, SURFACE=BOTTOM OF UPPER\n*KINEMATIC\n1, 3\n"
        "*COUPLING, CONSTRAINT NAME=D, REF NODE=100, SURFACE=TOP OF LOWER\n*DISTRIBUTING\n"
        "*TIE, NAME=glue, POSITION TOLERANCE=.1\nBOTTOM OF UPPER, TOP OF LOWER\n"
        "*EQUATION\n2\n100, 1, 1., 101, 1, -1.\n3\n1, 1, 1., 2, 1, 1.,\n3, 1, -2.\n"
        "*PRE-TENSION SECTION, NODE=101, SURFACE=BOTTOM OF UPPER\n0., 0., 1.\n"
        "*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1.E6,\n"
        "*FRICTION\n.2, 1.E5\n*CONTACT PAIR, INTERACTION=I\nBOTTOM OF UPPER, TOP OF LOWER\n"
        "*BOUNDARY\n1, 1, 3\n2, ENCASTRE\n4, 2,, 0.\n*STEP\n*STATIC\n*CLOAD\n101, 1, 5.E3\n"
        "*BOUNDARY\n100, 3, 3, 1.\n*END STEP\n"
    )
    assert [(each.kind, each.dofs) for each in deck.couplings] == [
        ("kinematic", (1, 2, 3)),
        ("distributing", (1, 2, 3, 4, 5, 6)),
    ]
    assert deck.ties[0].tolerance == 0.1
    assert [len(each.terms) for each in deck.equations] == [2, 3]
    assert deck.pretension[0].normal == (0, 0, 1)
    assert (deck.interactions["I"].stiffness, deck.interactions["I"].friction_coefficient) == (
        1e6,
        0.2,
    )
    assert [(each.step, each.first, each.last) for each in deck.boundaries] == [
        (0, 1, 3),
        (0, 1, 6),
        (0, 2, 2),
        (1, 3, 3),
    ]
    assert [(each.step, each.force) for each in deck.loads] == [(1, 5e3)]


def test_what_is_left_out_is_counted(read):
    deck = read(TWO_CUBES + "*EXPANSION\n1E-5\n*AMPLITUDE, NAME=A\n0., 1.\n*EXPANSION\n1E-5\n")
    place, count = deck.unused["EXPANSION"]
    assert (count, str(place)) == (2, "joint.inp, line 35")
    assert deck.unused["AMPLITUDE"][1] == 1


#: lines that follow the two cubes, and what is said of them
PAIR, OTHER = "TOP OF LOWER", "BOTTOM OF UPPER"
BAD = {
    "*INCLUDE, INPUT=mesh.msh": "line 35: *INCLUDE: file mesh.msh is missing",
    "*INCLUDE, INPUT=../mesh.msh": "line 35: *INCLUDE: ../mesh.msh must lie in the folder",
    "*INCLUDE, INPUT=joint.inp": "line 35: *INCLUDE: joint.inp includes itself",
    "*ELEMENT, TYPE=S4R\n5, 1, 2, 3, 4": "line 35: *ELEMENT: TYPE=S4R is not read; there are: C3D",
    "*ELEMENT, TYPE=C3D10M\n5, 1": "elements: {C3D10M: C3D10} of the assembly reads it so",
    "*ELEMENT, TYPE=C3D8\n5, 1, 2, 3": "line 36: *ELEMENT: element 5 has 3 nodes instead of 8",
    "*ELEMENT, TYPE=C3D8\n2, 1,2,3,4,5,6,7,8": "line 35: element 2 is there already",
    "*ELEMENT, TYPE=C3D8\n3, 1,2,3,4,5,6,7,99": "line 35: node 99 is not defined",
    "*NODE\n5, 0., 0., 1.5": "line 35: node 5 stands elsewhere at joint.inp, line 3: give",
    "*NODE\n50, 1.0 2.0 3.0": "line 36: *NODE: '1.0 2.0 3.0' is no number: values are apart by",
    "*NODE\n50, 1.e999": "line 36: *NODE: '1.e999' is no finite number",
    "*NODE\n50, 1.E300": "line 35: node 50 lies beyond 1e+12",
    "*NODE\nx, 1.": "line 36: *NODE: 'x' is no whole number",
    "*SHELL SECTION, ELSET=LOWER": "line 35: *SHELL SECTION: shells are not read",
    "*CYCLIC SYMMETRY MODEL, N=3": "line 35: *CYCLIC SYMMETRY MODEL: cyclic symmetry is not",
    "*SUBMODEL": "line 35: *SUBMODEL: submodels are not read",
    "*USER ELEMENT, TYPE=U1": "line 35: *USER ELEMENT: user elements are not read",
    "*MATERIAL, NAME=R\n*HYPERELASTIC": "line 36: *HYPERELASTIC: materials are linear",
    "*MATERIAL, NAME=R\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n1": "TYPE=ENGINEERING CONSTANTS is",
    "*MATERIAL, NAME=R\n*ELASTIC\n": "line 36: *ELASTIC: its data line is missing",
    "*MATERIAL, NAME=R\n*ELASTIC\n-1., .3": "line 37: *ELASTIC: Young's modulus -1 must be",
    "*MATERIAL, NAME=R\n*ELASTIC\n1., .5": "line 37: *ELASTIC: Poisson's ratio 0.5 must lie",
    "*MATERIAL, NAME=R\n*DENSITY\n0.": "line 37: *DENSITY: density 0 must be greater than 0",
    "*SURFACE, NAME=A\nLOWER, S9": "line 36: *SURFACE: face S9 is not read: S1 to S6",
    "*SURFACE, NAME=A, TYPE=CYLINDER": "line 35: *SURFACE: TYPE=CYLINDER is not read",
    "*EQUATION\n2\n1, 1, 1.": "line 36: *EQUATION: has fewer than 2 terms",
    "*EQUATION\n1\n1, 7, 1.": "line 37: *EQUATION: displacement 7 is not read: 1 to 6",
    "*EQUATION\nALL\n1, 1, 1.": "line 36: *EQUATION: 'ALL' is no whole number",
    "*BOUNDARY\n1": "line 36: *BOUNDARY: '' is no whole number",
    "*BOUNDARY\n1, XASYMM": "line 36: *BOUNDARY: 'XASYMM' is no whole number",
    "*TIE, NAME=A\nTOP OF LOWER": "line 36: *TIE: 'TOP OF LOWER' has too few values",
    "*PRE-TENSION SECTION, NODE=1": "SURFACE or ELEMENT must be given, and not both",
    "*TRANSFORM, NSET=ALL\n0., 0., 0., 1., 0., 0.": "line 35: *TRANSFORM: its points lie on a",
    "*NSET, NSET=A, GENERATE\n5, 1": "line 36: *NSET: '5, 1' is no range: first, last, step",
    "*NSET\n1": "line 35: *NSET: NSET is missing",
    "*KINEMATIC\n1": "line 35: *KINEMATIC: no *COUPLING stands before it",
    "*INSTANCE, NAME=A, PART=B": "line 35: *INSTANCE: there is no part B",
    "*COUPLING, REF NODE=1, SURFACE=TOP OF LOWER, ORIENTATION=O\n*KINEMATIC\n1, 2\n": (
        "line 36: *KINEMATIC: ORIENTATION=O of its *COUPLING is not read"
    ),
    f"*CONTACT PAIR, INTERACTION=I\n{PAIR}, {OTHER}\nBottom of Upper, Top of Lower\n": (
        "line 37: *CONTACT PAIR: Bottom of Upper and Top of Lower are a pair at joint.inp, line 36"
    ),
    "*SPRING, ELSET=A\n1, 1\n": "line 35: *SPRING: its second data line, the stiffness, is missing",
    "*SPRING, ELSET=A\n\n30., , 20.\n40., , 100.\n": "line 35: *SPRING: a stiffness that",
    "*SPRING, ELSET=A\n\n": "line 35: *SPRING: its second data line, the stiffness, is missing",
}


@pytest.mark.parametrize("lines", BAD)
def test_what_is_wrong_is_told_by_file_and_line(read, lines):
    with pytest.raises(ValueError) as refused:
        read(TWO_CUBES + lines + "\n")
    assert str(refused.value).startswith("joint.inp, line ")
    assert BAD[lines] in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("lines", "name", "sentence"),
    [
        ("", "NONE", "test: there is no *NSET NONE"),
        ("*NSET, NSET=A\n1, 99\n", "A", "joint.inp, line 35: node 99 is not defined"),
        ("*NSET, NSET=A\nB\n", "A", "line 36: *NSET A: there is no set B"),
        ("*NSET, NSET=A\nB\n*NSET, NSET=B\nA\n", "A", "line 38: *NSET A names itself"),
    ],
)
def test_sets_that_are_wrong_are_told_when_they_are_asked_for(read, lines, name, sentence):
    with pytest.raises(ValueError) as refused:
        nodes(read(TWO_CUBES + lines), name)
    assert sentence in str(refused.value)


def test_a_number_that_two_instances_have_must_say_of_which(read):
    deck = read(
        "*PART, NAME=p\n*NODE\n1, 0.\n2, 1.\n*END PART\n*INSTANCE, NAME=a, PART=p\n*END INSTANCE\n"
        "*INSTANCE, NAME=b, PART=p\n*END INSTANCE\n"
    )
    with pytest.raises(ValueError, match="node 2 is in no instance: instances A, B have one: wri"):
        nodes(deck, "2")


@pytest.mark.parametrize("text", ["", "1, 2., 3.\n", "*HEADING\nonly\n", "** a comment\n"])
def test_files_that_are_no_decks(read, text):
    with pytest.raises(ValueError, match=r"joint\.inp"):
        read(text)


def test_whatever_stands_in_a_deck_it_is_read_or_refused(read):
    rng = np.random.default_rng(5)
    words = (
        '*NODE,*ELEMENT,TYPE=C3D8,1,2.,-3,,NSET=A,*NSET,GENERATE,\n,\n,x,1.d3,S1,*STEP,=,"'.split(
            ","
        )
    )
    lines = (TWO_CUBES + "*TIE\nA, B\n*EQUATION\n1\n1, 1, 1.\n*BOUNDARY\n1, 1\n").splitlines()
    refused = 0
    for _ in range(300):
        changed = list(lines)
        for place in rng.integers(len(lines), size=3):
            changed[place] = ",".join(rng.choice(words, size=rng.integers(1, 5)))
        try:
            read("\n".join(changed))
        except ValueError as error:
            refused += 1
            assert str(error).startswith("joint.inp"), error
    assert 0 < refused < 300
