"""Figure and tables of a fit to a measurement, and what the page says of it."""

import numpy as np
import pytest
from figure_parts import legend_texts
from measured_bar import AMPLITUDES, FRICTION, TRUTH, calibration_of_truth
from small_study import CASE, write_config

from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.backbones import plot_calibration
from boltjoint.study.artefact_list import Contents
from boltjoint.study.tables.calibration import (
    tabulate_correlation,
    tabulate_parameters,
    tabulate_residuals,
)


def test_points_curve_and_residuals_are_drawn_of_both_quantities():
    calibration = calibration_of_truth()
    frequency, of_frequency, damping, of_damping = plot_calibration(calibration).axes
    assert set(legend_texts(frequency)) == {"measured, 95 %", "fitted, with its 95 % band"}
    for axes, name, factor in ((frequency, "frequency", 1), (damping, "damping_ratio", 100)):
        points, curve = axes.lines
        np.testing.assert_allclose(points.get_ydata(), factor * calibration[name])
        assert points.get_xdata() == pytest.approx(AMPLITUDES)
        np.testing.assert_allclose(curve.get_ydata(), factor * calibration[f"grid_{name}"])
        assert curve.get_xdata()[[0, -1]] == pytest.approx(AMPLITUDES[[0, -1]])
    for axes in (of_frequency, of_damping):
        residual = axes.lines[1].get_ydata()
        # of noise as stated
        assert 0.5 < np.sqrt(np.mean(residual**2)) < 1.5
    assert of_damping.get_xlabel() == "displacement (m)"


def test_tables_have_parameters_correlation_and_residuals():
    calibration = calibration_of_truth()
    parameters = tabulate_parameters(calibration).set_index("parameter")
    assert list(parameters.index) == list(TRUTH)
    assert parameters.loc[FRICTION, "before"] == 0.1
    assert (parameters["95_%_from"] < parameters["fitted"]).all()
    assert (parameters["fitted"] < parameters["95_%_to"]).all()
    assert (parameters["not_determined"] == "").all()
    correlation = tabulate_correlation(calibration).set_index("parameter").to_numpy()
    np.testing.assert_allclose(np.diag(correlation), 1)
    np.testing.assert_allclose(correlation, correlation.T)
    residuals = tabulate_residuals(calibration)
    assert list(residuals["quantity"]) == ["frequency", "damping"]
    assert (residuals["points"] == AMPLITUDES.size).all()
    # noise is 0.02 and 1 %
    assert residuals["rms_error_percent"].tolist() == pytest.approx([0.02, 1], rel=0.5)


def test_cases_with_a_measurement_have_figure_and_tables(tmp_path):
    write_config(tmp_path, {"small": CASE, "plain": CASE})
    (tmp_path / "config/bar.csv").write_text(
        "displacement_mm,frequency_Hz,damping_ratio\n0.1,340,0.01\n0.2,339,0.02\n"
    )
    measured = {
        "curves": [
            {
                "file": "config/bar.csv",
                "resonance": 1,
                "frequency_error_percent": 0.1,
                "damping_error_percent": 5,
            }
        ],
        "parameters": {"loss_factor": {"low": 1e-4, "high": 0.1}},
        "joint": "regions=2",
    }
    write_config(tmp_path, {"small": CASE | {"measured": measured}, "plain": CASE})
    contents = Contents(load_study(tmp_path, {"cases": ["small", "plain"]}), DISPLAYS)
    found = contents.select("calibration", "fitted_parameters", "parameter_correlation")
    assert {artefact.case for artefact in found} == {"small"}
    assert {artefact.joint for artefact in found} == {"regions=2"}
    assert {artefact.form for artefact in found} == {"data", "figure", "table"}
