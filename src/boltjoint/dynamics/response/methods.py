"""Methods by which the response of a joint to a force is found, each an object with its options.

``LinearModes`` and ``ResponseDependentModes`` follow the harmonic balance in coordinates of their
own, ``ModalSynthesis`` (``synthesis``) rebuilds responses from a backbone.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Self, get_args

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.dynamics.balance.balance_equations import BalanceEquations, Jacobian
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.dynamics.response.branch import Branch, ErrorLimits
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.continuation import Continuation
from boltjoint.dynamics.response.rdnm import LaggedRDNM, SelfConsistentRDNM
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import SolutionBranch
from boltjoint.solvers.step_control import StepControl


class Problem(NamedTuple):
    """A joint whose responses are sought around a resonance.

    Attributes
    ----------
    joint
        The joint and its structure.
    damping
        Damping of the structure.
    resonance
        Number of the resonance, from 1.
    window
        Lowest and highest frequency [Hz].
    control
        Tolerance and step lengths.
    """

    joint: Joint
    damping: Damping
    resonance: int
    window: tuple[float, float]
    control: StepControl

    @classmethod
    def of(
        cls,
        joint: Joint,
        damping: Damping | float,
        resonance: Resonance | int,
        control: StepControl | None,
    ) -> Self:
        """The problem of checked arguments of ``solve_response``.

        Raises
        ------
        ValueError
            As for ``solve_response``.
        """
        checks.instance("joint", joint, Joint)
        control = StepControl() if control is None else control
        checks.instance("control", control, StepControl)
        resonance = resonance if isinstance(resonance, Resonance) else Resonance(resonance)
        window = resonance.around(joint)
        return cls(joint, as_damping(damping), resonance.number, window, control)


@dataclass(frozen=True, kw_only=True)
class Method(ABC):
    """A way to find the response to a force.

    Parameters
    ----------
    jacobian
        ``analytic`` or ``forward-difference``.
    limits
        Estimated errors beyond which a warning reports a branch as wrong.
    has_fallback
        Whether such branches, and those that are not complete, are solved again in linear modes.
    repeats
        Whether a branch that breaks off is followed again from other starts and with shorter
        steps.
    """

    jacobian: Jacobian = "analytic"
    limits: ErrorLimits = field(default_factory=ErrorLimits)
    has_fallback: bool = False
    repeats: bool = True

    def __post_init__(self) -> None:
        """Refuse options that are not known."""
        checks.choice("jacobian", self.jacobian, get_args(Jacobian))
        checks.instance("limits", self.limits, ErrorLimits)
        checks.flag("has_fallback", self.has_fallback)
        checks.flag("repeats", self.repeats)

    @property
    @abstractmethod
    def name(self) -> str:
        """The ``coordinates`` in files."""

    @property
    def knows_harmonics(self) -> bool:
        """Whether motions of any number of harmonics are known to it."""
        return True

    @property
    def has_error(self) -> bool:
        """Whether its errors are estimated, by the balance in all linear modes."""
        return True

    def prepared(self, problem: Problem, forces: Sequence[float]) -> "Method":
        """The method with what the responses to several forces have in common."""
        return self

    @abstractmethod
    def solve(
        self, problem: Problem, force: float, start: NDArray[np.float64] | None = None
    ) -> Branch:
        """The response to a force, as ``solve_branch``."""


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
        whole = window if start is None else frequency_window(joint, resonance=problem.resonance)
        equations, continuation = self._continuation(problem, force, whole)
        low, high = (2 * np.pi * f for f in window)
        return _branch(force, continuation.across((low, high), start), equations)

    def _continuation(
        self, problem: Problem, force: float, window: tuple[float, float]
    ) -> tuple[BalanceEquations, Continuation]:
        """Equations of the response to a force, and its continuation with steps for a window."""
        balance = HarmonicBalance(problem.joint.distinct, problem.damping, force)
        equations, output = self.formulate(balance, problem.resonance), OutputPoint(balance)
        continuation = Continuation(
            equations, balance, problem.control, output, window, repeats=self.repeats
        )
        return equations, continuation


@dataclass(frozen=True, kw_only=True)
class LinearModes(_Followed):
    """All linear modes as coordinates: the method that others are compared with.

    Parameters
    ----------
    jacobian, limits, has_fallback, repeats
        As of ``Method``; its own errors are not estimated.
    """

    @property
    def name(self) -> str:
        """The ``coordinates`` in files."""
        return "linear"

    @property
    def has_error(self) -> bool:
        """The others are compared with it."""
        return False

    def formulate(self, balance: HarmonicBalance, resonance: int) -> BalanceEquations:
        """As of any method that follows the balance."""
        balance.joint.check_resonance(resonance)
        return BalanceEquations(balance, self.jacobian)

    def to_peak(self, problem: Problem, force: float) -> Branch | None:
        """The response to a force up to a little behind its first peak, which alone is exact.

        None where another resonance may be in the window, with a higher peak, and where the
        response takes no regular course: then ``solve`` finds it.
        """
        ranges = np.delete(problem.joint.resonance_range(), problem.resonance - 1, axis=0)
        if np.any((ranges[:, 0] <= problem.window[1]) & (ranges[:, 1] >= problem.window[0])):
            return None
        equations, continuation = self._continuation(problem, force, problem.window)
        low, high = (2 * np.pi * f for f in problem.window)
        path = continuation.to_peak((low, high))
        return None if path is None else _branch(force, path, equations)


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
        Whether they are updated once a solution; else they are those of the solution itself, and
        that of complex ones is corrected in all linear modes. Real modes with forward differences,
        as in the thesis, always are.
    quasi_static_correction
        Whether complex modes add the quasi-static response of the residual modes; without it they
        are not corrected.
    jacobian, limits, has_fallback, repeats
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


def _branch(force: float, path: SolutionBranch, equations: BalanceEquations) -> Branch:
    """Branch from the solutions of a continuation."""

    def along(name: str) -> NDArray:
        return np.array([getattr(solution, name) for solution in path.solutions])

    x = along("x")
    return Branch(
        force=force,
        frequency=along("p") / (2 * np.pi),
        modal_coordinate=x,
        amplitude=OutputPoint(equations.balance).amplitudes(x),
        iterations=along("iterations"),
        converged=along("converged"),
        located=along("located"),
        in_all_modes=equations.in_all_modes(along("reduced")),
        complete=path.complete,
        reason=path.reason,
    )
