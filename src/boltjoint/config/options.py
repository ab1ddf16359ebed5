"""Numerical options of a study."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool

from boltjoint import names
from boltjoint.config.entries import (
    DISTINCT,
    INTEGRAL,
    Count,
    Distinct,
    Entry,
    KeyPath,
    Number,
    Positive,
    Several,
)
from boltjoint.config.types import CaseName, ComparedModesName, ModesCount, Name
from boltjoint.solvers.equations import StepControl

#: fewer samples a period for each harmonic cannot tell the harmonics of a force apart
LEAST_SAMPLES = 8


#: resonances of the structure by which bases are compared; none can have fewer vectors
COMPARED_RESONANCES = 2


class Solver(Entry):
    """How the harmonic balance is solved and followed along frequency."""

    friction: Literal["exact", "sampled"] = "exact"
    """Forces in closed form, or sampled in time (AFT), which any number of harmonics can be."""
    harmonics: Count = 1
    """Harmonics of the response; more than 1 only with ``friction: sampled``."""
    samples: Annotated[int, Field(strict=True, ge=LEAST_SAMPLES), INTEGRAL] = 256
    """Samples a period with ``friction: sampled``; they err by their inverse square."""
    jacobian: Literal["analytic", "forward-difference"] = "analytic"
    """Where the derivatives come from: analytic, or forward-difference as in the source study."""
    basis_update: Literal["implicit", "lagged"] = "implicit"
    """Response-dependent modes: implicit, those of the solution itself; lagged, updated once a
    solution, as in the source study, where some branches are not complete. Modes of rdnm-N with
    forward differences are always lagged."""
    quasi_static_correction: StrictBool = True
    """Whether complex-rdnm-N adds the quasi-static response of the residual modes."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 1e-9
    """Residual at which a point is solved, relative to the modal force."""
    largest_step: Positive = 0.07
    """Longest step along the curve, as a relative change of the response."""
    smallest_step: Annotated[Positive, Field(lt=StepControl.first_step)] = 1e-9
    """Shortest step along the curve; a curve that needs a shorter one is given up."""
    target_iterations: Count = 4
    """Newton corrections a point that the step control aims at."""
    maximum_iterations: Annotated[int, Field(strict=True, ge=2), INTEGRAL] = 12
    """Newton corrections after which a point is tried again with a shorter step."""
    maximum_solutions: Count = 5000
    """Points after which a curve is given up."""
    largest_error: Positive = 0.05
    """Estimated relative error of a peak in other coordinates than linear beyond which a warning is
    given, by the balance in all linear modes; ten times as much on the flanks."""
    fallback: Literal["none", "linear"] = "none"
    """What takes the place of a response in other coordinates that is too far off, or broke off:
    none, or the response in linear modes."""

    @property
    def steps(self) -> dict[str, float]:
        """The options of ``solvers.equations.StepControl``."""
        return self.model_dump(include=set(StepControl.__dataclass_fields__))

    @property
    def sampling(self) -> dict[str, int] | None:
        """Harmonics and samples where friction is sampled, None where it is exact."""
        if self.friction == "exact":
            return None
        return {"harmonics": self.harmonics, "samples": self.samples}

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        if self.friction == "exact" and self.harmonics > 1:
            yield ("harmonics",), "must be 1 with friction: exact; more need friction: sampled"
        elif self.samples < LEAST_SAMPLES * self.harmonics:
            yield (
                ("samples",),
                f"must be at least {LEAST_SAMPLES * self.harmonics}, "
                f"{LEAST_SAMPLES} for each harmonic",
            )
        if self.smallest_step >= self.largest_step:
            yield ("smallest_step",), f"must be less than largest_step, {self.largest_step:g}"
        if self.target_iterations >= self.maximum_iterations:
            yield (
                ("target_iterations",),
                f"must be less than maximum_iterations, {self.maximum_iterations}",
            )


class ContactAdaptedBasis(Entry):
    """What the modal bases enriched-N are made for."""

    contact_stiffness_N_per_m: Positive = 1e8
    """Stiffness of each contact pair, along the bar and across the contact, in N/m."""
    friction_coefficient: Positive = 0.1
    """Coulomb friction coefficient; it decides whether pairs slip before they open."""
    loss_factor: Positive = 0.002
    """Of the structure; friction counts by what it adds to that."""
    free_modes: ModesCount = 12
    """Modes without contact among the candidates."""
    resonances: ModesCount = 2
    """Resonances whose motion the bases are to hold, from the first; at most free_modes."""
    levels: Count = 14
    """Steps by which the load that slips grows from none to all of it."""
    most: ModesCount = 80
    """Vectors of the largest basis; enriched-N has the first N of them."""

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        if self.resonances > self.free_modes:
            yield ("resonances",), f"must be at most free_modes, {self.free_modes}"


Fraction = Annotated[Number, Field(gt=0, lt=1)]


class Fitting(Entry):
    """How the elements of a region are replaced by a few."""

    starts: Count = 16
    """Starting points of the search; the best fit of all is kept."""
    load_fractions: Annotated[tuple[Fraction, Fraction, Fraction], DISTINCT] = (0.3, 0.6, 0.9)
    """Loops fit at the displacements where a region carries these parts of its slip force."""

    def fit(self, joint: str) -> dict[str, Any]:
        """The options of ``fitting.fit_reduced_joint`` for a joint of this name."""
        parsed = names.parse_joint(joint)
        if parsed.reduction == "harmonic":
            return {"count": parsed.elements, "method": "describing-function"}
        return {"count": parsed.elements, "method": "loops", **self.model_dump()}


class Timing(Entry):
    """How the solver is timed."""

    repeats: Count = 3
    """Times that each frequency response is computed while the clock runs, at most."""
    time_budget_s: Positive = 0.5
    """It is not computed again once all computations of it took so long, in s."""


class Convergence(Entry):
    """What is tabulated to show how far bases and regions are from converged ones."""

    bases: Distinct[ComparedModesName] = ()
    """Bases in which the resonances of the structure and the peaks of every case are found; the
    others are compared with the last, which is enriched-N. No table when left out."""
    regions: Distinct[Count] = ()
    """Numbers of regions whose peaks are compared with those of all pairs, in the basis of the
    converged response of a case. No table when left out."""

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        if self.bases and not names.is_enriched(self.bases[-1]):
            yield ("bases", len(self.bases) - 1), "must be enriched-N: all are compared with it"


class Settings(Entry):
    """The file config.yaml: which cases run, and the numerical options."""

    cases: Several[CaseName]
    """Case studies to run: files of config/cases, without .yaml."""
    assemblies: Distinct[Name] = ()
    """Assemblies to build and tabulate even if no case uses them: files of config/assemblies."""
    contact_adapted_basis: ContactAdaptedBasis = ContactAdaptedBasis()
    solver: Solver = Solver()
    fitting: Fitting = Fitting()
    timing: Timing = Timing()
    convergence: Convergence = Convergence()
