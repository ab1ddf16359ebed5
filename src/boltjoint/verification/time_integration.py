"""Steady states of a joint by time integration of its modal equations.

Neither the motion is assumed nor code shared with the friction laws or the harmonic balance. The
modes are integrated by backward differences (``time_steps``), and every element keeps its slider
between steps::

    q'' + C q' + L q + R^T f + N^T (n - max(n0, 0)) = phi F sin(wt)

with ``L = diag(w_r^2)``, friction force f and normal load n of the elements. Damping H that is not
viscous has no causal model in time: at the excitation frequency w it is the viscous damping
``C = H(w) / w``, which is the same for the first harmonic.

Rigid-body modes, at 0 Hz, are moved by no contact. Of their motions, which need not return, the
one with the period of the excitation and without a mean is known in closed form.

References
----------
D. A. Smith, W. F. Ford, A. Sidi: Extrapolation methods for vector sequences. SIAM Review 29 (1987)
199-233: reduced rank extrapolation.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import resample

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.joint.model import Joint
from boltjoint.verification.time_steps import integrate_period, sliders_along

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
        Change of displacement and velocity of the modes over the last period, relative to their
        size.
    step_error
        Relative difference of the first harmonic with the finer step from the extrapolated one.
    converged
        Whether the change fell below the tolerance with both steps, and every step was solved.
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

    Rigid-body modes have their periodic motion without a mean from the first. Where the transient
    decays slowly, as on resonance with light damping, the state is set to the limit of the last
    periods by reduced rank extrapolation: a guess like any initial state, steady only if the
    integration does not change it.

    Parameters
    ----------
    joint
        With its elements' own law, which are integrated as springs with sliders.
    frequency, force
        Frequency and force of the excitation [Hz], [N].
    damping
        Damping of the structure; a number is a loss factor.
    start
        Initial period of motion, modal coordinates at equally spaced times [kg^1/2 m], shape
        (samples, modes); the sliders follow it for two periods. By default the joint starts at rest
        and the force grows from zero.
    ramp
        Periods in which the force grows.
    steps
        Steps a period with the coarser step.
    harmonics
        Highest harmonic of the result.
    tolerance
        Change over a period below which the motion is steady, relative to its size.
    maximum_periods
        Periods after which the integration with either step ends.

    Raises
    ------
    ValueError
        If the friction of the joint is sampled, the start does not fit it, or a number is out of
        range.
    """
    checks.instance("joint", joint, Joint)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.level("force", force)
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
    coarse = Integration.of(joint, frequency, force, damping, steps)
    coarse.begin(start, ramp)
    coarse_change = _reach_steady_state(coarse, tolerance, maximum_periods)
    fine = coarse.halved()
    change = _reach_steady_state(fine, tolerance, maximum_periods)
    modal = fine.coefficients(harmonics)
    extrapolated = (4 * modal[1] - coarse.coefficients(1)[1]) / 3 @ joint.response_mode
    output = modal @ joint.response_mode
    return SteadyState(
        amplitude=complex(extrapolated),
        harmonics=output,
        motion=fine.motion(),
        steps=fine.steps,
        periods=coarse.periods + fine.periods + ramped,
        change=change,
        step_error=float(abs(output[1] - extrapolated) / abs(extrapolated)),
        converged=max(coarse_change, change) <= tolerance and not fine.unsolved,
    )


@dataclass
class Integration:
    """State of modes and sliders under time integration with one step."""

    frequency: float
    steps: int
    structure: tuple[Array, Array, NDArray[np.complex128]]
    """Stiffness and damping of the modes, and the force on them, sine + i cosine."""
    elements: tuple[Array, Array, Array, Array, Array, Array]
    """Rows k_u R, k_v N, R and N, n0 and mu of the sliders, as of ``integrate_period``."""
    elastic: NDArray[np.bool_]
    """The modes that are integrated, shape (all modes,)."""
    rigid: NDArray[np.complex128]
    """Periodic motion of the others, sine + i cosine, shape (all modes,)."""
    q: Array
    """Motion of the elastic modes, and its change in the last step, shape (2, modes)."""
    v: Array
    """Its velocity, in the same way."""
    z: Array
    history: Array
    periods: int = 0
    unsolved: int = 0
    """Steps of the last period that were not solved."""

    @classmethod
    def of(
        cls, joint: Joint, frequency: float, force: float, damping: Damping, steps: int
    ) -> "Integration":
        law = joint.contact.element_law
        sliders, dashpots = law.sliders(), law.dashpots
        if sliders is None:
            raise ValueError(
                f"the law {joint.law.name!r} is not known in time: its sliders move in the plane"
            )
        on, k_u, k_v = sliders.point, sliders.tangential_stiffness, sliders.normal_stiffness
        elastic = ~joint.is_rigid
        w, L = 2 * np.pi * frequency, (2 * np.pi * joint.natural_frequency[elastic]) ** 2
        lateral = sliders.lateral
        R = np.ascontiguousarray(joint.rows[0][on][:, elastic])
        if lateral is not None:
            R[lateral] = joint.rows[1][on[lateral]][:, elastic]
        X = k_u[:, None] * R
        N, normal_load, mu = np.zeros((0, L.size)), np.zeros(0), sliders.friction_coefficient
        if k_v is None:
            elements = X, N, R, N, normal_load, mu * sliders.normal_load
        else:
            N = np.ascontiguousarray(joint.rows[-1][on][:, elastic])
            V = k_v[:, None] * N
            if lateral is not None:
                # two sliders have a normal load in common, and it acts once
                N[lateral] = 0.0
            elements = X, V, R, N, sliders.normal_load, mu
        H = np.broadcast_to(damping.matrix(joint.structure()).at(w), (elastic.size,) * 2)
        pull = joint.excitation.modes * (force + 0j)
        viscous = H[np.ix_(elastic, elastic)] / w
        if dashpots is not None:
            B = joint.rows[0][:, elastic]
            viscous = viscous + B.T @ (dashpots.at_points(joint.points)[:, None] * B)
        structure = L, np.ascontiguousarray(viscous), pull[elastic]
        # no damping model couples them with elastic modes
        among = np.ix_(~elastic, ~elastic)
        rigid = np.zeros(elastic.size, dtype=complex)
        inertia = w**2 * np.eye(int(np.count_nonzero(~elastic)))
        rigid[~elastic] = np.linalg.solve(1j * H[among] - inertia, pull[~elastic])
        (q, v), z, history = np.zeros((2, 2, L.size)), np.zeros(on.size), np.zeros((steps, L.size))
        return cls(frequency, steps, structure, elements, elastic, rigid, q, v, z, history)

    def halved(self) -> "Integration":
        """The same state with half the step."""
        h = 1 / (self.frequency * self.steps)
        (q, dq), (v, dv) = self.q, self.v
        # the cubic of the last step, half a step back
        half, change = dq / 2 + h / 8 * dv, 1.5 * (v - dq / h) - dv / 4
        state = np.array([q, half]), np.array([v, change]), self.z.copy()
        history = np.zeros((2 * self.steps, q.size))
        of_modes = self.structure, self.elements, self.elastic, self.rigid
        return Integration(self.frequency, 2 * self.steps, *of_modes, *state, history)

    def advance(self, first_factor: float = 1.0, last_factor: float = 1.0) -> None:
        """Integrate a period over which the load factor changes linearly."""
        w, state = 2 * np.pi * self.frequency, (self.q, self.v, self.z)
        factors = first_factor, last_factor
        self.unsolved = integrate_period(
            *state, self.elements, self.structure, w, factors, self.history
        )
        self.periods += 1

    def begin(self, start: Array | None, ramp: int) -> None:
        """Follow a period of all modes, or raise the force over a number of periods."""
        if start is not None:
            self.follow(start)
            return
        for i in range(ramp):
            self.advance(i / ramp, (i + 1) / ramp)

    def follow(self, motion: Array) -> None:
        """Start from a period of all modes; the sliders follow it for two periods from zero."""
        motion = np.ascontiguousarray(resample(motion[:, self.elastic], self.steps))
        spectrum = np.fft.rfft(motion, axis=0)
        turned = 1j * np.arange(len(spectrum))[:, None] * spectrum
        velocity = 2 * np.pi * self.frequency * np.fft.irfft(turned, self.steps, axis=0)
        X, V, _, _, normal_load, mu = self.elements
        sliders_along(motion, self.z, X, V, normal_load, mu)
        self.q, self.v = (
            np.array([period[0], period[0] - period[-1]]) for period in (motion, velocity)
        )

    def state(self) -> Array:
        """Displacements and velocities over w, their changes in the last step, and sliders."""
        w = 2 * np.pi * self.frequency
        motion = np.stack([self.q, self.v / w], axis=1)
        return np.concatenate([motion.ravel(), self.z])

    def restore(self, state: Array) -> None:
        """Set displacements, velocities and sliders to those of a state."""
        of_both, sliders = np.split(state, [2 * self.q.size])
        motion = of_both.reshape(2, 2, -1)
        self.q, self.v = motion[:, 0].copy(), 2 * np.pi * self.frequency * motion[:, 1]
        self.z = sliders.copy()

    def motion(self) -> Array:
        """All modes at the begin of each step of the last period, shape (steps, all modes)."""
        phase = 2j * np.pi * np.arange(self.steps) / self.steps
        motion_of_body = np.outer(np.exp(phase), self.rigid).imag
        motion_of_body[:, self.elastic] = self.history
        return motion_of_body

    def coefficients(self, harmonics: int) -> NDArray[np.complex128]:
        """Sine + i cosine of the last period by harmonic from 0, (harmonics + 1, all modes)."""
        spectrum = np.fft.rfft(self.history, axis=0)[: harmonics + 1] / self.steps
        values = np.zeros((harmonics + 1, self.elastic.size), dtype=complex)
        values[0, self.elastic] = spectrum[0]
        values[1] = self.rigid
        values[1:, self.elastic] = 2j * spectrum[1:]
        return values


def _reach_steady_state(integration: Integration, tolerance: float, maximum_periods: int) -> float:
    """Integrate until the motion is steady; returns its change over the last period."""
    motion = integration.q.size
    before, last_change = None, np.inf
    while integration.periods < maximum_periods:
        states = [integration.state()]
        for _ in range(_BLOCK):
            integration.advance()
            states.append(integration.state())
        changes = np.diff([state[:motion] for state in states], axis=0)
        change = float(np.linalg.norm(changes[-1]) / np.linalg.norm(states[-1][:motion]))
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
            integration.restore(_extrapolated(last, motion))
        last_change = change
    return change


def _extrapolated(states: Array, motion: int) -> Array:
    """Limit of states that follow each other by the same matrix: reduced rank extrapolation."""
    first = np.diff(states, axis=0)
    second = np.diff(first[:, :motion], axis=0)
    weights, *_ = np.linalg.lstsq(second.T, -first[0, :motion], rcond=1e-6)
    return states[0] + weights @ first[:-1]
