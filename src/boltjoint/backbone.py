"""How do a joint's resonance and its damping change with amplitude? Modes at given amplitudes.

With one harmonic, the modes of the extended periodic motion concept (Krack, Comput. Struct. 154,
2015): the joint is held in a periodic motion without excitation by an artificial damping that
gives back what friction and structure take. Its frequency and its damping over amplitude are the
joint's backbone, from which the response to any force near the resonance is rebuilt.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import brentq

from boltjoint.balance import HarmonicBalance
from boltjoint.continuation import Solution, StepControl, newton, trace
from boltjoint.dataset import quantity
from boltjoint.joint import Joint

#: change of the logarithm of the amplitude that counts, in arc length, as much as doubling a mode
_SCALE = 3.0

#: longest step along a backbone [arc length]
_STEP = 0.1

#: phases from the peak [rad] at which a rebuilt response is given beside the states of the path
_PHASES = np.geomspace(0.01, 1.45, 24)


class ModeAtAmplitude:
    """The mode phi and its eigenvalue at an amplitude a, as equations that can be followed.

    With ``f(q)`` the contact's harmonic force under ``q = Im(a phi exp(iwt))`` and the bias
    ``a beta``, L, eta and the components as of ``HarmonicBalance``::

        (L (1 + i eta) - lambda) phi + f_1(a phi, a beta) / a = 0
        L beta + f_0(a phi, a beta) / a = 0
        phi^T phi = 1

    ``lambda = w^2 (1 + 2 i zeta)`` holds the frequency w and the damping ratio zeta. The unknown is
    that of the balance over a, then real and imaginary part of lambda over that of the stuck mode;
    the parameter is the logarithm of a.

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
    basis = None
    looks_ahead = False

    def __init__(self, joint: Joint, loss_factor: float, resonance: int = 1) -> None:
        self.balance = HarmonicBalance(joint, loss_factor, 0.0)
        self._modes = len(self.balance.stiffness)
        if self.balance.components[-2:] != ("sin", "cos") or len(self.balance.components) > 3:
            raise ValueError("a backbone needs a motion of one harmonic")
        if not 1 <= resonance <= self._modes:
            raise ValueError(f"resonance {resonance} of {self._modes} modes")
        squared, vectors = np.linalg.eigh(self.balance.stiffness + joint.stuck_stiffness())
        self.scale, self.stuck = squared[resonance - 1], vectors[:, resonance - 1]

    def start(self) -> NDArray[np.float64]:
        """The stuck mode and its eigenvalue, without damping."""
        mode = np.zeros((len(self.balance.components), self._modes))
        mode[-2] = self.stuck
        return np.append(mode.ravel(), [1.0, 0.0])

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residual and Jacobian at the amplitude exp(p)."""
        a, modes = np.exp(p), self._modes
        s, c = x[-2 - 2 * modes : -2].reshape(2, -1)
        real, imaginary = x[-2:]
        force, jacobian_of_force = self.balance.residual_and_jacobian(a * x[:-2], 0.0)
        residual = np.append(force / (a * self.scale), [s @ s - c @ c - 1, 2 * s @ c])
        jacobian = np.zeros((x.size, x.size))
        jacobian[:-2, :-2] = jacobian_of_force / self.scale

        sin, cos = slice(-2 - 2 * modes, -2 - modes), slice(-2 - modes, -2)
        residual[sin] -= real * s - imaginary * c
        residual[cos] -= real * c + imaginary * s
        unit = np.eye(modes)
        jacobian[sin, sin] -= real * unit
        jacobian[sin, cos] += imaginary * unit
        jacobian[cos, sin] -= imaginary * unit
        jacobian[cos, cos] -= real * unit
        jacobian[sin, -2:] = np.column_stack([-s, c])
        jacobian[cos, -2:] = np.column_stack([-c, -s])
        jacobian[-2, sin], jacobian[-2, cos] = 2 * s, -2 * c
        jacobian[-1, sin], jacobian[-1, cos] = 2 * c, 2 * s
        return residual, jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the amplitude."""
        force, jacobian = self.balance.residual_and_jacobian(np.exp(p) * x[:-2], 0.0)
        change = jacobian @ x[:-2] - force / np.exp(p)
        return np.append(change / self.scale, [0.0, 0.0])

    def renew(
        self,
        x: NDArray[np.float64],
        p: float,
        along: NDArray[np.float64],
        ahead: tuple[NDArray[np.float64], float],
    ) -> None:
        """The unknown keeps its meaning."""

    def to_fixed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """The unknown itself."""
        return x

    def amplitudes_for(
        self, forces: Sequence[float], window: tuple[float, float]
    ) -> tuple[float, float]:
        """Amplitudes between which the responses to some forces lie in a window [kg^1/2 m].

        From below what the smallest force can do to the stuck mode at the ends of the window [Hz]
        to above what structural damping alone would let the largest one do.
        """
        excitation = self.balance.joint.excitation_mode
        distance = max(abs(self.scale - (2 * np.pi * f) ** 2) for f in window)
        lowest = min(forces) * abs(self.stuck @ excitation) / distance
        losses = self.balance.loss_factor * np.min(np.diag(self.balance.stiffness))
        return 0.3 * lowest, 1.5 * max(forces) * np.linalg.norm(excitation) / losses


@dataclass(frozen=True)
class State:
    """The mode of a joint at one amplitude.

    ``amplitude`` a [kg^1/2 m]; ``mode`` phi, complex, shape (linear modes,); ``bias`` a beta, of
    the same shape, empty where the law has none; ``eigenvalue`` lambda [rad2/s2].
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


class Backbone:
    """The path of a mode over its amplitude, and the mode at any amplitude on it.

    Parameters
    ----------
    equations
        The mode that is followed.
    amplitudes
        Lowest and highest [kg^1/2 m].
    control
        Tolerance and step lengths.
    """

    def __init__(
        self,
        equations: ModeAtAmplitude,
        amplitudes: tuple[float, float],
        control: StepControl | None = None,
    ) -> None:
        self.equations = equations
        self._control = replace(control or StepControl(), largest_step=_STEP)
        low, high = np.log(amplitudes)
        path = trace(equations, equations.start(), (low, high), self._control, scale=_SCALE)
        self.complete, self.reason, self._solutions = path.complete, path.reason, path.solutions
        self.states = [self._state(solution) for solution in path.solutions]

    def between(self, index: int, amplitude: float) -> State:
        """The mode at an amplitude between those of a state on the path and the next."""
        first, second = self._solutions[index : index + 2]
        p = float(np.log(amplitude))
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

    ``frequency`` (solutions,) [Hz], rising; ``modal_coordinate`` (solutions, components * modes),
    as the unknown of ``HarmonicBalance``; ``peak``: index of the largest response, None if the
    backbone does not reach it; ``complete``: whether it covers the window, if not, ``reason``.
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

        |lambda - w^2| a = |phi^T e| F

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
    balance = backbone.equations.balance
    excitation = balance.joint.excitation_mode * force

    def excess(state: State) -> float:
        """How much more the force does than the damping needs, in terms of lambda."""
        return abs(state.mode @ excitation) / state.amplitude - state.eigenvalue.imag

    states = backbone.states
    beyond = next((i for i, state in enumerate(states) if excess(state) <= 0), None)
    found, peak, reason = states[:beyond], None, backbone.reason
    if beyond:
        within = [state.amplitude for state in states[beyond - 1 : beyond + 1]]
        at_peak = _root(lambda a: excess(backbone.between(beyond - 1, a)), within)
        peak = backbone.between(beyond - 1, at_peak)
        near = (_last_with(backbone, beyond, at_peak * np.cos(phase)) for phase in _PHASES)
        found = sorted([*found, *filter(None, near)], key=lambda state: state.amplitude)
    elif not reason:
        reason = "the backbone ends below the peak"

    ends = [(2 * np.pi * f) ** 2 for f in window]
    sides = []
    for sign, end in zip((-1.0, 1.0), ends, strict=True):

        def squared(state: State, sign: float = sign) -> float:
            """Of the frequency on this side of the resonance."""
            reach = abs(state.mode @ excitation) / state.amplitude
            way = np.sqrt(max(reach**2 - state.eigenvalue.imag**2, 0.0))
            return state.eigenvalue.real + sign * way

        side = [(state, squared(state)) for state in found]
        outside = [i for i, (_, at) in enumerate(side) if sign * (at - end) > 0]
        if outside and outside[-1] + 1 < len(side):
            within = [state.amplitude for state, _ in side[outside[-1] :][:2]]
            a = _root(lambda a, end=end: squared(_last_with(backbone, beyond, a)) - end, within)
            side = [(_last_with(backbone, beyond, a), end), *side[outside[-1] + 1 :]]
        elif not reason:
            reason = "the backbone begins above the response at an end of the window"
        sides.append(side)
    at_resonance = [(peak, peak.eigenvalue.real)] if peak else []
    both = [*sides[0], *at_resonance, *reversed(sides[1])]
    inside = [(state, at) for state, at in both if ends[0] <= at <= ends[1]]
    return Rebuilt(
        frequency=np.sqrt([at for _, at in inside]) / (2 * np.pi),
        modal_coordinate=np.array(
            [_motion(balance, state, at, excitation) for state, at in inside]
        ).reshape(len(inside), -1),
        peak=next((i for i, (state, _) in enumerate(inside) if state is peak), None),
        complete=not reason,
        reason=reason,
    )


def _root(function: Callable[[float], float], within: Sequence[float]) -> float:
    """Where a function of the amplitude vanishes, between two of them."""
    low, high = within
    return float(brentq(function, low, high, xtol=1e-12 * high))


def _last_with(backbone: Backbone, beyond: int, amplitude: float) -> State | None:
    """The state of an amplitude on the last stretch before some index that holds it."""
    for i in range(beyond - 1, -1, -1):
        if backbone.states[i].amplitude <= amplitude:
            return backbone.between(i, amplitude)
    return None


def _motion(
    balance: HarmonicBalance, state: State, squared: float, excitation: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unknown of the balance at the square of a frequency [rad2/s2]."""
    phi = state.mode
    share = phi @ excitation
    y = share / (state.eigenvalue - squared)
    own = state.amplitude * phi
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
    """
    equations = ModeAtAmplitude(joint, loss_factor, resonance)
    backbone = Backbone(equations, equations.amplitudes_for(forces, window), control)
    states = backbone.states
    amplitude = np.array([state.amplitude for state in states])
    mode = np.array([state.mode for state in states])
    needed = [
        state.amplitude * state.eigenvalue.imag / abs(state.mode @ joint.excitation_mode)
        for state in states
    ]
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
                "combination of the linear modes, phi^T phi = 1",
            ),
            "complete": quantity(
                (), np.int8(backbone.complete), "1", "1 where the path reached its last amplitude"
            ),
            "reason": quantity((), backbone.reason, "1", "why the path broke off"),
        },
        coords={"part": ["real", "imaginary"]},
        attrs={"loss_factor": loss_factor, "resonance": resonance},
    )
