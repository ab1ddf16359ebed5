"""Designs of a sweep: the values of the keys that vary, and which of them are impossible."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.config.case import Case
from boltjoint.config.distributions import Range, Values
from boltjoint.config.sweep import Design, Grid, Saltelli
from boltjoint.config.varied_case import keys_that_vary, read_table, refused, with_values
from boltjoint.dataset import quantity

Array = NDArray[np.float64]


def list_designs(
    vary: Mapping[str, Values],
    design: Design,
    case: Mapping[str, object],
    table: str | Path | None = None,
) -> xr.Dataset:
    """The designs of a sweep.

    Parameters
    ----------
    vary, design
        Values of the keys that vary, and which of their combinations are designs.
    case
        Content of the base case.
    table
        File of the designs, with ``kind: table``.

    Returns
    -------
    Dataset
        By ``design`` the value of each key, under the name of the quantity and with the key as an
        attribute, and ``reason``, why the design is impossible, empty where it is not. Its
        attributes are ``varied``, the names in their order, and of ``kind: saltelli``
        ``saltelli_samples``, the designs of each sample.
    """
    base = Case.model_validate(case)
    if table is None:
        columns = _columns(vary, design)
    else:
        columns = read_table(Path(table).read_text(encoding="utf-8"), str(table), base)
    quantities, found = keys_that_vary(base), {}
    for key, column in columns.items():
        name, unit, meaning = quantities[key]
        found[name] = quantity("design", column, unit, meaning)
        found[name].attrs["key"] = key
    rows = np.column_stack(list(columns.values())).tolist()
    changed = (with_values(case, dict(zip(columns, row, strict=True))) for row in rows)
    reasons = ["; ".join(refused(each, Case)) for each in changed]
    found["reason"] = quantity("design", reasons, "1", "why the design is impossible")
    attributes: dict[str, object] = {"varied": " ".join(quantities[key].name for key in columns)}
    if isinstance(design, Saltelli):
        attributes["saltelli_samples"] = design.number
    return xr.Dataset(found, attrs=attributes)


def values_of(designs: xr.Dataset) -> list[dict[str, float]]:
    """The values of the keys of each design."""
    named = {designs[name].attrs["key"]: designs[name].to_numpy() for name in varied(designs)}
    rows = zip(*(column.tolist() for column in named.values()), strict=True)
    return [dict(zip(named, row, strict=True)) for row in rows]


def varied(dataset: xr.Dataset) -> list[str]:
    """The names of the quantities that vary, in a list of designs or in a sweep."""
    return dataset.attrs["varied"].split()


def _columns(vary: Mapping[str, Values], design: Design) -> dict[str, Array]:
    """Values of each key by design; of a grid the last key varies first."""
    if isinstance(design, Grid):
        axes = np.meshgrid(*map(_grid_values, vary.values()), indexing="ij")
        return {key: axis.ravel() for key, axis in zip(vary, axes, strict=True)}
    # it takes half a second to import
    from scipy.stats import qmc

    if isinstance(design, Saltelli):
        # as scipy.stats.sobol_indices draws them
        both = qmc.Sobol(2 * len(vary), rng=design.seed).random(design.number).T
        shares = _exchanged(*np.split(both, 2))
    else:
        kinds = {"sobol": qmc.Sobol, "latin-hypercube": qmc.LatinHypercube}
        shares = kinds[design.kind](len(vary), rng=design.seed).random(design.number).T
    drawn = zip(vary.items(), shares, strict=True)
    return {key: _quantile(values, share) for (key, values), share in drawn}


def _exchanged(first: Array, second: Array) -> Array:
    """Both samples, (keys, designs), and the first with each key in turn of the second."""
    keys = len(first)
    mixed = np.repeat(first[:, None], keys, axis=1)
    mixed[range(keys), range(keys)] = second
    return np.concatenate([first, second, mixed.reshape(keys, -1)], axis=1)


def _quantile(values: Values, share: Array) -> Array:
    if isinstance(values, tuple):
        return np.array(values)[(share * len(values)).astype(int)]
    return values.quantile(share)


def _grid_values(values: Values) -> Array:
    if isinstance(values, Range):
        return values.quantile(np.linspace(0, 1, values.number))
    return np.array(values)
