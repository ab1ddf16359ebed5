"""What a study consists of: its YAML files, read strictly into plain, checked objects.

Run ``python -m boltjoint.config`` after changing a model: it rewrites the JSON schemas by which an
editor completes and checks the files.
"""
# ruff: noqa: N815 - keys end in their unit, and units are case-sensitive

import argparse
import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field, StrictBool, ValidationError

from boltjoint import names
from boltjoint.entries import (
    DISTINCT,
    INTEGRAL,
    Check,
    Count,
    Distinct,
    Entry,
    KeyPath,
    Number,
    Positive,
    Several,
    choice,
    explained,
)
from boltjoint.names import MOST_MODES
from boltjoint.solvers.equations import StepControl
from boltjoint.yamltext import TextError, read_mapping, shown, typed

CONFIG_FILE = "config/config.yaml"
COMMAND_LINE = "command line"
CASE_FOLDER = "config/cases"
ASSEMBLY_FOLDER = "config/assemblies"
SCHEMA_FOLDER = "config/schemas"

#: fewer samples a period for each harmonic cannot tell the harmonics of a force apart
LEAST_SAMPLES = 8

#: resonances of the structure by which bases are compared; none can have fewer vectors
COMPARED_RESONANCES = 2


class ConfigError(ValueError):
    """The configuration cannot be used; one line of text for each problem of each file."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


def _page(name: str) -> Iterator[tuple[KeyPath, str]]:
    if name in names.PAGES:
        yield (), "must be another name: the report has a page called so"


Name = Annotated[str, Field(pattern=names.NAME)]
CaseName = Annotated[Name, Check(_page, {"not": {"enum": list(names.PAGES)}})]
ModesName = Annotated[str, Field(pattern=names.MODES)]
ComparedModesName = Annotated[str, Field(pattern=names.COMPARED_MODES)]
CoordinatesName = Annotated[str, Field(pattern=names.COORDINATES)]
JointName = Annotated[str, Field(pattern=names.JOINT)]
ModesCount = Annotated[int, Field(strict=True, ge=1, le=MOST_MODES), INTEGRAL]
# left out of model_dump(), so that a result made from the dump does not go stale with the text
Description = Annotated[str, Field(exclude=True)]


class Bar(Entry):
    """The two bars: of full height outside the lap, of half height in it."""

    width_mm: Positive
    """Width of both bars (y)."""
    height_mm: Positive
    """Height of a bar outside the lap (z); in the lap each bar has half of it."""
    free_length_mm: tuple[Positive, Positive]
    """Lengths outside the lap: from the clamp to the lap, and from the lap to the free end."""
    lap_mm: Positive
    """Length of the lap (x)."""

    @property
    def length_mm(self) -> float:
        """Length of the whole assembly, from the clamp to the free end."""
        return self.free_length_mm[0] + self.lap_mm + self.free_length_mm[1]


class Material(Entry):
    """The linear elastic material of bars and bolts."""

    youngs_modulus_GPa: Positive
    """Young's modulus in GPa."""
    poissons_ratio: Annotated[Number, Field(ge=0, lt=0.5)]
    """Poisson's ratio."""
    density_kg_per_m3: Positive
    """Density in kg/m3."""


class Bolts(Entry):
    """A row of equal bolts on the centre line of the lap."""

    positions_from_lap_start_mm: Annotated[tuple[Positive, ...], Field(min_length=1)]
    """Bolt axes, ascending, measured along the bar from the clamped side's end of the lap."""
    shank_diameter_mm: Positive
    """Diameter of the shank."""
    hole_diameter_mm: Positive
    """Diameter of the clearance hole."""
    head_diameter_mm: Positive
    """Outer diameter of head and nut, both modelled round."""
    head_height_mm: Positive
    """Height of the head."""
    nut_height_mm: Positive
    """Height of the nut."""

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        if self.hole_diameter_mm <= self.shank_diameter_mm:
            yield (
                ("hole_diameter_mm",),
                f"must be greater than the shank's diameter of {self.shank_diameter_mm:g} mm",
            )
        if self.head_diameter_mm <= self.hole_diameter_mm:
            yield (
                ("head_diameter_mm",),
                f"must be greater than the hole's diameter of {self.hole_diameter_mm:g} mm",
            )


class Mesh(Entry):
    """Divisions of the mesh. Each bolt sits in a rectangular cell as wide as the bar."""

    ring_cells_across_width: Annotated[int, Field(strict=True, ge=2, multiple_of=2), INTEGRAL]
    """Elements across the width of the bar; even, so that nodes lie on the centre line."""
    ring_cells_along_bar: Annotated[int, Field(strict=True, ge=2), INTEGRAL]
    """Elements along each long side of a bolt cell."""
    rings_under_head: Count
    """Rings of elements between the edge of the hole and the edge of the head."""
    rings_head_to_cell_edge: Count
    """Rings of elements between the edge of the head and the edge of the bolt cell."""
    bolt_cell_length_mm: Positive
    """Length of a bolt cell along the bar, half of it on each side of the bolt's axis."""
    columns_between_bolt_cells: Count
    """Elements along the bar between two bolt cells."""
    columns_at_each_lap_end: Count
    """Elements along the bar between the outermost bolt cells and the ends of the lap."""
    layers_per_half_height: Count
    """Elements through half the height of a bar."""
    element_length_free_mm: Positive
    """Wanted length of the elements outside the lap."""
    rings_in_shank: Count
    """Rings of elements in the shank of a bolt."""
    layers_in_head: Count
    """Elements through the height of a head, and of a nut."""


class StaticContact(Entry):
    """Contact between the bars while the bolts are tightened."""

    penalty_N_per_m3: Positive = 1e15
    """Normal contact stiffness for each unit of area, in N/m3."""
    friction_coefficient: Annotated[Number, Field(ge=0)] = 0.1
    """Coulomb friction between the bars during tightening."""


class Point(Entry):
    """A point of the bars and a direction; the node nearest to the point is taken."""

    x_mm: Number
    """Distance from the clamp, along the bar."""
    y_mm: Number
    """Distance from the centre line, across the width."""
    z_mm: Number
    """Height above the plane of contact."""
    direction: Literal["x", "y", "z"]
    """Direction of the force or of the displacement."""


class Assembly(Entry):
    """Two bars with a half-lap joint, clamped at one end and held by a row of bolts."""

    description: Description = ""
    """What the assembly is, in one line; free text that no result depends on."""
    bar: Bar
    material: Material
    bolts: Bolts
    mesh: Mesh
    contact: StaticContact = StaticContact()
    preload_N: Positive | None = None
    """Preload of each bolt, in N, to tabulate the contact while no case uses the assembly."""
    excitation: Point | None = None
    """Where the force acts; by default the middle of the free end's top edge, along z."""
    response: Point | None = None
    """Where the response is observed; by default as the force."""

    @property
    def excitation_point(self) -> Point:
        """Where the harmonic force acts, the default filled in."""
        return self.excitation or self._free_end()

    @property
    def response_point(self) -> Point:
        """Where the response is observed, the default filled in."""
        return self.response or self._free_end()

    @property
    def elements_outside_lap(self) -> tuple[float, float]:
        """Elements along the bars from the clamp to the lap, and from the lap to the free end."""
        wanted = self.mesh.element_length_free_mm
        # whole, but no int: the quotient of what is allowed may be infinite
        before, behind = (max(1.0, round(length / wanted, 0)) for length in self.bar.free_length_mm)
        return before, behind

    @property
    def contact_pairs(self) -> int:
        """Coincident node pairs of the plane of contact, by counting the mesh divisions."""
        mesh = self.mesh
        around = 2 * (mesh.ring_cells_across_width + mesh.ring_cells_along_bar)
        return around * self._rings_of_pairs + (mesh.ring_cells_across_width + 1) * self._columns

    @property
    def pairs_of_one_side(self) -> int:
        """Those on the centre line and to one side of it: the others are their mirror images."""
        on_centre_line = 2 * self._rings_of_pairs + self._columns
        return (self.contact_pairs + on_centre_line) // 2

    @property
    def _rings_of_pairs(self) -> int:
        rings = self.mesh.rings_under_head + self.mesh.rings_head_to_cell_edge
        return len(self.bolts.positions_from_lap_start_mm) * (rings + 1)

    @property
    def _columns(self) -> int:
        """Columns of contact pairs across the bar that belong to no ring."""
        mesh, bolts = self.mesh, len(self.bolts.positions_from_lap_start_mm)
        between = (bolts - 1) * (mesh.columns_between_bolt_cells - 1)
        return between + 2 * mesh.columns_at_each_lap_end

    def _free_end(self) -> Point:
        return Point(x_mm=self.bar.length_mm, y_mm=0.0, z_mm=self.bar.height_mm / 2, direction="z")

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        yield from self._conflicts_of_head()
        yield from self._conflicts_of_positions()
        for key in ("excitation", "response"):
            point = getattr(self, key)
            if point is not None:
                yield from self._conflicts_of_point(key, point)

    def _conflicts_of_head(self) -> Iterator[tuple[KeyPath, str]]:
        for room, what in (
            (self.bar.width_mm, "the bar's width"),
            (self.mesh.bolt_cell_length_mm, "the bolt cell's length"),
        ):
            if self.bolts.head_diameter_mm >= room:
                yield (
                    ("bolts", "head_diameter_mm"),
                    f"must be less than {what} of {room:g} mm",
                )

    def _conflicts_of_positions(self) -> Iterator[tuple[KeyPath, str]]:
        key = ("bolts", "positions_from_lap_start_mm")
        positions = self.bolts.positions_from_lap_start_mm
        # to a nanometre: less room than that is a rounding error of the sums below
        pitches = [round(right - left, 6) for left, right in pairwise(positions)]
        if any(pitch <= 0 for pitch in pitches):
            yield key, "must be ascending"
            return

        cell = self.mesh.bolt_cell_length_mm
        for index, pitch in enumerate(pitches, start=1):
            for length, what in (
                (self.bolts.hole_diameter_mm, "holes"),
                (self.bolts.head_diameter_mm, "heads"),
                (cell, "bolt cells"),
            ):
                if pitch <= length:
                    yield (
                        (*key, index),
                        f"is {pitch:g} mm from the bolt before it, where {what} of {length:g} mm "
                        f"overlap or touch: must be more than {cell:g} mm from it",
                    )
                    break

        for index, position in enumerate(positions):
            before = round(position - cell / 2, 6)
            behind = round(self.bar.lap_mm - position - cell / 2, 6)
            if before <= 0 or behind <= 0:
                yield (
                    (*key, index),
                    f"puts the bolt's cell outside the lap: must be more than {cell / 2:g} mm "
                    f"(half a bolt cell) from both ends of the lap of {self.bar.lap_mm:g} mm",
                )

    def _conflicts_of_point(self, key: str, point: Point) -> Iterator[tuple[KeyPath, str]]:
        bar = self.bar
        for name, low, high in (
            ("x_mm", 0.0, bar.length_mm),
            ("y_mm", -bar.width_mm / 2, bar.width_mm / 2),
            ("z_mm", -bar.height_mm / 2, bar.height_mm / 2),
        ):
            if not low <= round(getattr(point, name), 6) <= round(high, 6):
                yield (key, name), f"must lie in the assembly, from {low:g} to {high:g} mm"
        # half an element from the clamp the nearest node is as far in it as beyond it
        free_mm = bar.free_length_mm[0] / self.elements_outside_lap[0] / 2
        if 0 <= round(point.x_mm, 6) <= round(free_mm, 6):
            effect = {
                "excitation": "a force there does not excite any mode",
                "response": "no mode moves there",
            }[key]
            yield (key, "x_mm"), f"is in the clamp: {effect}; must be more than {free_mm:g} mm"


class ConstantLoadContact(Entry):
    """Friction elements whose normal load stays what the preload made it."""

    law: Literal["constant"]
    """The contact law: constant or variable normal load."""
    tangential_stiffness_N_per_m: Positive
    """Tangential stiffness of each contact pair, in N/m."""
    friction_coefficient: Positive
    """Coulomb friction coefficient: slip force over normal load."""


class VariableLoadContact(Entry):
    """Friction elements whose normal load changes as the surfaces close, open and separate."""

    law: Literal["variable"]
    """The contact law: constant or variable normal load."""
    tangential_stiffness_N_per_m: Positive
    """Tangential stiffness of each contact pair, in N/m."""
    normal_stiffness_N_per_m: Positive
    """Normal stiffness of each contact pair, in N/m."""
    friction_coefficient: Positive
    """Coulomb friction coefficient: slip force over normal load."""


Contact = Annotated[ConstantLoadContact | VariableLoadContact, Field(discriminator="law")]


class Regions(Entry):
    """How the pairs of the contact surface are gathered in regions."""

    division: Literal["equal-load", "equal-middle-load"] = "equal-load"
    """Bands ``regions=N`` along the bar, of equal shares of the load or of the pressure along the
    middle of the width; ``clusters=N`` are of pairs that move alike."""
    motion: Literal["mean", "load-weighted"] = "mean"
    """How a band moves: as the mean of its pairs, or as their mean weighted by load."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 0.01
    """Largest error of the resonance, over states of slip, by which ``regions=auto`` and
    ``clusters=auto`` choose how many there are, before any response is solved."""


class SolveBlock(Entry):
    """A resonance, the joints whose response is computed around it, and in what they are solved."""

    resonance: ModesCount
    """Which resonance, from 1; not more than there are modes."""
    joints: Several[JointName]
    """Joint models: node-to-node; regions=N or clusters=N, N a number or auto; these with
    /elements=M or /harmonic=M (M fitted elements each) or /table (one tabulated element each)."""
    modes: Several[ModesName] | None = None
    """Modal bases; those of the case when left out."""
    coordinates: Several[CoordinatesName] | None = None
    """Unknowns; those of the case when left out."""
    window_Hz: tuple[Positive, Positive] | None = None
    """Lowest and highest frequency; chosen around the resonance when left out."""

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        if self.window_Hz is not None and self.window_Hz[0] >= self.window_Hz[1]:
            yield ("window_Hz",), "must be the lower frequency, then the higher one"


class Case(Entry):
    """One case study: an assembly under a preload, its contact, forces and the joints compared."""

    description: Description = ""
    """What the case is, in one line; free text that no result depends on."""
    published: Name | None = None
    """Case study of the source whose tables stand beside this case's (resources/source)."""
    assembly: Name
    """The assembly: a file of config/assemblies, without .yaml."""
    preload_N: Positive
    """Preload of each bolt, in N."""
    contact: Contact
    regions: Regions = Regions()
    loss_factor: Annotated[Number, Field(gt=0, lt=1)] = 0.002
    """Structural damping; above 0, since without it a peak has no bound where friction sticks."""
    forces_N: Several[Positive]
    """Amplitudes of the harmonic force, in N; one frequency response for each."""
    march_forces_N: Distinct[Positive] = ()
    """Those forces at whose peaks the node-to-node joint is also marched in time and balanced with
    up to 201 harmonics."""
    modes: Several[ModesName]
    """Modal bases: free-N, the first N bending modes without contact, or enriched-N, N vectors that
    also hold the contact while it sticks, slips or opens."""
    coordinates: Several[CoordinatesName]
    """Unknowns: linear (all modes of the basis), rdnm-N or complex-rdnm-N (N response-dependent
    modes), or backbone (the response rebuilt from the mode at given amplitudes)."""
    solve: Annotated[tuple[SolveBlock, ...], Field(min_length=1)]
    """The resonances, each with the joints that are solved there."""

    @property
    def blocks(self) -> tuple[SolveBlock, ...]:
        """The blocks of ``solve``, with what the case gives for what they leave out."""
        return tuple(
            block.model_copy(
                update={
                    "modes": block.modes or self.modes,
                    "coordinates": block.coordinates or self.coordinates,
                }
            )
            for block in self.solve
        )

    @property
    def bases(self) -> tuple[str, ...]:
        """All modal bases of all blocks, each once, in the order of the file."""
        return tuple(dict.fromkeys(family for block in self.blocks for family in block.modes))

    def joints(self, family: str) -> tuple[str, ...]:
        """All joints that are solved in a modal basis, each once, in the order of the file."""
        blocks = (block for block in self.blocks if family in block.modes)
        return tuple(dict.fromkeys(joint for block in blocks for joint in block.joints))

    def resonances(self, family: str) -> tuple[int, ...]:
        """The resonances that are solved in a modal basis, each once, in the order of the file."""
        blocks = (block for block in self.blocks if family in block.modes)
        return tuple(dict.fromkeys(block.resonance for block in blocks))

    def solved(self) -> Iterator[tuple[str, str, str, int]]:
        """Modal basis, joint, coordinates and resonance of every response, each once."""
        return iter(
            dict.fromkeys(
                (family, joint, coordinates, block.resonance)
                for block in self.blocks
                for family in block.modes
                for joint in block.joints
                for coordinates in block.coordinates
            )
        )

    def partition(self, regions: str) -> dict[str, Any]:
        """The options of ``partition.partition_regions`` for regions or clusters of this name."""
        parsed = names.parse_joint(regions)
        if parsed.division == "clusters":
            how = {"division": "clusters", "motion": "mean"}
        else:
            how = {"division": self.regions.division, "motion": self.regions.motion}
        if parsed.division == "clusters" or parsed.count == "auto":
            # bands of a given number do not depend on what is solved
            how["resonances"] = max(block.resonance for block in self.solve)
        if parsed.count == "auto":
            return {**how, "count": None, "tolerance": self.regions.tolerance}
        return {**how, "count": parsed.count}

    def window_around(self, resonance: int) -> tuple[float, float] | None:
        """The frequencies [Hz] given for a resonance, or None if they are to be chosen."""
        given = (block.window_Hz for block in self.solve if block.resonance == resonance)
        return next(filter(None, given), None)

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        there = ", ".join(f"{force:g}" for force in self.forces_N)
        for index, force in enumerate(self.march_forces_N):
            if force not in self.forces_N:
                yield ("march_forces_N", index), f"must be one of forces_N: {there}"
        yield from dict.fromkeys(
            problem for index in range(len(self.solve)) for problem in self._conflicts_in(index)
        )

    def _conflicts_in(self, index: int) -> Iterator[tuple[KeyPath, str]]:
        """What does not go together in a block, at the key that says it."""
        block, given = self.blocks[index], self.solve[index]
        smallest = min(block.modes, key=names.parse_modes)
        available = names.parse_modes(smallest)
        of_coordinates = (
            ("coordinates",) if given.coordinates is None else ("solve", index, "coordinates")
        )
        for place, name in enumerate(block.coordinates):
            if (names.parse_coordinates(name).count or 0) > available:
                yield (
                    (*of_coordinates, place),
                    f"must not have more modes than the basis {smallest}",
                )
        if block.resonance > available:
            yield (
                ("solve", index, "resonance"),
                f"must be at most {available}, the modes of the basis {smallest}",
            )
        if self.contact.law == "variable":
            for place, name in enumerate(block.joints):
                if names.parse_joint(name).reduction == "table":
                    yield (
                        ("solve", index, "joints", place),
                        "must not be tabulated: a table needs a constant normal load",
                    )

        for before in self.blocks[:index]:
            if before.resonance != block.resonance:
                continue
            if before.window_Hz and block.window_Hz and before.window_Hz != block.window_Hz:
                yield (
                    ("solve", index, "window_Hz"),
                    f"must be [{before.window_Hz[0]:g}, {before.window_Hz[1]:g}], as of the block "
                    f"before it around resonance {block.resonance}",
                )
            for place, name in enumerate(block.joints):
                if (
                    name in before.joints
                    and set(before.modes) & set(block.modes)
                    and set(before.coordinates) & set(block.coordinates)
                ):
                    yield (
                        ("solve", index, "joints", place),
                        f"must not be solved twice: a block before solves it around resonance "
                        f"{block.resonance} in the same basis and coordinates",
                    )


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
    renewal: Literal["within", "after"] = "within"
    """Modes of rdnm-N: those of the solution itself, or of the one before, as in the source study,
    which some paths do not survive; forward differences know the latter only. Modes of
    complex-rdnm-N: renewed until they belong to the solution, or once for each."""
    static_share: StrictBool = True
    """Whether what the excitation does to the modes left out is added to complex-rdnm-N."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 1e-9
    """Residual at which a point is solved, relative to the modal force."""
    largest_step: Positive = 0.07
    """Longest step along the curve, as a relative change of the response."""
    smallest_step: Annotated[Positive, Field(lt=StepControl.first_step)] = 1e-9
    """Shortest step along the curve; a curve that needs a shorter one is given up."""
    target_iterations: Count = 4
    """Newton corrections a point that the step control aims at."""
    most_iterations: Annotated[int, Field(strict=True, ge=2), INTEGRAL] = 12
    """Newton corrections after which a point is tried again with a shorter step."""
    most_solutions: Count = 5000
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
        if self.target_iterations >= self.most_iterations:
            yield (
                ("target_iterations",),
                f"must be less than most_iterations, {self.most_iterations}",
            )


class Enrichment(Entry):
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

    @property
    def options(self) -> dict[str, float]:
        """The parameters of ``structure.enrichment.Enrichment``."""
        options = self.model_dump(exclude={"most"})
        return {"contact_stiffness": options.pop("contact_stiffness_N_per_m"), **options}

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
    enough_s: Positive = 0.5
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
    enrichment: Enrichment = Enrichment()
    solver: Solver = Solver()
    fitting: Fitting = Fitting()
    timing: Timing = Timing()
    convergence: Convergence = Convergence()


class Study(Entry):
    """All that is to be computed: the cases, the assemblies they need, the numerical options."""

    cases: dict[str, Case]
    """The cases that run, by name, in the order of config.yaml."""
    assemblies: dict[str, Assembly]
    """The assemblies that config.yaml names and those that its cases use, by name."""
    enrichment: Enrichment
    solver: Solver
    fitting: Fitting
    timing: Timing
    convergence: Convergence

    def case(self, name: str) -> Case:
        """The case of this name; a ``KeyError`` names the cases there are."""
        if name not in self.cases:
            raise KeyError(f"{shown(name)} is not a case of this study{choice(name, self.cases)}")
        return self.cases[name]


def load_study(
    folder: str | Path,
    changes: Mapping[str, Any] | None = None,
    published: Collection[str] | None = None,
) -> Study:
    """Read and check the configuration of a study.

    Parameters
    ----------
    folder
        The folder that holds ``config/``.
    changes
        Keys that replace those of ``config.yaml``, as the command line gives them: values may still
        be words. Under ``study`` it may name a file, from the folder on, whose keys replace those
        of ``config.yaml`` before. Of keys that hold keys, only those are replaced that are given.
    published
        Case studies of the source that a case may be compared with; any name will do without.

    Raises
    ------
    ConfigError
        With one line for each problem of each file that the study uses.
    """
    reader = _Reader(Path(folder))
    settings = reader.settings(changes or {})
    if reader.problems:
        raise ConfigError(reader.problems)

    # Files named beside a problem are read all the same, to report their problems with it.
    checked = reader.check(Settings, settings, settings.content)
    cases = {}
    named = [(settings, path, name) for path, name in _names(settings.content, "assemblies")]
    for path, name in _names(settings.content, "cases"):
        if name in names.PAGES:
            continue
        file, content = reader.find(CASE_FOLDER, name, settings, path)
        cases[name] = reader.check(Case, file, content)
        if content is not None and _is_name(content.get("assembly")):
            named.append((file, ("assembly",), content["assembly"]))
    assemblies: dict[str, Assembly | None] = {}
    for place, path, name in named:
        file, content = reader.find(ASSEMBLY_FOLDER, name, place, path)
        if name not in assemblies:
            assemblies[name] = reader.check(Assembly, file, content)
    for name, case in cases.items():
        file = f"{CASE_FOLDER}/{name}.yaml"
        if case is not None and (assembly := assemblies[case.assembly]) is not None:
            reader.check_regions(file, case, assembly)
        if case is not None and checked is not None:
            reader.check_options(file, case, checked)
            reader.check_bases(file, case, checked.enrichment, assemblies[case.assembly])
        if case is not None and published is not None:
            reader.check_published(file, case, published)

    if all(cases.values()):
        reader.check_preloads(cases.values(), assemblies)
    if checked is not None:
        reader.check_convergence(settings, checked, cases.values(), assemblies)

    if reader.problems or checked is None:
        raise ConfigError(reader.problems)
    return Study(
        cases=cases,
        assemblies=assemblies,
        enrichment=checked.enrichment,
        solver=checked.solver,
        fitting=checked.fitting,
        timing=checked.timing,
        convergence=checked.convergence,
    )


def _updated(content: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The content with what is given in the changes; both may hold keys in keys."""
    updated = dict(content)
    for key, value in changes.items():
        if isinstance(value, Mapping):
            below = updated.get(key)
            value = _updated(below if isinstance(below, Mapping) else {}, value)
        updated[key] = value
    return updated


class _Settings:
    """The content of config.yaml after what a study file and the command line change of it."""

    def __init__(self) -> None:
        self.content: dict[str, Any] = {}
        self._layers: list[tuple[str, Mapping[str, Any]]] = []

    def update(self, place: str, changes: Mapping[str, Any]) -> None:
        """Replace the keys that a file or the command line holds."""
        self.content = _updated(self.content, changes)
        self._layers.append((place, changes))

    def place(self, path: KeyPath) -> str:
        """What gave the value under a key path, or else what that would stand in."""
        for length in range(len(path), 0, -1):
            for place, changes in reversed(self._layers):
                if _gives(changes, path[:length]):
                    return place
        return CONFIG_FILE


def _gives(content: Any, path: KeyPath) -> bool:  # noqa: ANN401 - YAML
    """Whether the value under a key path, or a list or word in which it would be, is given."""
    for part in path:
        if not isinstance(content, Mapping):
            return True
        if part not in content:
            return False
        content = content[part]
    return True


EntryT = TypeVar("EntryT", bound=Entry)


class _Reader:
    """Reads the files of one study and keeps every problem it meets."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[str] = []
        self._contents: dict[str, Mapping[str, Any] | None] = {}

    def settings(self, changes: Mapping[str, Any]) -> _Settings:
        """The keys of config.yaml, then of the study file, then of the command line."""
        settings = _Settings()
        if (content := self.read(CONFIG_FILE)) is not None:
            settings.update(CONFIG_FILE, content)
        if "study" in changes:
            file = changes["study"]
            if not isinstance(file, str) or "\0" in file:
                self._note(COMMAND_LINE, ("study",), shown(file), "must be the name of a file")
            elif (content := self.read(file)) is not None:
                settings.update(_as_word(file), content)
        try:
            given = {key: value for key, value in changes.items() if key != "study"}
            settings.update(COMMAND_LINE, typed(given))
        except ValueError as error:
            self.problems.append(f"{COMMAND_LINE}: {error}")
        return settings

    def read(self, file: str) -> Mapping[str, Any] | None:
        """The mapping that a file holds; None, with a problem noted, if it holds none."""
        if file not in self._contents:
            self._contents[file] = None
            place = _as_word(file)
            try:
                self._contents[file] = read_mapping(self.folder / file)
            except FileNotFoundError:
                self.problems.append(f"{place}: there is no such file in {self.folder.resolve()}")
            except OSError as error:
                self.problems.append(f"{place}: cannot be read: {error.strerror}")
            except TextError as error:
                self.problems.append(f"{place}{error.place}: {error.sentence}")
        return self._contents[file]

    def find(
        self, folder: str, name: str, place: str | _Settings, path: KeyPath
    ) -> tuple[str, Mapping[str, Any] | None]:
        """The file of this name in a folder and what it holds; ``place`` is where it is named."""
        file = f"{folder}/{name}.yaml"
        if (self.folder / file).exists():
            return file, self.read(file)
        present = sorted(path.stem for path in (self.folder / folder).glob("*.yaml"))
        self._note(place, path, shown(name), f"is not in {folder}{choice(name, present)}")
        return file, None

    def check(
        self, model: type[EntryT], file: str | _Settings, content: Mapping[str, Any] | None
    ) -> EntryT | None:
        """The content as a model; None, with the problems noted, if it is not one."""
        if content is None:
            return None
        try:
            return model.model_validate(content)
        except ValidationError as error:
            for path, value, sentence in explained(error, model, content, names.PATTERNS):
                self._note(file, path, value, sentence)
            return None

    def check_regions(self, file: str, case: Case, assembly: Assembly) -> None:
        """Note each joint with more regions, or elements in all, than there are contact pairs.

        Bands hold each pair with its mirror image, and so are at most as many as on one side.
        """
        pairs = assembly.contact_pairs, f"the contact pairs of {case.assembly}"
        of_one_side = assembly.pairs_of_one_side, _pairs_of_one_side(case.assembly)
        for block_index, block in enumerate(case.solve):
            for index, joint in enumerate(block.joints):
                parsed = names.parse_joint(joint)
                regions = 1 if parsed.count == "auto" else parsed.count or 0
                for count, what, (most, of_what) in (
                    (
                        regions,
                        parsed.division,
                        of_one_side if parsed.division == "regions" else pairs,
                    ),
                    (regions * (parsed.elements or 0), "elements in all", pairs),
                ):
                    if count > most:
                        self._note(
                            file,
                            ("solve", block_index, "joints", index),
                            shown(joint),
                            f"must have at most {most} {what}, {of_what}",
                        )
                        break

    def check_options(self, file: str, case: Case, settings: Settings) -> None:
        """Note what the numerical options of the study do not allow in a case."""
        for problem in dict.fromkeys(_conflicts_with_options(case, settings)):
            self._note(file, *problem)

    def check_preloads(
        self, cases: Collection[Case], assemblies: Mapping[str, Assembly | None]
    ) -> None:
        """Note each assembly that is to have an enriched basis but no contact to make it from."""
        used = {case.assembly for case in cases}
        enriched = [name for case in cases for name in case.bases if names.is_enriched(name)]
        for name, assembly in assemblies.items():
            if enriched and assembly and name not in used and assembly.preload_N is None:
                sentence = f"is missing: {enriched[0]} is made from the contact under preload"
                self._note(f"{ASSEMBLY_FOLDER}/{name}.yaml", ("preload_N",), None, sentence)

    def check_bases(
        self, file: str, case: Case, enrichment: Enrichment, assembly: Assembly | None
    ) -> None:
        """Note each enriched basis of more vectors than are found."""
        for family in case.bases:
            sentence = _too_large(family, enrichment, {case.assembly: assembly})
            if sentence:
                key = next(
                    ("modes",) if block.modes is None else ("solve", index, "modes")
                    for index, block in enumerate(case.solve)
                    if family in (block.modes or case.modes)
                )
                self._note(file, key, shown(family), sentence)

    def check_convergence(
        self,
        settings: _Settings,
        checked: Settings,
        cases: Collection[Case | None],
        assemblies: Mapping[str, Assembly | None],
    ) -> None:
        """Note bases and numbers of regions that an assembly does not have."""
        for index, basis in enumerate(checked.convergence.bases):
            if sentence := _too_large(basis, checked.enrichment, assemblies):
                self._note(settings, ("convergence", "bases", index), shown(basis), sentence)
        divided = dict.fromkeys(
            case.assembly for case in cases if case and any(map(names.is_enriched, case.bases))
        )
        for index, count in enumerate(checked.convergence.regions):
            for name in divided:
                assembly = assemblies[name]
                if assembly and count > (most := assembly.pairs_of_one_side):
                    sentence = f"must be at most {most}, {_pairs_of_one_side(name)}"
                    self._note(settings, ("convergence", "regions", index), shown(count), sentence)
                    break

    def check_published(self, file: str, case: Case, published: Collection[str]) -> None:
        """Note a case study that the source does not have."""
        if case.published is not None and case.published not in published:
            sentence = f"is no case study of the source{choice(case.published, published)}"
            self._note(file, ("published",), shown(case.published), sentence)

    def _note(self, file: str | _Settings, path: KeyPath, value: str | None, sentence: str) -> None:
        place = file if isinstance(file, str) else file.place(path)
        keys = "".join(
            f"[{part}]" if isinstance(part, int) else f".{_as_word(part)}" for part in path
        )
        what = sentence if value is None else f"{value} {sentence}"
        self.problems.append(f"{place}: {keys.removeprefix('.')}: {what}")


def _as_word(text: str) -> str:
    """A key or file name as it is, or in quotes and cut where it is no plain word."""
    return text if re.fullmatch(r"[\w./=+~-]{1,200}", text) else shown(text)


def _pairs_of_one_side(assembly: str) -> str:
    return f"the contact pairs of {assembly} on one side of the centre line and on it"


def _too_large(
    basis: str, enrichment: Enrichment, assemblies: Mapping[str, Assembly | None]
) -> str | None:
    """What an enriched basis of more vectors than are found must be, for the first assembly."""
    if not names.is_enriched(basis):
        return None
    number = names.parse_modes(basis)
    if number > enrichment.most:
        return f"must have at most {enrichment.most} vectors, as enrichment.most in {CONFIG_FILE}"
    for name, assembly in assemblies.items():
        if assembly is None:
            continue
        # candidates: modes, and the shapes of a force along and across the contact on every pair
        candidates = enrichment.free_modes + 2 * assembly.pairs_of_one_side
        if number > candidates:
            return (
                f"must have at most {candidates} vectors: enrichment.free_modes, and two for each "
                f"of {_pairs_of_one_side(name)}"
            )
    return None


def _conflicts_with_options(case: Case, settings: Settings) -> Iterator[tuple[KeyPath, str, str]]:
    """Key path, value and sentence for what a case asks for and the study's options do not do."""
    most, harmonics = settings.enrichment.resonances, settings.solver.harmonics
    for index, block in enumerate(case.blocks):
        enriched = [name for name in block.modes if names.is_enriched(name)]
        if enriched and block.resonance > most:
            sentence = f"must be at most {most}, enrichment.resonances, in {enriched[0]}"
            yield ("solve", index, "resonance"), shown(block.resonance), sentence
        of_block = ("solve", index) if case.solve[index].coordinates else ()
        for place, name in enumerate(block.coordinates):
            if harmonics > 1 and names.parse_coordinates(name).kind in ("complex", "backbone"):
                sentence = f"must be linear or rdnm-N with solver.harmonics: {harmonics}"
                yield (*of_block, "coordinates", place), shown(name), sentence


def _names(content: Mapping[str, Any], key: str) -> Iterator[tuple[KeyPath, str]]:
    """The well-formed names in the list under a key, each with its key path."""
    listed = content.get(key)
    if isinstance(listed, list | tuple):
        yield from (((key, index), name) for index, name in enumerate(listed) if _is_name(name))


def _is_name(value: object) -> bool:
    return isinstance(value, str) and re.fullmatch(names.NAME, value) is not None


SCHEMAS: dict[str, type[Entry]] = {"config": Settings, "assembly": Assembly, "case": Case}


def schema_text(model: type[Entry]) -> str:
    """The JSON schema of a YAML file, as the text that is kept in config/schemas."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **model.model_json_schema(),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def write_schemas(folder: str | Path) -> None:
    """Write the JSON schemas of the YAML files into a folder."""
    for name, model in SCHEMAS.items():
        path = Path(folder) / f"{name}.schema.json"
        path.write_text(schema_text(model), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the JSON schemas of the YAML files.")
    parser.add_argument("folder", nargs="?", default=SCHEMA_FOLDER, help="default: %(default)s")
    write_schemas(parser.parse_args().folder)
