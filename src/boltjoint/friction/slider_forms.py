"""Forces of springs with sliders that move on lines, at samples and in time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.friction.forms import AtSamples, InTime, Period
from boltjoint.friction.modal_aft import ModalSliders
from boltjoint.friction.modal_elements import ModalElements
from boltjoint.friction.sliders_at_samples import Sliders, slider_forces
from boltjoint.friction.sliders_in_time import integrate_friction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SlidersAtSamples(AtSamples):
    """Forces of the sliders of elements at samples of a period.

    Parameters
    ----------
    sliders
        Sliders of all elements.
    elements
        Number of elements.
    """

    sliders: Sliders
    elements: int

    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """As of ``AtSamples``."""
        return slider_forces(self.sliders, motion, period.tables, tangent)

    def in_modes(self, rows: Sequence[Array], w: float) -> ModalElements:
        """As of ``AtSamples``."""
        return ModalSliders.of(self.sliders, rows)

    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """As of ``AtSamples``; an element of several sliders slips with the first of them."""
        sliders = self.sliders
        along = 0 if sliders.lateral is None else sliders.lateral.astype(int)
        x = sliders.tangential_stiffness[:, None] * displacement[sliders.point, along]
        n = np.broadcast_to(sliders.normal_load[:, None], x.shape)
        if sliders.normal_stiffness is not None:
            n = n + sliders.normal_stiffness[:, None] * displacement[sliders.point, -1]
        bound = sliders.friction_coefficient[:, None] * np.maximum(n, 0)
        # no constant slider position lies between the bounds
        slips = (x - bound).max(axis=1) > (x + bound).min(axis=1)
        of_element = np.full(self.elements, STICK, dtype=np.int8)
        np.maximum.at(of_element, sliders.element, states_of_period(slips, n))
        return of_element


@dataclass(frozen=True)
class SlidersInTime(InTime):
    """Forces of sliders that are followed in time.

    Parameters
    ----------
    sliders
        Sliders of all elements.
    """

    sliders: Sliders

    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """As of ``InTime``."""
        sliders, force = self.sliders, np.zeros_like(motion)
        normal = np.arange(motion.shape[1])[-3:]
        lateral = np.zeros(sliders.point.size, bool) if sliders.lateral is None else sliders.lateral
        for d in range(motion.shape[1] // 3 - 1):
            mine = lateral == bool(d)
            of_direction = np.arange(3 * d, 3 * d + 3)
            at = np.concatenate([of_direction, normal])
            of_sliders = integrate_friction(
                sliders.point[mine],
                sliders.tangential_stiffness[mine],
                None if sliders.normal_stiffness is None else sliders.normal_stiffness[mine],
                sliders.normal_load[mine],
                sliders.friction_coefficient[mine],
                motion[:, at],
                samples,
            )
            # both directions have the normal load in common, and it acts once
            acting = slice(None) if d == 0 else slice(3)
            force[:, at[acting]] += of_sliders[:, acting]
        return force


def states_of_period(slips: NDArray[np.bool_], n: Array) -> NDArray[np.int8]:
    """Contact states by whether each element slips, and its normal load at samples (``n < 0``)."""
    state = np.where(slips, STICK_SLIP, STICK)
    state[n.min(axis=1) <= 0] = STICK_SLIP_SEPARATION
    state[n.max(axis=1) <= 0] = SEPARATION
    return state.astype(np.int8)
