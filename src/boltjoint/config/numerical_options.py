"""Settings of a study: the cases that run, and the numerical options, those of the solver first."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, StrictBool, Tag

from boltjoint.config.entries import Entry
from boltjoint.config.types import (
    INTEGRAL,
    CaseName,
    ComparedModalBasis,
    Count,
    Distinct,
    Fraction,
    Joint,
    ModesCount,
    Name,
    Number,
    Positive,
    Problems,
    Several,
)
from boltjoint.names import REDUCTIONS, REFERENCE, JointName
from boltjoint.solvers.step_control import (
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
    """Response-dependent modes: implicit, those of the solution itself (self-consistent RDNM), with
    complex ones corrected in all linear modes; lagged, updated once a solution, as in the source
    study, where some branches are not complete. Modes of ``rdnm-N`` with ``jacobian:
    forward-difference`` are always lagged."""
    quasi_static_correction: StrictBool = True
    """Whether ``complex-rdnm-N`` adds the quasi-static response of the residual modes; without it
    solutions are not corrected in all linear modes."""
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
        """The options of ``solvers.step_control.StepControl``."""
        return self.model_dump(include=set(StepControl.__dataclass_fields__))

    @property
    def sampling(self) -> dict[str, int | str] | None:
        """Harmonics, or auto, and time samples of AFT; None with analytic friction forces."""
        if self.friction_force == "analytic":
            return None
        return {"harmonics": self.harmonics, "samples": self.time_samples}

    @property
    def harmonic_convergence(self) -> dict[str, float]:
        """Options of ``dynamics.response.harmonic_convergence.HarmonicConvergence``."""
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


class ContactAdaptedBasis(Entry):
    """Accuracy and numerical options of the bases ``enriched-N`` and ``enriched-auto``.

    One basis of each size serves all cases of an assembly: it is made for the contact and damping
    of each of them, and for those of all cases where none uses the assembly. A case that is added
    with another contact or damping therefore makes new bases.
    """

    frequency_tolerance: Fraction = 1e-3
    """Relative error of the frequency of a peak. ``enriched-auto`` has the fewest vectors with
    which no peak of the first resonance is estimated to have a larger one."""
    amplitude_tolerance: Fraction = 1e-2
    """The same of its amplitude."""
    pattern_tolerance: Fraction = 2e-3
    """Relative error of resonances while a part of the contact sticks, against which that of peaks
    is weighed."""
    resonances: ModesCount = 2
    """Resonances whose motion the bases hold, from the first; at most ``free_modes``."""
    free_modes: ModesCount = 12
    """Modes without contact among the candidates."""
    maximum_vectors: ModesCount = 128
    """Vectors of the largest basis; ``enriched-N`` has the first N of them."""
    balanced_vectors: ModesCount = 40
    """Vectors with which all errors are made equally small, or ``maximum_vectors`` if fewer."""
    states: Count = 24
    """States of each backbone from which the basis is made."""
    adaptations: Count = 6
    """Bases that are each made from the errors of the one before, at most: no more are made once
    the dual-weighted residuals of all vectors are within the tolerances."""
    trial_step: Count = 8
    """Step of the numbers of vectors whose errors are estimated."""
    lowest_amplitude: Positive = 1.0
    """Amplitude at which backbones begin, over that at which the first pair slips."""
    highest_amplitude: Positive = 300.0
    """Amplitude at which they end, over that at which half of the pairs slip: all slip there."""
    smallest_growth: Fraction = 0.04
    """Smallest derivative of the logarithm of the force by that of the amplitude of its peak. Where
    it is less, near a fold of the peaks, the amplitude at a force has no limit of accuracy."""

    def conflicts(self) -> Problems:
        if self.resonances > self.free_modes:
            yield ("resonances",), f"must be at most free_modes, {self.free_modes}"


class Fitting(Entry):
    """Fit of joints ``.../elements=M``: M elements replace those of a region, as in the source."""

    initial_guesses: Count = 16
    """Initial guesses of the search; the best fit of all is kept."""
    load_fractions: Distinct[tuple[Fraction, Fraction, Fraction]] = (0.3, 0.6, 0.9)
    """Loops are fitted at the three displacement amplitudes at which a region carries these
    fractions of its slip force."""

    def options(self, joint: str) -> dict[str, Any]:
        """The reduction of a joint of this name, and its options, as for ``reduce_joint``."""
        parsed = JointName(joint)
        reduction = REDUCTIONS[str(parsed.reduction)]
        count = {"count": parsed.elements} if reduction.has_count else {}
        keys = {argument: getattr(self, key) for key, argument in reduction.options.items()}
        return {"reduction": reduction.name, **count, **keys}


class HyperReduction(Entry):
    """Accuracy of the joints ``hyper=auto``, in which few weighted contact pairs stand for all.

    They have the fewest pairs with which no peak of the resonances that are solved is estimated to
    have a larger error, under any force between the smallest and the largest of the case; in a
    sweep, no peak of some designs spread over it.
    """

    frequency_tolerance: Fraction = 1e-3
    """Relative error of the frequency of a peak."""
    amplitude_tolerance: Fraction = 1e-2
    """The same of its amplitude."""

    def options(self, joint: str) -> dict[str, Any]:
        """The options of ``hyper_reduction.weigh_pairs`` for a joint of this name."""
        pairs = JointName(joint).pairs
        return {"count": pairs} if pairs != "auto" else {"count": None, **self.model_dump()}


#: resonances of the structure by which bases are compared; none can have fewer vectors
COMPARED_RESONANCES = 2


class Convergence(Entry):
    """Bases and numbers of regions that are compared with converged ones beside the cases.

    Peaks of the first resonance are compared, with analytic friction forces and one harmonic
    whatever ``solver`` says.
    """

    bases: Distinct[tuple[ComparedModalBasis, ...]] = ()
    """Bases in which the resonances of every assembly, with parts of its contact stuck, and the
    peaks of every case are found; the others are compared with the last, which is ``enriched-N``.
    No table if empty."""
    regions: Distinct[tuple[Count, ...]] = ()
    """Numbers of regions whose peaks are compared with those of all contact pairs, by division, for
    every case solved in an enriched basis; at most the contact pairs on one side of the centre line
    and on it. No table if empty."""
    reductions: Distinct[tuple[Joint, ...]] = ()
    """Joints whose peaks and times are compared with those of all contact pairs, for every case
    solved in an enriched basis whose friction law they can have. No table if empty."""

    time_integration_N: Distinct[tuple[Positive, ...]] = ()
    """Forces at which the converged peak of the largest basis ``enriched-N`` is integrated in time,
    of each case those among its ``forces_N``, and found in the last of ``bases`` too where that
    has more vectors. It takes a minute or two each. No table if empty."""

    def conflicts(self) -> Problems:
        if self.bases and not self.bases[-1].is_contact_adapted:
            yield ("bases", len(self.bases) - 1), "must be enriched-N: all are compared with it"
        for index, joint in enumerate(self.reductions):
            if joint == REFERENCE[0]:
                yield ("reductions", index), "must not be node-to-node: all are compared with it"


class Regions(Entry):
    """Division of the contact pairs into regions."""

    division: Literal["equal-load", "equal-middle-load"] = "equal-load"
    """Bands ``regions=N`` along the surface (the bar) of equal shares of the slip force, or of
    equal shares of the pressure along the middle of the width, as in the source under variable
    load; ``clusters=N`` are of pairs of similar motion. Several surfaces have numbers in proportion
    to their slip forces."""
    motion: Literal["mean", "load-weighted"] = "mean"
    """Motion of a band: mean of its pairs as in the source, or their mean weighted by slip force,
    which keeps the friction dissipation in full slip."""
    tolerance: Fraction = 0.01
    """Largest relative error of the resonances, over states of slip, with which ``regions=auto``
    and ``clusters=auto`` take the fewest regions, of at most 64, before any response is solved.
    Errors of amplitude are larger than these, which are of frequency."""


class Contents(Entry):
    """What a study has, by the names of files."""

    cases: Several[CaseName]
    """Cases that run: files of ``cases/`` without ``.yaml``."""
    sweeps: Distinct[tuple[Name, ...]] = ()
    """Sweeps over many designs that run: files of ``sweeps/`` without ``.yaml``."""
    assemblies: Distinct[tuple[Name, ...]] = ()
    """Assemblies to build and tabulate even if no case uses them: files of ``assemblies/``."""


class NumericalOptions(Entry):
    """How what a study has is computed, and what of it is left out."""

    omit: Distinct[tuple[Literal["timing", "checks", "harmonics"], ...]] = ()
    """Parts to leave out: tables of solution times and costs of models, and what is solved by
    forward differences for them, as the source did; residuals in time; time integration and further
    harmonics at ``verification_forces_N``."""
    converged_peaks: Annotated[bool, Field(strict=True)] = False
    """Whether each response also has its peaks with as many harmonics as change them by less than
    ``solver.harmonic_tolerance``, and error bars from them: seconds to minutes for each joint."""
    contact_adapted_basis: ContactAdaptedBasis = ContactAdaptedBasis()
    solver: Solver = Solver()
    fitting: Fitting = Fitting()
    hyper_reduction: HyperReduction = HyperReduction()
    convergence: Convergence = Convergence()

    @property
    def harmonic_convergence(self) -> dict[str, float] | None:
        """Options of ``HarmonicConvergence``; None where peaks are not converged."""
        needed = self.converged_peaks or self.solver.harmonics == "auto"
        return self.solver.harmonic_convergence if needed else None


class Settings(NumericalOptions, Contents):
    """The file ``config.yaml``: the cases that run, and the numerical options."""

    def conflicts(self) -> Problems:
        if self.solver.harmonics == "auto":
            if self.sweeps:
                yield ("sweeps",), "must be empty with solver.harmonics: auto"
            if "timing" not in self.omit:
                yield ("omit",), "must hold timing with solver.harmonics: auto"
