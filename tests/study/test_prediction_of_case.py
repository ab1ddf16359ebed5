"""Backbones that were held aside from the fit of a case, beside what it predicts."""

import numpy as np
import pytest
from measured_bar import (
    MEASURED,
    OF_SECOND,
    SECOND,
    TRUTH,
    backbone,
    calibration_of_truth,
    case_with,
    predicted,
    prediction_of_truth,
    written,
)

from boltjoint.calibration import model_curves
from boltjoint.calibration.level_path import NotReached
from boltjoint.report.figures.calibration import plot_prediction
from boltjoint.study.tables.calibration import tabulate_prediction


def test_the_second_mode_lies_within_the_bands_of_the_fit_of_the_first():
    prediction = prediction_of_truth()
    assert prediction["draws_reached"].item() == 200
    # 19 of 20 on average
    assert (prediction["points_within"] >= 17).all()
    # noise is 0.02 and 1 %
    assert prediction["rms_error"].to_numpy()[0] == pytest.approx([2e-4, 0.01], rel=0.5)
    for name, scatter in (("frequency", 2e-4), ("damping_ratio", 0.01)):
        low, high = prediction[f"{name}_low"], prediction[f"{name}_high"]
        # that of a measurement is in it
        assert (high - low > 3.2 * scatter * prediction[name]).all()
        assert (low < prediction[f"model_{name}"]).all() and (
            prediction[f"model_{name}"] < high
        ).all()
    assert prediction["shift_low"] < prediction["shift_measured"] < prediction["shift_high"]
    f, _ = backbone(TRUTH, 2, OF_SECOND)
    assert prediction["shift_predicted"].item() == pytest.approx(f[-1] - f[0], rel=0.05)
    said = prediction.attrs["answer"]
    assert said.startswith("Predicted, not fitted: mode-2 is off by 0.0")
    assert "of 20 points within the 95 % bands; its frequency shifts by −" in said
    assert "reliable" not in said


def test_amplitudes_that_the_model_does_not_reach_are_said(monkeypatch):
    def not_reached(*_):
        raise NotReached("no mode was found at the amplitude 1")

    monkeypatch.setattr(model_curves, "solve_points", not_reached)
    text = written(backbone(TRUTH, 2, OF_SECOND), amplitudes=OF_SECOND)
    prediction = predicted(case_with(predicted=[SECOND]), calibration_of_truth(), text)
    said = "mode-2 cannot be predicted: the model does not reach its amplitudes"
    assert prediction.attrs["answer"] == f"Predicted, not fitted: {said}."
    table = tabulate_prediction(prediction)
    assert np.isnan(table["frequency_error_percent"]).all() and (table["points"] == 20).all()


def test_bands_that_no_draw_or_few_make_are_said():
    text = written(backbone(TRUTH, 2, OF_SECOND), amplitudes=OF_SECOND)
    case, calibration = case_with(predicted=[SECOND]), calibration_of_truth()
    none = calibration.isel(draw=slice(0))
    none.attrs = calibration.attrs | {"pareto_k": np.inf}
    said = predicted(case, none, text).attrs["answer"]
    assert "without bands: no posterior draw reaches its amplitudes" in said
    assert "(Pareto k without limit)" in said
    one_point = "\n".join(text.splitlines()[:2]) + "\n"
    said = predicted(case, calibration, one_point).attrs["answer"]
    assert "of 1 points within the 95 % bands." in said and "shifts" not in said


def test_draws_that_do_not_stand_for_the_posterior_are_said():
    calibration = calibration_of_truth().copy()
    calibration.attrs = calibration.attrs | {"pareto_k": 0.9}
    text = written(backbone(TRUTH, 2, OF_SECOND), amplitudes=OF_SECOND)
    said = predicted(case_with(predicted=[SECOND]), calibration, text).attrs["answer"]
    assert "The bands are not reliable" in said and "(Pareto k 0.9)" in said


def test_another_calibration_is_refused():
    other = MEASURED["parameters"] | {"frequency_ratio": {"low": 0.9, "high": 1.1}}
    case = case_with(predicted=[SECOND], parameters=other)
    with pytest.raises(ValueError, match=r"calibration is of .*, not of .*frequency_ratio"):
        predicted(case, calibration_of_truth(), written(backbone(TRUTH, 2, OF_SECOND)))


def test_table_and_figure_show_points_curve_and_band():
    prediction = prediction_of_truth()
    (row,) = tabulate_prediction(prediction).to_dict("records")
    with pytest.raises(ValueError, match="prediction has no variable 'curve' over curve"):
        tabulate_prediction(prediction.drop_vars("curve"))
    assert row["curve"] == "mode-2" and row["resonance"] == 2 and row["points"] == 20
    assert row["frequency_in_band"] >= 17
    assert row["shift_from_Hz"] < row["shift_measured_Hz"] < row["shift_to_Hz"] < 0
    frequency, damping = plot_prediction(prediction).axes
    for axes, name, factor in ((frequency, "frequency", 1), (damping, "damping_ratio", 100)):
        points, curve = axes.lines
        np.testing.assert_allclose(points.get_ydata(), factor * prediction[name])
        np.testing.assert_allclose(curve.get_ydata(), factor * prediction[f"model_{name}"])
        (band,) = (each for each in axes.collections if each.get_alpha() == 0.3)
        reach = band.get_datalim(axes.transData)
        assert reach.y1 == pytest.approx(factor * float(prediction[f"{name}_high"].max()))
    assert damping.get_xlabel() == "displacement (m)"
    figure = frequency.figure
    assert {text.get_text() for text in figure.legends[0].get_texts()} == {
        "measured, 95 %",
        "predicted, with the 95 % band of a measurement",
    }
