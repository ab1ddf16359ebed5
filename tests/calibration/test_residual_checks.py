"""Models that cannot be right, on public measurements and made-up residuals."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from calibrated_joint import synthetic

import boltjoint
from boltjoint.calibration.fit import CalibrationOptions
from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.calibration.parameters import Parameter
from boltjoint.calibration.residual_checks import (
    check_curve,
    losing_damping,
    runs_probability,
    stiffening,
)
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint.model import Joint

TABLES = Path(__file__).parents[2] / "resources/measured"


def one_mode(curve):
    """One mode with one Iwan element, and the parameters of both."""
    f, a = curve.frequency, curve.amplitude
    w = 2 * np.pi * f.max()
    one = np.ones(1)
    law = FourParameterIwan([0], [0.2 * w**2], [0.2 * w**2 * a.max()], [-0.5], [1.0])
    joint = Joint(
        0.9 * f.max() * one, one, one, one[:, None], np.zeros((1, 3)), law, np.zeros((1, 3))
    )
    parameters = [
        Parameter("natural_frequency[1]", 0.5 * f.min(), 0.999 * f.min()),
        Parameter("tangential_stiffness", 1e-3 * w**2, 2 * w**2),
        Parameter("slip_force", 1e-4 * w**2 * a.max(), 10 * w**2 * a.max()),
        Parameter("chi", -0.95, 0.0, logarithmic=False),
        Parameter("beta", 1e-3, 1e2),
        Parameter("loss_factor", 1e-5, 1e-2),
    ]
    return joint, parameters


def test_friction_alone_must_not_fit_a_decay_that_stiffens():
    table = pd.read_csv(TABLES / "brake_reuss_resonance_decay_backbone.csv")
    a, f, z = table.to_numpy().T
    curve = MeasuredBackbone(
        a[::3], f[::3], 0.02 * np.ptp(f), z[::3], 0.05 * z[::3], quantity="modal", name="decay"
    )
    joint, parameters = one_mode(curve)
    found = boltjoint.fit(joint, curve, parameters, options=CalibrationOptions(starts=1))
    (check,) = found.checks_of_curves
    assert check.stiffens
    assert check.size_probability[0] < 1e-10
    sentences = " ".join(found.refusals)
    assert "the frequency rises by 0.195 Hz from the amplitude 33" in sentences
    assert "times its stated scatter" in sentences
    assert found.summary().startswith("The model cannot be right: decay")
    assert found.p_value < 1e-10


def test_a_model_that_is_right_is_not_refused():
    from calibrated_joint import MODEL, PARAMETERS, TRUTH

    parameters = [
        Parameter(p.name, p.low, p.high, p.logarithmic, TRUTH[p.name]) for p in PARAMETERS
    ]
    refused = 0
    for seed in range(8):
        options = CalibrationOptions(starts=1)
        found = boltjoint.fit(MODEL, synthetic(seed), parameters, options=options)
        refused += bool(found.refusals)
        assert found.p_value > 1e-3
    assert refused == 0


def test_runs_are_counted_as_by_all_orders():
    # of 4 and 4 signs in 70 orders: 2 runs in 2 of them
    few = np.array([1.0, 1, 1, 1, -1, -1, -1, -1])
    assert runs_probability(few) < 0.05
    assert runs_probability(few * np.tile([1, -1], 4)) > 0.5
    random = np.random.default_rng(0)
    low = np.mean([runs_probability(random.standard_normal(40)) < 0.05 for _ in range(2000)])
    assert low == pytest.approx(0.05, abs=0.025)
    assert runs_probability(np.ones(20)) < 1e-5


def test_only_a_rise_beyond_the_scatter_stiffens():
    a = np.arange(1.0, 6.0)
    falling = [100.0, 99.0, 98.0, 97.0, 97.05]
    zeta = np.full(5, 0.01)
    assert stiffening(MeasuredBackbone(a, falling, 0.05, zeta, 1e-3)) is None
    rise = stiffening(MeasuredBackbone(a, falling, 0.005, zeta, 1e-3))
    assert rise == pytest.approx((4.0, 0.05))
    curve = MeasuredBackbone(a, falling, 0.05, zeta, 1e-3)
    right = np.column_stack([falling, zeta])
    assert check_curve(curve, right).sentences == ()
    assert (
        "damping is off by 10 times"
        in check_curve(curve, right + np.array([0.0, 0.01])).sentences[0]
    )


def test_damping_that_falls_faster_than_in_full_slip_is_told():
    a = np.geomspace(1e-6, 1e-3, 12)
    f = np.full(12, 100.0)
    # micro-slip, then full slip: the damping falls as 1 / amplitude
    slip = np.minimum(a / 1e-4, 1e-4 / a)
    steep = np.where(a > 1e-4, slip * 1e-4 / a, slip)
    model = np.column_stack([f, 0.02 * slip])
    assert losing_damping(MeasuredBackbone(a, f, 0.1, 0.02 * slip, 1e-4), model) is None
    curve = MeasuredBackbone(a, f, 0.1, 0.02 * steep, 0.05 * 0.02 * steep, name="tail")
    start, fall = losing_damping(curve, model)
    assert 5e-5 < start < 2e-4 and fall == pytest.approx(0.9, abs=0.1)
    sentences = check_curve(curve, model).sentences
    assert any("on the damping falls by" in sentence for sentence in sentences)
    assert check_curve(curve, model).loses_damping
    # accelerations have the frequency in them: in full slip the damping falls over them too
    softer = np.where(a > 1e-4, 90.0, 100.0)
    acceleration = a * (2 * np.pi * softer) ** 2
    slips = 0.02 * slip * (100 / softer) ** 2
    measured = MeasuredBackbone(acceleration, softer, 0.01, slips, 1e-5, quantity="acceleration")
    flat = np.column_stack([softer, np.full(12, 0.02)])
    assert losing_damping(measured, flat) is None
    # a model that does so too is not refused for it, nor a fall within the scatter
    assert losing_damping(curve, np.column_stack([f, 0.02 * steep])) is None
    wide = MeasuredBackbone(a, f, 0.1, 0.02 * steep, 0.5 * 0.02 * steep)
    assert losing_damping(wide, model) is None
