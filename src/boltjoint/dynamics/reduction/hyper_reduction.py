"""Hyper-reduction of the contact: a few pairs, with weights, stand for all.

Energy-conserving sampling and weighting (ECSW): weights that are not negative, most of them zero,
with which the pairs do the same work as all of them in motions that are known. Here these are the
states of backbones, and the work is that of the pairs' forces on the modes; what it changes of the
peak that each state stands for counts by the tolerances of peaks. A weighted pair has its stiffness
and slip force times the weight, so it slips at the same displacement: passivity and the first slip
of each pair that is kept are those of the whole joint.

References
----------
C. Farhat, P. Avery, T. Chapman, J. Cortial: Dimensional reduction of nonlinear finite element
dynamic models with finite rotations and energy-based mesh sampling and weighting for computational
efficiency. International Journal for Numerical Methods in Engineering 98 (2014) 625-662.
C. Farhat, T. Chapman, P. Avery: Structure-preserving, stability, and accuracy properties of the
energy-conserving sampling and weighting method for the hyper reduction of nonlinear finite element
dynamic models. International Journal for Numerical Methods in Engineering 102 (2015) 1077-1110.
A. A. Morsy, M. Kast, P. Tiso: A frequency-domain model order reduction for joints by hyperreduction
and model derivatives. Nonlinear Dynamics 108 (2022).
C. L. Lawson, R. J. Hanson: Solving Least Squares Problems. SIAM, 1995: chapter 23.
"""

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.numerical_options import HyperReduction
from boltjoint.damping import Damping
from boltjoint.dataset import quantity
from boltjoint.dynamics.backbone.backbone import Backbone, trace_for_forces
from boltjoint.dynamics.backbone.epmc import EPMCEquations, ModalState
from boltjoint.dynamics.backbone.peak_force import PeakSensitivity, peak_sensitivities
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.model import Joint, count_alike, keep_elements
from boltjoint.options import Options
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: tolerances that a study has unless it says otherwise
_OF_STUDY = HyperReduction()


@dataclass(frozen=True)
class HyperReductionOptions(Options):
    """Numerical options of the weights of contact pairs.

    Parameters
    ----------
    force_tolerance
        Error of the modal forces of a state, relative to those of all pairs with the contact stuck,
        that counts as much as the tolerances of its peak. It moves peaks in the second order only:
        without it weights hold peaks at the states alone, and need about as many pairs.
    smallest_growth
        Derivative of the logarithm of the force by that of the amplitude, below which the amplitude
        of a peak at a force has no limit of accuracy, as of contact-adapted bases.
    divisions
        Parts of every interval between two states of the backbone: every other state of all makes
        the weights, and all show the errors. Each pair that slips leaves a trace in the damping
        over the amplitude, between states that are too far apart for it.
    safety
        Factor of the errors at these states: those between them were at most 1.3 times as large, in
        joints of some hundred pairs.
    first_trial, trial_growth
        Number of pairs whose errors are estimated first, and the growth of that number until they
        are within the tolerances: a trial costs about as much as one response.
    corrector_tolerance
        Residual at which the states of the weighted pairs are solved: errors of a thousandth of the
        damping do not count.
    corrector_iterations
        After which a state is not found.
    """

    force_tolerance: float = 0.02
    smallest_growth: float = 0.04
    divisions: int = 4
    safety: float = 1.5
    first_trial: int = 20
    trial_growth: float = 1.15
    corrector_tolerance: float = 1e-7
    corrector_iterations: int = 40


class HeldPeaks(NamedTuple):
    """A joint whose peaks weights hold; forces and damping as for ``weigh_pairs``."""

    joint: Joint
    forces: Sequence[float]
    damping: Damping | float


def weigh_pairs(
    joint: Joint,
    forces: Sequence[float],
    damping: Damping | float,
    *,
    count: int | None = None,
    frequency_tolerance: float = _OF_STUDY.frequency_tolerance,
    amplitude_tolerance: float = _OF_STUDY.amplitude_tolerance,
    windows: Mapping[int, tuple[float, float] | None] = MappingProxyType({1: None}),
    control: StepControl | None = None,
    options: HyperReductionOptions = HyperReductionOptions(),
    others: Sequence[HeldPeaks] = (),
) -> tuple[Joint, xr.Dataset]:
    """A few pairs of a joint, with weights that hold its peaks.

    Parameters
    ----------
    joint
        Node to node, or any other.
    forces
        Amplitudes of the excitation [N], or accelerations of the supports [m/s2]: the peaks are
        held under all from the smallest to the largest.
    damping
        Damping of the structure; a number is a loss factor.
    count
        Pairs to keep; None for the fewest with which no peak is estimated to have larger errors
        than the tolerances.
    frequency_tolerance, amplitude_tolerance
        Relative errors of a peak.
    windows
        By the number of each resonance whose peaks are held, from 1, the frequencies [Hz] around
        it, or None for those of ``frequency_window``.
    control
        Step-length control of the backbones.
    options
        Numerical options.
    others
        Peaks that the weights hold too: of joints with the same pairs, but other coefficients, as
        the designs of a sweep, with windows of their own. One without a backbone is left out, with
        a warning.

    Returns
    -------
    joint : Joint
        Of the points that are kept.
    fit : Dataset
        ``weight`` (point) of each point; ``estimated_frequency_error`` and
        ``estimated_amplitude_error``, the largest relative errors of peaks.

    Raises
    ------
    ValueError
        If there are fewer points than ``count``, a tolerance is not positive, there is no
        resonance, a backbone has fewer than three states, or another joint has other pairs.
    RuntimeError
        If no number of pairs is within the tolerances.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law", joint.law, ElementLaw)
    tolerances = np.array(
        [
            checks.number("frequency_tolerance", frequency_tolerance, above=0),
            checks.number("amplitude_tolerance", amplitude_tolerance, above=0),
        ]
    )
    if count is not None and checks.whole("count", count, at_least=1) > joint.points:
        raise ValueError(f"count is {count}, but the joint has {joint.points} points")
    control = StepControl() if control is None else control
    checks.instance("options", options, HyperReductionOptions)
    checks.instance("windows", windows, Mapping)
    checks.sequence("others", others, HeldPeaks)
    alike = count_alike(joint)
    for place, other in enumerate(others):
        checks.instance(f"joint of others[{place}]", other.joint, Joint)
        if not np.array_equal(other.joint.law.point_of_element, joint.law.point_of_element):
            raise ValueError(f"joint of others[{place}] has other pairs")
        if not np.array_equal(count_alike(other.joint), alike):
            alike = np.ones(alike.shape)
    joint, weight = keep_elements(joint, alike), alike
    alike, on = alike[alike > 0], joint.law.point_of_element
    traced = [
        _trace(HeldPeaks(joint, forces, damping), resonance, window, control, options)
        for resonance, window in windows.items()
    ]
    for place, other in enumerate(others):
        same = other._replace(joint=keep_elements(other.joint, weight))
        try:
            traced += [_trace(same, resonance, None, control, options) for resonance in windows]
        except (ValueError, ArithmeticError) as error:
            logger.warning("weights are not made for others[%d]: %s", place, error)
    if not traced:
        raise ValueError("windows are empty: pairs are weighted for the peaks of a resonance")
    search = _Weights(
        row for backbone in traced for row in backbone.rows(tolerances, options.force_tolerance)
    )
    kept, errors = _grown(search, joint, traced, count, tolerances, options)
    weight = search.weight * np.bincount(on, alike) / np.bincount(on)
    return kept, _to_dataset(weight[weight > 0], errors, options)


def _to_dataset(weight: Array, errors: Array, options: HyperReductionOptions) -> xr.Dataset:
    """Weights of the pairs and estimated errors of frequency and amplitude of the peaks."""
    about = "largest relative error of peak {}, estimated on the backbones it is made for"
    return xr.Dataset(
        {
            "weight": quantity("point", weight, "1", "pairs that each pair stands for"),
            "estimated_frequency_error": quantity((), errors[0], "1", about.format("frequencies")),
            "estimated_amplitude_error": quantity((), errors[1], "1", about.format("amplitudes")),
        },
        attrs={"options": options.stored()},
    )


def _grown(
    search: "_Weights",
    joint: Joint,
    traced: Sequence["_TracedBackbone"],
    count: int | None,
    tolerances: Array,
    options: HyperReductionOptions,
) -> tuple[Joint, Array]:
    """The joint of as many pairs as the tolerances or the count ask for, and errors of peaks."""
    trial, in_order = float(options.first_trial if count is None else count), list(traced)
    while True:
        is_within = search.grow(round(trial))
        weight, errors = search.weight[joint.law.point_of_element], np.zeros(2)
        points = np.count_nonzero(search.weight)
        for place, backbone in enumerate(in_order):
            errors = np.maximum(errors, options.safety * backbone.errors(weight))
            if count is None and np.any(errors > tolerances):
                # what is off by more than the tolerances comes first the next time
                in_order.insert(0, in_order.pop(place))
                break
        logger.info("%d pairs: errors of peaks %.1e and %.1e", points, *errors)
        if count is not None or np.all(errors <= tolerances):
            return keep_elements(joint, weight), errors
        if not is_within:
            raise RuntimeError(
                f"{points} pairs hold the forces as well as all {joint.points}, but peaks "
                f"still have errors of {errors[0]:.2g} and {errors[1]:.2g}: allow larger ones"
            )
        trial = max(trial + 1, options.trial_growth * trial)


@dataclass(frozen=True)
class _TracedBackbone:
    """States of a backbone with the sensitivity of the peak at each.

    Weights are found from every other state; those between show errors that they were not made for.
    """

    equations: EPMCEquations
    states: tuple[ModalState, ...]
    sensitivities: tuple[PeakSensitivity, ...]
    options: HyperReductionOptions

    def rows(self, tolerances: Array, force_tolerance: float) -> Iterator[Array]:
        """What each point contributes to each state: to errors of its peak, and to modal forces.

        Relative to their tolerances, shape (rows, points).
        """
        equations = self.equations
        balance, joint = equations.balance, equations.balance.joint
        count, modes = len(balance.components), len(equations.stuck)
        # modal forces by their strain energy with the contact stuck
        scale = np.sqrt(np.diag(balance.stiffness + joint.stuck_stiffness()))
        every_other = zip(self.states[::2], self.sensitivities[::2], strict=True)
        for state, sensitivity in every_other:
            a, phi = state.amplitude, state.mode
            w = 2 * np.pi * state.frequency
            force = joint.law.evaluate(balance.motion(a * state.unknown[:-2]), w)
            modal = np.zeros((count, modes, joint.points))
            for d, rows in enumerate(joint.rows):
                modal += force[:, d * count : (d + 1) * count].T[:, None] * rows.T
            change = (phi @ (modal[-2] + 1j * modal[-1])) / (a * (phi @ phi))
            of_peak = sensitivity.gradient @ np.stack([change.real, change.imag])
            yield of_peak / tolerances[:, None]
            size = a * np.sqrt(state.eigenvalue.real) * force_tolerance
            yield (modal / (scale[:, None] * size)).reshape(-1, joint.points)

    def errors(self, weight: Array) -> Array:
        """Largest relative errors of frequency and amplitude of the peaks with weighted elements.

        Infinite where more than a tenth of the states are not found.
        """
        whole = self.equations
        joint = keep_elements(whole.balance.joint, weight)
        equations = EPMCEquations(joint, whole.balance.damping, whole.resonance)
        control = StepControl(
            tolerance=self.options.corrector_tolerance,
            maximum_iterations=self.options.corrector_iterations,
        )
        scale = np.append(np.ones(equations.start().size - 2), [whole.scale / equations.scale] * 2)
        largest, missing = np.zeros(2), 0
        difference = np.zeros(scale.size)
        for state, sensitivity in zip(self.states, self.sensitivities, strict=True):
            guess = scale * state.unknown
            # a state differs about as much as the one before
            solution = newton(
                equations, guess + difference, state.log_amplitude, control, chords=True
            )[0]
            if not solution.converged:
                missing += 1
                continue
            difference = solution.x - guess
            change = ModalState(equations, solution.x, state.log_amplitude).eigenvalue
            change -= state.eigenvalue
            error = sensitivity.gradient @ [change.real, change.imag]
            largest = np.maximum(largest, abs(error))
        allowed = 0.1 * len(self.states)
        return largest if missing <= allowed else np.full(2, np.inf)


def _trace(
    held: HeldPeaks,
    resonance: int,
    window: tuple[float, float] | None,
    control: StepControl,
    options: HyperReductionOptions,
) -> _TracedBackbone:
    joint, forces, damping = held
    window = frequency_window(joint, resonance=resonance) if window is None else window
    backbone = trace_for_forces(
        joint, forces, damping=damping, window=window, resonance=resonance, control=control
    )
    if len(backbone.states) < 3:
        raise ValueError(
            f"the backbone of resonance {resonance} ends after {len(backbone.states)} states: "
            f"{backbone.reason}"
        )
    if not backbone.complete:
        logger.warning("a backbone does not cover all forces: %s", backbone.reason)
    states = tuple(_divided(backbone, options.divisions))
    sensitivities = peak_sensitivities(states, options.smallest_growth)
    return _TracedBackbone(backbone.equations, states, sensitivities, options)


def _divided(backbone: Backbone, divisions: int) -> Iterator[ModalState]:
    """The states, and others between every two of them at equal steps of the log amplitude."""
    for first, second in pairwise(backbone.states):
        yield first
        for i in range(1, divisions):
            state = backbone.solve_between(first, second, i / divisions)
            if state is not None:
                yield state
    yield backbone.states[-1]


class _Weights:
    """Weights by which columns of a matrix add up to the sum of all: non-negative least squares.

    The active-set method of Lawson and Hanson, which adds one column after another, stopped at a
    number of columns. The matrix is given by some rows after others.
    """

    def __init__(self, rows: Iterable[Array]) -> None:
        # all rows at once would take more memory than all else
        self._product = sum((some.T @ some for some in rows), np.zeros(()))
        self._target = self._product.sum(axis=1)
        #: of each column
        self.weight = np.zeros(self._target.size)
        self._active = np.zeros(self._target.size, dtype=bool)
        # the product has lost what is smaller
        self._smallest = np.finfo(float).eps * np.trace(self._product)

    def grow(self, count: int) -> bool:
        """Add columns up to a number of them; whether there is one that reduces the residual."""
        while np.count_nonzero(self._active) < count:
            gain = self._target - self._product @ self.weight
            gain[self._active] = -np.inf
            best = int(np.argmax(gain))
            if gain[best] <= self._smallest:
                return False
            self._active[best] = True
            self._solve()
        return True

    def _solve(self) -> None:
        """Least squares of the active columns, without those that would become negative."""
        while True:
            active = np.flatnonzero(self._active)
            product = self._product[np.ix_(active, active)]
            product = product + self._smallest * np.eye(active.size)
            solution = np.linalg.solve(product, self._target[active])
            weight = self.weight[active]
            negative = solution <= 0
            if not negative.any():
                self.weight[active] = solution
                return
            step = np.min(weight[negative] / (weight[negative] - solution[negative]))
            weight = weight + step * (solution - weight)
            removed = negative & (weight <= np.finfo(float).eps * weight.max())
            # at least one column reaches zero, whatever rounding says
            removed[np.flatnonzero(negative)[np.argmin(weight[negative])]] = True
            self.weight[active] = np.where(removed, 0.0, weight)
            self._active[active[removed]] = False
