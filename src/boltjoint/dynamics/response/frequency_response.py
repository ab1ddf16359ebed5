"""Frequency responses of a joint over force levels, with their peaks.

Names of methods in files and the words of their options become methods here (``method_of``);
behind it nothing compares them.
"""

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, TypedDict, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping
from boltjoint.dynamics.balance.balance_equations import Jacobian
from boltjoint.dynamics.response.branch import (
    Branch,
    BranchError,
    ErrorLimits,
    estimate_branch_error,
)
from boltjoint.dynamics.response.methods import LinearModes, Method, Problem, ResponseDependentModes
from boltjoint.dynamics.response.response_file import to_dataset
from boltjoint.dynamics.response.synthesis import ModalSynthesis
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.joint.model import Joint
from boltjoint.names import Coordinates
from boltjoint.solvers.step_control import StepControl

logger = logging.getLogger(__name__)

BasisUpdate = Literal["implicit", "lagged"]
Fallback = Literal["none", "linear"]


def solve_branch(
    joint: Joint,
    force: float,
    method: Method | str = "linear",
    *,
    damping: Damping | float,
    resonance: Resonance | int = 1,
    control: StepControl | None = None,
    start: NDArray[np.float64] | None = None,
) -> Branch:
    """Frequency response of a joint at one force level.

    By arc-length continuation, or by modal synthesis. The initial guess at the lower end of the
    window is the stuck linear solution, or, where the corrector does not converge from it, one
    found by load stepping. Local maxima of the response are located, not only sampled.

    Parameters
    ----------
    joint
        The joint and its structure.
    force
        Amplitude of the excitation [N].
    method
        ``LinearModes``, ``ResponseDependentModes`` or ``ModalSynthesis`` with their options, or a
        name: ``linear``, ``rdnm-N``, ``complex-rdnm-N`` or ``backbone``.
    damping
        Damping of the structure; a number is a loss factor.
    resonance
        Number of the resonance, from 1, or a ``Resonance`` with a window: it sets the window, and a
        mode that response-dependent modes contain.
    control
        Tolerance and step lengths.
    start
        Initial guess of the modal coordinates at the lower end of the window, shape (components *
        modes,), as in ``Branch``. The step lengths are then those of the default window, so that
        the window may lie close around a peak. Not for modal synthesis.

    Returns
    -------
    Branch
        Its solutions and its peak; whether it is complete, and else why not.

    Raises
    ------
    ValueError
        If a start is given for modal synthesis; if force, damping, window or start are out of
        range, the structure has fewer modes, or the method is not known; or if the force does not
        excite the resonance, or the output point does not move.
    """
    checks.instance("joint", joint, Joint)
    force, method = checks.level("force", force), as_method(method)
    number = resonance.number if isinstance(resonance, Resonance) else resonance
    joint.check_excitation(number)
    problem = Problem.of(joint, damping, resonance, control)
    if start is not None:
        size = len(joint.law.components) * joint.natural_frequency.size
        start = checks.array("start", start, (size,))
    return method.solve(problem, force, start)


def solve_response(
    joint: Joint,
    forces: Sequence[float],
    method: Method | str = "linear",
    *,
    damping: Damping | float,
    resonance: Resonance | int = 1,
    control: StepControl | None = None,
) -> xr.Dataset:
    """Frequency responses at several force levels as the dataset of ``response.nc``.

    Parameters
    ----------
    joint
        The joint and its structure.
    forces
        Amplitudes of the excitation [N].
    method, damping, resonance, control
        As for ``solve_branch``.

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
    forces, method = checks.levels("forces", forces), as_method(method)
    problem = Problem.of(joint, damping, resonance, control)
    joint.check_excitation(problem.resonance)
    prepared, branches, errors = method.prepared(problem, forces), [], []
    for force in forces:
        branch = prepared.solve(problem, force)
        if method.has_error:
            branch, error = _assessed(method, problem, branch)
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
    estimates = errors if method.has_error else None
    return to_dataset(joint, branches, problem.damping, estimates, method.limits).assign_attrs(
        coordinates=method.name,
        resonance=problem.resonance,
        jacobian=method.jacobian,
        window_Hz=problem.window,
        largest_error=method.limits.of_peak,
        flank_error_ratio=method.limits.on_flanks,
        fallback="linear" if method.has_fallback else "none",
        options=problem.control.stored(),
    )


class MethodOptions(TypedDict, total=False):
    """Words of the options of a method, as for ``method_of``."""

    jacobian: Jacobian
    basis_update: str
    quasi_static_correction: bool
    largest_error: float
    fallback: str


def method_of(
    coordinates: str,
    *,
    jacobian: Jacobian = "analytic",
    basis_update: str = "implicit",
    quasi_static_correction: bool = True,
    largest_error: float = ErrorLimits.of_peak,
    fallback: str = "none",
    backbone: xr.Dataset | None = None,
) -> Method:
    """The method of a name in files, and of the words of its options.

    Parameters
    ----------
    coordinates
        ``linear``, ``rdnm-N``, ``complex-rdnm-N`` or ``backbone``.
    jacobian
        ``analytic`` or ``forward-difference``.
    basis_update
        Basis update of response-dependent modes: ``implicit`` or ``lagged``.
    quasi_static_correction
        Quasi-static correction of complex ones.
    largest_error
        Estimated relative error of a peak beyond which a warning reports a branch as wrong.
    fallback
        ``linear`` or ``none``.
    backbone
        Backbone of ``find_backbone``, for ``backbone``.

    Raises
    ------
    ValueError
        If a name or an option is not known.
    """
    name = Coordinates(coordinates)
    checks.choice("basis_update", basis_update, get_args(BasisUpdate))
    checks.flag("quasi_static_correction", quasi_static_correction)
    checks.choice("fallback", fallback, get_args(Fallback))
    limits = ErrorLimits(of_peak=checks.number("largest_error", largest_error, above=0))
    has_fallback = fallback == "linear"
    if name.kind == "linear":
        return LinearModes(jacobian=jacobian, limits=limits, has_fallback=has_fallback)
    if name.kind == "backbone":
        return ModalSynthesis(backbone, jacobian=jacobian, limits=limits, has_fallback=has_fallback)
    if name.count is None:
        raise ValueError(f"coordinates {coordinates!r} have no number of modes")
    return ResponseDependentModes(
        name.count,
        name.kind == "complex",
        basis_update == "lagged",
        quasi_static_correction,
        jacobian=jacobian,
        limits=limits,
        has_fallback=has_fallback,
    )


def as_method(method: Method | str) -> Method:
    """The method itself, or that of a name in files.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if isinstance(method, str):
        return method_of(method)
    checks.instance("method", method, Method)
    return method


def _assessed(method: Method, problem: Problem, branch: Branch) -> tuple[Branch, BranchError]:
    """The branch with its estimated errors, or that in linear modes in its place."""
    error = estimate_branch_error(problem.joint, branch, problem.damping)
    is_wrong = _is_wrong(branch, error, method.limits)
    if method.has_fallback and (is_wrong or not branch.complete):
        linear = LinearModes(jacobian=method.jacobian).solve(problem, branch.force)
        branch = replace(linear, fell_back=True)
        error = estimate_branch_error(problem.joint, branch, problem.damping)
    return branch, error


def _is_wrong(branch: Branch, error: BranchError, limits: ErrorLimits) -> bool:
    """Whether the estimated errors of a branch are larger than allowed; warns if so."""
    wrong = error.exceeds(limits)
    if wrong:
        at_peak = "" if branch.peak is None else f"{_in_percent(error.of_peak)} at the peak, "
        logger.warning(
            "%g N: the balance in all linear modes does not hold: estimated errors of the response "
            "are %sup to %s of its largest",
            branch.force,
            at_peak,
            _in_percent(error.largest),
        )
    return wrong


def _in_percent(share: float) -> str:
    """With two digits, and without an exponent where it is large."""
    return f"{float(f'{100 * share:.2g}'):.0f} %" if share >= 1 else f"{100 * share:.2g} %"
