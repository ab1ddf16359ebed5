"""Case: an assembly under a preload, with contact, forces and the joint models compared."""

from collections.abc import Sequence
from functools import cached_property
from itertools import product
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from boltjoint.config.contact import Contact
from boltjoint.config.damping import StructuralDamping
from boltjoint.config.entries import Entry, EntryWithLaterKeys
from boltjoint.config.excitation import Excitation, Point, Sensor
from boltjoint.config.measured import Measured
from boltjoint.config.numerical_options import Regions
from boltjoint.config.sweep import MOST_JOBS
from boltjoint.config.types import (
    Description,
    Distinct,
    Fraction,
    Joint,
    KeyPath,
    ModalBasis,
    ModesCount,
    Name,
    NotNegative,
    Positive,
    Problems,
    Several,
    Unknowns,
)
from boltjoint.damping import Damping, LossFactor
from boltjoint.names import (
    REPETITION_MEANING,
    Basis,
    Coordinates,
    JointName,
    Preload,
    repeats_pattern,
)

#: loss factor of a case that says nothing of damping; the published study does not give it
_LOSS_FACTOR = 0.002


#: levels that are listed where one of them must be named
_SHOWN = 20
#: characters of the names of an assembly and a preload; file names have 255, with other words
_LONGEST_NAMES = 200


class SolveBlock(Entry):
    """A resonance, the joint models whose response is computed around it, bases and coordinates."""

    resonance: ModesCount
    """Number of the resonance, at most the vectors of the smallest basis of the block; with a basis
    ``enriched-N`` at most ``contact_adapted_basis.resonances``."""
    joints: Several[Joint]
    """Joint models, listed under *Joints*. There are at most as many clusters, and elements in all,
    as contact pairs, and as many regions as pairs on one side of the centre line and on it."""
    modes: Several[ModalBasis] | None = None
    """Bases of this block; by default those of the case."""
    coordinates: Several[Unknowns] | None = None
    """Coordinates of this block; by default those of the case."""
    window_Hz: tuple[Positive, Positive] | None = None
    """Lowest and highest frequency, in Hz; by default chosen around the resonance. All blocks of a
    resonance that give a window give the same one. Where the resonance cannot lie in it, its job
    fails."""

    def conflicts(self) -> Problems:
        if self.window_Hz is not None and self.window_Hz[0] >= self.window_Hz[1]:
            yield ("window_Hz",), "must be the lower frequency, then the higher one"


class WholeBlock(NamedTuple):
    """A block of ``solve`` with bases and coordinates, its own or those of the case."""

    resonance: int
    joints: tuple[JointName, ...]
    modes: tuple[Basis, ...]
    coordinates: tuple[Coordinates, ...]
    window_Hz: tuple[float, float] | None


class Case(EntryWithLaterKeys):
    """One case study: an assembly under a preload, its contact, forces and joint models."""

    LATER_KEYS = frozenset({"bolt_preloads_N", "measured"})

    description: Description = ""
    """Description of the case in one line; no result depends on it."""
    published: Name | None = None
    """Case study of the source whose tables stand beside those of this case: a case of
    ``resources/source/case_studies.csv``. By default the case is compared with none."""
    assembly: Name
    """The assembly: a file of ``assemblies/`` without ``.yaml``."""
    preload_N: Positive | None = None
    """Preload of each bolt; by default what the assembly gives its bolts, as the loads of a deck. A
    warning is given where it strains the shanks beyond yield, of class 8.8 by default: the model
    stays elastic."""
    bolt_preloads_N: Annotated[dict[str, NotNegative], Field(min_length=1)] | None = None
    """Preload of some bolts by their names, which are ``bolt 1`` and so on where the assembly gives
    them none; the others have ``preload_N``. In place of ``preload_ratios``."""
    preload_ratios: Annotated[tuple[NotNegative, ...], Field(min_length=1)] | None = None
    """Preload of each bolt over ``preload_N``, in the order of the assembly; by default 1 for all.
    Head and nut of a bolt without preload stay tied to the bars: only the contact opens."""
    contact: Contact
    """Friction law of the contact pairs, and its coefficients."""
    regions: Regions = Regions()
    loss_factor: Fraction | None = None
    """Structural loss factor, the same for all motion; 0.002 where no ``damping`` is given, nor by
    the modes of the assembly, since without damping a peak has no bound where friction sticks."""
    damping: StructuralDamping | None = None
    """Another model of structural damping, in place of ``loss_factor``. Viscous ratios of
    ``model: modal`` are those of the bending modes without contact, in ``enriched-N`` too."""
    excitation: Excitation | None = None
    """What excites the structure: forces at points or at inputs that the assembly names, a load on
    a surface, or an acceleration of the supports; by default a force at the first input, of a half
    lap the middle of the free end's top edge, along z."""
    sensors: tuple[Sensor, ...] = ()
    """Points where the displacement is read, the first being the output point; by default the
    outputs of the assembly, of a half lap the middle of the free end's top edge, along z."""
    outputs: Distinct[tuple[Name, ...]] = ()
    """Outputs that the assembly names and where the displacement is read, after ``sensors``."""
    forces_N: Several[Positive] | None = None
    """Amplitudes of the harmonic excitation, in N; one frequency response for each. Required but
    with ``kind: base``."""
    accelerations_m_per_s2: Several[Positive] | None = None
    """Amplitudes of the acceleration of the supports, which stand in place of ``forces_N`` with
    ``kind: base``."""
    verification_forces_N: Distinct[tuple[Positive, ...]] = ()
    """Forces of ``forces_N``, or accelerations of ``accelerations_m_per_s2``, at which the peak of
    the node-to-node joint is found with up to 9 harmonics too, in every basis; in the first basis
    ``free-N`` it is also integrated in time, and solved with up to 201 harmonics."""
    modes: Several[ModalBasis]
    """Bases of all blocks that give none: ``free-N``, the first N bending modes without contact, as
    in the source; ``all-N``, the first N of all families, which also hold lateral and torsional
    motion; ``enriched-N``, the first N vectors of the contact-adapted basis, which also hold
    the motion of the contact in stick, slip and separation; ``enriched-auto``, as many of them as
    the tolerances of ``contact_adapted_basis`` ask for, at least 8. N is at most
    ``contact_adapted_basis.maximum_vectors`` there, and at most ``free_modes`` and two for each
    contact pair on one side of the centre line and on it. Laws of friction along both tangents have
    such bases of all motion, symmetric or not: the resonances of all cases of the assembly are then
    counted as in ``all-N``."""
    coordinates: Several[Unknowns]
    """Unknowns of all blocks that give none: ``linear``, all vectors of the basis; ``rdnm-N`` or
    ``complex-rdnm-N``, N real or complex response-dependent modes, at most the vectors of the
    smallest basis; ``backbone``, nonlinear modal synthesis from the damped nonlinear mode."""
    solve: Annotated[tuple[SolveBlock, ...], Field(min_length=1)]
    """Resonances, each with the joint models solved there. A resonance may have several blocks, as
    long as they solve nothing twice."""
    measured: Measured | None = None
    """Measured backbones to which parameters of a joint are fitted; by default none."""

    @property
    def structural_damping(self) -> Damping:
        """The model of structural damping with its parameters."""
        if self.damping is not None:
            return self.damping.damping
        return LossFactor(_LOSS_FACTOR if self.loss_factor is None else self.loss_factor)

    @property
    def tells_preload(self) -> bool:
        """Whether the preload of each bolt is told without its name, and without the assembly."""
        return self.preload_N is not None and self.bolt_preloads_N is None

    @property
    def nominal_preload(self) -> float:
        """Preload of a bolt whose ratio is 1 [N]."""
        if self.preload_N is None:
            raise ValueError("the preload of the case is that of its assembly")
        return self.preload_N

    @property
    def preload(self) -> Preload:
        """Preload of each bolt."""
        return Preload.of(self.nominal_preload, self.preload_ratios)

    @property
    def is_base_excited(self) -> bool:
        """Whether the supports move, and levels are accelerations."""
        return self.excitation is not None and self.excitation.kind == "base"

    @property
    def levels(self) -> tuple[float, ...]:
        """Excitation levels: forces [N], or accelerations of the supports [m/s2]."""
        return (self.accelerations_m_per_s2 if self.is_base_excited else self.forces_N) or ()

    @property
    def points(self) -> dict[KeyPath, Point]:
        """Points of the excitation and the sensors, by their key path."""
        of_excitation = getattr(self.excitation, "points", ())
        return {("excitation", "points", i): point for i, point in enumerate(of_excitation)} | {
            ("sensors", i): point for i, point in enumerate(self.sensors)
        }

    @property
    def named_places(self) -> dict[KeyPath, str]:
        """Names of inputs and outputs of the assembly, by their key path."""
        inputs = getattr(self.excitation, "inputs", ())
        return {
            ("excitation", "inputs", i, "name"): entry.name for i, entry in enumerate(inputs)
        } | {("outputs", i): name for i, name in enumerate(self.outputs)}

    @property
    def blocks(self) -> tuple[WholeBlock, ...]:
        """The blocks of ``solve``, with what the case gives for what they leave out."""
        return tuple(
            WholeBlock(
                block.resonance,
                block.joints,
                block.modes or self.modes,
                block.coordinates or self.coordinates,
                block.window_Hz,
            )
            for block in self.solve
        )

    @property
    def bases(self) -> tuple[Basis, ...]:
        """All modal bases of all blocks, each once, in the order of the file."""
        return tuple(dict.fromkeys(basis for basis, *_ in self.responses))

    def joints(self, basis: str) -> tuple[JointName, ...]:
        """All joints that are solved in a modal basis, each once, in the order of the file."""
        return tuple(
            dict.fromkeys(response[1] for response in self.responses if response[0] == basis)
        )

    def resonances(self, basis: str) -> tuple[int, ...]:
        """The resonances that are solved in a modal basis, each once, in the order of the file."""
        return tuple(
            dict.fromkeys(response[3] for response in self.responses if response[0] == basis)
        )

    @cached_property
    def responses(self) -> tuple[tuple[Basis, JointName, Coordinates, int], ...]:
        """Modal basis, joint, coordinates and resonance of every response, each once."""
        return tuple(
            dict.fromkeys(
                (basis, joint, coordinates, block.resonance)
                for block in self.blocks
                for basis in block.modes
                for joint in block.joints
                for coordinates in block.coordinates
            )
        )

    def partition(self, joint: str) -> dict[str, Any]:
        """The options of ``partition.partition_regions`` for regions or clusters of this name."""
        parsed = JointName(joint)
        options: dict[str, Any]
        if parsed.division == "clusters":
            options = {"division": "clusters", "motion": "mean"}
        else:
            options = self.regions.model_dump(exclude={"tolerance"})
        if parsed.division == "clusters" or parsed.count == "auto":
            # bands of a given number do not depend on what is solved
            options["resonances"] = max(block.resonance for block in self.solve)
        if parsed.count == "auto":
            return {**options, "count": None, "tolerance": self.regions.tolerance}
        return {**options, "count": parsed.count}

    def window_around(self, resonance: int) -> tuple[float, float] | None:
        """The frequencies [Hz] given for a resonance, or None if they are to be chosen."""
        windows = (block.window_Hz for block in self.solve if block.resonance == resonance)
        return next(filter(None, windows), None)

    def conflicts(self) -> Problems:
        if self.damping is not None and self.loss_factor is not None:
            yield ("damping",), "must not stand beside loss_factor: one of them damps the structure"
        yield from _conflicts_of_preload(self)
        yield from self._conflicts_of_excitation()
        blocks = self.blocks
        for index, block in enumerate(blocks):
            yield from self._conflicts_in_block(index, block)
        sizes = [len(b.joints) * len(b.modes) * len(b.coordinates) for b in blocks]
        if (count := sum(sizes)) > MOST_JOBS:
            key = ("solve", sizes.index(max(sizes)), "joints")
            yield key, f"is most of {count} responses of all blocks: must be at most {MOST_JOBS}"
        else:
            yield from _conflicts_between(blocks)

    def place_of(self, key: str, index: int) -> KeyPath:
        """Where modes or coordinates of a block are given: in the block or in the case."""
        return (key,) if getattr(self.solve[index], key) is None else ("solve", index, key)

    def _conflicts_of_excitation(self) -> Problems:
        level, other = "forces_N", "accelerations_m_per_s2"
        if self.is_base_excited:
            level, other = other, level
        if getattr(self, level) is None:
            kind = " of the supports" if self.is_base_excited else ""
            yield (level,), f"is missing: amplitudes of the excitation{kind}"
        if getattr(self, other) is not None:
            yield (other,), f"must not be given with this excitation: its levels are {level}"
        there = ", ".join(f"{chosen:g}" for chosen in self.levels[:_SHOWN])
        there += f" and {more} more" if (more := len(self.levels) - _SHOWN) > 0 else ""
        law = self.contact.declaration
        if self.verification_forces_N and not law.has_closed_form:
            sentence = f"must be left out with {law.name}: time integration of a joint knows no "
            yield ("verification_forces_N",), f"{sentence}sliders that move in the plane"
        levels = set(self.levels)
        for index, force in enumerate(self.verification_forces_N):
            if levels and force not in levels:
                yield ("verification_forces_N", index), f"must be one of {level}: {there}"
        names = set(self.outputs)
        for index, sensor in enumerate(self.sensors):
            if sensor.name in names:
                yield ("sensors", index, "name"), "must not appear twice"
            names.add(sensor.name)

    def _conflicts_in_block(self, index: int, block: WholeBlock) -> Problems:
        above = ("solve", index)
        smallest = min(block.modes, key=lambda basis: basis.fewest)
        available = smallest.fewest
        for place, name in enumerate(block.coordinates):
            if (name.count or 0) > available:
                path = (*self.place_of("coordinates", index), place)
                yield path, f"must not have more modes than the basis {smallest}"
        if block.resonance > available:
            sentence = f"must be at most {available}, the modes of the basis {smallest}"
            yield (*above, "resonance"), sentence
        law = self.contact.declaration
        for place, joint in enumerate(block.joints):
            if missing := joint.missing(law.capabilities):
                sentence = f"must not have /{joint.reduction}, which needs {' and '.join(missing)}"
                yield (*above, "joints", place), sentence
            if not law.has_closed_form and (joint.count == "auto" or joint.pairs is not None):
                sentence = f"must not be {joint}, which needs a closed form of the law {law.name}"
                yield (*above, "joints", place), sentence


def _conflicts_of_preload(case: Case) -> Problems:
    """Ratios of no bolt or beside preloads, or that cannot be part of the names of files."""
    if case.preload_ratios is not None and not any(case.preload_ratios):
        yield ("preload_ratios",), "must have a ratio above 0: a bolt that carries the load"
    if case.bolt_preloads_N is not None and case.preload_ratios is not None:
        yield ("bolt_preloads_N",), "must not stand beside preload_ratios"
    if case.preload_N is None:
        return
    length = len(case.assembly) + len(case.preload)
    if length > _LONGEST_NAMES:
        yield (
            ("preload_ratios",),
            f"makes names of files of {length} characters with the assembly: must make at most "
            f"{_LONGEST_NAMES}, by ratios of fewer digits",
        )
    elif repeats_pattern(case.preload):
        yield ("preload_ratios",), REPETITION_MEANING


def _conflicts_between(blocks: Sequence[WholeBlock]) -> Problems:
    """Windows of a resonance that differ, and what is solved twice."""
    windows: dict[int, tuple[float, float]] = {}
    solved: set[tuple[str | int, ...]] = set()
    for index, block in enumerate(blocks):
        if block.window_Hz is not None:
            low, high = windows.setdefault(block.resonance, block.window_Hz)
            if block.window_Hz != (low, high):
                yield (
                    ("solve", index, "window_Hz"),
                    f"must be [{low:g}, {high:g}], as of the block before it around resonance "
                    f"{block.resonance}",
                )
        for place, joint in enumerate(block.joints):
            own = set(product([block.resonance], block.modes, block.coordinates, [joint]))
            if own & solved:
                yield (
                    ("solve", index, "joints", place),
                    "must not be solved twice: a block before solves it around resonance "
                    f"{block.resonance} in the same basis and coordinates",
                )
            solved |= own
