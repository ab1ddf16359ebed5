"""Forces of springs with sliders that move on lines, at samples and in time.

The walk of a slider in time shares no code with that over samples (``sliders_at_samples``), nor
with the describing functions of the laws, so that either verifies the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import kept_loop
from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.friction.forms import AtSamples, InTime, Period
from boltjoint.friction.modal_aft import ModalSliders
from boltjoint.friction.protocol import ModalElements
from boltjoint.friction.sliders_at_samples import Sliders, slider_forces

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


#: elements integrated side by side: many for the processor's vectors, few for its cache
_LANES = 128


def integrate_friction(
    point: NDArray[np.int64],
    tangential_stiffness: NDArray[np.float64],
    normal_stiffness: NDArray[np.float64] | None,
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    motion: NDArray[np.float64],
    samples: int,
) -> NDArray[np.float64]:
    """Harmonic forces of sliders on their points, as ``ElementLaw.forces_in_time``.

    The normal load of a slider is that of its spring and never negative; the friction force is that
    of its spring, bounded by mu times the normal load. A slider that its spring cannot move at any
    phase has the force of the spring, which needs no samples.
    """
    phase = 2 * np.pi * np.arange(1, samples + 1) / samples
    table = np.column_stack([np.sin(phase), np.cos(phase)])
    x = tangential_stiffness[:, None] * motion[point, :3]
    n = np.zeros_like(x)
    if normal_stiffness is not None:
        n = normal_stiffness[:, None] * motion[point, 3:]
    least = normal_load + n[:, 0] - np.hypot(n[:, 1], n[:, 2])
    n[:, 0] += np.minimum(normal_load, 0)
    reach = np.abs(x[:, 0]) + np.hypot(x[:, 1], x[:, 2])
    sticks = (least >= 0) & (reach <= friction_coefficient * least)
    moved = ~sticks
    force = np.zeros_like(motion)
    _integrate_friction(
        point[moved],
        tangential_stiffness[moved],
        None if normal_stiffness is None else normal_stiffness[moved],
        normal_load[moved],
        friction_coefficient[moved],
        motion,
        table,
        force,
    )
    force *= np.tile([1 / samples, 2 / samples, 2 / samples], 2)
    changes = x if normal_stiffness is None else np.hstack([x, n])
    np.add.at(force[:, : changes.shape[1]], point[sticks], changes[sticks])
    return force


@kept_loop
def _integrate_friction(
    point_of_element: NDArray[np.int64],
    k_u: NDArray[np.float64],
    k_v: NDArray[np.float64] | None,
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    motion: NDArray[np.float64],
    table: NDArray[np.float64],
    force: NDArray[np.float64],
) -> None:
    """Sum friction and normal load change of all elements over a period, times 1, sine and cosine.

    Without a normal stiffness, numba compiles a version without the normal load.
    """
    # bias, sine and cosine of the spring forces; sums of the forces; state of the sliders
    x, n = np.empty((3, _LANES)), np.empty((3, _LANES))
    f_sum, n_sum = np.empty((3, _LANES)), np.empty((3, _LANES))
    mu, z = np.empty(_LANES), np.empty(_LANES)
    x_before, n_before = np.empty(_LANES), np.empty(_LANES)
    for first in range(0, k_u.size, _LANES):
        lanes = min(_LANES, k_u.size - first)
        for e in range(lanes):
            p = point_of_element[first + e]
            n[0, e], n[1, e], n[2, e] = normal_load[first + e], 0.0, 0.0
            for c in range(3):
                x[c, e] = k_u[first + e] * motion[p, c]
                if k_v is not None:
                    n[c, e] += k_v[first + e] * motion[p, 3 + c]
            mu[e] = friction_coefficient[first + e]
            # sliders start at zero traction; the period begins at sine 0, cosine 1
            z[e] = 0.0
            x_before[e], n_before[e] = x[0, e] + x[2, e], n[0, e] + n[2, e]
        f_sum[:] = 0.0
        n_sum[:] = 0.0
        for period in range(2):
            evaluated = period == 1
            for i in range(len(table)):
                sin, cos = table[i]
                for e in range(lanes):
                    x_now = x[0, e] + x[1, e] * sin + x[2, e] * cos
                    slider, load = z[e], n[0, e]
                    if k_v is not None:
                        n_now = n[0, e] + n[1, e] * sin + n[2, e] * cos
                        # on contact closing the slider restarts there, by linear interpolation
                        # between samples: the error of the force would else be of first order
                        part = n_before[e] / (n_before[e] - n_now)
                        closing = x_before[e] + (x_now - x_before[e]) * part
                        slider = closing if n_before[e] < 0.0 else slider
                        load = n_now if n_now > 0.0 else 0.0
                        x_before[e], n_before[e] = x_now, n_now
                        if evaluated:
                            n_sum[0, e] += load
                            n_sum[1, e] += load * sin
                            n_sum[2, e] += load * cos
                    lower, upper = x_now - mu[e] * load, x_now + mu[e] * load
                    slider = slider if slider > lower else lower
                    slider = slider if slider < upper else upper
                    z[e] = slider
                    if evaluated:
                        friction = x_now - slider
                        f_sum[0, e] += friction
                        f_sum[1, e] += friction * sin
                        f_sum[2, e] += friction * cos
        for e in range(lanes):
            p = point_of_element[first + e]
            for c in range(3):
                force[p, c] += f_sum[c, e]
                if k_v is not None:
                    force[p, 3 + c] += n_sum[c, e]
            if k_v is not None:
                force[p, 3] -= len(table) * max(normal_load[first + e], 0.0)
