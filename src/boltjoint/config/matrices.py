"""A structure from the matrices of another program: files, names of variables, contact, bolts."""

from collections.abc import Iterator, Mapping
from math import pi
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PrivateAttr

from boltjoint.config.bolts import Shank
from boltjoint.config.described import Described, MeshSize
from boltjoint.config.entries import Entry
from boltjoint.config.excitation import Direction, Point, Vector
from boltjoint.config.makers import maker
from boltjoint.config.matrix_contact import MatrixContact, repeated
from boltjoint.config.matrix_modes import MatrixModes
from boltjoint.config.types import (
    INTEGRAL,
    Description,
    Factorisation,
    KeyPath,
    MatrixFile,
    Name,
    Positive,
    Problems,
    VariableName,
    conflicts_of_factorisation,
)
from boltjoint.names import Preload

#: number of a degree of freedom
Dof = Annotated[int, Field(strict=True, ge=0), INTEGRAL]


class VariableFile(Entry):
    """A variable with a file of its own."""

    variable: VariableName
    """Name of the variable."""
    file: MatrixFile
    """File that holds it: ``.mtx`` (Matrix Market), or ``.npz`` of ``scipy.sparse.save_npz``, which
    hold nothing else; or ``.npz`` or ``.mat`` where it has this name."""


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
    """A place where a force acts or motion is read: a degree of freedom, a row, or a node."""

    name: Name
    """Name of the input or output."""
    dof: Dof | None = None
    """Its degree of freedom; or ``row``, or ``node``."""
    node: Dof | None = None
    """Number of its node among ``modes.node``, which moves along ``direction``."""
    row: VariableName | None = None
    """Variable of the displacement that a unit of each degree of freedom makes, (degrees of
    freedom)."""
    column: Dof | None = None
    """Column of ``row`` where that has several, or row where it is (rows, degrees of freedom)."""
    direction: Direction | None = None
    """Direction of the force or of the displacement, for tables and figures."""

    def conflicts(self) -> Problems:
        given = [key for key in ("dof", "row", "node") if getattr(self, key) is not None]
        if len(given) != 1:
            yield (given[1] if given else "dof",), "must be the only one of dof, row and node"
        if self.node is not None and self.direction is None:
            yield ("direction",), "is missing: that of the motion of node"
        if self.column is not None and self.row is None:
            yield ("column",), "must not be given without row"


class Matrices(Described):
    """A structure from stiffness and mass matrices, or modes, of another program, free or held.

    Degrees of freedom are those that are left by constraints, of nodes or of a reduced model that
    keeps its contact (Craig-Bampton). Variables lie in ``.npz`` files of NumPy (arrays, sparse
    matrices as ``scipy.sparse.save_npz`` writes them, or ``<name>_data``, ``<name>_indices``,
    ``<name>_indptr``, ``<name>_shape`` by rows, by columns where ``<name>_format`` is ``csc``), in
    ``.mat`` files of MATLAB, version 5 or 7.3, or in ``.mtx`` files (Matrix Market); modes of tests
    in universal files too.
    """

    NAMING_KEYS: ClassVar[frozenset[str]] = frozenset(
        {"numbered_from", "locked", "dof", "node", "column", "preload_N"}
    )
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
    numbered_from: Literal[0, 1] | None = None
    """Number of the first degree of freedom, column and surface, in keys and in variables: 0 as in
    Python, 1 as in MATLAB. To be given with a ``.mat`` file, if anything is numbered; else 0."""
    stiffness: VariableName = "K"
    """Variable of the stiffness matrix, (degrees of freedom, degrees of freedom), with both
    triangles."""
    mass: VariableName = "M"
    """Variable of the mass matrix, alike."""
    modes: MatrixModes | None = None
    """Modes in place of stiffness and mass, as of a modal test."""
    support: VariableName | None = None
    """Variable of the inertia forces on the degrees of freedom under a unit acceleration of all
    supports along x, y and z, -M r, (3, degrees of freedom): for shaken supports."""
    contact: MatrixContact
    bolts: tuple[MatrixBolt, ...] = ()
    """Bolts, in the order of their preloads; none with ``contact.normal_load``."""
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
    _ratios: tuple[float, ...] | None = PrivateAttr(None)

    @property
    def first_number(self) -> int:
        """Number of the first degree of freedom, column and surface."""
        return self.numbered_from or 0

    @property
    def bolt_count(self) -> int:
        """Number of bolts."""
        return len(self.bolts)

    @property
    def bolt_names(self) -> tuple[str, ...]:
        """Names of ``bolts``."""
        return tuple(bolt.name for bolt in self.bolts)

    @property
    def own_preload(self) -> Preload | None:
        """``preload_N``, or that of normal loads which are given."""
        given = self.given_loads
        return super().own_preload if given is None else Preload.of(given[1])

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
        return self.contact.gap is not None and self.contact.normal_load is None

    @property
    def given_loads(self) -> tuple[str, float] | None:
        """Key of normal loads that are given, and their preload [N]."""
        contact = self.contact
        return None if contact.preload_N is None else ("contact.normal_load", contact.preload_N)

    @property
    def has_modes_only(self) -> bool:
        """Whether nothing but its modes is known."""
        return self.modes is not None

    @property
    def damping_ratios(self) -> tuple[float, ...]:
        """Of the elastic modes, where their files hold them; a ``ValueError`` if they do not."""
        if self.modes is None or self.modes.damping_ratio is None:
            return ()
        if self._ratios is None:
            self._ratios = maker(self.type).damping_ratios_of(self, self._folder)
        return self._ratios

    @property
    def shank(self) -> Shank | None:
        """The thinnest shank that is known."""
        values = (
            Shank(pi / 4 * (1e-3 * bolt.shank_diameter_mm) ** 2, 1e9 * bolt.youngs_modulus_GPa)
            for bolt in self.bolts
            if bolt.shank_diameter_mm is not None and bolt.youngs_modulus_GPa is not None
        )
        return min(values, default=None)

    def conflicts_of_files(self) -> Problems:
        """What the heads of the files do not hold."""
        try:
            _ = self.size, self.damping_ratios
        except ValueError as error:
            yield (), str(error)

    def conflicts_of_point(self, point: Point) -> Problems:
        """A point: matrices know degrees of freedom alone."""
        yield (), "is no place of matrices, which have no nodes: name an input or an output"

    def conflicts(self) -> Problems:
        yield from conflicts_of_factorisation(self.factorisation)
        yield from self._conflicts_of_modes()
        if not self.bolts and self.contact.normal_load is None:
            yield ("bolts",), "is missing: bolts, or contact.normal_load"
        elif self.bolts and self.contact.normal_load is not None:
            yield ("bolts",), "must not be given with contact.normal_load, which they would make"
        if self.file is None and not self.files:
            yield ("file",), "is missing: the file that holds the matrices, or files"
            return
        yield from repeated(("files",), "variable", self.files)
        for path, name in self.variables.items():
            if self._file_of(name) is None:
                yield path, "has no file: add it to files, or give file"
        for key in ("bolts", "inputs", "outputs"):
            yield from repeated((key,), "name", getattr(self, key))
        yield from _conflicts_of_numbers(self)

    @property
    def surface_names(self) -> tuple[str, ...]:
        """Names of the surfaces in contact; one that is not told apart is called contact."""
        return tuple(surface.name for surface in self.contact.surfaces) or ("contact",)

    @property
    def variables(self) -> Mapping[KeyPath, str]:
        """Names of all variables that are read, by the keys that give them."""
        keys: list[KeyPath] = [("support",)]
        if self.modes is None:
            keys += [("stiffness",), ("mass",)]
        of_contact = ["side_a", "side_b", "relative", "area", "frame", "gap", "surface"]
        of_contact += ["normal_load"] if self.has_own_positions else ["normal_load", "position"]
        keys += [("contact", key) for key in of_contact]
        keys += [("bolts", i, "load") for i in range(len(self.bolts))]
        for rows in ("inputs", "outputs"):
            keys += [(rows, i, "row") for i in range(len(getattr(self, rows)))]
        found = {path: name for path in keys if (name := _value(self, path)) is not None}
        return found | {("modes", key): name for key, name in self._of_modes}

    @property
    def has_own_positions(self) -> bool:
        """Whether contact points lie between the nodes of modes."""
        return self.modes is not None and self.modes.variable("node_position") is not None

    @property
    def _of_modes(self) -> Iterator[tuple[str, str]]:
        """Keys and variables of the modes."""
        if (modes := self.modes) is not None:
            for key in MatrixModes.model_fields:
                if key != "file" and (name := modes.variable(key)) is not None:
                    yield key, name

    def file_of(self, variable: str) -> str:
        """File that holds a variable."""
        return self._file_of(variable) or str(self.file)

    def _file_of(self, variable: str) -> str | None:
        own = {entry.variable: entry.file for entry in self.files}
        if self.modes is not None and self.modes.file is not None:
            own |= {name: self.modes.file for _, name in self._of_modes}
        return own.get(variable) or self.file

    def _conflicts_of_modes(self) -> Problems:
        """What modes leave no place for, or would need."""
        modes = self.modes
        has_nodes = modes is not None and modes.variable("node") is not None
        for key in ("inputs", "outputs"):
            for index, row in enumerate(getattr(self, key)):
                if row.node is not None and not has_nodes:
                    yield (key, index, "node"), "must not be given without modes.node"
        if modes is None:
            return
        for key in ("stiffness", "mass"):
            if getattr(self, key) != type(self).model_fields[key].default:
                yield (key,), "must not be given with modes, which stand in its place"
        for index, bolt in enumerate(self.bolts):
            if bolt.locked is not None:
                yield ("bolts", index, "locked"), "must not be given with modes, which have it held"
        if self.contact.relative is None and modes.variable("mode_shape") is None:
            yield ("contact", "side_a"), "must not be given without modes.mode_shape"
        default = type(self.contact).model_fields["position"].default
        if self.has_own_positions and self.contact.relative is not None:
            yield ("modes", "node_position"), "must not be given with contact.relative"
        elif self.has_own_positions and self.contact.position != default:
            yield ("contact", "position"), "must not be given with modes.node_position"
        names = [name for _, name in self._of_modes]
        others = {name for path, name in self.variables.items() if path[0] != "modes"}
        if modes.file is not None:
            for name in sorted(others & set(names)):
                yield ("modes",), f"must not have {name}, which is a variable of another key too"


def _value(entry: Any, path: KeyPath) -> str | None:  # noqa: ANN401
    for part in path:
        entry = entry[int(part)] if isinstance(entry, tuple) else getattr(entry, str(part))
    return entry


def _numbers(described: Matrices) -> Iterator[tuple[KeyPath, int]]:
    """Keys that are numbers of degrees of freedom or columns."""
    for key in ("bolts", "inputs", "outputs"):
        for index, entry in enumerate(getattr(described, key)):
            for name in ("column", "locked", "dof"):
                if (number := getattr(entry, name, None)) is not None:
                    yield (key, index, name), number


def _conflicts_of_numbers(described: Matrices) -> Problems:
    """Numbers before the first, or that may count as in MATLAB where nothing tells from where."""
    for path, number in _numbers(described):
        if number < described.first_number:
            yield path, "must be at least 1, with numbered_from: 1"
    files = [file for file in described.named_files if file.endswith(".mat")]
    keys: list[KeyPath] = [path for path, _ in _numbers(described)]
    # with numbers of nodes, pairs are named by these
    has_nodes = described.modes is not None and described.modes.variable("node") is not None
    for name in ("surface",) if has_nodes else ("side_a", "surface"):
        if getattr(described.contact, name) is not None:
            keys.append(("contact", name))
    if files and keys and described.numbered_from is None:
        yield (
            ("numbered_from",),
            f"is missing: 1 if {keys[0][-1]} counts as in MATLAB, 0 if as in Python; "
            f"{files[0]} does not tell",
        )
