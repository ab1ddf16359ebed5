"""The structure of matrices from another program: contact, bolts and rows by variables."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from math import pi, prod
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, cholesky

from boltjoint.config.matrices import Matrices, MatrixBolt, MatrixContact, MatrixRow, Plane
from boltjoint.structure.contact_points import DIRECTIONS, ContactPoints, relative_of_pairs
from boltjoint.structure.makers.matrices.reader import Reader
from boltjoint.structure.model import Bolt, Row, Structure, unit_row

Array = NDArray[np.float64]

#: of the maker
NAME = "matrices"
#: degrees of freedom up to which matrices are factorized to see that they are positive
_FEW = 3000
#: eigenvalue of a matrix of unit diagonal that is zero within the rounding of ten digits
_ROUNDING = 1e-8
#: bytes of the factors over dofs^(4/3), the fill of a body in space, as measured for half laps
_FACTORS = 350


class Sizes(NamedTuple):
    """Numbers of degrees of freedom, contact points and bolts."""

    dofs: int
    points: int
    bolts: int


def sizes_of_matrices(described: Matrices, folder: str | Path) -> Sizes:
    """Sizes of a structure, of which only the heads of the files are read.

    Parameters
    ----------
    described, folder
        As for ``structure_of_matrices``.

    Raises
    ------
    ValueError
        If a variable is not there, K is not square, M has another size, or a degree of freedom is
        not there.
    """
    return _sizes(described, Reader(described, folder))


def _sizes(described: Matrices, reader: Reader) -> Sizes:
    name = described.stiffness
    size = reader.size(name)
    if len(size.shape) != 2 or size.shape[0] != size.shape[1] or not size.shape[0]:
        raise ValueError(f"{reader.place(name)} has shape {size.shape}: it must be square")
    points = prod(reader.size(described.contact.area).shape)
    dofs = size.shape[0]
    needed = max(_FACTORS * dofs ** (4 / 3), 2 * size.memory)
    reader.require_memory(name, needed, f"has {dofs} degrees of freedom")
    mass = reader.size(described.mass)
    if mass.shape != size.shape:
        place = reader.place(described.mass)
        raise ValueError(f"{place} has shape {mass.shape}, expected {size.shape}")
    for variable in dict.fromkeys(described.variables.values()):
        reader.size(variable)
    for bolt in described.bolts:
        if bolt.locked is not None:
            _dof(f"locked of bolt {bolt.name}", bolt.locked, described, reader, dofs)
    for row in (*described.inputs, *described.outputs):
        if row.dof is not None:
            _dof(f"dof of {row.name}", row.dof, described, reader, dofs)
    return Sizes(dofs, points, len(described.bolts))


def structure_of_matrices(described: Matrices, folder: str | Path) -> Structure:
    """The structure that files describe.

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
    sizes = _sizes(described, reader)
    dofs, K_name, M_name = sizes.dofs, described.stiffness, described.mass
    # lengths in mm go with N and t, so that q of any kind scales as lengths do
    metre = 1.0 if described.length_unit == "m" else 1e-3
    K, M = (reader.matrix(name, (dofs, dofs)) / metre for name in (K_name, M_name))
    bolts = tuple(_bolt(bolt, described, reader, dofs) for bolt in described.bolts)
    inputs = _rows(described.inputs, described, reader, dofs)
    outputs = _rows(described.outputs, described, reader, dofs)
    support = None
    if described.support is not None:
        support = reader.matrix(described.support, (DIRECTIONS, dofs)).toarray() / metre
    contact = _contact(described, reader, sizes, metre)
    places = {"stiffness": reader.place(K_name), "mass": reader.place(M_name)}
    places |= {f"load of {bolt.name}": _place_of(bolt, reader) for bolt in described.bolts}
    _check_diagonals(described, reader, K, M)
    with _placed(places, reader.place(K_name)):
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


def _contact(described: Matrices, reader: Reader, sizes: Sizes, metre: float) -> ContactPoints:
    contact, points = described.contact, sizes.points
    area = reader.array(contact.area, (points,), above=0)
    position = reader.array(contact.position, (points, DIRECTIONS))
    number = np.zeros(points, dtype=np.int64)
    if contact.surface is not None:
        number = reader.numbers(contact.surface, (points,), len(contact.surfaces))
    planes = contact.surfaces or (contact,)
    frame = _frames(described, reader, number)
    gap = np.zeros(points)
    if contact.gap is not None:
        gap = reader.array(contact.gap, (points,), at_least=0)
    penalty, friction_coefficient = (
        np.array([_first_given(plane, contact, key) for plane in planes])[number]
        for key in ("penalty_N_per_m3", "friction_coefficient")
    )
    surface = np.array(described.surface_names)[number]
    rows = _relative if contact.relative is not None else _relative_of_nodes
    return ContactPoints(
        rows(described, reader, frame, sizes.dofs),
        position=metre * position,
        area=metre**2 * area,
        frame=frame,
        gap=metre * gap,
        surface=surface,
        penalty=penalty,
        friction_coefficient=friction_coefficient,
    )


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
            point = int(np.argmax(wrong)) + described.numbered_from
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


def _relative(described: Matrices, reader: Reader, frame: Array, dofs: int) -> sparse.csr_array:
    """Rows of relative displacements along the frames, point by point."""
    contact, points = described.contact, len(frame)
    relative = reader.matrix(contact.relative or "", (DIRECTIONS * points, dofs)).tocsr()
    if contact.relative_by == "direction":
        relative = relative[np.arange(DIRECTIONS * points).reshape(DIRECTIONS, points).T.ravel()]
    if contact.relative_along == "xyz":
        blocks = frame, np.arange(points), np.arange(points + 1)
        relative = sparse.bsr_array(blocks, shape=2 * (DIRECTIONS * points,)).tocsr() @ relative
    if (empty := np.flatnonzero(abs(relative).sum(axis=1) == 0)).size:
        point = int(empty[0]) // DIRECTIONS + described.numbered_from
        raise ValueError(
            f"{reader.place(contact.relative or '')}: point {point} has a direction in which no "
            "degree of freedom moves it"
        )
    return sparse.csr_array(relative)


def _relative_of_nodes(
    described: Matrices, reader: Reader, frame: Array, dofs: int
) -> sparse.csr_array:
    """Rows of relative displacements of pairs of nodes along the frames, point by point."""
    contact, points = described.contact, len(frame)
    sides = [
        reader.numbers(side, (points, DIRECTIONS), dofs)
        for side in (contact.side_a, contact.side_b)
        if side is not None
    ]
    if same := np.flatnonzero(np.any(sides[0] == sides[1], axis=1)).tolist():
        raise ValueError(
            f"{reader.place(str(contact.side_b))}: pair {same[0] + described.numbered_from} has a "
            f"degree of freedom that {contact.side_a} has too: a node cannot meet itself"
        )
    return relative_of_pairs(sides[0], sides[1], dofs, frame)


def _bolt(bolt: MatrixBolt, described: Matrices, reader: Reader, dofs: int) -> Bolt:
    locked = None
    if bolt.load is not None:
        load = reader.column(bolt.load, dofs, bolt.column)
        if not load.any():
            raise ValueError(f"{reader.place(bolt.load)} is zero: a tension of 1 N has forces")
    else:
        locked = _dof(f"locked of bolt {bolt.name}", bolt.locked, described, reader, dofs)
        load = unit_row(locked, dofs)
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


def _rows(
    points: Iterable[MatrixRow], described: Matrices, reader: Reader, dofs: int
) -> dict[str, Row]:
    rows = {}
    for point in points:
        if point.row is not None:
            row = reader.column(point.row, dofs, point.column)
            if not row.any():
                raise ValueError(f"{reader.place(point.row)} is zero: nothing moves there")
        else:
            row = unit_row(_dof(f"dof of {point.name}", point.dof, described, reader, dofs), dofs)
        rows[point.name] = Row(row, point.direction or "")
    return rows


def _dof(what: str, number: int | None, described: Matrices, reader: Reader, dofs: int) -> int:
    """A degree of freedom from 0, of its number."""
    first = described.numbered_from
    if number is None or not first <= number < first + dofs:
        raise ValueError(
            f"{reader.place(described.stiffness)} has degrees of freedom from {first} to "
            f"{first + dofs - 1}: {what} is {number}"
        )
    return number - first


def _place_of(bolt: MatrixBolt, reader: Reader) -> str:
    return reader.place(bolt.load) if bolt.load is not None else f"bolt {bolt.name}"


def _check_diagonals(
    described: Matrices, reader: Reader, K: sparse.csc_array, M: sparse.csc_array
) -> None:
    """Refuse degrees of freedom without stiffness and mass, and matrices that are not positive."""
    first = described.numbered_from
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
