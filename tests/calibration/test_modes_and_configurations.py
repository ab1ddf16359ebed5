"""Which mode of a model was measured, and models that differ from one curve to another."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_joint import AMPLITUDES, FAST, MODEL, PARAMETERS, TRUTH, curve_of, synthetic

from boltjoint import MeasuredBackbone, fit
from boltjoint.calibration.mode_pairing import modal_assurance
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import Parameter, ParameterSpace
from boltjoint.dynamics.backbone.backbone_at import backbone_at

SPACE = ParameterSpace(PARAMETERS)
SENSORS = {"tip": [2.0, -1.9, 1.8], "middle": [0.3, 1.5, -0.4], "root": [-0.9, 0.6, 1.7]}


def sensed(values):
    """The joint with three sensors."""
    joint, damping = MODEL(values)
    modes = np.array(list(SENSORS.values()))
    return replace(joint, sensor_mode=modes, sensor_name=tuple(SENSORS)), damping


def shape_of(mode, turn=0.0):
    """Amplitudes of the sensors in a mode without contact, and some of the next one."""
    return {name: row[mode] + turn * row[(mode + 1) % 3] for name, row in SENSORS.items()}


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_a_mode_is_paired_by_its_shape(mode):
    """The frequency is that of another one, as where a model is off."""
    joint, _ = sensed(TRUTH)
    assurance = modal_assurance(shape_of(mode, 0.1), joint)
    assert np.argmax(assurance) == mode
    assert assurance[mode] > 0.9
    nearest = np.sqrt(np.prod(joint.resonance_range()[mode])) * 1.5
    curve = MeasuredBackbone([1e-6], [nearest], 0.1, [0.01], 0.001, shape=shape_of(mode, 0.1))
    assert ModelCurves(sensed, (curve,), SPACE).resonances == (mode + 1,)


def test_the_criterion_does_not_depend_on_scale_and_sign():
    joint, _ = sensed(TRUTH)
    shape = shape_of(1, 0.2)
    turned = {name: -30 * value for name, value in shape.items()}
    assert modal_assurance(turned, joint) == pytest.approx(modal_assurance(shape, joint))


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        ({"tip": 1.0, "elbow": 2.0}, "sensor elbow is none of tip, middle, root"),
        ({"tip": 2.0, "middle": -4.0, "root": -5.0}, "that of no mode of the model"),
        ({"tip": 1.0, "middle": -0.5}, "do not tell modes 2 and 3 apart"),
    ],
)
def test_shapes_that_tell_no_mode_are_refused(shape, said):
    curve = MeasuredBackbone([1e-6], [600.0], 0.1, [0.01], 0.001, shape=shape)
    with pytest.raises(ValueError, match=said):
        ModelCurves(sensed, (curve,), SPACE)


def test_modes_that_may_all_be_at_a_frequency_are_not_guessed():
    """With bounds of decades the ranges of two modes overlap."""
    wide = (Parameter("tangential_stiffness", 1e3, 1e12), *PARAMETERS[1:])
    curve = MeasuredBackbone([1e-6], [500.0], 0.1, [0.01], 0.001)
    with pytest.raises(ValueError, match="modes 1 and 2 of the model may be at 500 Hz"):
        ModelCurves(MODEL, (curve,), ParameterSpace(wide))
    told = replace(curve, resonance=2)
    assert ModelCurves(MODEL, (told,), ParameterSpace(wide)).resonances == (2,)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"shape": {"tip": 1.0}}, "two that move are needed"),
        ({"shape": {"tip": 1.0, "root": 0.0}}, "two that move are needed"),
        ({"shape": {"tip": 1.0, "root": 1.0}, "resonance": 1}, "one of them tells its mode"),
        ({"configuration": {"preload_N": None}}, "preload_N of configuration"),
    ],
)
def test_curves_that_contradict_themselves_are_refused(changed, said):
    with pytest.raises(ValueError, match=said):
        replace(synthetic(), **changed)


def test_configurations_are_fitted_at_once():
    """Half the friction in one test: fitted values are those of both, not of either."""
    curves = [synthetic(1)]
    joint, damping = MODEL({**TRUTH, "slip_force": 18.0})
    loose = np.column_stack(backbone_at(joint, AMPLITUDES, damping=damping))
    curves.append(
        curve_of(loose, AMPLITUDES, 0.01, 2, name="loose", configuration={"slip_force": 18.0})
    )
    found = fit(MODEL, curves, PARAMETERS, options=FAST)
    assert not found.refusals
    for name, value in TRUTH.items():
        low, high = found.interval(name)
        assert low < value < high
    alone = fit(MODEL, curves[0], PARAMETERS, options=FAST)
    assert np.all(found.standard_error < alone.standard_error)
    without = [curves[0], replace(curves[1], configuration={})]
    assert fit(MODEL, without, PARAMETERS, options=FAST).refusals


def test_unknown_names_of_a_configuration_are_refused():
    with pytest.raises(ValueError, match="parameter preload is none of the joint"):
        fit(MODEL, replace(synthetic(), configuration={"preload": 1.0}), PARAMETERS)
