"""Nonlinear modal synthesis: frequency responses from a backbone.

References
----------
M. Krack, L. Panning-von Scheidt, J. Wallaschek: A method for nonlinear modal analysis and
synthesis: application to harmonically forced and self-excited mechanical systems. Journal of Sound
and Vibration 332 (2013) 6798-6814.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from boltjoint import checks
from boltjoint.dynamics.backbone.backbone import Backbone
from boltjoint.dynamics.backbone.between_states import BetweenStates, solve_minimum
from boltjoint.dynamics.backbone.epmc import ModalState
from boltjoint.dynamics.balance.harmonic_balance import OutputPoint

#: why a response has no peak where friction alone dissipates energy
_UNLIMITED = "friction alone does not limit the response to this force"

#: phases from the peak [rad] at which a response is given where states of the backbone are farther
#: apart, dense enough to draw it; the peak does not depend on them
_PHASES = np.array([0.06, 0.18, 0.35, 0.55, 0.8, 1.05, 1.3])

#: width within which a maximum is located, over the step that it lies in: at a corner the place is
#: off by as much
_WIDTH = 1e-8

#: distance from a maximum, over the step, at which amplitudes are compared to locate it
_ASIDE = 1e-3

#: relative difference of amplitudes that are equal to what their states are solved to
_EQUAL = 1e-11

#: amplitude of a point over the highest from which it may lie beside the largest maximum: points
#: near the peak are 0.2 rad apart, and one of a corner was 2 % higher than those beside it
_NEARLY_HIGHEST = 0.9

#: relative excess of the force at a peak beyond which its mode is not solved: solutions have 1e-8,
#: what Newton's method leaves where it fails some tenths or more
_LARGEST_EXCESS = 1e-3

#: relative excess of the force at a state up to which a mode beside it may need more than the force
_SMALL_EXCESS = 1.0

#: factors by which steps of a backbone are shorter where the mode is not found between two states:
#: there the backbone has turned, or a contact has changed its state, within one step
_SHORTER_STEPS = (4.0, 16.0, 64.0)


@dataclass(frozen=True)
class SynthesisedResponse:
    """The response to a force from one nonlinear mode.

    ``frequency`` (solutions,) [Hz]; ``modal_coordinate`` (solutions, components * modes), as the
    unknown of ``HarmonicBalance``; ``peak``: index of the largest response of the output point,
    None without one in the window; ``complete``: whether the response covers the
    window; if not, ``reason``; ``has_isolated``: whether the force also excites higher amplitudes
    of the backbone, on an isolated branch.
    """

    frequency: NDArray[np.float64]
    modal_coordinate: NDArray[np.float64]
    peak: int | None
    complete: bool
    reason: str
    has_isolated: bool


def synthesise_response(
    backbone: Backbone, force: float, window: tuple[float, float]
) -> SynthesisedResponse:
    """Response to a harmonic force near a resonance, from the backbone alone.

    At the amplitude a of the mode the force F balances (L, phi, lambda, w as of
    ``EPMCEquations``, e the excitation in modal coordinates)::

        |lambda - w^2| a |phi^T phi| = |phi^T e| F

    with the damping of the structure at the frequency w of the response (``ModalState``),
    at two frequencies, one below and one above resonance, that coincide at the peak. The response
    of the other modes of the same state is added (quasi-static where they are far off resonance).

    Parameters
    ----------
    backbone
        Backbone of the joint, with its damping.
    force
        F [N].
    window
        Lowest and highest frequency [Hz].
    """
    checks.instance("backbone", backbone, Backbone)
    force, window = checks.level("force", force), checks.interval("window", window)
    curve = _ResponseCurve(backbone, force)
    for factor in _SHORTER_STEPS:
        if curve.is_solved:
            break
        curve = _ResponseCurve(backbone.with_shorter_steps(factor), force)
    backbone = curve.backbone
    if not backbone.states or curve.unreached == 0:
        empty = np.zeros((0, backbone.equations.start().size - 2))
        reason = "the backbone begins above the peak" if backbone.states else backbone.reason
        return SynthesisedResponse(np.zeros(0), empty, None, False, reason, curve.has_isolated)

    points = curve.points()
    low, high = ((2 * np.pi * f) ** 2 for f in window)
    first, last = curve.crossing(points, low), curve.crossing(points, high)
    if last:
        points = [*points[: last[0]], last[1]]
    if first:
        points = [first[1], *points[first[0] :]]
    points = [point for point in points if low <= point.squared <= high]
    if first and last:
        reason = ""
    elif not curve.is_solved:
        reason = "no mode was found at the peak, between two states of the backbone"
    elif curve.peak is None:
        reason = backbone.reason or (
            "the backbone ends below the peak"
            if curve.balance.damping_matrix.dissipates
            else _UNLIMITED
        )
    else:
        reason = "the backbone begins above the response at an end of the window"
    peak = None if curve.peak is None else curve.insert_peak(points, curve.peak)
    return SynthesisedResponse(
        frequency=np.sqrt([point.squared for point in points]) / (2 * np.pi),
        modal_coordinate=curve.motions(points),
        peak=peak,
        complete=not reason,
        reason=reason,
        has_isolated=curve.has_isolated,
    )


@dataclass(frozen=True, eq=False)
class _Point:
    """A state of the mode at the square of a frequency [rad2/s2] below or above resonance."""

    state: ModalState
    side: int
    squared: float


def _phase(point: _Point, peak: ModalState) -> float:
    """Phase from the peak [rad], negative below resonance."""
    ratio = np.exp(point.state.log_amplitude - peak.log_amplitude)
    return point.side * float(np.arccos(min(ratio, 1.0)))


class _ResponseCurve:
    """The response to one force, from below resonance over the peak to above it."""

    def __init__(self, backbone: Backbone, force: float) -> None:
        self.balance = backbone.equations.balance
        self.excitation = self.balance.joint.excitation.modes * force
        self.backbone = backbone = self._with_unreached(backbone)
        #: states whose amplitude the force exceeds, and at last that of the peak
        self.states = list(backbone.states)
        #: index of the first state whose amplitude the force does not reach
        self.unreached = next(
            (i for i, state in enumerate(backbone.states) if self._excess(state) <= 0), None
        )
        beyond = backbone.states[self.unreached :] if self.unreached is not None else ()
        #: whether it exceeds those of further ones beyond
        self.has_isolated = any(self._excess(state) > 0 for state in beyond)
        self.peak: ModalState | None = None
        #: whether the mode could be solved where the force balances the damping
        self.is_solved = True
        if self.unreached:
            below, above = backbone.states[self.unreached - 1 : self.unreached + 1]
            peak = backbone.solve_root(self._excess, below, above, above.least_distance)
            self.is_solved = abs(self._excess(peak)) <= _LARGEST_EXCESS * peak.least_distance
            self.peak = peak if self.is_solved else None
            self.states[self.unreached :] = [peak] if self.is_solved else []

    def _with_unreached(self, backbone: Backbone) -> Backbone:
        """The backbone with the first mode between states that the force exceeds and it does not.

        The force at peaks over the amplitude has a maximum there, where the response ends and an
        isolated branch lies above it: states further apart than both would not tell.
        """
        excess = [self._excess(state) for state in backbone.states]
        for after, (first, second) in enumerate(pairwise(backbone.states), start=1):
            beside = (first, excess[after - 1]), (second, excess[after])
            if any(value <= 0 for _, value in beside):
                break
            if any(value <= _SMALL_EXCESS * state.least_distance for state, value in beside):
                between = BetweenStates(first, second, backbone.control)
                least = solve_minimum(self._excess, between)
                if least is not None and self._excess(least) <= 0:
                    states = *backbone.states[:after], least, *backbone.states[after:]
                    return replace(backbone, states=states)
        return backbone

    def points(self) -> list[_Point]:
        """Points of the response: at states of the backbone, and more near the peak."""
        if self.peak is None:
            return [self._point(state, -1) for state in self.states]
        states = []
        inserted = self._near_peak()
        for place, state in enumerate(self.states[:-1]):
            states += [state, *inserted.get(place, ())]
        below = [self._point(state, -1) for state in states]
        above = [self._point(point.state, 1) for point in reversed(below)]
        return [*below, self._point(self.peak, 0), *above]

    def _near_peak(self) -> dict[int, list[ModalState]]:
        """States at phases from the peak, by the known one that they follow, which are apart."""
        states: dict[int, list[ModalState]] = {}
        p = np.array([state.log_amplitude for state in self.states])
        phases = np.arccos(np.minimum(np.exp(p - p[-1]), 1.0))
        spacings = np.diff(_PHASES, prepend=0.0)
        for phase, spacing in zip(_PHASES[::-1], spacings[::-1], strict=True):
            # the last interval that holds the phase
            at = np.flatnonzero((phases[:-1] >= phase) & (phase >= phases[1:]))
            if at.size and phases[at[-1]] - phases[at[-1] + 1] > spacing:
                place = int(at[-1])
                share = (p[-1] + np.log(np.cos(phase)) - p[place]) / (p[place + 1] - p[place])
                first, second = self.states[place : place + 2]
                state = self.backbone.solve_between(first, second, share)
                if state is not None:
                    states.setdefault(place, []).append(state)
        return states

    def crossing(self, points: Sequence[_Point], end: float) -> tuple[int, _Point] | None:
        """First crossing of the square of a frequency, with the number of points before it."""
        for before, (point, after) in enumerate(pairwise(points), start=1):
            if point.squared <= end <= after.squared:
                side = point.side or after.side
                squared = {id(end_point.state): end_point.squared for end_point in (point, after)}

                def beyond(state: ModalState, side: int = side, squares: dict = squared) -> float:
                    return squares.get(id(state), self._point(state, side).squared) - end

                state = self.backbone.solve_root(beyond, point.state, after.state, end)
                return before, _Point(state, side, end)
        return None

    def insert_peak(self, points: list[_Point], peak: ModalState) -> int | None:
        """Index of the largest maximum of the output point, which is located and inserted.

        All maxima of the points that may be the largest are located: which of two nearly equal ones
        is higher may depend on where the points lie. None without a maximum between the first and
        the last point.
        """
        amplitude = self.output_amplitude(points)
        rises, falls = np.diff(amplitude[:-1]) >= 0, np.diff(amplitude[1:]) <= 0
        maxima = 1 + np.flatnonzero(rises & falls)
        if not maxima.size:
            return None
        near = maxima[amplitude[maxima] >= _NEARLY_HIGHEST * amplitude[maxima].max()]
        located = [self._locate(points, int(place), amplitude, peak) for place in near]
        best = int(np.argmax([value for _, value, _ in located]))
        place, (point, _, above) = int(near[best]), located[best]
        if point is None:
            return place
        points.insert(place + above, point)
        return place + above

    def _locate(
        self, points: list[_Point], place: int, amplitude: NDArray[np.float64], peak: ModalState
    ) -> tuple[_Point | None, float, bool]:
        """The maximum near a point that is the highest of three, and whether it lies above it.

        With its amplitude; None where the point itself is the maximum. Phases are counted from the
        peak of the mode.
        """
        own = float(amplitude[place]), False
        around = points[place - 1 : place + 2]
        phases = [_phase(point, peak) for point in around]
        if not own[0] > max(amplitude[place - 1], amplitude[place + 1]):
            return None, *own  # flat, to rounding

        # where the backbone turns back in amplitude, the phase does not tell its states apart
        ascending = phases[0] < phases[1] < phases[2]
        phases = phases if ascending else [-0.5, 0.0, 0.5]
        # the tolerance is relative to the variable, and so to the step if that is near 1
        step = phases[2] - phases[0]
        variables = [1 + (phase - phases[1]) / step for phase in phases]
        negatives = dict(zip(variables, -amplitude[place - 1 : place + 2], strict=True))
        solved: dict[float, _Point | None] = dict(zip(variables, around, strict=True))

        def point_at(variable: float) -> _Point | None:
            phase = phases[1] + step * (variable - 1)
            interval = int(phase >= phases[1])
            first, second = around[interval : interval + 2]
            if ascending:
                p, begin, end = (
                    peak.log_amplitude + float(np.log(np.cos(phase))),
                    first.state.log_amplitude,
                    second.state.log_amplitude,
                )
                share, side = (p - begin) / (end - begin), int(np.sign(phase))
            else:
                share = (phase - phases[interval]) / (phases[interval + 1] - phases[interval])
                side = first.side or second.side
            state = self.backbone.solve_between(first.state, second.state, share)
            return None if state is None else self._point(state, side)

        def negative_amplitude(variable: float) -> float:
            if variable not in negatives:
                point = solved[variable] = point_at(variable)
                negatives[variable] = 0.0 if point is None else -self.output_amplitude([point])[0]
            return negatives[variable]

        located = minimize_scalar(
            negative_amplitude, bracket=variables, method="brent", options={"xtol": _WIDTH}
        )
        # values tell a maximum only to the root of their rounding, their differences do better
        below, above = (negative_amplitude(located.x + side * _ASIDE) for side in (-1, 1))
        curvature = below - 2 * located.fun + above
        aside = _ASIDE / 2 * (below - above) / curvature if curvature > 0 else 0.0
        top = located.x + (aside if abs(aside) < _ASIDE else 0.0)
        # but not at a corner, where a contact changes its state
        if -negative_amplitude(top) < (1 - _EQUAL) * -located.fun:
            top = located.x
        value, point = -negative_amplitude(top), solved[top]
        return (None, *own) if point is None or value < own[0] else (point, value, top > 1)

    def output_amplitude(self, points: Sequence[_Point]) -> NDArray[np.float64]:
        """Amplitude of the output point at points of the response [m]."""
        return OutputPoint(self.balance).amplitudes(self.motions(points))

    def motions(self, points: Sequence[_Point]) -> NDArray[np.float64]:
        """Unknowns of the balance at points of the response, shape (points, unknowns)."""
        equations, modes = self.backbone.equations, len(self.balance.stiffness)
        if not points:
            return np.zeros((0, equations.start().size - 2))
        states = [point.state for point in points]
        squared = np.array([point.squared for point in points])
        mode = np.array([state.mode for state in states])
        length = np.sqrt(np.einsum("ij,ij->i", mode, mode))
        phi = mode / length[:, None]
        modal_force = phi @ self.excitation
        eigenvalue = np.array([p.state.under_excitation(p.squared)[0] for p in points])
        dynamic = np.array([state.contact_stiffness for state in states])
        frequency = np.sqrt(np.maximum(squared, 0.0))
        dynamic += np.array([self.balance.complex_stiffness(w) for w in frequency])
        dynamic -= squared[:, None, None] * np.eye(modes)
        right = self.excitation - phi * modal_force[:, None]
        residual_modes = np.linalg.solve(dynamic, right[:, :, None])[:, :, 0]
        share = modal_force / (eigenvalue - squared) - np.einsum("ij,ij->i", phi, residual_modes)
        q = residual_modes + phi * share[:, None]
        motions = np.array([state.modal_coordinate for state in states])
        for h, sin, cos in equations.components.harmonics:
            # further harmonics are those of the mode, at its phase in the response
            mode = motions[:, sin] + 1j * motions[:, cos]
            turned = q if h == 1 else mode * np.exp(1j * h * np.angle(share / length))[:, None]
            motions[:, sin], motions[:, cos] = turned.real, turned.imag
        return motions.reshape(len(points), -1)

    def _excess(self, state: ModalState) -> float:
        """Excitation beyond that which balances the damping, in terms of lambda."""
        return state.excited_distance(self.excitation) - state.least_distance

    def _point(self, state: ModalState, side: int) -> _Point:
        if side == 0:
            return _Point(state, side, state.squared_at_peak)
        return _Point(state, side, state.frequencies_under(self.excitation)[side > 0])
