"""Nonlinear modal synthesis: frequency responses from a backbone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from boltjoint import checks
from boltjoint.dynamics.epmc import Backbone, State
from boltjoint.dynamics.harmonic_balance import HarmonicBalance

#: why a response is not rebuilt to the ends of the window, though its backbone is complete
BEGINS_ABOVE = "the backbone begins above the response at an end of the window"


#: why a response has no peak where nothing but friction takes energy
_UNLIMITED = "friction alone does not limit the response to this force"


#: phases from the peak [rad] at which a rebuilt response is given beside the states of the path
_PHASES = np.geomspace(0.01, 1.45, 24)


#: width [rad] within which the peak of the observed point is located
_PHASE_WIDTH = 1e-8


@dataclass(frozen=True)
class SynthesisedResponse:
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


def synthesise_response(
    backbone: Backbone, force: float, window: tuple[float, float]
) -> SynthesisedResponse:
    """Response to a harmonic force near a resonance, from the backbone alone.

    At the amplitude a of the mode the force F balances (L, phi, lambda, w as of
    ``EPMCEquations``, e the excitation in modal coordinates)::

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
        return SynthesisedResponse(np.zeros(0), empty, None, False, reason)

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
    return SynthesisedResponse(
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
