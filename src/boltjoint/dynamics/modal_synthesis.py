"""Nonlinear modal synthesis: frequency responses from a backbone.

References
----------
M. Krack, L. Panning-von Scheidt, J. Wallaschek: A method for nonlinear modal analysis and
synthesis: application to harmonically forced and self-excited mechanical systems. Journal of Sound
and Vibration 332 (2013) 6798-6814.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from boltjoint import checks
from boltjoint.dynamics.epmc import Backbone, ModalState
from boltjoint.dynamics.harmonic_balance import HarmonicBalance

#: why a response does not reach the ends of the window, though its backbone is complete
BEGINS_ABOVE = "the backbone begins above the response at an end of the window"

#: why a response has no peak where friction alone dissipates energy
_UNLIMITED = "friction alone does not limit the response to this force"

#: phases from the peak [rad] at which a response is given beside the states of the backbone
_PHASES = np.geomspace(0.01, 1.45, 24)

#: width [rad] within which the peak of the output point is located
_PHASE_WIDTH = 1e-8


@dataclass(frozen=True)
class SynthesisedResponse:
    """The response to a force from one nonlinear mode.

    ``frequency`` (solutions,) [Hz]; ``modal_coordinate`` (solutions, components * modes), as the
    unknown of ``HarmonicBalance``; ``peak``: index of the largest response of the output point,
    None without one in the window; ``complete``: whether the response covers the
    window; if not, ``reason``.
    """

    frequency: NDArray[np.float64]
    modal_coordinate: NDArray[np.float64]
    peak: int | None
    complete: bool
    reason: str


def synthesise_response(
    backbone: Backbone, force: float, window: tuple[float, float]
) -> SynthesisedResponse:
    """Response to a harmonic force near a resonance, from the backbone alone.

    At the amplitude a of the mode the force F balances (L, phi, lambda, w as of
    ``EPMCEquations``, e the excitation in modal coordinates)::

        |lambda - w^2| a |phi^T phi| = |phi^T e| F

    at two frequencies, one below and one above resonance, that coincide at the peak. The response
    of the other modes of the same state is added (quasi-static where they are far off resonance).

    Parameters
    ----------
    backbone
        Of the joint, with its loss factor.
    force
        F [N].
    window
        Lowest and highest frequency [Hz].
    """
    checks.instance("backbone", backbone, Backbone)
    force, window = checks.number("force", force, above=0), checks.interval("window", window)
    curve = _ResponseCurve(backbone, force)
    if curve.unreached == 0 or not backbone.states:
        empty = np.zeros((0, curve.balance.modal_force.size))
        reason = "the backbone begins above the peak" if backbone.states else backbone.reason
        return SynthesisedResponse(np.zeros(0), empty, None, False, reason)

    positions = curve.positions()
    points = [curve.point(*position) for position in positions]
    ends = [(2 * np.pi * f) ** 2 for f in window]
    first, last = (curve.crossing(positions, points, end) for end in ends)
    inside = [
        (position, point)
        for position, point in zip(positions, points, strict=True)
        if ends[0] < point.squared < ends[1]
    ]
    if first is not None:
        inside.insert(0, first)
    if last is not None:
        inside.append(last)
    if first is not None and last is not None:
        reason = ""
    elif curve.peak_amplitude is None:
        reason = backbone.reason or (
            "the backbone ends below the peak" if curve.balance.loss_factor else _UNLIMITED
        )
    else:
        reason = BEGINS_ABOVE
    peak = None if curve.peak_amplitude is None else curve.peak(inside)
    return SynthesisedResponse(
        frequency=np.sqrt([point.squared for _, point in inside]) / (2 * np.pi),
        modal_coordinate=np.array([point.motion for _, point in inside]).reshape(
            len(inside), curve.balance.modal_force.size
        ),
        peak=peak,
        complete=not reason,
        reason=reason,
    )


#: modal amplitude, and phase [rad] from the peak: negative below resonance, positive above, in size
#: arccos of the amplitude over that at the peak
_Position = tuple[float, float]


@dataclass(frozen=True)
class _ResponsePoint:
    squared: float
    """Square of the frequency [rad2/s2]."""
    motion: NDArray[np.float64]
    """Unknown of the balance."""


class _ResponseCurve:
    """The response to one force, from below resonance over the peak to above it."""

    def __init__(self, backbone: Backbone, force: float) -> None:
        self.backbone, self.balance = backbone, backbone.equations.balance
        self.excitation = self.balance.joint.excitation_mode * force
        states = backbone.states
        #: index of the first state whose amplitude the force does not reach
        self.unreached = next(
            (i for i, state in enumerate(states) if self._excess(state) <= 0), None
        )
        #: modal amplitude at the peak
        self.peak_amplitude: float | None = None
        if self.unreached:
            before = self.unreached - 1
            self.peak_amplitude = _root(
                lambda a: self._excess(backbone.solve_between(before, a)),
                (states[before].amplitude, states[self.unreached].amplitude),
            )

    def positions(self) -> list[_Position]:
        """Positions of the response: states of the backbone, and more near the peak."""
        amplitudes = [state.amplitude for state in self.backbone.states[: self.unreached]]
        if self.peak_amplitude is None:
            # without a peak, phases only number the amplitudes
            return [(a, -1.0 / (1 + i)) for i, a in enumerate(amplitudes)]
        phases = [
            float(np.arccos(a / self.peak_amplitude)) for a in amplitudes if a < self.peak_amplitude
        ]
        phases += [phase for phase in _PHASES if self.amplitude_at(phase) > amplitudes[0]]
        phases = sorted({*phases, 0.0})
        both = [*(-phase for phase in reversed(phases[1:])), *phases]
        return [(self.amplitude_at(phase), phase) for phase in both]

    def amplitude_at(self, phase: float) -> float:
        return self.peak_amplitude * float(np.cos(phase))

    def peak(self, points: "list[tuple[_Position, _ResponsePoint]]") -> int | None:
        """Index of the largest maximum of the output point, which is located and inserted.

        None without a maximum between the first and the last point.
        """
        amplitude = np.array([self.output_amplitude(point) for _, point in points])
        rises, falls = np.diff(amplitude[:-1]) >= 0, np.diff(amplitude[1:]) <= 0
        maxima = 1 + np.flatnonzero(rises & falls)
        if not maxima.size:
            return None
        highest = int(maxima[np.argmax(amplitude[maxima])])

        def at(phase: float) -> tuple[_Position, _ResponsePoint]:
            position = self.amplitude_at(phase), phase
            return position, self.point(*position)

        around = [points[i][0][1] for i in (highest - 1, highest + 1)]
        located = minimize_scalar(
            lambda phase: -self.output_amplitude(at(phase)[1]),
            bounds=around,
            method="bounded",
            options={"xatol": _PHASE_WIDTH},
        )
        if -located.fun <= amplitude[highest]:
            return highest
        highest += int(located.x > points[highest][0][1])
        points.insert(highest, at(located.x))
        return highest

    def output_amplitude(self, point: _ResponsePoint) -> float:
        """Amplitude of the output point [m]."""
        s, c = point.motion.reshape(-1, len(self.balance.stiffness))[-2:]
        mode = self.balance.joint.response_mode
        return float(np.hypot(s @ mode, c @ mode))

    def point(self, amplitude: float, phase: float) -> _ResponsePoint:
        state = self._state(amplitude)
        distance, damping = state.excited_distance(self.excitation), state.eigenvalue.imag
        squared = state.eigenvalue.real + np.sign(phase) * np.sqrt(
            max(distance**2 - damping**2, 0.0)
        )
        return _ResponsePoint(squared, _motion(self.balance, state, squared, self.excitation))

    def crossing(
        self, positions: Sequence[_Position], points: Sequence[_ResponsePoint], end: float
    ) -> tuple[_Position, _ResponsePoint] | None:
        """First crossing of the square of a frequency, None without one."""
        response = zip(positions, points, strict=True)
        for (position, point), (next_position, next_point) in pairwise(response):
            if point.squared <= end <= next_point.squared:
                side = position[1] + next_position[1]
                within = sorted((position[0], next_position[0]))
                a = _root(lambda a, side=side: self.point(a, side).squared - end, within)
                return (a, side), _ResponsePoint(end, self.point(a, side).motion)
        return None

    def _excess(self, state: ModalState) -> float:
        """Excitation beyond that which balances the damping, in terms of lambda."""
        return state.excited_distance(self.excitation) - state.eigenvalue.imag

    def _state(self, amplitude: float) -> ModalState:
        """State of an amplitude, on the last interval with it that the force reaches."""
        states = self.backbone.states
        last = len(states) - 1 if self.unreached is None else self.unreached
        below = [i for i in range(last) if states[i].amplitude <= amplitude]
        return self.backbone.solve_between(below[-1], amplitude) if below else states[0]


def _root(function: Callable[[float], float], within: Sequence[float]) -> float:
    """Root of a function of the amplitude between two of them."""
    low, high = within
    return float(brentq(function, low, high, xtol=1e-12 * high))


def _motion(
    balance: HarmonicBalance, state: ModalState, squared: float, excitation: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unknown of the balance at the square of a frequency [rad2/s2]."""
    harmonic = state.amplitude * state.mode
    phi = state.mode / np.sqrt(state.mode @ state.mode)
    modal_force = phi @ excitation
    y = modal_force / (state.eigenvalue - squared)
    x = np.concatenate([state.bias, harmonic.real, harmonic.imag])
    contact = balance.contact.spring_stiffness(balance.describing_function(x))
    dynamic = balance.complex_stiffness + contact - squared * np.eye(len(phi))
    residual_modes = np.linalg.solve(dynamic, excitation - phi * modal_force)
    q = phi * y + residual_modes - phi * (phi @ residual_modes)
    return np.concatenate([state.bias, q.real, q.imag])
