"""The joint of a sweep in each of its designs, and how it is solved."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.case import Case
from boltjoint.config.varied_case import with_values
from boltjoint.dynamics.backbone.backbone_at import backbone_at
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.converged_peaks import ConvergedPeak, find_converged_peak
from boltjoint.dynamics.response.frequency_response import as_method
from boltjoint.dynamics.response.methods import Problem
from boltjoint.dynamics.response.peak_sequence import HarmonicConvergence
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.harmonics import Components
from boltjoint.joint.model import Joint
from boltjoint.joint.rescaled import rescale_contact
from boltjoint.solvers.equations import StepControl

if TYPE_CHECKING:
    from boltjoint.dynamics.response.branch import Branch

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SweptJoint:
    """The joint of a sweep, as each design has it.

    Parameters
    ----------
    case
        Content of the base case, with the resonance, joint and coordinates that are solved.
    joints
        Joints of the base case: node to node, then those that it was reduced to; the last one is
        solved, in a frequency window that suits all.
    sampling
        Harmonics and time samples of AFT, None for analytic forces.
    control
        Tolerance and step lengths; the defaults if None.
    harmonics
        Numbers of harmonics and tolerances of converged peaks.
    """

    case: Mapping[str, Any]
    joints: Sequence[Joint]
    sampling: Mapping[str, int] | None = None
    control: StepControl | None = None
    harmonics: HarmonicConvergence = HarmonicConvergence()

    @cached_property
    def base(self) -> Case:
        """The base case."""
        return Case.model_validate(self.case)

    @property
    def elements(self) -> int:
        """Number of elements of the joint that is solved."""
        return self.joints[-1].law.point_of_element.size

    def window(self, values: Mapping[str, float]) -> tuple[float, float]:
        """Frequency window of the design with these values of its keys [Hz]."""
        return self._window(self._joints(self._case(values)))

    def solve(
        self, values: Mapping[str, float], window: tuple[float, float] | None = None
    ) -> tuple[Joint, list["Branch"]]:
        """The joint of a design, and its response at each level.

        Parameters
        ----------
        values
            Values of the keys that vary.
        window
            Frequencies [Hz]; by default those of the design.
        """
        case = self._case(values)
        joints = self._joints(case)
        joint = self._solved(joints)
        resonance = Resonance(case.solve[0].resonance, window or self._window(joints))
        problem = Problem.of(joint, case.structural_damping, resonance, self.control)
        joint.check_excitation(problem.resonance)
        method = as_method(str(case.coordinates[0])).prepared(problem, case.levels)
        return joint, [method.solve(problem, level) for level in case.levels]

    def converge(
        self, values: Mapping[str, float], joint: Joint, branches: Sequence["Branch"]
    ) -> list[ConvergedPeak]:
        """The peaks of a design with all harmonics, from its responses."""
        damping = self._case(values).structural_damping
        peaks = []
        for branch in branches:
            if branch.peak is None:
                peaks.append(ConvergedPeak())
                continue
            components = Components(joint.law.components)
            amplitude = components.rows(branch.modal_coordinate[branch.peak])
            at = float(branch.frequency[branch.peak]), PeriodicMotion(components, amplitude)
            peaks.append(find_converged_peak(joint, *at, branch.force, damping, self.harmonics))
        return peaks

    def backbone(self, values: Mapping[str, float], amplitudes: Array) -> tuple[Array, Array]:
        """Natural frequency [Hz] and damping ratio of a design at amplitudes [m]."""
        case = self._case(values)
        return backbone_at(
            self._solved(self._joints(case)),
            amplitudes,
            resonance=case.solve[0].resonance,
            damping=case.structural_damping,
            control=self.control,
        )

    def largest_peak(self, level: float) -> float:
        """Amplitude of the peak of the base case under a level [m]; 0 without one."""
        key = "accelerations_m_per_s2" if self.base.is_base_excited else "forces_N"
        _, (branch,) = self.solve({key: level})
        return 0.0 if branch.peak is None else float(branch.amplitude[branch.peak])

    def _solved(self, joints: Sequence[Joint]) -> Joint:
        """That of all joints which is solved."""
        if self.sampling is None:
            return joints[-1]
        law = AlternatingFrequencyTime(joints[-1].law, **self.sampling)
        return replace(joints[-1], law=law)

    def _case(self, values: Mapping[str, float]) -> Case:
        return Case.model_validate(with_values(self.case, values))

    def _joints(self, case: Case) -> list[Joint]:
        """All joints with the contact and the preload of a design."""
        before, after = dict(self.base.contact.options), dict(case.contact.options)
        law, _ = before.pop("law"), after.pop("law")
        ratio = case.preload_N / self.base.preload_N
        return [rescale_contact(joint, law, before, after, ratio) for joint in self.joints]

    def _window(self, joints: Sequence[Joint]) -> tuple[float, float]:
        block = self.base.solve[0]
        return frequency_window(*joints, resonance=block.resonance, given=block.window_Hz)
