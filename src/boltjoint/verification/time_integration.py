"""Steady states of a joint by time integration of its modal equations."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.signal import resample

from boltjoint import checks
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


#: periods between two extrapolations, and how many of the last ones an extrapolation looks at
_BLOCK, _LOOK_BACK = 12, 8


#: a change that has not fallen to this part of itself between two extrapolations falls slowly
_SLOW = 0.5


@dataclass(frozen=True)
class SteadyState:
    """The periodic motion that a transient leaves.

    Parameters
    ----------
    amplitude
        First harmonic of the observed point [m], ``Im(amplitude exp(iwt))``, extrapolated from both
        steps.
    harmonics
        Those of the observed point from 0 [m], likewise but of the finer step; the first is the
        mean.
    motion
        Modal coordinates at the samples of the last period, finer step [kg^1/2 m], shape
        (samples, modes).
    steps
        Steps a period, of the finer march.
    periods
        How many were marched, with either step.
    change
        Of displacement and velocity of the modes over the last period, relative to their size.
    step_error
        How far the first harmonic of the finer step is from the extrapolated one, relative.
    settled
        Whether the change fell below the tolerance with both steps.
    """

    amplitude: complex
    harmonics: NDArray[np.complex128]
    motion: Array
    steps: int
    periods: int
    change: float
    step_error: float
    settled: bool


def steady_state(
    joint: Joint,
    frequency: float,
    force: float,
    loss_factor: float,
    *,
    start: Array | None = None,
    ramp: int = 100,
    steps: int = 2000,
    harmonics: int = 9,
    tolerance: float = 1e-9,
    most_periods: int = 3000,
) -> SteadyState:
    """March a joint to its steady state, with one step and then with half of it.

    Where the motion settles slowly, as on resonance with light damping, its state is put forward to
    where the last periods lead (reduced rank extrapolation). That is a guess like any start: the
    motion is steady when the march itself leaves it as it is.

    Parameters
    ----------
    joint
        With its elements' own law, constant or variable.
    frequency, force
        Of the excitation [Hz], [N].
    loss_factor
        eta [-].
    start
        A period of motion to begin with, modal coordinates at equally spaced times
        [kg^1/2 m], shape (samples, modes); the sliders are moved along with it, from rest, for two
        periods. Without it, the joint begins at rest and the force grows from zero.
    ramp
        Periods in which it grows.
    steps
        Steps a period of the coarser march; they must resolve the highest mode while all contact
        sticks.
    harmonics
        Highest harmonic of the result.
    tolerance
        Change over a period below which the motion is steady, relative to its size.
    most_periods
        After so many, either march is given up.

    Raises
    ------
    ValueError
        If the steps are too long for the highest mode: the march would be unstable; if the friction
        of the joint is sampled, or the start does not fit it; or if a number is out of range.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law of the joint", joint.law, ConstantLoad, VariableLoad)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.number("force", force, above=0)
    loss_factor = checks.number("loss_factor", loss_factor, at_least=0)
    ramp = checks.whole("ramp", ramp, at_least=0)
    steps = checks.whole("steps", steps, at_least=3)
    harmonics = checks.whole("harmonics", harmonics, at_least=1, at_most=steps)
    tolerance = checks.number("tolerance", tolerance, above=0)
    begun = ramp if start is None else 0
    most_periods = checks.whole("most_periods", most_periods, at_least=begun + 1)
    if start is not None:
        start = checks.array("start", start, ("samples", joint.natural_frequency.size))
        checks.whole("length of start", len(start), at_least=1)
    march = _March.of(joint, frequency, force, loss_factor, steps)
    if start is None:
        for i in range(ramp):
            march.period(i / ramp, (i + 1) / ramp)
    else:
        march.follow(start)
    coarse_change = _settle(march, tolerance, most_periods)
    coarse = march.coefficients(1)[1]
    fine = march.halved()
    change = _settle(fine, tolerance, most_periods)
    modal = fine.coefficients(harmonics)
    extrapolated = (4 * modal[1] - coarse) / 3 @ joint.response_mode
    found = modal @ joint.response_mode
    return SteadyState(
        amplitude=complex(extrapolated),
        harmonics=found,
        motion=fine.history.copy(),
        steps=fine.steps,
        periods=march.periods + fine.periods + begun,
        change=change,
        step_error=float(abs(found[1] - extrapolated) / abs(extrapolated)),
        settled=max(coarse_change, change) <= tolerance,
    )


@dataclass
class _March:
    """Modes and sliders on their way."""

    frequency: float
    steps: int
    modal: tuple[Array, Array, Array]
    """Stiffness and damping of the modes, and the force on them."""
    elements: tuple[Array | None, ...]
    """What gives x = k_u u and k_v v from the modes; what takes friction and load to them; n0; mu.

    Under constant load all that has to do with n is None, and mu n stands for mu.
    """
    q: Array
    step: Array
    """By which the modes last moved; summed up, it is free of the rounding of differences of q."""
    z: Array
    history: Array
    periods: int = 0

    @classmethod
    def of(
        cls, joint: Joint, frequency: float, force: float, loss_factor: float, steps: int
    ) -> "_March":
        law, on = joint.law, joint.law.point_of_element
        w, L = 2 * np.pi * frequency, (2 * np.pi * joint.natural_frequency) ** 2
        R = np.ascontiguousarray(joint.tangential_mode[on].T)
        X = law.tangential_stiffness * R
        stuck = np.diag(L) + R @ X.T
        if joint.normal_mode is None:
            elements = X, None, R, None, None, law.slip_force
        else:
            N = np.ascontiguousarray(joint.normal_mode[on].T)
            V = law.normal_stiffness * N
            stuck += N @ V.T
            elements = X, V, R, N, law.normal_load, law.friction_coefficient
        shortest = np.pi * np.sqrt(np.linalg.eigvalsh(stuck)[-1]) / w
        if steps <= shortest:
            raise ValueError(
                f"{steps} steps a period are unstable: more than {shortest:.0f} needed"
            )
        rest, z = np.zeros((2, L.size)), np.zeros(on.size)
        modal = L, loss_factor * L / w, joint.excitation_mode * force
        return cls(frequency, steps, modal, elements, *rest, z, np.zeros((steps, L.size)))

    def halved(self) -> "_March":
        """Go on with half the step."""
        before, last = self.history[-2:]
        # the parabola through the last samples, half a step back
        between = (3 * self.q + 6 * last - before) / 8
        steps = 2 * self.steps
        history = np.zeros((steps, self.q.size))
        state = self.q.copy(), self.q - between, self.z.copy()
        return _March(self.frequency, steps, self.modal, self.elements, *state, history)

    def period(self, force_before: float = 1.0, force_after: float = 1.0) -> None:
        """March a period in which the force goes from one part of itself to another."""
        w = 2 * np.pi * self.frequency
        state = self.q, self.step, self.z
        forces = force_before, force_after
        _march_period(*state, *self.elements, self.modal, w, forces, self.history)
        self.periods += 1

    def follow(self, motion: Array) -> None:
        """Take up a motion: the sliders are moved along with it for two periods, from rest."""
        motion = np.ascontiguousarray(resample(motion, self.steps))
        X, V, _, _, normal_load, mu = self.elements
        _move_along(motion, self.z, X, V, normal_load, mu)
        self.q, self.step = motion[0].copy(), motion[0] - motion[-1]

    def state(self) -> Array:
        """Displacements, velocities over w and sliders, one after another."""
        phase = 2 * np.pi / self.steps
        return np.concatenate([self.q, self.step / phase, self.z])

    def restore(self, state: Array) -> None:
        """Go back to a state."""
        modes = self.q.size
        self.q = state[:modes].copy()
        self.step = 2 * np.pi / self.steps * state[modes : 2 * modes]
        self.z = state[2 * modes :].copy()

    def coefficients(self, harmonics: int) -> NDArray[np.complex128]:
        """Sine + i cosine of the last period by harmonic from 0, shape (harmonics + 1, modes)."""
        spectrum = np.fft.rfft(self.history, axis=0)[: harmonics + 1] / self.steps
        return np.concatenate([spectrum[:1], 2j * spectrum[1:]])


def _settle(march: _March, tolerance: float, most_periods: int) -> float:
    """March until the motion is steady; the change over the last period."""
    modes = 2 * march.q.size
    before, reached = None, np.inf
    while march.periods < most_periods:
        states = [march.state()]
        for _ in range(_BLOCK):
            march.period()
            states.append(march.state())
        way = np.diff([state[:modes] for state in states], axis=0)
        change = float(np.linalg.norm(way[-1]) / np.linalg.norm(states[-1][:modes]))
        if change <= tolerance:
            break
        if before is not None and change > reached:
            # it led astray: go on from where it began, and for once without
            march.restore(before)
            before = None
            continue
        before = None
        # a jump may move a slider that would have stayed for good: only where there is no other way
        if change > _SLOW * reached:
            before = states[-1]
            march.restore(_extrapolated(np.array(states[-_LOOK_BACK - 1 :]), modes))
        reached = change
    return change


def _extrapolated(states: Array, modes: int) -> Array:
    """Where states lead that are multiplied by the same matrix each time.

    The mean of the states, with weights that make it change the least.
    """
    way = np.diff(states, axis=0)
    bend = np.diff(way[:, :modes], axis=0)
    steps, *_ = np.linalg.lstsq(bend.T, -way[0, :modes], rcond=1e-6)
    return states[0] + steps @ way[:-1]


@njit(cache=True, error_model="numpy")
def _slide(
    x: Array,
    n: Array | None,
    x_before: Array | None,
    n_before: Array | None,
    mu: Array,
    z: Array,
) -> None:
    """Move the sliders to where the bounds of this step leave them."""
    for e in range(z.size):
        slider, bound = z[e], mu[e]
        if n is not None:
            # surfaces that meet lay the slider down where they do, on a straight line between steps
            way = n_before[e] / (n_before[e] - n[e])
            laid_down = x_before[e] + (x[e] - x_before[e]) * way
            slider = laid_down if n_before[e] < 0.0 else slider
            bound *= n[e] if n[e] > 0.0 else 0.0
        lower, upper = x[e] - bound, x[e] + bound
        slider = slider if slider > lower else lower
        z[e] = slider if slider < upper else upper


@njit(cache=True, error_model="numpy")
def _march_period(
    q: Array,
    step: Array,
    z: Array,
    X: Array,
    V: Array | None,
    R: Array,
    N: Array | None,
    normal_load: Array | None,
    mu: Array,
    modal: tuple[Array, Array, Array],
    w: float,
    forces: tuple[float, float],
    history: Array,
) -> None:
    """March a period by central differences, changing the state in place."""
    stiffness, damping, force = modal
    steps, modes = history.shape
    dt = 2 * np.pi / w / steps
    x, x_before, friction = np.empty(z.size), np.empty(z.size), np.empty(z.size)
    contact = np.empty(modes)
    if V is not None:
        across = np.empty(modes)
        n, n_before, load = np.empty(z.size), np.empty(z.size), np.empty(z.size)
        np.dot(q - step, X, x_before)
        np.dot(q - step, V, n_before)
        n_before += normal_load
    for i in range(steps):
        np.dot(q, X, x)
        if V is not None:
            np.dot(q, V, n)
            n += normal_load
            _slide(x, n, x_before, n_before, mu, z)
            for e in range(z.size):
                load[e] = max(n[e], 0.0) - max(normal_load[e], 0.0)
            np.dot(N, load, across)
        else:
            _slide(x, None, None, None, mu, z)
        for e in range(z.size):
            friction[e] = x[e] - z[e]
        np.dot(R, friction, contact)
        if V is not None:
            contact += across
            x, x_before, n, n_before = x_before, x, n_before, n
        share = i / steps
        part = forces[0] + (forces[1] - forces[0]) * share
        excitation = part * np.sin(2 * np.pi * share)
        for r in range(modes):
            history[i, r] = q[r]
            pull = force[r] * excitation - stiffness[r] * q[r] - contact[r]
            brake = 0.5 * damping[r] * dt
            step[r] = ((1 - brake) * step[r] + dt * dt * pull) / (1 + brake)
            q[r] += step[r]


@njit(cache=True, error_model="numpy")
def _move_along(
    motion: Array, z: Array, X: Array, V: Array | None, normal_load: Array | None, mu: Array
) -> None:
    """Move the sliders along with a motion for two periods, up to its last sample."""
    z[:] = 0.0
    x_before = np.dot(motion[-1], X)
    if V is not None:
        n_before = np.dot(motion[-1], V) + normal_load
    for i in range(2 * len(motion)):
        x = np.dot(motion[i % len(motion)], X)
        if V is not None:
            n = np.dot(motion[i % len(motion)], V) + normal_load
            _slide(x, n, x_before, n_before, mu, z)
            x_before, n_before = x, n
        else:
            _slide(x, None, None, None, mu, z)
