"""Responses by nonlinear modal synthesis, with a warning where another resonance is larger.

Nonlinear modal synthesis gives the peak of the resonance whose backbone it is of. Where others lie
in the same window, the largest response may be one of theirs.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.backbone.backbone import Backbone, backbone_from_dataset, trace_for_forces
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance, OutputPoint
from boltjoint.dynamics.response.branch import (
    Branch,
    ErrorLimits,
    estimate_solution_error,
)
from boltjoint.dynamics.response.folds import find_folds
from boltjoint.dynamics.response.methods import Method, Problem

#: relative difference of amplitudes below which two peaks may be the same: what synthesis from two
#: backbones of one resonance is off by
_SAME = 0.02
#: estimated error at a turning point above which the full equations may not turn there, but pass
#: below an isolated branch
_LARGEST_AT_TURNS = 0.1


class OtherResonances:
    """Backbones of the other resonances that may lie in a window, traced when they are asked for.

    Parameters
    ----------
    backbone
        Backbone of the resonance whose responses are synthesised.
    forces
        Amplitudes of the excitation [N].
    window
        Lowest and highest frequency of the responses [Hz].
    """

    def __init__(
        self, backbone: Backbone, forces: Sequence[float], window: tuple[float, float]
    ) -> None:
        self._backbone, self._forces, self._window = backbone, forces, window

    @cached_property
    def _backbones(self) -> list[Backbone]:
        equations, (low, high) = self._backbone.equations, self._window
        balance = equations.balance
        backbones = []
        for number, (free, stuck) in enumerate(balance.joint.resonance_range(), start=1):
            if number == equations.resonance or free > high or stuck < low:
                continue
            try:
                balance.joint.check_excitation(number)
            except ValueError:
                continue  # not excited: it has no peak
            backbone = trace_for_forces(
                balance.joint,
                self._forces,
                damping=balance.damping,
                window=self._window,
                resonance=number,
                control=self._backbone.control,
            )
            backbones.append(backbone)
        return backbones

    def larger_than(self, branch: Branch) -> int | None:
        """Number of the resonance with the largest peak if it is larger than a branch's, else 0.

        None if that is not known: a response breaks off without a peak, or a larger one is in error
        by more than is allowed (``ErrorLimits``), and no other is larger.
        """
        largest, number = branch.peak_amplitude * (1 + _SAME), 0
        is_known = True
        balance = _balance(self._backbone, branch.force)
        for backbone in self._backbones:
            response = synthesise_response(backbone, branch.force, self._window)
            if response.peak is None:
                is_known &= response.complete
                continue
            x, w = (
                response.modal_coordinate[response.peak],
                2 * np.pi * response.frequency[response.peak],
            )
            amplitude = OutputPoint(balance).value(x)
            if amplitude <= largest:
                continue
            if estimate_solution_error(balance, x, w) <= ErrorLimits.of_peak:
                largest, number = amplitude, backbone.equations.resonance
            else:
                is_known = False
        return number if number or is_known else None


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
    jacobian, limits, has_fallback, repeats
        As of ``Method``; the Jacobian is that of the fallback, and nothing is repeated.
    """

    backbone: Backbone | xr.Dataset | None = None
    others: OtherResonances | None = None

    def __post_init__(self) -> None:
        """Refuse options that are not known, and what is no backbone."""
        super().__post_init__()
        if self.backbone is not None:
            checks.instance("backbone", self.backbone, Backbone, xr.Dataset)

    @property
    def name(self) -> str:
        """The ``coordinates`` in files."""
        return "backbone"

    @property
    def knows_harmonics(self) -> bool:
        """Backbones are of one harmonic."""
        return False

    def prepared(self, problem: Problem, forces: Sequence[float]) -> "ModalSynthesis":
        """With the backbone that covers the responses to all forces."""
        joint, control, backbone = problem.joint, problem.control, self.backbone
        if backbone is None:
            backbone = trace_for_forces(
                joint,
                forces,
                window=problem.window,
                damping=problem.damping,
                resonance=problem.resonance,
                control=control,
            )
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
        backbone = checks.instance("backbone", self.backbone, Backbone)
        return synthesise_branch(backbone, force, problem.window, self.others)


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
    if branch.peak is None:
        return branch
    if not (branch.has_isolated or _is_way_known(branch, backbone)):
        branch = replace(branch, has_isolated=None)
    if others is None:
        return branch
    larger = others.larger_than(branch)
    if larger:
        logger.warning("%g N: resonance %d has a larger peak in the window", force, larger)
    return replace(branch, larger_resonance=larger)


def _balance(backbone: Backbone, force: float) -> HarmonicBalance:
    """The full equations of the joint of a backbone."""
    free = backbone.equations.balance
    return HarmonicBalance(free.joint, free.damping, force)


def _is_way_known(branch: Branch, backbone: Backbone) -> bool:
    """Whether the turning points before the peak are solutions of the full equations."""
    turns = find_folds(branch.frequency, branch.complete).at
    balance = _balance(backbone, branch.force)
    return all(
        estimate_solution_error(
            balance, branch.modal_coordinate[turn], 2 * np.pi * branch.frequency[turn]
        )
        <= _LARGEST_AT_TURNS
        for turn in turns[turns < (branch.peak or 0)]
    )
