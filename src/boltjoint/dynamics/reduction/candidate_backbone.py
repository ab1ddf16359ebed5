"""Backbone of a joint in a basis of candidates, and what the basis lacks at each of its states.

The nonlinear mode solved in a basis (EPMC) leaves a residual in the candidates, and so do the
adjoint solutions of its eigenvalue. Static responses to both residuals are what the basis lacks;
their product is the dual-weighted residual, an estimate of the error of the eigenvalue.

References
----------
M. Krack: Nonlinear modal analysis of nonconservative systems: extension of the periodic motion
concept. Computers and Structures 154 (2015) 59-71.
R. Becker, R. Rannacher: An optimal control approach to a posteriori error estimation in finite
element methods. Acta Numerica 10 (2001) 1-102.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import eigh

from boltjoint.damping import Damping
from boltjoint.dynamics.backbone.backbone import Backbone, trace_backbone
from boltjoint.dynamics.backbone.epmc import EPMCEquations, ModalState
from boltjoint.dynamics.backbone.peak_force import PeakSensitivity
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.declarations import AXES
from boltjoint.friction.protocol import FrictionLaw
from boltjoint.joint.derived import merge_points
from boltjoint.joint.model import Joint
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl
from boltjoint.structure.adapted_basis.candidates import Candidates, SpringContact

Array = NDArray[np.float64]

#: of single states: corners of the law take many corrections, and errors of a thousandth of the
#: damping do not count; bases are the same with half or twice of either
_CORRECTOR = StepControl(tolerance=1e-7, maximum_iterations=40)


@dataclass(frozen=True)
class Correction:
    """A solution in candidates with what the basis lacks of it.

    Attributes
    ----------
    motion
        Bias where the law has one, sine and cosine part, shape (candidates, components).
    adjoints
        Adjoint solutions of the relative frequency and amplitude of the peak, of the same shape.
    errors
        Dual-weighted residual of either: its value in the basis less that in the candidates.
    """

    motion: Array
    adjoints: tuple[Array, Array]
    errors: Array


class CandidateBackbone:
    """A nonlinear mode of a joint in a basis of candidates.

    Parameters
    ----------
    candidates
        The candidate vectors.
    vectors
        The basis, shape (candidates, vectors).
    connect
        Makes the joint from modes of all pairs of the assembly (``modes.nc``).
    damping
        Damping of the structure; a number is a loss factor.
    resonance
        Number of the mode, from 1.
    control
        Tolerance and step lengths of the backbone.
    """

    def __init__(
        self,
        candidates: Candidates,
        vectors: Array,
        connect: Callable[[xr.Dataset], Joint],
        damping: Damping | float,
        resonance: int = 1,
        control: StepControl | None = None,
    ) -> None:
        self.candidates = candidates
        squared, turn = eigh(vectors.T @ vectors, vectors.T @ candidates.mass @ vectors)
        #: mass-normalised modes of the structure without contact in the basis
        self.modes = vectors @ turn
        self._control = StepControl() if control is None else control
        joint, self._pair = _joint_of_side(candidates, np.sqrt(squared), self.modes, connect)
        self.equations = EPMCEquations(joint, damping, resonance)

    @property
    def law(self) -> FrictionLaw:
        """Friction law of the contact points."""
        return self.equations.balance.joint.law

    @cached_property
    def _rows(self) -> tuple[Array, ...]:
        """Relative displacements of the contact points in each direction, by candidate."""
        rows = self.candidates.by_direction
        return tuple(rows[direction][self._pair] for direction in self.law.directions)

    @cached_property
    def _stuck(self) -> Array:
        """Stiffness of the contact points in stick [N/m], shape (points, directions)."""
        return self.law.stuck_stiffness(len(self._pair))

    def trace(self, lowest: float, highest: float) -> Backbone:
        """The backbone over amplitudes relative to those at which the stuck mode slips.

        Parameters
        ----------
        lowest
            First amplitude, over that at which the first point slips.
        highest
            Last amplitude, over that at which half of the points slip.
        """
        first, half = self._slip_amplitudes()
        return trace_backbone(self.equations, (lowest * first, highest * half), self._control)

    def solve_near(self, unknown: Array, log_amplitude: float) -> ModalState | None:
        """The state at an amplitude from an initial guess; None if the corrector fails."""
        solution = newton(self.equations, unknown, log_amplitude, _CORRECTOR, chords=True)[0]
        if not solution.converged:
            return None
        return ModalState(self.equations, solution.x, log_amplitude)

    def transfer(self, source: "CandidateBackbone") -> Callable[[ModalState], Array]:
        """Unknown here of a state of the same mode in another basis, projected by mass."""
        onto = self.modes.T @ (self.candidates.mass @ source.modes)
        scale = source.equations.scale / self.equations.scale

        def transferred(state: ModalState) -> Array:
            components = state.unknown[:-2].reshape(-1, onto.shape[1]) @ onto.T
            return np.append(components.ravel(), scale * state.unknown[-2:])

        return transferred

    def correct(self, state: ModalState, sensitivity: PeakSensitivity) -> Correction:
        """The motion and adjoint solutions of a state with what the basis lacks of them."""
        balance, scale = self.equations.balance, self.equations.scale
        count = len(balance.components)
        x, a = state.unknown, state.amplitude
        motion = self.modes @ x[:-2].reshape(count, -1).T
        w = 2 * np.pi * state.frequency
        force, tangent = self.law.evaluate_with_tangent(self._relative(a * motion), w)
        lacking = self._static_responses(tangent, count)

        residual = self._linear(motion, state.eigenvalue) + self._project(force / a, count)
        motion_lacking = -lacking(residual)
        # equations of the basis over their scale: adjoints of lambda in terms of the unscaled ones
        jacobian = self.equations.evaluate(x, state.log_amplitude)[1]()
        by_eigenvalue = np.zeros((x.size, 2))
        by_eigenvalue[-2:] = np.eye(2)
        solved = np.linalg.solve(jacobian.T, by_eigenvalue @ sensitivity.gradient.T).T
        inertia = self.candidates.mass @ motion[:, -2:]
        adjoints, errors = [], []
        for dual in solved:
            adjoint = self.modes @ dual[:-2].reshape(count, -1).T
            residual = self._linear(adjoint, state.eigenvalue, adjoint=True)
            through = np.einsum("pij,pi->pj", tangent, self._relative(adjoint))
            residual += self._project(through, count)
            # conditions of unit modal mass and of the phase
            residual[:, -2:] += scale * (2 * dual[-2] * inertia + dual[-1] * inertia[:, ::-1])
            adjoints.append(adjoint - lacking(residual))
            errors.append(np.sum(residual * motion_lacking))
        return Correction(motion + motion_lacking, tuple(adjoints), np.array(errors))

    def _slip_amplitudes(self) -> tuple[float, float]:
        """Amplitudes at which the first point and half of the points slip in the stuck mode.

        Where the normal load is constant an element slips as a whole at its slip force, whatever
        slips in it before; else the contact states are bisected.
        """
        joint, stuck = self.equations.balance.joint, self.equations.stuck
        if joint.normal_mode is None:
            in_plane = [abs(B @ stuck) for B in joint.contact.rows_in_plane]
            moved = in_plane[0] if len(in_plane) == 1 else np.hypot(*in_plane)
            moved = moved[joint.law.point_of_element]
            limit = joint.law.slip_force / joint.law.tangential_stiffness
            onset = np.sort((limit / np.maximum(moved, np.finfo(float).tiny))[self._loaded])
            return float(onset[0]), float(onset[onset.size // 2])
        components = np.zeros((len(self.equations.balance.components), len(stuck)))
        components[-2] = stuck
        unit = self.equations.balance.motion(components.ravel())
        frequency = np.sqrt(self.equations.scale) / (2 * np.pi)
        # of each element: at least one, as the stuck ones are counted
        reached = []
        for share in (0.0, 0.5):
            low, high = -40.0, 40.0
            for _ in range(40):
                middle = (low + high) / 2
                states = joint.law.contact_state(np.exp(middle) * unit, frequency)
                slips = states[self._loaded] > 0
                low, high = (low, middle) if slips.mean() > share else (middle, high)
            reached.append(float(np.exp(high)))
        return reached[0], reached[1]

    @cached_property
    def _loaded(self) -> NDArray[np.bool_]:
        """Elements on pairs that carry load."""
        return self.candidates.loaded[self._pair][self.law.point_of_element]

    def _relative(self, motion: Array) -> Array:
        return np.hstack([B @ motion for B in self._rows])

    def _project(self, force: Array, count: int) -> Array:
        directions = range(len(self._rows))
        of_directions = (
            self._rows[d].T @ force[:, d * count : (d + 1) * count] for d in directions
        )
        return sum(of_directions, np.zeros(()))

    def _linear(self, motion: Array, eigenvalue: complex, adjoint: bool = False) -> Array:
        """Structure with damping, less lambda times the mass, on bias, sine and cosine parts."""
        sign = -1.0 if adjoint else 1.0
        product = motion.copy()
        inertia = self.candidates.mass @ motion[:, -2:]
        turned = np.column_stack([-motion[:, -1], motion[:, -2]])
        turned_inertia = np.column_stack([-inertia[:, 1], inertia[:, 0]])
        # what the basis lacks is damped as the stuck mode is: whatever the model, that is little
        product[:, -2:] += sign * self.equations.loss * turned
        product[:, -2:] -= eigenvalue.real * inertia + sign * eigenvalue.imag * turned_inertia
        return product

    def _static_responses(self, tangent: Array, count: int) -> Callable[[Array], Array]:
        """Static responses with springs that are the mean tangent of the points.

        Springs are as stiff as in stick at most, and not negative, so that the structure is stable.
        """
        pairs = len(self.candidates.weight)
        stiffness = {direction: np.zeros(pairs) for direction in self.candidates.by_direction}
        for d, direction in enumerate(self.law.directions):
            last = (d + 1) * count
            mean = (tangent[:, last - 2, last - 2] + tangent[:, last - 1, last - 1]) / 2
            limited = np.clip(mean, 0.0, self._stuck[:, d])
            stiffness[direction][self._pair] = limited / self.candidates.weight[self._pair]
        contact = SpringContact(self.candidates, **stiffness)
        return contact.displacement


def _joint_of_side(
    candidates: Candidates, frequency: Array, modes: Array, connect: Callable[[xr.Dataset], Joint]
) -> tuple[Joint, NDArray[np.int64]]:
    """The joint on one side of the plane of symmetry, and the pair of each contact point.

    A point there carries the elements of its mirror image too. A law without closed form is
    evaluated by AFT.
    """
    relative = np.zeros((len(candidates.pair_on_side), 3, modes.shape[1]))
    for direction, B in candidates.by_direction.items():
        relative[:, "xyz".index(AXES[direction])] = (B @ modes)[candidates.pair_on_side]
    # backbones do not depend on where forces act and responses are read
    at_rest = np.zeros_like(frequency)
    whole = connect(
        xr.Dataset(
            {
                "natural_frequency": ("mode", frequency / (2 * np.pi)),
                "excitation_mode": ("mode", at_rest),
                "response_mode": ("mode", at_rest),
                "relative_mode": (("pair", "axis", "mode"), relative),
                "position": (("pair", "axis"), candidates.assembly_position),
                "free_frequency": ("free_mode", candidates.free_frequency),
                "free_participation": (
                    ("free_mode", "mode"),
                    candidates.free_participation @ modes,
                ),
            },
            coords={"axis": ["x", "y", "z"]},
        )
    )
    # points of two surfaces may lie at one position
    surface = candidates.surface[candidates.pair_on_side]
    points = zip(surface, map(tuple, candidates.assembly_position), strict=True)
    number = {point: pair for pair, point in enumerate(points)}
    on = zip(whole.surface_places.name, map(tuple, whole.position), strict=True)
    pair = candidates.pair_on_side[[number[point] for point in on]]
    kept, region = np.unique(pair, return_inverse=True)
    joint = merge_points(whole, region)
    law = joint.contact.element_law
    if not law.declaration.has_closed_form:
        joint = replace(joint, law=AlternatingFrequencyTime(law))
    return joint, kept
