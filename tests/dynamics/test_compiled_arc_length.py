"""The compiled path: the same solutions as the general tracer, of every law and damping."""

from dataclasses import replace

import numpy as np
import pytest
from random_joints import random_joint
from small_joint import make_joint

from boltjoint.damping import MODELS, LossFactor, make_damping
from boltjoint.dynamics.backbone import backbone
from boltjoint.dynamics.backbone.backbone import trace_for_forces
from boltjoint.dynamics.balance.compiled_balance import CompiledBalance
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.continuation import Continuation
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.solvers import arc_length
from boltjoint.solvers.step_control import StepControl

DAMPING = {
    "loss_factor": {"loss_factor": 0.01},
    "modal": {"damping_ratios": (0.01, 0.003, 0.006)},
    "rayleigh": {"mass_coefficient": 5.0, "stiffness_coefficient": 1e-5},
}


def joint_of(law):
    """A joint of every law; that of few points has many elements on each of them."""
    if law in ("constant", "variable"):
        return make_joint(law=law)
    joint = make_joint()
    known = joint.law
    if law == "iwan":
        shape = np.full(known.slip_force.size, -0.3), np.full(known.slip_force.size, 0.5)
        few = known.point_of_element, known.tangential_stiffness, known.slip_force
        return replace(joint, law=FourParameterIwan(*few, *shape))
    kinds = {"tabulated": TabulatedLoad, "few points": ConstantLoad}
    on = np.arange(known.slip_force.size) // 10
    points = on.max() + 1
    return replace(
        joint,
        law=kinds[law](on, known.tangential_stiffness, known.slip_force),
        tangential_mode=joint.tangential_mode[:: len(on) // points],
        position=joint.position[:: len(on) // points],
    )


@pytest.mark.parametrize("model", DAMPING)
@pytest.mark.parametrize("law", ["constant", "variable", "iwan", "tabulated", "few points"])
def test_a_compiled_balance_is_that_of_python(law, model):
    balance = HarmonicBalance(joint_of(law), make_damping(model, **DAMPING[model]), 5.0)
    compiled = CompiledBalance.of(balance)
    x = np.random.default_rng(1).normal(scale=1e-6, size=balance.modal_force.size)
    w = 2 * np.pi * 75.0
    expected, derivative = balance.residual_and_jacobian(x, w)
    residual, jacobian = compiled.residual_and_jacobian(x, w)
    np.testing.assert_allclose(residual, expected, rtol=0, atol=1e-13 * abs(expected).max())
    matrix = derivative()
    np.testing.assert_allclose(jacobian(), matrix, rtol=0, atol=1e-13 * abs(matrix).max())


def both(monkeypatch, joint, *given, **options):
    """The branch by the compiled path, where that is followed, and by the general tracer."""
    traced = []
    with monkeypatch.context() as patch:
        patch.setattr(arc_length, "trace", lambda *a, **k: traced.append(a) or trace(*a, **k))
        compiled = solve_branch(joint, *given, **options)
    with monkeypatch.context() as patch:
        patch.setattr(Continuation, "_follow_compiled", lambda *_: None)
        general = solve_branch(joint, *given, **options)
    return compiled, general, not traced


trace = arc_length.trace


def assert_same(compiled, general):
    assert compiled.complete and general.complete
    np.testing.assert_array_equal(compiled.iterations, general.iterations)
    np.testing.assert_array_equal(compiled.located, general.located)
    # a peak is where the slope is zero but for its rounding, at a flat maximum
    tolerance = np.where(general.located, 1e-10, 1e-12) * general.frequency
    assert np.all(np.abs(compiled.frequency - general.frequency) < tolerance)
    scale = np.linalg.norm(general.modal_coordinate, axis=1)[:, None]
    difference = compiled.modal_coordinate - general.modal_coordinate
    assert np.abs(difference / scale).max() < 1e-9


@pytest.mark.parametrize("damping", [make_damping(name, **DAMPING[name]) for name in MODELS])
@pytest.mark.parametrize("law", ["constant", "few points", "tabulated", "iwan", "variable"])
def test_solutions_are_those_of_the_general_tracer(law, damping, monkeypatch):
    joint = joint_of(law)
    if isinstance(damping, LossFactor):
        # points of the excitation that are not in phase
        joint = replace(joint, excitation_mode_cos=np.array([0.3, 0.7, -0.2]))
    for force in (0.01, 5.0, 200.0):
        compiled, general, is_compiled = both(monkeypatch, joint, force, damping=damping)
        assert is_compiled
        assert compiled.peak is not None
        assert_same(compiled, general)


@pytest.mark.parametrize("damping", [make_damping(name, **DAMPING[name]) for name in MODELS])
@pytest.mark.parametrize("law", ["constant", "few points", "tabulated", "iwan", "variable"])
def test_backbones_are_those_of_the_general_tracer(law, damping, monkeypatch):
    joint = joint_of(law)

    def found():
        return trace_for_forces(joint, [0.01, 200.0], damping=damping, window=(20.0, 400.0))

    traced = []
    with monkeypatch.context() as patch:
        patch.setattr(backbone, "trace", lambda *a, **k: traced.append(a) or trace(*a, **k))
        compiled = found()
        assert not traced
        patch.setattr(backbone, "epmc_system", lambda _: None)
        general = found()
        assert traced
    assert compiled.complete and general.complete
    for one, other in zip(compiled.states, general.states, strict=True):
        assert one.log_amplitude == pytest.approx(other.log_amplitude, rel=1e-12)
        np.testing.assert_allclose(one.unknown, other.unknown, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_branches_of_random_joints_are_the_same(law, monkeypatch):
    """Those with corners too, which the general tracer follows."""
    irregular = 0
    for index in range(30):
        joint, force, loss_factor = random_joint(law, index)
        compiled, general, is_compiled = both(monkeypatch, joint, force, damping=loss_factor)
        assert compiled.complete
        if is_compiled:
            assert_same(compiled, general)
        else:
            irregular += 1
            np.testing.assert_array_equal(compiled.frequency, general.frequency)
    assert irregular < 15


def test_a_path_in_a_window_of_its_own_starts_where_it_is_told(monkeypatch):
    joint = make_joint()
    whole = solve_branch(joint, 5.0, damping=0.01)
    index = whole.peak - 4
    start, window = whole.modal_coordinate[index], tuple(whole.frequency[[index, whole.peak + 4]])
    options = {"damping": 0.01, "resonance": Resonance(1, window), "start": start}
    compiled, general, is_compiled = both(monkeypatch, joint, 5.0, **options)
    assert is_compiled
    assert_same(compiled, general)


def test_a_path_starts_by_load_stepping_where_the_stuck_solution_is_too_far(monkeypatch):
    control = StepControl(smallest_step=0.015, maximum_iterations=2)
    options = {"damping": 0.01, "control": control}
    compiled, general, _ = both(monkeypatch, make_joint(), 5.0, **options)
    assert_same(compiled, general)


def test_a_path_that_breaks_off_is_left_to_the_general_tracer(monkeypatch):
    options = {"damping": 0.01, "control": StepControl(maximum_solutions=20)}
    compiled, general, is_compiled = both(monkeypatch, make_joint(), 5.0, **options)
    assert not is_compiled
    assert (compiled.complete, compiled.reason) == (general.complete, general.reason)
    np.testing.assert_array_equal(compiled.frequency, general.frequency)


def test_whole_numbers_of_a_control_are_numbers():
    # compiled functions are called with numbers of the types they were compiled for
    paths = [
        solve_branch(
            make_joint(), 1.0, damping=0.01, control=StepControl(largest_step=step, first_step=step)
        )
        for step in (1, 1.0, np.float32(1.0))
    ]
    for path in paths[1:]:
        np.testing.assert_array_equal(path.frequency, paths[0].frequency)
