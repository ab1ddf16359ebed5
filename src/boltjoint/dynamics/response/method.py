"""Protocol of the methods by which the response of a joint to a force is found."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Self, get_args

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, as_damping
from boltjoint.dynamics.balance.linear_modes import Jacobian
from boltjoint.dynamics.response.branch import Branch, ErrorLimits
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.joint.model import Joint
from boltjoint.solvers.equations import StepControl


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
    """

    jacobian: Jacobian = "analytic"
    limits: ErrorLimits = field(default_factory=ErrorLimits)
    has_fallback: bool = False

    #: whether motions of any number of harmonics are known to it
    knows_harmonics: ClassVar[bool] = True
    #: whether its errors are estimated, by the balance in all linear modes
    has_error: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Refuse options that are not known."""
        checks.choice("jacobian", self.jacobian, get_args(Jacobian))
        checks.instance("limits", self.limits, ErrorLimits)
        checks.flag("has_fallback", self.has_fallback)

    @property
    @abstractmethod
    def name(self) -> str:
        """The ``coordinates`` in files."""

    def prepared(self, problem: Problem, forces: Sequence[float]) -> "Method":
        """The method with what the responses to several forces have in common."""
        return self

    @abstractmethod
    def solve(
        self, problem: Problem, force: float, start: NDArray[np.float64] | None = None
    ) -> Branch:
        """The response to a force, as ``solve_branch``."""
