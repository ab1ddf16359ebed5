"""Solution branches of the frequency response, with their peaks, folds and error estimates.

Branches in RDNM or from modal synthesis are judged by the harmonic balance in all linear modes.
Its residual over the excitation tells whether it holds, but weighs stiff modes as heavily as soft
ones. The first Newton correction in all linear modes is the error of the response to first order.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.dynamics.balance.modal_contact import ModalContact
from boltjoint.dynamics.balance.periodic_motion import energy_error
from boltjoint.dynamics.response.folds import Folds, find_folds
from boltjoint.dynamics.response.stability import (
    StabilityOptions,
    find_stability,
    stability_variables,
)
from boltjoint.friction import contact_states
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint
from boltjoint.options import Options
from boltjoint.solvers.newton import solve

#: harmonic components that the result files begin with; further ones follow in the law's order
_COMPONENTS = Components.up_to(1)

_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Branch:
    """The response at one force level, in linear modal coordinates.

    ``amplitude`` [m] is that of the first harmonic at the output point; ``modal_coordinate`` has
    the shape (solutions, components * modes); frequencies are in Hz; ``located`` marks located
    local maxima; ``in_all_modes`` marks solutions of the balance in all linear modes, also where a
    branch in response-dependent modes needed them; ``reason`` says why the branch ends before the
    window does, or has no peak; ``fell_back`` tells that the branch is one in
    linear modes because that in the given coordinates was too inaccurate; ``has_isolated`` whether
    there is an isolated branch beside it, ``larger_resonance`` which other resonance has a larger
    peak in the window, 0 where none has; each is None where that is not known.
    """

    force: float
    frequency: NDArray[np.float64]
    modal_coordinate: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    iterations: NDArray[np.int64]
    converged: NDArray[np.bool_]
    located: NDArray[np.bool_]
    in_all_modes: NDArray[np.bool_]
    complete: bool
    reason: str
    fell_back: bool = False
    has_isolated: bool | None = None
    larger_resonance: int | None = None

    def __post_init__(self) -> None:
        """Say why a complete branch has no peak."""
        located = checks.flags("located", self.located, ("solutions",))
        complete = checks.flag("complete", self.complete)
        checks.instance("reason", self.reason, str)
        if complete and not self.reason and not located.any():
            object.__setattr__(self, "reason", "no peak in the window")

    def __repr__(self) -> str:
        """The branch in a line, without its arrays."""
        peak = self.reason or "no peak"
        if self.peak is not None:
            peak = f"peak {self.peak_amplitude:.4g} m at {self.peak_frequency:.4f} Hz"
        whole = "complete" if self.complete else f"not complete: {self.reason}"
        count = self.frequency.size
        return f"<Branch of {count} solutions at a force of {self.force:g}: {peak}, {whole}>"

    @property
    def peak(self) -> int | None:
        """Index of the largest located maximum; None if there is none."""
        if not self.located.any():
            return None
        return int(np.argmax(np.where(self.located, self.amplitude, -1.0)))

    @property
    def peak_frequency(self) -> float:
        """Frequency of the peak [Hz]; a ``ValueError`` without one."""
        return float(self.frequency[self._existing_peak])

    @property
    def peak_amplitude(self) -> float:
        """Amplitude of the peak [m]; a ``ValueError`` without one."""
        return float(self.amplitude[self._existing_peak])

    def to_dataset(self) -> xr.Dataset:
        """Amplitude [m] over ``frequency`` [Hz] along the branch, and where it converged."""
        of_branch = {
            "response_amplitude": quantity("frequency", self.amplitude, "m", "of the output point"),
            "converged": quantity("frequency", self.converged, "1", "whether it is a solution"),
        }
        frequency = quantity("frequency", self.frequency, "Hz", "excitation frequency")
        attributes = {"force": self.force, "complete": int(self.complete), "reason": self.reason}
        return xr.Dataset(of_branch, {"frequency": frequency}, attributes)

    def plot(self, **style: object) -> list:
        """Draw amplitude over frequency with matplotlib, into the current axes; its lines."""
        solved = self.to_dataset().isel(frequency=np.flatnonzero(self.converged))
        return solved["response_amplitude"].plot.line(yscale="log", **style)

    @property
    def _existing_peak(self) -> int:
        if self.peak is None:
            why = self.reason or "no local maximum inside the window"
            raise ValueError(f"the response to {self.force:g} N has no peak: {why}")
        return self.peak


def relative_residual(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Norm of the residual of the balance over that of the excitation."""
    return float(np.linalg.norm(balance.residual(x, w)) / np.linalg.norm(balance.modal_force))


def estimate_solution_error(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Relative error of the response amplitude to first order in the residual of the balance.

    The change of the output point's complex amplitude by one Newton correction in all linear modes
    at the same frequency, over that amplitude; infinite where the Jacobian is singular.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    x
        A solution in other coordinates, as amplitudes of the linear modes, shape (components *
        modes,).
    w
        Its frequency [rad/s].
    """
    output = OutputPoint(balance)
    residual, jacobian = balance.residual_and_jacobian(x, w)
    correction = solve(jacobian(), residual)
    if correction is None:
        return np.inf
    return abs(output(correction)) / max(abs(output(x)), _TINY)


@dataclass(frozen=True)
class ErrorLimits(Options):
    """Estimated errors beyond which a branch in other coordinates than ``linear`` is wrong.

    No result depends on them but the flag ``wrong`` and, where asked for, the fallback.

    Parameters
    ----------
    of_peak
        Relative error of the amplitude of the peak: ``solver.largest_error`` of a study.
    on_flanks
        Errors elsewhere, over the amplitude of the peak, that are allowed for each error allowed at
        the peak: on a flank a small error of the frequency is a large one of the amplitude.
    """

    of_peak: float = 0.05
    on_flanks: float = 10.0


@dataclass(frozen=True)
class BranchError:
    """Estimated errors of a branch in other coordinates than all linear modes.

    ``of_solutions``: relative error of the amplitude of each solution, shape (solutions,);
    ``of_peak``: that of the peak, NaN without one; ``largest``: largest error of any solution over
    the amplitude of the peak, or without one over the largest amplitude.
    """

    of_solutions: NDArray[np.float64]
    of_peak: float
    largest: float

    def exceeds(self, limits: ErrorLimits) -> bool:
        """Whether the error of the peak, or that of any other solution, is beyond its limit."""
        return self.of_peak > limits.of_peak or self.largest > limits.on_flanks * limits.of_peak


def estimate_branch_error(joint: Joint, branch: Branch, damping: Damping | float) -> BranchError:
    """Errors of a branch by the balance in all linear modes (``estimate_solution_error``)."""
    balance = HarmonicBalance(joint.distinct, damping, branch.force)
    at = zip(branch.modal_coordinate, 2 * np.pi * branch.frequency, strict=True)
    errors = np.array([estimate_solution_error(balance, x, w) for x, w in at])
    if not errors.size:
        return BranchError(errors, np.nan, 0.0)
    nonzero = branch.amplitude > 0
    largest = np.max((errors * branch.amplitude)[nonzero], initial=0.0)
    if branch.peak is None:
        return BranchError(errors, np.nan, float(largest / max(branch.amplitude.max(), _TINY)))
    over_peak = largest / branch.amplitude[branch.peak]
    return BranchError(errors, float(errors[branch.peak]), float(over_peak))


def to_dataset(
    joint: Joint,
    branches: Sequence[Branch],
    damping: Damping | float,
    errors: Sequence[BranchError] | None = None,
    limits: ErrorLimits = ErrorLimits(),
    stability: StabilityOptions = StabilityOptions(),
) -> xr.Dataset:
    """Branches of one joint over force levels as ``response.nc`` holds them.

    Parameters
    ----------
    joint
        The joint and its structure.
    branches
        One for each force level.
    damping
        Damping of the structure; a number is a loss factor.
    errors
        Errors of each branch; None where the branches are in linear modes.
    limits
        Estimated errors beyond which a branch is marked as wrong.
    stability
        Where stability is found, and how.

    Raises
    ------
    ValueError
        If there is no branch, one is of another joint, there are not as many errors, or the
        damping is negative.
    """
    checks.instance("joint", joint, Joint)
    checks.sequence("branches", branches, Branch)
    checks.instance("limits", limits, ErrorLimits)
    checks.instance("stability", stability, StabilityOptions)
    if errors is not None:
        checks.sequence("errors", errors, BranchError)
    if not branches:
        raise ValueError("branches is empty: it must hold at least one branch")
    if errors is not None and len(errors) != len(branches):
        raise ValueError(f"errors has {len(errors)} entries, branches {len(branches)}")
    if errors is None:
        errors = [BranchError(np.zeros(branch.frequency.size), 0.0, 0.0) for branch in branches]
    folds = [find_folds(branch.frequency, branch.complete) for branch in branches]
    residuals, energy_errors, states_at_peak, stabilities = [], [], [], []
    contact = ModalContact(joint.contact)
    for branch, fold in zip(branches, folds, strict=True):
        balance = HarmonicBalance(joint.distinct, damping, branch.force)
        at = list(zip(branch.modal_coordinate, 2 * np.pi * branch.frequency, strict=True))
        residuals += [relative_residual(balance, x, w) for x, w in at]
        energy_errors += [energy_error(balance, x, w) for x, w in at]
        states = np.full(joint.law.point_of_element.size, contact_states.UNKNOWN, dtype=np.int8)
        if branch.peak is not None:
            motion = contact.motion(branch.modal_coordinate[branch.peak])
            states = joint.law.contact_state(motion, branch.peak_frequency)
        states_at_peak.append(states)
        solutions = branch.frequency, branch.modal_coordinate
        stabilities.append(find_stability(balance, *solutions, fold, stability))
    components, values = _modal_coordinates(joint, branches)
    dimensions = ("solution", "mode", "component")
    modal_coordinate = (dimensions, values, "kg^1/2 m", "amplitude of the linear modes")

    def by_branch(name: str) -> list:
        return [getattr(branch, name) for branch in branches]

    def along(name: str) -> NDArray:
        return np.concatenate(by_branch(name))

    def at_peak(name: str) -> list[float]:
        peaks = zip(by_branch(name), by_branch("peak"), strict=True)
        return [np.nan if peak is None else values[peak] for values, peak in peaks]

    def flags(values: NDArray | list) -> NDArray[np.int8]:
        return np.array(values).astype(np.int8)

    force = by_branch("force")
    excitation = np.repeat(force, [branch.frequency.size for branch in branches])
    amplitude = along("amplitude")
    error_estimate = np.concatenate([error.of_solutions for error in errors])
    on_sweep_up = np.concatenate([fold.on_sweep_up for fold in folds])
    on_sweep_down = np.concatenate([fold.on_sweep_down for fold in folds])
    folded_from, folded_to = zip(*(fold.frequency_range for fold in folds), strict=True)
    turning_points = np.array([fold.turning_points for fold in folds])
    peak_error, largest = zip(*((error.of_peak, error.largest) for error in errors), strict=True)
    wrong = [error.exceeds(limits) for error in errors]
    isolated = [-1 if value is None else value for value in by_branch("has_isolated")]
    isolated = np.array(isolated, dtype=np.int8)
    larger = [-1 if value is None else value for value in by_branch("larger_resonance")]
    of_solutions = (
        ("excitation_force", excitation, joint.excitation.unit, "excitation amplitude"),
        ("frequency", along("frequency"), "Hz", "excitation frequency"),
        ("response_amplitude", amplitude, "m", "first-harmonic amplitude of the output point"),
        ("iterations", along("iterations"), "1", "corrector iterations"),
        ("converged", flags(along("converged")), "1", "1 where the corrector converged"),
        ("in_all_modes", flags(along("in_all_modes")), "1", "1 where solved in all linear modes"),
        ("residual", residuals, "1", "residual of the balance in all linear modes over the force"),
        ("error_estimate", error_estimate, "1", "estimated relative error of response_amplitude"),
        ("on_sweep_up", flags(on_sweep_up), "1", "1 where a slow sweep up the frequency passes"),
        ("on_sweep_down", flags(on_sweep_down), "1", "1 where a slow sweep down passes"),
        ("energy_error", energy_errors, "1", "input less dissipation, over the larger of both"),
    )
    of_forces = (
        ("force_level", force, joint.excitation.unit, "excitation amplitude"),
        ("peak_frequency", at_peak("frequency"), "Hz", "frequency of the largest maximum"),
        ("peak_amplitude", at_peak("amplitude"), "m", "largest maximum of response_amplitude"),
        ("peak_error_estimate", list(peak_error), "1", "error_estimate at the peak"),
        ("largest_error_estimate", list(largest), "1", "largest error over the peak amplitude"),
        ("turning_points", turning_points, "1", "turning points of the branch in frequency"),
        ("folded_from", list(folded_from), "Hz", "lowest frequency with several solutions"),
        ("folded_to", list(folded_to), "Hz", "highest frequency with several solutions"),
        ("isolated_branch", isolated, "1", "1 with an isolated branch, 0 without, -1 if not known"),
        ("larger_resonance", larger, "1", "resonance of a larger peak, 0 none, -1 if not known"),
        ("wrong", flags(wrong), "1", "1 where estimated errors are larger than allowed"),
        ("fell_back", flags(by_branch("fell_back")), "1", "1 where solved in linear modes instead"),
        (
            "complete",
            flags(by_branch("complete")),
            "1",
            "1 where the branch crosses the whole window",
        ),
        ("reason", by_branch("reason"), "1", "why the branch ends before, or has no peak"),
    )
    return xr.Dataset(
        {name: quantity("solution", *row) for name, *row in of_solutions}
        | {"modal_coordinate": quantity(*modal_coordinate)}
        | {name: quantity("force", *row) for name, *row in of_forces}
        | stability_variables(stabilities)
        | {name: quantity("fold", *row) for name, *row in _of_folds(joint, branches, folds)}
        | _of_sensors(joint, branches)
        | {
            "contact_state": xr.Variable(
                ("force", "element"), np.array(states_at_peak), contact_states.ATTRIBUTES
            ),
        },
        coords={"component": components, "sensor": list(joint.sensors.by_name)},
        attrs=as_damping(damping).attributes() | {"stability": stability.stored()},
    )


def _of_folds(
    joint: Joint, branches: Sequence[Branch], folds: Sequence[Folds]
) -> tuple[tuple[str, NDArray, str, str], ...]:
    """Excitation, frequency and amplitude at every turning point of all branches."""
    pairs = list(zip(branches, folds, strict=True))
    force = np.repeat([branch.force for branch in branches], [fold.at.size for fold in folds])
    frequency, amplitude = (
        np.concatenate([getattr(branch, name)[fold.at] for branch, fold in pairs])
        for name in ("frequency", "amplitude")
    )
    return (
        ("fold_force", force, joint.excitation.unit, "excitation whose branch turns"),
        ("fold_frequency", frequency, "Hz", "frequency of the solution at which it turns"),
        ("fold_amplitude", amplitude, "m", "response_amplitude of that solution"),
    )


def _of_sensors(joint: Joint, branches: Sequence[Branch]) -> dict[str, xr.Variable]:
    """Amplitudes of the sensors, and the largest of each at every force level."""
    mode = np.array(list(joint.sensors.by_name.values()))
    components = Components(joint.law.components)
    sin, cos = components.sin(), components.cos()
    amplitudes, peaks = [], np.full((len(branches), len(mode)), np.nan)
    at_peak = np.full_like(peaks, np.nan)
    for i, branch in enumerate(branches):
        q = branch.modal_coordinate.reshape(-1, len(components), mode.shape[1])
        amplitude = np.hypot(q[:, sin] @ mode.T, q[:, cos] @ mode.T)
        amplitudes.append(amplitude)
        if branch.peak is not None:
            highest = amplitude.argmax(axis=0)
            peaks[i], at_peak[i] = amplitude.max(axis=0), branch.frequency[highest]
    along = np.concatenate(amplitudes)
    rows = (
        ("sensor_amplitude", "solution", along, "m", "amplitude of the sensor"),
        ("sensor_peak_amplitude", "force", peaks, "m", "largest amplitude of the solutions"),
        ("sensor_peak_frequency", "force", at_peak, "Hz", "frequency of the largest amplitude"),
    )
    return {name: quantity((dim, "sensor"), *row) for name, dim, *row in rows}


def _modal_coordinates(
    joint: Joint, branches: Sequence[Branch]
) -> tuple[list[str], NDArray[np.float64]]:
    """Components of the result file, and modal coordinates, (solutions, modes, components)."""
    of_law, modes = joint.law.components, joint.natural_frequency.size
    components = [*_COMPONENTS, *(name for name in of_law if name not in _COMPONENTS)]
    shape = -1, len(of_law), modes
    x = np.concatenate([branch.modal_coordinate.reshape(shape) for branch in branches])
    coordinates = np.zeros((len(x), modes, len(components)))
    coordinates[:, :, [components.index(name) for name in of_law]] = x.transpose(0, 2, 1)
    return components, coordinates
