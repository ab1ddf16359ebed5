"""Dashpots at contact points: viscous forces along the first tangent, beside other forms.

A dashpot of the damping d has the force ``d u'``, in the harmonic h of a motion of the frequency w
``i h w d u_h``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.forms import AtSamples, ClosedForm, InTime, Period
from boltjoint.friction.protocol import HarmonicBasis, ModalElements, ModalTangent
from boltjoint.harmonics import Components, phase_derivative

Array = NDArray[np.float64]

#: in which time integration has its forces
_IN_TIME = Components.up_to(1)


@dataclass(frozen=True)
class Dashpots:
    """Dashpots between the two sides of contact points.

    Parameters
    ----------
    element
        The element of the law each belongs to, counted from 0, shape (dashpots,).
    point
        The contact point each acts on, counted from 0, shape (dashpots,).
    damping
        Damping of each [N s/m], shape (dashpots,).
    """

    element: NDArray[np.int64]
    point: NDArray[np.int64]
    damping: Array

    def at_points(self, points: int) -> Array:
        """Damping of each point along the first tangent [N s/m], shape (points,)."""
        return np.asarray(np.bincount(self.point, self.damping, minlength=points), dtype=np.float64)

    def force(self, motion: Array, w: float, components: Components) -> Array:
        """Harmonic forces on the points, shape of the motion.

        Parameters
        ----------
        motion
            As for ``FrictionLaw.force``.
        w
            The frequency [rad/s].
        components
            Components of motion and force in each direction.
        """
        force, own = np.zeros_like(motion), slice(len(components))
        d = self.at_points(len(motion))
        force[:, own] = w * d[:, None] * (motion[:, own] @ components.phase_derivative.T)
        return force

    def add_tangent(self, w: float, components: Components, tangent: Array) -> None:
        """Add the tangents of the points, unless their array is empty."""
        if tangent.size:
            d, own = self.at_points(len(tangent)), slice(len(components))
            tangent[:, own, own] += w * d[:, None, None] * components.phase_derivative


@dataclass(frozen=True)
class ClosedFormWithDashpots(ClosedForm):
    """A closed form and dashpots beside it.

    Parameters
    ----------
    form
        Form of the elements without dashpots.
    dashpots
        Beside them.
    components
        Harmonic coefficients of the law.
    """

    form: ClosedForm
    dashpots: Dashpots
    components: Components

    def evaluate(self, motion: Array, w: float) -> Array:
        """As of ``ClosedForm``."""
        force = self.form.evaluate(motion, w)
        return force + self.dashpots.force(motion, w, self.components)

    def evaluate_with_tangent(self, motion: Array, w: float) -> tuple[Array, Array]:
        """As of ``ClosedForm``."""
        force, tangent = self.form.evaluate_with_tangent(motion, w)
        self.dashpots.add_tangent(w, self.components, tangent)
        return force + self.dashpots.force(motion, w, self.components), tangent

    def frequency_derivative(self, motion: Array, w: float) -> Array:
        """As of ``ClosedForm``."""
        return self.dashpots.force(motion, 1.0, self.components)

    def states(self, motion: Array, w: float) -> NDArray[np.int8]:
        """As of ``ClosedForm``."""
        return self.form.states(motion, w)


@dataclass(frozen=True)
class SamplesWithDashpots(AtSamples):
    """Forces by samples and dashpots beside them.

    Parameters
    ----------
    form
        Form of the elements without dashpots.
    dashpots
        Beside them.
    """

    form: AtSamples
    dashpots: Dashpots

    def evaluate(self, motion: Array, period: Period, tangent: Array) -> Array:
        """As of ``AtSamples``."""
        force = self.form.evaluate(motion, period, tangent)
        self.dashpots.add_tangent(period.frequency, period.components, tangent)
        return force + self.dashpots.force(motion, period.frequency, period.components)

    def frequency_derivative(self, motion: Array, period: Period) -> Array:
        """As of ``AtSamples``."""
        return self.dashpots.force(motion, 1.0, period.components)

    def in_modes(self, rows: Sequence[Array], w: float) -> ModalElements | None:
        """As of ``AtSamples``."""
        elements = self.form.in_modes(rows, w)
        if elements is None:
            return None
        d = self.dashpots.at_points(len(rows[0]))
        return _ModalWithDashpots(elements, rows[0].T @ (d[:, None] * rows[0]), w)

    def states(self, displacement: Array, w: float) -> NDArray[np.int8]:
        """As of ``AtSamples``."""
        return self.form.states(displacement, w)


@dataclass(frozen=True)
class TimeWithDashpots(InTime):
    """Forces in time and dashpots beside them.

    Parameters
    ----------
    form
        Form of the elements without dashpots.
    dashpots
        Beside them.
    """

    form: InTime
    dashpots: Dashpots

    def evaluate(self, motion: Array, w: float, samples: int) -> Array:
        """As of ``InTime``; the velocity is that of differences of the displacements in time."""
        force, d = self.form.evaluate(motion, w, samples), self.dashpots.at_points(len(motion))
        table = _IN_TIME.at_samples(samples)
        displacement = motion[:, :3] @ table
        step = 2 * np.pi / (w * samples) if w > 0 else np.inf
        # a harmonic motion has this one over its central difference
        exact = 2 * np.pi / samples / np.sin(2 * np.pi / samples)
        change = np.roll(displacement, -1, axis=1) - np.roll(displacement, 1, axis=1)
        viscous = d[:, None] * change * exact / (2 * step)
        force[:, :3] += viscous @ table.T * [1 / samples, 2 / samples, 2 / samples]
        return force


class _ModalWithDashpots(NamedTuple):
    """As ``ModalElements``, with dashpots.

    ``damping`` of the modes has the shape (modes, modes) [1/s]; ``w`` is the frequency.
    """

    elements: ModalElements
    damping: Array
    w: float

    def force_and_tangent(
        self, basis: HarmonicBasis, amplitude: Array
    ) -> tuple[Array, "_TangentWithDashpots"]:
        """As ``ModalElements.force_and_tangent``."""
        force, tangent = self.elements.force_and_tangent(basis, amplitude)
        turn = self.w * phase_derivative(basis.harmonic, basis.is_sine)
        viscous = turn @ amplitude @ self.damping
        return force + viscous, _TangentWithDashpots(tangent, turn, self.damping)

    def delay(self, basis: HarmonicBasis, amplitude: Array) -> Array:
        """As ``ModalElements.delay``; a growing change has a velocity of its own."""
        count = len(basis.weight)
        own = self.w / (2 * np.pi) * np.einsum("ij,rs->irjs", np.eye(count), self.damping)
        return self.elements.delay(basis, amplitude) + own


class _TangentWithDashpots(NamedTuple):
    """As ``ModalTangent``, with dashpots."""

    tangent: ModalTangent
    turn: Array
    damping: Array

    def __call__(self, precision: type[np.floating] = np.float64) -> Array:
        """As ``ModalTangent``."""
        tangent = self.tangent(precision)
        tangent += np.einsum("ij,rs->irjs", self.turn, self.damping)
        return tangent

    def along(self, change: Array) -> Array:
        """As ``ModalTangent.along``."""
        return self.tangent.along(change) + self.turn @ change @ self.damping
