"""How do a joint's resonance and its damping change with amplitude? Modes at given amplitudes.

With one harmonic, the modes of the extended periodic motion concept (Krack, Comput. Struct. 154,
2015): the joint is held in a periodic motion without excitation by an artificial damping that
gives back what friction and structure take. Its frequency and its damping over amplitude are the
joint's backbone, from which the response to any force near the resonance is rebuilt.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from boltjoint import checks
from boltjoint.balance import HarmonicBalance
from boltjoint.dataset import quantity
from boltjoint.joint import Joint
from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.equations import Equations, LazyJacobian, Solution, StepControl
from boltjoint.solvers.newton import newton

#: change of the logarithm of the amplitude that counts, in arc length, as much as doubling a mode
_SCALE = 3.0

#: longest step along a backbone [arc length]
_STEP = 0.1

#: amplitudes from which the mode is tried to be found, over the lowest asked for
_LOWER = (1.0, 0.1, 0.01, 1e-3, 1e-5, 1e-7)

#: loss factor below which amplitudes are no longer followed to where it alone limits the response
_LEAST_LOSS_FACTOR = 1e-5

#: why a response is not rebuilt to the ends of the window, though its backbone is complete
BEGINS_ABOVE = "the backbone begins above the response at an end of the window"

#: why a response has no peak where nothing but friction takes energy
_UNLIMITED = "friction alone does not limit the response to this force"

#: phases from the peak [rad] at which a rebuilt response is given beside the states of the path
_PHASES = np.geomspace(0.01, 1.45, 24)

#: width [rad] within which the peak of the observed point is located
_PHASE_WIDTH = 1e-8


class ModeAtAmplitude(Equations):
    """The mode phi and its eigenvalue at an amplitude a, as equations that can be followed.

    With ``f(q)`` the contact's harmonic force under ``q = Im(a phi exp(iwt))`` and the bias
    ``a beta``, L, eta and the components as of ``HarmonicBalance``::

        (L (1 + i eta) - lambda) phi + f_1(a phi, a beta) / a = 0
        L beta + f_0(a phi, a beta) / a = 0
        phi^H phi = 1

    ``lambda = w^2 (1 + 2 i zeta)`` holds the frequency w and the damping ratio zeta. The mode is
    normalised to unit modal mass with the conjugate (Krack 2015), so that a is the amplitude
    whatever the phases of the motion. The phase of phi is arbitrary: it is held to that of the last
    accepted solution. The unknown is that of the balance over a, then real and imaginary part of
    lambda over that of the stuck mode; the parameter is the logarithm of a.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    loss_factor
        eta [-].
    resonance
        Which mode of the stuck structure the path starts from, from 1.

    Raises
    ------
    ValueError
        If the structure has fewer modes, or its motion has further harmonics.
    """

    residual_scale = 1.0

    def __init__(self, joint: Joint, loss_factor: float, resonance: int = 1) -> None:
        self.balance = HarmonicBalance(joint, loss_factor, 0.0)
        self._modes = len(self.balance.stiffness)
        if self.balance.components[-2:] != ("sin", "cos") or len(self.balance.components) > 3:
            raise ValueError("a backbone needs a motion of one harmonic")
        resonance = joint.check_resonance(resonance)
        squared, vectors = np.linalg.eigh(self.balance.stiffness + joint.stuck_stiffness())
        self.scale, self.stuck = squared[resonance - 1], vectors[:, resonance - 1]
        #: sine and cosine part of the mode whose phase the unknown has
        self.tracked = self.stuck, np.zeros(self._modes)

    def start(self) -> NDArray[np.float64]:
        """The stuck mode and its eigenvalue, without damping."""
        mode = np.zeros((len(self.balance.components), self._modes))
        mode[-2] = self.stuck
        return np.append(mode.ravel(), [1.0, 0.0])

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual at the amplitude exp(p), and what forms its Jacobian."""
        a, modes = np.exp(p), self._modes
        s, c = x[-2 - 2 * modes : -2].reshape(2, -1)
        real, imaginary = x[-2:]
        force, jacobian_of_force = self.balance.residual_and_jacobian(a * x[:-2], 0.0)
        s_0, c_0 = self.tracked
        residual = np.append(force / (a * self.scale), [s @ s + c @ c - 1, s_0 @ c - c_0 @ s])
        residual[-2 - 2 * modes : -2 - modes] -= real * s - imaginary * c
        residual[-2 - modes : -2] -= real * c + imaginary * s
        return residual, lambda: self._jacobian(x, jacobian_of_force())

    def _jacobian(
        self, x: NDArray[np.float64], of_force: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The Jacobian from that of the balance without excitation and inertia."""
        modes = self._modes
        s, c = x[-2 - 2 * modes : -2].reshape(2, -1)
        real, imaginary = x[-2:]
        jacobian = np.zeros((x.size, x.size))
        jacobian[:-2, :-2] = of_force / self.scale

        sin, cos = slice(-2 - 2 * modes, -2 - modes), slice(-2 - modes, -2)
        unit = np.eye(modes)
        jacobian[sin, sin] -= real * unit
        jacobian[sin, cos] += imaginary * unit
        jacobian[cos, sin] -= imaginary * unit
        jacobian[cos, cos] -= real * unit
        jacobian[sin, -2:] = np.column_stack([-s, c])
        jacobian[cos, -2:] = np.column_stack([-c, -s])
        jacobian[-2, sin], jacobian[-2, cos] = 2 * s, 2 * c
        jacobian[-1, cos], jacobian[-1, sin] = self.tracked[0], -self.tracked[1]
        return jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the amplitude."""
        a, mode = np.exp(p), x[:-2]
        force, change = self.balance.residual_and_change(a * mode, 0.0, mode)
        return np.append((change - force / a) / self.scale, [0.0, 0.0])

    def accept(self, x: NDArray[np.float64]) -> None:
        """Hold the phase of the mode to that of x from here on."""
        self.tracked = tuple(x[-2 - 2 * self._modes : -2].reshape(2, -1))

    def amplitudes_for(
        self, forces: Sequence[float], window: tuple[float, float]
    ) -> tuple[float, float]:
        """Amplitudes between which the responses to some forces lie in a window [kg^1/2 m].

        From below what the smallest force can do to the stuck mode at the ends of the window [Hz]
        to above what structural damping alone would let the largest one do. Without it nothing
        limits the response where all contact slips: a loss factor of 1e-5 then stands for it.
        """
        forces, window = checks.numbers("forces", forces), checks.interval("window", window)
        excitation = self.balance.joint.excitation_mode
        distance = max(abs(self.scale - (2 * np.pi * f) ** 2) for f in window)
        lowest = min(forces) * abs(self.stuck @ excitation) / distance
        loss_factor = max(self.balance.loss_factor, _LEAST_LOSS_FACTOR)
        losses = loss_factor * np.min(np.diag(self.balance.stiffness))
        return 0.3 * lowest, 1.5 * max(forces) * np.linalg.norm(excitation) / losses


@dataclass(frozen=True)
class State:
    """The mode of a joint at one amplitude.

    ``amplitude`` a [kg^1/2 m]; ``mode`` phi, complex, phi^H phi = 1, shape (linear modes,);
    ``bias`` a beta, of the same shape, empty where the law has none; ``eigenvalue`` lambda
    [rad2/s2].
    """

    amplitude: float
    mode: NDArray[np.complex128]
    bias: NDArray[np.float64]
    eigenvalue: complex

    @property
    def frequency(self) -> float:
        """Natural frequency [Hz]."""
        return float(np.sqrt(self.eigenvalue.real) / (2 * np.pi))

    @property
    def damping_ratio(self) -> float:
        """Damping ratio zeta [-]."""
        return self.eigenvalue.imag / (2 * self.eigenvalue.real)

    def excited_by(self, excitation: NDArray[np.float64]) -> float:
        """Distance ``|lambda - w^2|`` at which a modal excitation holds the amplitude [rad2/s2]."""
        return abs(self.mode @ excitation / (self.mode @ self.mode)) / self.amplitude


class Backbone:
    """The path of a mode over its amplitude, and the mode at any amplitude on it.

    Parameters
    ----------
    equations
        The mode that is followed.
    amplitudes
        Lowest and highest [kg^1/2 m]. Where the mode is not found at the lowest, it is followed
        from a lower one.
    control
        Tolerance and step lengths.
    """

    def __init__(
        self,
        equations: ModeAtAmplitude,
        amplitudes: tuple[float, float],
        control: StepControl | None = None,
    ) -> None:
        checks.instance("equations", equations, ModeAtAmplitude)
        control = StepControl() if control is None else control
        checks.instance("control", control, StepControl)
        self.equations = equations
        self._control = replace(control, largest_step=_STEP)
        low, high = np.log(checks.interval("amplitudes", amplitudes))
        path = None
        for lower in np.log(_LOWER):
            # the stuck mode leads to where little slips, and the path from there to where more does
            equations.tracked = equations.stuck, np.zeros_like(equations.stuck)
            window = (low + lower, high)
            found = trace(equations, equations.start(), window, self._control, scale=_SCALE)
            if path is None or found.complete or len(path.solutions) < 2:
                path = found
            if path.complete:
                break
        self._solutions = [solution for solution in path.solutions if solution.converged]
        self.complete, self.reason = path.complete, path.reason
        self.states = [self._state(solution) for solution in self._solutions]

    def between(self, index: int, amplitude: float) -> State:
        """The mode at an amplitude between those of a state on the path and the next."""
        first, second = self._solutions[index : index + 2]
        p = float(np.log(amplitude))
        self.equations.accept(first.x)
        share = (p - first.p) / (second.p - first.p)
        guess = first.x + share * (second.x - first.x)
        return self._state(newton(self.equations, guess, p, self._control)[0])

    def _state(self, solution: Solution) -> State:
        a, modes = np.exp(solution.p), len(self.equations.stuck)
        s, c = solution.x[-2 - 2 * modes : -2].reshape(2, -1)
        return State(
            amplitude=float(a),
            mode=s + 1j * c,
            bias=a * solution.x[: -2 - 2 * modes],
            eigenvalue=complex(*solution.x[-2:]) * self.equations.scale,
        )


@dataclass(frozen=True)
class Rebuilt:
    """The response to a force as one mode gives it.

    ``frequency`` (solutions,) [Hz]; ``modal_coordinate`` (solutions, components * modes), as the
    unknown of ``HarmonicBalance``; ``peak``: index of the largest response of the observed point,
    None where it is not reached in the window; ``complete``: whether the response covers the
    window; if not, ``reason``.
    """

    frequency: NDArray[np.float64]
    modal_coordinate: NDArray[np.float64]
    peak: int | None
    complete: bool
    reason: str


def rebuild(backbone: Backbone, force: float, window: tuple[float, float]) -> Rebuilt:
    """Response to a harmonic force near a resonance, from the backbone alone.

    At the amplitude a of the mode the force F balances (L, phi, lambda, w as of
    ``ModeAtAmplitude``, e the excitation in modal coordinates)::

        |lambda - w^2| a |phi^T phi| = |phi^T e| F

    which two frequencies do, one below and one above resonance, until they meet at the peak. The
    other modes of the same state add what they do under the force.

    Parameters
    ----------
    backbone
        Of the joint and its loss factor.
    force
        F [N].
    window
        Lowest and highest frequency [Hz].
    """
    checks.instance("backbone", backbone, Backbone)
    force, window = checks.number("force", force, above=0), checks.interval("window", window)
    curve = _Curve(backbone, force)
    if curve.beyond == 0 or not backbone.states:
        empty = np.zeros((0, curve.balance.modal_force.size))
        reason = "the backbone begins above the peak" if backbone.states else backbone.reason
        return Rebuilt(np.zeros(0), empty, None, False, reason)

    places = curve.places()
    points = [curve.point(*place) for place in places]
    ends = [(2 * np.pi * f) ** 2 for f in window]
    first, last = (curve.crossing(places, points, end) for end in ends)
    inside = [
        (place, point)
        for place, point in zip(places, points, strict=True)
        if ends[0] < point.squared < ends[1]
    ]
    if first is not None:
        inside.insert(0, first)
    if last is not None:
        inside.append(last)
    if first is not None and last is not None:
        reason = ""
    elif curve.at_peak is None:
        reason = backbone.reason or (
            "the backbone ends below the peak" if curve.balance.loss_factor else _UNLIMITED
        )
    else:
        reason = BEGINS_ABOVE
    peak = None if curve.at_peak is None else curve.peak(inside)
    return Rebuilt(
        frequency=np.sqrt([point.squared for _, point in inside]) / (2 * np.pi),
        modal_coordinate=np.array([point.motion for _, point in inside]).reshape(
            len(inside), curve.balance.modal_force.size
        ),
        peak=peak,
        complete=not reason,
        reason=reason,
    )


#: amplitude of the mode, and the phase [rad] that stands for a place on a response: below
#: resonance negative, above positive, in size arccos of the amplitude over that at the peak
_Place = tuple[float, float]


@dataclass(frozen=True)
class _Point:
    squared: float
    """Square of the frequency [rad2/s2]."""
    motion: NDArray[np.float64]
    """Unknown of the balance."""


class _Curve:
    """The response to one force, from below resonance over the peak to above."""

    def __init__(self, backbone: Backbone, force: float) -> None:
        self.backbone, self.balance = backbone, backbone.equations.balance
        self.excitation = self.balance.joint.excitation_mode * force
        states = backbone.states
        #: index of the first state that the force does not reach
        self.beyond = next((i for i, state in enumerate(states) if self._excess(state) <= 0), None)
        #: amplitude at the peak of the mode
        self.at_peak: float | None = None
        if self.beyond:
            before = self.beyond - 1
            self.at_peak = _root(
                lambda a: self._excess(backbone.between(before, a)),
                (states[before].amplitude, states[self.beyond].amplitude),
            )

    def places(self) -> list[_Place]:
        """Where the response is given: at states of the backbone, and closer near the peak."""
        amplitudes = [state.amplitude for state in self.backbone.states[: self.beyond]]
        if self.at_peak is None:
            # with no peak, phases count amplitudes only
            return [(a, -1.0 / (1 + i)) for i, a in enumerate(amplitudes)]
        phases = [float(np.arccos(a / self.at_peak)) for a in amplitudes if a < self.at_peak]
        phases += [phase for phase in _PHASES if self.amplitude_at(phase) > amplitudes[0]]
        phases = sorted({*phases, 0.0})
        both = [*(-phase for phase in reversed(phases[1:])), *phases]
        return [(self.amplitude_at(phase), phase) for phase in both]

    def amplitude_at(self, phase: float) -> float:
        return self.at_peak * float(np.cos(phase))

    def peak(self, points: "list[tuple[_Place, _Point]]") -> int | None:
        """Index of the largest maximum of the observed point, which is added where it lies.

        None where the observed point has no maximum between the first and the last.
        """
        observed = np.array([self.observed(point) for _, point in points])
        rises, falls = np.diff(observed[:-1]) >= 0, np.diff(observed[1:]) <= 0
        maxima = 1 + np.flatnonzero(rises & falls)
        if not maxima.size:
            return None
        highest = int(maxima[np.argmax(observed[maxima])])

        def at(phase: float) -> tuple[_Place, _Point]:
            place = self.amplitude_at(phase), phase
            return place, self.point(*place)

        around = [points[i][0][1] for i in (highest - 1, highest + 1)]
        found = minimize_scalar(
            lambda phase: -self.observed(at(phase)[1]),
            bounds=around,
            method="bounded",
            options={"xatol": _PHASE_WIDTH},
        )
        if -found.fun <= observed[highest]:
            return highest
        highest += int(found.x > points[highest][0][1])
        points.insert(highest, at(found.x))
        return highest

    def observed(self, point: "_Point") -> float:
        """Amplitude of the observed point [m]."""
        s, c = point.motion.reshape(-1, len(self.balance.stiffness))[-2:]
        mode = self.balance.joint.response_mode
        return float(np.hypot(s @ mode, c @ mode))

    def point(self, amplitude: float, phase: float) -> _Point:
        state = self._state(amplitude)
        excited, lost = state.excited_by(self.excitation), state.eigenvalue.imag
        squared = state.eigenvalue.real + np.sign(phase) * np.sqrt(max(excited**2 - lost**2, 0.0))
        return _Point(squared, _motion(self.balance, state, squared, self.excitation))

    def crossing(
        self, places: Sequence[_Place], points: Sequence[_Point], end: float
    ) -> tuple[_Place, _Point] | None:
        """Where the response crosses the square of a frequency, None where it does not."""
        for (place, point), (further, beyond) in pairwise(zip(places, points, strict=True)):
            if point.squared <= end <= beyond.squared:
                side = place[1] + further[1]
                within = sorted((place[0], further[0]))
                a = _root(lambda a, side=side: self.point(a, side).squared - end, within)
                found = self.point(a, side)
                return (a, side), _Point(end, found.motion)
        return None

    def _excess(self, state: State) -> float:
        """How much more the force does than the damping needs, in terms of lambda."""
        return state.excited_by(self.excitation) - state.eigenvalue.imag

    def _state(self, amplitude: float) -> State:
        """The state of an amplitude, on the last stretch in reach of the force that holds it."""
        states = self.backbone.states
        last = len(states) - 1 if self.beyond is None else self.beyond
        below = [i for i in range(last) if states[i].amplitude <= amplitude]
        return self.backbone.between(below[-1], amplitude) if below else states[0]


def _root(function: Callable[[float], float], within: Sequence[float]) -> float:
    """Where a function of the amplitude vanishes, between two of them."""
    low, high = within
    return float(brentq(function, low, high, xtol=1e-12 * high))


def _motion(
    balance: HarmonicBalance, state: State, squared: float, excitation: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unknown of the balance at the square of a frequency [rad2/s2]."""
    own = state.amplitude * state.mode
    phi = state.mode / np.sqrt(state.mode @ state.mode)
    share = phi @ excitation
    y = share / (state.eigenvalue - squared)
    secant = balance.secant_stiffness(np.concatenate([state.bias, own.real, own.imag]))
    matrix = balance.stiffness_with(secant) + 1j * balance.loss_factor * balance.stiffness
    rest = np.linalg.solve(matrix - squared * np.eye(len(phi)), excitation - phi * share)
    q = phi * y + rest - phi * (phi @ rest)
    return np.concatenate([state.bias, q.real, q.imag])


def find_backbone(
    joint: Joint,
    forces: Sequence[float],
    *,
    loss_factor: float,
    window: tuple[float, float],
    resonance: int = 1,
    control: StepControl | None = None,
) -> xr.Dataset:
    """Natural frequency and damping ratio of a joint over its amplitude (``backbone.nc``).

    Parameters
    ----------
    joint
        The joint and its structure.
    forces
        Amplitudes of the excitation [N] whose responses the backbone shall reach.
    loss_factor
        Structural damping eta [-].
    window
        Lowest and highest frequency of those responses [Hz].
    resonance
        Which mode, from 1.
    control
        Tolerance and step lengths.

    Returns
    -------
    Dataset
        By state: ``modal_amplitude`` [kg^1/2 m], ``response_amplitude`` of the observed point [m],
        ``natural_frequency`` [Hz], ``damping_ratio``, ``peak_force`` [N], under which the response
        is largest at that state, ``mode_shape`` (state, mode, part); ``complete`` and ``reason``.

    Raises
    ------
    ValueError
        If forces, loss factor or window are out of range, the structure has fewer modes, the motion
        has further harmonics, or the force does not excite the resonance.
    """
    checks.instance("joint", joint, Joint)
    joint.check_excitation(resonance)
    equations = ModeAtAmplitude(joint, loss_factor, resonance)
    backbone = Backbone(equations, equations.amplitudes_for(forces, window), control)
    states = backbone.states
    amplitude = np.array([state.amplitude for state in states])
    mode = np.array([state.mode for state in states]).reshape(-1, len(joint.response_mode))
    needed = [state.eigenvalue.imag / state.excited_by(joint.excitation_mode) for state in states]
    return xr.Dataset(
        {
            "modal_amplitude": quantity("state", amplitude, "kg^1/2 m", "amplitude of the mode"),
            "response_amplitude": quantity(
                "state",
                amplitude * abs(mode @ joint.response_mode),
                "m",
                "amplitude of the observed point",
            ),
            "natural_frequency": quantity(
                "state", [state.frequency for state in states], "Hz", "natural frequency"
            ),
            "damping_ratio": quantity(
                "state", [state.damping_ratio for state in states], "1", "damping ratio"
            ),
            "peak_force": quantity(
                "state", needed, "N", "excitation under which the response is largest here"
            ),
            "mode_shape": quantity(
                ("state", "mode", "part"),
                np.stack([mode.real, mode.imag], axis=-1),
                "1",
                "combination of the linear modes, phi^H phi = 1",
            ),
            "complete": quantity(
                (), np.int8(backbone.complete), "1", "1 where the path reached its last amplitude"
            ),
            "reason": quantity((), backbone.reason, "1", "why the path broke off"),
        },
        coords={"part": ["real", "imaginary"]},
        attrs={"loss_factor": loss_factor, "resonance": resonance},
    )
