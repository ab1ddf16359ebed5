"""Signals from files: units, times, clipped records, universal files."""

import numpy as np
import pytest

from boltjoint import read_signals
from boltjoint.measurement.signals import Signals

TIME = np.arange(200) / 1000
WAVE = np.sin(2 * np.pi * 30 * TIME) * np.exp(-TIME)


def write(path, header, *values):
    rows = "\n".join(",".join(f"{each:.9g}" for each in row) for row in zip(*values, strict=True))
    path.write_text(f"{header}\n{rows}\n")
    return path


def test_units_of_the_names_become_si(tmp_path):
    path = write(
        tmp_path / "a.csv", "time_ms,tip_velocity_mm_per_s,force_lbf", 1e3 * TIME, WAVE, WAVE
    )
    signals = read_signals(path)
    assert signals.sensors == ("tip",)
    assert signals.quantity == "velocity"
    assert signals.sampling_rate == pytest.approx(1000)
    assert signals.values[:, 0] == pytest.approx(1e-3 * WAVE)
    force = read_signals(path, "force")
    assert force.values[:, 0] == pytest.approx(4.4482216152605 * WAVE)


@pytest.mark.parametrize(
    ("header", "sentence"),
    [
        ("time_s,velocity", "a.csv:1: velocity has no unit: its name must end as velocity_m_per_s"),
        ("time_s,velocity_inch", "velocity_inch has the unit inch"),
        ("time,velocity_m_per_s", "time has no unit: its name must end as time_s, time_ms"),
        ("t,velocity_m_per_s", "there must be a column time_s or time_ms"),
        ("time_s,x", "no motion: quantity must name one"),
        ("time_s,time_ms", "there is another column of the same"),
    ],
)
def test_missing_units_are_refused_in_one_line(tmp_path, header, sentence):
    with pytest.raises(ValueError, match=sentence) as refused:
        read_signals(write(tmp_path / "a.csv", header, TIME, WAVE))
    assert "\n" not in str(refused.value)


def test_records_that_are_none_are_refused_in_one_line(tmp_path):
    late = TIME.copy()
    late[100:] += 5e-4
    for time, values, sentence in (
        (late, WAVE, "time is not equidistant: from 0.099 s to 0.1005 s"),
        (TIME[::-1], WAVE, "must hold two or more values that increase"),
        (TIME, np.clip(WAVE, -0.5, 0.5), "is clipped"),
        (TIME, 0 * WAVE, "is constant"),
    ):
        with pytest.raises(ValueError, match=sentence) as refused:
            read_signals(write(tmp_path / "a.csv", "time_s,velocity_m_per_s", time, values))
        assert str(tmp_path / "a.csv") in str(refused.value)
        assert "\n" not in str(refused.value)
    with pytest.raises(ValueError, match="must end as one of"):
        read_signals(tmp_path / "a.xlsx")
    with pytest.raises(ValueError, match=r"a.csv has no force; there is velocity"):
        read_signals(write(tmp_path / "a.csv", "time_s,velocity_m_per_s", TIME, WAVE), "force")


def test_a_sensor_is_chosen_by_its_name():
    signals = Signals(TIME, np.column_stack([WAVE, 2 * WAVE]), "velocity", ("a", "b"))
    assert signals.of(["b"]).values[:, 0] == pytest.approx(2 * WAVE)
    with pytest.raises(ValueError, match="sensor 'c' is not known; allowed: a, b"):
        signals.of(["c"])


def universal(path, unit="m/s2", kind=12, function=1):
    pyuff = pytest.importorskip("pyuff")
    for node in (1, 2):
        record = {
            "type": 58,
            "binary": 0,
            **{f"id{place}": "NONE" for place in range(1, 6)},
            **{"func_type": function, "func_id": 0, "ver_num": 0, "load_case_id": 0},
            **{"rsp_ent_name": "beam", "rsp_node": node, "rsp_dir": 3},
            **{"ref_ent_name": "NONE", "ref_node": 1, "ref_dir": 3, "z_axis_value": 0.0},
            **{"ord_data_type": 4, "abscissa_spacing": 1, "num_pts": TIME.size},
            **{"abscissa_min": 0.0, "abscissa_inc": 1e-3, "x": TIME, "data": node * WAVE},
        }
        for axis, spec, label in (
            ("abscissa", 17, "s"),
            ("ordinate", kind, unit),
            ("orddenom", 0, "NONE"),
            ("z_axis", 0, "NONE"),
        ):
            record |= {f"{axis}_spec_data_type": spec, f"{axis}_axis_units_lab": label}
            record |= {f"{axis}_axis_lab": "NONE", f"{axis}_len_unit_exp": 0}
            record |= {f"{axis}_force_unit_exp": 0, f"{axis}_temp_unit_exp": 0}
        pyuff.UFF(str(path)).write_sets(record, mode="add")
    return path


def test_time_responses_of_universal_files_are_read(tmp_path):
    signals = read_signals(universal(tmp_path / "a.uff"))
    assert signals.quantity == "acceleration"
    assert signals.sensors == ("beam 1:+3", "beam 2:+3")
    assert signals.values == pytest.approx(np.column_stack([WAVE, 2 * WAVE]), abs=1e-6)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"unit": "NONE"}, "has the unit NONE"),
        ({"unit": "m/s"}, "has the unit m/s"),
        ({"function": 4}, "no time response"),
    ],
)
def test_other_universal_files_are_refused_in_one_line(tmp_path, change, sentence):
    with pytest.raises(ValueError, match=sentence) as refused:
        read_signals(universal(tmp_path / "a.uff", **change))
    assert "\n" not in str(refused.value)
