"""Forms in which the forces of friction elements are known: closed form, samples, time.

A law of elements composes them. Each is given the frequency of the motion, on which viscous forces
and those that depend on the rate depend; forces of dry friction do not.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.aft_kernels import SampleTables
from boltjoint.friction.kernels import Kernel
from boltjoint.friction.modal_elements import ModalElements
from boltjoint.harmonics import Components

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Period:
    """A period at whose samples forces are evaluated.

    Parameters
    ----------
    frequency
        Frequency of the motion [rad/s].
    components
        Harmonic coefficients of motion and force.
    tables
        These components at the samples.
    """

    frequency: float
    components: Components
    tables: SampleTables


class ClosedForm(ABC):
    """Forces of one harmonic without sampling, as functions of the motion of the points.

    Motion, forces and tangents are those of ``FrictionLaw.force_and_tangent``.
    """

    @property
    def kernel(self) -> Kernel | None:
        """The compiled function of the forces; None where they depend on the frequency."""
        return None

    @abstractmethod
    def evaluate(self, motion: Array, w: float) -> Array:
        """Forces on the points under a motion of the frequency w [rad/s]."""

    @abstractmethod
    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """Forces on the points, and their derivative by the motion of each."""

    def frequency_derivative(self, motion: Array, w: float) -> Array | None:
        """Derivative of the forces by w, shape of the motion; None where they do not depend on it.

        Parameters
        ----------
        motion, w
            As for ``evaluate``.
        """
        return None

    @abstractmethod
    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """State of each element over the period, shape (elements,)."""


class AtSamples(ABC):
    """Forces of any number of harmonics by samples of a period, for AFT."""

    @abstractmethod
    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """Harmonic forces on the points.

        Parameters
        ----------
        motion
            As for ``FrictionLaw.force``.
        period
            Its frequency, components and samples.
        tangent
            To which the tangents are added, or empty.
        """

    def frequency_derivative(self, motion: Array, period: Period) -> Array | None:
        """As of ``ClosedForm``, at the frequency of the period."""
        return None

    def in_modes(self, rows: Sequence[Array], w: float) -> ModalElements | None:
        """The elements in modal coordinates; None of those that are summed by points alone.

        Parameters
        ----------
        rows
            Modal rows of the points in each direction [kg^-1/2], each (points, modes).
        w
            The frequency [rad/s].
        """
        return None

    @abstractmethod
    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """State of each element over a period of samples.

        Parameters
        ----------
        displacement
            Displacement of the points [m], shape (points, directions, samples).
        w
            The frequency [rad/s].
        """


class InTime(ABC):
    """Forces by following the elements in time, with no code in common with the other forms."""

    @abstractmethod
    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """Harmonic forces on the points, as ``ElementLaw.forces_in_time``."""


@dataclass(frozen=True)
class CompiledForm(ClosedForm):
    """A closed form by a compiled function, of forces that do not depend on the frequency.

    Parameters
    ----------
    compiled
        The function and its elements.
    find_states
        States of the elements by the motion of the points.
    """

    compiled: Kernel
    find_states: Callable[[Array], NDArray[np.int8]]

    @property
    def kernel(self) -> Kernel:
        """The compiled function of the forces."""
        return self.compiled

    def evaluate(self, motion: Array, w: float) -> Array:
        """As of ``ClosedForm``."""
        force = np.zeros_like(motion)
        columns = motion.shape[1]
        add_forces, elements = self.compiled
        add_forces(elements, motion, force, np.zeros((0, columns, columns)))
        return force

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """As of ``ClosedForm``."""
        force, tangent = np.zeros_like(motion), np.zeros((*motion.shape, motion.shape[1]))
        add_forces, elements = self.compiled
        add_forces(elements, motion, force, tangent)
        return force, tangent

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As of ``ClosedForm``."""
        return self.find_states(motion)
