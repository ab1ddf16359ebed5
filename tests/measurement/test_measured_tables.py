"""Public measurements in ``resources/measured``."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from boltjoint.measurement.identification import IdentifiedMode, scatter_between
from boltjoint.measurement.stepped_sine import identify_constant_response

TABLES = Path(__file__).parents[2] / "resources/measured"


def hammer_mode(rows):
    return IdentifiedMode(
        rows["time_s"].to_numpy(),
        rows["acceleration_m_per_s2"].to_numpy(),
        rows["frequency_Hz"].to_numpy(),
        rows["frequency_std_Hz"].to_numpy(),
        rows["damping_ratio"].to_numpy(),
        rows["damping_ratio_std"].to_numpy(),
        np.zeros(len(rows)),
        rows["sensor"].iloc[0],
        "acceleration",
        "analytic signal",
    )


@pytest.mark.parametrize("mode", [1, 2, 3, 4])
def test_three_sensors_of_a_hammer_test_agree_within_their_intervals(mode):
    table = pd.read_csv(TABLES / "brake_reuss_hammer_backbones.csv")
    of_mode = table[table["mode"] == mode]
    modes = [hammer_mode(rows) for _, rows in of_mode.groupby("sensor")]
    assert len(modes) == 3
    scatter = scatter_between(modes)
    assert scatter.frequency_over_error < 1
    assert scatter.damping_over_error < 1
    assert np.median(scatter.frequency_scatter / scatter.frequency) < 2e-4
    for first, second in ((0, 1), (0, 2), (1, 2)):
        pair = scatter_between([modes[first], modes[second]])
        # of normal errors half lie within 0.67 of them
        assert pair.frequency_over_error < 1
        assert pair.damping_over_error < 1


def test_stepped_sines_at_constant_response_have_the_published_damping():
    table = pd.read_csv(TABLES / "brake_reuss_stepped_sine.csv")
    found = [
        identify_constant_response(
            rows["frequency_Hz"].to_numpy(),
            rows["acceleration_m_per_s2"].to_numpy(),
            rows["force_N"].to_numpy(),
            rows["phase_rad"].to_numpy(),
            "acceleration",
        )
        for _, rows in table[table["controlled"] == "response"].groupby("level")
    ]
    amplitude = [each.amplitude for each in found]
    assert amplitude == pytest.approx([5, 20.1, 29.8, 40, 50.2, 60.2, 70.3, 80.4], rel=0.01)
    # frequency steps of the measurement are 0.05 Hz
    peaks = [80.35, 80.2, 80.2, 80.15, 80.25, 80.35, 80.45, 80.5]
    assert [each.frequency for each in found] == pytest.approx(peaks, abs=0.06)
    # 0.30 % at 40 m/s2: the ratio of force and response at the peak says so too
    assert found[3].damping_ratio == pytest.approx(0.0030, abs=1e-4)
    # modal mass is a constant of the mode
    mass = np.array([each.modal_mass for each in found])
    assert mass.std() < 0.03 * abs(mass.mean())
