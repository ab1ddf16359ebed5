"""The responses of a case in a basis, with the joints, windows and options of its stages."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any, Unpack

import pandas as pd
import xarray as xr

from boltjoint import dataset
from boltjoint.damping import Damping
from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.response.converged_peaks import (
    converge_peaks,
    find_converged_peaks,
    solve_converged_response,
)
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import (
    MethodOptions,
    method_of,
    solve_response,
)
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.dynamics.response.limits_at_peaks import LimitsReached, add_limits
from boltjoint.dynamics.response.methods import Problem
from boltjoint.dynamics.response.windows import Resonance, window_around
from boltjoint.joint.io import joint_from_dataset, model_errors
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl
from boltjoint.study import layout
from boltjoint.study.timing import Timed, clock

if TYPE_CHECKING:
    from boltjoint.study.response_list import Response


@dataclass(frozen=True)
class CaseInBasis:
    """A case in a basis, as its responses are solved.

    Parameters
    ----------
    case, basis
        Their names.
    forces
        Amplitudes of the excitation [N].
    damping
        Damping of the structure.
    windows
        Frequencies [Hz] by resonance, None where they are chosen.
    sampling
        Harmonics and time samples of AFT, None for analytic forces. With the harmonics ``auto``
        each response has as many as its peak needs.
    steps
        Fields of ``StepControl``.
    """

    case: str
    basis: str
    forces: Sequence[float]
    damping: Damping
    windows: Mapping[int, tuple[float, float] | None]
    sampling: Mapping[str, int | str] | None
    steps: Mapping[str, Any]

    def solve(
        self,
        responses: "Sequence[Response]",
        backbones: "Mapping[Response, tuple[xr.Dataset, tuple[float, float]]]",
        *,
        harmonics: HarmonicConvergence | None = None,
        **options: Unpack[MethodOptions],
    ) -> Iterator[tuple[xr.Dataset, dict[str, Any], pd.DataFrame]]:
        """The frequency responses, the parameters of each, and the times of its solution.

        ``backbones`` with the wall and processor time that they took [s]; ``options`` as for
        ``method_of``.

        With ``harmonics`` each has its peaks with all harmonics too. They are those of the joint in
        all linear modes, found from the first response of it, whatever coordinates others have.
        Where the harmonics are chosen, these are the options of that.
        """
        converged: dict[tuple[str, int], xr.Dataset] = {}
        limits = LimitsReached()
        for response, joint, how, stored in self._problems(responses):
            parameters = {
                "coordinates": str(response.coordinates),
                **self._excitation(response),
                **options,
            }
            backbone, seconds = backbones.get(response, (None, (0.0, 0.0)))
            method = method_of(str(response.coordinates), backbone=backbone, **options)
            method = Timed.of(method, seconds)
            peaks = response.joint, response.resonance
            if self._chooses_harmonics:
                how["harmonics"] = harmonics = harmonics or HarmonicConvergence()
                if peaks not in converged:
                    of_linear = {**how, "jacobian": method.jacobian}
                    converged[peaks] = find_converged_peaks(joint, self.forces, **of_linear).merge(
                        model_errors(stored)
                    )
                how["peaks"] = converged[peaks]
                solved = solve_converged_response(joint, self.forces, method, **how)
            else:
                solved = solve_response(joint, self.forces, method, **how)
                if harmonics is not None:
                    if peaks not in converged:
                        converged[peaks] = converge_peaks(joint, solved, harmonics).merge(
                            model_errors(stored)
                        )
                    solved = add_converged_peaks(solved, converged[peaks])
            solved = add_limits(solved, stored)
            limits.add(solved)
            if harmonics is not None:
                solved.attrs["harmonic_convergence"] = harmonics.stored()
            yield solved, self._parameters(response, parameters), method.times
        limits.warn()

    def time_by_differences(
        self, responses: "Sequence[Response]", **options: Unpack[MethodOptions]
    ) -> Iterator[pd.DataFrame]:
        """The times of the frequency responses with forward differences, each followed once.

        ``options`` as for ``method_of``.
        """
        options["jacobian"] = "forward-difference"
        for response, joint, how, _ in self._problems(responses):
            method = method_of(str(response.coordinates), **options)
            method = Timed.of(replace(method, repeats=False))
            problem = Problem.of(joint, **how)
            prepared = method.prepared(problem, self.forces)
            for force in self.forces:
                prepared.solve(problem, force)
            yield method.times

    def trace_backbones(
        self, responses: "Sequence[Response]"
    ) -> Iterator[tuple[xr.Dataset, dict[str, Any], tuple[float, float]]]:
        """The backbones of the joints and resonances, the parameters of each, and its time [s]."""
        for response, joint, how, _ in self._problems(responses):
            excitation, resonance = self._excitation(response), how.pop("resonance")
            how |= {"window": resonance.window, "resonance": resonance.number}
            # compiled before its time is taken
            brief = how | {"control": replace(how["control"], maximum_solutions=2)}
            find_backbone(joint, self.forces, **brief)
            begun = clock()
            traced = find_backbone(joint, self.forces, **how)
            wall, cpu = clock() - begun
            yield traced, self._parameters(response, excitation), (wall, cpu)

    def _problems(
        self, responses: "Sequence[Response]"
    ) -> "Iterator[tuple[Response, Joint, dict[str, Any], xr.Dataset]]":
        """Joint, window and step-length control of each response, and the file of the joint."""
        load = cache(self._load)
        for response in responses:
            joint, stored = load(response.joint)
            ranges = stored["resonance_range"].to_numpy().tolist()
            resonance = response.resonance
            low, high = ranges[resonance - 1]
            window = window_around(low, high, resonance, self.windows[resonance])
            how = {
                "damping": self.damping,
                "resonance": Resonance(resonance, window),
                "control": StepControl(**self.steps),
            }
            yield response, joint, how, stored

    def _load(self, name: str) -> tuple[Joint, xr.Dataset]:
        """A joint and its file."""
        path = layout.path("joint", case=self.case, basis=self.basis, joint=name)
        stored = dataset.load(path)
        if self._chooses_harmonics or self.sampling is None:
            return joint_from_dataset(stored), stored
        sampling = {name: int(number) for name, number in self.sampling.items()}
        return joint_from_dataset(stored, sampling), stored

    @property
    def _chooses_harmonics(self) -> bool:
        return self.sampling is not None and self.sampling["harmonics"] == "auto"

    def _excitation(self, response: "Response") -> dict[str, Any]:
        """Resonance, forces and damping of a response."""
        return {
            "resonance": response.resonance,
            "forces": self.forces,
            "damping": self.damping,
        }

    def _parameters(self, response: "Response", arguments: Mapping[str, Any]) -> dict[str, Any]:
        resonance = response.resonance
        return {
            "window": {"resonance": resonance, "given": self.windows[resonance]},
            "options": arguments,
            "sampling": self.sampling,
            "steps": self.steps,
        }
