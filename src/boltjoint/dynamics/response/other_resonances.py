"""Larger peaks of other resonances in the window of a response that is synthesised from one.

Nonlinear modal synthesis gives the peak of the resonance whose backbone it is of. Where others lie
in the same window, the largest response may be one of theirs.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from boltjoint.dynamics.backbone.backbone import Backbone, trace_for_forces
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.branch import (
    Branch,
    ErrorLimits,
    OutputPoint,
    estimate_solution_error,
)

#: relative difference of amplitudes below which two peaks may be the same: what synthesis from two
#: backbones of one resonance is off by
_SAME = 0.02


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
            known = trace_for_forces(
                balance.joint,
                self._forces,
                damping=balance.damping,
                window=self._window,
                resonance=number,
                control=self._backbone.control,
            )
            backbones.append(known)
        return backbones

    def larger_than(self, branch: Branch) -> int:
        """Number of the resonance with the largest peak if it is larger than a branch's, else 0.

        Peaks whose estimated error is too large count as none (``ErrorLimits``).
        """
        largest, number = branch.peak_amplitude * (1 + _SAME), 0
        of_joint = self._backbone.equations.balance
        balance = HarmonicBalance(of_joint.joint, of_joint.damping, branch.force)
        for known in self._backbones:
            response = synthesise_response(known, branch.force, self._window)
            if response.peak is None:
                continue
            x, w = (
                response.modal_coordinate[response.peak],
                2 * np.pi * response.frequency[response.peak],
            )
            amplitude = OutputPoint(balance).value(x)
            if amplitude <= largest:
                continue
            if estimate_solution_error(balance, x, w) <= ErrorLimits.of_peak:
                largest, number = amplitude, known.equations.resonance
        return number
