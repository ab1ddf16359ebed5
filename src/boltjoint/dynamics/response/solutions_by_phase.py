"""Solutions that are known at some phases, from which others are guessed."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator

Array = NDArray[np.float64]


class SolutionsByPhase(dict[float, Array]):
    """Unknowns by their phase [rad]."""

    def nearest(self, phase: float) -> list[float]:
        """The known phases, the nearest one first."""
        return sorted(self, key=lambda other: abs(other - phase))

    def within(self, distance: float, phase: float) -> list[float]:
        """The known phases within a distance of one."""
        return [other for other in self if abs(other - phase) <= distance]

    def span(self, phase: float, room: float) -> bool:
        """Whether a phase is between known ones, or as near to them as the room."""
        return min(self) - room <= phase <= max(self) + room

    def between(self, phase: float) -> Array:
        """Interpolated between the three nearest; the only one where there are no others."""
        near = self.nearest(phase)[:3]
        if len(near) == 1:
            return self[near[0]]
        weights = BarycentricInterpolator(near, np.eye(len(near)))(phase)
        return sum((x * self[one] for one, x in zip(near, weights, strict=True)), np.zeros(()))
