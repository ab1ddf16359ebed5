"""Friction under constant normal load against time integration and closed forms."""

import numpy as np
import pytest

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.contact_states import STICK, STICK_SLIP


def one_element(k=2e8, slip=30.0):
    return ConstantLoad(np.array([0]), np.array([k]), np.array([slip]))


def integrate(law, motion, samples):
    """Sine and cosine of the friction forces, integrated in time without a bias."""
    both = np.zeros((len(motion), 6))
    both[:, 1:3] = motion
    return law.forces_in_time(both, samples)[:, 1:3]


def random_cases(count, seed=0):
    random = np.random.default_rng(seed)
    k = 10 ** random.uniform(6, 9, count)
    slip = 10 ** random.uniform(-1, 3, count)
    # from deep in stick to deep in slip
    amplitude = slip / k * 10 ** random.uniform(-1, 2.5, count)
    phase = random.uniform(0, 2 * np.pi, count)
    return k, slip, np.column_stack([amplitude * np.cos(phase), amplitude * np.sin(phase)])


def test_force_equals_time_integration():
    k, slip, motion = random_cases(200)
    law = ConstantLoad(np.arange(200), k, slip)
    force, integrated = law.force(motion), integrate(law, motion, 20000)
    # the trapezoidal rule errs by about (2 pi / samples)^2 times the corners of the force
    np.testing.assert_allclose(force, integrated, atol=1e-6 * slip.max(), rtol=0)
    error = np.linalg.norm(force - integrated, axis=1) / np.minimum(slip, k * np.hypot(*motion.T))
    assert error.max() < 2e-6


def test_time_integration_converges_to_the_force_with_second_order():
    law, motion = one_element(1e8, 10.0), np.array([[2.3e-7, -1.1e-7]])
    exact = law.force(motion)[0]

    def error(samples):
        # an average over phases, since single errors depend on where samples meet corners
        errors = []
        for turn in np.linspace(0, 2 * np.pi / samples, 16, endpoint=False):
            c, s = np.cos(turn), np.sin(turn)
            rotation = np.array([[c, -s], [s, c]])
            integrated = integrate(law, (rotation @ motion[0])[None], samples)[0]
            errors.append(np.linalg.norm(integrated - rotation @ exact))
        return np.sqrt(np.mean(np.square(errors)))

    order = np.log2(error(200) / error(12800)) / 6
    assert order == pytest.approx(2, abs=0.1)


def test_tangent_equals_central_differences():
    k, slip, motion = random_cases(300, seed=1)
    law = ConstantLoad(np.arange(300), k, slip)
    _, tangent = law.force_and_tangent(motion)
    amplitude = np.hypot(*motion.T)
    for j in range(2):
        step = np.zeros_like(motion)
        step[:, j] = 1e-6 * amplitude
        difference = (law.force(motion + step) - law.force(motion - step)) / (2e-6 * amplitude)[
            :, None
        ]
        # differences of rounded forces; none of the random amplitudes sits on the slip limit
        np.testing.assert_allclose(
            tangent[:, :, j] / k[:, None], difference / k[:, None], atol=1e-7
        )


def test_force_alone_is_the_force_with_tangent():
    k, slip, motion = random_cases(100, seed=2)
    law = ConstantLoad(np.arange(100), k, slip)
    np.testing.assert_array_equal(law.force(motion), law.force_and_tangent(motion)[0])


def test_stuck_element_is_a_spring():
    motion = np.array([[1e-7, -0.5e-7]])
    np.testing.assert_array_equal(one_element().force(motion), 2e8 * motion)


def test_element_in_full_slip_is_coulomb_friction():
    # k -> infinity: a square wave against the velocity, of first harmonic 4 mu N / pi
    force = one_element(k=1e22).force(np.array([[1e-3, 0.0]]))[0]
    assert force[1] == pytest.approx(4 * 30.0 / np.pi, rel=1e-6)
    assert abs(force[0]) < 1e-4


def test_dissipation_is_the_area_of_the_loop():
    k, slip, amplitude = 2e8, 30.0, 1e-6
    force = one_element(k, slip).force(np.array([[amplitude, 0.0]]))[0]
    assert np.pi * amplitude * force[1] == pytest.approx(4 * slip * (amplitude - slip / k))


def test_force_is_continuous_where_slip_begins():
    law = one_element()
    limit = 30.0 / 2e8
    below, above = (law.force(np.array([[limit * (1 + d), 0.0]])) for d in (-1e-12, 1e-12))
    np.testing.assert_allclose(below, above, atol=1e-8)


def test_a_shift_in_time_turns_the_force_along():
    law, motion = one_element(), np.array([[4e-7, 1e-7]])
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    np.testing.assert_allclose(law.force(motion @ turn.T), law.force(motion) @ turn.T, rtol=1e-12)


def test_elements_on_one_point_add_up_in_any_order():
    k, slip, _ = random_cases(50, seed=3)
    motion = np.array([[2e-7, 1e-7]])
    together = ConstantLoad(np.zeros(50, dtype=np.int64), k, slip)
    back = ConstantLoad(np.zeros(50, dtype=np.int64), k[::-1].copy(), slip[::-1].copy())
    alone = sum(one_element(*one).force(motion) for one in zip(k, slip, strict=True))
    np.testing.assert_allclose(together.force(motion), alone, rtol=1e-12)
    np.testing.assert_allclose(back.force(motion), alone, rtol=1e-12)


def test_contact_state():
    law = ConstantLoad(np.array([0, 0]), np.array([1e8, 1e8]), np.array([10.0, 30.0]))
    np.testing.assert_array_equal(
        law.contact_state(np.array([[2e-7, 0.0]])), np.array([STICK_SLIP, STICK])
    )


@pytest.mark.parametrize(("k", "slip"), [(-1.0, 1.0), (1.0, 0.0), (np.nan, 1.0)])
def test_impossible_elements_are_refused(k, slip):
    with pytest.raises(ValueError, match=r"must be (positive|finite), but is"):
        one_element(k, slip)


def test_arrays_of_different_length_are_refused():
    with pytest.raises(ValueError, match="slip_force has shape"):
        ConstantLoad(np.array([0]), np.array([1.0]), np.array([1.0, 2.0]))
