"""Delay of sliders in the derivative of their forces, against elements followed one by one."""

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.friction.aft import AlternatingFrequencyTime, by_samples
from boltjoint.friction.constant import ConstantLoad

SAMPLES = 64
#: size of the change, so small that contact states stay, and rate of its growth over a period
CHANGE, RATE = 1e-7, 1e-3
PERIODS = 4


def waves(components):
    """Values of the components at the samples, and the weight of a sample in each."""
    phase = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    values = {"bias": np.ones(SAMPLES)}
    for harmonic in (1, 2, 3):
        number = "" if harmonic == 1 else harmonic
        values[f"sin{number}"] = np.sin(harmonic * phase)
        values[f"cos{number}"] = np.cos(harmonic * phase)
    weight = [1 if name == "bias" else 2 for name in components]
    return np.array([values[name] for name in components]), np.array(weight) / SAMPLES


def forces_along(joint, q):
    """Forces on the modes in the last period of a motion; how many slip, and are open."""
    sliders = joint.law.sliders()
    force = np.zeros((len(q), SAMPLES))
    slips = opens = 0
    for e, point in enumerate(sliders.point):
        x = sliders.tangential_stiffness[e] * joint.tangential_mode[point] @ q
        n = np.full(x.size, sliders.normal_load[e])
        if sliders.normal_stiffness is not None:
            across = joint.normal_mode[point]
            n += sliders.normal_stiffness[e] * across @ q
            force += np.outer(across, np.maximum(n, 0.0)[-SAMPLES:])
        z = 0.0
        for i in range(1, x.size):
            if n[i] > 0 >= n[i - 1]:
                z = x[i - 1] + (x[i] - x[i - 1]) * n[i - 1] / (n[i - 1] - n[i])
            bound, before = sliders.friction_coefficient[e] * max(n[i], 0.0), z
            z = min(max(z, x[i] - bound), x[i] + bound)
            if i >= x.size - SAMPLES:
                force[:, i % SAMPLES] += (x[i] - z) * joint.tangential_mode[point]
                slips, opens = slips + (n[i] > 0 and z != before), opens + (n[i] <= 0)
    return force, slips, opens


@pytest.mark.parametrize(("kind", "harmonics"), [("constant", 3), ("variable", 2)])
def test_delay_is_the_derivative_by_the_rate_of_growth(kind, harmonics):
    joint = make_joint(6, law=kind)
    law = AlternatingFrequencyTime(joint.law, harmonics, SAMPLES)
    values, weight = waves(law.components)
    random = np.random.default_rng(3)
    amplitude, change = random.normal(size=(2, len(weight), joint.natural_frequency.size))
    amplitude *= 2e-5
    time = np.arange(PERIODS * SAMPLES) / SAMPLES - (PERIODS - 1)
    q, dq = (np.tile(each.T @ values, PERIODS) for each in (amplitude, change))
    start, slips, opens = forces_along(joint, q)
    # all that may happen does, and none all the time
    assert 0 < slips < 0.9 * 6 * SAMPLES - opens
    assert (opens > 0) == (kind == "variable")
    tangents = []
    for rate in (RATE, -RATE):
        growth = np.exp(rate * time)
        changed = forces_along(joint, q + CHANGE * growth * dq)[0]
        derivative = (changed - start) / CHANGE / growth[-SAMPLES:]
        tangents.append((derivative @ values.T).T * weight[:, None])
    expected = (tangents[0] - tangents[1]) / (2 * RATE)
    found = np.einsum("irjs,js->ir", law.modal_slider_delay(joint.rows, amplitude, 0.0), change)
    # differences round to 1e-16 of the forces over the change
    np.testing.assert_allclose(found, expected, atol=1e-5 * abs(expected).max())
    # beside them are the tangents themselves
    tangent = np.einsum(
        "irjs,js->ir", law.modal_force_and_tangent(joint.rows, amplitude, 0.0)[1](), change
    )
    mean = (tangents[0] + tangents[1]) / 2
    np.testing.assert_allclose(tangent, mean, atol=1e-5 * abs(mean).max())


def test_sliders_that_rest_have_no_delay():
    joint = make_joint(6)
    law = AlternatingFrequencyTime(joint.law, samples=SAMPLES)
    assert not law.modal_slider_delay(joint.rows, np.full((2, 3), 1e-9), 0.0).any()


def test_many_elements_are_followed_in_parts(monkeypatch):
    joint = make_joint(60)
    law = AlternatingFrequencyTime(joint.law, samples=SAMPLES)
    amplitude = 1e-4 * np.random.default_rng(0).normal(size=(2, 3))
    whole = law.modal_slider_delay(joint.rows, amplitude, 0.0)
    monkeypatch.setattr("boltjoint.friction.modal_aft._ELEMENTS_AT_ONCE", 7)
    parts = law.modal_slider_delay(joint.rows, amplitude, 0.0)
    assert whole.any()
    np.testing.assert_allclose(parts, whole, rtol=1e-9, atol=1e-12 * abs(whole).max())


def test_a_law_is_followed_at_as_many_samples_as_asked_for():
    elements = ConstantLoad(np.array([0]), np.array([1e6]), np.array([10.0]))
    assert by_samples(elements, 32).samples == 32
    sampled = AlternatingFrequencyTime(elements, samples=64)
    assert by_samples(sampled, 32) is sampled
