"""Stepped sines of a case: what is said of files, keys and values that cannot be used."""

import numpy as np
import pytest
from small_study import ASSEMBLY, CASE, SETTINGS, write

from boltjoint.config.csv_table import TableError
from boltjoint.config.measured_tables import read_response_table
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError

FILE, CASE_FILE = "config/measured/sine.csv", "config/cases/small.yaml"
HEAD = "frequency_Hz,displacement_mm,force_N,phase_deg"
ROWS = [(330.0, 0.01, 2.0, -30), (335.0, 0.02, 2.0, -90), (340.0, 0.01, 2.1, -150)]
MEASURED = {
    "responses": [{"file": FILE, "name": "sine", "excitation_error_percent": 3}],
    "parameters": {"contact.friction_coefficient": {"low": 0.05, "high": 0.5}},
}


def table(head=HEAD, rows=ROWS):
    return "\n".join([head, *(",".join(map(str, row)) for row in rows)]) + "\n"


@pytest.fixture
def study(tmp_path):
    folder = tmp_path / "study"
    write(folder / "config/assemblies/two_bolt.yaml", ASSEMBLY)
    write(folder / "config/config.yaml", SETTINGS | {"convergence": {}})
    (folder / FILE).parent.mkdir(parents=True)
    return folder


def written(folder, text=None, measured=MEASURED, **changes):
    write(folder / CASE_FILE, CASE | {"measured": measured} | changes)
    (folder / FILE).write_text(table() if text is None else text, encoding="utf-8")


def problem_of(folder):
    with pytest.raises(ConfigError) as caught:
        load_study(folder)
    (line,) = caught.value.problems
    return line


def test_columns_are_read_in_si_units():
    read = read_response_table(table(), FILE, {})
    assert read.quantity == "displacement" and read.has_unit and read.level_unit == "N"
    np.testing.assert_allclose(read.amplitude, [1e-5, 2e-5, 1e-5])
    np.testing.assert_allclose(read.phase, np.deg2rad([-30, -90, -150]))
    np.testing.assert_allclose(read.level, [2, 2, 2.1])
    head = "frequency_Hz,acceleration_g,base_acceleration_m_per_s2"
    read = read_response_table(f"{head}\n100,2,0.5\n", FILE, {})
    assert (read.amplitude, read.level_unit, read.phase) == (2 * 9.80665, "m/s2", None)


@pytest.mark.parametrize(
    ("head", "rows", "said"),
    [
        ("frequency_Hz,displacement_mm", [(1, 1)], "there must be a column force_N or base_acc"),
        ("displacement_mm,force_N", [(1, 1)], "there must be a column frequency_Hz"),
        ("frequency_Hz,force_N", [(1, 1)], "there must be a column of amplitudes: displacement_m"),
        ("frequency_Hz,modal_amplitude,force_N", [(1, 1, 1)], "there must be a column of amplitu"),
        (f"{HEAD},phase_rad", [(1, 1, 1, 1, 1)], "phase_deg and phase_rad: must be one column of"),
        (HEAD, [(330, 0.01, -2, 0)], ":2: force_N: -2 must be greater than 0"),
        (HEAD, [(330, 0.01, "much", 0)], "force_N"),
        (f"{HEAD},force_N", [(1, 1, 1, 1, 1)], "force_N: must not appear twice"),
    ],
)
def test_tables_that_cannot_be_used_are_refused(head, rows, said):
    with pytest.raises(TableError, match=said.replace("(", r"\(")):
        read_response_table(table(head, rows), FILE, {})


def test_a_case_may_have_responses_alone(study):
    written(study)
    assert load_study(study).measured_points == {"small": (3, 0)}


@pytest.mark.parametrize(
    ("changes", "text", "line"),
    [
        (
            {},
            table(HEAD.replace("force_N", "base_acceleration_m_per_s2")),
            f'measured.responses[0].file: "{FILE}" has no column force_N: as the excitation of',
        ),
        (
            {"responses": [MEASURED["responses"][0] | {"phase_error_deg": 2}]},
            table("frequency_Hz,displacement_mm,force_N", [row[:3] for row in ROWS]),
            "responses[0].phase_error_deg: 2 must be left out: config/measured/sine.csv has no ph",
        ),
        (
            {"responses": [{"file": FILE, "name": "sine"}]},
            None,
            "responses[0].excitation_error_percent: is missing: Standard deviation",
        ),
        (
            {"responses": [MEASURED["responses"][0], dict(MEASURED["responses"][0])]},
            None,
            'responses[1].name: "sine" must not be sine, as of a curve before it',
        ),
        (
            {},
            table(HEAD.replace("displacement_mm", "displacement_amplitude")),
            "tells no unit of the displacement: its column must end in one, or parameters must hav",
        ),
        (
            {"parameters": {f"joint.regions[{n}].friction_coefficient": {} for n in range(1)}},
            None,
            "measured.parameters.joint.regions[0].friction_coefficient",
        ),
        (
            {
                "parameters": {
                    key: {"low": 1e-3, "high": 1e9}
                    for key in ("preload_N", "loss_factor", "amplitude_scale", "frequency_ratio")
                }
            },
            None,
            "are 4, more than the 3 measured values: must be at most as many",
        ),
    ],
)
def test_what_does_not_go_together_is_refused_in_one_line(study, changes, text, line):
    written(study, text, MEASURED | changes)
    with pytest.raises(ConfigError) as caught:
        load_study(study)
    assert any(line in problem for problem in caught.value.problems), caught.value.problems
    assert all(problem.startswith(f"{CASE_FILE}: ") for problem in caught.value.problems)


def test_bolts_are_fitted_node_to_node_alone(study):
    bolts = {"preload_ratios[0]": {"low": 0.1, "high": 1.2}}
    written(study, measured=MEASURED | {"parameters": bolts})
    load_study(study)
    regions = [{"resonance": 1, "joints": ["regions=2"]}]
    measured = MEASURED | {"parameters": bolts, "joint": "regions=2"}
    written(study, measured=measured, solve=regions)
    said = "is no key that is fitted; preloads of bolts ask for joint: node-to-node"
    assert problem_of(study).endswith(said)
