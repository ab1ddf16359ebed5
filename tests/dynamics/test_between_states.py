"""Modes between the states of a backbone: where slip sets in, and where the backbone turns back."""

import numpy as np
import pytest
from random_joints import random_joint

from boltjoint import ConstantLoad, Joint, frequency_window, solve_branch
from boltjoint.dynamics.backbone.backbone import trace_for_forces
from boltjoint.dynamics.response.windows import Resonance


def make_slipping_joint(share=0.5):
    """One mode of 10 Hz and a slider of a share of its stiffness that slips at 1 N."""
    stiffness = share * (2 * np.pi * 10) ** 2
    one, position = np.ones(1), np.zeros((1, 3))
    law = ConstantLoad(np.array([0]), np.array([stiffness]), np.array([1.0]))
    return Joint(10 * one, one, one, np.ones((1, 1)), position, law, position)


def peak_of_slider(loss_factor, force, share=0.5):
    """Amplitude at which force, structural damping and Coulomb friction are in balance [m].

    ``F a = eta K a^2 + 4 mu N / pi (a - mu N / k)``: the energy of a period over pi.
    """
    stiffness = (2 * np.pi * 10) ** 2
    stuck = 1 / (share * stiffness)
    friction = 4 / np.pi
    half = (force - friction) / (2 * loss_factor * stiffness)
    return half + np.sqrt(half**2 + friction * stuck / (loss_factor * stiffness))


@pytest.mark.parametrize(
    ("loss_factor", "force"), [(1e-3, 1.5), (1e-5, 10.0), (1e-6, 1.5), (1e-7, 1.3), (1e-9, 2.0)]
)
def test_a_backbone_reaches_the_peak_that_slight_damping_allows(loss_factor, force):
    joint, window = make_slipping_joint(), (5.0, 20.0)
    expected = peak_of_slider(loss_factor, force)
    if (loss_factor, force) == (1e-6, 1.5):
        assert expected == pytest.approx(57.44194, abs=5e-6)
    known = {"damping": loss_factor, "resonance": Resonance(1, window)}
    branch = solve_branch(joint, force, method="backbone", **known)
    assert branch.complete, branch.reason
    assert branch.peak_amplitude == pytest.approx(expected, rel=1e-9)
    backbone = trace_for_forces(joint, [force], damping=loss_factor, window=window)
    assert backbone.complete
    assert backbone.states[-1].amplitude > expected
    if loss_factor > 1e-8:
        linear = solve_branch(joint, force, **known)
        assert linear.peak_amplitude == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("share", [1e2, 1e4])
def test_a_contact_much_stiffer_than_the_structure_does_not_limit_amplitudes(share):
    loss_factor, force, window = 1e-6, 10.0, (5.0, 12.0 * np.sqrt(share))
    joint = make_slipping_joint(share)
    branch = solve_branch(
        joint, force, method="backbone", damping=loss_factor, resonance=Resonance(1, window)
    )
    assert branch.complete, branch.reason
    expected = peak_of_slider(loss_factor, force, share)
    assert branch.peak_amplitude == pytest.approx(expected, rel=1e-7)


def test_a_rigid_body_mode_has_a_backbone():
    """Its stiffness is that of the contact alone, and nothing else damps it."""
    joint = make_slipping_joint()
    two = np.ones(2)
    joint = Joint(np.array([0.0, 10.0]), two, two, np.array([[1.0, 0.5]]), *joint_parts(joint))
    branch = solve_branch(
        joint, 0.1, method="backbone", damping=1e-3, resonance=Resonance(1, (2.0, 9.0))
    )
    assert branch.complete, branch.reason
    linear = solve_branch(joint, 0.1, damping=1e-3, resonance=Resonance(1, (2.0, 9.0)))
    assert branch.peak_frequency == pytest.approx(linear.peak_frequency, rel=5e-3)


def joint_parts(joint):
    """What a joint of other modes has in common."""
    return joint.position, joint.law, joint.element_position


@pytest.mark.parametrize("force", [1e-3, 3e-3])
def test_a_peak_just_beyond_the_onset_of_slip_is_found(force):
    """Friction then outgrows a structural damping of a millionth within a step of the backbone."""
    joint, window = make_slipping_joint(share=2.0), (5.0, 30.0)
    known = {"damping": 1e-6, "resonance": Resonance(1, window)}
    branch = solve_branch(joint, force, method="backbone", **known)
    linear = solve_branch(joint, force, **known)
    assert branch.complete, branch.reason
    assert linear.complete
    assert branch.peak_amplitude == pytest.approx(linear.peak_amplitude, rel=1e-7)
    assert branch.peak_frequency == pytest.approx(linear.peak_frequency, rel=1e-7)


#: joints with close modes whose backbones turn back in amplitude near the peak
FOLDING = [93, 255, 289, 302, 440]


@pytest.mark.parametrize("index", FOLDING)
def test_states_between_those_of_a_backbone_that_turns_back_are_modes(index):
    joint, force, loss_factor = random_joint("constant", index, seed=5151)
    window = frequency_window(joint)
    backbone = trace_for_forces(joint, [force], damping=loss_factor, window=window)
    amplitude = np.array([state.log_amplitude for state in backbone.states])
    assert np.any(np.diff(amplitude) < 0)
    for state in backbone.states:
        residual, _ = backbone.equations.evaluate(state.unknown, state.log_amplitude)
        assert np.linalg.norm(residual) < 1e-8
        assert np.linalg.norm(state.mode) == pytest.approx(1.0, rel=1e-8)


#: joints of either law whose backbones turn, or have a corner, within a step at the peak
WITHIN_A_STEP = [("constant", 373), ("variable", 292), ("variable", 376)]


@pytest.mark.parametrize(
    ("law", "index"), [*(("constant", index) for index in FOLDING), *WITHIN_A_STEP]
)
def test_a_response_from_a_backbone_that_turns_back_has_its_peak(law, index):
    joint, force, loss_factor = random_joint(law, index, seed=5151)
    branch = solve_branch(joint, force, method="backbone", damping=loss_factor)
    assert branch.complete, branch.reason
    assert branch.peak is not None
    # no solution beside it is higher, and none is far from the last
    around = branch.amplitude[branch.peak - 1 : branch.peak + 2]
    assert around[1] == around.max()
    assert np.all(np.isfinite(branch.amplitude))
