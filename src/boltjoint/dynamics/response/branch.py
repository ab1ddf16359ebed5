"""Solution branches of the frequency response, with their peaks, folds and error estimates.

Branches in RDNM or from modal synthesis are judged by the harmonic balance in all linear modes.
Its residual over the excitation tells whether it holds, but weighs stiff modes as heavily as soft
ones. The first Newton correction in all linear modes is the error of the response to first order.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.joint.model import Joint
from boltjoint.options import Options
from boltjoint.solvers.newton import solve

_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Branch:
    """The response at one force level, in linear modal coordinates.

    Parameters
    ----------
    force
        Amplitude of the excitation [N], or acceleration of the supports [m/s^2].
    frequency
        Of each solution along the branch [Hz], shape (solutions,).
    modal_coordinate
        In all linear modes [kg^1/2 m], shape (solutions, components * modes).
    amplitude
        Of the first harmonic at the output point [m], shape (solutions,).
    iterations
        Corrector iterations, shape (solutions,).
    converged
        Whether the corrector converged, shape (solutions,).
    located
        Marks located local maxima, shape (solutions,).
    in_all_modes
        Marks solutions that response-dependent modes do not hold and did not predict: all of a
        branch in linear modes; of one in complex modes, where these did not suffice, and ends and
        located peaks, which are solved without; shape (solutions,).
    complete
        Whether the branch reaches the end of the window, or that behind its peak where no more is
        wanted.
    reason
        Why the branch breaks off, or has no peak.
    fell_back
        Whether it is one in linear modes because that in the given coordinates was too inaccurate.
    has_isolated
        Whether there is an isolated branch beside it; None where that is not known.
    larger_resonance
        Number of another resonance with a larger peak in the window, 0 where none has; None where
        that is not known.
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
        """Refuse arrays that do not fit each other; say why a complete branch has no peak."""
        solutions = checks.array("frequency", self.frequency, ("solutions",)).shape
        checks.array("modal_coordinate", self.modal_coordinate, (*solutions, "components"))
        checks.array("amplitude", self.amplitude, solutions)
        checks.indices("iterations", self.iterations, solutions)
        for name in ("converged", "located", "in_all_modes"):
            checks.flags(name, getattr(self, name), solutions)
        complete = checks.flag("complete", self.complete)
        checks.instance("reason", self.reason, str)
        if complete and not self.reason and not self.located.any():
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

    def plot(self, **style: Any) -> list:  # noqa: ANN401
        """Draw amplitude over frequency with matplotlib, into the current axes; its lines."""
        solved = self.to_dataset().isel(frequency=np.flatnonzero(self.converged))
        return solved["response_amplitude"].plot.line(yscale="log", **style)

    @property
    def _existing_peak(self) -> int:
        if self.peak is None:
            why = self.reason or "no local maximum inside the window"
            raise ValueError(f"the response to {self.force:g} N has no peak: {why}")
        return self.peak


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
