"""Folds of a response over frequency: turning points, sweeps, the part with more harmonics.

Where a branch folds, several solutions belong to one frequency. A sweep follows the branch while
its frequency moves on, and at a turning point jumps to where the branch next passes that frequency
in the sense of the sweep: it shows the solutions whose frequency is the highest so far. That is a
convention: where several stable solutions lie beyond the jump, the motion before it decides which
one is reached. Which solutions are stable is found in ``dynamics.response.stability``.

With few harmonics a branch turns at other frequencies than the motion itself does, or where that
does not turn at all. From the solutions at its ends, where there is one at each frequency, the
folded part is followed by arc-length continuation of a balance with more harmonics (AFT). Where
both branches pass a frequency as often, motions with more belong to solutions with few in their
order along the branch: lower, middle and upper sheet of a fold. Elsewhere the nearest does.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.friction.aft import AlternatingFrequencyTime, elements_of
from boltjoint.solvers.arc_length import CornerTracer
from boltjoint.solvers.corrector import Corrector
from boltjoint.solvers.equations import LazyJacobian, Solution, SolutionBranch
from boltjoint.solvers.linear_solvers import LARGE
from boltjoint.solvers.newton import NewtonKrylov, newton
from boltjoint.solvers.step_control import StepControl

#: a smaller relative change of the frequency between two solutions is rounding
_ROUNDING = 1e-12


class Folds(NamedTuple):
    """Turning points of a branch, and which of its solutions sweeps show.

    ``at``: solutions at which it turns, shape (turning points,); ``frequency_range``: lowest and
    highest frequency [Hz] between which there are several solutions, NaN where the branch does not
    fold; ``on_sweep_up``, ``on_sweep_down``: shape (solutions,).
    """

    at: NDArray[np.int64]
    frequency_range: tuple[float, float]
    on_sweep_up: NDArray[np.bool_]
    on_sweep_down: NDArray[np.bool_]

    @property
    def turning_points(self) -> int:
        """How many there are."""
        return self.at.size


def find_folds(frequency: NDArray[np.float64], complete: bool = True) -> Folds:
    """Folds of a branch by the frequencies along it.

    Parameters
    ----------
    frequency
        Frequencies of the solutions in the order of the branch [Hz], shape (solutions,); the branch
        runs from low to high.
    complete
        Whether it does to the end. Else a sweep down, which would begin beyond, shows none of it.

    Raises
    ------
    ValueError
        If a frequency is not finite.
    """
    frequency = checks.array("frequency", frequency, ("solutions",))
    complete = checks.flag("complete", complete)
    change = np.diff(frequency)
    moving = np.flatnonzero(np.abs(change) > _ROUNDING * np.abs(frequency[:-1]))
    direction = np.sign(change[moving])
    at = moving[1:][direction[1:] != direction[:-1]]
    backward = np.flatnonzero(change < -_ROUNDING * np.abs(frequency[:-1]))
    folded = np.nan, np.nan
    if backward.size:
        folded = float(frequency[backward + 1].min()), float(frequency[backward].max())
    tolerance = _ROUNDING * np.abs(frequency)
    on_sweep_down = frequency <= np.minimum.accumulate(frequency[::-1])[::-1] + tolerance
    return Folds(
        at,
        folded,
        on_sweep_up=frequency >= np.maximum.accumulate(frequency) - tolerance,
        on_sweep_down=on_sweep_down & complete,
    )


Array = NDArray[np.float64]

#: margins on either side of the folded part, over its width, that are tried one after another: its
#: turning points with more harmonics may lie outside
_MARGINS = (1.0, 4.0, np.inf)

#: twice the steps of a response, whose solutions are guesses here
_CONTROL = StepControl(tolerance=1e-7, smallest_step=1e-5, largest_step=0.15)
#: a motion that opens and closes is far from that of few harmonics
_FROM_FEW = replace(_CONTROL, maximum_iterations=50)
#: time samples with which the branch is followed: enough for guesses
_FEW_SAMPLES = 256
#: evaluations with few samples after which a branch is lost among corners, three a solution where
#: it is not, and after which no more motions are sought: those of some 200
_OF_BRANCH, _IN_ALL = 1000, 5000
#: unknowns beyond which a branch takes minutes: motions are sought from the solutions alone
_MOST_UNKNOWNS = 500
#: distance of a motion from its solution, over the size of that, above which others are sought
_FAR = 0.1
#: distance of two solutions that are the same: far above the tolerance, and below that of sheets
_SAME = 1e-3


class FoldedBranch:
    """The folded part of a branch with more harmonics, and its motion at any frequency.

    Parameters
    ----------
    balance
        The modal equations with few harmonics, in linear modes.
    frequency
        Frequencies of the solutions [Hz], shape (solutions,).
    x
        Their modal coordinates, finite, shape (solutions, components * modes).
    folds
        Folds of the branch: at least one turning point.
    harmonics, samples
        Highest harmonic, and time samples of a period.
    """

    def __init__(
        self,
        balance: HarmonicBalance,
        frequency: Array,
        x: Array,
        folds: Folds,
        harmonics: int,
        samples: int,
    ) -> None:
        few_samples = min(samples, max(_FEW_SAMPLES, 2 * harmonics + 1))
        self.balance, coarse = (
            _with_harmonics(balance, harmonics, number) for number in (samples, few_samples)
        )
        self._equations, self._of_few = _Counted(self.balance), balance.components
        self._guiding = _Counted(coarse)
        self._solvers: dict[tuple[_Counted, StepControl], NewtonKrylov] = {}
        self._frequency, self._x = frequency, x
        self._whole: SolutionBranch | None = None
        self._parts = self._follow(folds)

    def motion_of(self, place: int) -> Array | None:
        """The motion that belongs to a solution, counted from 0, at the same frequency.

        Returns
        -------
        ndarray or None
            Modal coordinates of the balance with more harmonics, shape (components * modes,); None
            where no motion is known, or so many evaluations were made that no more are sought.
        """
        if self._evaluations > _IN_ALL:
            return None
        own, w = self._with_all_harmonics(self._x[place]), 2 * np.pi * self._frequency[place]

        def distance(motion: Array) -> float:
            return float(np.linalg.norm(motion - own))

        guesses = self._passing(w)
        before, of_few = self._order(place)
        if self._whole is not None and len(guesses) == of_few:
            motions = self._solve([guesses[before]], w, _CONTROL)
            if motions:
                return motions[0]
        # where the branch turns right there, both sides of the turn are near
        motions = self._solve(sorted(guesses, key=distance)[:2], w, _CONTROL)
        if min(map(distance, motions), default=np.inf) > _FAR * np.linalg.norm(own):
            # there may be a closed branch of its own near the solution
            motions += self._solve([own], w, _FROM_FEW if self._parts and not motions else _CONTROL)
        return min(motions, key=distance, default=None)

    @property
    def frequency_range(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz] between which there are several motions.

        NaN where there are none, or the part could not be followed from one end to the other.
        """
        if self._whole is None:
            return np.nan, np.nan
        w = np.array([solution.p for solution in self._whole.solutions])
        return find_folds(w / (2 * np.pi)).frequency_range

    @property
    def _evaluations(self) -> float:
        """Evaluations of the balance so far, in those with few samples."""
        return self._guiding.evaluations + self._equations.evaluations

    def _follow(self, folds: Folds) -> list[SolutionBranch]:
        """The part from one end to the other; else what there is of it from both ends."""
        parts: list[SolutionBranch] = []
        if self._with_all_harmonics(self._x[0]).size > _MOST_UNKNOWNS:
            return parts
        for ends in self._ends(folds):
            traces = []
            for begin, end in (ends, ends[::-1]):
                if not begin.converged:
                    continue
                traces.append(self._trace(begin, end.p))
                if traces[-1].complete and _are_equal(traces[-1].solutions[-1], end):
                    self._whole = traces[-1]
                    return traces[-1:]
            parts = traces or parts
            if self._evaluations > _OF_BRANCH:
                break
        return parts

    def _ends(self, folds: Folds) -> Iterator[tuple[Solution, Solution]]:
        """Motions on both sides of the part, farther and farther away from it."""
        low, high = folds.frequency_range
        first_turn, last_turn = folds.at[0], folds.at[-1]
        pairs: set[tuple[int, int]] = set()
        for margin in _MARGINS:
            width = margin * (high - low)
            before = np.flatnonzero(self._frequency[:first_turn] < low - width)
            after = last_turn + np.flatnonzero(self._frequency[last_turn:] > high + width)
            first = before[-1] if before.size else 0
            last = after[0] if after.size else last_turn + self._frequency[last_turn:].argmax()
            if (first, last) not in pairs:
                pairs.add((first, last))
                yield self._end(int(first)), self._end(int(last))

    def _end(self, place: int) -> Solution:
        """The motion at one of the solutions where there is one at its frequency."""
        guess, w = self._with_all_harmonics(self._x[place]), 2 * np.pi * self._frequency[place]
        return self._newton(self._guiding, guess, float(w), _FROM_FEW)

    def _trace(self, begin: Solution, end: float) -> SolutionBranch:
        """From a motion to a frequency [rad/s], or until it is lost among corners."""
        largest_scale = _CONTROL.window_scale * 2 * np.pi * float(np.ptp(self._frequency))
        corrector = Corrector(
            self._guiding, _CONTROL, lambda w: min(largest_scale, _CONTROL.parameter_scale * w)
        )
        branch, most = SolutionBranch(), self._evaluations + _OF_BRANCH
        tracer = CornerTracer(corrector, (begin.p, end), branch)
        if tracer.start(begin.x, begin.p):
            while tracer.advance() and self._evaluations <= most:
                pass
        return branch

    def _solve(self, guesses: Sequence[Array], w: float, control: StepControl) -> list[Array]:
        """Motions at a frequency [rad/s] near guesses, without those that are not found."""
        coarse = [self._newton(self._guiding, guess, w, control) for guess in guesses]
        solutions = [
            self._newton(self._equations, guess.x, w, _CONTROL)
            for guess in coarse
            if guess.converged
        ]
        return [solution.x for solution in solutions if solution.converged]

    def _newton(
        self, equations: "_Counted", guess: Array, w: float, control: StepControl
    ) -> Solution:
        """The solution near a guess: of many unknowns by the factors of one near it."""
        if guess.size < LARGE:
            return newton(equations, guess, w, control)[0]
        solver = self._solvers.setdefault((equations, control), NewtonKrylov(equations, control))
        return solver.solve(guess, w)

    def _order(self, place: int) -> tuple[int, int]:
        """How often the branch of few harmonics passes the frequency of a solution before it.

        And how often in all, with the solution itself.
        """
        beyond = self._frequency > self._frequency[place]
        passing = np.flatnonzero(beyond[1:] != beyond[:-1])
        others = passing[(passing != place) & (passing != place - 1)]
        return int(np.sum(others < place)), others.size + 1

    def _passing(self, w: float) -> list[Array]:
        """Motions where the parts pass a frequency [rad/s], interpolated between solutions."""
        guesses = []
        for part in self._parts:
            for one, other in pairwise(
                solution for solution in part.solutions if solution.converged
            ):
                if one.p != other.p and (one.p - w) * (other.p - w) <= 0:
                    guesses.append(one.x + (w - one.p) / (other.p - one.p) * (other.x - one.x))
        return guesses

    def _with_all_harmonics(self, x: Array) -> Array:
        """A motion of few harmonics in the components of all."""
        motion = PeriodicMotion(self._of_few, self._of_few.rows(x))
        return motion.in_components(self.balance.components).ravel()


class _Counted(BalanceEquations):
    """The equations, with the number of their evaluations: those of few samples as one."""

    def __init__(self, balance: HarmonicBalance) -> None:
        super().__init__(balance)
        law = checks.instance("law of the balance", balance.joint.law, AlternatingFrequencyTime)
        self.evaluations, self._cost = 0.0, law.samples / _FEW_SAMPLES

    def evaluate(self, x: Array, p: float, load_factor: float = 1.0) -> tuple[Array, LazyJacobian]:
        """Residual and Jacobian."""
        self.evaluations += self._cost
        return super().evaluate(x, p, load_factor)


def _with_harmonics(balance: HarmonicBalance, harmonics: int, samples: int) -> HarmonicBalance:
    """The balance by AFT of the same elements."""
    law = AlternatingFrequencyTime(elements_of(balance.joint.law), harmonics, samples)
    return replace(balance, joint=replace(balance.joint, law=law))


def _are_equal(one: Solution, other: Solution) -> bool:
    """Whether two solutions at a frequency are the same, not those of two sheets of a fold."""
    distance = np.linalg.norm(one.x - other.x)
    return other.converged and bool(distance <= _SAME * np.linalg.norm(other.x))
