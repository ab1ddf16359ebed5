"""Figure and tables of a fit to a measurement, and what the page says of it."""

import numpy as np
import pytest
import xarray as xr
from figure_parts import legend_texts
from measured_bar import AMPLITUDES, FRICTION, TRUTH, calibration_of_truth
from small_study import CASE, write_config

from boltjoint.config.study import load_study
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.figures.calibration import plot_calibration, plot_fitted_responses
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


def test_responses_of_two_quantities_have_axes_of_their_own():
    """Each in its unit, over one frequency, with the phases of those that have them."""
    points = np.arange(4)
    of_point = np.repeat([0, 1], 4)
    frequency = np.tile([100.0, 101.0, 102.0, 103.0], 2)
    phase = np.where(of_point == 0, -1.0, np.nan)
    columns = {
        "response_of_point": of_point,
        "response_frequency": frequency,
        "response_amplitude": np.repeat([2.0, 3e-6], 4),
        "response_excitation": np.repeat([1.0, 1.5], 4),
        "response_excitation_deviation": np.full(8, 0.1),
        "model_excitation": np.repeat([1.1, 1.5], 4),
        "response_phase": phase,
        "model_phase": phase,
    }
    calibration = xr.Dataset(
        {
            **{name: ("response_point", values) for name, values in columns.items()},
            "response": ("response", ["shaker", "laser"]),
            "response_amplitude_quantity": ("response", ["acceleration", "displacement"]),
            "response_amplitude_unit": ("response", ["m/s2", "m"]),
        }
    )
    calibration["response_excitation"].attrs["units"] = "N"
    axes = plot_fitted_responses(calibration).axes
    assert len(axes) == 6
    assert [each.get_ylabel() for each in axes[:2]] == [
        "acceleration per excitation\n(m/s2/N)",
        "displacement per excitation\n(m/N)",
    ]
    measured, fitted, *_ = axes[0].lines
    np.testing.assert_allclose(measured.get_ydata(), 2.0)
    np.testing.assert_allclose(fitted.get_ydata(), 2.0 / 1.1)
    residual = axes[4].lines[0]
    np.testing.assert_allclose(residual.get_ydata(), np.log(1.1) / 0.1)
    assert residual.get_xdata()[points].tolist() == [100.0, 101.0, 102.0, 103.0]
    np.testing.assert_allclose(axes[2].lines[0].get_ydata(), np.rad2deg(-1.0))
