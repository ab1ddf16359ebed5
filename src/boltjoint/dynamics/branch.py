"""Solution branches of the frequency response, with their peaks, folds and errors.

The errors of one-mode answers are judged by the full balance in all linear modes, which their own
equations do not contain. What is left of it, over the excitation, says whether it holds; it weighs
stiff modes as heavily as soft ones, so that it says little about the response. The first correction
of Newton's method in all modes does: it is the error of the response to first order.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dataset import quantity
from boltjoint.dynamics.folds import find_folds
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.friction import contact_states
from boltjoint.joint.model import Joint
from boltjoint.solvers.newton import solve

#: harmonic components that the result files begin with; further ones follow as they were solved for
_COMPONENTS = ("bias", "sin", "cos")

#: errors on the flanks, over the amplitude of the peak, that count as much as one at the peak:
#: there a small error of the frequency is a large one of the amplitude
_FLANKS = 10.0

_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Branch:
    """The response at one force level, in linear modal coordinates.

    ``amplitude`` [m] is that of the first harmonic at the observed point; ``modal_coordinate`` has
    the shape (solutions, components * modes); frequencies are in Hz; ``located`` marks local maxima
    that were solved for; ``in_all_modes`` solutions of the full equations, also where a branch in
    response-dependent modes needed them; ``fell_back`` tells that the branch is one in linear modes
    because the coordinates asked for were too far off.
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

    @property
    def peak(self) -> int | None:
        """Index of the largest maximum that was located; None if the branch shows none."""
        if not self.located.any():
            return None
        return int(np.argmax(np.where(self.located, self.amplitude, -1.0)))


class Observed:
    """Complex first-harmonic amplitude of the observed point [m] from modal coordinates.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    """

    def __init__(self, balance: HarmonicBalance) -> None:
        self._mode = balance.joint.response_mode
        self._sin, self._cos = (balance.components.index(name) for name in ("sin", "cos"))

    def __call__(self, q: NDArray[np.float64]) -> complex:
        """Complex amplitude, sine coefficient + i cosine coefficient [m]."""
        amplitude = q.reshape(-1, self._mode.size) @ self._mode
        return complex(amplitude[self._sin], amplitude[self._cos])

    def value(self, q: NDArray[np.float64]) -> float:
        """Amplitude [m]."""
        return abs(self(q))

    def slope(self, q: NDArray[np.float64], dq: NDArray[np.float64]) -> float:
        """Half the derivative of the square of the amplitude, of the same sign as its own."""
        return float((self(q).conjugate() * self(dq)).real)


def residual(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Norm of what is left of the balance at a solution over that of the excitation."""
    return float(np.linalg.norm(balance.residual(x, w)) / np.linalg.norm(balance.modal_force))


def error_estimate(balance: HarmonicBalance, x: NDArray[np.float64], w: float) -> float:
    """Relative error of the response amplitude, to first order in what is left of the balance.

    The change of the observed point's complex amplitude by one correction of Newton's method in all
    linear modes at the same frequency, over that amplitude; infinite where there is no correction.

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
    observe = Observed(balance)
    left, jacobian_at = balance.residual_and_jacobian(x, w)
    correction = solve(jacobian_at(), left)
    if correction is None:
        return np.inf
    return abs(observe(correction)) / max(abs(observe(x)), _TINY)


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

    def exceeds(self, largest_error: float) -> bool:
        """Whether the peak is off by more than this, or any solution by ten times as much of it."""
        return self.of_peak > largest_error or self.largest > _FLANKS * largest_error


def estimate_error(joint: Joint, branch: Branch, loss_factor: float) -> BranchError:
    """Errors of a branch by the full balance in all linear modes (``error_estimate``)."""
    balance = HarmonicBalance(joint, loss_factor, branch.force)
    at = zip(branch.modal_coordinate, 2 * np.pi * branch.frequency, strict=True)
    errors = np.array([error_estimate(balance, x, w) for x, w in at])
    if not errors.size:
        return BranchError(errors, np.nan, 0.0)
    moves = branch.amplitude > 0
    largest = np.max((errors * branch.amplitude)[moves], initial=0.0)
    if branch.peak is None:
        return BranchError(errors, np.nan, float(largest / max(branch.amplitude.max(), _TINY)))
    over_peak = largest / branch.amplitude[branch.peak]
    return BranchError(errors, float(errors[branch.peak]), float(over_peak))


def to_dataset(
    joint: Joint,
    branches: Sequence[Branch],
    loss_factor: float,
    errors: Sequence[BranchError] | None = None,
    largest_error: float = np.inf,
) -> xr.Dataset:
    """Branches of one joint over force levels as ``response.nc`` holds them.

    Parameters
    ----------
    joint
        The joint and its structure.
    branches
        One for each force level.
    loss_factor
        Structural damping eta [-].
    errors
        Of each branch; none where the branches are in linear modes.
    largest_error
        Estimated error of a peak beyond which a branch is marked as wrong.

    Raises
    ------
    ValueError
        If there is no branch, one is of another joint, there are not as many errors, or the loss
        factor is negative.
    """
    if not branches:
        raise ValueError("branches is empty: it must hold at least one branch")
    if errors is not None and len(errors) != len(branches):
        raise ValueError(f"errors has {len(errors)} entries, branches {len(branches)}")
    if errors is None:
        errors = [BranchError(np.zeros(branch.frequency.size), 0.0, 0.0) for branch in branches]
    solved = joint.law.components
    components = (*_COMPONENTS, *(name for name in solved if name not in _COMPONENTS))
    modes = joint.natural_frequency.size
    coordinates, states_at_peak, folds = [], [], []
    unbalanced, left = [], []
    for branch in branches:
        balance = HarmonicBalance(joint, loss_factor, branch.force)
        at = list(zip(branch.modal_coordinate, 2 * np.pi * branch.frequency, strict=True))
        unbalanced += [_energy_error(balance, x) for x, _ in at]
        left += [residual(balance, x, w) for x, w in at]
        folds.append(find_folds(branch.frequency, branch.complete))
        found = branch.modal_coordinate.reshape(-1, len(solved), modes)
        full = np.zeros((len(found), modes, len(components)))
        full[:, :, [components.index(name) for name in solved]] = found.transpose(0, 2, 1)
        coordinates.append(full)
        elements = joint.law.point_of_element.size
        at_peak = np.full(elements, contact_states.UNKNOWN, dtype=np.int8)
        if branch.peak is not None:
            motion = balance.motion(branch.modal_coordinate[branch.peak])
            at_peak = joint.law.contact_state(motion)
        states_at_peak.append(at_peak)

    def along(name: str) -> NDArray:
        return np.concatenate([getattr(branch, name) for branch in branches])

    def flags(name: str) -> NDArray[np.int8]:
        return along(name).astype(np.int8)

    def of_peak(name: str) -> list[float]:
        return [
            np.nan if branch.peak is None else getattr(branch, name)[branch.peak]
            for branch in branches
        ]

    force = [branch.force for branch in branches]
    count = [branch.frequency.size for branch in branches]
    excitation = np.repeat(force, count)
    return xr.Dataset(
        {
            "excitation_force": quantity("solution", excitation, "N", "excitation amplitude"),
            "frequency": quantity("solution", along("frequency"), "Hz", "excitation frequency"),
            "modal_coordinate": quantity(
                ("solution", "mode", "component"),
                np.concatenate(coordinates),
                "kg^1/2 m",
                "amplitude of the linear modes",
            ),
            "response_amplitude": quantity(
                "solution",
                along("amplitude"),
                "m",
                "first-harmonic amplitude of the observed point",
            ),
            "iterations": quantity("solution", along("iterations"), "1", "corrections"),
            "converged": quantity(
                "solution", flags("converged"), "1", "1 where the equations hold"
            ),
            "in_all_modes": quantity(
                "solution", flags("in_all_modes"), "1", "1 where all linear modes were solved for"
            ),
            "residual": quantity(
                "solution", left, "1", "residual of the balance in all linear modes over the force"
            ),
            "error_estimate": quantity(
                "solution",
                np.concatenate([error.of_solutions for error in errors]),
                "1",
                "relative change of the response amplitude by a correction in all linear modes",
            ),
            "on_sweep_up": quantity(
                "solution",
                np.concatenate([fold.on_sweep_up for fold in folds]).astype(np.int8),
                "1",
                "1 where a slow sweep up the frequency shows the solution",
            ),
            "on_sweep_down": quantity(
                "solution",
                np.concatenate([fold.on_sweep_down for fold in folds]).astype(np.int8),
                "1",
                "1 where a slow sweep down the frequency shows the solution",
            ),
            "energy_error": quantity(
                "solution",
                unbalanced,
                "1",
                "work of the excitation less structural loss and friction, over the larger side",
            ),
            "force_level": quantity("force", force, "N", "excitation amplitude"),
            "peak_frequency": quantity(
                "force", of_peak("frequency"), "Hz", "frequency of the largest maximum"
            ),
            "peak_amplitude": quantity(
                "force", of_peak("amplitude"), "m", "largest maximum of the response amplitude"
            ),
            "peak_error_estimate": quantity(
                "force", [error.of_peak for error in errors], "1", "error_estimate at the peak"
            ),
            "largest_error_estimate": quantity(
                "force",
                [error.largest for error in errors],
                "1",
                "largest estimated error of a solution over the amplitude of the peak",
            ),
            "turning_points": quantity(
                "force",
                np.array([fold.turning_points for fold in folds]),
                "1",
                "turning points of the branch in frequency",
            ),
            "folded_from": quantity(
                "force",
                [fold.frequency_range[0] for fold in folds],
                "Hz",
                "lowest frequency with several solutions",
            ),
            "folded_to": quantity(
                "force",
                [fold.frequency_range[1] for fold in folds],
                "Hz",
                "highest frequency with several solutions",
            ),
            "wrong": quantity(
                "force",
                np.array([error.exceeds(largest_error) for error in errors], dtype=np.int8),
                "1",
                "1 where estimated errors are larger than allowed",
            ),
            "fell_back": quantity(
                "force",
                np.array([branch.fell_back for branch in branches], dtype=np.int8),
                "1",
                "1 where linear modes took the place of the coordinates asked for",
            ),
            "complete": quantity(
                "force",
                np.array([branch.complete for branch in branches], dtype=np.int8),
                "1",
                "1 where the branch crosses the whole window",
            ),
            "reason": quantity(
                "force", [branch.reason for branch in branches], "1", "why a branch broke off"
            ),
            "contact_state": xr.Variable(
                ("force", "element"),
                np.array(states_at_peak),
                {
                    "units": "1",
                    "long_name": "contact state at the peak, -1 where the branch shows none",
                    "flag_values": np.arange(len(contact_states.MEANINGS), dtype=np.int8),
                    "flag_meanings": " ".join(m.replace(" ", "_") for m in contact_states.MEANINGS),
                },
            ),
        },
        coords={"component": list(components)},
        attrs={"loss_factor": loss_factor},
    )


def _energy_error(balance: HarmonicBalance, x: NDArray[np.float64]) -> float:
    driven, lost, rubbed = balance.works(x)
    return (driven - lost - rubbed) / max(abs(driven), abs(lost + rubbed))
