"""Calibration by synthetic backbones: parameters, intervals, and what cannot be told."""

import numpy as np
import pytest
from calibrated_joint import (
    AMPLITUDES,
    FAST,
    MODEL,
    PARAMETERS,
    TRUTH,
    curve_of,
    make_joint,
    synthetic,
    true_curves,
)

import boltjoint
from boltjoint.calibration.calibration import Undetermined
from boltjoint.calibration.fit import CalibrationOptions
from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import Parameter, ParameterSpace, Prior
from boltjoint.calibration.posterior_draws import pareto_shape
from boltjoint.joint.derived import rescale_contact
from boltjoint.measurement.identification import IdentifiedMode

SCALED = np.array([np.log(2e6), np.log(36.0), -0.5, np.log(0.004)])


def started(parameters=PARAMETERS):
    """The parameters with a first guess that is off by a factor."""
    return [
        Parameter(p.name, p.low, p.high, p.logarithmic, 0.7 * TRUTH[p.name], p.prior)
        for p in parameters
    ]


@pytest.fixture(scope="module")
def fitted():
    return boltjoint.fit(MODEL, synthetic(3), started(), options=FAST)


def test_parameters_are_found_without_noise():
    found = boltjoint.fit(MODEL, synthetic(), PARAMETERS, options=CalibrationOptions(starts=4))
    for name, value in TRUTH.items():
        assert found.value(name) == pytest.approx(value, rel=1e-6)
    assert found.costs.min() < 1e-8
    assert np.all(np.array(found.rms_errors) < 1e-6)


def test_intervals_hold_the_parameters_under_noise():
    ratios = []
    for seed in range(12):
        options = CalibrationOptions(starts=1)
        found = boltjoint.fit(MODEL, synthetic(seed), started(), options=options)
        assert found.undetermined == ()
        ratios.append((found.scaled - SCALED) / found.standard_error)
    # of 48 values, which are correlated, 2.4 lie outside on average
    assert 0.85 <= np.mean(abs(np.array(ratios)) < 1.96) <= 1.0
    assert 0.4 < np.std(ratios) < 1.6


def test_a_profile_is_the_interval_of_a_parabola_where_one_holds(fitted):
    low, high = fitted.profile("loss_factor")
    expected = fitted.interval("loss_factor")
    assert (low, high) == pytest.approx(expected, rel=0.05)
    assert low < TRUTH["loss_factor"] < high


def test_draws_stand_for_the_posterior(fitted):
    draws = fitted.draws(200)
    assert draws.pareto_k < 0.7
    assert draws.effective > 100
    deviation = draws.scaled.std(axis=0)
    assert deviation == pytest.approx(fitted.standard_error, rel=0.25)
    again = fitted.draws(200)
    np.testing.assert_array_equal(draws.scaled, again.scaled)


def test_pareto_shape_of_known_tails():
    random = np.random.default_rng(0)
    for k in (0.2, 1.0):
        weight = random.pareto(1 / k, 20_000) + 1
        assert pareto_shape(weight) == pytest.approx(k, abs=0.12)


def test_bands_hold_the_true_curves(fitted):
    (band,), (curves,) = fitted.bands(), fitted.curves()
    truth, _ = true_curves()
    ratio = abs(curves - truth) / band
    assert np.mean(ratio < 1.96) > 0.85
    measured = fitted.compared.measured[0]
    assert np.all(band[:, 0] < measured.frequency_deviation)


def test_what_is_not_reached_is_named_and_refused():
    # far below the knee, where slip force and stiffness of microslip go together
    amplitudes = np.geomspace(1e-7, 1e-6, 15)
    curve = curve_of(np.tile([110.0, 0.01], (15, 1)), amplitudes, resonance=1)
    given = boltjoint.fit(MODEL, synthetic(), started(), options=FAST)
    (curves,) = given.curves([amplitudes])
    for seed in range(3):
        curve = curve_of(curves, amplitudes, 0.01, seed, resonance=1)
        parameters = [*started(), Parameter("beta", 1e-3, 1e3)]
        found = boltjoint.fit(MODEL, curve, parameters, options=FAST)
        assert {"slip_force", "beta"} <= set(found.undetermined)
        with pytest.raises(Undetermined, match="slip_force cannot be told by this measurement"):
            found.value("slip_force")
        with pytest.raises(Undetermined):
            found.interval("beta")
        assert "beta cannot be told" in found.summary()
        assert found.condition > 100


def test_a_prior_determines_what_the_measurement_does_not():
    curve = synthetic(2)
    prior = Prior(1e-3, 0.05)
    wide = Parameter("amplitude_scale", 1e-2, 1e2)
    known = Parameter("amplitude_scale", 1e-2, 1e2, prior=Prior(1.0, 0.05))
    parameters = started()
    without = boltjoint.fit(MODEL, curve, [*parameters, wide], options=FAST)
    with_prior = boltjoint.fit(MODEL, curve, [*parameters, known], options=FAST)
    # amplitudes of another scale are those of another slip force
    assert without.correlation[1, -1] > 0.99
    assert with_prior.standard_error[-1] < 0.051
    assert with_prior.standard_error[1] < without.standard_error[1]
    assert prior.deviation == 0.05


def test_two_modes_and_a_scale_of_one_are_fitted_at_once():
    first, amplitudes = true_curves()
    second, _ = true_curves(resonance=2)
    curves = [
        curve_of(first, amplitudes, 0.01, 4, resonance=1, name="bending"),
        curve_of(second, amplitudes / 3, 0.01, 5, resonance=2, name="second"),
    ]
    parameters = [*started(), Parameter("amplitude_scale[second]", 0.1, 10.0)]
    found = boltjoint.fit(MODEL, curves, parameters, options=FAST)
    low, high = found.interval("amplitude_scale[second]")
    assert low < 3.0 < high
    assert high / low < 2


def test_a_robust_loss_ignores_an_outlier():
    curve = synthetic(1)
    frequency = curve.frequency.copy()
    frequency[10] *= 1.05
    spoiled = MeasuredBackbone(
        AMPLITUDES,
        frequency,
        curve.frequency_deviation,
        curve.damping_ratio,
        curve.damping_deviation,
        resonance=1,
    )
    plain = boltjoint.fit(MODEL, spoiled, started(), options=FAST)
    robust = boltjoint.fit(MODEL, spoiled, started(), loss="soft_l1", options=FAST)
    good = boltjoint.fit(MODEL, curve, started(), options=FAST)
    assert abs(robust.scaled - good.scaled)[0] < 0.3 * abs(plain.scaled - good.scaled)[0]
    assert any("frequency is off" in sentence for sentence in plain.refusals)


def test_keys_of_contact_are_fitted_by_a_function():
    from small_joint import connect_small

    keys = {"tangential_stiffness": 3e6, "friction_coefficient": 0.1}
    joint, _ = connect_small("constant", keys)

    def model(values):
        loss = values.pop("loss_factor")
        from boltjoint.damping import LossFactor

        return rescale_contact(joint, "constant", keys, keys | values), LossFactor(loss)

    parameters = [
        Parameter("tangential_stiffness", 1e6, 1e7, start=2e6),
        Parameter("friction_coefficient", 0.02, 0.5, start=0.2),
        Parameter("loss_factor", 1e-4, 1e-2, start=1e-3),
    ]
    lowest, highest = joint.resonance_range()[0]
    amplitudes = np.geomspace(1e-7, 3e-5, 12)
    near = curve_of(np.tile([(lowest + highest) / 2, 0.01], (12, 1)), amplitudes)
    space = ParameterSpace(tuple(parameters))
    compared = ModelCurves(model, (near,), space)
    curves, _ = compared.curves_at(space.scaled([3e6, 0.1, 2e-3]))[0]
    found = boltjoint.fit(
        model, curve_of(curves, amplitudes), parameters, options=CalibrationOptions(starts=1)
    )
    assert found.value("friction_coefficient") == pytest.approx(0.1, rel=1e-5)
    assert found.value("tangential_stiffness") == pytest.approx(3e6, rel=1e-5)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"resonance": 4}, "mode 4 is not in the model, which has 3 elastic modes"),
        ({"resonance": None, "frequency": np.full(20, 20.0)}, "mode at 20 Hz is not in the model"),
        ({"sensor": "tail"}, "sensor tail is none of output"),
        ({"amplitude": -AMPLITUDES}, "amplitude must be positive"),
        ({"frequency": np.full(19, 100.0)}, "frequency"),
        ({"quantity": "force"}, "quantity 'force' is not known"),
    ],
)
def test_impossible_curves_are_refused_before_anything_is_solved(change, sentence):
    curve = synthetic()
    given = {
        "amplitude": curve.amplitude,
        "frequency": curve.frequency,
        "frequency_deviation": 0.1,
        "damping_ratio": curve.damping_ratio,
        "damping_deviation": 1e-4,
        "resonance": 1,
    }
    with pytest.raises(ValueError, match=sentence) as refused:
        boltjoint.fit(MODEL, MeasuredBackbone(**given | change), PARAMETERS, options=FAST)
    assert "\n" not in str(refused.value)


def identified(quantity, sensor, amplitude, curves):
    """A mode of a record whose column has a name."""
    of_points = np.full(amplitude.size, 0.1)
    errors = (1e-3 * curves[:, 0], 1e-2 * curves[:, 1])
    values = (curves[:, 0], errors[0], curves[:, 1], errors[1])
    return IdentifiedMode(of_points, amplitude, *values, of_points, sensor, quantity, "")


def test_accelerations_are_displacements_times_the_square_of_the_frequency():
    """A column without a name is that of the output point."""
    curves, amplitudes = true_curves()
    w = 2 * np.pi * curves[:, 0]
    space = ParameterSpace(PARAMETERS)
    at = space.scaled(list(TRUTH.values()))
    for quantity, factor in (("displacement", 1), ("velocity", w), ("acceleration", w**2)):
        mode = identified(quantity, quantity, amplitudes * factor, curves)
        curve = MeasuredBackbone.of(mode, resonance=1)
        assert curve.sensor is None
        compared = ModelCurves(MODEL, (curve,), space)
        found, _ = compared.curves_at(at, slopes=False)[0]
        np.testing.assert_allclose(found, curves, rtol=1e-7)


def test_a_sensor_with_a_name_is_the_output_of_that_name():
    curves, amplitudes = true_curves()
    mode = identified("displacement", "tip", amplitudes, curves)
    assert MeasuredBackbone.of(mode).sensor == "tip"
    assert MeasuredBackbone.of(mode, sensor="output").sensor == "output"
    with pytest.raises(ValueError, match="sensor tip is none of output"):
        boltjoint.fit(MODEL, MeasuredBackbone.of(mode), PARAMETERS, options=FAST)


def test_impossible_parameters_are_refused_in_one_line():
    few = MeasuredBackbone([1e-5], [110.0], 0.1, [0.01], 1e-3)
    for task, sentence in (
        (lambda: Parameter("slip_force", 10.0, 1.0), "bounds of slip_force are reversed"),
        (lambda: Parameter("slip_force", 0.0, 1.0), "a logarithm needs it above 0"),
        (lambda: Parameter("chi", -1.0, 0.0, False, 3.0), "start of chi is 3"),
        (lambda: boltjoint.fit(MODEL, few, PARAMETERS), "too few for 4 parameters"),
        (lambda: boltjoint.fit(MODEL, synthetic(), []), "parameters is empty"),
        (lambda: boltjoint.fit(MODEL, [], PARAMETERS), "measured is empty"),
        (lambda: boltjoint.fit(MODEL, synthetic(), PARAMETERS[:1] * 2), "stands 2 times"),
        (lambda: boltjoint.fit(MODEL, synthetic(), PARAMETERS, loss="l1"), "loss 'l1'"),
        (
            lambda: boltjoint.fit(make_joint(), synthetic(), [Parameter("mu", 0.1, 1.0)]),
            "parameter mu is none of the joint",
        ),
    ):
        with pytest.raises(ValueError, match=sentence) as refused:
            task()
        assert "\n" not in str(refused.value)


def test_bands_of_a_mode_held_aside_are_the_same_of_several_processes(fitted):
    aside = synthetic(5, resonance=2)
    (alone,), (shared,) = (fitted.predict(aside, 250, processes=count) for count in (1, 2))
    assert shared.draws.shape == (250, AMPLITUDES.size, 2)
    assert np.array_equal(alone.draws, shared.draws)
    assert np.array_equal(alone.scatter, shared.scatter)
    # 95 % of 20 frequencies and damping ratios lie within
    assert min(shared.points_within) >= 16
    with pytest.raises(ValueError, match="processes"):
        fitted.predict(aside, 250, processes=0)
