"""Designs of a sweep: the values of the keys that vary, and which of them are impossible."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import xarray as xr

from boltjoint import checks
from boltjoint.config.case import Case
from boltjoint.config.csv_table import read_file
from boltjoint.config.distributions import DISTRIBUTIONS, Values
from boltjoint.config.entries import Entry
from boltjoint.config.sweep import Design, Grid, Saltelli, Samples, design_columns
from boltjoint.config.varied_case import read_table, refused, with_values
from boltjoint.config.varied_keys import Quantity, is_rescaled, rescaled_keys
from boltjoint.dataset import quantity

Value = TypeVar("Value")

_ONE_JOINT: tuple[Mapping[str, Any], ...] = ({"values": {}, "reason": ""},)


def list_designs(
    vary: Mapping[str, Values],
    design: Design,
    case: Mapping[str, Any],
    variants: Sequence[Mapping[str, Any]] = _ONE_JOINT,
    quantities: Mapping[str, Quantity] | None = None,
    table: str | Path | None = None,
) -> xr.Dataset:
    """The designs of a sweep.

    Parameters
    ----------
    vary, design
        Values of the keys that vary, and which of their combinations are designs.
    case
        Content of the base case.
    variants
        ``values`` of the keys that need another joint, and ``reason`` why they are impossible,
        empty where they are not; by default none needs one.
    quantities
        What the keys that may vary are called; by default those that need no other joint.
    table
        File of the designs, with ``kind: table``.

    Returns
    -------
    Dataset
        By ``design`` the value of each key, under the name of the quantity and with the key as an
        attribute, the number of its ``variant``, and ``reason``, why the design is impossible,
        empty where it is not. Its attributes are ``varied``, the names in their order, and of
        ``kind: saltelli`` ``saltelli_samples``, the designs of each sample.

    Raises
    ------
    ValueError
        If an argument is of another kind, or a key may not vary.
    """
    checks.mapping("case", case)
    checks.sequence("variants", variants, Mapping)
    if not variants:
        raise ValueError("variants is empty: there is one of the base case at least")
    for i, variant in enumerate(variants):
        checks.mapping(f"values of variants[{i}]", variant.get("values"))
        checks.instance(f"reason of variants[{i}]", variant.get("reason"), str)
    if quantities is None:
        quantities = rescaled_keys(Case.model_validate(case))
    checks.mapping("quantities", quantities)
    if table is None:
        checks.mapping("vary", vary, quantities)
        for key, values in vary.items():
            if isinstance(values, Entry):
                checks.instance(f"vary[{key!r}]", values, *DISTRIBUTIONS.values())
            else:
                checks.array(f"vary[{key!r}]", values, ("values",))
        checks.instance("design", design, Grid, Samples, Saltelli)
        columns = design_columns(vary, design)
    else:
        columns = read_table(read_file(table), str(table), quantities)
    columns_of_designs = {}
    for key, column in columns.items():
        name, unit, meaning, factor = quantities[key]
        columns_of_designs[name] = quantity("design", factor * column, unit, meaning)
        columns_of_designs[name].attrs["key"] = key
    entries = zip(*(column.tolist() for column in columns.values()), strict=True)
    rows = [dict(zip(columns, row, strict=True)) for row in entries]
    by_values = {tuple(one["values"].values()): one["reason"] for one in variants}
    possible = (values for values, reason in by_values.items() if not reason)
    numbers = {values: n for n, values in enumerate(possible)}
    own = [tuple(row[key] for key in variants[0]["values"]) for row in rows]
    reasons = [
        by_values[values] or "; ".join(refused(with_values(case, _rescaled(row)), Case))
        for values, row in zip(own, rows, strict=True)
    ]
    columns_of_designs["reason"] = quantity("design", reasons, "1", "why the design is impossible")
    number = [numbers.get(values, -1) for values in own]
    meaning = "number of the joint that is rescaled, or -1 where there is none"
    columns_of_designs["variant"] = quantity("design", number, "1", meaning)
    attributes: dict[str, Any] = {"varied": " ".join(quantities[key].name for key in columns)}
    if isinstance(design, Saltelli):
        attributes["saltelli_samples"] = design.number
    return xr.Dataset(columns_of_designs, attrs=attributes)


def values_of(designs: xr.Dataset) -> list[dict[str, float]]:
    """The values of those keys of each design for which its joint is rescaled."""
    named = {}
    for name in varied(designs):
        values = checks.variable("designs", designs, name, ("design",))
        key = designs[name].attrs.get("key")
        checks.instance(f"key of {name}", key, str)
        named[key] = values
    named = _rescaled(named)
    rows = zip(*(column.tolist() for column in named.values()), strict=True)
    return [dict(zip(named, row, strict=True)) for row in rows] or [{}] * designs.sizes["design"]


def varied(dataset: xr.Dataset) -> list[str]:
    """The names of the quantities that vary, in a list of designs or in a sweep.

    Raises
    ------
    ValueError
        If it does not tell them, or has one that is no quantity of its designs with units.
    """
    places = places_of(dataset)
    names = dataset.attrs.get("varied")
    checks.instance("attribute varied of the designs", names, str)
    for name in names.split():
        dims = tuple(dataset[name].dims) if name in dataset else ()
        checks.variable("designs", dataset, name, dims)
        if not set(dims) <= set(places):
            raise ValueError(f"{name} is over {', '.join(map(str, dims))}, but designs are not")
        checks.instance(f"units of {name}", dataset[name].attrs.get("units"), str)
    return names.split()


def places_of(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dimensions of the designs, in a list of designs or in a sweep.

    Raises
    ------
    ValueError
        If it has no designs.
    """
    checks.instance("designs", dataset, xr.Dataset)
    if "reason" not in dataset:
        raise ValueError("designs has no variable 'reason'")
    return tuple(map(str, dataset["reason"].dims))


def _rescaled(of_keys: Mapping[str, Value]) -> dict[str, Value]:
    return {key: value for key, value in of_keys.items() if is_rescaled(key)}
