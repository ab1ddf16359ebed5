"""Cases with other values of some keys, as the designs of a sweep are."""

import csv
from collections.abc import Mapping
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from boltjoint.config.case import Case
from boltjoint.config.entries import Entry, choice, explain
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.sweep import MOST_DESIGNS, Sweep
from boltjoint.config.types import Problems

Array = NDArray[np.float64]


def conflicts_with_case(sweep: Sweep, case: Case) -> Problems:
    """Keys that the base case does not vary, and ranges that reach beyond what it allows."""
    allowed, content = keys_that_vary(case), case.model_dump()
    for key, values in sweep.vary.items():
        if key not in allowed:
            yield ("vary", key), f"is no key that varies{choice(key, allowed)}"
        elif not isinstance(values, tuple):
            for value in values.extremes:
                changed = with_values(content, {key: float(f"{value:.4g}")})
                for sentence in refused(changed, Case):
                    yield ("vary", key), f"reaches too far: {sentence}"


def refused(content: Mapping[str, Any], model: type[Entry]) -> list[str]:
    """What is wrong with the content of a file, a line each; none if nothing is."""
    try:
        model.model_validate(content)
    except ValidationError as error:
        found = explain(error, model, content)
        return [f"{'.'.join(map(str, path))}: {sentence}" for path, sentence in found]
    return []


class Quantity(NamedTuple):
    """What a key that varies is called in results, its unit and its meaning."""

    name: str
    unit: str
    meaning: str


def keys_that_vary(case: Case) -> dict[str, Quantity]:
    """The keys of a case that a sweep may vary."""
    level, unit = ("accelerations_m_per_s2", "m/s2") if case.is_base_excited else ("forces_N", "N")
    return {
        "preload_N": Quantity("preload", "N", "preload of each bolt"),
        level: Quantity("force_level", unit, "excitation amplitude"),
        **(
            {"loss_factor": Quantity("loss_factor", "1", "structural loss factor")}
            if case.damping is None
            else {}
        ),
        **{
            f"contact.{each.key}": Quantity(each.name, each.unit, _as_meaning(each.meaning))
            for each in case.contact.declaration.keys
        },
    }


def with_values(content: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """The content of a case with other values of some keys, a level being the only one."""
    changed = {**content, "verification_forces_N": ()}
    for key, value in values.items():
        section, _, name = key.rpartition(".")
        if section:
            changed[section] = {**changed[section], name: value}
        else:
            changed[name] = (value,) if isinstance(changed.get(name), tuple) else value
    return changed


def solved_alone(case: Case, sweep: Sweep) -> dict[str, Any]:
    """The content of a case that solves only what a sweep does."""
    block = {
        "resonance": sweep.resonance,
        "joints": (sweep.joint,),
        "window_Hz": case.window_around(sweep.resonance),
    }
    level = "accelerations_m_per_s2" if case.is_base_excited else "forces_N"
    return {
        **case.model_dump(),
        level: sweep.levels or case.levels,
        "verification_forces_N": (),
        "modes": (sweep.basis,),
        "coordinates": (sweep.coordinates,),
        "solve": (block,),
    }


def _as_meaning(sentence: str) -> str:
    return sentence[0].lower() + sentence[1:].partition(". ")[0].rstrip(".")


def read_table(text: str, file: str, case: Case) -> dict[str, Array]:
    """Values of the keys that vary, by design, from the text of a CSV file.

    Raises
    ------
    TableError
        If a column is no key that varies, is missing or appears twice, or a cell is no number.
    """
    rows = list(csv.reader(text.splitlines()))
    keys, allowed = rows[0] if rows else [], keys_that_vary(case)
    for index, key in enumerate(keys):
        if key not in allowed:
            raise TableError(
                f"{file}: column {as_text(key)} is no key that varies{choice(key, allowed)}"
            )
        if key in keys[:index]:
            raise TableError(f"{file}: column {key} must not appear twice")
    if not keys or len(rows) < 2:
        raise TableError(f"{file}: must have a line of keys, and one for each design")
    if len(rows) - 1 > MOST_DESIGNS:
        raise TableError(f"{file}: must have at most {MOST_DESIGNS} designs")
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(keys):
            raise TableError(f"{file}:{line}: must have {len(keys)} values, as many as keys")
        for key, cell in zip(keys, row, strict=True):
            if not _is_number(cell):
                raise TableError(f"{file}:{line}: {key}: {as_text(cell)} must be a number")
    columns = np.array(rows[1:], dtype=float).T
    return dict(zip(keys, columns, strict=True))


def _is_number(cell: str) -> bool:
    try:
        return isfinite(float(cell))
    except ValueError:
        return False


class TableError(ValueError):
    """What is wrong with a table of designs."""
