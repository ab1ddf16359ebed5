"""Figures of sweeps: what they show of the designs."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from text_boxes import faults

from boltjoint.report.figures.sweeps import (
    plot_backbones,
    plot_bands,
    plot_peaks,
    plot_sensitivity,
    plot_tornado,
)


@pytest.fixture
def sweep():
    """Ninety-nine designs of two keys, of which the second does not vary, and a lost one."""
    number = np.arange(100.0)
    number[40] = np.nan
    response = number[:, None, None] * np.array([1.0, 2.0])[:, None] * np.array([1.0, 3.0, 2.0])
    each = ("design", "force")
    return xr.Dataset(
        {
            "peak_frequency": (each, 70 + np.column_stack([number, number])),
            "peak_amplitude": (each, response.max(axis=2) * 1e-3),
            "response_amplitude": ((*each, "frequency"), response * 1e-3),
            "reason": ("design", np.where(np.isnan(number), "lost", "")),
            "preload": ("design", np.arange(100.0) * 100, {"units": "N"}),
            "loss_factor": ("design", np.full(100, 0.002), {"units": "1"}),
            "force_level": ("force", [1.0, 10.0], {"units": "N"}),
        },
        coords={"frequency": [60.0, 70.0, 80.0]},
        attrs={"varied": "preload loss_factor"},
    )


def test_bands_hold_their_shares_of_the_designs(sweep):
    (axes,) = plot_bands(sweep).axes
    lines = axes.get_lines()
    np.testing.assert_allclose(lines[0].get_ydata(), 50 * np.array([1, 3, 2]))
    np.testing.assert_allclose(lines[1].get_ydata(), 100 * np.array([1, 3, 2]))
    outer = axes.collections[0].get_paths()[0].vertices
    expected = np.nanquantile(np.delete(np.arange(100.0), 40), [0.05, 0.95])
    assert (outer[:, 1].min(), outer[:, 1].max()) == pytest.approx((expected[0], 3 * expected[1]))
    texts = [text.get_text() for text in axes.get_legend().get_texts()]
    assert texts == ["1 N", "10 N", "90% of the designs", "50% of the designs", "median"]


@pytest.mark.filterwarnings("error")
def test_bands_end_where_no_design_has_a_response(sweep):
    within = sweep["response_amplitude"].where(sweep["frequency"] > 65)
    (axes,) = plot_bands(sweep.assign(response_amplitude=within)).axes
    for line, whole in zip(axes.get_lines(), plot_bands(sweep).axes[0].get_lines(), strict=True):
        assert np.isnan(line.get_ydata()[0])
        np.testing.assert_array_equal(line.get_ydata()[1:], whole.get_ydata()[1:])


def test_peaks_are_drawn_over_what_varies(sweep):
    figure = plot_peaks(sweep)
    frequency, amplitude = figure.axes
    assert amplitude.get_xlabel() == "preload (N)"
    x, y = frequency.get_lines()[0].get_data()
    np.testing.assert_allclose(y[np.isfinite(y)], 70 + x[np.isfinite(y)] / 100)
    assert np.isnan(y).sum() == 1
    np.testing.assert_allclose(amplitude.get_lines()[1].get_ydata()[-1], 99 * 2 * 3)


def test_a_grid_is_drawn_as_its_designs():
    grid = xr.Dataset(
        {
            "peak_frequency": (("preload", "mu"), np.arange(6.0).reshape(3, 2)),
            "peak_amplitude": (("preload", "mu"), np.ones((3, 2))),
            "reason": (("preload", "mu"), np.full((3, 2), "")),
        },
        coords={
            "preload": ("preload", [1.0, 2.0, 3.0], {"units": "N"}),
            "mu": ("mu", [0.1, 0.2], {"units": "1"}),
        },
        attrs={"varied": "preload mu"},
    )
    figure = plot_peaks(grid)
    x, y = figure.axes[1].get_lines()[0].get_data()
    np.testing.assert_allclose(x, [0.1, 0.2] * 3)
    np.testing.assert_allclose(y, range(6))


def indices(**first_order):
    """The table of Sobol indices of some keys."""
    return pd.DataFrame(
        {
            "observed": observed,
            "key": key,
            "first_order": first,
            "first_order_low": first - 0.1,
            "first_order_high": first + 0.1,
            "total": first + 0.2,
            "total_low": first,
            "total_high": first + 0.3,
        }
        for observed in ("peak_frequency_Hz", "peak_mm")
        for key, first in first_order.items()
    )


def test_indices_have_bars_and_intervals():
    figure = plot_sensitivity(indices(preload=0.3, loss_factor=0.5))
    heights = sorted(bar.get_height() for bar in figure.axes[1].patches)
    np.testing.assert_allclose(heights, [0.3, 0.5, 0.5, 0.7])
    labels = [label.get_text() for label in figure.axes[1].get_xticklabels()]
    assert labels == ["preload", "loss factor"]


@pytest.mark.parametrize("count", [6, 8, 9, 20])
def test_long_names_of_many_keys_are_apart(count):
    long = [f"static_friction_coefficient_{number}" for number in range(count)]
    figure = plot_sensitivity(indices(**dict.fromkeys(long, 0.3)))
    assert not faults(figure)
    labels = [label.get_text() for label in figure.axes[1].get_xticklabels()]
    assert [label.split() for label in labels] == [name.split("_") for name in long]


def extremes(levels=(None,)):
    return pd.DataFrame(
        [
            {"observed": observed, "key": key, "unit": unit, "mean": mean}
            | ({} if level is None else {"force_N": level})
            | {"low_bound": 8000.0, "low_mean": mean * (1 - move), "low_half_width": 0.1}
            | {"high_bound": 1.2e8, "high_mean": mean * (1 + 2 * move), "high_half_width": 0.1}
            for observed, mean in (("peak_frequency_Hz", 70.0), ("peak_mm", 2.0))
            for level in levels
            for key, unit, move in (("loss_factor", "1", 0.01), ("preload", "N", -0.2))
        ]
    )


def test_the_key_that_moves_most_is_uppermost():
    frequency, amplitude = plot_tornado(extremes()).axes
    labels = [label.get_text() for label in frequency.get_yticklabels()]
    assert labels == ["loss factor\n≤ 8000, ≥ 1.2 × 10⁸", "preload\n≤ 8000, ≥ 1.2 × 10⁸ N"]
    ends = [round(bar.get_width(), 6) for bar in frequency.patches]
    # the low ends, in the order of the table, then the high ends
    assert ends == [-0.7, 14, 1.4, -28]
    assert [round(bar.get_width(), 6) for bar in amplitude.patches] == [-1, 20, 2, -40]
    assert amplitude.get_xlabel() == "change of the mean peak amplitude (%)"


def test_each_level_has_its_bars():
    figure = plot_tornado(extremes((1.0, 10.0)))
    assert len(figure.axes[0].patches) == 2 * 2 * 2
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["1 N", "10 N"]
    centres = {round(bar.get_y() + bar.get_height() / 2, 6) for bar in figure.axes[0].patches}
    assert len(centres) == 4


def test_a_tornado_of_nothing_is_empty():
    figure = plot_tornado(pd.DataFrame(columns=["observed", "key"]))
    assert not any(axes.patches for axes in figure.axes)


@pytest.fixture
def backbones(sweep):
    amplitude = np.geomspace(1e-6, 1e-3, 4)
    number = np.arange(100.0)[:, None]
    damping = number * 1e-3 * np.array([1.0, 2.0, 3.0, 2.0])
    damping[40] = np.nan
    found = {
        "natural_frequency": (("design", "amplitude"), 100 - number * [0.0, 0.1, 0.2, 0.3]),
        "damping_ratio": (("design", "amplitude"), damping),
    }
    return sweep.assign(found).assign_coords(amplitude=amplitude)


def test_backbones_of_many_designs_are_bands(backbones):
    frequency, damping = plot_backbones(backbones).axes
    (line,) = damping.get_lines()
    np.testing.assert_allclose(line.get_xdata(), np.geomspace(1e-3, 1, 4))
    np.testing.assert_allclose(line.get_ydata(), 0.05 * np.array([1, 2, 3, 2]))
    assert (len(damping.collections), damping.get_yscale()) == (2, "log")
    assert damping.get_xlabel() == "amplitude of the output point (mm)"
    assert frequency.get_ylabel() == "natural frequency (Hz)"


def test_backbones_of_few_designs_are_lines_with_their_values(backbones):
    few = backbones.isel(design=[1, 40, 2])
    figure = plot_backbones(few)
    lines = figure.axes[1].get_lines()
    np.testing.assert_allclose(lines[1].get_ydata(), 2e-3 * np.array([1, 2, 3, 2]))
    (legend,) = figure.legends
    words = [text.get_text() for text in legend.get_texts()]
    assert words == ["preload = 100 N", "preload = 200 N"]


def test_no_backbones_are_an_empty_figure(backbones):
    lost = backbones.assign(damping_ratio=np.nan * backbones["damping_ratio"])
    assert not plot_backbones(lost).axes[0].get_lines()
