"""Responses by nonlinear modal synthesis, with a warning where another resonance is larger."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.backbone.backbone import Backbone, backbone_from_dataset, trace_for_forces
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.output_point import OutputPoint
from boltjoint.dynamics.response.branch import Branch
from boltjoint.dynamics.response.method import Method, Problem
from boltjoint.dynamics.response.other_resonances import OtherResonances

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ModalSynthesis(Method):
    """Nonlinear modal synthesis: responses from the backbone of the resonance.

    Parameters
    ----------
    backbone
        That covers the responses, or a dataset of ``find_backbone``; by default it is traced, once
        for all forces.
    others
        Other resonances, among which a larger peak is sought; by default those in the window.
    jacobian, limits, has_fallback
        As of ``Method``; the Jacobian is that of the fallback.
    """

    backbone: Backbone | xr.Dataset | None = None
    others: OtherResonances | None = None

    knows_harmonics: ClassVar[bool] = False

    def __post_init__(self) -> None:
        """Refuse options that are not known, and what is no backbone."""
        super().__post_init__()
        if self.backbone is not None:
            checks.instance("backbone", self.backbone, Backbone, xr.Dataset)

    @property
    def name(self) -> str:
        """The ``coordinates`` in files."""
        return "backbone"

    def prepared(self, problem: Problem, forces: Sequence[float]) -> "ModalSynthesis":
        """With the backbone that covers the responses to all forces."""
        joint, control, backbone = problem.joint, problem.control, self.backbone
        if backbone is None:
            how = {"damping": problem.damping, "resonance": problem.resonance, "control": control}
            backbone = trace_for_forces(joint, forces, window=problem.window, **how)
        elif isinstance(backbone, xr.Dataset):
            backbone = backbone_from_dataset(joint, backbone, control)
        others = OtherResonances(backbone, forces, problem.window)
        return replace(self, backbone=backbone, others=others)

    def solve(
        self, problem: Problem, force: float, start: NDArray[np.float64] | None = None
    ) -> Branch:
        """As of ``Method``.

        Raises
        ------
        ValueError
            If a start is given.
        """
        if start is not None:
            raise ValueError("a response synthesised from the backbone has no start")
        if self.others is None:
            return self.prepared(problem, [force]).solve(problem, force)
        return synthesise_branch(self.backbone, force, problem.window, self.others)


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
