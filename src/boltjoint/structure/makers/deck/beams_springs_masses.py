"""Beams of bolts, springs between nodes, and masses of nodes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from boltjoint.structure.makers.deck.content import Beam, Deck, PretensionSection
from boltjoint.structure.makers.deck.labels import Indices
from boltjoint.structure.makers.deck.mesh import Mesh
from boltjoint.structure.makers.deck.unknowns import AXES, Unknowns

Array = NDArray[np.float64]

#: sine of an angle below which two directions are the same, and difference of equal sections
_ACROSS = 1e-6


@dataclass(frozen=True, eq=False)
class BoltBeam:
    """A beam B31 with a section, whose shortening tightens it.

    ``nodes`` are its two ends, ``section`` that of the deck, ``beam`` its cross-section.
    """

    nodes: Indices
    section: PretensionSection
    beam: Beam

    @property
    def shear_factor(self) -> float:
        """Area that takes shear over the whole, as Abaqus has it."""
        return {"CIRC": 0.89, "RECT": 0.85, "PIPE": 0.53}[self.beam.kind]

    def axes(self, coordinate: Array) -> Array:
        """Unit vectors along the beam and across it, as the widths of its section: shape (3, 3).

        Parameters
        ----------
        coordinate
            Of the nodes of its deck, shape (nodes, 3).

        Raises
        ------
        ValueError
            If it has no length, or the first axis of a section that is not the same in all
            directions is along it.
        """
        along = np.subtract(*coordinate[self.nodes[::-1]])
        if not along.any():
            raise ValueError(f"{self.section.place}: the beam of the bolt has no length")
        along = along / np.linalg.norm(along)
        first = np.array(self.beam.first_axis) / np.linalg.norm(self.beam.first_axis)
        across = first - (first @ along) * along
        if np.linalg.norm(across) < _ACROSS:
            _, second, third, _ = self.sizes
            if abs(second - third) > _ACROSS * second:
                raise ValueError(
                    f"{self.beam.place}: *BEAM SECTION: its first axis {self.beam.first_axis} is "
                    "along the beam: it must be across it, where the two widths differ"
                )
            across = np.eye(3)[np.argmin(abs(along))]
            across = across - (across @ along) * along
        across /= np.linalg.norm(across)
        return np.stack([along, across, np.cross(along, across)])

    @property
    def sizes(self) -> tuple[float, float, float, float]:
        """Area, both second moments and that of torsion, in units of the deck."""
        if self.beam.kind == "RECT":
            a, b = self.beam.sizes
            long, short = max(a, b), min(a, b)
            ratio = short / long
            torsion = long * short**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))
            return a * b, a * b**3 / 12, b * a**3 / 12, torsion
        outer = self.beam.sizes[0]
        inner = outer - self.beam.sizes[1] if self.beam.kind == "PIPE" else 0.0
        second = np.pi / 4 * (outer**4 - inner**4)
        return np.pi * (outer**2 - inner**2), second, second, 2 * second


def bolt_beams(deck: Deck) -> list[BoltBeam]:
    """The beams of a deck, each of which must be a bolt.

    Raises
    ------
    ValueError
        If a beam has no section, or none of BEAM SECTION or of PRE-TENSION SECTION.
    """
    bolts = []
    of_bolts: list[int] = []
    for section in deck.pretension:
        if section.element is None:
            continue
        place = deck.elements_of(section.element)
        nodes = np.concatenate(
            [block.node[np.isin(block.place, place)] for block in _beams(deck)]
            + [np.zeros((0, 2), np.int64)]
        )
        if len(nodes) != 1:
            raise ValueError(
                f"{section.place}: *PRE-TENSION SECTION: ELEMENT={section.element.text} is no "
                "element B31: surfaces of solid elements are given by SURFACE"
            )
        beam = next(
            (other for other in deck.beams if place[0] in deck.elements_of(other.elements)), None
        )
        if beam is None:
            raise ValueError(
                f"{section.place}: *PRE-TENSION SECTION: element {section.element.text} has no "
                "*BEAM SECTION"
            )
        of_bolts.append(int(place[0]))
        bolts.append(BoltBeam(nodes[0], section, beam))
    for block in _beams(deck):
        others = np.setdiff1d(block.place, of_bolts)
        if others.size:
            raise ValueError(
                f"{deck.file}: {deck.numbers.name(int(others[0]))} (B31) is no bolt: beams are "
                "read where a *PRE-TENSION SECTION, ELEMENT= tightens them"
            )
    return bolts


def _beams(deck: Deck) -> Iterator:
    return (block for block in deck.elements if block.kind == "B31")


def turning_beams(deck: Deck) -> list[Indices]:
    """Ends of beams where a constraint knows a rotation: others turn freely, as bars do."""
    turning = {
        int(node)
        for equation in deck.equations
        for term in equation.terms
        if term.dof > AXES
        for node in deck.nodes_of(term.node)
    }
    turning |= {deck.node_of(body.reference) for body in deck.rigid_bodies}
    turning |= {
        deck.node_of(coupling.reference) for coupling in deck.couplings if coupling.of_surface
    }
    return [beam.nodes for beam in bolt_beams(deck) if turning & set(beam.nodes.tolist())]


def stiffness(
    beams: Sequence[BoltBeam], unknowns: Unknowns, mesh: Mesh, pascal: float
) -> sparse.csc_array:
    """Stiffness of bolts: along the axis with their shortening, and bending where ends turn."""
    total = sparse.csc_array((unknowns.size, unknowns.size))
    first = len(unknowns.sections) - len(beams)
    for number, bolt in enumerate(beams):
        material = mesh.deck.materials[bolt.beam.material.upper()]
        modulus, ratio = material.elasticity
        E = pascal * modulus
        shear = E / (2 * (1 + ratio))
        scale = mesh.metre ** np.array([2, 4, 4, 4])
        area, second, third, torsion = scale * np.array(bolt.sizes)
        axes = bolt.axes(mesh.coordinate)
        length = float(np.linalg.norm(np.subtract(*mesh.coordinate[bolt.nodes])))
        columns = unknowns.translations(bolt.nodes)
        shortening = np.array([unknowns.shortening(first + number)])
        # elongation with the shortening of the shank
        row = np.concatenate([-axes[0], axes[0], [1.0]])
        place = np.concatenate([columns.ravel(), shortening])
        total = total + _added(E * area / length * np.outer(row, row), place, unknowns.size)
        ends = [unknowns.rotations(int(node)) for node in bolt.nodes]
        turned = [end for end in ends if end is not None]
        if len(turned) < len(ends):
            continue
        effective = bolt.shear_factor * shear * area
        block = _bending(E, (second, third, shear * torsion), effective, length, axes)
        of_ends = [part for end in range(2) for part in (columns[end], turned[end])]
        total = total + _added(block, np.concatenate(of_ends), unknowns.size)
    return total


def _bending(
    E: float, moments: tuple[float, float, float], shear: float, length: float, axes: Array
) -> Array:
    """Bending and torsion of a beam that shears, unknowns u and rotation of both ends.

    ``moments``: both second moments, and the stiffness in torsion; ``shear``: stiffness in shear.

    References
    ----------
    J. S. Przemieniecki: Theory of Matrix Structural Analysis. McGraw-Hill, 1968, section 5.6.
    """
    second, third, torsion = moments
    K = np.zeros((12, 12))
    for moment, shift, turn, sign in ((third, 1, 5, 1.0), (second, 2, 4, -1.0)):
        place = np.array([shift, turn, 6 + shift, 6 + turn])
        # deflection by shear over that by bending, of ends that do not turn
        share = 12 * E * moment / (shear * length**2)
        a, b = 12 / length**3, sign * 6 / length**2
        c, d = (4 + share) / length, (2 - share) / length
        own = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
        own *= E * moment / (1 + share)
        K[np.ix_(place, place)] += own
    K[np.ix_([3, 9], [3, 9])] += torsion / length * np.array([[1, -1], [-1, 1]])
    turned = np.kron(np.eye(4), axes)
    return np.asarray(turned.T @ K @ turned, float)


def _added(block: Array, place: Indices, size: int) -> sparse.csc_array:
    row, column = np.meshgrid(place, place, indexing="ij")
    entries = block.ravel(), (row.ravel(), column.ravel())
    return sparse.coo_array(entries, shape=(size, size)).tocsc()


def spring_stiffness(mesh: Mesh, size: int, newton: float) -> sparse.csc_array:
    """Stiffness of springs SPRINGA along the lines between their nodes."""
    deck, total = mesh.deck, sparse.csc_array((size, size))
    for spring in deck.springs:
        place = deck.elements_of(spring.elements)
        for elements in deck.elements:
            if elements.kind != "SPRINGA":
                continue
            for node in elements.node[np.isin(elements.place, place)]:
                along = np.subtract(*mesh.coordinate[node[::-1]])
                length = np.linalg.norm(along)
                if not length > 0:
                    raise ValueError(
                        f"{spring.elements.place}: *SPRING: the nodes of a spring of set "
                        f"{spring.elements.text} lie on one spot"
                    )
                row = np.concatenate([-along, along]) / length
                columns = (AXES * node[:, None] + np.arange(AXES)).ravel()
                factor = spring.value * newton / mesh.metre
                total = total + _added(factor * np.outer(row, row), columns, size)
    return total


def point_masses(mesh: Mesh, size: int, kilogram: float) -> sparse.csc_array:
    """Masses of the elements MASS."""
    deck, diagonal = mesh.deck, np.zeros(size)
    for mass in deck.masses:
        place = deck.elements_of(mass.elements)
        for elements in deck.elements:
            if elements.kind == "MASS":
                node = elements.node[np.isin(elements.place, place), 0]
                for axis in range(AXES):
                    np.add.at(diagonal, AXES * node + axis, kilogram * mass.value)
    return sparse.diags_array(diagonal, format="csc")
