"""CalculiX on a deck: its bodies and constraints in its own words, and what it finds of them.

Whatever program the deck is of, parts, included meshes and units are read before, so that CalculiX
gets nodes, elements, ties, couplings, sections and contact in SI units. It joins, cuts and searches
contact in its own way: ties move nodes onto faces, contact is face to face by a penalty.

References
----------
G. Dhondt: CalculiX CrunchiX user's manual, version 2.20.
"""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint.config.deck import Deck as Description
from boltjoint.config.deck import DeckContact
from boltjoint.structure.bolt_tension import tension_of
from boltjoint.structure.calculix_comparison import (
    PRESTRESSED_MODES,
    Verified,
    compare_frequencies,
    elastic,
    prestressed_frequencies,
    row,
)
from boltjoint.structure.calculix_program import fields, paragraphs, tables_after
from boltjoint.structure.elements.assembly import ElementBlock
from boltjoint.structure.makers.deck.beams_springs_masses import bolt_beams
from boltjoint.structure.makers.deck.content import Coupling, Reference
from boltjoint.structure.makers.deck.distributing import node_of_element
from boltjoint.structure.makers.deck.interfaces import faces_of_contact, tied_pairs
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Faces, Mesh
from boltjoint.structure.makers.deck.pretension import SectionBolt, bolts_of
from boltjoint.structure.makers.deck.summary import described_mesh, supports_of

_MM = 1e-3
_DIRECTIONS = 3
#: numbers of a line
_A_LINE = 8
#: density of beams [kg/m3]: CalculiX needs some
_NO_MASS = 1e-6


def write_decks(
    model: Verified,
    modes: xr.Dataset,
    preload: float | tuple[float, ...],
    paths: Mapping[str, str | Path],
) -> None:
    """Write the decks of modes without contact, of the preload, and of modes under it.

    Parameters
    ----------
    model
        The assembly.
    modes
        As from ``find_modes``: as many are asked for.
    preload
        Tension of the bolts [N]: a number for all, or one for each.
    paths
        ``modes``, ``preload`` and ``prestressed``: files ending in ``.inp``, whose folders are
        made.

    Raises
    ------
    ValueError
        If the deck has what is not written: file, line and keyword.
    """
    description, mesh = _mesh(model)
    writer = _Writer(description, mesh)
    rigid = model.structure.rigid_body_motions.shape[1]
    count = modes.sizes.get("candidate", modes.sizes["mode"]) + rigid
    frequency = ["*FREQUENCY", f"{count}"]
    held = ["*BOUNDARY", *(f"{label}, 1, 1" for label in writer.section_labels)]
    held = held if writer.section_labels else []
    # round beams of two nodes are allowed with a section alone
    closed = [*writer.sections, *held] if writer.has_beams else writer.model
    _write(paths["modes"], [*closed, *_step("", frequency)])
    contact = writer.contact()
    tight = ["*STATIC", "1., 1.", *writer.tightening(preload)]
    step = _step(", INC=1000", [*tight, *writer.prints])
    _write(paths["preload"], [*writer.sections, *contact, *step])
    under = [*held, "*FREQUENCY", f"{PRESTRESSED_MODES + rigid}"]
    _write(
        paths["prestressed"],
        [
            *writer.sections,
            *writer.contact(has_friction=False),
            *_step(", INC=1000", tight),
            *_step(", PERTURBATION", under),
        ],
    )


def compare(
    model: Verified, modes: xr.Dataset, preload: xr.Dataset, printed: Mapping[str, str | Path]
) -> pd.DataFrame:
    """What both programs find; what CalculiX did not solve has no number.

    Parameters
    ----------
    model
        The assembly.
    modes, preload
        As from ``find_modes`` and ``apply_preload``.
    printed
        ``modes``, ``preload`` and ``prestressed``: files ending in ``.dat``.
    """
    description = model.described
    rows: list[dict[str, object]] = []
    if model.structure.base_springs is None:
        name = "candidate_frequency" if "candidate_frequency" in modes else "natural_frequency"
        ours = elastic(modes[name].to_numpy())
        theirs = _frequencies(printed["modes"])
        rows += compare_frequencies("natural frequency", ours, theirs)
    ours = prestressed_frequencies(model.structure, preload.attrs["preload_N"])
    rows += compare_frequencies(
        "frequency under preload", ours, _frequencies(printed["prestressed"])
    )
    forces = _normal_forces(printed["preload"])
    load, surface = preload["normal_load"].to_numpy(), preload["surface"].to_numpy().astype(str)
    area = preload["area"].to_numpy()
    for number, interface in enumerate(_contact_of(description)):
        own = surface == interface.name
        force, under = forces[number] if number < len(forces) else (np.nan, np.nan)
        rows.append(row(f"normal force of {interface.name}", "N", load[own].sum(), force))
        closed = area[own & (load > 0)].sum()
        rows.append(row(f"area under load of {interface.name}", "mm2", 1e6 * closed, 1e6 * under))
    return pd.DataFrame(rows)


def _mesh(model: Verified) -> tuple[Description, Mesh]:
    if not isinstance(model.described, Description):
        raise ValueError(f"an assembly of type {model.described.type} is no deck")
    return model.described, described_mesh(model.described, model.folder)


def _contact_of(described: object) -> Iterable[DeckContact]:
    return described.contact if isinstance(described, Description) else ()


def _step(options: str, lines: Iterable[str]) -> list[str]:
    return [f"*STEP{options}", *lines, "*END STEP"]


class _Writer:
    """Bodies of a deck in the words of CalculiX: nodes and elements are numbered from 1."""

    def __init__(self, description: Description, mesh: Mesh) -> None:
        self._description, self._mesh, self._deck = description, mesh, mesh.deck
        left_out = [("*TRANSFORM", axes.nodes.place) for axes in self._deck.axes]
        left_out += [("elements MASS", mass.elements.place) for mass in self._deck.masses]
        left_out += [("elements SPRINGA", spring.elements.place) for spring in self._deck.springs]
        for what, place in left_out:
            raise ValueError(f"{place}: {what} cannot be written for CalculiX yet")
        self._names, self._elements = iter(range(1, 10**6)), len(self._deck.numbers)
        self._beam_numbers: dict[int, int] = {}
        self.section_labels: list[int] = []
        self.prints: list[str] = []
        bodies = [*self._nodes(), *self._solids(), *self._beams(), *self._weighted_couplings()]
        self.has_beams = bool(self._beam_numbers)
        self.model = [*bodies, *self._ties(), *self._constraints()]
        #: the same with bolts that can be tightened
        self.sections = [*self.model, *self._sections()]

    def _nodes(self) -> Iterator[str]:
        yield "*NODE, NSET=ALL"
        for number, place in enumerate(self._mesh.coordinate, 1):
            yield f"{number}, {fields(*place)}"

    def _solids(self) -> Iterator[str]:
        length, mass, _ = self._description.units.factors
        blocks = self._mesh.blocks(self._description.units.pascal, mass / length**3)
        for solid, block in zip(self._mesh.solids, blocks, strict=True):
            yield f"*ELEMENT, TYPE={solid.kind.name}"
            for place, node in zip(solid.place, solid.node, strict=True):
                yield from _lines([place + 1, *(node + 1)])
            yield from self._materials(solid.place, block)

    def _materials(self, place: Indices, block: ElementBlock) -> Iterator[str]:
        """Each material of some elements."""
        constants = np.broadcast_arrays(
            block.material.youngs_modulus,
            block.material.poissons_ratio,
            block.material.density,
            place,
        )
        values = np.column_stack(constants[:3])
        materials, number = np.unique(values, axis=0, return_inverse=True)
        for index, (modulus, ratio, density) in enumerate(materials):
            name = f"M{next(self._names)}"
            yield from (f"*MATERIAL, NAME={name}", "*ELASTIC", fields(modulus, ratio))
            yield from ("*DENSITY", fields(density), f"*ELSET, ELSET={name}")
            yield from _lines(place[number.ravel() == index] + 1)
            yield f"*SOLID SECTION, ELSET={name}, MATERIAL={name}"

    def _surface(self, faces: Faces) -> tuple[str, list[str]]:
        """Name and lines of a surface of faces."""
        name = f"S{next(self._names)}"
        rows = zip((faces.element + 1).tolist(), (faces.number + 1).tolist(), strict=True)
        return name, [f"*SURFACE, NAME={name}", *(f"{element}, S{face}" for element, face in rows)]

    def _of_reference(self, reference: Reference) -> tuple[str, list[str]]:
        """A surface of the deck, of faces or nodes."""
        if not self._deck.surface(reference).of_nodes:
            return self._surface(self._mesh.faces(reference))
        name = f"S{next(self._names)}"
        nodes = self._mesh.nodes_of_surface(reference)
        return name, [f"*SURFACE, NAME={name}, TYPE=NODE", *(f"{node + 1}," for node in nodes)]

    def _ties(self) -> Iterator[str]:
        """Ties, and contact pairs that have no friction here."""
        description, metre = self._description, self._mesh.metre
        every = description.ties.tolerance_mm
        pairs = [(tie.slave, tie.master, tie.tolerance) for tie in self._deck.ties]
        pairs += [
            (pair.slave, pair.master, None) for pair in tied_pairs(description.contact, self._deck)
        ]
        adjust = "NO" if description.ties.adjust == "none" else "YES"
        for slave, master, tolerance in pairs:
            (first, of_slave), (second, of_master) = map(self._of_reference, (slave, master))
            own = metre * tolerance if every is None and tolerance is not None else None
            own = _MM * every if every is not None else own
            within = "" if own is None else f", POSITION TOLERANCE={own:.12e}"
            yield from (*of_slave, *of_master)
            yield f"*TIE, NAME=T{next(self._names)}, ADJUST={adjust}{within}"
            yield f"{first}, {second}"

    def _constraints(self) -> Iterator[str]:
        deck = self._deck
        for equation in deck.equations:
            nodes = [deck.nodes_of(term.node) for term in equation.terms]
            for together in zip(*nodes, strict=True) if nodes else ():
                yield from ("*EQUATION", f"{len(together)}")
                for node, term in zip(together, equation.terms, strict=True):
                    yield f"{node + 1}, {term.dof}, {term.coefficient:.12e}"
        for coupling in deck.couplings:
            if coupling.of_surface:
                yield from self._coupling(coupling)
        for body in deck.rigid_bodies:
            kind, number = (
                ("ELSET", deck.elements_of)
                if body.kind == "elements"
                else (
                    "NSET",
                    deck.nodes_of,
                )
            )
            name = f"R{next(self._names)}"
            yield f"*{kind}, {kind}={name}"
            yield from _lines(number(body.nodes) + 1)
            yield f"*RIGID BODY, {kind}={name}, REF NODE={deck.node_of(body.reference) + 1}"
        boundaries = supports_of(self._description, deck)
        if boundaries:
            yield "*BOUNDARY"
        of_solids = set(self._mesh.nodes.tolist())
        for boundary in boundaries:
            for node in deck.nodes_of(boundary.nodes).tolist():
                last = min(boundary.last, _DIRECTIONS) if node in of_solids else boundary.last
                if boundary.first <= last:
                    yield f"{node + 1}, {boundary.first}, {last}"

    def _coupling(self, coupling: Coupling) -> Iterator[str]:
        reference = self._deck.node_of(coupling.reference) + 1
        name, lines = self._of_reference(coupling.nodes)
        yield from lines
        yield f"*COUPLING, REF NODE={reference}, SURFACE={name}, CONSTRAINT NAME=C{name}"
        yield f"*{coupling.kind.upper()}"
        yield from (f"{dof}, {dof}" for dof in coupling.dofs)

    def _weighted_couplings(self) -> Iterator[str]:
        """Means of nodes with weights that a node follows, by elements DCOUP3D."""
        joined: dict[int, list[Coupling]] = {}
        for coupling in self._deck.couplings:
            if not coupling.of_surface:
                joined.setdefault(node_of_element(self._deck, coupling), []).append(coupling)
        for node, couplings in joined.items():
            number, name = self._next_element(), f"D{next(self._names)}"
            yield from (f"*ELEMENT, TYPE=DCOUP3D, ELSET={name}", f"{number}, {node + 1}")
            yield f"*DISTRIBUTING COUPLING, ELSET={name}"
            for coupling in couplings:
                weight = fields(coupling.weights[0] if coupling.weights else 1.0)
                yield from (f"{n + 1}, {weight}" for n in self._deck.nodes_of(coupling.nodes))

    def _next_element(self) -> int:
        self._elements += 1
        return self._elements

    def _beams(self) -> Iterator[str]:
        """Beams of bolts, each with the number of its element kept."""
        units, metre = self._description.units, self._mesh.metre
        for bolt in bolt_beams(self._deck):
            number, name = self._next_element(), f"B{next(self._names)}"
            self._beam_numbers[id(bolt.section)] = number
            modulus, ratio = self._deck.materials[bolt.beam.material.upper()].elasticity
            one, other = (bolt.nodes + 1).tolist()
            yield from (f"*ELEMENT, TYPE=B31, ELSET={name}", f"{number}, {one}, {other}")
            yield from (
                f"*MATERIAL, NAME={name}",
                "*ELASTIC",
                fields(modulus * units.pascal, ratio),
            )
            # beams of bolts have no mass
            yield from ("*DENSITY", fields(_NO_MASS))
            yield f"*BEAM SECTION, ELSET={name}, MATERIAL={name}, SECTION={bolt.beam.kind}"
            # a circle has two radii for CalculiX
            sizes = 2 * bolt.beam.sizes if len(bolt.beam.sizes) == 1 else bolt.beam.sizes
            yield fields(*(metre * size for size in sizes))
            yield fields(*bolt.axes(self._mesh.coordinate)[1])

    def _sections(self) -> Iterator[str]:
        """Sections of bolts that are cut, and the numbers of their nodes."""
        for section in self._deck.pretension:
            label = self._deck.node_of(section.node) + 1
            self.section_labels.append(label)
            if section.surface is not None:
                name, lines = self._of_reference(section.surface)
                yield from lines
                yield f"*PRE-TENSION SECTION, SURFACE={name}, NODE={label}"
            else:
                number = self._beam_numbers[id(section)]
                yield f"*PRE-TENSION SECTION, ELEMENT={number}, NODE={label}"
            if any(section.normal):
                yield fields(*section.normal)

    def contact(self, *, has_friction: bool = True) -> list[str]:
        """Pairs of surfaces in contact, and which results of them are printed."""
        lines, self.prints = [], []
        for interface in self._description.contact:
            name = f"I{next(self._names)}"
            (slave, of_slave), (master, of_master) = map(
                self._surface, faces_of_contact(self._mesh, interface)
            )
            lines += [*of_slave, *of_master, f"*SURFACE INTERACTION, NAME={name}"]
            lines += ["*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"]
            lines += [fields(interface.penalty_N_per_m3)]
            if has_friction and interface.friction_coefficient:
                lines += ["*FRICTION"]
                lines += [fields(interface.friction_coefficient, interface.penalty_N_per_m3)]
            lines += [f"*CONTACT PAIR, INTERACTION={name}, TYPE=SURFACE TO SURFACE, SMALL SLIDING"]
            lines += [f"{slave}, {master}"]
            if not self._description.has_initial_gap:
                lines += [f"*CLEARANCE, MASTER={master}, SLAVE={slave}, VALUE=0."]
            self.prints += [f"*CONTACT PRINT, MASTER={master}, SLAVE={slave}, FREQUENCY=1000", "CF"]
        return lines

    def tightening(self, preload: float | tuple[float, ...]) -> list[str]:
        """Forces of the bolts."""
        bolts = bolts_of(self._deck, self._description.wanted_bolts)
        lines = ["*CLOAD"]
        for bolt, tension in zip(bolts, tension_of(preload, len(bolts)).tolist(), strict=True):
            if isinstance(bolt, SectionBolt):
                label = self._deck.node_of(self._deck.pretension[bolt.section].node) + 1
                lines.append(f"{label}, 1, {tension:.12e}")
                continue
            for node, sign in zip(bolt.node.tolist(), (1.0, -1.0), strict=True):
                force = sign * tension * bolt.direction
                lines += [f"{node + 1}, {dof}, {x:.12e}" for dof, x in enumerate(force, 1) if x]
        return lines


def _lines(numbers: Iterable[int]) -> Iterator[str]:
    """Numbers in lines that end with a comma where they go on."""
    numbers = [int(number) for number in numbers]
    for first in range(0, len(numbers), _A_LINE):
        yield ", ".join(map(str, numbers[first : first + _A_LINE])) + ","


def _write(path: str | Path, lines: Iterable[str]) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")


def _frequencies(path: str | Path) -> np.ndarray:
    """Elastic natural frequencies [Hz] that CalculiX printed, none where it printed none."""
    tables = tables_after("CYCLES/TIME", paragraphs(path))
    return elastic(tables[0][:, 3]) if tables else np.zeros(0)


def _normal_forces(path: str | Path) -> list[tuple[float, float]]:
    """Normal force [N], positive in compression, and area under load [m2] of each pair."""
    tables = tables_after("area,  normal force", paragraphs(path))
    return [(-float(table[0, 1]), float(table[0, 0])) for table in tables]
