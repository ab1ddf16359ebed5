"""Steady states of a joint by time integration of its modal equations.

Neither the motion is assumed nor code shared with the friction laws or the harmonic balance. The
modes are integrated by central differences, and every element keeps its slider between steps::

    q'' + C q' + L q + R^T f + N^T (n - max(n0, 0)) = phi F sin(wt)

with ``L = diag(w_r^2)``, friction force f and normal load n of the elements. Damping H that is not
viscous has no causal model in time: at the excitation frequency w it is the viscous damping
``C = H(w) / w``, which is the same for the first harmonic.

References
----------
D. A. Smith, W. F. Ford, A. Sidi: Extrapolation methods for vector sequences. SIAM Review 29 (1987)
199-233: reduced rank extrapolation.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import resample

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.friction.law import ElementLaw
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]

#: periods between two extrapolations, and how many of the last enter one: amplitudes are the same
#: within the tolerance for others
_BLOCK, _EXTRAPOLATED_PERIODS = 12, 8

#: a change that has not decreased to this part of itself between extrapolations is a slow one
_SLOW = 0.5


@dataclass(frozen=True)
class SteadyState:
    """A periodic motion after its transient.

    Parameters
    ----------
    amplitude
        First harmonic of the output point [m], ``Im(amplitude exp(iwt))``, extrapolated from both
        step sizes.
    harmonics
        Harmonics of the output point from 0, the mean [m], with the finer step.
    motion
        Modal coordinates at the samples of the last period, with the finer step [kg^1/2 m], shape
        (samples, modes).
    steps
        Steps a period with the finer step.
    periods
        Number of integrated periods with both steps.
    change
        Of displacement and velocity of the modes over the last period, relative to their size.
    step_error
        Relative difference of the first harmonic with the finer step from the extrapolated one.
    converged
        Whether the change fell below the tolerance with both steps.
    """

    amplitude: complex
    harmonics: NDArray[np.complex128]
    motion: Array
    steps: int
    periods: int
    change: float
    step_error: float
    converged: bool


def steady_state(
    joint: Joint,
    frequency: float,
    force: float,
    damping: Damping | float,
    *,
    start: Array | None = None,
    ramp: int = 100,
    steps: int = 2000,
    harmonics: int = 9,
    tolerance: float = 1e-9,
    maximum_periods: int = 3000,
) -> SteadyState:
    """Integrate a joint in time to its steady state, with one step and then with half of it.

    Where the transient decays slowly, as on resonance with light damping, the state is set to the
    limit of the last periods by reduced rank extrapolation: a guess like any initial state, steady
    only if the integration does not change it.

    Parameters
    ----------
    joint
        With its elements' own law, which are integrated as springs with sliders.
    frequency, force
        Of the excitation [Hz], [N].
    damping
        Of the structure; a number is a loss factor.
    start
        Initial period of motion, modal coordinates at equally spaced times [kg^1/2 m], shape
        (samples, modes); the sliders follow it for two periods. By default the joint starts at rest
        and the force grows from zero.
    ramp
        Periods in which the force grows.
    steps
        Steps a period with the coarser step; they must resolve the highest stuck mode.
    harmonics
        Highest harmonic of the result.
    tolerance
        Change over a period below which the motion is steady, relative to its size.
    maximum_periods
        Periods after which the integration with either step ends.

    Raises
    ------
    ValueError
        If the steps are too long for stability, the friction of the joint is sampled, the start
        does not fit it, or a number is out of range.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law of the joint", joint.law, ElementLaw)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.number("force", force, above=0)
    damping = as_damping(damping)
    ramp = checks.whole("ramp", ramp, at_least=0)
    steps = checks.whole("steps", steps, at_least=3)
    harmonics = checks.whole("harmonics", harmonics, at_least=1, at_most=steps)
    tolerance = checks.number("tolerance", tolerance, above=0)
    ramped = ramp if start is None else 0
    maximum_periods = checks.whole("maximum_periods", maximum_periods, at_least=ramped + 1)
    if start is not None:
        start = checks.array("start", start, ("samples", joint.natural_frequency.size))
        checks.whole("length of start", len(start), at_least=1)
    coarse = _Integration.of(joint, frequency, force, damping, steps)
    if start is None:
        for i in range(ramp):
            coarse.advance(i / ramp, (i + 1) / ramp)
    else:
        coarse.follow(start)
    coarse_change = _reach_steady_state(coarse, tolerance, maximum_periods)
    fine = coarse.halved()
    change = _reach_steady_state(fine, tolerance, maximum_periods)
    modal = fine.coefficients(harmonics)
    extrapolated = (4 * modal[1] - coarse.coefficients(1)[1]) / 3 @ joint.response_mode
    output = modal @ joint.response_mode
    return SteadyState(
        amplitude=complex(extrapolated),
        harmonics=output,
        motion=fine.history.copy(),
        steps=fine.steps,
        periods=coarse.periods + fine.periods + ramped,
        change=change,
        step_error=float(abs(output[1] - extrapolated) / abs(extrapolated)),
        converged=max(coarse_change, change) <= tolerance,
    )


@dataclass
class _Integration:
    """State of modes and sliders under time integration with one step."""

    frequency: float
    steps: int
    modal: tuple[Array, Array, NDArray[np.complex128]]
    """Stiffness and damping of the modes, and the force on them, sine + i cosine."""
    coupled_damping: Array | None
    """C where it couples the modes."""
    elements: tuple[Array | None, ...]
    """Rows k_u R and k_v N, rows R and N, n0 and mu of the sliders.

    Under constant normal load k_v N, N and n0 are None, and the slip force stands for mu.
    """
    q: Array
    step: Array
    """Last increment of q, which avoids the rounding of differences of q."""
    z: Array
    history: Array
    periods: int = 0

    @classmethod
    def of(
        cls, joint: Joint, frequency: float, force: float, damping: Damping, steps: int
    ) -> "_Integration":
        sliders = joint.law.sliders()
        on, k_v = sliders.point, sliders.normal_stiffness
        w, natural = 2 * np.pi * frequency, 2 * np.pi * joint.natural_frequency
        L, H = natural**2, damping.matrix(joint.structure()).at(w)
        R = np.ascontiguousarray(joint.tangential_mode[on].T)
        X = sliders.tangential_stiffness * R
        stuck = np.diag(L) + R @ X.T
        if k_v is None:
            elements = X, None, R, None, None, sliders.friction_coefficient * sliders.normal_load
        else:
            N = np.ascontiguousarray(joint.normal_mode[on].T)
            V = k_v * N
            stuck += N @ V.T
            elements = X, V, R, N, sliders.normal_load, sliders.friction_coefficient
        shortest = np.pi * np.sqrt(np.linalg.eigvalsh(stuck)[-1]) / w
        if steps <= shortest:
            raise ValueError(
                f"{steps} steps a period are unstable: more than {shortest:.0f} needed"
            )
        rest, z = np.zeros((2, L.size)), np.zeros(on.size)
        modal = L, np.diag(H) / w, joint.excitation * (force + 0j)
        C = H / w if np.any(H - np.diag(np.diag(H))) else None
        return cls(frequency, steps, modal, C, elements, *rest, z, np.zeros((steps, L.size)))

    def halved(self) -> "_Integration":
        """The same state with half the step."""
        before, last = self.history[-2:]
        # parabola through the last samples, at half a step back
        between = (3 * self.q + 6 * last - before) / 8
        steps = 2 * self.steps
        history = np.zeros((steps, self.q.size))
        state = self.q.copy(), self.q - between, self.z.copy()
        structure = self.modal, self.coupled_damping
        return _Integration(self.frequency, steps, *structure, self.elements, *state, history)

    def advance(self, first_factor: float = 1.0, last_factor: float = 1.0) -> None:
        """Integrate a period over which the load factor changes linearly."""
        w = 2 * np.pi * self.frequency
        state = self.q, self.step, self.z
        factors = first_factor, last_factor
        structure = self.modal, self.coupled_damping
        _integrate_period(*state, *self.elements, *structure, w, factors, self.history)
        self.periods += 1

    def follow(self, motion: Array) -> None:
        """Start from a period of motion; the sliders follow it for two periods from zero."""
        motion = np.ascontiguousarray(resample(motion, self.steps))
        X, V, _, _, normal_load, mu = self.elements
        _sliders_along(motion, self.z, X, V, normal_load, mu)
        self.q, self.step = motion[0].copy(), motion[0] - motion[-1]

    def state(self) -> Array:
        """Displacements, velocities over w, and sliders."""
        phase = 2 * np.pi / self.steps
        return np.concatenate([self.q, self.step / phase, self.z])

    def restore(self, state: Array) -> None:
        """Set displacements, velocities and sliders to those of a state."""
        modes = self.q.size
        self.q = state[:modes].copy()
        self.step = 2 * np.pi / self.steps * state[modes : 2 * modes]
        self.z = state[2 * modes :].copy()

    def coefficients(self, harmonics: int) -> NDArray[np.complex128]:
        """Sine + i cosine of the last period by harmonic from 0, shape (harmonics + 1, modes)."""
        spectrum = np.fft.rfft(self.history, axis=0)[: harmonics + 1] / self.steps
        return np.concatenate([spectrum[:1], 2j * spectrum[1:]])


def _reach_steady_state(integration: _Integration, tolerance: float, maximum_periods: int) -> float:
    """Integrate until the motion is steady; returns its change over the last period."""
    modes = 2 * integration.q.size
    before, last_change = None, np.inf
    while integration.periods < maximum_periods:
        states = [integration.state()]
        for _ in range(_BLOCK):
            integration.advance()
            states.append(integration.state())
        changes = np.diff([state[:modes] for state in states], axis=0)
        change = float(np.linalg.norm(changes[-1]) / np.linalg.norm(states[-1][:modes]))
        if change <= tolerance:
            break
        if before is not None and change > last_change:
            # the extrapolation diverged: continue from the state before it
            integration.restore(before)
            before = None
            continue
        before = None
        # an extrapolation may displace a slider that would stick for good: only where decay is slow
        if change > _SLOW * last_change:
            before = states[-1]
            last = np.array(states[-_EXTRAPOLATED_PERIODS - 1 :])
            integration.restore(_extrapolated(last, modes))
        last_change = change
    return change


def _extrapolated(states: Array, modes: int) -> Array:
    """Limit of states that follow each other by the same matrix: reduced rank extrapolation."""
    first = np.diff(states, axis=0)
    second = np.diff(first[:, :modes], axis=0)
    weights, *_ = np.linalg.lstsq(second.T, -first[0, :modes], rcond=1e-6)
    return states[0] + weights @ first[:-1]


@njit(cache=True, error_model="numpy")
def _update_sliders(
    x: Array,
    n: Array | None,
    x_before: Array | None,
    n_before: Array | None,
    mu: Array,
    z: Array,
) -> None:
    """Move the sliders to within the slip bounds of this step."""
    for e in range(z.size):
        slider, bound = z[e], mu[e]
        if n is not None:
            # on contact closing the slider restarts there, by linear interpolation between steps
            part = n_before[e] / (n_before[e] - n[e])
            closing = x_before[e] + (x[e] - x_before[e]) * part
            slider = closing if n_before[e] < 0.0 else slider
            bound *= n[e] if n[e] > 0.0 else 0.0
        lower, upper = x[e] - bound, x[e] + bound
        slider = slider if slider > lower else lower
        z[e] = slider if slider < upper else upper


@njit(cache=True, error_model="numpy")
def _integrate_period(
    q: Array,
    step: Array,
    z: Array,
    X: Array,
    V: Array | None,
    R: Array,
    N: Array | None,
    normal_load: Array | None,
    mu: Array,
    modal: tuple[Array, Array, NDArray[np.complex128]],
    coupled_damping: Array | None,
    w: float,
    factors: tuple[float, float],
    history: Array,
) -> None:
    """Integrate a period by central differences, changing the state in place."""
    stiffness, damping, force = modal
    steps, modes = history.shape
    dt = 2 * np.pi / w / steps
    x, x_before, friction = np.empty(z.size), np.empty(z.size), np.empty(z.size)
    contact, change = np.empty(modes), np.empty(modes)
    if coupled_damping is not None:
        # of all modes at once: (1 + C dt/2) step = (1 - C dt/2) step + dt^2 acceleration
        after = np.linalg.inv(np.eye(modes) + 0.5 * dt * coupled_damping)
        before = np.eye(modes) - 0.5 * dt * coupled_damping
    if V is not None:
        normal = np.empty(modes)
        n, n_before, load = np.empty(z.size), np.empty(z.size), np.empty(z.size)
        np.dot(q - step, X, x_before)
        np.dot(q - step, V, n_before)
        n_before += normal_load
    for i in range(steps):
        np.dot(q, X, x)
        if V is not None:
            np.dot(q, V, n)
            n += normal_load
            _update_sliders(x, n, x_before, n_before, mu, z)
            for e in range(z.size):
                load[e] = max(n[e], 0.0) - max(normal_load[e], 0.0)
            np.dot(N, load, normal)
        else:
            _update_sliders(x, None, None, None, mu, z)
        for e in range(z.size):
            friction[e] = x[e] - z[e]
        np.dot(R, friction, contact)
        if V is not None:
            contact += normal
            x, x_before, n, n_before = x_before, x, n_before, n
        factor = factors[0] + (factors[1] - factors[0]) * (i / steps)
        phase = 2 * np.pi * (i / steps)
        sin, cos = factor * np.sin(phase), factor * np.cos(phase)
        for r in range(modes):
            history[i, r] = q[r]
            pull = force[r].real * sin + force[r].imag * cos
            acceleration = pull - stiffness[r] * q[r] - contact[r]
            if coupled_damping is not None:
                change[r] = dt * dt * acceleration
                continue
            d = 0.5 * damping[r] * dt
            step[r] = ((1 - d) * step[r] + dt * dt * acceleration) / (1 + d)
            q[r] += step[r]
        if coupled_damping is not None:
            step[:] = after @ (before @ step + change)
            q += step


@njit(cache=True, error_model="numpy")
def _sliders_along(
    motion: Array, z: Array, X: Array, V: Array | None, normal_load: Array | None, mu: Array
) -> None:
    """Move the sliders along a motion for two periods, up to its last sample."""
    z[:] = 0.0
    x_before = np.dot(motion[-1], X)
    if V is not None:
        n_before = np.dot(motion[-1], V) + normal_load
    for i in range(2 * len(motion)):
        x = np.dot(motion[i % len(motion)], X)
        if V is not None:
            n = np.dot(motion[i % len(motion)], V) + normal_load
            _update_sliders(x, n, x_before, n_before, mu, z)
            x_before, n_before = x, n
        else:
            _update_sliders(x, None, None, None, mu, z)
