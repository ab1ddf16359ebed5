"""Solver of the harmonic balance: friction force, harmonics, basis update and continuation."""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, StrictBool, Tag

from boltjoint.config.entries import Entry
from boltjoint.config.types import INTEGRAL, Count, Fraction, Number, Positive, Problems
from boltjoint.solvers.equations import (
    LEAST_STEP,
    LEAST_TOLERANCE,
    MOST_ITERATIONS,
    MOST_SOLUTIONS,
    StepControl,
)

#: with fewer time samples for each harmonic AFT cannot tell the harmonics of a force apart
LEAST_SAMPLES = 8
#: frequencies of peaks move less than amplitudes
_OF_FREQUENCY = 0.1


Harmonics = Annotated[
    Annotated[Count, Tag("number")] | Annotated[Literal["auto"], Tag("auto")],
    Discriminator(
        lambda value: (
            "number" if isinstance(value, int | float) else "auto" if value == "auto" else None
        ),
        custom_error_type="no_values",
        custom_error_message="must be a whole number or auto",
    ),
]


class Solver(Entry):
    """Solution of the harmonic balance and arc-length continuation over frequency."""

    friction_force: Literal["analytic", "aft"] = "analytic"
    """Forces of the friction elements: analytic describing functions of one harmonic, or AFT
    (alternating frequency/time) with any number of harmonics."""
    harmonics: Harmonics = 1
    """Number of harmonics of the response; under constant load the odd ones up to it, since no
    others arise. Must be 1 with ``friction_force: analytic``, and with ``complex-rdnm-N``. With
    ``auto`` each response has as many as its peak needs, up to 33: not for ``backbone``, sweeps and
    timing."""
    harmonic_tolerance: Fraction = 0.005
    """Relative change of the amplitude of a peak by more harmonics, and ten times that of its
    frequency, below which there are enough: for ``harmonics: auto`` and ``converged_peaks``."""
    time_samples: Annotated[int, Field(strict=True, ge=LEAST_SAMPLES), INTEGRAL] = 256
    """Time samples of a period with ``friction_force: aft``, at least 8 for each harmonic. The
    error of the forces falls with their square."""
    jacobian: Literal["analytic", "forward-difference"] = "analytic"
    """Derivatives of the residual: analytic, or forward differences as in the source study."""
    basis_update: Literal["implicit", "lagged"] = "implicit"
    """Response-dependent modes: implicit, those of the solution itself (self-consistent RDNM);
    lagged, updated once a solution, as in the source study, where some branches are not complete.
    Modes of ``rdnm-N`` with ``jacobian: forward-difference`` are always lagged."""
    quasi_static_correction: StrictBool = True
    """Whether ``complex-rdnm-N`` adds the quasi-static response of the residual modes."""
    tolerance: Annotated[Number, Field(ge=LEAST_TOLERANCE, lt=1)] = StepControl.tolerance
    """Residual at which a solution is accepted, relative to the modal force: at least 1e-15, since
    less is rounding."""
    largest_step: Positive = StepControl.largest_step
    """Largest arc length of a step: relative change of the response."""
    smallest_step: Annotated[Number, Field(ge=LEAST_STEP, lt=StepControl.first_step)] = (
        StepControl.smallest_step
    )
    """Smallest arc length of a step, below ``largest_step`` and the first step of 0.02: a branch
    that needs a shorter one ends there and is marked incomplete. Close natural frequencies need
    short steps; one below 1e-15 is lost in rounding."""
    target_iterations: Count = StepControl.target_iterations
    """Newton iterations for each solution at which the step-length control aims, below
    ``maximum_iterations``."""
    maximum_iterations: Annotated[int, Field(strict=True, ge=2, le=MOST_ITERATIONS), INTEGRAL] = (
        StepControl.maximum_iterations
    )
    """Newton iterations after which a step is repeated at half the length, at most 100: each
    doubles the correct digits, and a solution that has none by then will not converge."""
    maximum_solutions: Annotated[int, Field(strict=True, ge=1, le=MOST_SOLUTIONS), INTEGRAL] = (
        StepControl.maximum_solutions
    )
    """Solutions after which a branch ends and is marked incomplete, at most a million: branches
    have some hundred, and so many take hours and gigabytes."""
    largest_error: Positive = 0.05
    """Estimated relative error of a peak in coordinates other than ``linear`` above which a warning
    is given; elsewhere on the branch, ten times as much of the peak."""
    fallback: Literal["none", "linear"] = "none"
    """What replaces a response with such an error, or an incomplete one: nothing, or the response
    in linear modes. Its time in the tables stays that of the coordinates asked for."""

    @property
    def steps(self) -> dict[str, float]:
        """The options of ``solvers.equations.StepControl``."""
        return self.model_dump(include=set(StepControl.__dataclass_fields__))

    @property
    def sampling(self) -> dict[str, int | str] | None:
        """Harmonics, or auto, and time samples of AFT; None with analytic friction forces."""
        if self.friction_force == "analytic":
            return None
        return {"harmonics": self.harmonics, "samples": self.time_samples}

    @property
    def harmonic_convergence(self) -> dict[str, float]:
        """Options of ``dynamics.response.peak_sequence.HarmonicConvergence``."""
        amplitude = self.harmonic_tolerance
        return {
            "amplitude_tolerance": amplitude,
            "frequency_tolerance": _OF_FREQUENCY * amplitude,
            "samples": self.time_samples,
        }

    def conflicts(self) -> Problems:
        if self.friction_force == "analytic" and self.harmonics != 1:
            sentence = "must be 1 with friction_force: analytic; more need friction_force: aft"
            yield ("harmonics",), sentence
        elif self.harmonics != "auto" and self.time_samples < (
            least := LEAST_SAMPLES * self.harmonics
        ):
            yield ("time_samples",), f"must be at least {least}, {LEAST_SAMPLES} for each harmonic"
        if self.smallest_step >= self.largest_step:
            yield ("smallest_step",), f"must be less than largest_step, {self.largest_step:g}"
        if self.target_iterations >= self.maximum_iterations:
            sentence = f"must be less than maximum_iterations, {self.maximum_iterations}"
            yield ("target_iterations",), sentence
