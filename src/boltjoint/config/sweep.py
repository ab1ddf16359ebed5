"""Sweeps: designs of a case that vary some of its keys, solved with one joint model."""

from itertools import pairwise
from math import prod
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, StrictBool, Tag

from boltjoint.config.distributions import Range, Values
from boltjoint.config.entries import Entry
from boltjoint.config.sampling import Design, Grid, Saltelli, Table
from boltjoint.config.types import (
    INTEGRAL,
    CaseName,
    Count,
    Description,
    Joint,
    ModalBasis,
    ModesCount,
    Positive,
    Problems,
    Several,
)
from boltjoint.options import CONVERGING

#: more designs than any sweep has: their parameters alone fill the memory
MOST_DESIGNS = 10_000_000

#: keys of a case that hold its excitation levels
LEVEL_KEYS = {"forces_N", "accelerations_m_per_s2"}

#: more jobs than the workflow can list in a reasonable time
MOST_JOBS = 10_000

#: designs whose peaks are solved with all harmonics, where those of others follow by regression,
#: for each of its variables: keys that vary, frequency and amplitude with one harmonic, slip force
LEAST_BY_VARIABLE = 3

#: highest harmonic with which peaks are sought, of ``options.CONVERGING``
Harmonics = Literal[3, 9, 17, 33]
#: least of them from whose last change further ones are extrapolated
_LEAST_EXTRAPOLATED = CONVERGING[1]
#: designs whose peaks are solved with all harmonics
SolvedDesigns = Annotated[int, Field(strict=True, ge=30), INTEGRAL]

#: time of a design of few elements at one level [s], and size of its peak with its values [byte]
_SECONDS, _BYTES = 4e-3, 50


Observed = Literal["peaks", "converged-peaks", "responses", "contact-states", "backbone"]


def words_of_harmonics(highest: int) -> str:
    """What harmonics peaks have that are sought with those up to a number."""
    return "with all harmonics" if highest >= CONVERGING[-1] else f"with up to {highest} harmonics"


class SweepCheck(Entry):
    """Designs drawn at random that are solved again in a larger model.

    How far their peaks are off is the error of the sweep. With ``converged_designs`` they are drawn
    from those that are solved with most harmonics.
    """

    designs: Count = 20
    """Number of these designs; all, if there are not more."""
    basis: ModalBasis
    """Modal basis of the larger model."""
    joint: Joint = Field("node-to-node", validate_default=True)
    """Joint of the larger model."""
    harmonics: Harmonics = 33
    """Highest harmonic of the larger model: more than ``harmonics`` of the sweep, as these would
    not be tested, or all."""
    seed: Annotated[int, Field(strict=True, ge=0), INTEGRAL] = 0
    """Seed of the random numbers: with the same one the same designs are drawn."""


class ConvergedDesigns(Entry):
    """Designs whose peaks are solved with harmonics up to one."""

    harmonics: Harmonics
    """Highest harmonic."""
    number: SolvedDesigns
    """Number of designs."""


def _form(value: object) -> str | None:
    if isinstance(value, list | tuple):
        return "several"
    return "number" if isinstance(value, int | float) else None


NumbersOfConverged = Annotated[
    Annotated[SolvedDesigns, Tag("number")] | Annotated[Several[ConvergedDesigns], Tag("several")],
    Discriminator(
        _form,
        custom_error_type="no_numbers",
        custom_error_message="must be a whole number, or a list of harmonics and number",
    ),
]


class Sweep(Entry):
    """Designs that vary keys of a case, its assembly or its joint, solved with one joint model.

    The joint is reduced once for all values of the contact, the preload, the force and the damping:
    each design has its regions, weighted pairs or fitted elements with coefficients of its own.
    Weights of pairs hold the peaks of designs spread over the sweep, beside those of the base case.
    """

    description: Description = ""
    """Description of the sweep in one line; no result depends on it."""
    case: CaseName
    """The base case: a file of ``cases/`` without ``.yaml``. What does not vary is as it says."""
    vary: dict[str, Values] = Field({})
    """Keys that vary, each with its values: a list, a range or a distribution. Of the base case as
    ``preload_N``, ``forces_N`` (one level a design), ``contact.friction_coefficient`` or
    ``preload_ratios[0]``, of its assembly as ``assembly.bar.lap_mm``, of the joint as
    ``joint.regions``. None with ``kind: table``."""
    levels: Several[Positive] | None = None
    """Excitation levels at which each design is solved, in N or m/s²; by default those of the case.
    Not where they vary."""
    design: Design = Grid(kind="grid")
    """Which combinations of values are designs."""
    basis: ModalBasis
    """Modal basis. One that is contact-adapted is made for each mesh and each ratio of preloads."""
    joint: Joint
    """Joint model, as in ``solve`` of a case."""
    resonance: ModesCount = 1
    """Number of the resonance."""
    coordinates: Literal["linear", "backbone"] = "linear"
    """``linear``, all vectors of the basis, or ``backbone``, nonlinear modal synthesis."""
    observe: Several[Observed] = ("peaks",)
    """What is kept of each design: ``peaks``, frequency and amplitude of the peak;
    ``converged-peaks``, these with all harmonics and their errors; ``responses``,
    the amplitude over frequency on one grid for all; ``contact-states``, of each element at the
    peak; ``backbone``, natural frequency and damping ratio over the amplitude of the output
    point."""
    harmonics: Harmonics = 33
    """Highest harmonic with which ``converged-peaks`` are sought. Fewer take less time, and
    ``check`` tells what they leave out."""
    error_bars: StrictBool = True
    """Whether error bars of ``converged-peaks`` are estimated, of designs and of those of
    ``check``. They take four fifths of the time of a peak. Without them what the last harmonics
    changed, extrapolated, counts in their place, and peaks are located with three harmonics
    only: their frequencies and amplitudes were up to 6e-4 off for that."""
    converged_designs: NumbersOfConverged | None = None
    """Number of designs, spread over all, whose ``converged-peaks`` are solved, or several numbers
    by their highest harmonic, as 300 up to 9 and 60 of these up to 17. Those of the others follow
    from their peaks with fewer by regression, whose error counts in that of the sweep: it does not
    know a superharmonic resonance between the designs that are solved. All by default."""
    frequencies: Count = 400
    """Frequencies of the grid of ``responses``."""
    amplitudes: Count = 50
    """Amplitudes of the grid of ``backbone``, evenly in their logarithm."""
    amplitudes_mm: tuple[Positive, Positive] | None = None
    """Lowest and highest amplitude of that grid; by default three decades up to the largest peak of
    the base case."""
    check: SweepCheck | None = None
    """Designs that are solved again in a larger model, for the error of all; without it the error
    of the sweep is not known."""
    designs_per_job: Count = 2500
    """Designs that one job solves."""

    def conflicts(self) -> Problems:
        of_table = isinstance(self.design, Table)
        if of_table and self.vary:
            yield ("vary",), "must not be given with kind: table: its columns are what varies"
        if not of_table and not self.vary:
            yield ("vary",), "must have at least one key"
        if "backbone" in self.observe and self.amplitudes < 2:
            yield ("amplitudes",), "must be at least 2, the ends of the grid"
        if self.converged_designs is not None:
            yield from self._conflicts_of_converged()
        if self.check is not None:
            yield from self._conflicts_of_check(self.check.harmonics)
        if self.amplitudes_mm is not None and self.amplitudes_mm[0] >= self.amplitudes_mm[1]:
            yield ("amplitudes_mm",), "must ascend"
        if self.levels is not None and (keys := LEVEL_KEYS & set(self.vary)):
            yield ("levels",), f"must not be given where {keys.pop()} varies"
        for key, values in self.vary.items():
            if isinstance(self.design, Grid) and not isinstance(values, tuple):
                if not isinstance(values, Range):
                    yield ("vary", key, "kind"), "must be linear or log in a grid"
                elif values.number is None or values.number < 2:
                    yield ("vary", key, "number"), "is missing: at least two values of a grid"
        yield from self.conflicts_of_number(self.designs or 0)

    def _conflicts_of_check(self, harmonics: int) -> Problems:
        """What speaks against the harmonics of the larger model."""
        path, all_of_them = ("check", "harmonics"), CONVERGING[-1]
        if "converged-peaks" in self.observe and harmonics <= self.harmonics != all_of_them:
            yield path, f"must be above the harmonics of the sweep, {self.harmonics}"
        elif "converged-peaks" in self.observe and harmonics < self.harmonics:
            yield path, "must be those of the sweep, which has all"
        elif not self.error_bars and harmonics < _LEAST_EXTRAPOLATED:
            yield path, f"must be at least {_LEAST_EXTRAPOLATED} without error_bars"

    def _conflicts_of_converged(self) -> Problems:
        """What speaks against the numbers of designs that are solved with all harmonics."""
        least, path = LEAST_BY_VARIABLE * (len(self.vary) + 3), ("converged_designs",)
        tiers, numbers = zip(*self._tiers, strict=True)
        within = [number for number in CONVERGING if number <= self.harmonics]
        if "converged-peaks" not in self.observe:
            yield path, "must not be given without converged-peaks in observe"
        elif list(tiers) != within[-len(tiers) :]:
            yield path, f"must ascend to the harmonics of the sweep, {self.harmonics}, one by one"
        elif any(more < fewer for more, fewer in pairwise(numbers)):
            yield path, "must not have more designs with more harmonics"
        elif min(numbers) < least:
            yield path, f"must be at least {least} with so many keys that vary"

    def conflicts_of_number(self, count: int) -> Problems:
        """What speaks against a number of designs."""
        if count > MOST_DESIGNS:
            days, size = _SECONDS * count / 86400, _BYTES * count / 1e9
            yield (
                ("design",),
                f"makes {count:.3g} designs, {days:.3g} days on one core and {size:.3g} GB of "
                f"peaks for each level: must make at most {MOST_DESIGNS:g}",
            )
        elif count > MOST_JOBS * self.designs_per_job:
            yield (
                ("designs_per_job",),
                f"makes {count / self.designs_per_job:.3g} jobs: must make at most {MOST_JOBS:g}",
            )

    @property
    def designs(self) -> int | None:
        """Number of designs; None where they are the rows of a table."""
        if isinstance(self.design, Grid):
            return prod(self.grid.values())
        if isinstance(self.design, Saltelli):
            return self.design.number * (len(self.vary) + 2)
        return getattr(self.design, "number", None)

    @property
    def observed(self) -> dict[str, Any]:
        """What ``study.solved_designs.solve_designs`` keeps of each design."""
        return {
            "frequencies": self.frequencies if "responses" in self.observe else None,
            "amplitudes": self.amplitudes if "backbone" in self.observe else None,
            "between": self.amplitudes_mm
            and tuple(1e-3 * amplitude for amplitude in self.amplitudes_mm),
            "states": "contact-states" in self.observe,
            "converged": "converged-peaks" in self.observe,
            "error_bars": self.error_bars,
            "converged_designs": self.designs_by_harmonics,
        }

    @property
    def designs_by_harmonics(self) -> dict[int, int] | None:
        """Designs whose peaks are solved, by the highest harmonic; None where all are with all."""
        return dict(self._tiers) or None

    @property
    def _tiers(self) -> list[tuple[int, int]]:
        """Highest harmonic and number of designs, as they are given."""
        if isinstance(self.converged_designs, int):
            return [(self.harmonics, self.converged_designs)]
        return [(each.harmonics, each.number) for each in self.converged_designs or ()]

    @property
    def harmonics_in_words(self) -> str:
        """What harmonics its peaks have."""
        if "converged-peaks" not in self.observe:
            return "without all harmonics"
        told = words_of_harmonics(self.harmonics)
        numbers = self.designs_by_harmonics
        solved = None if numbers is None else min(numbers.values())
        if solved is None or (self.designs is not None and solved >= self.designs):
            return told
        return f"{told} in {solved} designs and by regression in all others"

    @property
    def checking(self) -> Self:
        """The sweep as its designs are solved again in the larger model.

        Raises
        ------
        ValueError
            If there is none.
        """
        if self.check is None:
            raise ValueError("the sweep has no larger model")
        larger = {"basis": self.check.basis, "joint": self.check.joint, "coordinates": "linear"}
        return self.model_copy(update=larger)

    @property
    def grid(self) -> dict[str, int]:
        """Number of values of each key in a grid; empty where the designs are none."""
        if not isinstance(self.design, Grid):
            return {}
        return {
            key: len(values) if isinstance(values, tuple) else getattr(values, "number", None) or 1
            for key, values in self.vary.items()
        }
