"""Two plates with a pattern of bolts: mesh, mass, preload, symmetry, convergence, what is refused.

A deck of the same structure, which the reader of decks makes contact points and sections of, has
the same loads and frequencies.
"""

import numpy as np
import pytest
from bolted import (
    BOLTS,
    PLATES,
    STEEL,
    WASHERS,
    WHOLE,
    built,
    changed,
    first_peaks,
    mass_of,
    refined,
    refusal,
    study_of,
    volume_of_bolts,
)
from deck_of_assembly import deck_of_bodies

from boltjoint.config.deck import Deck
from boltjoint.config.plates import Pattern, Plates
from boltjoint.config.types import ConfigError
from boltjoint.structure.elements.matrices import smallest_jacobian
from boltjoint.structure.extrusion.bodies import KIND
from boltjoint.structure.makers.deck.structure import structure_of_deck
from boltjoint.structure.makers.plates.mesh import mesh_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

STAGGERED = {
    "plates": {"width_mm": 70, "thickness_mm": [5, 8], "lap_mm": 90},
    "pattern": {"rows": 3, "columns": 2, "pitch_mm": 20, "gauge_mm": 36, "staggered": True},
    "mesh": {"layers": [1, 1], "rings_head_to_cell_edge": 1, "elements_along_cell": 2},
}
ECCENTRIC = {"pattern": {"offset_mm": [3, 6]}, **WHOLE}
VARIANTS = {
    "a row": {},
    "washers": {"bolts": {"washer": WASHERS}},
    "washers under heads": {
        "bolts": {"washer": {"thickness_mm": 2, "diameter_mm": 13, "under": ["head"]}}
    },
    "staggered": STAGGERED,
    "eccentric": ECCENTRIC,
    "one bolt": {"pattern": {"rows": 1, "columns": 1, "pitch_mm": None}},
}


@pytest.mark.parametrize("changes", VARIANTS.values(), ids=VARIANTS)
def test_mesh_has_the_size_and_the_mass_of_the_dimensions(changes):
    content = changed(PLATES, **changes)
    description, structure = built(PLATES, **changes, **{"support": "none"})
    size, mesh = description.size, mesh_of(description)
    assert size == (len(mesh.coordinate), len(mesh.hexahedron), len(mesh.pair))
    worst = smallest_jacobian(KIND, mesh.coordinate[mesh.hexahedron], at_corners=True)
    assert worst.min() > 0
    plates, bolts = content["plates"], content["bolts"]
    lengths = np.array(plates["free_length_mm"]) + plates["lap_mm"]
    hole = np.pi / 4 * bolts["hole_diameter_mm"] ** 2 * description.bolt_count
    thickness = plates["thickness_mm"]
    volume = plates["width_mm"] * lengths @ thickness - hole * sum(thickness)
    volume += description.bolt_count * volume_of_bolts(bolts, sum(thickness))
    mass = mass_of(structure)
    np.testing.assert_allclose(mass, 1e-9 * volume * STEEL["density_kg_per_m3"], rtol=1e-12)
    area = 1e-6 * (plates["width_mm"] * plates["lap_mm"] - hole)
    assert mesh.area.sum() == pytest.approx(area, rel=1e-12)
    np.testing.assert_array_equal(*mesh.coordinate[mesh.pair].swapaxes(0, 1))


@pytest.mark.parametrize("name", ["washers", "staggered", "eccentric"])
def test_contact_carries_the_load_of_all_bolts(name):
    description, structure = built(PLATES, **VARIANTS[name])
    ratios = np.linspace(0.8, 1.2, description.bolt_count) if name == "eccentric" else 1.0
    loads = 1e4 * ratios * np.ones(description.bolt_count)
    preload = apply_preload(structure, loads.tolist(), tolerance=1e-12)
    assert preload["normal_load"].sum() == pytest.approx(loads.sum(), rel=1e-10)
    assert (preload["normal_load"] == 0).any()


def test_materials_and_masses_are_those_of_the_parts():
    soft = {"youngs_modulus_GPa": 70, "poissons_ratio": 0.33, "density_kg_per_m3": 2700}
    heavy = STEEL | {"density_kg_per_m3": 17000}
    bolts = {"material": soft, "washer": WASHERS | {"material": heavy}}
    masses = [
        mass_of(built(PLATES, support="none", bolts=each)[1])[0]
        for each in (
            {"washer": WASHERS},
            {"material": soft, "washer": WASHERS | {"material": STEEL}},
            bolts,
        )
    ]
    both = volume_of_bolts(BOLTS | {"washer": WASHERS}, 10)
    alone = volume_of_bolts(BOLTS, 10) + np.pi / 4 * 64 * 2 * 1.6
    assert masses[1] - masses[0] == pytest.approx(2e-9 * alone * (2700 - 7850), rel=1e-9)
    assert masses[2] - masses[1] == pytest.approx(2e-9 * (both - alone) * (17000 - 7850), rel=1e-9)


def test_a_half_moves_as_the_whole_does():
    _, half = built(PLATES, **STAGGERED)
    _, whole = built(PLATES, **STAGGERED, **WHOLE)
    assert half.symmetry is not None
    assert whole.symmetry is None
    one, other = (find_modes(each, "free-3")["natural_frequency"] for each in (half, whole))
    np.testing.assert_allclose(one, other, rtol=1e-7)
    loads = [apply_preload(each, 9e3)["normal_load"] for each in (half, whole)]
    np.testing.assert_allclose(*loads, atol=1e-9 * loads[0].max())
    # twice as much on bolts beyond the plane: the whole is solved, whatever the structure has
    ratios = [9e3, 4e3, 6e3, 9e3, 4e3]
    assert apply_preload(half, ratios)["normal_load"].sum() == pytest.approx(32e3, rel=1e-9)


def test_free_plates_have_six_rigid_body_modes():
    _, structure = built(PLATES, support="none", **ECCENTRIC)
    assert structure.rigid_body_motions.shape[1] == 6
    assert structure.support is None
    frequency = find_modes(structure, "free-2")["natural_frequency"].to_numpy()
    np.testing.assert_array_equal(frequency[:6], 0)
    assert frequency[6] > 100


def test_frequencies_and_a_peak_converge():
    """Differences fall with the size of elements: docs/structures.md has further meshes."""
    meshes = (refined(PLATES, factor) for factor in (0.5, 1, 1.5))
    frequency, peak, amplitude = (
        np.array(values)
        for values in zip(
            *(first_peaks(built(PLATES, mesh=mesh)[1], 1e4, [5.0]) for mesh in meshes), strict=True
        )
    )
    # 151.56, 150.15 and 149.64 Hz; 963.1, 902.3 and 892.3 Hz; then 154.03, 152.78 and 152.34 Hz
    for values in (*frequency.T[:2], peak[:, 0]):
        first, second = -np.diff(values)
        assert 0 < 1.5 * second < first
        assert second < 0.012 * values[-1]
    # 18.60, 17.41 and 17.04 mm
    first, second = abs(np.diff(amplitude[:, 0])) / amplitude[-1]
    assert 1.5 * second < first
    assert second < 0.03


def test_a_deck_of_the_same_plates_has_the_same_loads_and_frequencies(tmp_path):
    description, structure = built(PLATES, **STAGGERED, **WHOLE)
    (tmp_path / "plates.inp").write_text(deck_of_bodies(mesh_of(description), STEEL, 1e4))
    deck = Deck.model_validate(
        {
            "type": "deck",
            "file": "plates.inp",
            "units": {"length": "mm", "mass": "t"},
            "elements": [{"kind": "C3D8R", "read_as": "C3D8I"}],
            "contact": [{"surfaces": ["lap_a", "lap_b"], "points": "nodes"}],
            "points": [{"name": "tip", "near_mm": [160, 0, 5], "direction": "z"}],
        }
    )
    read = structure_of_deck(deck, tmp_path)
    assert len(read.contact) == len(structure.contact)
    loads = []
    for each in (structure, read):
        load = apply_preload(each, 1e4)["normal_load"].to_numpy()
        order = np.lexsort(np.round(each.contact.position, 9).T)
        loads.append(load[order])
    np.testing.assert_allclose(*loads, atol=1e-8 * loads[0].max())
    one, other = (find_modes(each, "free-4")["natural_frequency"] for each in (structure, read))
    np.testing.assert_allclose(one, other, rtol=1e-8)


def test_staggered_rows_have_bolts_between_those_beside_them():
    pattern = Pattern(rows=3, columns=2, pitch_mm=20, gauge_mm=36, staggered=True)
    assert pattern.positions_mm == ((-20, -18), (-20, 18), (0, 0), (20, -18), (20, 18))
    moved = Pattern(rows=1, columns=2, gauge_mm=30, offset_mm=(2, -1))
    assert moved.positions_mm == ((2, -16), (2, 14))


@pytest.fixture
def study(tmp_path):
    """A study of the small plates, with other keys of its assembly or case."""

    def read(case=(), content=PLATES, **changes):
        return study_of(tmp_path, changed(content, **changes), case)

    return read


def test_a_study_knows_sizes_and_places(study):
    assembly = study().assembly("two_bolt")
    assert isinstance(assembly, Plates)
    assert assembly.surface_names == ("interface",)
    assert assembly.input_names == ("tip",)
    assert assembly.pairs_of_one_side < assembly.contact_pairs


REFUSED = {
    "a negative length": ({"plates": {"lap_mm": -60}}, "plates.lap_mm: -60 must be greater than 0"),
    "no thickness": (
        {"plates": {"thickness_mm": [5, 0]}},
        "plates.thickness_mm[1]: 0 must be greater than 0",
    ),
    "no bolts": ({"pattern": {"rows": 0}}, "pattern.rows: 0 must be at least 1"),
    "no pitch": ({"pattern": {"pitch_mm": None}}, "pattern.pitch_mm: null is missing: distance"),
    "bolts outside the lap": (
        {"pattern": {"pitch_mm": 70}},
        "pattern.pitch_mm: 70 leaves 0 mm from bolts to the ends of the lap: must leave at least "
        "7.15 mm, 0.55 times the diameter of head or washer",
    ),
    "bolts beside the plates": (
        {"pattern": {"offset_mm": [0, 25]}, **WHOLE},
        "plates.width_mm: 40 leaves 0 mm from bolts to the sides of the plates",
    ),
    "overlapping holes": (
        {"pattern": {"pitch_mm": 8}},
        "pattern.pitch_mm: 8 leaves 8 mm between bolts: must leave at least 14.3 mm, 1.1 times",
    ),
    "bolts that are too near": (
        {"pattern": {"columns": 2, "gauge_mm": 14}},
        "pattern.gauge_mm: 14 leaves 14 mm between bolts: must leave at least 14.3 mm",
    ),
    "washers that overlap": (
        {"bolts": {"washer": WASHERS | {"diameter_mm": 25}}},
        "pattern.pitch_mm: 26 leaves 26 mm between bolts: must leave at least 27.5 mm",
    ),
    "a hole as wide as the head": (
        {"bolts": {"hole_diameter_mm": 13}},
        "bolts.head_diameter_mm: 13 must be greater than the hole's diameter of 13 mm",
    ),
    "a cell without room": (
        {"mesh": {"bolt_cell_mm": 30}},
        "mesh.bolt_cell_mm: 30 must be at least 14.3 mm, 1.1 times the diameter of head or washer, "
        "and at most 26 mm",
    ),
    "a point off the plates": (
        {"points": [{"name": "tip", "near_mm": [170, 0, 5], "direction": "z"}]},
        "points[0].near_mm[0]: 170 must lie in the assembly, x from 0 to 160 mm",
    ),
    "a point off the plane": (
        {"points": [{"name": "tip", "near_mm": [160, 20, 5], "direction": "z"}]},
        "must lie on the plane of x and z and act in it, with symmetry: xz",
    ),
    "a pattern that is not symmetric": (
        {"pattern": {"offset_mm": [0, 2]}},
        'symmetry: "xz" must be none: bolts are not symmetric about the plane of x and z',
    ),
    "another key": ({"pattern": {"row": 2}}, "pattern.row: is not a known key; did you mean rows"),
}


@pytest.mark.parametrize(("changes", "line"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_joint_is_said_in_one_line(study, changes, line):
    said = refusal(study, changes)
    assert said.startswith("config/assemblies/two_bolt.yaml: ")
    assert line in said


@pytest.mark.parametrize(
    ("case", "line"),
    [
        (
            {"preload_ratios": [1, 1, 1, 0.5, 1]},
            "preload_ratios[3]: 0.5 must be that of the bolt beyond the plane, with symmetry: xz",
        ),
        (
            {"sensors": [{"name": "side", "x_mm": 150, "y_mm": 9, "z_mm": 0, "direction": "z"}]},
            "sensors[0].y_mm: 9 must lie on the plane of x and z",
        ),
        ({"outputs": ["end"]}, '"end" is no output of two_bolt'),
    ],
)
def test_a_case_that_a_half_cannot_have_is_refused(study, case, line):
    with pytest.raises(ConfigError) as refused:
        study(case, **STAGGERED)
    assert line in str(refused.value)
