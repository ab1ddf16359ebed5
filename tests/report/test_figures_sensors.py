"""Figure and table of sensors."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint
from small_study import CASE, write_config

from boltjoint.config.study import load_study
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.responses import plot_sensors
from boltjoint.study.artefact_list import Contents
from boltjoint.study.tables.accuracy import tabulate_sensors


@pytest.fixture(scope="module")
def response():
    joint = make_joint()
    modes = np.array([joint.response_mode, 0.5 * joint.response_mode])
    joint = replace(joint, sensor_mode=modes, sensor_name=("tip", "half"))
    return solve_response(joint, [0.01, 5.0], damping=0.01)


def test_the_table_has_the_peak_of_each_sensor(response):
    table = tabulate_sensors(response).set_index(["sensor", "force_N"])
    assert len(table) == 4
    for level, force in enumerate((0.01, 5.0)):
        tip, half = table.loc[("tip", force)], table.loc[("half", force)]
        expected = 1e3 * response["peak_amplitude"][level] / force
        assert tip["peak_mm_per_N"] == pytest.approx(float(expected), rel=1e-12)
        assert half["peak_mm_per_N"] == pytest.approx(tip["peak_mm_per_N"] / 2, rel=1e-12)
        assert half["peak_frequency_Hz"] == tip["peak_frequency_Hz"]
    assert (table["harmonics"] == 1).all() and (table["error"] == "not tested").all()
    bars = response["force_level"].copy(data=[0.01, 0.25])
    response = response.assign(peak_amplitude_error=bars)
    assert (tabulate_sensors(response)["error"] == "not tested").all()
    table = tabulate_sensors(response.assign(basis_amplitude_error=bars))
    assert table["error_of_output_percent"].tolist() == [1.0, 25.0] * 2 and "error" not in table


def test_the_figure_has_a_panel_for_each_sensor(response):
    figure = plot_sensors(response)
    tip, half = figure.axes[:2]
    assert [axes.get_ylabel() for axes in (tip, half)] == ["tip\n(mm per N)", "half\n(mm per N)"]
    for one, other in zip(tip.lines, half.lines, strict=True):
        np.testing.assert_allclose(other.get_ydata(), one.get_ydata() / 2, rtol=1e-12)


def test_cases_with_several_sensors_have_both(tmp_path):
    point = {"x_mm": 100, "y_mm": 0, "z_mm": 10, "direction": "z"}
    sensors = [point | {"name": name} for name in ("one", "other")]
    write_config(tmp_path, {"small": CASE | {"sensors": sensors}, "plain": CASE})
    contents = Contents(load_study(tmp_path, {"cases": ["small", "plain"]}), DISPLAYS)
    found = contents.select("sensors")
    assert {artefact.case for artefact in found} == {"small"}
    assert {artefact.form for artefact in found} == {"figure", "table"}
