"""Frequency responses of a joint over force levels, with their peaks.

Branches of the harmonic balance are followed by arc-length continuation, or synthesised from a
backbone.
"""

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, choose_damping
from boltjoint.dynamics.backbone.backbone import Backbone, backbone_from_dataset, trace_for_forces
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.linear_modes import Jacobian
from boltjoint.dynamics.balance.output_point import OutputPoint
from boltjoint.dynamics.response.branch import (
    Branch,
    BranchError,
    ErrorLimits,
    estimate_branch_error,
    to_dataset,
)
from boltjoint.dynamics.response.continuation import Continuation
from boltjoint.dynamics.response.coordinates import check_options, formulate_equations
from boltjoint.dynamics.response.other_resonances import OtherResonances
from boltjoint.dynamics.response.rdnm import BasisUpdate, SelfConsistentRDNM
from boltjoint.dynamics.response.stability import StabilityOptions
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.joint.model import Joint
from boltjoint.names import Coordinates
from boltjoint.solvers.equations import SolutionBranch, StepControl

logger = logging.getLogger(__name__)

Fallback = Literal["none", "linear"]


def solve_branch(
    joint: Joint,
    force: float,
    *,
    loss_factor: float | None = None,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "implicit",
    quasi_static_correction: bool = True,
    control: StepControl | None = None,
    start: NDArray[np.float64] | None = None,
    damping: Damping | None = None,
) -> Branch:
    """Frequency response of a joint at one force level, by arc-length continuation.

    The initial guess at the lower end of the window is the stuck linear solution, or, where the
    corrector does not converge from it, one found by load stepping. Local maxima of the response
    are located, not only sampled.

    Parameters
    ----------
    joint
        The joint and its structure.
    force
        Amplitude of the excitation [N].
    loss_factor
        Structural damping eta [-], in place of ``damping``.
    window
        Lowest and highest frequency [Hz]; by default ``frequency_window`` of the resonance.
    coordinates
        As for ``formulate_equations``; or ``backbone`` for nonlinear modal synthesis.
    resonance
        Number of the resonance, from 1: it sets the window and a mode that ``rdnm-N`` contains.
    jacobian
        ``analytic`` or ``forward-difference``.
    basis_update, quasi_static_correction
        Of response-dependent modes, as for ``formulate_equations``.
    control
        Tolerance and step lengths.
    start
        Initial guess of the modal coordinates at the lower end of the window, shape (components *
        modes,), as in ``Branch``. The step lengths are then those of the default window, so that
        the window may lie close around a peak. Not for ``backbone``.
    damping
        Of the structure, in place of ``loss_factor``.

    Raises
    ------
    ValueError
        If a start is given for ``backbone``; if force, damping, window or start are out of
        range, the structure has fewer modes, or an option is not known; or if the force does not
        excite the resonance, or the output point does not move.
    """
    checks.instance("joint", joint, Joint)
    force = checks.level("force", force)
    damping = choose_damping(loss_factor, damping)
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
            raise ValueError("a response synthesised from the backbone has no start")
        of_mode = {"damping": damping, "resonance": resonance, "control": control}
        known = trace_for_forces(joint, [force], window=window, **of_mode)
        others = OtherResonances(known, [force], window)
        return synthesise_branch(known, force, window, others)
    balance = HarmonicBalance(joint.distinct, damping, force)
    equations = formulate_equations(
        coordinates, balance, resonance, jacobian, basis_update, quasi_static_correction
    )
    output = OutputPoint(balance)
    whole = window if start is None else frequency_window(joint, resonance=resonance)
    continuation = Continuation(equations, balance, control, output, whole)
    low, high = (2 * np.pi * f for f in window)
    solved = _branch(force, continuation.across((low, high), start), output)
    if isinstance(equations, SelfConsistentRDNM):
        return replace(solved, in_all_modes=np.zeros_like(solved.in_all_modes))
    return solved


def solve_response(
    joint: Joint,
    forces: Sequence[float],
    *,
    loss_factor: float | None = None,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "implicit",
    quasi_static_correction: bool = True,
    control: StepControl | None = None,
    largest_error: float = ErrorLimits.of_peak,
    flank_error_ratio: float = ErrorLimits.on_flanks,
    fallback: Fallback = "none",
    backbone: xr.Dataset | None = None,
    damping: Damping | None = None,
    stability: StabilityOptions = StabilityOptions(),
) -> xr.Dataset:
    """Frequency responses at several force levels as the dataset of ``response.nc``.

    Parameters
    ----------
    joint, loss_factor, window, coordinates, resonance, jacobian, basis_update,
    quasi_static_correction, control, damping
        As for ``solve_branch``.
    forces
        Amplitudes of the excitation [N].
    largest_error, flank_error_ratio
        Estimated errors beyond which a warning reports a branch in other coordinates than
        ``linear`` as wrong (``ErrorLimits``).
    fallback
        ``linear`` solves such branches, and those that are not complete, again in linear modes;
        ``none`` keeps them.
    backbone
        Of ``find_backbone``, from which coordinates ``backbone`` synthesise all responses; by
        default it is traced once for all forces.
    stability
        Where the stability of solutions is found, and how.

    Returns
    -------
    Dataset
        All solutions one after another, and by force level the peak (NaN without one), whether the
        branch is complete, and the contact states at the peak; where branches fold, their turning
        points and the stability of the solutions there.

    Raises
    ------
    ValueError
        As for ``solve_branch``.
    """
    forces = checks.levels("forces", forces)
    limits = ErrorLimits(
        of_peak=checks.number("largest_error", largest_error, above=0),
        on_flanks=checks.number("flank_error_ratio", flank_error_ratio, above=0),
    )
    checks.choice("fallback", fallback, get_args(Fallback))
    if window is None:
        window = frequency_window(joint, resonance=resonance)
    window = checks.interval("window", window)
    damping = choose_damping(loss_factor, damping)
    linear = {"damping": damping, "window": window, "resonance": resonance}
    linear |= {"jacobian": jacobian, "control": control}
    update = {"basis_update": basis_update, "quasi_static_correction": quasi_static_correction}
    solve = branch_solver(
        joint, forces, coordinates=coordinates, backbone=backbone, **update, **linear
    )
    branches, errors = [], []
    for force in forces:
        branch = solve(force)
        if coordinates != "linear":
            error = estimate_branch_error(joint, branch, damping)
            wrong = _is_wrong(branch, error, limits)
            if fallback == "linear" and (wrong or not branch.complete):
                branch = replace(solve_branch(joint, force, **linear), fell_back=True)
                error = estimate_branch_error(joint, branch, damping)
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
    found = to_dataset(joint, branches, damping, errors or None, limits, stability)
    return found.assign_attrs(
        coordinates=coordinates,
        resonance=resonance,
        jacobian=jacobian,
        window_Hz=window,
        largest_error=largest_error,
        flank_error_ratio=flank_error_ratio,
        fallback=fallback,
        options=(control or StepControl()).stored(),
    )


def branch_solver(
    joint: Joint,
    forces: Sequence[float],
    *,
    loss_factor: float | None = None,
    window: tuple[float, float] | None = None,
    coordinates: str = "linear",
    resonance: int = 1,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "implicit",
    quasi_static_correction: bool = True,
    control: StepControl | None = None,
    backbone: xr.Dataset | None = None,
    damping: Damping | None = None,
) -> Callable[[float], Branch]:
    """Function that gives the frequency response at each of several force levels.

    What all of them have in common is done once: a backbone, unless it is given, is traced here.

    Parameters
    ----------
    joint, forces, loss_factor, window, coordinates, resonance, jacobian, basis_update,
    quasi_static_correction, control, backbone, damping
        As for ``solve_response``.

    Raises
    ------
    ValueError
        As for ``solve_branch``; with other coordinates than ``backbone`` only once it is called.
    """
    damping = choose_damping(loss_factor, damping)
    of_mode = {"damping": damping, "resonance": resonance, "control": control}
    if coordinates != "backbone":
        return partial(
            solve_branch,
            joint,
            window=window,
            coordinates=coordinates,
            jacobian=jacobian,
            basis_update=basis_update,
            quasi_static_correction=quasi_static_correction,
            **of_mode,
        )
    check_options(jacobian, basis_update, quasi_static_correction)
    if window is None:
        window = frequency_window(joint, resonance=resonance)
    if backbone is None:
        known = trace_for_forces(joint, forces, window=window, **of_mode)
    else:
        known = backbone_from_dataset(joint, backbone, control)
    others = OtherResonances(known, forces, window)
    return partial(synthesise_branch, known, window=window, others=others)


def _is_wrong(branch: Branch, error: BranchError, limits: ErrorLimits) -> bool:
    """Whether the estimated errors of a branch are larger than allowed; warns if so."""
    wrong = error.exceeds(limits)
    if wrong:
        at_peak = "" if branch.peak is None else f"{100 * error.of_peak:.2g} % at the peak, "
        logger.warning(
            "%g N: the balance in all linear modes does not hold: estimated errors of the response "
            "are %sup to %.2g %% of its largest",
            branch.force,
            at_peak,
            100 * error.largest,
        )
    return wrong


def synthesise_branch(
    backbone: Backbone,
    force: float,
    window: tuple[float, float],
    others: OtherResonances | None = None,
) -> Branch:
    """Frequency response at one force level by nonlinear modal synthesis.

    Parameters
    ----------
    backbone
        That covers the response (``trace_for_forces``).
    force, window
        As for ``solve_branch``.
    others
        Resonances among which a larger peak is sought; a warning tells of one.
    """
    response = synthesise_response(backbone, force, window)
    count, output = response.frequency.size, OutputPoint(backbone.equations.balance)
    branch = Branch(
        force=force,
        frequency=response.frequency,
        modal_coordinate=response.modal_coordinate,
        amplitude=output.amplitudes(response.modal_coordinate),
        iterations=np.zeros(count, dtype=np.int64),
        converged=np.ones(count, dtype=bool),
        located=np.arange(count) == (-1 if response.peak is None else response.peak),
        in_all_modes=np.zeros(count, dtype=bool),
        complete=response.complete,
        reason=response.reason,
        has_isolated=response.has_isolated,
    )
    if others is None or branch.peak is None:
        return branch
    larger = others.larger_than(branch)
    if larger:
        logger.warning("%g N: resonance %d has a larger peak in the window", force, larger)
    return replace(branch, larger_resonance=larger)


def _branch(force: float, path: SolutionBranch, output: OutputPoint) -> Branch:
    """Branch from the solutions of a continuation."""

    def each(name: str) -> NDArray:
        return np.array([getattr(solution, name) for solution in path.solutions])

    x = each("x")
    return Branch(
        force=force,
        frequency=each("p") / (2 * np.pi),
        modal_coordinate=x,
        amplitude=output.amplitudes(x),
        iterations=each("iterations"),
        converged=each("converged"),
        located=each("located"),
        in_all_modes=~each("reduced"),
        complete=path.complete,
        reason=path.reason,
    )
