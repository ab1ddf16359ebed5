"""Form error of the contact surfaces: maps, what does not suit a lap, and preloads that vary."""

import re

import numpy as np
import pytest
import yaml
from mutations import ROOT

from boltjoint.config.gap_map import TableError, load_gap_map, read_gap_map
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError

MAP = "config/assemblies/measured.csv"
HOLLOW = "config/assemblies/three_bolt_hollow.yaml"
CASE = "three_bolt_hollow_variable"
#: the lap of the shipped assembly, from its centre
LAP, WIDTH = 110.5, 20.0


def text_of(x, y, gap, header="x_mm,y_mm,gap_um"):
    return "\n".join([header, *(",".join(map(str, row)) for row in np.c_[x, y, gap].tolist())])


def grid(along=(-60, -20, 5, 60), across=(-10, -4, 4, 10)):
    x, y = np.meshgrid(along, across, indexing="ij")
    return x.ravel(), y.ravel()


def bilinear(x, y):
    return 3.0 + 0.1 * x - 0.2 * abs(y) + 0.01 * x * abs(y)


def scattered():
    """Points on both sides of the middle, whose hull is more than the lap."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-56, 56, 40), rng.uniform(0.5, 11, 40)
    x, y = np.append(x, [-60, 60, 0]), np.append(y, [12, 12, 0])
    return np.concatenate([x, x[:-1]]), np.concatenate([y, -y[:-1]])


@pytest.fixture
def study_with_map(study):
    """A study whose hollow joint has a map; the problems of its text."""

    def problems(text, **changes):
        (study / MAP).write_text(text, encoding="utf-8")
        content = yaml.safe_load((study / HOLLOW).read_text(encoding="utf-8"))
        content["contact"]["gap_um"] = MAP
        (study / HOLLOW).write_text(yaml.safe_dump(content), encoding="utf-8")
        try:
            load_study(study, {"cases": [CASE], **changes})
        except ConfigError as error:
            return list(error.problems)
        return []

    return problems


def test_a_grid_is_interpolated_bilinearly_whatever_the_order():
    x, y = grid()
    order = np.random.default_rng(0).permutation(x.size)
    found = read_gap_map(text_of(x[order], y[order], bilinear(x, y)[order]), MAP)
    at = np.array([-33.0, 0.5, 59.0]), np.array([-9.0, 8.0, 4.0])
    np.testing.assert_allclose(found.at(*at), bilinear(*at), rtol=1e-13)
    # as the points of a file beside columns in another order
    swapped = read_gap_map(text_of(x + y, x, y, "gap_um,x_mm,y_mm"), MAP)
    np.testing.assert_allclose(swapped.at(*at), at[0] + at[1], rtol=1e-13)


def test_scattered_points_are_interpolated_linearly():
    x, y = scattered()
    found = read_gap_map(text_of(x, y, 2 + 0.1 * x - 0.3 * y), MAP)
    at = np.array([-33.0, 0.5, 50.0]), np.array([-9.0, 8.0, 4.0])
    np.testing.assert_allclose(found.at(*at), 2 + 0.1 * at[0] - 0.3 * at[1], rtol=1e-12)
    assert np.isnan(found.at(np.array([61.0]), np.array([0.0]))).all()


def test_symmetric_maps_that_cover_the_lap_are_taken(study_with_map):
    x, y = scattered()
    for text in (text_of(x, y, bilinear(x, y)), text_of(*grid(), bilinear(*grid()))):
        assert study_with_map(text) == []
        assert list(read_gap_map(text, MAP).conflicts(LAP, WIDTH)) == []
    # the ends of the lap may be the last points, though half of it is no decimal number of them
    x, y = grid((-LAP / 2, LAP / 2), (-WIDTH / 2, 0, WIDTH / 2))
    assert study_with_map(text_of(x, y, 0 * x)) == []


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", f"{MAP}: must have the columns x_mm, y_mm, gap_um"),
        ("x_mm,y_mm,gap_mm\n0,0,1", f"{MAP}: must have the columns x_mm, y_mm, gap_um"),
        ("x_mm,y_mm,gap_um\n0,0", f"{MAP}:2: must have 3 values, as many as keys"),
        ("x_mm,y_mm,gap_um\n0,0,1\n1,0,nan", f'{MAP}:3: gap_um: "nan" must be a number'),
        ("x_mm,y_mm,gap_um", f"{MAP}: must have points that do not all lie on one line"),
        (
            "x_mm,y_mm,gap_um\n0,0,1\n1,1,1\n2,2,1\n-3,-3,1",
            f"{MAP}: must have points that do not all lie on one line",
        ),
        (
            "x_mm,y_mm,gap_um\n0,0,1\n1,1,1\n2,0,1\n0,0,2",
            f"{MAP}:5: the point 0, 0 mm must not appear twice",
        ),
        (
            text_of(*grid((-60, 55)), np.zeros(8)),
            f'"{MAP}" has no value at x = 55.25, y = -10 mm: must cover the lap, from -55.25 to '
            "55.25 mm along and from -10 to 10 mm across, seen from its centre",
        ),
        (
            text_of(*grid(), 0.01 * grid()[1]),
            f'"{MAP}" differs by 0.2 um on both sides of the middle at x = -55.25, y = 10 mm: must '
            "be symmetric about the middle, as the preload is",
        ),
    ],
)
def test_what_is_said_of_a_map(study_with_map, text, sentence):
    assert study_with_map(text) == [f"{HOLLOW}: contact.gap_um: {sentence}"]


def test_asymmetry_is_rounding_up_to_a_thousandth():
    x, y = grid()
    for share, taken in ((0.9e-3, True), (1.1e-3, False)):
        gap = x / np.ptp(x) + share * (y > 0) * (x > 0) * (110.5 / 120)
        found = list(read_gap_map(text_of(x, y, gap), MAP).conflicts(LAP, WIDTH))
        assert (found == []) is taken


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("0,0,1\n1,2,-1e7\n3,1,0", "gap_um: 1e+07 must be at most 1e+06"),
        ("-1e30,0,1\n1,2,1\n3,1,0", "x_mm: 1e+30 must be at most 1e+06"),
        ("0,0,1\n1,5e-20,1\n3,1e-20,0", "must have points that do not all lie on one line"),
        ("0,0,1\n1e6,1e6,1\n1,1.00001,0", "must have points that do not all lie on one line"),
        ("".join(f"{i},0,0\n" for i in range(250_001)), "must have at most 250000 points"),
    ],
)
def test_no_map_has_numbers_beyond_those_of_a_lap(rows, sentence):
    with pytest.raises(TableError, match=re.escape(f"{MAP}: {sentence}")):
        read_gap_map(f"x_mm,y_mm,gap_um\n{rows}\n", MAP)


def test_the_same_file_is_read_from_its_path(tmp_path):
    x, y = grid()
    (tmp_path / "map.csv").write_text(text_of(x, y, x), encoding="utf-8")
    np.testing.assert_array_equal(load_gap_map(tmp_path / "map.csv").gap_um, x)
    (tmp_path / "map.csv").write_text("x_mm,y_mm", encoding="utf-8")
    with pytest.raises(TableError, match=r"map\.csv: must have the columns"):
        load_gap_map(tmp_path / "map.csv")


def test_flat_surfaces_have_no_key_of_the_gap():
    study = load_study(ROOT, {"assemblies": ["three_bolt_hollow"]})
    flat, hollow = (study.assemblies[name] for name in ("three_bolt", "three_bolt_hollow"))
    assert list(flat.model_dump()["contact"]) == ["penalty_N_per_m3", "friction_coefficient"]
    assert hollow.model_dump()["contact"].pop("gap_um")["flatness_um"] == 5
    assert LapJoint.model_validate(hollow.model_dump()).model_dump() == hollow.model_dump()
    assert flat.gap_file is hollow.gap_file is None
    # all else is the same, as is what is compared
    plain = {"exclude": {"contact": {"gap_um"}}}
    assert hollow.model_dump(**plain) == flat.model_dump(**plain)
    for law in ("constant", "variable"):
        cases = [f"three_bolt_{law}", f"three_bolt_hollow_{law}"]
        one, other = load_study(ROOT, {"cases": cases}).cases.values()
        for key in ("preload_N", "contact", "forces_N", "structural_damping"):
            assert getattr(one, key) == getattr(other, key), key


def other_case(study, **changes):
    content = yaml.safe_load((study / f"config/cases/{CASE}.yaml").read_text(encoding="utf-8"))
    (study / "config/cases/other.yaml").write_text(yaml.safe_dump(content | changes))
    return {"cases": [CASE, "other"]}


def problems_of(study, changes):
    with pytest.raises(ConfigError) as caught:
        load_study(study, changes)
    return list(caught.value.problems)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"preload_N": 12000}, "preload_N: 12000"),
        ({"preload_ratios": [1, 0.5, 1]}, "preload_ratios: [1, 0.5, 1]"),
    ],
)
def test_a_contact_adapted_basis_of_a_hollow_joint_is_made_for_one_preload(study, changes, problem):
    cases = other_case(study, **changes)
    line = (
        f"config/cases/other.yaml: {problem} must be as in {CASE}: a contact-adapted basis of "
        "three_bolt_hollow is made for one preload, with contact.gap_um"
    )
    assert problems_of(study, cases) == [line]
    # one of the convergence study too
    content = yaml.safe_load((study / f"config/cases/{CASE}.yaml").read_text(encoding="utf-8"))
    (study / f"config/cases/{CASE}.yaml").write_text(
        yaml.safe_dump(content | {"modes": ["free-4"]})
    )
    cases = other_case(study, **changes)
    assert len(load_study(study, cases).cases) == 2
    compared = {"convergence": {"bases": ["free-4", "enriched-20"]}}
    assert problems_of(study, cases | compared) == [line]


def test_preloads_of_flat_joints_are_alike(study):
    cases = other_case(study, preload_N=12000, assembly="three_bolt")
    assert len(load_study(study, cases).cases) == 2


SWEEP = {
    "case": CASE,
    "vary": {"preload_N": [8000, 10000]},
    "basis": "free-4",
    "joint": "node-to-node",
}


def swept(study, **changes):
    (study / "config/sweeps/hollow.yaml").write_text(yaml.safe_dump(SWEEP | changes))
    return {"sweeps": ["hollow"]}


def test_the_preload_of_a_hollow_joint_does_not_vary_in_a_sweep(study):
    reason = (
        "with contact.gap_um of three_bolt_hollow: loads of a joint with an initial gap do not "
        "grow with the preload, and another preload is another case"
    )
    assert problems_of(study, swept(study)) == [
        f"config/sweeps/hollow.yaml: vary.preload_N: [8000, 10000] must not vary {reason}"
    ]
    table = {"kind": "table", "file": "config/sweeps/hollow.csv"}
    (study / table["file"]).write_text("preload_N\n8000\n", encoding="utf-8")
    (line,) = problems_of(study, swept(study, vary={}, design=table))
    assert line.startswith("config/sweeps/hollow.yaml: design.file: ")
    assert line.endswith(f"must not have the column preload_N {reason}")


def test_the_flatness_and_the_preload_of_each_bolt_vary_in_a_sweep(study):
    vary = {"assembly.contact.gap_um.flatness_um": [0, 5, 10], "preload_ratios[1]": [0.5, 1]}
    loaded = load_study(study, swept(study, vary=vary))
    assert [each.reason for each in loaded.variants["hollow"]] == [""] * 6
    quantity = loaded.quantities("hollow")["assembly.contact.gap_um.flatness_um"]
    assert (quantity.name, quantity.unit, quantity.factor) == ("contact_gap_flatness", "m", 1e-6)
    hollow = {each.assembly_name: each.assembly for each in loaded.variants["hollow"]}
    assert [each.contact.gap_um.flatness_um for each in hollow.values()] == [0, 5, 10]


def test_a_map_that_does_not_cover_a_longer_lap_makes_a_design_impossible(study, study_with_map):
    x, y = grid()
    assert study_with_map(text_of(x, y, 0 * x)) == []
    loaded = load_study(study, swept(study, vary={"assembly.bar.lap_mm": [110.5, 130]}))
    fits, too_long = (each.reason for each in loaded.variants["hollow"])
    assert fits == ""
    assert too_long.startswith("assembly.contact.gap_um: has no value at x = -65, y = -10 mm")
