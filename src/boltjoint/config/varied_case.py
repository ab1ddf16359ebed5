"""Cases with other values of some keys, as the designs of a sweep are, and what varies in them."""

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cached_property
from hashlib import blake2b
from itertools import islice, product
from math import prod
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from boltjoint.config.case import Case
from boltjoint.config.csv_table import CsvTable, TableError
from boltjoint.config.described import Described
from boltjoint.config.entries import Entry
from boltjoint.config.error_messages import explain
from boltjoint.config.sampling import Grid, design_columns, grid_values
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.sweep import LEVEL_KEYS, MOST_JOBS, Sweep
from boltjoint.config.types import KeyPath, Problems, unforeseen
from boltjoint.config.varied_keys import (
    ASSEMBLY,
    JOINT,
    RATIOS,
    is_rescaled,
    key_of,
    not_varied,
    path_of,
    value_at,
    with_numbers,
    with_value_at,
)
from boltjoint.names import Basis, JointName

Array = NDArray[np.float64]
EntryT = TypeVar("EntryT", bound=Entry)


def read_content(
    content: Mapping[str, Any], model: type[EntryT]
) -> tuple[EntryT | None, list[str]]:
    """The content of a file as a model; None, and what is wrong with it, a line each."""
    try:
        return model.model_validate(content), []
    except ValidationError as error:
        explained = explain(error, model, content)
        return None, [f"{key_of(path)}: {sentence}" for path, sentence in explained]


def refused(content: Mapping[str, Any], model: type[Entry]) -> list[str]:
    """What is wrong with the content of a file, a line each; none if nothing is."""
    return read_content(content, model)[1]


def with_values(content: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """The content of a case with other values of those keys that are its own."""
    changed = {**content, "verification_forces_N": ()}
    for key, value in values.items():
        if key in LEVEL_KEYS:
            changed[key] = (value,)
        elif not key.startswith((ASSEMBLY, JOINT)):
            changed = with_value_at(changed, path_of(key), value)
    return changed


def with_all_ratios(
    content: Mapping[str, Any], keys: Collection[str], bolts: int
) -> dict[str, Any]:
    """The content of a case with a ratio of preload for each bolt where some of these vary."""
    ratios = content["preload_ratios"]
    if ratios is None and any(key.startswith(RATIOS) for key in keys):
        ratios = (1.0,) * bolts
    return {**content, "preload_ratios": ratios}


def solved_alone(case: Case, sweep: Sweep) -> dict[str, Any]:
    """The content of a case that solves only what a sweep does."""
    block = {
        "resonance": sweep.resonance,
        "joints": (sweep.joint,),
        # of another assembly the resonance may lie elsewhere
        "window_Hz": None
        if any(key.startswith(ASSEMBLY) for key in sweep.vary)
        else case.window_around(sweep.resonance),
    }
    level = "accelerations_m_per_s2" if case.is_base_excited else "forces_N"
    return {
        **case.model_dump(exclude={"measured"}),
        level: sweep.levels or case.levels,
        "verification_forces_N": (),
        "modes": (sweep.basis,),
        "coordinates": (sweep.coordinates,),
        "solve": (block,),
    }


class SolvedCase(NamedTuple):
    """A case that solves only what a sweep does; None, with problems, if it is impossible."""

    case: Case | None
    problems: list[tuple[KeyPath, str]]


def solve_alone(case: Case, sweep: Sweep) -> SolvedCase:
    """The case that solves only what a sweep does."""
    try:
        return SolvedCase(Case.model_validate(solved_alone(case, sweep)), [])
    except ValidationError as error:
        problems = [listed for problem in error.errors() for listed in problem["ctx"]["problems"]]
        return SolvedCase(None, problems)


def read_table(text: str, file: str, allowed: Collection[str]) -> dict[str, Array]:
    """Values of the keys that vary, by design, from the text of a CSV file.

    Parameters
    ----------
    text, file
        What the file holds, and its name.
    allowed
        The keys that may vary.

    Raises
    ------
    TableError
        If a column is no key that varies, is missing or appears twice, or a cell is no number.
    """
    table = CsvTable(text, file)
    keys = table.keys
    for index, key in enumerate(keys):
        if key not in allowed:
            raise TableError(f"{file}: column {as_text(key)} {not_varied(key, allowed)}")
        if key in keys[:index]:
            raise TableError(f"{file}: column {key} must not appear twice")
    columns = table.columns() if keys else {}
    designs = len(next(iter(columns.values()), ()))
    if not designs:
        raise TableError(f"{file}: must have a line of keys, and one for each design")
    return columns


#: characters of a name beyond which values are told by a hash: folders have 255
_LONGEST_NAME = 120

Values = Mapping[str, float]
Conflicts = Callable[[SolvedCase, Described], Problems]
"""What an assembly and the settings do not allow in a case, solved as a sweep does."""


class TooManyVariants(ValueError):
    """More variants than the workflow has jobs for."""


class _Checked(NamedTuple):
    """A case, its assembly and its joint, and why they are impossible."""

    case: Case
    assembly: Described
    joint: JointName
    reason: str


class BaseOfVariants:
    """The base case of a sweep, its assembly and its joint, whose keys vary.

    What several variants have in common is checked once.

    Parameters
    ----------
    sweep
        The sweep.
    case, assembly
        The base case and its assembly.
    conflicts
        As ``Conflicts``.
    """

    def __init__(self, sweep: Sweep, case: Case, assembly: Described, conflicts: Conflicts) -> None:
        self.sweep, self.case, self.assembly = sweep, case, assembly
        self._conflicts = conflicts
        self._contents = case.model_dump(), assembly.model_dump()
        self._cases: dict[tuple[object, ...], tuple[Case | None, list[str]]] = {}
        self._solved: dict[tuple[object, ...], SolvedCase] = {}

    def is_own(self, of_assembly: Values) -> bool:
        """Whether the values of keys of the assembly are those it has."""
        content = self._contents[1]
        return all(value_at(content, path_of(key)) == of_assembly[key] for key in of_assembly)

    def other_ratios(self, values: Values) -> dict[str, float]:
        """The values of ratios of preloads; none where they are those it has."""
        ratios = {key: value for key, value in values.items() if key.startswith(RATIOS)}
        content = with_all_ratios(self._contents[0], ratios, self.assembly.bolt_count)
        is_own = all(value_at(content, path_of(key)) == ratios[key] for key in ratios)
        return {} if is_own else ratios

    def checked(self, values: Values) -> _Checked:
        """The base case with other values of some keys, as far as it is possible."""
        of_assembly, of_joint = _of_part(values, ASSEMBLY), _of_part(values, JOINT)
        of_case = {key: value for key, value in values.items() if not key.startswith(JOINT)}
        assembly, reasons, joint = self.assembly, [], self.sweep.joint
        if not self.is_own(of_assembly):
            content = self._contents[1]
            for key, value in of_assembly.items():
                content = with_value_at(content, path_of(key), value)
            explained, lines = read_content(content, type(assembly))
            reasons += [f"{ASSEMBLY}{line}" for line in lines]
            if explained is not None:
                assembly = explained.in_folder(assembly.folder)
                reasons += [f"{ASSEMBLY}{line}" for _, line in assembly.conflicts_of_files()]
        own = tuple(item for item in of_case.items() if not item[0].startswith(ASSEMBLY))
        bolts = assembly.bolt_count
        case, lines = self._case(own, bolts)
        reasons += lines
        try:
            joint = with_numbers(joint, of_joint)
        except ValueError as error:
            reasons.append(f"{JOINT}{error}")
        if case is not None and not reasons:
            parts = own, bolts, joint
            if parts not in self._solved:
                alone = self.sweep.model_copy(update={"joint": joint})
                self._solved[parts] = solve_alone(case, alone)
            conflicts = self._conflicts(self._solved[parts], assembly)
            reasons += [f"{key_of(path)}: {line}" for path, line in conflicts]
        return _Checked(case or self.case, assembly, joint, "; ".join(reasons))

    def _case(
        self, own: tuple[tuple[str, float], ...], bolts: int
    ) -> tuple[Case | None, list[str]]:
        """The base case with other values of keys of its own; None, with reasons, if impossible."""
        if (own, bolts) not in self._cases:
            values = dict(own)
            content = with_values(with_all_ratios(self._contents[0], values, bolts), values)
            content["verification_forces_N"] = self.case.verification_forces_N
            self._cases[own, bolts] = read_content(content, Case)
        return self._cases[own, bolts]


class Variant:
    """A base case, its assembly and its joint with other values of some keys.

    Attributes
    ----------
    values
        These values by their keys.
    case_name, assembly_name
        Names of their files. A contact-adapted basis is made for preloads of one ratio: with
        others, the assembly is one of its own.
    """

    def __init__(self, values: Values, base: BaseOfVariants) -> None:
        self.values, self._base = values, base

    @property
    def bases(self) -> set[Basis]:
        """The bases of the sweep and of its check."""
        check = self._base.sweep.check
        return {self._base.sweep.basis} | (set() if check is None else {check.basis})

    @cached_property
    def case_name(self) -> str:
        return _named(self._base.sweep.case, _without(self.values, JOINT))

    @cached_property
    def assembly_name(self) -> str:
        own = _of_part(self.values, ASSEMBLY)
        values = {} if self._base.is_own(own) else own
        if any(basis.is_contact_adapted for basis in self.bases):
            values |= self._base.other_ratios(self.values)
        return _named(self._base.case.assembly, values)

    @cached_property
    def _checked(self) -> _Checked:
        try:
            return self._base.checked(self.values)
        except Exception as error:  # of values that no rule thought of
            base = self._base
            reason = unforeseen("checked", error)
            return _Checked(base.case, base.assembly, base.sweep.joint, reason)

    @cached_property
    def case(self) -> Case:
        """The case, of the assembly of this variant."""
        if self._checked.case.assembly == self.assembly_name:
            return self._checked.case
        return self._checked.case.model_copy(update={"assembly": self.assembly_name})

    @property
    def assembly(self) -> Described:
        """The assembly; where it is impossible, that of the base case."""
        return self._checked.assembly

    @property
    def joint(self) -> JointName:
        """The joint; where it is impossible, that of the sweep."""
        return self._checked.joint

    @property
    def reason(self) -> str:
        """Why it is impossible, empty where it is not."""
        return self._checked.reason


def find_variants(
    base: BaseOfVariants, columns: Mapping[str, NDArray[np.float64]] | None = None
) -> list[Variant]:
    """The variants of a sweep, in the order of its designs. They are counted, and none is checked.

    Parameters
    ----------
    base
        What varies.
    columns
        Values of the keys by design, where they are those of a table.

    Raises
    ------
    TooManyVariants
        If there are more than ``MOST_JOBS``.
    """
    sweep = base.sweep
    keys = [key for key in (columns or sweep.vary) if not is_rescaled(key)]
    if not keys:
        return [Variant({}, base)]
    if columns is None and isinstance(sweep.design, Grid):
        # the other keys of a grid make no further ones
        rows: Iterable[tuple[float, ...]] = ()
        if (count := prod(sweep.grid[key] for key in keys)) <= MOST_JOBS:
            rows = product(*(grid_values(sweep.vary[key]).tolist() for key in keys))
    else:
        columns = columns or design_columns(sweep.vary, sweep.design)
        rows, count = zip(*(columns[key].tolist() for key in keys), strict=True), 0
    distinct = dict.fromkeys(_until_too_many(rows))
    if max(count, len(distinct)) > MOST_JOBS:
        told = f"{count}" if count else f"more than {MOST_JOBS}"
        raise TooManyVariants(f"makes {told} joints of other dimensions, preloads or divisions")
    return [Variant(dict(zip(keys, row, strict=True)), base) for row in distinct]


def _until_too_many(rows: Iterable[tuple[float, ...]]) -> Iterable[tuple[float, ...]]:
    """The first of equal rows, until there are more than can be made."""
    rows = iter(rows)
    seen: set[tuple[float, ...]] = set()
    while len(seen) <= MOST_JOBS and (some := list(islice(rows, MOST_JOBS))):
        fresh = [row for row in dict.fromkeys(some) if row not in seen]
        seen.update(fresh)
        yield from fresh


def _of_part(values: Values, part: str) -> dict[str, float]:
    """The values of the keys of a part, without its name."""
    return {key.removeprefix(part): value for key, value in values.items() if key.startswith(part)}


def _without(values: Values, part: str) -> dict[str, float]:
    return {key: value for key, value in values.items() if not key.startswith(part)}


def _named(name: str, values: Values) -> str:
    """The name of a file or folder, with values."""
    if not values:
        return name
    told = [f"{'.'.join(map(str, path_of(key)))}={value:.15g}" for key, value in values.items()]
    full = ",".join([name, *told])
    if len(full) <= _LONGEST_NAME:
        return full
    return f"{name},{blake2b(full.encode(), digest_size=8).hexdigest()}"
