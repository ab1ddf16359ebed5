"""Which periodic motion is left when harmonics are no longer missing? Balance of very many.

Friction is sampled in time, and damping is one that a march in time knows as well: at the frequency
w of the excitation, the loss factor eta is the viscous damping ``C = eta L / w``. Both are the same
for the first harmonic; the harmonic h is damped h times as much.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
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

    Raises
    ------
    ValueError
        If there is not a row for each component.
    """

    components: tuple[str, ...]
    modal_coordinate: NDArray[np.float64]
    converged: bool = True

    def __post_init__(self) -> None:
        """Refuse amplitudes that do not fit the components; not converged, they may be anything."""
        shape = len(self.components), "modes"
        found = checks.array("modal_coordinate", self.modal_coordinate, shape, finite=False)
        object.__setattr__(self, "modal_coordinate", found)

    def in_components(self, components: tuple[str, ...]) -> NDArray[np.float64]:
        """Amplitudes of other components, zero where there are none, (components, modes)."""
        found = dict(zip(self.components, self.modal_coordinate, strict=True))
        nothing = np.zeros(self.modal_coordinate.shape[1])
        return np.array([found.get(name, nothing) for name in components])

    def in_time(self, samples: int) -> NDArray[np.float64]:
        """The modes at equally spaced times of a period [kg^1/2 m], shape (samples, modes)."""
        samples = checks.whole("samples", samples, at_least=1)
        phase = 2 * np.pi * np.arange(samples) / samples
        total = np.zeros((samples, self.modal_coordinate.shape[1]))
        for name, amplitude in zip(self.components, self.modal_coordinate, strict=True):
            part, harmonic = parse_component(name)
            shape = np.sin if part == "sin" else np.cos
            total += np.outer(shape(harmonic * phase), amplitude)
        return total

    def amplitude(self, mode: NDArray[np.float64]) -> complex:
        """First harmonic [m] of a point with these modes: sine coefficient + i cosine."""
        mode = checks.array("mode", mode, self.modal_coordinate.shape[1:])
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

    Raises
    ------
    ValueError
        If the friction of the joint is sampled already, there are too few samples for the
        harmonics, the start is of another joint, or a number is out of range.
    """
    checks.instance("joint", joint, Joint)
    frequency = checks.number("frequency", frequency, above=0)
    force = checks.number("force", force, above=0)
    control = StepControl(most_iterations=50) if control is None else control
    checks.instance("control", control, StepControl)
    w = 2 * np.pi * frequency
    law = SampledInTime(joint.law, harmonics, samples)
    balance = ViscousBalance(replace(joint, law=law), loss_factor, force)
    if start is None:
        x = balance.stuck_solution(w)
    else:
        checks.instance("start", start, PeriodicMotion)
        shape = "components", joint.natural_frequency.size
        x = checks.array("start", start.in_components(law.components), shape).ravel()
    solution, _ = newton(LinearModes(balance), x, w, control)
    amplitude = solution.x.reshape(len(law.components), -1)
    return PeriodicMotion(law.components, amplitude, solution.converged)
