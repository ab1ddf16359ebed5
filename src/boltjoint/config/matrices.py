"""A structure from the matrices of another program: files, names of variables, contact, bolts."""

from collections.abc import Iterable, Mapping, Sequence
from math import pi
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PrivateAttr

from boltjoint.config.described import Described, MeshSize
from boltjoint.config.entries import Entry
from boltjoint.config.excitation import Direction, Point
from boltjoint.config.makers import maker
from boltjoint.config.types import (
    INTEGRAL,
    Description,
    Factorisation,
    KeyPath,
    MatrixFile,
    Name,
    NotNegative,
    Number,
    Positive,
    Problems,
    VariableName,
    conflicts_of_factorisation,
)

#: number of a degree of freedom
Dof = Annotated[int, Field(strict=True, ge=0), INTEGRAL]
#: along x, y, z
Vector = tuple[Number, Number, Number]

#: sine of the angle below which two directions are one
_PARALLEL = 1e-6


class VariableFile(Entry):
    """A variable with a file of its own."""

    variable: VariableName
    """Name of the variable."""
    file: MatrixFile
    """File that holds it: ``.mtx`` (Matrix Market), or ``.npz`` of ``scipy.sparse.save_npz``, which
    hold nothing else; or ``.npz`` or ``.mat`` where it has this name."""


class Plane(Entry):
    """Contact of a surface: directions and static contact."""

    normal: Vector | None = None
    """Normal from side A into side B, along x, y, z, of any length."""
    first_tangent: Vector | None = None
    """First tangent along x, y, z: its part in the plane of the surface counts."""
    penalty_N_per_m3: Positive | None = None
    """Static normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative | None = None
    """Coulomb friction during tightening."""


class MatrixSurface(Plane):
    """One of several surfaces in contact; what it does not give is that of all."""

    name: Name
    """Name of the surface in results."""


class MatrixContact(Plane):
    """Contact points: pairs of nodes, or rows of the relative displacement at quadrature points.

    Displacements of side A minus side B count, so that surfaces close along the normal.
    """

    normal: Vector | None = None
    """Normal from side A into side B along x, y, z, of any length; z by default."""
    first_tangent: Vector | None = None
    """First tangent along x, y, z: its part in the plane of the surface counts; x by default."""
    penalty_N_per_m3: Positive = 1e15
    """Static normal contact stiffness for each unit of area."""
    friction_coefficient: NotNegative = 0.1
    """Coulomb friction during tightening."""
    side_a: VariableName | None = None
    """Variable of the degrees of freedom along x, y, z of the nodes on side A of pairs, (points,
    3); with ``side_b``, or else ``relative``."""
    side_b: VariableName | None = None
    """The same on side B."""
    relative: VariableName | None = None
    """Variable of the rows of the displacement of side A minus side B at each point, of any
    interpolation, (3 * points, degrees of freedom)."""
    relative_along: Literal["xyz", "frame"] = "xyz"
    """Directions of these rows: x, y, z, or the two tangents and the normal."""
    relative_by: Literal["point", "direction"] = "point"
    """Order of these rows: the three of one point after another, or all points of one direction
    after another."""
    area: VariableName = "area"
    """Variable of the areas of the points, which are the weights of the quadrature, (points)."""
    position: VariableName = "position"
    """Variable of the positions of the points, (points, 3)."""
    frame: VariableName | None = None
    """Variable of the directions of first tangent, second tangent and normal in x, y, z of each
    point, (points, 3, 3) or (points, 9); by default ``normal`` and ``first_tangent`` of its
    surface."""
    gap: VariableName | None = None
    """Variable of the gap of the points before tightening, (points); closed by default."""
    surface: VariableName | None = None
    """Variable of the number of each point's surface in ``surfaces``, (points), with two or
    more."""
    surfaces: tuple[MatrixSurface, ...] = ()
    """Surfaces that are told apart; by default one, called contact."""

    def conflicts(self) -> Problems:
        pairs = [key for key in ("side_a", "side_b") if getattr(self, key) is not None]
        if self.relative is not None and pairs:
            yield (pairs[0],), "must not be given with relative: give one of both"
        elif self.relative is None and len(pairs) < 2:
            missing = "side_b" if pairs == ["side_a"] else "side_a"
            yield (missing,), "is missing: give side_a and side_b, or relative"
        if self.relative is None:
            for key in ("relative_along", "relative_by"):
                if getattr(self, key) != type(self).model_fields[key].default:
                    yield (key,), "must not be given without relative"
        if len(self.surfaces) > 1 and self.surface is None:
            yield ("surface",), "is missing: variable of the number of each point's surface"
        if len(self.surfaces) < 2 and self.surface is not None:
            yield ("surface",), "must not be given without two or more surfaces"
        yield from _twice(("surfaces",), "name", self.surfaces)
        for path, plane in [
            ((), self),
            *((("surfaces", i), s) for i, s in enumerate(self.surfaces)),
        ]:
            yield from self._conflicts_of_directions(path, plane)

    def _conflicts_of_directions(self, path: KeyPath, plane: Plane) -> Problems:
        if self.frame is not None:
            for key in ("normal", "first_tangent"):
                if getattr(plane, key) is not None:
                    yield (*path, key), "must not be given with frame, which holds all directions"
            return
        normal, tangent = self.directions(plane)
        for key, vector in (("normal", normal), ("first_tangent", tangent)):
            if not any(vector):
                yield (*path, key), "must not be zero"
                return
        if _sine(normal, tangent) < _PARALLEL:
            yield (*path, "first_tangent"), "must not be parallel to the normal"

    def directions(self, plane: Plane) -> tuple[Vector, Vector]:
        """Normal and first tangent of a surface, of any length."""
        normal = plane.normal or self.normal or (0.0, 0.0, 1.0)
        return normal, plane.first_tangent or self.first_tangent or (1.0, 0.0, 0.0)


class MatrixBolt(Entry):
    """A bolt: the forces of its tension, or the degree of freedom that is its shortening."""

    name: Name
    """Name of the bolt in results."""
    load: VariableName | None = None
    """Variable of the forces of a tension of 1 N, (degrees of freedom), in equilibrium with
    themselves; or ``locked``."""
    column: Dof | None = None
    """Column of ``load`` where that has several."""
    locked: Dof | None = None
    """Degree of freedom that is the shortening of the shank: it is held once the bolt is tight."""
    axis: Vector | None = None
    """Direction of the shank along x, y, z."""
    position_mm: Vector | None = None
    """A point on the axis."""
    shank_diameter_mm: Positive | None = None
    """Diameter of the shank, by which a preload beyond its yield is told."""
    youngs_modulus_GPa: Positive | None = None
    """Young's modulus of the shank."""

    def conflicts(self) -> Problems:
        if (self.load is None) == (self.locked is None):
            yield ("load",), "or locked must be given, and not both"
        if self.column is not None and self.load is None:
            yield ("column",), "must not be given without load"
        if self.axis is not None and not any(self.axis):
            yield ("axis",), "must not be zero"


class MatrixRow(Entry):
    """A place where a force acts or motion is read: a degree of freedom, or a row of them."""

    name: Name
    """Name of the input or output."""
    dof: Dof | None = None
    """Its degree of freedom; or ``row``."""
    row: VariableName | None = None
    """Variable of the displacement that a unit of each degree of freedom makes, (degrees of
    freedom)."""
    column: Dof | None = None
    """Column of ``row`` where that has several, or row where it is (rows, degrees of freedom)."""
    direction: Direction | None = None
    """Direction of the force or of the displacement, for tables and figures."""

    def conflicts(self) -> Problems:
        if (self.row is None) == (self.dof is None):
            yield ("dof",), "or row must be given, and not both"
        if self.column is not None and self.row is None:
            yield ("column",), "must not be given without row"


class Matrices(Described):
    """A structure from stiffness and mass matrices of another program, free or held.

    Degrees of freedom are those that are left by constraints, of nodes or of a reduced model that
    keeps its contact (Craig-Bampton). Variables lie in ``.npz`` files of NumPy (arrays, sparse
    matrices as ``scipy.sparse.save_npz`` writes them, or ``<name>_data``, ``<name>_indices``,
    ``<name>_indptr``, ``<name>_shape`` by rows, by columns where ``<name>_format`` is ``csc``), in
    ``.mat`` files of MATLAB, version 5 or 7.3, or in ``.mtx`` files (Matrix Market).
    """

    NAMING_KEYS: ClassVar[frozenset[str]] = frozenset({"numbered_from", "locked", "dof", "column"})
    GAP_KEY: ClassVar[str] = "contact.gap"

    type: Literal["matrices"]
    """Kind of structure."""
    description: Description = ""
    """Description of the structure in one line; no result depends on it."""
    file: MatrixFile | None = None
    """File of all variables that ``files`` does not name."""
    files: tuple[VariableFile, ...] = ()
    """Variables with files of their own."""
    length_unit: Literal["m", "mm"] = "m"
    """Unit of lengths in all variables: m, with N/m and kg, or mm, with N/mm and t."""
    numbered_from: Literal[0, 1] = 0
    """Number of the first degree of freedom, column and surface, in keys and in variables: 0 as in
    Python, 1 as in MATLAB."""
    stiffness: VariableName = "K"
    """Variable of the stiffness matrix, (degrees of freedom, degrees of freedom), with both
    triangles."""
    mass: VariableName = "M"
    """Variable of the mass matrix, alike."""
    support: VariableName | None = None
    """Variable of the inertia forces on the degrees of freedom under a unit acceleration of all
    supports along x, y and z, -M r, (3, degrees of freedom): for shaken supports."""
    contact: MatrixContact
    bolts: Annotated[tuple[MatrixBolt, ...], Field(min_length=1)]
    """Bolts, in the order of their preloads."""
    inputs: tuple[MatrixRow, ...] = ()
    """Places where forces may act."""
    outputs: tuple[MatrixRow, ...] = ()
    """Places where motion may be read; the first is the output point."""
    factorisation: Factorisation = "auto"
    """Factors of the stiffness: those of SuperLU in an ordering of minimum degree; in one by nested
    dissection (METIS), with about three quarters of the entries in half the time; or PARDISO, with
    half the memory and a quarter of the time, of Intel processors and their like. The last two need
    packages of ``boltjoint[fast]``. ``auto`` is nested dissection from 30,000 degrees of freedom
    on, where it is installed, else SuperLU."""
    _folder: Path = PrivateAttr(Path())
    _size: MeshSize | None = PrivateAttr(None)

    @property
    def bolt_count(self) -> int:
        """Number of bolts."""
        return len(self.bolts)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of ``inputs``."""
        return tuple(point.name for point in self.inputs)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of ``outputs``."""
        return tuple(point.name for point in self.outputs)

    @property
    def has_support(self) -> bool:
        """Whether forces of shaken supports are given."""
        return self.support is not None

    @property
    def named_files(self) -> tuple[str, ...]:
        """All files that are read, once each."""
        return tuple(dict.fromkeys(map(self.file_of, self.variables.values())))

    @property
    def folder(self) -> Path:
        """Folder of the study, in which the files lie."""
        return self._folder

    def in_folder(self, folder: Path) -> Self:
        """The same description, whose files lie in a folder."""
        copied = self.model_copy()
        copied._folder = folder
        return copied

    @property
    def size(self) -> MeshSize:
        """Size by the heads of the files; a ``ValueError`` if they do not tell it."""
        if self._size is None:
            self._size = maker(self.type).size_of(self, self._folder)
        return self._size

    @property
    def has_initial_gap(self) -> bool:
        """Whether the surfaces stand apart before the bolts are tightened."""
        return self.contact.gap is not None

    @property
    def shank(self) -> tuple[float, float] | None:
        """Cross-section [m2] and Young's modulus [Pa] of the thinnest shank that is known."""
        values = (
            (pi / 4 * (1e-3 * bolt.shank_diameter_mm) ** 2, 1e9 * bolt.youngs_modulus_GPa)
            for bolt in self.bolts
            if bolt.shank_diameter_mm is not None and bolt.youngs_modulus_GPa is not None
        )
        return min(values, default=None)

    def conflicts_of_files(self) -> Problems:
        """What the heads of the files do not hold."""
        try:
            _ = self.size
        except ValueError as error:
            yield (), str(error)

    def conflicts_of_point(self, point: Point) -> Problems:
        """A point: matrices know degrees of freedom alone."""
        yield (), "is no place of matrices, which have no nodes: name an input or an output"

    def conflicts(self) -> Problems:
        yield from conflicts_of_factorisation(self.factorisation)
        if self.file is None and not self.files:
            yield ("file",), "is missing: the file that holds the matrices, or files"
            return
        yield from _twice(("files",), "variable", self.files)
        own = {entry.variable for entry in self.files}
        for path, name in () if self.file is not None else self.variables.items():
            if name not in own:
                yield path, "has no file: add it to files, or give file"
        for key in ("bolts", "inputs", "outputs"):
            yield from _twice((key,), "name", getattr(self, key))
            for index, entry in enumerate(getattr(self, key)):
                for number in ("column", "locked", "dof"):
                    if (column := getattr(entry, number, None)) is not None:
                        if column < self.numbered_from:
                            yield (key, index, number), "must be at least 1, with numbered_from: 1"

    @property
    def surface_names(self) -> tuple[str, ...]:
        """Names of the surfaces in contact; one that is not told apart is called contact."""
        return tuple(surface.name for surface in self.contact.surfaces) or ("contact",)

    @property
    def variables(self) -> Mapping[KeyPath, str]:
        """Names of all variables that are read, by the keys that give them."""
        keys: list[KeyPath] = [("stiffness",), ("mass",), ("support",)]
        of_contact = ("side_a", "side_b", "relative", "area", "position", "frame", "gap", "surface")
        keys += [("contact", key) for key in of_contact]
        keys += [("bolts", i, "load") for i in range(len(self.bolts))]
        for rows in ("inputs", "outputs"):
            keys += [(rows, i, "row") for i in range(len(getattr(self, rows)))]
        return {path: name for path in keys if (name := _value(self, path)) is not None}

    def file_of(self, variable: str) -> str:
        """File that holds a variable."""
        own = {entry.variable: entry.file for entry in self.files}
        return own.get(variable) or str(self.file)


def _value(entry: Any, path: KeyPath) -> str | None:  # noqa: ANN401
    for part in path:
        entry = entry[int(part)] if isinstance(entry, tuple) else getattr(entry, str(part))
    return entry


def _twice(path: KeyPath, key: str, entries: Sequence[Entry]) -> Problems:
    seen: set[str] = set()
    for index, entry in enumerate(entries):
        value = getattr(entry, key)
        if value in seen:
            yield (*path, index, key), "must not appear twice"
        seen.add(value)


def _sine(one: Iterable[float], other: Iterable[float]) -> float:
    """Sine of the angle between two directions."""
    (a, b, c), (d, e, f) = one, other
    product = (b * f - c * e) ** 2 + (c * d - a * f) ** 2 + (a * e - b * d) ** 2
    return (product / ((a * a + b * b + c * c) * (d * d + e * e + f * f))) ** 0.5
