"""The structure of matrices or modes from another program: contact, bolts, rows by variables."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, cholesky

from boltjoint.config.matrices import Matrices, MatrixBolt, MatrixRow
from boltjoint.config.matrix_contact import MatrixContact, Plane
from boltjoint.structure.contact_points import DIRECTIONS, ContactPoints, relative_of_pairs
from boltjoint.structure.makers.matrices.modal_data import read_modal_data
from boltjoint.structure.makers.matrices.reader import Reader
from boltjoint.structure.makers.matrices.source import Source, read_sizes
from boltjoint.structure.model import Bolt, Row, Structure, unit_row

Array = NDArray[np.float64]

#: of the maker
NAME = "matrices"
#: degrees of freedom up to which matrices are factorized to see that they are positive
_FEW = 3000
#: eigenvalue of a matrix of unit diagonal that is zero within the rounding of ten digits
_ROUNDING = 1e-8


def structure_of_matrices(described: Matrices, folder: str | Path) -> Structure:
    """The structure that files describe, by matrices or by modes.

    Parameters
    ----------
    described
        Names of files and variables.
    folder
        Folder of the study, in which all files lie.

    Raises
    ------
    ValueError
        If a file or a variable is not there, damaged, not finite, of another size, or no structure
        (``Structure``), or if degrees of freedom need more memory than this machine has: file,
        variable and problem in one line.
    """
    reader = Reader(described, folder)
    sizes, source = read_sizes(described, reader)
    # lengths in mm go with N and t, so that q of any kind scales as lengths do
    metre = 1.0 if described.length_unit == "m" else 1e-3
    if described.modes is not None:
        source = replace(source, modes=read_modal_data(described.modes, reader))
        K, M = source.of_modes.matrices(1 / metre)
        places = dict.fromkeys(
            ("stiffness", "mass"), reader.place(described.modes.natural_frequency)
        )
    else:
        names = {"stiffness": described.stiffness, "mass": described.mass}
        shape = sizes.dofs, sizes.dofs
        K, M = (reader.matrix(name, shape) / metre for name in names.values())
        places = {key: reader.place(name) for key, name in names.items()}
        _check_diagonals(described, reader, K, M)
    bolts = tuple(_bolt(bolt, source) for bolt in described.bolts)
    inputs, outputs = (_rows(rows, source) for rows in (described.inputs, described.outputs))
    support = None
    if described.support is not None:
        given = reader.matrix(described.support, (DIRECTIONS, source.dofs))
        support = source.rows(given.toarray() / metre)
    contact = _contact(source, sizes.points, metre)
    places |= {f"load of {bolt.name}": _place_of(bolt, reader) for bolt in described.bolts}
    with _placed(places, places["stiffness"]):
        structure = Structure(
            K,
            M,
            contact,
            bolts,
            inputs,
            outputs,
            support=support,
            factorisation=described.factorisation,
            maker=NAME,
        )
        for name, matrix in (("stiffness", structure.stiffness), ("mass", structure.mass)):
            _check_positive(name, matrix)
        return structure.with_rigid_motions()


def _contact(source: Source, points: int, metre: float) -> ContactPoints:
    described, reader = source.described, source.reader
    contact = described.contact
    area = reader.array(contact.area, (points,), above=0)
    number = np.zeros(points, dtype=np.int64)
    if contact.surface is not None:
        number = reader.numbers(contact.surface, (points,), len(contact.surfaces))
    planes = contact.surfaces or (contact,)
    frame = _frames(described, reader, number)
    gap, normal_load = np.zeros(points), None
    if contact.gap is not None:
        gap = reader.array(contact.gap, (points,), at_least=0)
    if contact.normal_load is not None:
        normal_load = _normal_load(contact.normal_load, gap, source)
    penalty, friction_coefficient = (
        np.array([_first_given(plane, contact, key) for plane in planes])[number]
        for key in ("penalty_N_per_m3", "friction_coefficient")
    )
    surface = np.array(described.surface_names)[number]
    if contact.relative is not None:
        relative, sides = _relative(source, frame), None
    else:
        side_a, side_b = sides = _sides(source, points)
        relative = relative_of_pairs(side_a, side_b, source.dofs, frame)
    if sides is None or (data := source.modes) is None or data.position is None:
        position = reader.array(contact.position, (points, DIRECTIONS))
    else:
        position = np.mean([data.position[side[:, 0] // DIRECTIONS] for side in sides], axis=0)
    return ContactPoints(
        sparse.csr_array(source.rows(relative)),
        position=metre * position,
        area=metre**2 * area,
        frame=frame,
        gap=metre * gap,
        surface=surface,
        penalty=penalty,
        friction_coefficient=friction_coefficient,
        normal_load=normal_load,
    )


def _normal_load(name: str, gap: Array, source: Source) -> Array:
    """Normal loads of the points [N], of which none has a gap too."""
    reader, first = source.reader, source.described.first_number
    load = reader.array(name, gap.shape, at_least=0)
    if not load.any():
        raise ValueError(f"{reader.place(name)} is zero: nothing is pressed together")
    if (both := np.flatnonzero((load > 0) & (gap > 0))).size:
        where = f"point {both[0] + first}"
        raise ValueError(f"{reader.place(name)}: {where} has a load of {load[both[0]]:g} and a gap")
    return load


def _first_given(plane: Plane, contact: MatrixContact, key: str) -> float:
    """The value of a surface, or else of all."""
    own = getattr(plane, key)
    return getattr(contact, key) if own is None else own


def _frames(described: Matrices, reader: Reader, number: NDArray[np.int64]) -> Array:
    """Directions of two tangents and the normal at each point, whose surface has this number."""
    contact, shape = described.contact, (len(number), DIRECTIONS, DIRECTIONS)
    if contact.frame is not None:
        is_flat = reader.size(contact.frame).shape == (len(number), DIRECTIONS**2)
        rows = reader.array(contact.frame, (len(number), DIRECTIONS**2) if is_flat else shape)
        frame = rows.reshape(shape)
        products = np.einsum("pij,pkj->pik", frame, frame)
        wrong = abs(products - np.eye(DIRECTIONS)).max(axis=(1, 2)) > _ROUNDING
        if wrong.any():
            point = int(np.argmax(wrong)) + described.first_number
            raise ValueError(
                f"{reader.place(contact.frame)}: directions of point {point} are not orthonormal"
            )
        # to rounding: the nearest that are
        u, _, v = np.linalg.svd(frame)
        return u @ v
    frames = []
    for plane in contact.surfaces or (contact,):
        normal, tangent = (
            np.array(direction, dtype=float) for direction in contact.directions(plane)
        )
        normal /= np.linalg.norm(normal)
        tangent = tangent - (tangent @ normal) * normal
        tangent /= np.linalg.norm(tangent)
        frames.append([tangent, np.cross(normal, tangent), normal])
    return np.array(frames)[number]


def _relative(source: Source, frame: Array) -> sparse.csr_array:
    """Rows of relative displacements along the frames, point by point."""
    described, reader = source.described, source.reader
    contact, points = described.contact, len(frame)
    name = contact.relative or ""
    relative = reader.matrix(name, (DIRECTIONS * points, source.dofs)).tocsr()
    if contact.relative_by == "direction":
        relative = relative[np.arange(DIRECTIONS * points).reshape(DIRECTIONS, points).T.ravel()]
    if contact.relative_along == "xyz":
        blocks = frame, np.arange(points), np.arange(points + 1)
        relative = sparse.bsr_array(blocks, shape=2 * (DIRECTIONS * points,)).tocsr() @ relative
    empty = np.flatnonzero(abs(relative).sum(axis=1) == 0)
    # modes may all leave a point at rest
    if empty.size and described.modes is None:
        point = int(empty[0]) // DIRECTIONS + described.first_number
        raise ValueError(
            f"{reader.place(name)}: point {point} has a direction in which no degree of freedom "
            "moves it"
        )
    return sparse.csr_array(relative)


def _sides(source: Source, points: int) -> list[NDArray[np.int64]]:
    """Degrees of freedom of the nodes on both sides of pairs, (points, 3)."""
    described, reader = source.described, source.reader
    contact, sides = described.contact, []
    for side in (contact.side_a, contact.side_b):
        if side is not None and source.of_nodes:
            numbers = reader.whole_numbers(side, (points,))
            sides.append(source.dofs_of_nodes(f"{reader.place(side)}: one of them", numbers))
        elif side is not None:
            sides.append(reader.numbers(side, (points, DIRECTIONS), source.dofs))
    if same := np.flatnonzero(np.any(sides[0] == sides[1], axis=1)).tolist():
        raise ValueError(
            f"{reader.place(str(contact.side_b))}: pair {same[0] + described.first_number} has a "
            f"degree of freedom that {contact.side_a} has too: a node cannot meet itself"
        )
    return sides


def _bolt(bolt: MatrixBolt, source: Source) -> Bolt:
    locked, reader = None, source.reader
    if bolt.load is not None:
        load = source.rows(reader.column(bolt.load, source.dofs, bolt.column))
        if not load.any():
            raise ValueError(f"{reader.place(bolt.load)} is zero: a tension of 1 N has forces")
    else:
        locked = source.dof(f"locked of bolt {bolt.name}", bolt.locked)
        load = unit_row(locked, source.dofs)
    diameter, modulus = bolt.shank_diameter_mm, bolt.youngs_modulus_GPa
    axis = None if bolt.axis is None else np.array(bolt.axis, dtype=float)
    return Bolt(
        name=bolt.name,
        load=load,
        locked=locked,
        axis=None if axis is None else axis / np.linalg.norm(axis),
        position=None if bolt.position_mm is None else 1e-3 * np.array(bolt.position_mm),
        section=None if diameter is None else pi / 4 * (1e-3 * diameter) ** 2,
        youngs_modulus=None if modulus is None else 1e9 * modulus,
    )


def _rows(points: Iterable[MatrixRow], source: Source) -> dict[str, Row]:
    rows = {}
    for point in points:
        if point.row is not None:
            row, place = source.reader.column(point.row, source.dofs, point.column), point.row
        else:
            row, place = unit_row(_dof_of(point, source), source.dofs), source.holder
        row = source.rows(row)
        if not row.any():
            raise ValueError(f"{source.reader.place(place)} is zero: nothing moves at {point.name}")
        rows[point.name] = Row(row, point.direction or "")
    return rows


def _dof_of(point: MatrixRow, source: Source) -> int:
    """The degree of freedom that is a place, or that of a node along its direction."""
    if point.node is None:
        return source.dof(f"dof of {point.name}", point.dof)
    (dofs,) = source.dofs_of_nodes(f"node of {point.name}", np.array([point.node]))
    return int(dofs["xyz".index(point.direction or "x")])


def _place_of(bolt: MatrixBolt, reader: Reader) -> str:
    return reader.place(bolt.load) if bolt.load is not None else f"bolt {bolt.name}"


def _check_diagonals(
    described: Matrices, reader: Reader, K: sparse.csc_array, M: sparse.csc_array
) -> None:
    """Refuse degrees of freedom without stiffness and mass, and matrices that are not positive."""
    first = described.first_number
    for name, matrix in ((described.stiffness, K), (described.mass, M)):
        diagonal, largest = matrix.diagonal(), abs(matrix).max(axis=0).toarray().ravel()
        if (wrong := np.flatnonzero(diagonal < 0)).size:
            raise ValueError(
                f"{reader.place(name)} is not positive: its diagonal is {diagonal[wrong[0]]:g} at "
                f"degree of freedom {wrong[0] + first}"
            )
        if (wrong := np.flatnonzero((diagonal == 0) & (largest > 0))).size:
            raise ValueError(
                f"{reader.place(name)} is not positive: its diagonal is 0 at degree of freedom "
                f"{wrong[0] + first}, and other entries are not"
            )
    if (empty := np.flatnonzero((K.diagonal() == 0) & (M.diagonal() == 0))).size:
        raise ValueError(
            f"{reader.place(described.stiffness)}: degree of freedom {empty[0] + first} has "
            "neither stiffness nor mass: leave it out, as constraints do"
        )


def _check_positive(name: str, matrix: sparse.csc_array) -> None:
    """Refuse a matrix with a negative eigenvalue, beyond rounding, where it is small enough."""
    size = matrix.diagonal()
    if len(size) > _FEW:
        return
    scale = 1 / np.sqrt(np.where(size > 0, size, 1.0))
    scaled = scale[:, None] * matrix.toarray() * scale
    scaled[np.diag_indices_from(scaled)] += _ROUNDING
    try:
        cholesky(scaled, lower=True, overwrite_a=True, check_finite=False)
    except LinAlgError:
        raise ValueError(f"{name} is not positive: it has a negative eigenvalue") from None


@contextmanager
def _placed(places: Mapping[str, str], otherwise: str) -> Iterator[None]:
    """Put file and variable before what is wrong with a structure."""
    try:
        yield
    except (ValueError, RuntimeError) as error:
        text = " ".join(str(error).split())
        place = next((each for start, each in places.items() if text.startswith(start)), otherwise)
        raise ValueError(f"{place}: {text}") from error
