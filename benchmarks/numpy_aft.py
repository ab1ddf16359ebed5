"""Friction forces as they are usually computed: AFT in NumPy, all elements at a sample at once."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.protocol import FrictionLaw
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NumpyAFT(FrictionLaw):
    """Elements under constant normal load, followed through two periods of samples.

    Parameters
    ----------
    elements
        The friction elements.
    samples
        Samples a period.
    """

    elements: ConstantLoad
    samples: int = 128

    directions = ("tangential",)
    components = ("sin", "cos")

    @property
    def point_of_element(self) -> NDArray[np.int64]:
        """The contact point each element acts on, shape (elements,)."""
        return self.elements.point_of_element

    def stuck_stiffness(self, points: int) -> Array:
        """Stiffness of the points in stick [N/m], shape (points, directions)."""
        return self.elements.stuck_stiffness(points)

    def evaluate(self, motion: Array, w: float) -> Array:
        """Harmonic forces of all elements on each point."""
        return self.evaluate_with_tangent(motion, w)[0]

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """Harmonic forces on each point and their derivative by the motion of that point."""
        on, k = self.point_of_element, self.elements.tangential_stiffness
        limit = self.elements.slip_force
        u = motion[on] @ self._synthesis
        force, gradient = np.zeros(k.size), np.zeros((k.size, 2))
        forces = np.empty((self.samples, k.size))
        gradients = np.empty((self.samples, k.size, 2))
        before, at_before = np.zeros(k.size), np.zeros(2)
        for sample in range(2 * self.samples):
            i = sample % self.samples
            now, at = u[:, i], self._synthesis[:, i]
            force = force + k * (now - before)
            gradient = gradient + k[:, None] * (at - at_before)
            slips = abs(force) > limit
            force = np.where(slips, np.copysign(limit, force), force)
            gradient[slips] = 0.0
            forces[i], gradients[i] = force, gradient
            before, at_before = now, at
        analysis = 2 / self.samples * self._synthesis
        f, t = np.zeros_like(motion), np.zeros((*motion.shape, 2))
        np.add.at(f, on, (analysis @ forces).T)
        np.add.at(t, on, np.einsum("cs,sed->ecd", analysis, gradients))
        return f, t

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """State of every element over the period."""
        return self.elements.states(motion, w)

    @cached_property
    def _synthesis(self) -> Array:
        phase = 2 * np.pi * np.arange(1, self.samples + 1) / self.samples
        return np.stack([np.sin(phase), np.cos(phase)])


def with_numpy_aft(joint: Joint, samples: int = 128) -> Joint:
    """The joint with forces by AFT in NumPy."""
    return replace(joint, law=NumpyAFT(joint.law, samples))
