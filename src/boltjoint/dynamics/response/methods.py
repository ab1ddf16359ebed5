"""Methods by which responses are found, each an object with its options.

``LinearModes`` and ``ResponseDependentModes`` follow the harmonic balance in coordinates of their
own, ``ModalSynthesis`` rebuilds responses from a backbone. ``method_of`` gives that of a name in
files and of the words of its options; behind it nothing compares them.
"""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.linear_modes import BalanceEquations
from boltjoint.dynamics.balance.output_point import OutputPoint
from boltjoint.dynamics.response.branch import Branch, ErrorLimits
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.continuation import Continuation
from boltjoint.dynamics.response.method import Method, Problem
from boltjoint.dynamics.response.rdnm import LaggedRDNM, SelfConsistentRDNM
from boltjoint.dynamics.response.synthesis import ModalSynthesis
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.names import Coordinates
from boltjoint.solvers.equations import SolutionBranch

BasisUpdate = Literal["implicit", "lagged"]
Fallback = Literal["none", "linear"]


class _Followed(Method):
    """A method that follows the harmonic balance by arc-length continuation."""

    @abstractmethod
    def formulate(self, balance: HarmonicBalance, resonance: int) -> BalanceEquations:
        """Equations of the balance in the coordinates of the method.

        Parameters
        ----------
        balance
            The modal equations.
        resonance
            The resonance that is followed, from 1.

        Raises
        ------
        ValueError
            If the structure has no such resonance, or fewer modes than are asked for.
        """

    def solve(
        self, problem: Problem, force: float, start: NDArray[np.float64] | None = None
    ) -> Branch:
        """As of ``Method``."""
        joint, window = problem.joint, problem.window
        balance = HarmonicBalance(joint.distinct, problem.damping, force)
        equations, output = self.formulate(balance, problem.resonance), OutputPoint(balance)
        whole = window if start is None else frequency_window(joint, resonance=problem.resonance)
        continuation = Continuation(equations, balance, problem.control, output, whole)
        low, high = (2 * np.pi * f for f in window)
        path = continuation.across((low, high), start)
        return _branch(force, path, output, equations)


@dataclass(frozen=True, kw_only=True)
class LinearModes(_Followed):
    """All linear modes as coordinates: the method that others are compared with.

    Parameters
    ----------
    jacobian, limits, has_fallback
        As of ``Method``; its own errors are not estimated.
    """

    has_error: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """The ``coordinates`` in files."""
        return "linear"

    def formulate(self, balance: HarmonicBalance, resonance: int) -> BalanceEquations:
        """As of any method that follows the balance."""
        balance.joint.check_resonance(resonance)
        return BalanceEquations(balance, self.jacobian)


@dataclass(frozen=True)
class ResponseDependentModes(_Followed):
    """Response-dependent nonlinear modes (RDNM), real or complex, as coordinates.

    Parameters
    ----------
    count
        Number of modes.
    is_complex
        Whether they are those of the complex describing function.
    is_lagged
        Whether they are updated once a solution; else they are those of the solution itself. Real
        modes with forward differences, as in the thesis, always are.
    quasi_static_correction
        Whether complex modes add the quasi-static response of the residual modes.
    jacobian, limits, has_fallback
        As of ``Method``.
    """

    count: int
    is_complex: bool = False
    is_lagged: bool = False
    quasi_static_correction: bool = True

    def __post_init__(self) -> None:
        """Refuse options that are not known."""
        super().__post_init__()
        checks.whole("count", self.count, at_least=1)
        for option in ("is_complex", "is_lagged", "quasi_static_correction"):
            checks.flag(option, getattr(self, option))

    @property
    def name(self) -> str:
        """The ``coordinates`` in files."""
        return f"{'complex-' if self.is_complex else ''}rdnm-{self.count}"

    @property
    def knows_harmonics(self) -> bool:
        """Complex modes are those of a motion of one harmonic."""
        return not self.is_complex

    def formulate(self, balance: HarmonicBalance, resonance: int) -> BalanceEquations:
        """As of any method that follows the balance."""
        modes = self.count, balance.joint.place_of(resonance)
        if self.is_complex:
            options = self.is_lagged, self.quasi_static_correction
            return ComplexRDNM(balance, *modes, self.jacobian, *options)
        if self.is_lagged or self.jacobian == "forward-difference":
            return LaggedRDNM(balance, *modes, self.jacobian)
        return SelfConsistentRDNM(balance, *modes)


def method_of(
    coordinates: str,
    *,
    jacobian: str = "analytic",
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
    of_all = {"jacobian": jacobian, "limits": limits, "has_fallback": fallback == "linear"}
    if name.kind == "linear":
        return LinearModes(**of_all)
    if name.kind == "backbone":
        return ModalSynthesis(backbone, **of_all)
    return ResponseDependentModes(
        name.count,
        name.kind == "complex",
        basis_update == "lagged",
        quasi_static_correction,
        **of_all,
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


def _branch(
    force: float, path: SolutionBranch, output: OutputPoint, equations: BalanceEquations
) -> Branch:
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
        in_all_modes=equations.in_all_modes(each("reduced")),
        complete=path.complete,
        reason=path.reason,
    )
