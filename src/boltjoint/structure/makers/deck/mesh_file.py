"""Meshes of gmsh and VTU files as lines of a deck: nodes, solid elements, and sets by their groups.

A deck includes such a file, and says itself what a mesh does not know: materials, ties, bolts.

References
----------
C. Geuzaine, J.-F. Remacle: Gmsh: a 3-D finite element mesh generator with built-in pre- and
post-processing facilities. Int. J. for Numerical Methods in Engineering 79 (2009) 1309-1331.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import meshio
import numpy as np
from numpy.typing import NDArray

from boltjoint.structure.elements.kinds import KINDS

Indices = NDArray[np.int64]

#: what reads a file, by the sign that it begins with, as no line of a deck does
_READERS = {b"$": meshio.gmsh.read, b"<": meshio.vtu.read}
#: kind of the solid elements of a deck, by the cells that meshio names; nodes are in the same order
_SOLIDS = {"tetra": "C3D4", "tetra10": "C3D10", "wedge": "C3D6", "wedge15": "C3D15"}
_SOLIDS |= {"hexahedron": "C3D8", "hexahedron20": "C3D20"}
#: corners of faces
_FACES = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4}
#: cells that are sets of nodes alone
_LINES = {"vertex", "line", "line3"}
#: numbers on a line at most: an element of 20 nodes is on one
_ON_LINE = 21


class _Group(NamedTuple):
    """Cells of a block of the mesh that have a name together."""

    name: str
    block: int
    cells: Indices


def is_mesh(path: Path) -> bool:
    """Whether a file is a mesh, by its begin; decks may have the same endings."""
    return _sign(path) in _READERS


def _sign(path: Path) -> bytes:
    with path.open("rb") as content:
        return content.read(80).lstrip()[:1]


def lines_of_mesh(folder: Path, file: str) -> Iterator[str]:
    """Lines of a deck that tell the mesh of a file.

    Nodes and solid elements have numbers in the order of the file. A group of solids is a set of
    elements; one of faces a surface, of the faces S1 to S6 of solids; one of any cells a set of
    nodes. All solids are in the set that is named as the file is, without its ending.

    Parameters
    ----------
    folder
        In which the file lies.
    file
        The mesh; of gmsh, physical groups have their names, of others and of VTU files the name of
        an array of whole numbers with each of its values, as ``part-1``.

    Raises
    ------
    ValueError
        If it is no mesh, has cells that are not read, or faces on no solid: one line of text.
    """
    mesh = _read(folder, file)
    yield "*NODE"
    for number, (x, y, z) in enumerate(mesh.points.tolist(), 1):
        yield f"{number}, {x!r}, {y!r}, {z!r}"
    first = 1
    numbers: dict[int, Indices] = {}
    for place, cells in enumerate(mesh.cells):
        if cells.type not in _SOLIDS:
            continue
        numbers[place] = first + np.arange(len(cells.data))
        first += len(cells.data)
        yield f"*ELEMENT, TYPE={_SOLIDS[cells.type]}, ELSET={Path(file).stem}"
        yield from _rows(np.column_stack([numbers[place], cells.data + 1]))
    for name, block, of_group in _groups(mesh, file):
        cells = mesh.cells[block]
        chosen = cells.data[of_group]
        if block in numbers:
            yield f"*ELSET, ELSET={name}"
            yield from _rows([numbers[block][of_group]])
        elif cells.type in _FACES:
            yield f"*SURFACE, NAME={name}"
            on_solids = _on_solids(mesh, numbers, chosen[:, : _FACES[cells.type]])
            if len(on_solids) < len(chosen):
                missing = len(chosen) - len(on_solids)
                raise ValueError(f"{file}: {missing} faces of {name} are on no solid element")
            for element, face in on_solids.tolist():
                yield f"{element}, S{face}"
        yield f"*NSET, NSET={name}"
        yield from _rows([np.unique(chosen) + 1])


def _rows(values: Iterable[Indices]) -> Iterator[str]:
    """Whole numbers as data lines; a set goes on in the next."""
    for row in values:
        for begin in range(0, len(row), _ON_LINE):
            yield ", ".join(map(str, row[begin : begin + _ON_LINE].tolist()))


def _read(folder: Path, file: str) -> meshio.Mesh:
    path = folder / file
    try:
        mesh = _READERS[_sign(path)](path)
    except (meshio.ReadError, ValueError, LookupError, TypeError, AssertionError) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ValueError(f"{file} cannot be read as a mesh: {first}") from error
    unread = {cells.type for cells in mesh.cells} - set(_SOLIDS) - set(_FACES) - _LINES
    if unread:
        known = ", ".join(_SOLIDS)
        raise ValueError(f"{file} has cells that are not read, {', '.join(unread)}: {known} are")
    return mesh


def _groups(mesh: meshio.Mesh, file: str) -> Iterator[_Group]:
    """Groups by the whole numbers that cells have; 0 of gmsh is none."""
    names = {tuple(value): name for name, value in mesh.field_data.items()}
    for key, of_blocks in mesh.cell_data.items():
        if key == "gmsh:geometrical":
            continue
        for block, values in enumerate(of_blocks):
            if values.ndim > 1 or not np.issubdtype(values.dtype, np.integer):
                continue
            for value in np.unique(values).tolist():
                if key != "gmsh:physical":
                    name = f"{key}-{value}"
                elif value:
                    name = names.get((value, mesh.cells[block].dim), f"physical-{value}")
                else:
                    continue
                if set(",=*") & set(name):
                    raise ValueError(f"{file}: group {name!r} must have a name without , = *")
                yield _Group(name, block, np.flatnonzero(values == value))


def _on_solids(mesh: meshio.Mesh, numbers: dict[int, Indices], corners: Indices) -> Indices:
    """Element and number of its face, (faces, 2): of two, that from which the face looks away."""
    count = corners.shape[1]
    found: dict[tuple[int, ...], list[tuple[int, int, tuple[int, ...]]]] = {
        tuple(sorted(face)): [] for face in corners.tolist()
    }
    on_faces = np.zeros(len(mesh.points), bool)
    on_faces[corners] = True
    for block, number in numbers.items():
        kind = KINDS[_SOLIDS[mesh.cells[block].type]]
        for label, of_face in enumerate(kind.corners_of_faces, 1):
            if len(of_face) != count:
                continue
            nodes = mesh.cells[block].data[:, list(of_face)]
            for row in np.flatnonzero(on_faces[nodes].all(axis=1)):
                face = nodes[row].tolist()
                if (key := tuple(sorted(face))) in found:
                    found[key].append((int(number[row]), label, _turned(face)))
    chosen = []
    for face in corners.tolist():
        solids = found[tuple(sorted(face))]
        outward = [solid for solid in solids if solid[2] == _turned(face)]
        chosen += [one[:2] for one in (outward or solids)[:1]]
    return np.array(chosen, dtype=np.int64).reshape(-1, 2)


def _turned(face: list[int]) -> tuple[int, ...]:
    """Corners of a face from the least of them on, in their order."""
    first = face.index(min(face))
    return (*face[first:], *face[:first])
