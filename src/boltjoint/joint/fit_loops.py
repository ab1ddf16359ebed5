"""Least-squares fit of a few Jenkins elements to hysteresis loops (eq. 3.3 of the thesis)."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from boltjoint.joint.element_shares import ElementShares
from boltjoint.joint.fit_options import FitOptions
from boltjoint.joint.masing import force_on_loading_curve

Array = NDArray[np.float64]


class LoopMisfit(ElementShares):
    """Force differences between loops of a region and of a few elements, over the slip force.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    amplitude
        Amplitude of the loops [m], shape (loops,).
    samples
        Points along half a loop.
    """

    def __init__(
        self,
        stiffness: Array,
        slip_force: Array,
        amplitude: Array,
        samples: int = FitOptions.loop_samples,
    ) -> None:
        super().__init__(stiffness, slip_force)
        drop = np.outer(amplitude, 1 - np.cos(np.linspace(0, np.pi, samples))) / 2
        # top of the loop less twice the loading curve over half the drop (Masing)
        self.displacement = np.concatenate([amplitude, drop.ravel()])
        top = np.repeat(np.arange(amplitude.size), samples)
        self._combine = np.zeros((top.size, self.displacement.size))
        self._combine[np.arange(top.size), top] = 1.0
        self._combine[np.arange(top.size), amplitude.size + np.arange(top.size)] = -2.0
        self._target = self._combine @ force_on_loading_curve(
            self.displacement, stiffness, slip_force
        )

    def residual(self, unknown: Array) -> Array:
        """Differences along all loops, shape (loops * samples,)."""
        force = self._combine @ force_on_loading_curve(self.displacement, *self.elements(unknown))
        return (force - self._target) / self.total_slip

    def jacobian(self, unknown: Array) -> Array:
        """Their derivatives by the unknowns."""
        k, s = self.elements(unknown)
        sticks = np.multiply.outer(self.displacement, k) < s
        by_k = np.where(sticks, self.displacement[:, None], 0.0)
        by_s = np.where(sticks, 0.0, 1.0)
        return self._combine @ self.by_unknown(k, s, by_k, by_s) / self.total_slip


def initial_guesses(
    stiffness: Array, slip_force: Array, count: int, starts: int
) -> Iterator[Array]:
    """Elements grouped in the order in which they slip, with small groups first or last."""
    order = np.argsort(slip_force / stiffness, kind="stable")
    rank = np.linspace(0, 1, stiffness.size, endpoint=False)
    for bias in np.linspace(0.5, 2.0, starts):
        group = np.floor(count * rank**bias).astype(np.int64)
        k = np.bincount(group, stiffness[order], minlength=count)
        s = np.bincount(group, slip_force[order], minlength=count)
        filled = np.where(k > 0, k, k.max() / stiffness.size), np.where(s > 0, s, s.max() / s.size)
        yield np.log(np.concatenate([filled[0] / k.sum(), filled[1] / s.sum()]))
