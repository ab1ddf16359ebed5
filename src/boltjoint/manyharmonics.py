"""Which periodic motion is left when harmonics are no longer missing? Balance of very many.

Friction is sampled in time, and damping is one that a march in time knows as well: at the frequency
w of the excitation, the loss factor eta is the viscous damping ``C = eta L / w``. Both are the same
for the first harmonic; the harmonic h is damped h times as much.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint.balance import Forming, HarmonicBalance, parse_component
from boltjoint.coordinates import LinearModes
from boltjoint.friction.sampled import SampledInTime
from boltjoint.joint import Joint
from boltjoint.solvers.equations import StepControl
from boltjoint.solvers.newton import newton


@dataclass(frozen=True)
class ViscousBalance(HarmonicBalance):
    """``HarmonicBalance`` of sampled friction with losses ``h eta L`` in the harmonic h.

    The contact is added up in modal coordinates, not point by point: hundreds of harmonics of a few
    modes stay affordable.
    """

    def residual(self, x: NDArray[np.float64], w: float) -> NDArray[np.float64]:
        """What is left of the equations at x and w, shape of x."""
        return self.residual_and_jacobian(x, w)[0]

    def residual_and_jacobian(
        self, x: NDArray[np.float64], w: float
    ) -> tuple[NDArray[np.float64], Forming]:
        """Residual, and what forms its exact derivative by x."""
        amplitude = x.reshape(len(self.components), -1)
        force, tangent = self.joint.law.modal_force_and_tangent(self.rows, amplitude)
        linear = self.dynamic_stiffness(w)
        residual = linear @ x + force.ravel() - self.modal_force
        return residual, lambda: linear + tangent.reshape(x.size, x.size)

    @cached_property
    def _springs_and_losses(self) -> NDArray[np.float64]:
        """The linear part of the equations without inertia."""
        n, modes = len(self.components), len(self.stiffness)
        matrix = np.zeros((n, modes, n, modes))
        parts = {parse_component(name): i for i, name in enumerate(self.components)}
        for (part, harmonic), i in parts.items():
            matrix[i, :, i, :] = self.stiffness
            if part == "sin":
                cos = parts["cos", harmonic]
                matrix[i, :, cos, :] = -harmonic * self.loss_factor * self.stiffness
                matrix[cos, :, i, :] = harmonic * self.loss_factor * self.stiffness
        return matrix.reshape(n * modes, n * modes)


@dataclass(frozen=True)
class PeriodicMotion:
    """A motion of the modes by its harmonics.

    Parameters
    ----------
    components
        As a law names them: ``sin``, ``cos``, ``sin2`` and so on, ``bias`` where there is one.
    modal_coordinate
        Amplitudes of the modes [kg^1/2 m], shape (components, modes).
    converged
        Whether the equations hold.
    """

    components: tuple[str, ...]
    modal_coordinate: NDArray[np.float64]
    converged: bool = True

    def in_components(self, components: tuple[str, ...]) -> NDArray[np.float64]:
        """Amplitudes of other components, zero where there are none, (components, modes)."""
        found = dict(zip(self.components, self.modal_coordinate, strict=True))
        nothing = np.zeros(self.modal_coordinate.shape[1])
        return np.array([found.get(name, nothing) for name in components])

    def in_time(self, samples: int) -> NDArray[np.float64]:
        """The modes at equally spaced times of a period [kg^1/2 m], shape (samples, modes)."""
        phase = 2 * np.pi * np.arange(samples) / samples
        total = np.zeros((samples, self.modal_coordinate.shape[1]))
        for name, amplitude in zip(self.components, self.modal_coordinate, strict=True):
            part, harmonic = parse_component(name)
            shape = np.sin if part == "sin" else np.cos
            total += np.outer(shape(harmonic * phase), amplitude)
        return total

    def amplitude(self, mode: NDArray[np.float64]) -> complex:
        """First harmonic [m] of a point with these modes: sine coefficient + i cosine."""
        sin, cos = self.in_components(("sin", "cos")) @ mode
        return complex(sin, cos)


def solve_periodic(
    joint: Joint,
    frequency: float,
    force: float,
    loss_factor: float,
    *,
    harmonics: int,
    samples: int = 1024,
    start: PeriodicMotion | None = None,
    control: StepControl | None = None,
) -> PeriodicMotion:
    """Solve the balance of many harmonics at one frequency.

    Parameters
    ----------
    joint
        With its elements' own law, constant or variable.
    frequency, force
        Of the excitation [Hz], [N].
    loss_factor
        eta, as viscous damping [-].
    harmonics
        The highest harmonic.
    samples
        Samples a period.
    start
        A motion to start from, of any harmonics; by default that of the joint while all contact
        sticks. Few harmonics lead to more of them.
    control
        Tolerance and most iterations.
    """
    w = 2 * np.pi * frequency
    law = SampledInTime(joint.law, harmonics, samples)
    balance = ViscousBalance(replace(joint, law=law), loss_factor, force)
    if start is None:
        x = balance.stuck_solution(w)
    else:
        x = start.in_components(law.components).ravel()
    control = control or StepControl(most_iterations=50)
    solution, _ = newton(LinearModes(balance), x, w, control)
    amplitude = solution.x.reshape(len(law.components), -1)
    return PeriodicMotion(law.components, amplitude, solution.converged)
