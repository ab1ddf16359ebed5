"""Structures of decks: the same as those that are built, their base, and what is refused."""

import re

import numpy as np
import pytest
from deck_of_assembly import deck_of
from decks import TWO_CUBES
from pydantic import ValidationError
from scipy.spatial import cKDTree

from boltjoint.config.deck import Deck
from boltjoint.structure.makers.deck import check, files_of, size_of
from boltjoint.structure.makers.deck.model_check import facts_of
from boltjoint.structure.makers.deck.structure import model_of_deck, structure_of_deck
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.structure.structure_file import structure_from_dataset, structure_to_dataset

MILLIMETRES = {"length": "mm", "mass": "t"}


@pytest.fixture
def described(tmp_path):
    """The description of a text, with other keys."""

    def of_text(text, **keys):
        (tmp_path / "joint.inp").write_text(text)
        given = {"type": "deck", "file": "joint.inp", "units": MILLIMETRES} | keys
        return Deck.model_validate(given).in_folder(tmp_path)

    return of_text


def test_a_lap_in_the_manner_of_abaqus_is_the_one_that_is_built(tiny, described):
    built = structure_of(tiny)
    end = 1e3 * tiny["coordinate"].to_numpy()[tiny["response_node"].item()]
    description = described(
        deck_of(tiny, 8e3),
        elements=[{"kind": "C3D8R", "read_as": "C3D8I"}],
        contact=[{"name": "lap", "surfaces": ["lap_a", "LAP_B"], "points": "nodes"}],
        points=[{"name": "tip", "near_mm": end.tolist(), "direction": "z"}],
    )
    assert list(description.conflicts_of_files()) == []
    model = model_of_deck(description, description.folder)
    structure = model.structure
    assert description.bolt_count == len(structure.bolts) == 2
    assert description.size == size_of(description, description.folder)
    assert description.size.pairs == len(structure.contact) == len(built.contact)
    assert description.has_support
    assert model.loads.tolist() == [8e3, 8e3]
    # as many degrees of freedom: tied nodes are those that are shared where it is built
    assert structure.dofs == built.dofs
    assert structure.mass.sum() == pytest.approx(built.mass.sum(), rel=1e-12)
    for bolt, other in zip(structure.bolts, built.bolts, strict=True):
        assert np.allclose(bolt.axis, other.axis, atol=1e-12)
        assert np.allclose(bolt.position[:2], other.position[:2], atol=1e-12)
        assert bolt.section == pytest.approx(other.section, rel=1e-9)
        assert bolt.youngs_modulus == pytest.approx(other.youngs_modulus, rel=1e-12)
    distance, same = cKDTree(built.contact.position).query(structure.contact.position)
    assert distance.max() < 1e-12
    assert np.allclose(structure.contact.area, built.contact.area[same], rtol=1e-9)
    loads = [apply_preload(each, 8e3) for each in (structure, built)]
    one, other = (each["normal_load"].to_numpy() for each in loads)
    assert abs(one - other[same]).max() < 1e-9 * other.max()
    shortening = [each["shank_shortening"].to_numpy() for each in loads]
    assert np.allclose(*shortening, rtol=1e-9)
    modes, others = find_modes(structure, "all-8"), find_modes(built, "all-8")
    frequency = others["natural_frequency"].to_numpy()
    assert np.allclose(modes["natural_frequency"], frequency, rtol=1e-9)
    response = [abs(each["response_mode"].to_numpy()) for each in (modes, others)]
    assert np.allclose(*response, rtol=1e-7, atol=1e-9 * response[0].max())


def test_a_plane_parts_a_shank_as_its_section_does(described, tiny):
    text = deck_of(tiny, 8e3)
    keys = {
        "elements": [{"kind": "C3D8R", "read_as": "C3D8I"}],
        "contact": [{"name": "lap", "surfaces": ["lap_a", "lap_b"], "points": "nodes"}],
    }
    of_sections = structure_of_deck(described(text, **keys), described(text, **keys).folder)
    # neither sections nor a load that tells a direction
    bare = re.sub(r"\*Pre-tension Section.*\n.*\n", "", text)
    place = 1e3 * tiny["coordinate"].to_numpy()[tiny["section_node"].to_numpy()[:, 0]]
    points = [place[tiny["section_bolt"].to_numpy() == bolt].mean(axis=0) for bolt in range(2)]

    def by_planes(*normal):
        plane = [{"point_mm": point.tolist(), "normal": list(normal)} for point in points]
        bolts = [{"name": f"bolt_{bolt}", "plane": one} for bolt, one in enumerate(plane)]
        return described(bare, bolts=bolts, **keys)

    description = by_planes(0, 0, -2)
    assert list(description.conflicts_of_files()) == []
    assert (description.bolt_names, description.own_preload) == (("bolt_0", "bolt_1"), None)
    of_planes = structure_of_deck(description, description.folder)
    one, other = (apply_preload(each, [8e3, 4e3]) for each in (of_planes, of_sections))
    largest = float(other["normal_load"].max())
    assert float(abs(one["normal_load"] - other["normal_load"]).max()) < 1e-9 * largest
    assert np.allclose(one["shank_shortening"], other["shank_shortening"], rtol=1e-9)
    for bolt, section in zip(of_planes.bolts, of_sections.bolts, strict=True):
        assert bolt.section == pytest.approx(section.section, rel=1e-9)
        assert np.allclose(bolt.axis, [0, 0, -1])
    [(_, line)] = by_planes(0, 0.1, 1).conflicts_of_files()
    assert "no faces of elements lie in the plane of bolt bolt_0 through" in line


#: the cubes fall apart but for a bolt between two reference nodes that pulls along z
BOLTED = (
    TWO_CUBES + "*NODE\n100, .5, .5, 2.\n101, .5, .5, 0.\n*SURFACE, NAME=HEAD\n2, S2\n"
    "*SURFACE, NAME=NUT\n1, S1\n"
    "*COUPLING, CONSTRAINT NAME=head, REF NODE=100, SURFACE=HEAD\n*DISTRIBUTING\n"
    "*COUPLING, CONSTRAINT NAME=nut, REF NODE=101, SURFACE=NUT\n*DISTRIBUTING\n"
    "*EQUATION\n2\n100, 4, 1., 101, 4, -1.\n2\n100, 5, 1., 101, 5, -1.\n"
    "2\n100, 6, 1., 101, 6, -1.\n"
    # the reference nodes lie apart: the upper one moves by the rotation too
    "3\n100, 1, 1., 101, 1, -1., 101, 5, -2.\n3\n100, 2, 1., 101, 2, -1., 101, 4, 2.\n"
    "*STEP\n*STATIC\n*CLOAD\n100, 3, -500.\n101, 3, 500.\n*END STEP\n"
)
LAP = {"name": "lap", "surfaces": ["TOP OF LOWER", "BOTTOM OF UPPER"]}
PAIR = {"contact": [LAP]}


def test_a_base_with_closed_contact_holds_what_falls_apart_without(described):
    with pytest.raises(ValueError, match="without contact 1 motions of bodies are free: tie what"):
        structure_of_deck(described(BOLTED, **PAIR), described(BOLTED, **PAIR).folder)
    description = described(BOLTED, base="closed", contact=[LAP | {"penalty_N_per_m3": 1e12}])
    model = model_of_deck(description, description.folder)
    structure = model.structure
    assert (model.mechanisms, structure.rigid.shape[1]) == (1, 6)
    assert [bolt.name for bolt in structure.bolts] == ["head"]
    assert np.allclose(structure.bolts[0].axis, [0, 0, -1])
    assert model.loads.tolist() == [500]
    preload = apply_preload(structure, 500.0)
    assert preload["normal_load"].sum() == pytest.approx(500, rel=1e-10)
    contact = structure.contact
    assert np.allclose(structure.base_springs, contact.penalty * contact.area)
    modes = find_modes(structure, "all-6")["natural_frequency"].to_numpy()
    assert np.all(modes[:6] == 0)
    assert modes[6] > 0
    # closed contact is what the springs of all points make of the stiffness
    normal = contact.relative[2::3].toarray()
    K = structure.stiffness.toarray() + normal.T @ (structure.base_springs[:, None] * normal)
    squared = np.linalg.eigvals(np.linalg.solve(structure.mass.toarray(), K)).real
    expected = np.sqrt(np.sort(squared)[6:12]) / (2 * np.pi)
    assert np.allclose(modes[6:], expected, rtol=1e-6)
    # it lasts in files
    again = structure_from_dataset(structure_to_dataset(structure))
    assert np.array_equal(again.base_springs, structure.base_springs)


def test_contact_pairs_that_are_not_named_are_tied(described):
    pair = "*SURFACE INTERACTION, NAME=I\n*CONTACT PAIR, INTERACTION=I\nTOP OF LOWER, "
    pair += "BOTTOM OF UPPER\n"
    sides = "*SURFACE, NAME=ONE\n1, S4\n*SURFACE, NAME=OTHER\n2, S6\n"
    text = BOLTED.replace("*STEP", f"{pair}{sides}*STEP", 1)
    named = described(text, base="closed", **PAIR)
    assert model_of_deck(named, named.folder).assembled.ties == ()
    reverse = [{"surfaces": ["bottom of upper", "top of lower"]}]
    named = described(text, base="closed", contact=reverse)
    assert model_of_deck(named, named.folder).assembled.ties == ()


def test_materials_units_and_supports_of_a_description(described):
    text = BOLTED.replace("*DENSITY\n7.85E-9\n", "")
    description = described(text, base="closed", **PAIR)
    assert [line for _, line in description.conflicts_of_files()] == [
        "joint.inp, line 28: *MATERIAL STEEL has no *DENSITY: give materials: [{name: STEEL, "
        "density_kg_per_m3: ...}]"
    ]
    steel = {"name": "steel", "density_kg_per_m3": 7850, "youngs_modulus_GPa": 105}
    held = described(text, materials=[steel], supports=["LOWER NODES"], base="closed", **PAIR)
    assert "joint.inp has no *NSET LOWER NODES; there are: ALL" in str(
        list(held.conflicts_of_files())
    )
    free = described(text, materials=[steel], base="closed", **PAIR)
    model = model_of_deck(free, free.folder)
    assert model.structure.mass.sum() / 3 == pytest.approx(2e-9 * 7850, rel=1e-12)
    # of what is no steel only where it is given
    assert np.isnan(model.structure.geometry.material.yield_strength).all()
    given = described(text, materials=[steel | {"yield_strength_MPa": 250}], base="closed", **PAIR)
    material = model_of_deck(given, given.folder).structure.geometry.material
    assert set(material.yield_strength) == {250e6} and set(material.youngs_modulus) == {105e9}
    plain = described(BOLTED, base="closed", **PAIR)
    material = model_of_deck(plain, plain.folder).structure.geometry.material
    assert set(material.yield_strength) == {355e6}
    inches = described(BOLTED, base="closed", units={"length": "in", "mass": "slinch"}, **PAIR)
    model = model_of_deck(inches, inches.folder)
    assert model.structure.mass.sum() / 3 == pytest.approx(2 * 7.85e-9 * 175.126835, rel=1e-9)
    # of 210 000 psi
    modulus = 210e3 * 0.45359237 * 9.80665 / 0.0254**2
    assert inches.units.pascal * 210e3 == pytest.approx(modulus, rel=1e-6)


CONTACT = {"contact": [LAP]}
BAD = {
    "a surface that is not there": (
        "",
        {"contact": [{"surfaces": ["LAP", "BOTTOM OF UPPER"]}]},
        "joint.inp has no *SURFACE LAP; there are: TOP OF LOWER, BOTTOM OF UPPER, HEAD, NUT",
    ),
    "faces that look away": (
        "",
        {"contact": [{"surfaces": ["HEAD", "NUT"]}]},
        "joint.inp: surfaces HEAD and NUT: no part of side_b lies before side_a",
    ),
    "a surface of nodes": (
        "*SURFACE, NAME=NODES, TYPE=NODE\nALL\n",
        {"contact": [{"surfaces": ["NODES", "NUT"]}]},
        "*SURFACE NODES is one of nodes: faces of elements are needed",
    ),
    "the same nodes": (
        "*SURFACE, NAME=SAME\nLOWER, S2\n",
        {"contact": [{"surfaces": ["SAME", "TOP OF LOWER"]}]},
        "joint.inp: surfaces SAME and TOP OF LOWER share all nodes: a node cannot meet itself",
    ),
    "a bolt that is not there": (
        "",
        CONTACT | {"bolts": [{"name": "one", "section": "CUT"}]},
        "joint.inp has no *PRE-TENSION SECTION of CUT; there are: none",
    ),
    "a coupling that is not there": (
        "",
        CONTACT | {"bolts": [{"name": "one", "couplings": ["head", "thread"]}]},
        "joint.inp has no *COUPLING thread; there are: head, nut",
    ),
    "a material that is not there": (
        "",
        CONTACT | {"materials": [{"name": "iron", "density_kg_per_m3": 7000}]},
        "joint.inp has no *MATERIAL iron; there are: STEEL",
    ),
    "elements without a section": (
        "*NODE\n30, 5., 0., 0.\n31, 6., 0., 0.\n32, 5., 1., 0.\n33, 5., 0., 1.\n"
        "*ELEMENT, TYPE=C3D4\n30, 30, 31, 32, 33\n",
        CONTACT,
        "joint.inp: element 30 (C3D4) has no material: give *SOLID SECTION for its set",
    ),
    "a bolt that pulls one way": (
        "*CLOAD\n100, 1, 3.\n101, 1, -3.\n",
        CONTACT,
        "joint.inp: load of head is not in equilibrium with itself",
    ),
    "an element turned inside out": (
        "*NODE\n30, 5., 0., 0.\n31, 6., 0., 0.\n32, 5., 1., 0.\n33, 5., 0., -1.\n"
        "*ELEMENT, TYPE=C3D4, ELSET=UPPER\n30, 30, 31, 32, 33\n",
        CONTACT,
        "joint.inp, line 62: *ELEMENT: element 30 (C3D4) is turned inside out",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_structure_is_told_in_one_line(described, case):
    lines, keys, sentence = BAD[case]
    description = described(BOLTED.replace("*STEP", f"{lines}*STEP", 1), base="closed", **keys)
    with pytest.raises(ValueError) as refused:
        if problems := list(description.conflicts_of_files()):
            raise ValueError(problems[0][1])
        structure_of_deck(description, description.folder)
    assert sentence in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_body_that_slides_is_told_before_anything_is_solved(described):
    loose = BOLTED.replace("*EQUATION\n2\n100, 4", "*EQUATION\n2\n100, 3, 0., 1, 3, 0.\n2\n100, 4")
    loose = loose.replace("3\n100, 1, 1., 101, 1, -1., 101, 5, -2.\n", "")
    description = described(loose, base="closed", **PAIR)
    with pytest.raises(ValueError, match="1 motions of bodies along the surfaces are free, which"):
        structure_of_deck(description, description.folder)


def test_included_files_belong_to_the_description(described, tmp_path):
    head, tail = BOLTED.split("*MATERIAL")
    (tmp_path / "more.inc").write_text(f"*MATERIAL{tail}")
    description = described(f"{head}*INCLUDE, INPUT=more.inc\n", base="closed", **PAIR)
    assert description.named_files == ("joint.inp", "more.inc")
    assert files_of(description, tmp_path) == ("joint.inp", "more.inc")
    assert description.bolt_count == 1


def test_a_model_is_looked_at_before_anything_is_solved(described):
    text = BOLTED.replace("*STEP", "*EXPANSION\n1E-5\n*STEP\n*BOUNDARY\n1, 1, 3\n", 1)
    description = described(text, base="closed", units={"length": "m", "mass": "kg"}, **PAIR)
    facts, doubts = check(description, description.folder)
    assert facts["mass (kg)"] == f"{2 * 7.85e-9:.6g}"
    assert facts["volume (cm³)"] == "2e+06"
    assert facts["size (mm)"] == "1000 x 1000 x 2000"
    assert facts["sets of elements"] == "LOWER, UPPER"
    assert (facts["bodies"], facts["rigid-body motions without contact"]) == ("2", "7")
    bolt = "head, between two couplings, along (0, 0, -1), 2000 mm apart, 500 N in the deck"
    assert facts["bolts"] == bolt
    assert facts["contact"].startswith("lap: 1 points, 10000 cm², gaps 0 to 0 mm")
    assert facts["share of the surfaces that meets"].endswith(
        "TOP OF LOWER 100%, BOTTOM OF UPPER 100%"
    )
    left_out = "*EXPANSION (1, first at joint.inp, line 57), *BOUNDARY in steps (1), 1 step"
    assert facts["not used of the deck"] == left_out
    assert doubts == [
        "material STEEL: Young's modulus 0.00021 GPa is unusual: is it in MPa?",
        "material STEEL: density 7.85e-09 kg/m³ is unusual",
    ]
    page = facts_of(description)
    assert page["deck"] == "joint.inp"
    assert page["to look at"].startswith("material STEEL")


#: a third cube on the second, whose faces meet those of surfaces of their own
THIRD = (
    "*NODE\n"
    + "".join(
        f"{40 + number}, {x}., {y}., {z}.\n"
        for number, (x, y, z) in enumerate(
            [(0, 0, 2), (1, 0, 2), (1, 1, 2), (0, 1, 2), (0, 0, 3), (1, 0, 3), (1, 1, 3), (0, 1, 3)]
        )
    )
    + "*ELEMENT, TYPE=C3D8, ELSET=THIRD\n3, 40, 41, 42, 43, 44, 45, 46, 47\n"
    "*SOLID SECTION, ELSET=THIRD, MATERIAL=STEEL\n"
    "*SURFACE, NAME=A\n3, S1\n*SURFACE, NAME=B\n2, S2\n"
)


def test_what_else_a_check_tells(described):
    text = BOLTED.replace("*STEP", f"{THIRD}*CONTACT\n*CONTACT PAIR, INTERACTION=I\nA, B\n*STEP", 1)
    masses = "*ELEMENT, TYPE=MASS, ELSET=M\n60, 1\n*MASS, ELSET=M\n1.\n*STEP"
    description = described(text.replace("*STEP", masses, 1), base="closed", **PAIR)
    facts, doubts = check(description, description.folder)
    # a tonne beside three cubes of 7.85e-9 t
    assert float(facts["mass (kg)"]) == pytest.approx(1e3, rel=1e-6)
    assert "A, B: 4 nodes" in facts["ties"]
    (doubt,) = [line for line in doubts if "*CONTACT, of all surfaces, is not read" in line]
    assert doubt.startswith("joint.inp, line ")
    twice = described(text.replace("*CONTACT\n", "*TIE, NAME=glue\nA, B\n"), base="closed", **PAIR)
    ((_, line),) = twice.conflicts_of_files()
    assert "A and B are tied by *TIE glue at joint.inp, line" in line


def test_an_element_that_is_turned_inside_out_is_told_before_any_job(described):
    turned = THIRD.replace("40, 41, 42, 43, 44, 45, 46, 47", "44, 45, 46, 47, 40, 41, 42, 43")
    description = described(BOLTED.replace("*STEP", f"{turned}*STEP", 1), base="closed", **PAIR)
    ((_, line),) = description.conflicts_of_files()
    assert re.match(r"joint\.inp, line \d+: \*ELEMENT: element 3 \(C3D8\) is turned inside", line)
    with pytest.raises(ValueError, match=r"element 3 .* is turned inside out"):
        check(description, description.folder)


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"contact": [LAP | {"tangent": [0, 0, 0]}]}, "must not be zero"),
        ({"contact": [LAP, LAP | {"name": "b"}]}, "must not be given twice, or the"),
        (
            {"contact": [LAP, {"name": "b", "surfaces": LAP["surfaces"][::-1]}]},
            "must not be given twice, or the other way",
        ),
        ({"contact": [LAP | {"surfaces": ["a", "A"]}]}, "must be another surface"),
        ({"bolts": [{"name": "a"}], **PAIR}, "or plane must be given, and one of them alone"),
        (
            {"bolts": [{"name": "a", "section": "b", "couplings": ["c", "d"]}], **PAIR},
            "or plane must be given, and one of them alone",
        ),
        ({"base": "closed", "initial_gap": "from deck", **PAIR}, "must be closed"),
        ({"units": {"length": "km", "mass": "t"}, **PAIR}, "'m', 'cm', 'mm', 'in' or"),
    ],
)
def test_keys_that_contradict_each_other_are_refused(described, keys, sentence):
    with pytest.raises(ValidationError) as refused:
        described(BOLTED, **keys)
    assert sentence in str(refused.value)
