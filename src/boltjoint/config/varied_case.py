"""Cases with other values of some keys, as the designs of a sweep are."""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from boltjoint.config.case import Case
from boltjoint.config.csv_table import CsvTable, TableError
from boltjoint.config.entries import Entry, explain
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.sweep import LEVEL_KEYS, MOST_DESIGNS, Sweep
from boltjoint.config.types import KeyPath, Problems
from boltjoint.config.varied_keys import (
    ASSEMBLY,
    JOINT,
    RATIOS,
    is_rescaled,
    key_of,
    not_varied,
    path_of,
    with_value_at,
)

Array = NDArray[np.float64]
EntryT = TypeVar("EntryT", bound=Entry)


def conflicts_with_case(sweep: Sweep, case: Case, allowed: Collection[str]) -> Problems:
    """Keys that do not vary, and ranges that reach beyond what the base case allows."""
    content = case.model_dump()
    for key, values in sweep.vary.items():
        if key not in allowed:
            yield ("vary", key), not_varied(key, allowed)
        elif is_rescaled(key) and not isinstance(values, tuple):
            for value in values.extremes:
                changed = with_values(content, {key: float(f"{value:.4g}")})
                for sentence in refused(changed, Case):
                    yield ("vary", key), f"reaches too far: {sentence}"


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
    if designs > MOST_DESIGNS:
        raise TableError(f"{file}: must have at most {MOST_DESIGNS} designs")
    return columns
