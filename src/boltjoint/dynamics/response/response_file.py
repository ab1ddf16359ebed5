"""Branches of a joint over force levels as ``response.nc`` holds them, and arranged by level."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.dataset import quantities, quantity
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.modal_contact import ModalContact
from boltjoint.dynamics.balance.periodic_motion import energy_error
from boltjoint.dynamics.response.branch import Branch, BranchError, ErrorLimits
from boltjoint.dynamics.response.folds import Folds, find_folds
from boltjoint.dynamics.response.stability import (
    StabilityOptions,
    find_stability,
    stability_variables,
)
from boltjoint.friction import contact_states
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint

#: a variable without its dimension: name, values, unit, meaning
_Row = tuple[str, ArrayLike, str, str]

#: harmonic components that the result files begin with; further ones follow in the law's order
_COMPONENTS = Components.up_to(1)


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
    residuals, energy_errors, stabilities = [], [], []
    for branch, fold, error in zip(branches, folds, errors, strict=True):
        balance = HarmonicBalance(joint.distinct, damping, branch.force)
        at = list(zip(branch.modal_coordinate, 2 * np.pi * branch.frequency, strict=True))
        residuals += [relative_residual(balance, x, w) for x, w in at]
        energy_errors += [energy_error(balance, x, w) for x, w in at]
        solutions = branch.frequency, branch.modal_coordinate
        holds = error.of_solutions <= limits.of_peak
        stabilities.append(find_stability(balance, *solutions, fold, stability, holds=holds))
    components, values = _modal_coordinates(joint, branches)
    dimensions = ("solution", "mode", "component")
    modal_coordinate = (dimensions, values, "kg^1/2 m", "amplitude of the linear modes")
    columns, unit = _Columns(branches), joint.excitation.unit
    of_solutions = _of_solutions(columns, unit, errors, folds, residuals, energy_errors)
    of_forces = _of_forces(columns, unit, errors, folds, limits)
    return xr.Dataset(
        _along("solution", of_solutions)
        | {"modal_coordinate": quantity(*modal_coordinate)}
        | _along("force", of_forces)
        | stability_variables(stabilities)
        | _along("fold", _of_folds(joint, branches, folds))
        | _of_sensors(joint, branches)
        | {
            "contact_state": xr.Variable(
                ("force", "element"), _states_at_peaks(joint, branches), contact_states.ATTRIBUTES
            ),
        },
        coords={"component": components, "sensor": list(joint.sensors.by_name)},
        attrs=as_damping(damping).attributes() | {"stability": stability.stored()},
    )


def _along(dimension: str, rows: Iterable[_Row]) -> dict[str, xr.Variable]:
    """Variables along a dimension."""
    return quantities(
        (name, dimension, values, unit, meaning) for name, values, unit, meaning in rows
    )


def relative_residual(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Norm of the residual of the balance over that of the excitation."""
    return float(np.linalg.norm(balance.residual(x, w)) / np.linalg.norm(balance.modal_force))


@dataclass(frozen=True)
class _Columns:
    """Attributes of all branches, one after another."""

    branches: Sequence[Branch]

    def by_branch(self, name: str) -> list:
        """An attribute of every branch."""
        return [getattr(branch, name) for branch in self.branches]

    def along(self, name: str) -> NDArray:
        """An attribute of all solutions."""
        return np.concatenate(self.by_branch(name))

    def at_peak(self, name: str) -> list[float]:
        """An attribute of the solution at every peak, not a number without one."""
        peaks = zip(self.by_branch(name), self.by_branch("peak"), strict=True)
        return [np.nan if peak is None else values[peak] for values, peak in peaks]

    def numbers(self, name: str) -> list[int]:
        """A number of every branch, -1 where it is not known."""
        return [-1 if value is None else value for value in self.by_branch(name)]


def _flags(values: ArrayLike) -> NDArray[np.int8]:
    return np.array(values).astype(np.int8)


def _of_solutions(
    columns: _Columns,
    unit: str,
    errors: Sequence[BranchError],
    folds: Sequence[Folds],
    residuals: list[float],
    energy_errors: list[float],
) -> tuple[_Row, ...]:
    """Variables by solution."""
    along = columns.along
    sizes = [frequency.size for frequency in columns.by_branch("frequency")]
    excitation = np.repeat(columns.by_branch("force"), sizes)
    error_estimate = np.concatenate([error.of_solutions for error in errors])
    on_sweep_up = np.concatenate([fold.on_sweep_up for fold in folds])
    on_sweep_down = np.concatenate([fold.on_sweep_down for fold in folds])
    in_all_modes = _flags(along("in_all_modes"))
    amplitude = along("amplitude")
    return (
        ("excitation_force", excitation, unit, "excitation amplitude"),
        ("frequency", along("frequency"), "Hz", "excitation frequency"),
        ("response_amplitude", amplitude, "m", "first-harmonic amplitude of the output point"),
        ("iterations", along("iterations"), "1", "corrector iterations"),
        ("converged", _flags(along("converged")), "1", "1 where the corrector converged"),
        (
            "in_all_modes",
            in_all_modes,
            "1",
            "1 where no response-dependent mode held or predicted it",
        ),
        ("residual", residuals, "1", "residual of the balance in all linear modes over the force"),
        ("error_estimate", error_estimate, "1", "estimated relative error of response_amplitude"),
        ("on_sweep_up", _flags(on_sweep_up), "1", "1 where a slow sweep up the frequency passes"),
        ("on_sweep_down", _flags(on_sweep_down), "1", "1 where a slow sweep down passes"),
        ("energy_error", energy_errors, "1", "input less dissipation, over the larger of both"),
    )


def _of_forces(
    columns: _Columns,
    unit: str,
    errors: Sequence[BranchError],
    folds: Sequence[Folds],
    limits: ErrorLimits,
) -> tuple[_Row, ...]:
    """Variables by force level."""
    at_peak, by_branch = columns.at_peak, columns.by_branch
    folded_from, folded_to = zip(*(fold.frequency_range for fold in folds), strict=True)
    turning_points = np.array([fold.turning_points for fold in folds])
    peak_error, largest = zip(*((error.of_peak, error.largest) for error in errors), strict=True)
    wrong = _flags([error.exceeds(limits) for error in errors])
    isolated = np.array(columns.numbers("has_isolated"), dtype=np.int8)
    larger = columns.numbers("larger_resonance")
    fell_back, complete = _flags(by_branch("fell_back")), _flags(by_branch("complete"))
    return (
        ("force_level", by_branch("force"), unit, "excitation amplitude"),
        ("peak_frequency", at_peak("frequency"), "Hz", "frequency of the largest maximum"),
        ("peak_amplitude", at_peak("amplitude"), "m", "largest maximum of response_amplitude"),
        ("peak_error_estimate", list(peak_error), "1", "error_estimate at the peak"),
        ("largest_error_estimate", list(largest), "1", "largest error over the peak amplitude"),
        ("turning_points", turning_points, "1", "turning points of the branch in frequency"),
        ("folded_from", list(folded_from), "Hz", "lowest frequency with several solutions"),
        ("folded_to", list(folded_to), "Hz", "highest frequency with several solutions"),
        ("isolated_branch", isolated, "1", "1 with an isolated branch, 0 without, -1 if not known"),
        ("larger_resonance", larger, "1", "resonance of a larger peak, 0 none, -1 if not known"),
        ("wrong", wrong, "1", "1 where estimated errors are larger than allowed"),
        ("fell_back", fell_back, "1", "1 where solved in linear modes instead"),
        ("complete", complete, "1", "1 where the branch crosses the whole window"),
        ("reason", by_branch("reason"), "1", "why the branch ends before, or has no peak"),
    )


def _states_at_peaks(joint: Joint, branches: Sequence[Branch]) -> NDArray[np.int8]:
    """Contact states at every peak, unknown without one, shape (forces, elements)."""
    contact, states_at_peak = ModalContact(joint.contact), []
    for branch in branches:
        states = np.full(joint.law.point_of_element.size, contact_states.UNKNOWN, dtype=np.int8)
        if branch.peak is not None:
            motion = contact.motion(branch.modal_coordinate[branch.peak])
            states = joint.law.contact_state(motion, branch.peak_frequency)
        states_at_peak.append(states)
    return np.array(states_at_peak)


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
    of_solutions, of_forces = ("solution", "sensor"), ("force", "sensor")
    rows = (
        ("sensor_amplitude", of_solutions, along, "m", "amplitude of the sensor"),
        ("sensor_peak_amplitude", of_forces, peaks, "m", "largest amplitude of the solutions"),
        ("sensor_peak_frequency", of_forces, at_peak, "Hz", "frequency of the largest amplitude"),
    )
    return quantities(rows)


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


#: of the solutions that are arranged, as far as the response has them
_OF_SOLUTIONS = ("frequency", "response_amplitude", "stable", "error_estimate")


def by_force(response: xr.Dataset, joint: Joint | None = None) -> xr.Dataset:
    """The solutions of a response by excitation level, along each branch.

    Parameters
    ----------
    response
        As ``solve_response`` returns it, or ``response.nc``.
    joint
        The joint that was solved: with it, the motion of its sensors is told too.

    Returns
    -------
    Dataset
        ``force`` [N or m/s^2] is a coordinate. The variables of the levels are as before. Those of
        the solutions have the dimensions (force, point): branches that are shorter than the
        longest end with not a number, and so do solutions that did not converge. With a joint,
        ``complex_amplitude`` [m] (force, point, sensor) is the first harmonic of each sensor, sine
        coefficient + i cosine coefficient: its angle is the phase by which the motion leads the
        sine of the excitation.

    Raises
    ------
    ValueError
        If the response is no dataset of one, or of another joint.
    """
    checks.instance("response", response, xr.Dataset)
    levels = checks.variable("response", response, "force_level", ("force",))
    of_solution = checks.variable("response", response, "excitation_force", ("solution",))
    solved = checks.variable("response", response, "converged", ("solution",)) == 1
    places = [np.flatnonzero((of_solution == level) & solved) for level in levels]
    longest = max((place.size for place in places), default=0)
    arranged: dict[Hashable, xr.Variable | xr.DataArray] = {
        name: response[name] for name in response if "solution" not in response[name].dims
    }

    def along(values: np.ndarray) -> np.ndarray:
        rows = np.full((levels.size, longest, *values.shape[1:]), np.nan, values.dtype)
        for row, place in zip(rows, places, strict=True):
            row[: place.size] = values[place]
        return rows

    for name in _OF_SOLUTIONS:
        if name in response:
            values = checks.variable("response", response, name, ("solution",), finite=False)
            arranged[name] = xr.Variable(("force", "point"), along(values), response[name].attrs)
    if joint is not None:
        checks.instance("joint", joint, Joint)
        dimensions = ("solution", "component", "mode")
        checks.variable("response", response, "modal_coordinate", dimensions)
        q = response["modal_coordinate"].transpose(*dimensions)
        modes = np.array(list(joint.sensors.by_name.values()))
        if q.sizes["mode"] != modes.shape[1]:
            raise ValueError(
                f"the response has {q.sizes['mode']} modes, the joint {modes.shape[1]}"
            )
        missing = {"sin", "cos"} - set(q["component"].to_numpy().tolist())
        if missing:
            raise ValueError(f"the response has no component {min(missing)!r}")
        sine, cosine = (q.sel(component=part).to_numpy() @ modes.T for part in ("sin", "cos"))
        meaning = "first harmonic of the sensor, sine + i cosine coefficient"
        dims = ("force", "point", "sensor")
        arranged["complex_amplitude"] = quantity(dims, along(sine + 1j * cosine), "m", meaning)
    whole = xr.Dataset(arranged, attrs=response.attrs)
    unit = {"units": response["force_level"].attrs.get("units", "1")}
    whole = whole.assign_coords(force=xr.Variable("force", levels, unit))
    return whole if joint is None else whole.assign_coords(sensor=list(joint.sensors.by_name))


Array = NDArray[np.float64]
