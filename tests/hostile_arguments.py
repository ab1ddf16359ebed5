"""Arguments of random types and magnitudes, in place of one of a valid call."""

import zlib
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pandas as pd
import xarray as xr

#: of any argument
ANYTHING = [
    *(None, "", "nope", "1", b"x", True, object(), int, lambda: None),
    *([], {}, (), [None], ["nope"], [[1], [1, 2]], {"nope": 1}, {1: 2}),
    *(-1, 0, 1, 7, 1.5, -5.0, 1j, 10**400, 5e-324, 1e308, np.nan, np.inf, -np.inf),
    *(np.int64(3), np.array(1), np.zeros(0), np.zeros((2, 2, 2)), np.full(3, np.nan)),
    *(np.array(["a"]), np.ma.masked, np.ma.array([1.0, 2.0], mask=[True, False])),
    *(np.datetime64("2020-01-01"), xr.Dataset(), pd.DataFrame(), pd.Series([1.0])),
]


def changed(value, rng):
    """Another value for an argument: of another kind, or nearly the same."""
    near = _near(value, rng) if rng.random() < 0.5 else []
    among = near or ANYTHING
    return among[rng.integers(len(among))]


def assert_refused(function, valid, name, number):
    """Whatever one argument of a valid call is, the call returns or raises a ``ValueError``."""
    # valid to begin with: nothing else is refused
    function(**valid)
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    for _ in range(number):
        wrong = str(rng.choice(list(valid)))
        arguments = valid | {wrong: changed(valid[wrong], rng)}
        try:
            with np.errstate(all="ignore"):
                function(**arguments)
        except (ValueError, OSError):
            pass
        except Exception as error:
            raise AssertionError(f"{wrong} = {arguments[wrong]!r}") from error


def _near(value, rng):
    if isinstance(value, np.ndarray):
        return _near_array(value)
    if isinstance(value, xr.Dataset):
        return _near_dataset(value, rng)
    if isinstance(value, bool):
        return [1, 0, "yes"]
    if isinstance(value, int | float):
        return [-value, 1.5 * value, float(value), 0, 1e9 * value, str(value), [value], 5e-324]
    if isinstance(value, str):
        return [value.upper(), value + "x", value + "=", value[:-1]]
    if isinstance(value, list | tuple) and value:
        i = rng.integers(len(value))
        other = [*value[:i], changed(value[i], rng), *value[i + 1 :]]
        return [other, tuple(other), value[1:], [*value, *value], value[0]]
    if is_dataclass(value) and not isinstance(value, type):
        name = rng.choice([field.name for field in fields(value)])
        try:
            return [replace(value, **{name: changed(getattr(value, name), rng)})]
        except ValueError:
            return []
    return []


def _near_array(value):
    spoiled = value.astype(float)
    spoiled.flat[:1] = np.nan
    negative, beyond = value.copy(), value.copy()
    negative.flat[:1] = -1
    beyond.flat[-1:] = 10**9 if value.dtype.kind in "if" else value.flat[-1:]
    near = [value.T, value[:-1], value[:0], value[None], value[..., None], value.ravel()]
    near += [
        value * 0,
        spoiled * -1,
        value.astype(complex),
        value.astype(str),
        value.astype(object),
    ]
    return [*near, spoiled, negative, beyond, np.ma.array(value, mask=True), spoiled * 1e200]


def _near_dataset(value, rng):
    name = str(rng.choice(list(value.data_vars)))
    dim = str(rng.choice(list(value.sizes)))
    near = [value.drop_vars(name), value.assign({name: ("none", np.zeros(2))})]
    near += [value.assign({name: (value[name].dims, np.full(value[name].shape, "a"))})]
    near += [value.isel({dim: slice(0)}), value.isel({dim: 0}), value.rename({dim: "other"})]
    for wrong in (np.nan, -1e9, 1e9, -1, 10**9):
        copy = value.copy(deep=True)
        if copy[name].size and copy[name].dtype.kind in ("f" if wrong != wrong else "if"):
            wide = np.array(copy[name], dtype="f8" if copy[name].dtype.kind == "f" else "i8")
            wide.flat[0] = wrong
            near.append(copy.assign({name: (copy[name].dims, wide, copy[name].attrs)}))
    return near
