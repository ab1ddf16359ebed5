"""Ring-downs of a joint by time integration: records to plan tests with, and to test by.

The modal equations without excitation are integrated by backward differences
(``verification.time_steps``), with the slider of every element, from a periodic motion of a
nonlinear mode, as after a shaker is switched off, or from the velocities that an impulse causes.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.dynamics.backbone.epmc import ModalState
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.model import Joint
from boltjoint.measurement.signals import MOTIONS, Signals
from boltjoint.verification.time_integration import Integration
from boltjoint.verification.time_steps import integrate_period, sliders_along

Array = NDArray[np.float64]

#: derivatives of fourth order by central differences, times the step to the power of the order
_DIFFERENCES = {
    1: np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12,
    2: np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12,
}
_BESIDE = 2
#: a sample in eleven days, and as many values of the motion as four gigabytes hold
_LEAST_RATE, _MOST_VALUES = 1e-6, 500_000_000


def simulate_ring_down(
    joint: Joint,
    damping: Damping | float,
    *,
    impulse: float | None = None,
    state: ModalState | None = None,
    duration: float,
    sampling_rate: float,
    quantity: str = "acceleration",
    resonance: int = 1,
    steps: int = 1000,
) -> Signals:
    """The free decay of a joint, as its sensors measure it.

    Backward differences lower frequencies by ``(2 pi / steps)^2 / 3``, 1.3e-5 by default, of a mode
    at the resonance, and by the square of the ratio more of higher ones. Rigid-body modes are left
    out: sensors measure vibration.

    Parameters
    ----------
    joint
        With its elements' own law, which are integrated as springs with sliders.
    damping
        Damping of the structure; a number is a loss factor. Damping that is not viscous is the
        viscous damping which is the same at the resonance.
    impulse
        Impulse of the excitation at time 0 [N s], from rest.
    state
        Nonlinear mode of this joint in which it vibrates at time 0, in place of an impulse.
    duration, sampling_rate
        Duration and sampling rate of the record [s], [Hz].
    quantity
        ``displacement``, ``velocity`` or ``acceleration``.
    resonance
        Number of the resonance, from 1, whose stuck frequency counts for damping and steps.
    steps
        Fewest steps in a period of that resonance; there is a whole number between two samples.

    Returns
    -------
    Signals
        Of each sensor of the joint.

    Raises
    ------
    ValueError
        If the friction of the joint is sampled, both or neither of impulse and state are given, the
        state is of another joint, a number is out of range, or a step cannot be solved.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law of the joint", joint.law, ElementLaw)
    damping = as_damping(damping)
    rate = checks.number("sampling_rate", sampling_rate, above=0, at_least=_LEAST_RATE)
    duration = checks.number("duration", duration, above=0, at_most=1e9 / rate)
    checks.choice("quantity", quantity, MOTIONS)
    steps = checks.whole("steps", steps, at_least=20, at_most=1_000_000)
    place = joint.place_of(resonance)
    if (impulse is None) == (state is None):
        raise ValueError("impulse or state must be given, one of them")
    stuck = np.diag((2 * np.pi * joint.natural_frequency) ** 2) + joint.stuck_stiffness()
    frequency = float(np.sqrt(np.linalg.eigvalsh(stuck)[place]) / (2 * np.pi))
    between = int(np.ceil(steps * frequency / rate))
    step = 1 / (rate * between)
    samples = int(np.floor(duration * rate)) + 1
    checks.whole("samples", samples, at_least=2)
    most = _MOST_VALUES // joint.natural_frequency.size
    checks.whole("steps of the whole record", samples * between, at_most=most)
    free = Integration.of(joint, frequency, 0.0, damping, steps)
    if impulse is None:
        _start_from_mode(free, joint, checks.instance("state", state, ModalState), step)
    else:
        kick = checks.number("impulse", impulse) * joint.excitation_mode[free.elastic]
        free.q[:] = 0.0
        free.q[1] = step * kick
        free.v[0] = kick
    history = _integrate(free, (samples - 1) * between + 2 * _BESIDE + 1, step)
    modes = np.array(list(joint.sensors.by_name.values()))[:, free.elastic]
    motion = history[:, free.elastic] @ modes.T
    order = MOTIONS[quantity]
    values = motion[_BESIDE:-_BESIDE] if order == 0 else _derivative(motion, order, step)
    time = np.arange(samples) / rate
    return Signals(time, values[::between][:samples], quantity, tuple(joint.sensors.by_name))


def _start_from_mode(free: Integration, joint: Joint, state: ModalState, step: float) -> None:
    """Motion, velocity and sliders of a period of a nonlinear mode, at its end."""
    equations = state.equations
    if equations.balance.joint.natural_frequency.size != joint.natural_frequency.size:
        raise ValueError("state is of a joint with another number of modes")
    w, components = 2 * np.pi * state.frequency, equations.components
    steps = int(np.ceil(1 / (state.frequency * step)))
    motion = (state.modal_coordinate.T @ components.at_samples(64)).T[:, free.elastic]
    fine = resample(motion, steps)
    X, V, _, _, normal_load, mu = free.elements
    sliders_along(np.ascontiguousarray(fine), free.z, X, V, normal_load, mu)
    amplitude = state.modal_coordinate[:, free.elastic]
    rates = [(0.0 if n == 0 else n * w) for n in components.number]
    place, sign = components.quarter_later()
    # derivative by time: a quarter of the period ahead, times the frequency
    velocity = np.array(rates)[:, None] * (sign[:, None] * amplitude[place])
    at = [
        (np.sin if is_sine else np.cos)(np.outer(rate, [0.0, -step]))
        for rate, is_sine in zip(rates, components.is_sine, strict=True)
    ]
    table = np.array(at)[:, 0, :]
    q, v = amplitude.T @ table, velocity.T @ table
    free.q[:] = q[:, 0], q[:, 0] - q[:, 1]
    free.v[:] = v[:, 0], v[:, 0] - v[:, 1]


def _integrate(free: Integration, count: int, step: float) -> Array:
    """Motion of all modes at as many steps, shape (count, all modes)."""
    force = np.zeros(free.q.shape[1], dtype=complex)
    elastic = np.empty((count, free.q.shape[1]))
    w = 2 * np.pi / (count * step)
    damped = free.structure[0], free.structure[1], force
    unsolved = integrate_period(
        free.q, free.v, free.z, free.elements, damped, w, (0.0, 0.0), elastic
    )
    if unsolved:
        raise ValueError(
            f"{unsolved} of {count} time steps could not be solved: ask for more steps"
        )
    history = np.zeros((count, free.elastic.size))
    history[:, free.elastic] = elastic
    return history


def _derivative(motion: Array, order: int, step: float) -> Array:
    """Derivative by time at all steps but those at both ends, (steps, sensors)."""
    weights = _DIFFERENCES[order] / step**order
    end = len(motion) - 2 * _BESIDE
    return sum(weight * motion[n : n + end] for n, weight in enumerate(weights) if weight)
