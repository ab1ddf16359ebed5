"""Modes from stepped sines at constant response."""

import numpy as np
import pytest

from boltjoint.measurement.signals import MOTIONS
from boltjoint.measurement.stepped_sine import identify_constant_response

FREQUENCY = np.linspace(79.0, 81.0, 21)


def stepped_sine(order, zeta=0.004, f0=80.2, mass=1.9):
    """Amplitudes of response and force, and the phase, at one amplitude of the response."""
    w, w0 = 2 * np.pi * FREQUENCY, 2 * np.pi * f0
    receptance = 1 / (mass * (w0**2 - w**2 + 2j * zeta * w0 * w))
    transfer = receptance * (1j * w) ** order
    response = np.full(w.size, 5.0)
    return response, response / abs(transfer), np.angle(transfer)


@pytest.mark.parametrize(("order", "quantity"), list(enumerate(MOTIONS)))
def test_an_oscillator_is_identified_exactly(order, quantity):
    found = identify_constant_response(FREQUENCY, *stepped_sine(order), quantity)
    assert found.frequency == pytest.approx(80.2, rel=1e-10)
    assert found.damping_ratio == pytest.approx(0.004, rel=1e-8)
    assert found.modal_mass == pytest.approx(1.9, rel=1e-8)


def test_a_sensor_that_moves_against_the_force_has_the_same_damping():
    response, force, phase = stepped_sine(2)
    found = identify_constant_response(FREQUENCY, response, force, phase + np.pi, "acceleration")
    assert found.damping_ratio == pytest.approx(0.004, rel=1e-8)
    assert found.modal_mass == pytest.approx(-1.9, rel=1e-8)


def test_stated_intervals_hold():
    response, force, phase = stepped_sine(2)
    held = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        noisy = force * (1 + 0.01 * rng.standard_normal(21)), phase + 0.01 * rng.standard_normal(21)
        found = identify_constant_response(FREQUENCY, response, *noisy, "acceleration")
        held.append(
            [
                abs(found.frequency - 80.2) < 1.96 * found.frequency_error,
                abs(found.damping_ratio - 0.004) < 1.96 * found.damping_error,
            ]
        )
    assert np.all((np.mean(held, axis=0) >= 0.90) & (np.mean(held, axis=0) <= 0.99))


def test_what_is_no_constant_response_is_refused():
    response, force, phase = stepped_sine(2)
    given = FREQUENCY, response, force, phase, "acceleration"
    for change, sentence in (
        ({1: response * np.linspace(1, 2, 21)}, "response spreads by"),
        ({0: FREQUENCY[:5]} | {n: given[n][:5] for n in (1, 2, 3)}, "at least 6"),
        ({3: np.zeros(21)}, "no resonance"),
        ({4: "force"}, "quantity 'force'"),
    ):
        with pytest.raises(ValueError, match=sentence):
            identify_constant_response(*(change.get(n, each) for n, each in enumerate(given)))
