"""Options of the continuation: step lengths, tolerances, location of peaks."""

from dataclasses import dataclass, replace

from boltjoint import checks
from boltjoint.options import Options

#: a residual below this is rounding of its terms
LEAST_TOLERANCE = 1e-15
#: a shorter step is lost in the rounding of the solution
LEAST_STEP = 1e-15
#: with a smaller scale of the frequency or amplitude a branch takes millions of steps
LEAST_SCALE = 1e-6
#: Newton's method doubles the correct digits: what has none after so many will not converge
MOST_ITERATIONS = 100
#: a branch of some thousand solutions is a finely resolved curve: so many take hours and gigabytes
MOST_SOLUTIONS = 1_000_000

# steps at corners, the same for all branches: ``arc_length`` and its compiled form take them,
# then ``tracer`` lets the step grow again. Peaks are the same with half or twice both
#: a step that turns the branch by more than a right angle is repeated at half the length, unless it
#: is as short as this: then the branch has a corner there
TURNING_STEP = 1e-3
#: longest step with which the branch is continued beyond a corner
CORNER_STEP = 1e-4


@dataclass(frozen=True)
class LaggedControl(Options):
    """Continuation in a basis that depends on the response, such as response-dependent modes.

    Where the basis only predicts solutions of the full equations, ``largest_correction`` decides
    how these are reached, and no other option counts. A lagged basis has an error that the step
    length moves, an implicit one that is not corrected one that ``tolerance`` moves: with the steps
    of the study by up to the error that the result states (``error_estimate``).

    Parameters
    ----------
    maximum_start_iterations, start_tolerance
        Iterations on the basis of the first solution, and the relative change that ends them: a
        thousandth of the tolerance of later ones, since all solutions follow from the first.
    maximum_iterations, tolerance
        Iterations on an implicit basis within a step, and the relative change of the solution, over
        the step length, that ends them: the error of a basis is of second order in it.
    maximum_iterations_at_peak, tolerance_at_peak
        The same at a peak; the tolerance of the corrector.
    smallest_relaxation, largest_relaxation
        Limits of the relaxation factor of these iterations (Aitken): no extrapolation.
    longest_secant
        Arc length between two solutions above which the second is on another branch: three times
        the largest step.
    backtracking_distance
        Arc length by which a basis update may move the branch back: a third of the largest step.
    largest_correction
        Distance of a solution of the full equations from that in the basis, over the step length,
        above which it is sought along the tangent instead.
    """

    maximum_start_iterations: int = 100
    start_tolerance: float = 1e-6
    maximum_iterations: int = 8
    tolerance: float = 0.05
    maximum_iterations_at_peak: int = 30
    tolerance_at_peak: float = 1e-9
    smallest_relaxation: float = 0.05
    largest_relaxation: float = 1.0
    longest_secant: float = 0.2
    backtracking_distance: float = 0.02
    largest_correction: float = 0.05

    def __post_init__(self) -> None:
        """Refuse options that are not positive."""
        for name, value in vars(self).items():
            checks.number(name, value, above=0)


@dataclass(frozen=True)
class StepControl(Options):
    """Tolerance of the corrector, step-length control and location of peaks.

    Parameters
    ----------
    tolerance
        Residual at which a solution is accepted, relative to the residual's scale; a residual
        within rounding of its terms is accepted too. A peak is as accurate over its damping ratio.
        At least 1e-15, which is rounding.
    first_step, smallest_step, largest_step
        Arc lengths; the first step is no longer than the largest. They decide where a branch has
        its solutions, and whether it is complete.
    target_iterations
        Corrector iterations at which the step length is kept; with fewer it grows, with more it
        shrinks.
    maximum_iterations
        Corrector iterations after which a step is retried at half the length, at most 100: Newton's
        method doubles the correct digits, and what has none by then will not converge.
    smallest_cosine
        Cosine of the angle between a step and the tangent below which the solution is rejected, as
        one of another branch: 60 degrees, far more than a branch turns in the largest step.
    maximum_solutions
        Solutions after which the continuation of a branch stops, at most a million.
    peak_tolerance
        Width within which a peak is located, over the step that it lies in: of some 1e-2 of the
        frequency or less, so that frequencies are within 1e-8.
    window_scale, parameter_scale
        Change of the frequency that counts, in arc length, as much as doubling the response: this
        part of the window, but no more than that part of the frequency itself, however wide the
        window is.
    amplitude_scale
        Change of the logarithm of a backbone's amplitude that counts as much as doubling its mode.
    curve_tolerance
        Distance of the frequency or the damping of a backbone from a straight line between two
        states, over its range, above which a state is inserted: what a drawn curve shows.
    lagged
        Options in a basis that depends on the response.

    Raises
    ------
    ValueError
        If one of them is not positive and finite or beyond its limit, iterations or solutions are
        not whole numbers, or the smallest step is not below the first one, or the smallest cosine
        not below 1.
    """

    tolerance: float = 1e-9
    first_step: float = 0.02
    smallest_step: float = 1e-9
    largest_step: float = 0.07
    target_iterations: int = 4
    maximum_iterations: int = 12
    smallest_cosine: float = 0.5
    maximum_solutions: int = 5000
    peak_tolerance: float = 1e-6
    window_scale: float = 1 / 15
    parameter_scale: float = 0.1
    amplitude_scale: float = 8.0
    curve_tolerance: float = 0.01
    lagged: LaggedControl = LaggedControl()

    def __post_init__(self) -> None:
        """Refuse options that allow no continuation."""
        checks.instance("lagged", self.lagged, LaggedControl)
        for name, value in vars(self).items():
            if name in ("target_iterations", "maximum_iterations", "maximum_solutions"):
                checks.whole(name, value, above=0)
            elif name != "lagged":
                checks.number(name, value, above=0)
        checks.number("smallest_cosine", self.smallest_cosine, below=1)
        checks.number("tolerance", self.tolerance, at_least=LEAST_TOLERANCE)
        checks.number("smallest_step", self.smallest_step, at_least=LEAST_STEP)
        for name in ("window_scale", "parameter_scale", "amplitude_scale"):
            checks.number(name, getattr(self, name), at_least=LEAST_SCALE)
        checks.whole("maximum_iterations", self.maximum_iterations, at_most=MOST_ITERATIONS)
        checks.whole("maximum_solutions", self.maximum_solutions, at_most=MOST_SOLUTIONS)
        begin = min(self.first_step, self.largest_step)
        if self.smallest_step >= begin:
            raise ValueError(
                f"smallest_step is {self.smallest_step}: it must be below the first step, {begin}"
            )

    def with_shorter_steps(self, factor: float) -> "StepControl":
        """The same with steps shorter by a factor."""
        names = "first_step", "largest_step"
        return replace(self, **{name: getattr(self, name) / factor for name in names})

    def stricter(self, tolerance: float) -> "StepControl":
        """The same with another tolerance if that is stricter, but none below rounding."""
        return replace(self, tolerance=max(min(self.tolerance, tolerance), LEAST_TOLERANCE))
