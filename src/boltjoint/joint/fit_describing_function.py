"""Least-squares fit of a few Jenkins elements to the describing function of many."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from boltjoint.joint.element_shares import ElementShares
from boltjoint.joint.fit_options import FitOptions
from boltjoint.joint.minimax_curve import minimax_loading_curve

Array = NDArray[np.float64]


class DescribingFunctionMisfit(ElementShares):
    """Weighted differences between the describing functions of a region and of a few elements.

    With r = mu N / (k A), a slipping element has k f(r) in phase with displacement and k g(r) with
    velocity, ``f = (theta - sin theta cos theta) / pi``, ``g = 4 r (1 - r) / pi`` (see
    ``friction.constant``).

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    loss_weight
        Weight of relative errors of small losses.
    options
        Amplitudes that are compared, and which losses are small.
    """

    def __init__(
        self,
        stiffness: Array,
        slip_force: Array,
        loss_weight: float,
        options: FitOptions = FitOptions(),
    ) -> None:
        super().__init__(stiffness, slip_force)
        onset = slip_force / stiffness
        self.amplitude = np.geomspace(
            options.lowest_amplitude * onset.min(), onset.max(), options.compared_amplitudes
        )
        self._target = self._describing_function(stiffness, slip_force)
        force = self.amplitude / self.total_slip
        loss = self._target[options.compared_amplitudes :] / self.total_stiffness
        hidden = options.hidden_loss
        small = loss_weight * hidden / (loss + hidden) ** 2 / self.total_stiffness
        self._weight = np.concatenate([force, np.hypot(force, small)])

    def residual(self, unknown: Array) -> Array:
        """Differences in phase with displacement, then with velocity, at all amplitudes."""
        return self.difference(self._describing_function(*self.elements(unknown)))

    def difference(self, describing_function: Array) -> Array:
        """Weighted difference of a describing function, both parts [N/m], from the region's."""
        return self._weight * (describing_function - self._target)

    def jacobian(self, unknown: Array) -> Array:
        """Their derivatives by the unknowns."""
        k, s = self.elements(unknown)
        ratio, sine, f, g = self._of_elements(k, s)
        df, dg = 4 / np.pi * sine, np.where(ratio < 1, 4 / np.pi * (1 - 2 * ratio), 0.0)
        by_k = np.vstack([f - ratio * df, g - ratio * dg])
        by_s = np.vstack([df, dg]) / np.tile(self.amplitude, 2)[:, None]
        return self._weight[:, None] * self.by_unknown(k, s, by_k, by_s)

    def _describing_function(self, k: Array, s: Array) -> Array:
        _, _, f, g = self._of_elements(k, s)
        return np.concatenate([f @ k, g @ k])

    def _of_elements(self, k: Array, s: Array) -> tuple[Array, ...]:
        """r, sin theta, f and g of every element at every amplitude."""
        ratio = np.minimum(s / np.outer(self.amplitude, k), 1.0)
        sine = 2 * np.sqrt(ratio * (1 - ratio))
        theta = 2 * np.arctan2(np.sqrt(ratio), np.sqrt(1 - ratio))
        return ratio, sine, (theta - sine * (1 - 2 * ratio)) / np.pi, sine * sine / np.pi


def initial_guesses(
    stiffness: Array, slip_force: Array, count: int, options: FitOptions = FitOptions()
) -> Iterator[Array]:
    """Minimax loading curves with more or less weight on small amplitudes."""
    for sharpness in options.sharpnesses:
        k, s, _ = minimax_loading_curve(
            stiffness, slip_force, count, sharpness, hidden_loss=options.hidden_loss
        )
        yield np.log(np.concatenate([k / k.sum(), s / s.sum()]))
