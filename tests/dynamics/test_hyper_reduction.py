"""Weighted pairs: their forces, their weights, and the peaks that they hold."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import nnls
from small_joint import make_joint

from boltjoint.dynamics.reduction.hyper_reduction import HeldPeaks, _Weights, weigh_pairs
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.joint.derived import rescale_contact

FORCES, LOSS = (0.5, 5.0, 50.0), 0.01


@pytest.mark.parametrize("seed", range(5))
def test_weights_are_those_of_nonnegative_least_squares(seed):
    matrix = np.random.default_rng(seed).normal(size=(40, 25)) + 0.3
    search = _Weights([matrix[:15], matrix[15:]])
    assert not search.grow(26)
    np.testing.assert_allclose(search.weight, nnls(matrix, matrix.sum(axis=1))[0], atol=1e-9)
    few = _Weights([matrix])
    few.grow(5)
    assert np.count_nonzero(few.weight) == 5
    # with its pairs none reduces the residual further
    gradient = matrix.T @ (matrix.sum(axis=1) - matrix @ few.weight)
    assert np.abs(gradient[few.weight > 0]).max() < 1e-9 * np.abs(gradient).max()


def test_columns_that_would_be_negative_leave_again():
    random = np.random.default_rng(7)
    # neighbours that nearly agree compete with each other
    matrix = np.repeat(random.normal(size=(60, 12)) + 1, 3, axis=1)
    matrix += 0.05 * random.normal(size=matrix.shape)
    target = matrix @ random.uniform(0, 2, 36)
    search = _Weights([matrix])
    search._target = matrix.T @ target
    search.grow(36)
    np.testing.assert_allclose(search.weight, nnls(matrix, target)[0], atol=1e-8)


@pytest.mark.parametrize("law", ["constant", "variable", "iwan"])
def test_peaks_at_all_forces_are_within_the_tolerances(law):
    joint = make_joint(300, law=law)
    few, fit = weigh_pairs(joint, FORCES, LOSS)
    assert few.points < joint.points / 3
    np.testing.assert_array_equal(fit["weight"], fit["weight"].where(fit["weight"] > 0))
    estimated = [float(fit[f"estimated_{of}_error"]) for of in ("frequency", "amplitude")]
    assert estimated[0] <= 1e-3 and estimated[1] <= 1e-2
    frequency, amplitude = errors_of_peaks(joint, few)
    assert frequency <= 1e-3 and amplitude <= 1e-2


def test_weights_hold_peaks_of_designs_too():
    """Stiffer across than along, with less preload: those of one joint alone do not."""
    joint = make_joint(300, law="variable")
    before = {"tangential_stiffness": 1e6, "friction_coefficient": 0.1, "normal_stiffness": 2e6}
    after = {"tangential_stiffness": 5e5, "friction_coefficient": 0.15, "normal_stiffness": 1e7}

    def design(each):
        return rescale_contact(each, "variable", before, after, 0.6)

    held = []
    for others in ((), (HeldPeaks(design(joint), FORCES, LOSS),)):
        few, _ = weigh_pairs(joint, FORCES, LOSS, others=others)
        off = errors_of_peaks(design(joint), design(few))
        held.append(off[0] <= 1e-3 and off[1] <= 1e-2)
    assert held == [False, True]


def errors_of_peaks(joint, few):
    """Largest errors of frequency and amplitude of the peaks of a joint of few pairs."""
    errors = []
    for force in np.geomspace(FORCES[0], FORCES[-1], 10):
        of_all, of_few = (solve_branch(each, force, damping=LOSS) for each in (joint, few))
        errors.append(
            [
                abs(getattr(of_few, name)[of_few.peak] / getattr(of_all, name)[of_all.peak] - 1)
                for name in ("frequency", "amplitude")
            ]
        )
    return np.max(errors, axis=0)


def test_designs_with_other_pairs_are_refused():
    with pytest.raises(ValueError, match=r"joint of others\[0\] has other pairs"):
        weigh_pairs(make_joint(), FORCES, LOSS, others=[HeldPeaks(make_joint(50), FORCES, LOSS)])


def test_a_design_that_is_not_excited_is_left_out(caplog):
    joint = make_joint()
    still = replace(joint, excitation_mode=np.zeros(3))
    _, fit = weigh_pairs(joint, FORCES, LOSS, count=15, others=[HeldPeaks(still, FORCES, LOSS)])
    assert "weights are not made for others[0]: " in caplog.text
    np.testing.assert_array_equal(
        fit["weight"], weigh_pairs(joint, FORCES, LOSS, count=15)[1]["weight"]
    )


def test_more_pairs_have_smaller_errors():
    joint = make_joint()
    errors = [
        float(weigh_pairs(joint, FORCES, LOSS, count=n)[1]["estimated_amplitude_error"])
        for n in (4, 12, 24)
    ]
    assert errors[2] < 0.1 * errors[0] and errors[1] < errors[0]


def test_a_number_is_kept_and_every_resonance_held():
    joint = make_joint()
    few, fit = weigh_pairs(joint, FORCES, LOSS, count=15, windows={1: None, 2: (300.0, 500.0)})
    assert few.points == fit.sizes["point"] == 15
    first = weigh_pairs(joint, FORCES, LOSS, count=15)[1]
    assert not np.array_equal(fit["weight"], first["weight"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 61}, "count is 61, but the joint has 60 points"),
        ({"count": 0}, "count"),
        ({"frequency_tolerance": 0.0}, "frequency_tolerance"),
        ({"amplitude_tolerance": -1.0}, "amplitude_tolerance"),
        ({"windows": {}}, "windows are empty"),
        ({"windows": {9: None}}, "resonance"),
    ],
)
def test_impossible_options_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        weigh_pairs(make_joint(), FORCES, LOSS, **options)


def test_tolerances_that_no_pairs_meet_are_an_error():
    with pytest.raises(RuntimeError, match="allow larger ones"):
        weigh_pairs(make_joint(), FORCES, LOSS, amplitude_tolerance=1e-14)
