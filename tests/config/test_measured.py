"""Measured backbones of a case: what is said of files, keys and values that cannot be used."""

import copy
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from small_study import ASSEMBLY, CASE, SETTINGS, write

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import (
    _refused_value,
    calibrated_content,
    fits_preloads,
    range_of_ratios,
)
from boltjoint.config.csv_table import TableError
from boltjoint.config.makers import description_of
from boltjoint.config.measured_tables import MOST_POINTS, read_backbone_table
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.study import memory_and_time_of_study as needs

FILE, CASE_FILE = "config/measured/bar.csv", "config/cases/small.yaml"
HEAD = "displacement_mm,frequency_Hz,damping_ratio"
POINTS = [(0.001, 340.0, 0.002), (0.01, 338.0, 0.004), (0.1, 335.0, 0.006)]
SCATTER = {"frequency_error_percent": 0.02, "damping_error_percent": 1}
MEASURED = {
    "curves": [{"file": FILE, "resonance": 1, **SCATTER}],
    "parameters": {
        "contact.friction_coefficient": {"low": 0.05, "high": 0.5, "start": 0.2},
        "loss_factor": {"low": 1e-4, "high": 0.05, "log": False},
    },
}


OTHER = MEASURED["curves"][0] | {"resonance": 2}


def table(rows=POINTS, head=HEAD):
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)]) + "\n"


@pytest.fixture
def study(tmp_path):
    folder = tmp_path / "study"
    write(folder / "config/assemblies/two_bolt.yaml", ASSEMBLY)
    write(folder / "config/config.yaml", SETTINGS | {"convergence": {}})
    write_files(folder)
    return folder


def write_files(folder, text=None, **changes):
    write(folder / CASE_FILE, CASE | {"measured": MEASURED} | changes)
    (folder / FILE).parent.mkdir(parents=True, exist_ok=True)
    (folder / FILE).write_text(table() if text is None else text, encoding="utf-8")


def problems_of(folder):
    with pytest.raises(ConfigError) as caught:
        load_study(folder)
    assert all(line.isprintable() and len(line) < 700 for line in caught.value.problems)
    return list(caught.value.problems)


def test_a_measurement_is_read_with_its_points_and_the_hash_of_its_file(study):
    loaded = load_study(study)
    assert loaded.measured_points == {"small": (3, 0)}
    before = loaded.hashes[FILE]
    write_files(study, table([*POINTS, (0.2, 334.0, 0.006)]))
    again = load_study(study)
    assert again.measured_points == {"small": (4, 0)}
    assert again.hashes[FILE] != before
    # what was checked before reads no table, but finds the same hash
    assert load_study(study, before=True).hashes[FILE] == again.hashes[FILE]


def test_more_starts_and_points_take_longer(study):
    def seconds(**changes):
        write_files(study, table(POINTS * changes.pop("times", 1)), measured=MEASURED | changes)
        return needs.estimate(load_study(study)).seconds

    one = seconds(starts=1)
    assert seconds(starts=100) > one
    assert seconds(starts=100, times=10) > seconds(starts=100)


def test_the_content_of_a_calibration_does_not_depend_on_what_is_solved(study):
    content = calibrated_content(load_study(study).case("small"))
    write_files(study, forces_N=[1, 20], coordinates=["linear"], description="other")
    assert calibrated_content(load_study(study).case("small")) == content
    write_files(study, preload_N=12000)
    assert calibrated_content(load_study(study).case("small")) != content


def changed(path, value):
    """The measurement with another value under a path; None removes the key."""
    content = copy.deepcopy(MEASURED)
    *above, last = path
    inner = content
    for part in above:
        inner = inner[part]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return content


OF_FRICTION = ("parameters", "contact.friction_coefficient")
CURVE = ("curves", 0)


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        (("curves",), [], "curves: [] is missing: there must be a curve"),
        (("parameters",), {}, "parameters: "),
        (("starts",), 0, "starts: 0 must be at least 1"),
        (("starts",), 1001, "starts: 1001 must be at most 1000"),
        (("loss",), "lineer", 'loss: "lineer" must be linear, soft_l1, huber, cauchy or arctan'),
        (("basis",), "free-3", 'basis: "free-3" is none of the bases that are solved: free-2'),
        (("joint",), "regions=3", 'joint: "regions=3" is no joint that solve has in free-2'),
        ((*CURVE, "resonance"), 3, "curves[0].resonance: 3 must be at most 2, the modes of"),
        ((*CURVE, "file"), "../bar.csv", 'curves[0].file: "../bar.csv" must be a file in the'),
        ((*CURVE, "file"), "config/no.csv", 'curves[0].file: "config/no.csv" cannot be read (No'),
        ((*CURVE, "sensor"), "tip", 'curves[0].sensor: "tip" is no sensor of the case; '),
        ((*CURVE, "rows"), {"mode": 1}, f'"{FILE}" cannot be used: {FILE}:1: has no column mode'),
        (
            (*CURVE, "rows"),
            {"frequency_Hz": 7},
            "has no row with frequency_Hz 7; frequency_Hz is 340.0, 338.0, 335.0",
        ),
        (
            ("curves",),
            [{"file": FILE, **SCATTER}],
            "curves[0].name: is missing: a curve without a resonance needs one",
        ),
        (
            (*CURVE, "shape"),
            {"tip": 1.0, "root": -0.5},
            "must not stand beside resonance",
        ),
        (
            ("curves",),
            [{"file": FILE, "name": "bending", "shape": {"tip": 1, "root": -1}, **SCATTER}],
            "no sensor of the case; there are: output",
        ),
        (
            (*CURVE, "configuration"),
            {"preload": 5000},
            "curves[0].configuration.preload: 5000 is no key that is fitted; did you",
        ),
        (
            (*CURVE, "configuration"),
            {"preload_N": -5000},
            "curves[0].configuration.preload_N: -5000 ",
        ),
        (
            ("parameters", "preload_ratios[2]"),
            {"low": 0.1, "high": 1.2},
            "preload_ratios[2]: ",
        ),
        (
            ("parameters", "preload_ratios[0]"),
            {"low": -0.1, "high": 1.2, "log": False},
            "preload_ratios[0].low: -0.1 reaches too far: must be greater than 0",
        ),
        ((*CURVE, "rows"), {"frequency_Hz": []}, "frequency_Hz: [] must be a number or a word"),
        (("predicted",), [MEASURED["curves"][0]], "predicted[0].name: must not be mode-1, as of a"),
        (("predicted",), [MEASURED["curves"][0] | {"resonance": 3}], "resonance: 3 must be at mo"),
        (("predicted",), [OTHER | {"sensor": "tip"}], 'predicted[0].sensor: "tip" is no sensor of'),
        (("predicted",), [OTHER | {"file": "config/no.csv"}], "predicted[0].file: "),
        (
            ("predicted",),
            [{key: value for key, value in OTHER.items() if key != "damping_error_percent"}],
            "predicted[0].damping_error_percent: is missing",
        ),
        (
            (*CURVE, "frequency_error_percent"),
            None,
            "curves[0].frequency_error_percent: is missing",
        ),
        ((*CURVE, "damping_error_percent"), None, f"{FILE} has no column damping_ratio_std"),
        ((*CURVE, "damping_error_percent"), 0, "damping_error_percent: 0 must be greater than 0"),
        ((*OF_FRICTION, "low"), 0.6, "friction_coefficient.low: 0.6 must be less than high, 0.5"),
        ((*OF_FRICTION, "low"), -1, "low: -1 must be greater than 0 with log: true"),
        ((*OF_FRICTION, "start"), 0.7, "start: 0.7 must lie between 0.05 and 0.5"),
        (
            (*OF_FRICTION, "prior"),
            {"mean": 0.7, "standard_deviation": 0.1},
            "prior.mean: 0.7 must lie between 0.05 and 0.5",
        ),
        ((*OF_FRICTION, "start"), "x", 'start: "x" must be a number'),
        (("parameters", "loss_factor", "high"), 1, "loss_factor.high: 1 reaches too far: loss_"),
        (("parameters", "forces_N"), {"low": 1, "high": 2}, "forces_N: "),
        (
            ("parameters", "contact.mu"),
            {"low": 1, "high": 2},
            "is no key that is fitted; there are",
        ),
        (("parameters", "joint.regions[0].friction_coefficient"), {"low": 0.5, "high": 2}, "is no"),
        (("parameters", "frequency_ratio"), {"low": -1, "high": 2, "log": False}, "it is a ratio"),
        (
            ("parameters", "amplitude_scale[mode-2]"),
            {"low": 0.5, "high": 2},
            "is of no curve; ther",
        ),
    ],
)
def test_wrong_values_are_refused_in_one_line(study, path, value, line):
    write_files(study, measured=changed(path, value))
    problems = problems_of(study)
    assert len(problems) == 1
    assert problems[0].startswith(f"{CASE_FILE}: measured.{path[0]}")
    assert line in problems[0]


def test_two_curves_of_one_name_are_refused(study):
    curve = MEASURED["curves"][0]
    write_files(study, measured=MEASURED | {"curves": [curve, copy.deepcopy(curve)]})
    (line,) = problems_of(study)
    assert "measured.curves[1].name: must not be mode-1, as of a curve before it" in line
    write_files(study, measured=MEASURED | {"curves": [curve, curve | {"name": "again"}]})
    load_study(study)


def test_regions_are_fitted_where_the_joint_has_them(study):
    def parameters(region):
        key = f"joint.regions[{region}].tangential_stiffness"
        return {"parameters": MEASURED["parameters"] | {key: {"low": 0.5, "high": 2}}}

    write_files(study, measured=MEASURED | {"joint": "regions=2"} | parameters(1))
    load_study(study)
    write_files(study, measured=MEASURED | {"joint": "regions=2"} | parameters(2))
    (line,) = problems_of(study)
    assert "joint.regions[2].tangential_stiffness" in line
    assert "did you mean joint.regions[0].tangential_stiffness?" in line


def test_more_parameters_than_values_are_refused(study):
    further = {
        key: {"low": 0.5, "high": 2}
        for key in ("frequency_ratio", "amplitude_scale", "contact.tangential_stiffness_N_per_m")
    }
    further["contact.tangential_stiffness_N_per_m"] = {"low": 1e8, "high": 1e10}
    parameters = MEASURED["parameters"] | further
    write_files(study, table(POINTS[:2]), measured=MEASURED | {"parameters": parameters})
    (line,) = problems_of(study)
    assert "parameters" in line
    assert "are 5, more than the 4 measured values: must be at most as many" in line


def test_a_law_without_closed_form_is_refused(study):
    contact = CASE["contact"] | {"law": "coupled-constant"}
    case = {"contact": contact, "modes": ["all-6"], "coordinates": ["linear"]}
    solve = [{"resonance": 1, "joints": ["node-to-node"]}]
    settings = SETTINGS | {"convergence": {}, "solver": {"friction_force": "aft"}}
    write(study / "config/config.yaml", settings)
    write_files(study, **case, solve=solve, verification_forces_N=[])
    (line,) = problems_of(study)
    assert "measured.joint" in line
    assert "fits need a closed form" in line


def test_the_preload_of_a_joint_with_a_gap_is_not_fitted(study):
    write(
        study / "config/assemblies/two_bolt.yaml",
        ASSEMBLY | {"contact": {"gap_um": {"flatness_um": 5}}},
    )
    parameters = MEASURED["parameters"] | {"preload_N": {"low": 5000, "high": 20000}}
    write_files(study, measured=MEASURED | {"parameters": parameters})
    lines = [line for line in problems_of(study) if "measured" in line]
    assert len(lines) == 1
    assert "measured.parameters.preload_N: " in lines[0]
    assert "loads of a joint with an initial gap do not grow with the preload" in lines[0]
    curve = MEASURED["curves"][0] | {"configuration": {"preload_N": 5000}}
    write_files(study, measured=MEASURED | {"curves": [curve]})
    (line,) = (line for line in problems_of(study) if "measured" in line)
    assert "configuration.preload_N: 5000 must not differ with " in line
    assert "loads of a joint with an initial gap do not grow with the preload" in line


def test_a_bolt_without_preload_is_not_fitted(study):
    bolts = {"preload_ratios[0]": {"low": 0.1, "high": 1.2}}
    write_files(study, measured=MEASURED | {"parameters": bolts}, preload_ratios=[1, 0])
    (line,) = (line for line in problems_of(study) if "measured" in line)
    assert "must not fit preloads of a case with a bolt that has none" in line
    curve = MEASURED["curves"][0] | {"configuration": {"preload_ratios[0]": 0}}
    write_files(study, measured=MEASURED | {"curves": [curve]})
    (line,) = (line for line in problems_of(study) if "measured" in line)
    assert "configuration.preload_ratios[0]: 0 must be greater than 0" in line


def test_the_range_of_preloads_is_that_of_all_curves(study):
    bolts = MEASURED["parameters"] | {"preload_ratios[0]": {"low": 0.3, "high": 1.2}}
    held = OTHER | {"configuration": {"preload_ratios[1]": 0.2}}
    write_files(study, measured=MEASURED | {"parameters": bolts, "predicted": [held]})
    case = load_study(study).case("small")
    assert fits_preloads(case.measured)
    assert range_of_ratios(case) == (0.2, 1.2)


def test_half_of_a_symmetric_joint_has_no_bolt_of_its_own(tmp_path):
    """Plates of which one half is solved: a bolt off the plane has a mirror image."""
    assembly = Path(__file__).parents[2] / "config/assemblies/five_bolt_plates.yaml"
    described = description_of(yaml.safe_load(assembly.read_text()))
    places = described.bolt_positions_mm
    beside = next(n for n, (_, y) in enumerate(places) if y != 0)
    case = Case.model_validate(CASE | {"assembly": "five_bolt_plates"})
    key = f"preload_ratios[{beside}]"
    said = list(_refused_value(case, described, key, 0.5))
    assert said == ["must be that of the bolt beyond the plane, with symmetry: xz"]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", "there must be a column of amplitudes: displacement_m,"),
        (
            table(head="amplitude,frequency_Hz,damping_ratio"),
            "there must be a column of amplitudes",
        ),
        (table(head="displacement_mm,frequency,damping_ratio"), ":1: there must be a column freq"),
        (table(head="displacement_mm,frequency_Hz,damping"), ":1: there must be a column damping_"),
        (table(head="displacement_mm,frequency_Hz,frequency_Hz"), ":1: frequency_Hz: must not app"),
        (
            table([(1, 1, 340, 0.1)], "velocity_m_per_s,displacement_m,frequency_Hz,damping_ratio"),
            ":1: velocity_m_per_s and displacement_m: must be one column of amplitudes",
        ),
        (
            table(head="displacement_amplitude,frequency_Hz,damping_ratio"),
            "tells no unit of the dis",
        ),
        (table([*POINTS, (0, 330.0, 0.1)]), ":5: displacement_mm: 0 must be greater than 0"),
        (table([*POINTS, (1, -330.0, 0.1)]), ":5: frequency_Hz: -330 must be greater than 0"),
        (table([*POINTS, (1, 330.0, 0.6), (2, 330, 1.2)]), ":6: damping_ratio: 1.2 must be less"),
        (table([*POINTS, (1, 330.0, "x")]), ':5: damping_ratio: "x" must be a number'),
        (table([*POINTS, (1, 330.0, "nan")]), ':5: damping_ratio: "nan" must be a number'),
        (table([*POINTS, (1, 330.0, "1e-31")]), ':5: damping_ratio: "1e-31" must be 0 or a numb'),
        (table([*POINTS, (1, 330.0)]), ":5: must have 3 values, as many as keys"),
        (table([]), f"{FILE}: has no row"),
        (table(POINTS * MOST_POINTS), f"{FILE}: must have at most 10000 rows"),
        ('displacement_mm,"frequency', "cannot be read as CSV"),
    ],
)
def test_wrong_tables_are_refused_in_one_line(study, text, line):
    write_files(study, text)
    (problem,) = problems_of(study)
    assert problem.startswith(f"{CASE_FILE}: measured.curves[0].file: ")
    assert line in problem


def test_files_that_are_no_regular_files_of_the_study_are_refused(study):
    path = study / FILE
    path.unlink()
    os.mkfifo(path)
    assert "is no regular file" in problems_of(study)[0]
    path.unlink()
    path.mkdir()
    assert "cannot be read (Is a directory)" in problems_of(study)[0]
    path.rmdir()
    outside = study.parent / "outside.csv"
    outside.write_text(table(), encoding="utf-8")
    path.symlink_to(outside)
    assert "lies outside the folder of the study" in problems_of(study)[0]
    path.unlink()
    path.write_bytes(b"\xff\xfe")
    assert "is not text in UTF-8" in problems_of(study)[0]


def test_rows_are_told_by_words_and_other_columns_hold_anything():
    head = "sensor,displacement_mm,frequency_Hz,damping_ratio,remark"
    rows = [
        ("acc1", 0.1, 100, 0.01, "first"),
        ("acc2", 0.1, 101, 0.01, ""),
        (" acc1 ", 0.2, 99, 0.02, "'a;b'"),
        ("acc3", "", "", "", "not measured"),
    ]
    found = read_backbone_table(table(rows, head), "a.csv", {"sensor": "acc1"})
    assert found.frequency.tolist() == [100, 99]
    assert found.amplitude == pytest.approx([1e-4, 2e-4])
    with pytest.raises(TableError, match=r"no row with sensor acc4; sensor is acc1, acc2, acc3$"):
        read_backbone_table(table(rows, head), "a.csv", {"sensor": "acc4"})
    with pytest.raises(TableError, match=r'a\.csv:5: displacement_mm: "" must be a number'):
        read_backbone_table(table(rows, head), "a.csv", {"sensor": "acc3"})


def test_curves_held_aside_are_counted_and_need_a_common_scale(study):
    write_files(study, measured=MEASURED | {"predicted": [OTHER]})
    loaded = load_study(study)
    assert loaded.measured_points == {"small": (3, 3)}
    with_them = needs.estimate(loaded).seconds
    write_files(study)
    assert needs.estimate(load_study(study)).seconds < with_them
    head = HEAD.replace("displacement_mm", "displacement_amplitude")
    own = {"amplitude_scale[mode-1]": {"low": 0.1, "high": 10}}
    changes = {"parameters": MEASURED["parameters"] | own, "predicted": [OTHER]}
    write_files(study, table(head=head), measured=MEASURED | changes)
    (line,) = problems_of(study)
    assert "predicted[0].file" in line and line.endswith("or parameters must have amplitude_scale")


def test_units_scatter_and_rows_of_a_table():
    head = "mode,acceleration_g,frequency_Hz,damping_ratio,frequency_std_Hz"
    text = table([(1, 2, 100, 0.01, 0.3), (2, 3, 200, 0.02, 0.4)], head)
    found = read_backbone_table(text, "a.csv", {"mode": 2})
    assert found.quantity == "acceleration"
    assert found.amplitude == pytest.approx([3 * 9.80665])
    of_frequency, of_damping = found.deviations(0.15, 5)
    # 0.15 % of 200 Hz beside 0.4 Hz
    assert of_frequency == pytest.approx([0.5])
    assert of_damping == pytest.approx([0.001])
    assert found.damping_std is None
    semicolons = text.replace(",", ";").replace(".", ",")
    again = read_backbone_table(semicolons, "a.csv", {})
    assert np.array_equal(again.frequency, [100, 200])
    with pytest.raises(TableError, match=r"frequency_std_Hz: -0\.4 must be greater than 0"):
        read_backbone_table(text.replace("0.4", "-0.4"), "a.csv", {})
