"""A case: an assembly under a preload, with contact, forces and the joints to compare."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from boltjoint import names
from boltjoint.config.entries import Distinct, Entry, KeyPath, Number, Positive, Several
from boltjoint.config.types import (
    CoordinatesName,
    Description,
    JointName,
    ModesCount,
    ModesName,
    Name,
)


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
    verification_forces_N: Distinct[Positive] = ()
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
        for index, force in enumerate(self.verification_forces_N):
            if force not in self.forces_N:
                yield ("verification_forces_N", index), f"must be one of forces_N: {there}"
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
