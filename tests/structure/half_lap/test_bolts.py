"""Bolts and washers of their own material: ties, masses, stiffnesses in series, and yield."""

import logging
from itertools import product

import meshio
import numpy as np
import pytest
from examples import COARSE, FEWEST, coarse_assembly
from test_mesh import volume

from boltjoint.config.described import mesh_size
from boltjoint.config.lap_joint import LapJoint
from boltjoint.structure.elasticity import smallest_jacobian
from boltjoint.structure.makers.half_lap.mesh import FIRST_BOLT, build_assembly
from boltjoint.structure.makers.half_lap.parts import element_materials
from boltjoint.structure.makers.half_lap.structure import assemble_assembly, structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.structure.vtu import write_preload

ALUMINIUM = {"youngs_modulus_GPa": 70, "poissons_ratio": 0.33, "density_kg_per_m3": 2700}
STEEL = {"youngs_modulus_GPa": 206, "poissons_ratio": 0.3, "density_kg_per_m3": 7850}
BRASS = {"youngs_modulus_GPa": 100, "poissons_ratio": 0.35, "density_kg_per_m3": 8500}
WIDE = {"thickness_mm": 1.6, "diameter_mm": 16}
WASHERS = {
    "wide": WIDE,
    "as wide as the head": WIDE | {"diameter_mm": 13},
    "with a hole of its own": WIDE | {"hole_diameter_mm": 8.4},
    "under the nut alone": WIDE | {"hole_diameter_mm": 8.4, "under": ["nut"]},
    "as the head, with a hole": WIDE
    | {"diameter_mm": 13, "hole_diameter_mm": 8.4, "under": ["head"]},
}
MESHES = {
    "chosen": {},
    "finer": {
        "rings_head_to_cell_edge": 4,
        "rings_head_to_washer_edge": 2,
        "layers_in_washer": 3,
    },
}


def bolted(bolts, mesh=None, bars=COARSE["material"], **other):
    """The coarse assembly with other keys of its bolts."""
    content = COARSE | {"material": bars, **other}
    content["bolts"] = COARSE["bolts"] | bolts
    return LapJoint.model_validate(content | {"mesh": COARSE["mesh"] | (mesh or {})})


def circle(diameter_mm):
    return np.pi / 4 * 1e-6 * diameter_mm**2


@pytest.fixture(params=product(WASHERS, MESHES), ids=", ".join, scope="module")
def washers(request):
    """An assembly with washers: as configured, and as built."""
    which, mesh = request.param
    configured = bolted({"material": STEEL, "washer": WASHERS[which]}, MESHES[mesh], ALUMINIUM)
    return configured, build_assembly(configured)


def test_mass_of_bolts_and_washers_is_that_of_their_polygons(washers):
    configured, built = washers
    bolts, bar, washer = configured.bolts, configured.bar, configured.bolts.washer
    # polygons have the area of their circle
    hole = washer.hole_diameter_mm or bolts.hole_diameter_mm
    number, many = built.sizes["bolt"], len(washer.under)
    ring = circle(washer.diameter_mm) - circle(hole)
    of_washers = number * many * 1e-3 * washer.thickness_mm * ring
    length = bar.height_mm + many * washer.thickness_mm
    heads = bolts.head_height_mm + bolts.nut_height_mm
    of_bolts = circle(bolts.shank_diameter_mm) * length + circle(bolts.head_diameter_mm) * heads
    of_bolts *= 1e-3 * number
    solid = 1e-9 * bar.width_mm * bar.height_mm * bar.length_mm
    of_bars = solid - number * circle(bolts.hole_diameter_mm) * 1e-3 * bar.height_mm
    assert volume(built) == pytest.approx(of_bars + of_bolts + of_washers, rel=1e-12)
    _, M = assemble_assembly(built)
    mass = 2700 * of_bars + 7850 * (of_bolts + of_washers)
    assert M.sum() / 3 == pytest.approx(mass, rel=1e-12)


def test_washers_are_tied_from_hole_to_edge(washers):
    configured, built = washers
    bolts, washer = configured.bolts, configured.bolts.washer
    connectivity, part = built["connectivity"].to_numpy(), built["part"].to_numpy()
    coordinate, number = built["coordinate"].to_numpy(), built.sizes["bolt"]
    assert smallest_jacobian(coordinate, connectivity).min() > 0
    names = built["part"].attrs["flag_meanings"].split()
    assert names[FIRST_BOLT + number :] == [f"washers_{b + 1}" for b in range(number)]
    of_bars = np.unique(connectivity[part < FIRST_BOLT])
    # corners of a polygon of the circle's area lie a little outside of it
    beyond = 1.03
    for b in range(number):
        here = np.unique(connectivity[part == FIRST_BOLT + number + b])
        of_bolt = np.unique(connectivity[part == FIRST_BOLT + b])
        for other, level, inner, outer in (
            (of_bars, 10, bolts.hole_diameter_mm, washer.diameter_mm),
            (
                of_bolt,
                10 + washer.thickness_mm,
                washer.hole_diameter_mm or bolts.hole_diameter_mm,
                bolts.head_diameter_mm,
            ),
        ):
            tied = coordinate[np.intersect1d(here, other)] - built["bolt_position"][b].to_numpy()
            sides = {"nut": -1, "head": 1}
            expected = [sides[which] * 1e-3 * level for which in washer.under]
            found = np.unique(np.round(tied[:, 2], 9))
            np.testing.assert_allclose(found, np.sort(expected), rtol=1e-9)
            diameter = 2e3 * np.hypot(tied[:, 0], tied[:, 1])
            assert inner < diameter.min() < beyond * inner
            assert outer < diameter.max() < beyond * outer


def test_nodes_elements_and_pairs_are_counted_as_built(washers):
    configured, built = washers
    found = mesh_size(configured)
    assert found == (built.sizes["node"], built.sizes["element"], built.sizes["pair"])


def test_every_element_has_the_material_of_its_part():
    own = {"material": STEEL, "washer": WIDE | {"material": BRASS}}
    built = build_assembly(bolted(own, bars=ALUMINIUM))
    kinds = np.array([0, 0, 1, 1, 2, 2])[built["part"].to_numpy()]
    found = element_materials(built)
    for name, factor in (
        ("youngs_modulus_GPa", 1e9),
        ("poissons_ratio", 1),
        ("density_kg_per_m3", 1),
    ):
        values = factor * np.array([each[name] for each in (ALUMINIUM, STEEL, BRASS)])
        array = getattr(found, name.removesuffix("_GPa").removesuffix("_kg_per_m3"))
        np.testing.assert_array_equal(array, values[kinds])
    # of readers that know one material: that of the bars
    assert built["youngs_modulus"].item() == 70e9
    # washers are of the bolts' material if they have none
    without = build_assembly(bolted({"material": STEEL, "washer": WIDE}, bars=ALUMINIUM))
    assert np.unique(element_materials(without).density).tolist() == [2700, 7850]


@pytest.mark.parametrize(
    ("plain", "told"),
    [
        ({}, {"material": COARSE["material"]}),
        ({"washer": WIDE}, {"washer": WIDE | {"material": COARSE["material"]}}),
        (
            {"material": STEEL, "washer": WIDE},
            {"material": STEEL, "washer": WIDE | {"material": STEEL, "hole_diameter_mm": 9}},
        ),
    ],
)
def test_a_material_that_is_the_same_anyway_changes_no_bit(plain, told):
    first, second = (build_assembly(bolted(keys)) for keys in (plain, told))
    for one, other in zip(assemble_assembly(first), assemble_assembly(second), strict=True):
        np.testing.assert_array_equal(one.data, other.data)
        np.testing.assert_array_equal(one.indices, other.indices)
    for one, other in (
        (find_modes(first, "free-2"), find_modes(second, "free-2")),
        (apply_preload(first, 8e3), apply_preload(second, 8e3)),
    ):
        assert one.identical(other)


def test_without_the_keys_nothing_of_them_is_stored():
    built = build_assembly(coarse_assembly())
    # but for strengths, which are those of bodies and bolts
    assert [name for name in built if name.startswith("part_")] == ["part_yield_strength"]
    assert "washers" not in built["part"].attrs["flag_meanings"]


def test_more_parts_than_a_byte_counts():
    number, pitch = 130, 25
    row = {"number": number, "pitch_mm": pitch, "positions_from_lap_start_mm": None}
    bar = COARSE["bar"] | {"lap_mm": pitch * number + 10}
    built = build_assembly(bolted(row, FEWEST, bar=bar))
    assert np.unique(built["part"]).tolist() == list(range(number + 2))
    assert len(built["part"].attrs["flag_meanings"].split()) == number + 2


def shortening(thickness, stiffness):
    """Of a shank, whose washers are sleeves as wide as the head, between bars of steel times that.

    The layers of the washers are as thick at any thickness [mm].
    """
    shared = {"poissons_ratio": 0, "density_kg_per_m3": 1}
    configured = bolted(
        {
            "number": 1,
            "positions_from_lap_start_mm": None,
            "material": shared | {"youngs_modulus_GPa": 200},
            "washer": {
                "thickness_mm": thickness,
                "diameter_mm": 13,
                "material": shared | {"youngs_modulus_GPa": 70},
            },
        },
        {
            "layers_in_washer": thickness // 2,
            "columns_at_each_lap_end": 1,
            "element_length_free_mm": 30,
        },
        shared | {"youngs_modulus_GPa": 200 * stiffness},
        bar={"width_mm": 20, "height_mm": 20, "free_length_mm": [30, 30], "lap_mm": 40},
    )
    return apply_preload(build_assembly(configured), 5e3)["shank_shortening"].item()


def test_shank_and_washers_are_springs_in_series():
    shank, sleeve = circle(8), circle(13) - circle(9)
    # away from their ends both are in uniform tension and compression (Saint-Venant)
    exact = 5e3 * 2 * 10e-3 * (1 / (200e9 * shank) + 1 / (70e9 * sleeve))
    error = [shortening(30, n) / exact - shortening(20, n) / exact - 1 for n in (10, 100, 1000)]
    # what is left is the compliance of the bars: a tenth of it in bars ten times as stiff
    assert abs(error[0]) < 3e-6
    np.testing.assert_allclose(np.divide(error[:-1], error[1:]), 10, rtol=0.5)
    assert abs(error[2]) < 1e-7


def test_strain_of_the_shanks_is_told_by_their_own_modulus(caplog):
    of_bars = build_assembly(bolted({}, bars=ALUMINIUM))
    own = build_assembly(bolted({"material": STEEL}, bars=ALUMINIUM))
    preload = 0.39e-2 * 70e9 * structure_of(of_bars).bolts[0].section
    with caplog.at_level(logging.WARNING):
        apply_preload(of_bars, preload)
        assert "strains the shanks by 0.39%" in caplog.text
        caplog.clear()
        # 0.13 %, below yield
        apply_preload(own, preload)
        assert not caplog.text
        apply_preload(own, 3 * preload)
        assert f"strains the shanks by {3 * 0.39 * 70 / 206:.2f}%" in caplog.text


def test_bolts_yield_by_a_strength_of_their_own(caplog):
    stronger = build_assembly(bolted({"material": {**STEEL, "yield_strength_MPa": 940}}))
    (bolt, *_) = structure_of(stronger).bolts
    with caplog.at_level(logging.WARNING):
        # 640 MPa, the strength of class 8.8, is exceeded, then that of class 10.9
        apply_preload(stronger, 700e6 * bolt.section)
        assert not caplog.text
        apply_preload(stronger, 950e6 * bolt.section)
    told = f"more than the {940 / 206e3:.2%} at which bolts of 940 MPa (yield_strength_MPa) yield"
    assert told in caplog.text


def test_views_have_washers_as_parts(tmp_path):
    built = build_assembly(bolted({"washer": WIDE}))
    write_preload(built, apply_preload(built, 8e3), tmp_path / "preload.vtu")
    read = meshio.read(tmp_path / "preload.vtu").cell_data_dict["part"]
    np.testing.assert_array_equal(read["hexahedron"], built["part"])
    assert np.unique(read["hexahedron"]).tolist() == [0, 1, 2, 3, 4, 5]
    # the contact is a part of its own
    assert np.unique(read["quad"]).tolist() == [6]
