"""What further harmonics ask of a basis of modes and static shapes, against all modes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.converged_peaks import find_converged_peaks
from boltjoint.dynamics.response.inertia_of_basis import count_modes
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.model import Joint

FORCE, LOSS_FACTOR = 3.0, 2e-3
QUANTITIES = ("frequency", "amplitude")


def many_modes(scale):
    """A joint of ten modes, those from the third on scaled in frequency."""
    random = np.random.default_rng([11, 0])
    squares = (np.arange(1, 11) - 0.5) ** 2 / 0.25
    frequency = np.sort(50 * squares * random.uniform(0.9, 1.1, 10))
    tip = random.normal(size=10)
    rows = random.normal(size=(6, 10)) * np.linspace(0.3, 1, 10)
    stiffness = 0.3 * (2 * np.pi * frequency[0]) ** 2 / (rows[:, 0] @ rows[:, 0])
    law = ConstantLoad(np.arange(6), np.full(6, stiffness), random.uniform(0.5, 2, 6))
    place = np.column_stack([np.linspace(0, 0.1, 6), np.zeros((6, 2))])
    frequency[2:] *= scale
    return Joint(frequency, tip, tip, rows, place, law, place)


def with_static_shapes(joint):
    """The joint in its first two modes and the static shapes of its points."""
    squared = (2 * np.pi * joint.natural_frequency) ** 2
    static = (joint.tangential_mode / squared).T
    static[:2] = 0
    shapes = np.linalg.svd(static * np.sqrt(squared)[:, None], full_matrices=False)[0]
    vectors = np.linalg.qr(np.hstack([np.eye(10)[:, :2], shapes / np.sqrt(squared)[:, None]]))[0]
    ritz, share = eigh(vectors.T @ (squared[:, None] * vectors))
    basis = vectors @ share
    return Joint(
        np.sqrt(ritz) / (2 * np.pi),
        joint.excitation_mode @ basis,
        joint.response_mode @ basis,
        joint.tangential_mode @ basis,
        joint.position,
        joint.law,
        joint.element_position,
        free_frequency=joint.natural_frequency,
        free_participation=basis,
    )


def errors_and_bars(joint):
    """Errors of the peak in the basis against all modes, and its errors of both kinds."""
    in_basis = with_static_shapes(joint)
    peaks, true = (
        find_converged_peaks(one, [FORCE], damping=LOSS_FACTOR) for one in (in_basis, joint)
    )
    error = [
        float(abs(peaks[f"peak_{x}_converged"] / true[f"peak_{x}_converged"] - 1)[0])
        for x in QUANTITIES
    ]
    bars = [
        [float(peaks[f"peak_{x}_{of}_error"][0]) for x in QUANTITIES]
        for of in ("truncation", "inertia")
    ]
    return (
        np.array(error),
        *map(np.array, bars),
        float(peaks["peak_frequency_converged"][0]) / in_basis.natural_frequency,
    )


def scale_at_fifth_harmonic():
    """The scale with which a vector that is no mode lies at the fifth harmonic of the peak."""
    scale = 1.0
    for _ in range(3):
        in_basis = with_static_shapes(many_modes(scale))
        peak = find_converged_peaks(in_basis, [FORCE], damping=LOSS_FACTOR)
        scale *= 5 * float(peak["peak_frequency_converged"][0]) / in_basis.natural_frequency[2]
    return scale


def test_a_harmonic_at_the_frequency_of_a_static_shape_is_told():
    error, truncation, inertia, ratio = errors_and_bars(many_modes(scale_at_fifth_harmonic()))
    assert np.abs(5 * ratio - 1).min() < 1e-3
    # what is left out by harmonics does not see it
    assert (error > 5 * truncation).all()
    assert (error < inertia).all()
    assert (inertia < 3 * error).all()


def test_a_vector_far_from_all_harmonics_asks_little():
    error, truncation, inertia, _ = errors_and_bars(many_modes(1.9))
    assert (inertia < truncation).all()
    assert (error < truncation + inertia).all()


def test_inertia_is_left_out_of_further_harmonics_alone():
    joint = many_modes(1.0)
    law = AlternatingFrequencyTime(joint.law, harmonics=5)
    balance = HarmonicBalance(replace(joint, law=law), LOSS_FACTOR, FORCE)
    x, w = np.random.default_rng(1).normal(size=6 * 10), 300.0
    without = replace(balance, inertial=2)
    left_out = balance.components.rows(without.residual(x, w) - balance.residual(x, w))
    inertia = balance.components.rows(x) * (w * balance.components.number[:, None]) ** 2
    inertia[:2] = 0
    inertia[:, :2] = 0
    assert left_out == pytest.approx(inertia, rel=1e-9, abs=1e-9 * inertia.max())
    jacobian = without.residual_and_jacobian(x, w)[1]()
    difference = without.residual(1.000001 * x, w) - without.residual(0.999999 * x, w)
    along = jacobian @ x
    assert along == pytest.approx(difference / 2e-6, abs=1e-5 * abs(along).max())


def test_modes_are_counted_from_the_first():
    joint = many_modes(1.0)
    in_basis = with_static_shapes(joint)
    assert count_modes(joint) == 10
    assert count_modes(in_basis) == 2
    # of one frequency, however they are mixed
    frequency = joint.natural_frequency.copy()
    frequency[2] = frequency[1]
    mixed = np.eye(10)
    mixed[1:3, 1:3] = np.array([[1, -1], [1, 1]]) / np.sqrt(2)
    of_one = {"natural_frequency": frequency, "free_frequency": frequency}
    assert count_modes(replace(joint, **of_one, free_participation=mixed)) == 10
    assert (
        count_modes(
            replace(joint, free_frequency=joint.natural_frequency, free_participation=np.eye(10))
        )
        == 10
    )


def test_a_joint_in_its_modes_has_no_such_error():
    peaks = find_converged_peaks(many_modes(1.0), [FORCE], damping=LOSS_FACTOR)
    assert peaks["peak_harmonics"] > 1
    assert [float(peaks[f"peak_{x}_inertia_error"][0]) for x in QUANTITIES] == [0.0, 0.0]
