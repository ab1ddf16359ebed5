"""The figure of microslip: what is drawn of backbones, fits and peaks."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from figure_parts import curves, legend_texts, texts_in

from boltjoint.report.figures.backbones import Peaks, plot_microslip
from boltjoint.study.tables.backbones import tabulate_microslip


def backbone(power=2.5):
    """Dissipation of a power below an amplitude of 1 mm, and proportional to it above."""
    amplitude = np.geomspace(1e-8, 1e-1, 141)
    relative = amplitude / 1e-3
    dissipation = np.where(relative < 1, relative**power, relative) * (amplitude > 1e-7)
    return xr.Dataset(
        {
            "modal_amplitude": ("state", amplitude),
            "response_amplitude": ("state", amplitude),
            "natural_frequency": ("state", 70 + 6 / (1 + relative)),
            "friction_dissipation": ("state", dissipation + 1e-30),
        }
    )


@pytest.fixture
def joints():
    return {"node-to-node": backbone(), "regions=6": backbone(3.0)}


def test_each_joint_has_its_curve_its_power_and_its_peaks(joints):
    table = tabulate_microslip(joints)
    assert table["power"].to_list() == pytest.approx([2.5, 3.0], abs=1e-9)
    at = Peaks(np.array([1e-8, 1e-4]), np.array([76.0, 75.0]), np.array([1e-31, 0.1**2.5]))
    figure = plot_microslip(joints, table, {"node-to-node": at})
    lost, resonance = figure.axes
    drawn = curves(lost)
    x, y = drawn["node-to-node"].T
    np.testing.assert_allclose(x, joints["node-to-node"]["response_amplitude"] * 1e3)
    # rounding, where the joint sticks, is not drawn
    assert np.isnan(y[x < 1e-4]).all() and np.isfinite(y[x > 1e-3]).all()
    (low, high), (least, most) = drawn["microslip: power 2.50"].T
    assert np.log(most / least) / np.log(high / low) == pytest.approx(2.5)
    assert {"slope 2.50", "slope 3.00"} == set(texts_in(figure))
    assert "power 3, smooth spheres (Mindlin)" in legend_texts(lost)
    peaks = [line.get_ydata() for line in lost.get_lines() if line.get_marker() == "o"]
    assert np.isnan(peaks[0][0]) and peaks[0][1] == 0.1**2.5
    for axes in (lost, resonance):
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_a_joint_without_microslip_is_drawn_without_a_line(joints):
    table = tabulate_microslip(joints).assign(power=[np.nan, 3.0])
    figure = plot_microslip(joints, table, {})
    assert texts_in(figure) == ["slope 3.00"]
    assert "peak of a response" not in legend_texts(figure.axes[0])
    assert isinstance(table, pd.DataFrame)
