"""Protocol of elements in modal coordinates, whose forces are followed by AFT."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.aft_kernels import Array


class HarmonicBasis(NamedTuple):
    """Components of motion and force: ``harmonic`` number and ``is_sine``, shape (components,).

    ``synthesis`` has their values at the samples, shape (components, samples); ``weight`` that of a
    sample in each; ``mean`` the sums of the weighted values up to a sample, (samples + 1,
    components).
    """

    harmonic: NDArray[np.int64]
    is_sine: NDArray[np.bool_]
    synthesis: Array
    weight: Array
    mean: Array


class ModalTangent(Protocol):
    """Derivative of harmonic forces in modal coordinates, evaluated when it is called."""

    def __call__(self) -> Array:
        """D force[i, r] / d amplitude[j, s], shape (components, modes, components, modes)."""

    def along(self, change: Array) -> Array:
        """Derivative of the forces along a change of the amplitudes, both (components, modes)."""


class ModalElements(Protocol):
    """Elements of a law in modal coordinates."""

    def force_and_tangent(
        self, basis: HarmonicBasis, amplitude: Array
    ) -> tuple[Array, ModalTangent]:
        """Harmonic forces in modal coordinates, and their lazily evaluated derivative.

        Parameters
        ----------
        basis
            The components of motion and force.
        amplitude
            Modal coordinates by component [kg^1/2 m], shape (components, modes).

        Returns
        -------
        force : ndarray
            Shape (components, modes) [kg^-1/2 N].
        tangent : ModalTangent
            Derivative of the forces by the amplitudes.
        """

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """Derivative of the harmonic forces by the rate at which a change of the motion grows.

        Under a change ``exp(r t)`` times a periodic one, an element holds what the motion was at
        the times tau before at which sliders stopped: in the derivative of the forces each of these
        is multiplied by ``exp(-r tau)``. This is the derivative of that by r at r = 0, with r over
        a period.

        Parameters
        ----------
        basis, amplitude
            As for ``force_and_tangent``.

        Returns
        -------
        ndarray
            By the derivative of the forces [s^-2], shape (components, modes, components, modes).
            What rests for the whole period has no part in it.
        """
