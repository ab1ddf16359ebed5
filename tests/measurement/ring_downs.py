"""A joint whose first mode alone moves the contact, its backbone and its ring-downs."""

from functools import cache

import numpy as np
from scipy.interpolate import CubicSpline

from boltjoint.damping import ModalDamping
from boltjoint.dynamics.backbone.backbone import trace_backbone
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.model import Joint
from boltjoint.measurement.signals import Signals
from boltjoint.measurement.simulated_ring_down import simulate_ring_down

#: damping is 0.44 % at rest and 2.2 % at the largest amplitude
DAMPING = ModalDamping((0.005, 0.004))
RATE = 6400.0  # Hz
BAND = (75.0, 135.0)  # Hz
#: acceleration per modal amplitude at the sensor
SENSOR = 1.0


@cache
def two_modes(elements=40):
    """Mode 1 from 107.5 Hz to 95 Hz, and mode 2 at 370 Hz, which is linear."""
    slip = 80 / elements * np.linspace(0.02, 1.0, elements) ** 2
    rows = np.column_stack([np.full(elements, 0.5), np.zeros(elements)])
    at, position = np.array([SENSOR, 0.15]), np.zeros((elements, 3))
    law = ConstantLoad(np.arange(elements), np.full(elements, 4e5 / elements), slip)
    return Joint(np.array([95.0, 370.0]), at, at, rows, position, law, position)


@cache
def backbone(elements=40):
    equations = EPMCEquations(two_modes(elements), DAMPING, 1)
    return trace_backbone(equations, (1e-7, 1e-2)).refined()


@cache
def ring_down(elements=40, duration=2.0, steps=1000):
    """Acceleration after an impulse that both modes answer."""
    state = min(backbone(elements).states, key=lambda each: abs(each.amplitude - 8e-4))
    impulse = state.amplitude * 2 * np.pi * state.frequency / SENSOR
    return simulate_ring_down(
        two_modes(elements),
        DAMPING,
        impulse=impulse,
        duration=duration,
        sampling_rate=RATE,
        resonance=2,
        steps=steps,
    )


def with_noise(signals, ratio, seed):
    """White noise whose standard deviation is a part of the largest value."""
    noise = np.random.default_rng(seed).standard_normal(signals.values.shape)
    values = signals.values + ratio * abs(signals.values).max() * noise
    return Signals(signals.time, values, signals.quantity, signals.sensors)


def curves_at(amplitude, elements=40):
    """Frequency and damping of the backbone at amplitudes of the acceleration."""
    states = sorted(backbone(elements).states, key=lambda each: each.log_amplitude)
    frequency, damping = np.array([state.curves for state in states]).T
    known = np.log([SENSOR * s.amplitude * (2 * np.pi * s.frequency) ** 2 for s in states])
    order = np.argsort(known)
    x = np.log(amplitude)
    return (CubicSpline(known[order], y[order])(x) for y in (frequency, damping))


def errors(mode, elements=40):
    """Relative errors of frequency and damping, and both over their standard errors."""
    frequency, damping = curves_at(mode.amplitude, elements)
    f, z = mode.frequency - frequency, mode.damping_ratio - damping
    return f / frequency, z / damping, f / mode.frequency_error, z / mode.damping_error
