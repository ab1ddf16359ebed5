"""Backbones by the extended periodic motion concept (EPMC), with one harmonic.

An artificial negative damping that balances friction and structural damping keeps the joint in a
periodic motion without excitation. The natural frequency and modal damping ratio of this nonlinear
mode over its modal amplitude are the backbone.

References
----------
M. Krack: Nonlinear modal analysis of nonconservative systems: extension of the periodic motion
concept. Computers and Structures 154 (2015) 59-71.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.joint.model import Joint
from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.equations import Equations, LazyJacobian, Solution, StepControl
from boltjoint.solvers.newton import newton

#: change of the logarithm of the amplitude that counts, in arc length, as much as doubling a mode
_SCALE = 3.0

#: longest step along a backbone [arc length]
_STEP = 0.1

#: amplitudes at which a backbone is started, over the lowest asked for
_FIRST_AMPLITUDES = (1.0, 0.1, 0.01, 1e-3, 1e-5, 1e-7)

#: loss factor below which amplitudes are not followed to where it alone limits the response
_LEAST_LOSS_FACTOR = 1e-5


class EPMCEquations(Equations):
    """Equations of the nonlinear mode phi and its eigenvalue lambda at a modal amplitude a.

    With ``f(q)`` the contact's harmonic force under ``q = Im(a phi exp(iwt))`` and the bias
    ``a beta``, L, eta and the components as of ``HarmonicBalance``::

        (L (1 + i eta) - lambda) phi + f_1(a phi, a beta) / a = 0
        L beta + f_0(a phi, a beta) / a = 0
        phi^H phi = 1

    ``lambda = w^2 (1 + 2 i zeta)`` holds the frequency w and the damping ratio zeta. The mode is
    normalised to unit modal mass with the conjugate (Krack 2015). Its phase is arbitrary and held
    to that of the last accepted solution. The unknown is that of the balance over a, then real and
    imaginary part of lambda over that of the stuck mode; the parameter is the logarithm of a.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    loss_factor
        eta [-].
    resonance
        Number of the stuck mode at which the backbone starts, from 1.

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
        self._reference = self.stuck, np.zeros(self._modes)

    def start(self) -> NDArray[np.float64]:
        """The stuck mode and its eigenvalue, without damping."""
        mode = np.zeros((len(self.balance.components), self._modes))
        mode[-2] = self.stuck
        return np.append(mode.ravel(), [1.0, 0.0])

    def evaluate(
        self, x: NDArray[np.float64], p: float
    ) -> tuple[NDArray[np.float64], LazyJacobian]:
        """Residual and Jacobian at the modal amplitude exp(p)."""
        a, modes = np.exp(p), self._modes
        s, c = x[-2 - 2 * modes : -2].reshape(2, -1)
        real, imaginary = x[-2:]
        force, force_jacobian = self.balance.residual_and_jacobian(a * x[:-2], 0.0)
        s_0, c_0 = self._reference
        residual = np.append(force / (a * self.scale), [s @ s + c @ c - 1, s_0 @ c - c_0 @ s])
        residual[-2 - 2 * modes : -2 - modes] -= real * s - imaginary * c
        residual[-2 - modes : -2] -= real * c + imaginary * s
        return residual, lambda: self._jacobian(x, force_jacobian())

    def _jacobian(
        self, x: NDArray[np.float64], force_jacobian: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The Jacobian from that of the balance without excitation and inertia."""
        modes = self._modes
        s, c = x[-2 - 2 * modes : -2].reshape(2, -1)
        real, imaginary = x[-2:]
        jacobian = np.zeros((x.size, x.size))
        jacobian[:-2, :-2] = force_jacobian / self.scale

        sin, cos = slice(-2 - 2 * modes, -2 - modes), slice(-2 - modes, -2)
        unit = np.eye(modes)
        jacobian[sin, sin] -= real * unit
        jacobian[sin, cos] += imaginary * unit
        jacobian[cos, sin] -= imaginary * unit
        jacobian[cos, cos] -= real * unit
        jacobian[sin, -2:] = np.column_stack([-s, c])
        jacobian[cos, -2:] = np.column_stack([-c, -s])
        jacobian[-2, sin], jacobian[-2, cos] = 2 * s, 2 * c
        jacobian[-1, cos], jacobian[-1, sin] = self._reference[0], -self._reference[1]
        return jacobian

    def parameter_derivative(self, x: NDArray[np.float64], p: float) -> NDArray[np.float64]:
        """Derivative of the residual by the logarithm of the modal amplitude."""
        a, mode = np.exp(p), x[:-2]
        force, change = self.balance.residual_and_change(a * mode, 0.0, mode)
        return np.append((change - force / a) / self.scale, [0.0, 0.0])

    def accept(self, x: NDArray[np.float64]) -> None:
        """Hold the phase of the mode to that of x from here on."""
        self._reference = tuple(x[-2 - 2 * self._modes : -2].reshape(2, -1))

    def state(self) -> tuple[NDArray[np.float64], ...]:
        """Sine and cosine part of the mode to whose phase the mode is held."""
        return self._reference

    def restore(self, state: tuple[NDArray[np.float64], ...]) -> None:
        """Hold the phase of the mode to that of an earlier one."""
        self._reference = state

    def amplitudes_for(
        self, forces: Sequence[float], window: tuple[float, float]
    ) -> tuple[float, float]:
        """Range of modal amplitudes of the responses to forces in a window [kg^1/2 m].

        From below that of the stuck mode under the smallest force at the ends of the window [Hz] to
        above that which structural damping alone allows under the largest force. In full slip
        nothing else limits the response: without structural damping, a loss factor of 1e-5 does.
        """
        forces, window = checks.numbers("forces", forces), checks.interval("window", window)
        excitation = self.balance.joint.excitation_mode
        distance = max(abs(self.scale - (2 * np.pi * f) ** 2) for f in window)
        lowest = min(forces) * abs(self.stuck @ excitation) / distance
        loss_factor = max(self.balance.loss_factor, _LEAST_LOSS_FACTOR)
        losses = loss_factor * np.min(np.diag(self.balance.stiffness))
        return 0.3 * lowest, 1.5 * max(forces) * np.linalg.norm(excitation) / losses


@dataclass(frozen=True)
class ModalState:
    """The nonlinear mode of a joint at one modal amplitude.

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
        """Modal damping ratio zeta [-]."""
        return self.eigenvalue.imag / (2 * self.eigenvalue.real)

    def excited_distance(self, excitation: NDArray[np.float64]) -> float:
        """Distance ``|lambda - w^2|`` at which an excitation causes the amplitude [rad2/s2]."""
        return abs(self.mode @ excitation / (self.mode @ self.mode)) / self.amplitude


class Backbone:
    """Backbone of a nonlinear mode, and the mode at any modal amplitude on it.

    Parameters
    ----------
    equations
        Of the nonlinear mode.
    amplitudes
        Lowest and highest [kg^1/2 m]. Where the corrector does not converge from the stuck mode at
        the lowest, the backbone starts at a lower one.
    control
        Tolerance and step lengths.
    """

    def __init__(
        self,
        equations: EPMCEquations,
        amplitudes: tuple[float, float],
        control: StepControl | None = None,
    ) -> None:
        checks.instance("equations", equations, EPMCEquations)
        control = StepControl() if control is None else control
        checks.instance("control", control, StepControl)
        self.equations = equations
        self._control = replace(control, largest_step=_STEP)
        low, high = np.log(checks.interval("amplitudes", amplitudes))
        path = None
        for first in np.log(_FIRST_AMPLITUDES):
            # the stuck mode is an initial guess where little slips
            equations.restore((equations.stuck, np.zeros_like(equations.stuck)))
            window = (low + first, high)
            found = trace(equations, equations.start(), window, self._control, scale=_SCALE)
            if path is None or found.complete or len(path.solutions) < 2:
                path = found
            if path.complete:
                break
        self._solutions = [solution for solution in path.solutions if solution.converged]
        self.complete, self.reason = path.complete, path.reason
        self.states = [self._state(solution) for solution in self._solutions]

    def solve_between(self, index: int, amplitude: float) -> ModalState:
        """The mode at an amplitude between those of a state and the next."""
        first, second = self._solutions[index : index + 2]
        p = float(np.log(amplitude))
        self.equations.accept(first.x)
        part = (p - first.p) / (second.p - first.p)
        guess = first.x + part * (second.x - first.x)
        return self._state(newton(self.equations, guess, p, self._control)[0])

    def _state(self, solution: Solution) -> ModalState:
        a, modes = np.exp(solution.p), len(self.equations.stuck)
        s, c = solution.x[-2 - 2 * modes : -2].reshape(2, -1)
        return ModalState(
            amplitude=float(a),
            mode=s + 1j * c,
            bias=a * solution.x[: -2 - 2 * modes],
            eigenvalue=complex(*solution.x[-2:]) * self.equations.scale,
        )


def find_backbone(
    joint: Joint,
    forces: Sequence[float],
    *,
    loss_factor: float,
    window: tuple[float, float],
    resonance: int = 1,
    control: StepControl | None = None,
) -> xr.Dataset:
    """Natural frequency and damping ratio of a joint over its modal amplitude (``backbone.nc``).

    Parameters
    ----------
    joint
        The joint and its structure.
    forces
        Amplitudes of the excitation [N] whose responses the backbone covers.
    loss_factor
        Structural damping eta [-].
    window
        Lowest and highest frequency of those responses [Hz].
    resonance
        Number of the mode, from 1.
    control
        Tolerance and step lengths.

    Returns
    -------
    Dataset
        By state: ``modal_amplitude`` [kg^1/2 m], ``response_amplitude`` of the output point [m],
        ``natural_frequency`` [Hz], ``damping_ratio``, ``peak_force`` [N] whose response has its
        peak at that state, ``mode_shape`` (state, mode, part); ``complete`` and ``reason``.

    Raises
    ------
    ValueError
        If forces, loss factor or window are out of range, the structure has fewer modes, the motion
        has further harmonics, or the force does not excite the resonance.
    """
    checks.instance("joint", joint, Joint)
    joint.check_excitation(resonance)
    equations = EPMCEquations(joint, loss_factor, resonance)
    backbone = Backbone(equations, equations.amplitudes_for(forces, window), control)
    states = backbone.states
    amplitude = np.array([state.amplitude for state in states])
    mode = np.array([state.mode for state in states]).reshape(-1, len(joint.response_mode))
    excitation = joint.excitation_mode
    force = [state.eigenvalue.imag / state.excited_distance(excitation) for state in states]
    frequency = [state.frequency for state in states]
    damping = [state.damping_ratio for state in states]
    response = amplitude * abs(mode @ joint.response_mode)
    shape = np.stack([mode.real, mode.imag], axis=-1)
    quantities = (
        ("modal_amplitude", "state", amplitude, "kg^1/2 m", "modal amplitude"),
        ("response_amplitude", "state", response, "m", "amplitude of the output point"),
        ("natural_frequency", "state", frequency, "Hz", "natural frequency"),
        ("damping_ratio", "state", damping, "1", "modal damping ratio"),
        ("peak_force", "state", force, "N", "excitation whose response has its peak here"),
        ("mode_shape", ("state", "mode", "part"), shape, "1", "in linear modes, phi^H phi = 1"),
        ("complete", (), np.int8(backbone.complete), "1", "1 where the last amplitude is reached"),
        ("reason", (), backbone.reason, "1", "why the backbone ends before"),
    )
    return xr.Dataset(
        {name: quantity(*row) for name, *row in quantities},
        coords={"part": ["real", "imaginary"]},
        attrs={"loss_factor": loss_factor, "resonance": resonance},
    )
