"""Keywords of decks that tell nodes, elements, sets, surfaces and directions."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.makers.deck import lines
from boltjoint.structure.makers.deck.content import (
    Axes,
    FacePiece,
    Reading,
    Reference,
    SurfaceLines,
)
from boltjoint.structure.makers.deck.labels import Members, Sets, scoped
from boltjoint.structure.makers.deck.lines import Block

Array = NDArray[np.float64]

#: nodes of an element, by its kind
SOLIDS = {
    "C3D4": 4,
    "C3D10": 10,
    "C3D6": 6,
    "C3D15": 15,
    "C3D8": 8,
    "C3D8I": 8,
    "C3D8R": 8,
    "C3D20": 20,
    "C3D20R": 20,
}
#: those that are no solids: beams are bolts
_OTHERS = {"B31": 2, "DCOUP3D": 1, "MASS": 1, "SPRINGA": 2}
#: those that a description may read as others of as many nodes
LIKE_SOLIDS = {"C3D10M": 10, "C3D10H": 10, "C3D10MH": 10, "C3D10HS": 10, "C3D10I": 10, "C3D4H": 4}
LIKE_SOLIDS |= {"C3D6H": 6, "C3D8H": 8, "C3D8IH": 8, "C3D8RH": 8, "C3D15H": 15, "C3D20H": 20}
LIKE_SOLIDS |= {"C3D20RH": 20, "C3D4T": 4, "C3D8T": 8, "C3D10T": 10}


def node(reading: Reading, block: Block) -> None:
    """NODE: numbers and coordinates, in the coordinates of SYSTEM or of cylinders."""
    label, coordinate = lines.numbered_reals(block, 3)
    kind = block.options.get("SYSTEM", "R").upper()
    if kind == "C":
        angle = np.deg2rad(coordinate[:, 1])
        along = coordinate[:, 0, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        coordinate = np.column_stack([along, coordinate[:, 2]])
    elif kind != "R":
        raise block.refused(f"SYSTEM={kind} is not read: R or C")
    reading.add_nodes(label, coordinate, block)
    if name := block.options.get("NSET"):
        reading.deck.node_sets.add(reading.scope, name, Members(reading.scope, block.place, label))


def element(reading: Reading, block: Block) -> None:
    """ELEMENT: kind, numbers and nodes."""
    kind = block.option("TYPE").upper()
    lengths = SOLIDS | _OTHERS
    length = (lengths | {own: LIKE_SOLIDS[own] for own in reading.kinds if own in LIKE_SOLIDS}).get(
        kind
    )
    if length is None:
        like = f": elements: {{{kind}: {kind[:5].rstrip('HMT')}}} of the assembly reads it so"
        raise block.refused(
            f"TYPE={kind} is not read{like if kind in LIKE_SOLIDS else ''}; there are: "
            f"{', '.join(lengths)}"
        )
    record = lines.records(block, length + 1)
    reading.add_elements(reading.kinds.get(kind, kind), record[:, 0], record[:, 1:], block)
    if name := block.options.get("ELSET"):
        members = Members(reading.scope, block.place, record[:, 0])
        reading.deck.element_sets.add(reading.scope, name, members)


def nset(reading: Reading, block: Block) -> None:
    """NSET: numbers of nodes, ranges of them, or names of sets."""
    _add_set(reading, block, reading.deck.node_sets, block.option("NSET"))


def elset(reading: Reading, block: Block) -> None:
    """ELSET: numbers of elements, ranges of them, or names of sets."""
    _add_set(reading, block, reading.deck.element_sets, block.option("ELSET"))


def _add_set(reading: Reading, block: Block, sets: Sets, name: str) -> None:
    within = block.options.get("INSTANCE", reading.scope).upper()
    if within and within not in reading.instances:
        raise block.refused(f"there is no instance {within}")
    members = Members(within, block.place)
    if "GENERATE" in block.options:
        members.is_range = True
        members.labels = np.concatenate(
            [np.zeros(0, np.int64), *(_range(block, row) for row in range(len(block.rows)))]
        )
    elif block.keyword == "NSET" and block.options.get("ELSET"):
        members.nodes_of = block.options["ELSET"]
    elif (labels := _plain_numbers(block)) is not None:
        members.labels = labels
    else:
        # in the order of the lines, which UNSORTED keeps
        for row in range(len(block.rows)):
            for text in filter(None, block.fields(row)):
                place = block.place_of(row)
                if lines.is_whole(text):
                    label = np.array([lines.whole(block, row, text)])
                    sets.add(reading.scope, name, Members(within, place, label))
                else:
                    sets.add(reading.scope, name, Members(within, place, names=[text]))
    # a set of the assembly stands in no instance, whatever its members do
    sets.add(reading.scope, name, members)


def _plain_numbers(block: Block) -> NDArray[np.int64] | None:
    tokens = ",".join(row.rstrip(", ") for row in block.rows).split(",")
    try:
        return np.array(tokens, dtype=np.int64) if block.rows else None
    except (ValueError, OverflowError):
        return None


def _range(block: Block, row: int) -> NDArray[np.int64]:
    bounds = [lines.whole(block, row, field) for field in block.fields(row) if field]
    if not bounds:
        return np.zeros(0, np.int64)
    first, last = bounds[0], bounds[1] if len(bounds) > 1 else bounds[0]
    step = bounds[2] if len(bounds) > 2 else 1
    if step < 1 or last < first or (last - first) // step > lines.MOST:
        raise block.refused(f"{block.rows[row]!r} is no range: first, last, step", row)
    return np.arange(first, last + 1, step)


def surface(reading: Reading, block: Block) -> None:
    """SURFACE: faces of elements by their numbers S1 to S6, free faces of a set, or nodes."""
    name = block.option("NAME")
    kind = block.options.get("TYPE", "ELEMENT").upper()
    if kind not in ("ELEMENT", "NODE"):
        raise block.refused(f"TYPE={kind} is not read: ELEMENT or NODE")
    key = scoped(reading.scope, name)
    surface_lines = reading.deck.surfaces.setdefault(
        key, SurfaceLines(name, block.place, kind == "NODE")
    )
    for row in range(len(block.rows)):
        fields = block.fields(row)
        if not fields or not fields[0]:
            continue
        reference = Reference(fields[0], reading.scope, block.place_of(row))
        face = fields[1].upper() if len(fields) > 1 and kind == "ELEMENT" else ""
        if face and not (len(face) == 2 and face[0] == "S" and face[1] in "123456"):
            raise block.refused(f"face {face} is not read: S1 to S6", row)
        surface_lines.pieces.append(FacePiece(reference, int(face[1]) if face else None))


def system(reading: Reading, block: Block) -> None:
    """SYSTEM: coordinates in which the nodes that follow are given."""
    if not block.rows:
        reading.system = (np.eye(3), np.zeros(3))
        return
    first = lines.reals(block, 0, 6)
    origin, x = np.array(first[:3]), np.array(first[3:])
    if len(block.fields(0)) <= 3:
        reading.system = (np.eye(3), origin)
        return
    if len(block.rows) > 1:
        second = np.array(lines.reals(block, 1, 3)) - origin
    else:
        second = np.cross([0.0, 0.0, 1.0], x - origin)
    reading.system = (directions(x - origin, second, block), origin)


def transform(reading: Reading, block: Block) -> None:
    """TRANSFORM: directions of the displacements of a set of nodes."""
    kind = block.options.get("TYPE", "R").upper()
    if kind not in ("R", "C"):
        raise block.refused(f"TYPE={kind} is not read: R or C")
    reference = Reference(block.option("NSET"), reading.scope, block.place)
    points = tuple(lines.reals(block, 0, 6))
    if kind == "R":
        directions(np.array(points[:3]), np.array(points[3:]), block)
    reading.deck.axes.append(Axes(reference, kind, points))


def directions(first: Array, second: Array, block: Block) -> Array:
    """Orthonormal directions, as rows, of the first and a vector in the plane of the second."""
    length = np.linalg.norm(first)
    normal = np.cross(first, second)
    if not (length > 0 and np.linalg.norm(normal) > 1e-9 * length * np.linalg.norm(second)):
        raise block.refused("its points lie on a line: they are no directions")
    x, z = first / length, normal / np.linalg.norm(normal)
    return np.stack([x, np.cross(z, x), z])


HANDLERS = {
    "NODE": node,
    "ELEMENT": element,
    "NSET": nset,
    "ELSET": elset,
    "SURFACE": surface,
    "SYSTEM": system,
    "TRANSFORM": transform,
}
