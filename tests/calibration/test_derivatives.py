"""Derivatives of backbones at given amplitudes by all parameters."""

import time
from dataclasses import replace

import numpy as np
import pytest
from calibrated_joint import AMPLITUDES, MODEL, PARAMETERS, TRUTH, make_joint, synthetic
from small_joint import make_joint as make_other

from boltjoint import MeasuredResponse, backbone_at
from boltjoint.calibration import backbone_points, model_curves, response_points
from boltjoint.calibration.backbone_points import SensedMode, solve_points
from boltjoint.calibration.level_path import NotReached
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import JointParameters, Parameter, ParameterSpace
from boltjoint.damping import RayleighDamping
from boltjoint.dynamics.backbone.backbone import trace_backbone
from boltjoint.dynamics.backbone.epmc import EPMCEquations

LOSS = Parameter("loss_factor", 1e-4, 2e-2)


def differences(compared, at, n, step=1e-5):
    """Central differences, with the term of the third derivative taken out."""
    curves = []
    for h in (step, 2 * step):
        low, high = at.copy(), at.copy()
        low[n] -= h
        high[n] += h
        pair = [compared.curves_at(x, slopes=False)[0][0] for x in (low, high)]
        curves.append((pair[1] - pair[0]) / (2 * h))
    return (4 * curves[0] - curves[1]) / 3


def assert_exact(compared, at):
    curves, slopes = compared.curves_at(at)[0]
    for n, name in enumerate(compared.space.names):
        expected = differences(compared, at, n, 1e-4)
        # rounding of the frequency, over the step, where a parameter hardly moves it
        size = np.maximum(abs(expected).max(axis=0), 1e-3 * curves.max(axis=0))
        assert np.all(abs(slopes[:, :, n] - expected) < 1e-6 * size), name


@pytest.mark.parametrize("quantity", ["displacement", "acceleration"])
@pytest.mark.parametrize("resonance", [1, 2])
def test_derivatives_are_those_of_central_differences(resonance, quantity):
    space = ParameterSpace((*PARAMETERS, Parameter("amplitude_scale", 0.1, 10.0)))
    curve = synthetic(resonance=resonance, quantity=quantity)
    assert_exact(ModelCurves(MODEL, (curve,), space), space.scaled([*TRUTH.values(), 1.3]))


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_derivatives_of_other_laws(law):
    joint = make_other(40, law=law)
    names = [("tangential_stiffness", 3e8), ("slip_force", 300.0)]
    if law == "variable":
        names = [("tangential_stiffness", 3e8), ("friction_coefficient", 0.1)]
    parameters = [Parameter(name, value / 3, value * 3) for name, value in names]
    space = ParameterSpace((*parameters, LOSS))
    frequency = joint.resonance_range()[0].mean()
    amplitudes = np.array([1.3e-6, 2.1e-5, 1.7e-4])
    from calibrated_joint import curve_of

    curve = curve_of(np.tile([frequency, 0.01], (3, 1)), amplitudes, resonance=1)
    at = space.scaled([*(value for _, value in names), 0.003])
    assert_exact(ModelCurves(JointParameters(joint), (curve,), space), at)


def curve_of_kind(kind):
    if kind == "backbone":
        return synthetic()
    frequency = np.linspace(88.0, 92.0, 4)
    return MeasuredResponse(frequency, np.geomspace(1e-6, 1e-4, 4), 1.0, 0.1)


def shaken(values):
    """Damping that goes with the frequency, and a sensor that turns with a parameter."""
    joint, _ = JointParameters(make_joint())(
        {name: value for name, value in values.items() if name != "turn"}
    )
    turned = joint.response_mode * (1 + values["turn"] * np.arange(3))
    return replace(joint, response_mode=turned), RayleighDamping(0.5, 1e-6)


@pytest.mark.parametrize("kind", ["backbone", "response"])
def test_a_law_without_kernel_has_the_same_derivatives(kind, monkeypatch):
    names = [p for p in PARAMETERS if p.name != "loss_factor"]
    space = ParameterSpace([*names, Parameter("turn", 0.1, 1.0)])
    at = space.scaled([*(TRUTH[p.name] for p in names), 0.3])
    compared = ModelCurves(shaken, (curve_of_kind(kind),), space)
    ((values, slopes),) = compared.curves_at(at)
    for compiled in (backbone_points.CompiledMode, response_points.CompiledBalance):
        monkeypatch.setattr(compiled, "of", lambda *_: None)
    ((interpreted, their_slopes),) = compared.curves_at(at)
    np.testing.assert_allclose(values, interpreted, rtol=1e-9)
    # rounding over a step of 1e-6
    largest = abs(slopes).max(axis=(0, 2))
    assert np.all(abs(slopes - their_slopes).max(axis=(0, 2)) < 1e-8 * largest)


@pytest.mark.parametrize("kind", ["backbone", "response"])
def test_sensors_may_depend_on_parameters(kind):
    space = ParameterSpace([PARAMETERS[1], Parameter("turn", 0.1, 1.0)])
    others = {"tangential_stiffness": 2e6, "chi": -0.5}
    compared = ModelCurves(
        lambda values: shaken({**others, **values}), (curve_of_kind(kind),), space
    )
    assert_exact(compared, space.scaled([36.0, 0.3]))


@pytest.mark.parametrize("kind", ["backbone", "response"])
def test_a_sensor_that_does_not_move_has_no_curve(kind):
    still = replace(make_joint(), response_mode=np.zeros(3))
    space = ParameterSpace(PARAMETERS[:1])
    compared = ModelCurves(JointParameters(still, 0.002), (curve_of_kind(kind),), space)
    with np.errstate(all="ignore"), pytest.raises(NotReached, match=r"sensor|no motion was found"):
        compared.curves_at(space.scaled([2e6]))


def test_all_joints_of_a_model_have_as_many_modes(monkeypatch):
    def model(values):
        joint, damping = MODEL({})
        return (joint if values["slip_force"] <= 36 else cut(joint)), damping

    def cut(joint):
        names = "natural_frequency", "excitation_mode", "response_mode"
        fewer = {name: getattr(joint, name)[:2] for name in names}
        return replace(joint, **fewer, tangential_mode=joint.tangential_mode[:, :2])

    space = ParameterSpace([Parameter("slip_force", 3.0, 400.0)])
    with pytest.raises(ValueError, match="as many modes and harmonics whatever its parameters"):
        ModelCurves(model, (synthetic(),), space)
    # within bounds of as many, but not beside the parameters
    space = ParameterSpace([Parameter("slip_force", 3.0, 36.0)])
    compared = ModelCurves(model, (synthetic(),), space)
    compared.curves_at(space.scaled([30.0]))
    monkeypatch.setattr(model_curves, "neighbours_of", lambda at, *_: [at(space.scaled([37.0]))])
    with pytest.raises(ValueError, match="as many modes and harmonics whatever its parameters"):
        compared.curves_at(space.scaled([30.0]))


def test_points_are_those_of_the_traced_backbone():
    joint, damping = MODEL(TRUTH)
    points = solve_points(
        SensedMode(EPMCEquations(joint, damping, 1), joint.response_mode, "displacement"),
        AMPLITUDES,
    )
    frequency, zeta = backbone_at(joint, AMPLITUDES, damping=damping)
    assert points.values[:, 0] == pytest.approx(frequency, rel=1e-9)
    assert points.values[:, 1] == pytest.approx(zeta, rel=1e-6)


def test_all_derivatives_cost_less_than_a_traced_backbone():
    # of four parameters; the traced one with the same interpreted equations
    space = ParameterSpace(PARAMETERS)
    compared = ModelCurves(MODEL, (synthetic(),), space)
    at = space.scaled(list(TRUTH.values()))
    joint, damping = MODEL(TRUTH)

    def seconds(task):
        task()
        spent = []
        for _ in range(9):
            start = time.process_time()
            task()
            spent.append(time.process_time() - start)
        return min(spent)

    with_slopes = seconds(lambda: compared.curves_at(at))
    without = seconds(lambda: compared.curves_at(at, slopes=False))
    modal = AMPLITUDES[[0, -1]] / 2
    from boltjoint.dynamics.backbone import backbone

    one = seconds(
        lambda: backbone.trace(
            EPMCEquations(joint, damping, 1),
            EPMCEquations(joint, damping, 1).start(),
            tuple(np.log(modal)),
            backbone.StepControl(),
            scale=backbone.StepControl().amplitude_scale,
        )
    )
    assert trace_backbone(EPMCEquations(joint, damping, 1), tuple(modal)).complete
    assert with_slopes - without < one


def test_parameters_of_a_point_and_of_modes():
    joint = make_joint()
    model = JointParameters(joint)
    changed, damping = model(
        {"slip_force[2]": 100.0, "beta": 3.0, "natural_frequency[3]": 900.0, "loss_factor": 0.01}
    )
    assert changed.law.slip_force[2] == 100.0
    assert changed.law.slip_force[[0, 1, 3, 4, 5]] == pytest.approx(
        joint.law.slip_force[[0, 1, 3, 4, 5]]
    )
    assert np.all(changed.law.beta == 3.0)
    assert changed.natural_frequency.tolist() == [70.0, 360.0, 900.0]
    assert damping.attributes()["loss_factor"] == 0.01
    total, _ = model({"slip_force": 72.0})
    assert total.law.slip_force == pytest.approx(2 * joint.law.slip_force)
    for name in ("nope", "slip_force[6]", "natural_frequency[4]", "natural_frequency"):
        with pytest.raises(ValueError, match="is none of the joint"):
            model({name: 1.0})
