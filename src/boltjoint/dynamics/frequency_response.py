"""How does the assembly respond? Frequency responses over force levels, and their peaks."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.branch import Branch, BranchError, Observed, estimate_error, to_dataset
from boltjoint.dynamics.coordinates import check_options, pose
from boltjoint.dynamics.epmc import Backbone, EPMCEquations
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.linear_modes import Jacobian, LinearModes
from boltjoint.dynamics.load_stepping import LoadStepping
from boltjoint.dynamics.modal_synthesis import BEGINS_ABOVE, synthesise_response
from boltjoint.dynamics.rdnm import BasisUpdate, SelfConsistentRDNM
from boltjoint.joint.model import Joint
from boltjoint.names import Coordinates
from boltjoint.solvers import arc_length, lagged_basis
from boltjoint.solvers.equations import Path, StepControl
from boltjoint.solvers.lagged_basis import LaggedEquations
from boltjoint.solvers.newton import newton

logger = logging.getLogger(__name__)

Fallback = Literal["none", "linear"]

#: share of the window that counts, in arc length, as much as doubling the response
_WINDOW_SHARE = 1 / 15

#: ... but no more than this share of the frequency itself, however wide the window is
_LARGEST_SHARE = 0.1

#: where in the window a branch is sought that is not found from its ends
_INSIDE = (0.5, 0.25, 0.75)

#: shares of a force under which little slips, so that the corrector finds the solution
_LITTLE_FORCE = (1e-3, 1e-6, 1e-9)

#: amplitudes at which a backbone begins, over the one expected to be low enough, until it is
_LOWER_AMPLITUDES = (1.0, 0.1, 0.01, 1e-3)


def frequency_window(
    *joints: Joint, resonance: int = 1, given: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Frequencies to follow a resonance through: from 0.85 of the contact-free one to 1.05 stuck.

    Parameters
    ----------
    *joints
        One joint, or several on the same structure whose responses are to be compared: their
        windows together.
    resonance
        Which natural frequency, counted from 1.
    given
        A window [Hz] to take instead, if the resonance can lie in it.

    Returns
    -------
    tuple of float
        Lowest and highest frequency [Hz].

    Raises
    ------
    ValueError
        If there is no joint, the structure has fewer modes, or the resonance lies outside the
        window given, however much of the contact slips.
    """
    if not joints:
        raise ValueError("joints is empty: a window is that of at least one joint")
    if given is not None:
        given = checks.interval("given", given)
    lowest, highest = np.inf, 0.0
    for joint in joints:
        checks.instance("joint", joint, Joint)
        resonance = joint.check_resonance(resonance)
        stuck = np.diag((2 * np.pi * joint.natural_frequency) ** 2) + joint.stuck_stiffness()
        frequency = np.sqrt(np.linalg.eigvalsh(stuck)[resonance - 1]) / (2 * np.pi)
        highest = max(highest, float(frequency))
        lowest = min(lowest, float(np.sort(joint.natural_frequency)[resonance - 1]))
    if given is None:
        return 0.85 * lowest, 1.05 * highest
    if given[1] < lowest or given[0] > highest:
        raise ValueError(
            f"the window from {given[0]:g} to {given[1]:g} Hz contains no resonance {resonance}: "
            f"it lies between {lowest:.5g} Hz without contact and {highest:.5g} Hz stuck"
        )
    return given


def solve_branch(
    joint: Joint,
    force: float,
    *,
    loss_factor: float,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "within",
    quasi_static_correction: bool = True,
    control: StepControl | None = None,
    start: NDArray[np.float64] | None = None,
) -> Branch:
    """Frequency response of a joint at one force level, by harmonic balance and arc length.

    The path starts from the stuck linear solution at the lower end of the window, or, where that is
    too far from the solution, from one to which the force was raised. Local maxima of the response
    are located, not only sampled.

    Parameters
    ----------
    joint
        The joint and its structure.
    force
        Amplitude of the excitation [N].
    loss_factor
        Structural damping eta [-].
    window
        Lowest and highest frequency [Hz]; by default ``frequency_window`` of the resonance.
    coordinates
        As for ``coordinates.pose``; or ``backbone``, to rebuild the response from the joint's mode
        at given amplitudes.
    resonance
        Which resonance is followed, from 1: it sets the window and the mode ``rdnm-N`` must hold.
    jacobian
        ``analytic`` or ``forward-difference``.
    basis_update, quasi_static_correction
        Of response-dependent modes, as for ``coordinates.pose``.
    control
        Tolerance and step lengths.
    start
        A guess of the modal coordinates at the lower end of the window, shape (components *
        modes,), as ``Branch`` holds them, so that the window may lie close around a peak: steps are
        as long as in the default window, however narrow it is. Not for ``backbone``.

    Raises
    ------
    ValueError
        If a start is given for ``backbone``; if force, loss factor, window or start are out of
        range, the structure has fewer modes, or an option is not known; or if the force does not
        excite the resonance, or the observed point does not move.
    """
    checks.instance("joint", joint, Joint)
    force = checks.number("force", force, above=0)
    loss_factor = checks.number("loss_factor", loss_factor, at_least=0)
    Coordinates(coordinates)
    check_options(jacobian, basis_update, quasi_static_correction)
    control = StepControl() if control is None else control
    checks.instance("control", control, StepControl)
    joint.check_excitation(resonance)
    if window is None:
        window = frequency_window(joint, resonance=resonance)
    window = checks.interval("window", window)
    if start is not None:
        size = len(joint.law.components) * joint.natural_frequency.size
        start = checks.array("start", start, (size,))
    if coordinates == "backbone":
        if start is not None:
            raise ValueError("a response rebuilt from the backbone has no start")
        return _rebuilt(joint, force, loss_factor, window, resonance, control)
    balance = HarmonicBalance(joint, loss_factor, force)
    equations = pose(
        coordinates, balance, resonance, jacobian, basis_update, quasi_static_correction
    )
    observe = Observed(balance)
    whole = window if start is None else frequency_window(joint, resonance=resonance)
    branch = _Continuation(equations, balance, control, observe, whole)
    low, high = (2 * np.pi * f for f in window)
    found = _branch(force, branch.across((low, high), start), observe)
    if isinstance(equations, SelfConsistentRDNM):
        return replace(found, in_all_modes=np.zeros_like(found.in_all_modes))
    return found


def solve_response(
    joint: Joint,
    forces: Sequence[float],
    *,
    loss_factor: float,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "within",
    quasi_static_correction: bool = True,
    control: StepControl | None = None,
    largest_error: float = 0.05,
    fallback: Fallback = "none",
) -> xr.Dataset:
    """Frequency responses at several force levels, as the result files keep them.

    Parameters
    ----------
    joint, loss_factor, window, coordinates, resonance, jacobian, basis_update,
    quasi_static_correction, control
        As for ``solve_branch``.
    forces
        Amplitudes of the excitation [N].
    largest_error
        Estimated relative error of a peak beyond which a branch in other coordinates than
        ``linear`` is reported as wrong, by a warning; so is one that is off by ten times as much of
        the peak anywhere.
    fallback
        What takes their place then, and where the branch is not complete: ``none``, or ``linear``
        modes.

    Returns
    -------
    Dataset
        ``response.nc``: all solutions one after another, and by force level the peak (NaN where
        the branch shows none), whether the branch is complete, and the contact states at the peak.

    Raises
    ------
    ValueError
        As for ``solve_branch``.
    """
    forces = checks.numbers("forces", forces)
    largest_error = checks.number("largest_error", largest_error, above=0)
    checks.choice("fallback", fallback, get_args(Fallback))
    if window is None:
        window = frequency_window(joint, resonance=resonance)
    window = checks.interval("window", window)
    linear = {"loss_factor": loss_factor, "window": window, "resonance": resonance}
    linear |= {"jacobian": jacobian, "control": control}
    branches, errors = [], []
    for force in forces:
        branch = solve_branch(
            joint,
            force,
            coordinates=coordinates,
            basis_update=basis_update,
            quasi_static_correction=quasi_static_correction,
            **linear,
        )
        if coordinates != "linear":
            error = estimate_error(joint, branch, loss_factor)
            wrong = _warn_if_wrong(branch, error, largest_error)
            if fallback == "linear" and (wrong or not branch.complete):
                branch = replace(solve_branch(joint, force, **linear), fell_back=True)
                error = estimate_error(joint, branch, loss_factor)
            errors.append(error)
        branches.append(branch)
        logger.info(
            "%g N: %d solutions, %s, %s",
            force,
            branch.frequency.size,
            "no peak"
            if branch.peak is None
            else f"peak {branch.amplitude[branch.peak]:.4g} m "
            f"at {branch.frequency[branch.peak]:.2f} Hz",
            "complete" if branch.complete else branch.reason,
        )
    return to_dataset(joint, branches, loss_factor, errors or None, largest_error).assign_attrs(
        coordinates=coordinates,
        resonance=resonance,
        jacobian=jacobian,
        window_Hz=window,
        largest_error=largest_error,
        fallback=fallback,
    )


def _warn_if_wrong(branch: Branch, error: BranchError, largest_error: float) -> bool:
    """Whether the full balance in all linear modes says that a branch is too far off."""
    wrong = error.exceeds(largest_error)
    if wrong:
        of_peak = f"the peak is off by some {100 * error.of_peak:.2g} %, "
        logger.warning(
            "%g N: the balance in all linear modes does not hold: %sthe response by up to %.2g %% "
            "of its largest",
            branch.force,
            of_peak if branch.peak is not None else "",
            100 * error.largest,
        )
    return wrong


class _Continuation:
    """The response to one force over frequency, followed from wherever it leads across a window.

    Parameters
    ----------
    equations, balance
        In their coordinates, and the modal equations they stand for.
    control
        Tolerance and step lengths.
    observe
        What is observed.
    window
        Frequencies [Hz] that set the scale of steps.
    """

    def __init__(
        self,
        equations: LinearModes,
        balance: HarmonicBalance,
        control: StepControl,
        observe: Observed,
        window: tuple[float, float],
    ) -> None:
        self._equations, self._balance, self._control = equations, balance, control
        self._observe = observe
        self._longest = _WINDOW_SHARE * 2 * np.pi * (window[1] - window[0])
        self._lagged = isinstance(equations, LaggedEquations)

    def across(self, window: tuple[float, float], start: NDArray[np.float64] | None) -> Path:
        """From the lower end of a window [rad/s], or by another way where that does not lead on."""
        low, high = window
        path = self._follow((low, high), low, start)
        if path.complete or start is not None:
            return path
        for begin in (high, *(low + share * (high - low) for share in _INSIDE)):
            other = self._through(window, begin)
            if other.complete:
                return other
        return path

    def _through(self, window: tuple[float, float], begin: float) -> Path:
        """Both ways from a frequency in the window, put together."""
        low, high = window
        start = self._start(begin)
        down = self._follow((high, low), begin, start)
        if not down.complete:
            return down
        if begin == high:
            return Path(down.solutions[::-1], complete=True)
        up = self._follow((low, high), begin, start)
        return Path(down.solutions[:0:-1] + up.solutions, up.complete, up.reason)

    def _follow(
        self, window: tuple[float, float], begin: float, start: NDArray[np.float64] | None
    ) -> Path:
        if start is None:
            start = self._start(begin)
        trace = lagged_basis.trace if self._lagged else arc_length.trace
        return trace(
            self._equations,
            start,
            window,
            self._control,
            scale=self._scale,
            maximise=self._observe,
            begin=begin,
        )

    def _scale(self, w: float) -> float:
        return min(self._longest, _LARGEST_SHARE * w)

    def _start(self, w: float) -> NDArray[np.float64]:
        """An initial guess: the stuck linear solution, or what it becomes as the force grows."""
        stuck = self._balance.stuck_solution(w)
        if self._lagged and self._equations.full is None:
            return stuck  # a lagging basis cannot be followed far from the solution it belongs to
        equations = self._equations.full if self._lagged else self._equations
        if newton(equations, stuck, w, self._control)[0].converged:
            return stuck
        loading = LoadStepping(equations, w)
        for share in _LITTLE_FORCE:
            window = np.log(share), 0.0
            grown = arc_length.trace(loading, share * stuck, window, self._control, scale=1.0)
            if grown.complete:
                return grown.solutions[-1].x
        return stuck


def _rebuilt(
    joint: Joint,
    force: float,
    loss_factor: float,
    window: tuple[float, float],
    resonance: int,
    control: StepControl,
) -> Branch:
    mode = EPMCEquations(joint, loss_factor, resonance)
    low, high = mode.amplitudes_for([force], window)
    for lower in _LOWER_AMPLITUDES:
        found = synthesise_response(Backbone(mode, (lower * low, high), control), force, window)
        if found.reason != BEGINS_ABOVE:
            break
    count, observe = found.frequency.size, Observed(mode.balance)
    return Branch(
        force=force,
        frequency=found.frequency,
        modal_coordinate=found.modal_coordinate,
        amplitude=np.array([abs(observe(row)) for row in found.modal_coordinate]),
        iterations=np.zeros(count, dtype=np.int64),
        converged=np.ones(count, dtype=bool),
        located=np.arange(count) == (-1 if found.peak is None else found.peak),
        in_all_modes=np.zeros(count, dtype=bool),
        complete=found.complete,
        reason=found.reason,
    )


def _branch(force: float, path: Path, observe: Observed) -> Branch:
    x = np.array([solution.x for solution in path.solutions])
    return Branch(
        force=force,
        frequency=np.array([solution.p for solution in path.solutions]) / (2 * np.pi),
        modal_coordinate=x,
        amplitude=np.array([abs(observe(row)) for row in x]),
        iterations=np.array([solution.iterations for solution in path.solutions]),
        converged=np.array([solution.converged for solution in path.solutions]),
        located=np.array([solution.located for solution in path.solutions]),
        in_all_modes=np.array([solution.full for solution in path.solutions]),
        complete=path.complete,
        reason=path.reason,
    )
