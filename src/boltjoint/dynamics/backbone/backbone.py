"""Backbone: natural frequency, damping and shape of a nonlinear mode over its modal amplitude.

Modes at a sequence of amplitudes are found by arc-length continuation; the mode at any other
amplitude is solved from a cubic interpolation between two of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, as_damping, damping_of_attributes
from boltjoint.dataset import Quantity, quantities
from boltjoint.dynamics.backbone.between_states import BetweenStates, solve_root
from boltjoint.dynamics.backbone.compiled_epmc import epmc_system
from boltjoint.dynamics.backbone.epmc import EPMCEquations, ModalState
from boltjoint.dynamics.backbone.peak_force import find_isolated_branches, least_near
from boltjoint.dynamics.balance.periodic_motion import energy_per_period
from boltjoint.joint.model import Joint
from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.compiled_arc_length import follow
from boltjoint.solvers.compiled_steps import Limits
from boltjoint.solvers.equations import SolutionBranch
from boltjoint.solvers.step_control import StepControl

Array = NDArray[np.float64]

#: amplitudes at which a backbone is started, over the lowest asked for: the first that succeeds
_FIRST_AMPLITUDES = (1.0, 0.1, 0.01, 1e-3, 1e-5, 1e-7)

#: factor by which steps are shorter where a backbone reaches the end from none of these amplitudes
_SHORTER_STEPS = 4.0

#: states as close as this in the logarithm of the amplitude have none inserted between them: for
#: curves that jump, where no number of states would be enough; states of the default study never
#: come so close
_CLOSEST = 0.05

#: largest residual of a state over the damping of the structure, where that is stricter: for loss
#: factors below those of any structure, so that states of the default study do not depend on it
_OF_DAMPING = 1e-4


@dataclass(frozen=True)
class Backbone:
    """States of a nonlinear mode in the order of the continuation, and the mode between them.

    Parameters
    ----------
    equations
        Equations of the nonlinear mode.
    states
        Solutions of the equations.
    control
        Tolerance of the equations.
    complete, reason
        Whether the last amplitude is reached; if not, why.
    """

    equations: EPMCEquations
    states: tuple[ModalState, ...]
    control: StepControl
    complete: bool
    reason: str

    def solve_between(
        self, first: ModalState, second: ModalState, share: float
    ) -> ModalState | None:
        """The mode at a share of the way between two states (``BetweenStates.state``)."""
        return BetweenStates(first, second, self.control).state(share)

    def solve_root(
        self,
        function: Callable[[ModalState], float],
        first: ModalState,
        second: ModalState,
        scale: float,
    ) -> ModalState:
        """The mode between two states at which a function is zero (``between_states``)."""
        return solve_root(function, BetweenStates(first, second, self.control), scale)

    def with_shorter_steps(self, factor: float) -> "Backbone":
        """The backbone between its first and last amplitude with steps shorter by a factor."""
        amplitudes = self.states[0].amplitude, max(state.amplitude for state in self.states)
        control = self.control.with_shorter_steps(factor)
        return trace_backbone(self.equations, amplitudes, control).refined()

    def refined(self) -> "Backbone":
        """The backbone with states where its curves bend (``StepControl.curve_tolerance``)."""
        curves = np.array([state.curves for state in self.states])
        limits = self.control.curve_tolerance * np.ptp(curves, axis=0)
        states = list(self.states[:1])
        ahead = list(self.states[:0:-1])
        while ahead:
            first, second = states[-1], ahead[-1]
            between = BetweenStates(first, second, self.control)
            middle = between.interpolation(0.5)
            bend = abs(middle.curves - (first.curves + second.curves) / 2)
            wide = abs(second.log_amplitude - first.log_amplitude) > _CLOSEST
            inserted = between.state(0.5) if wide and np.any(bend > limits) else None
            if inserted is None or not between.is_divided_by(inserted):
                states.append(ahead.pop())
            else:
                ahead.append(inserted)
        return replace(self, states=tuple(states))

    def _peak_force(self, state: ModalState) -> float:
        """Excitation whose response has its peak at a state."""
        excitation = self.equations.balance.joint.excitation.modes
        return float(state.least_distance / state.excited_distance(excitation))

    def _isolated_branches(self, force: NDArray[np.float64]) -> list[Quantity]:
        """Ranges of the excitation with isolated branches, by its values at the states."""
        joint, (appears, merges) = self.equations.balance.joint, find_isolated_branches(force)
        lowest, highest = (
            [least_near(function, self.states, place, self.control) for place in places]
            for function, places in (
                (self._peak_force, appears),
                (lambda state: -self._peak_force(state), merges),
            )
        )
        unit = joint.excitation.unit
        begin, end = (np.array([*map(self._peak_force, of)]) for of in (lowest, highest))
        at = np.array([one.amplitude * abs(one.mode @ joint.response_mode) for one in lowest])
        return [
            ("isolated_from", "isola", begin, unit, "lowest excitation with isolated branch"),
            ("isolated_to", "isola", end, unit, "highest excitation with that branch"),
            ("isolated_amplitude", "isola", at, "m", "response_amplitude where the branch appears"),
        ]

    def to_dataset(self) -> xr.Dataset:
        """The dataset of ``backbone.nc`` (``find_backbone``)."""
        joint, states = self.equations.balance.joint, self.states
        unit = joint.excitation.unit
        amplitude = np.array([state.amplitude for state in states])
        mode = np.array([state.mode for state in states]).reshape(-1, len(joint.response_mode))
        force = np.array([self._peak_force(state) for state in states])
        frequency = [state.frequency for state in states]
        damping = [state.damping_ratio for state in states]
        # of the forces of the contact, not the total less the structure's: exact where little slips
        balance = self.equations.balance
        friction = [
            energy_per_period(balance, state.amplitude * state.unknown[:-2], w)[2]
            for state, w in zip(states, 2 * np.pi * np.array(frequency), strict=True)
        ]
        response = amplitude * abs(mode @ joint.response_mode)
        shape = np.stack([mode.real, mode.imag], axis=-1)
        rows: list[Quantity] = [
            ("modal_amplitude", "state", amplitude, "kg^1/2 m", "modal amplitude"),
            ("response_amplitude", "state", response, "m", "amplitude of the output point"),
            ("natural_frequency", "state", frequency, "Hz", "natural frequency"),
            ("damping_ratio", "state", damping, "1", "modal damping ratio"),
            ("friction_dissipation", "state", friction, "J", "friction dissipation in a period"),
            ("peak_force", "state", force, unit, "excitation whose response has its peak here"),
            ("mode_shape", ("state", "mode", "part"), shape, "1", "in linear modes, phi^H phi = 1"),
            *self._isolated_branches(force),
            ("complete", (), np.int8(self.complete), "1", "1 where the last amplitude is reached"),
            ("reason", (), self.reason, "1", "why the backbone ends before"),
        ]
        components = self.equations.components
        motion = np.array([state.modal_coordinate for state in states])
        motion = motion.reshape(len(states), len(components), mode.shape[1])
        if components.has_bias:
            bias = motion[:, components.bias]
            meaning = "bias of the modal coordinates"
            rows.append(("bias", ("state", "mode"), bias, "kg^1/2 m", meaning))
        coords: dict[str, list[str]] = {"part": ["real", "imaginary"]}
        further = np.flatnonzero(components.number > 1)
        if further.size:
            coords["component"] = [components[i] for i in further]
            dims, meaning = ("state", "component", "mode"), "further harmonics of the motion"
            rows.append(("further_harmonics", dims, motion[:, further], "kg^1/2 m", meaning))
        return xr.Dataset(
            quantities(rows),
            coords=coords,
            attrs={
                **as_damping(self.equations.balance.damping).attributes(),
                "resonance": self.equations.resonance,
                "options": self.control.stored(),
            },
        )


def trace_backbone(
    equations: EPMCEquations,
    amplitudes: tuple[float, float],
    control: StepControl | None = None,
) -> Backbone:
    """Trace the backbone of a nonlinear mode over its modal amplitude.

    Parameters
    ----------
    equations
        Equations of the nonlinear mode.
    amplitudes
        Lowest and highest [kg^1/2 m]. Where the corrector does not converge from the stuck mode at
        the lowest, the backbone starts at a lower one.
    control
        Tolerance and step lengths.

    Raises
    ------
    ValueError
        If the amplitudes are no interval of positive numbers.
    """
    checks.instance("equations", equations, EPMCEquations)
    control = StepControl() if control is None else control
    checks.instance("control", control, StepControl)
    low, high = np.log(checks.interval("amplitudes", amplitudes))
    # the damping of a state tells whether a force exceeds it, however slight it is
    precise = control.stricter(_OF_DAMPING * equations.loss)
    branch = SolutionBranch()
    controls = precise, precise.with_shorter_steps(_SHORTER_STEPS)
    for steps, first in product(controls, np.log(_FIRST_AMPLITUDES)):
        # the stuck mode is an initial guess where little slips
        window = (low + first, high)
        attempt = _trace(equations, equations.start(), window, steps)
        if not attempt.solutions[0].converged:
            attempt = _trace(equations, equations.damped_start(), window, steps)
        if not branch.solutions or attempt.complete or len(branch.solutions) < 2:
            branch = attempt
        if branch.complete:
            break
    solutions = (solution for solution in branch.solutions if solution.converged)
    states = tuple(ModalState(equations, x, p) for x, p, *_ in solutions)
    return Backbone(equations, states, control, branch.complete, branch.reason)


def _trace(
    equations: EPMCEquations, start: Array, window: tuple[float, float], control: StepControl
) -> SolutionBranch:
    """Continuation from a stuck mode, in a compiled loop where that takes its regular course."""
    system = epmc_system(equations)
    if system is not None:
        limits = Limits.of(control, equations.residual_scale, control.amplitude_scale)
        path = follow(system, start, window, limits)
        if path.complete:
            return path.branch()
    return trace(equations, start, window, control, scale=control.amplitude_scale)


def trace_for_forces(
    joint: Joint,
    forces: Sequence[float],
    *,
    damping: Damping | float,
    window: tuple[float, float],
    resonance: int = 1,
    control: StepControl | None = None,
) -> Backbone:
    """The backbone that covers the responses to forces in a window, as for ``find_backbone``."""
    checks.instance("joint", joint, Joint)
    joint.check_excitation(resonance)
    equations = EPMCEquations(joint.distinct, damping, resonance)
    low, high = equations.amplitudes_for(forces, window)
    smallest = min(forces) * joint.excitation.modes
    for first in _FIRST_AMPLITUDES:
        backbone = trace_backbone(equations, (first * low, high), control)
        if not backbone.states:
            break
        lowest, highest = backbone.states[0].frequencies_under(smallest)
        if lowest <= (2 * np.pi * window[0]) ** 2 and highest >= (2 * np.pi * window[1]) ** 2:
            break
    return backbone.refined() if len(backbone.states) > 1 else backbone


def find_backbone(
    joint: Joint,
    forces: Sequence[float],
    *,
    damping: Damping | float,
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
    damping
        Damping of the structure; a number is a loss factor.
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
        ``natural_frequency`` [Hz], ``damping_ratio``, ``friction_dissipation`` in a period [J],
        ``peak_force`` [N] whose response has its peak at that state, ``mode_shape`` (state, mode,
        part), under variable load ``bias`` (state, mode) [kg^1/2 m], with several harmonics
        ``further_harmonics`` (state, component, mode) [kg^1/2 m]; ranges of excitation with an
        isolated branch (``IsolatedBranches``); ``complete`` and ``reason``.

    Raises
    ------
    ValueError
        If forces, damping or window are out of range, the structure has fewer modes, or the force
        does not excite the resonance.
    """
    traced = trace_for_forces(
        joint, forces, damping=damping, window=window, resonance=resonance, control=control
    )
    return traced.to_dataset()


def backbone_from_dataset(
    joint: Joint, stored: xr.Dataset, control: StepControl | None = None
) -> Backbone:
    """The backbone that a dataset of ``find_backbone`` describes.

    Parameters
    ----------
    joint
        The joint whose backbone it is.
    stored
        ``backbone.nc``.
    control
        Tolerance with which modes between the states are solved.

    Raises
    ------
    ValueError
        If the dataset does not describe a backbone of a joint with as many modes.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("stored", stored, xr.Dataset)
    control = StepControl() if control is None else control
    equations = EPMCEquations(
        joint.distinct, damping_of_attributes(stored.attrs), int(stored.attrs["resonance"])
    )
    of_state = {
        name: checks.variable("stored", stored, name, ("state",))
        for name in ("modal_amplitude", "natural_frequency", "damping_ratio")
    }
    amplitude, frequency, damping = of_state.values()
    shape = checks.variable("stored", stored, "mode_shape", ("state", "mode", "part"))
    parts = {"sin": shape[..., 0], "cos": shape[..., 1]}
    if equations.components.has_bias:
        bias = checks.variable("stored", stored, "bias", ("state", "mode"))
        parts["bias"] = bias / amplitude[:, None]
    if "further_harmonics" in stored:
        of_component = "state", "component", "mode"
        further = checks.variable("stored", stored, "further_harmonics", of_component)
        for i, name in enumerate(stored["component"].to_numpy()):
            parts[str(name)] = further[:, i] / amplitude[:, None]
    if set(parts) != set(equations.components):
        raise ValueError(
            f"stored has the components {', '.join(parts)}: "
            f"the joint has {', '.join(equations.components)}"
        )
    real = (2 * np.pi * frequency) ** 2 / equations.scale
    mode = [parts[name] for name in equations.components]
    unknown = np.column_stack([*mode, real, 2 * real * damping])
    if unknown.shape[1] != equations.start().size:
        raise ValueError(
            f"stored has {shape.shape[1]} modes, the joint {joint.natural_frequency.size}"
        )
    states = tuple(map(partial(ModalState, equations), unknown, np.log(amplitude)))
    complete, reason = bool(stored["complete"]), str(stored["reason"].item())
    return Backbone(equations, states, control, complete, reason)
