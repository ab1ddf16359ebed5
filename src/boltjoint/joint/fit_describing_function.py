"""Least-squares fit of few Jenkins elements to the describing function of many."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax

from boltjoint.joint.masing import COMPARED_AMPLITUDES, HIDDEN_LOSS

#: lowest of them where harmonics are compared, over that of the first slip: a fit must not slip
#: before the region does
_LOWEST = 0.8


class DescribingFunctionMisfit:
    """Weighted differences between the describing functions of a region and of a few elements.

    With r = mu N / (k A), a slipping element has k f(r) in phase with displacement and k g(r) with
    velocity, ``f = (theta - sin theta cos theta) / pi``, ``g = 4 r (1 - r) / pi`` (see
    ``friction.constant``).
    """

    def __init__(
        self,
        stiffness: NDArray[np.float64],
        slip_force: NDArray[np.float64],
        loss_weight: float,
    ) -> None:
        self.total_stiffness, self.total_slip = stiffness.sum(), slip_force.sum()
        onset = slip_force / stiffness
        self.amplitude = np.geomspace(_LOWEST * onset.min(), onset.max(), COMPARED_AMPLITUDES)
        self._target = self._describing_function(stiffness, slip_force)
        force = self.amplitude / self.total_slip
        loss = self._target[COMPARED_AMPLITUDES:] / self.total_stiffness
        small = loss_weight * HIDDEN_LOSS / (loss + HIDDEN_LOSS) ** 2 / self.total_stiffness
        self._weight = np.concatenate([force, np.hypot(force, small)])

    def elements(
        self, unknown: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Stiffness and slip force of the elements from the logarithms of their shares."""
        a, b = np.split(unknown, 2)
        return self.total_stiffness * softmax(a), self.total_slip * softmax(b)

    def residual(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._weight * (self._describing_function(*self.elements(unknown)) - self._target)

    def jacobian(self, unknown: NDArray[np.float64]) -> NDArray[np.float64]:
        k, s = self.elements(unknown)
        ratio, sine, f, g = self._of_elements(k, s)
        df, dg = 4 / np.pi * sine, np.where(ratio < 1, 4 / np.pi * (1 - 2 * ratio), 0.0)
        by_k = np.vstack([f - ratio * df, g - ratio * dg])
        by_s = np.vstack([df, dg]) / np.tile(self.amplitude, 2)[:, None]
        by_a = by_k * k - np.outer(by_k @ k, k) / self.total_stiffness
        by_b = by_s * s - np.outer(by_s @ s, s) / self.total_slip
        return self._weight[:, None] * np.hstack([by_a, by_b])

    def _describing_function(
        self, k: NDArray[np.float64], s: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        _, _, f, g = self._of_elements(k, s)
        return np.concatenate([f @ k, g @ k])

    def _of_elements(
        self, k: NDArray[np.float64], s: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], ...]:
        ratio = np.minimum(s / np.outer(self.amplitude, k), 1.0)
        sine = 2 * np.sqrt(ratio * (1 - ratio))
        theta = 2 * np.arctan2(np.sqrt(ratio), np.sqrt(1 - ratio))
        return ratio, sine, (theta - sine * (1 - 2 * ratio)) / np.pi, sine * sine / np.pi
