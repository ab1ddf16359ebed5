"""Checks of arguments where data enters: type, shape, finiteness and range.

Every check returns what it checked as the library computes with it, or raises a ``ValueError`` that
names the argument, what it is and what is allowed. Lists are converted to arrays and whole numbers
to floating point; the other way round, nothing is rounded: a float is no index, be it whole or not.
"""

import operator
from collections.abc import Collection, Mapping, Sequence
from math import isfinite
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import xarray as xr

Shape = Sequence[int | str]
"""Length of each dimension, or a name where any length is allowed."""

#: motion of a point in a mode, over that of other points, below which it is rounding: where there
#: should be none, it reaches 2e-10 on the meshes of the study
ROUNDING_OF_MODES = 1e-8

#: excitation levels beyond which energies, which go with their square, are zero or infinite
SMALLEST_LEVEL, LARGEST_LEVEL = 1e-100, 1e100

#: largest whole number, that of an index
_LARGEST = np.iinfo(np.int64).max

#: length of a value in a message, in characters
_LONGEST = 100

#: what a limit asks for, and how it reads
_LIMITS = {
    "above": (operator.gt, "above"),
    "at_least": (operator.ge, "at least"),
    "below": (operator.lt, "below"),
    "at_most": (operator.le, "at most"),
}


def array(
    name: str,
    value: ArrayLike,
    shape: Shape | None = None,
    *,
    finite: bool = True,
    **limits: float,
) -> NDArray[np.float64]:
    """An array of real numbers.

    Parameters
    ----------
    name
        Name of the argument.
    value
        What it was given.
    shape
        What its shape must be; any by default.
    finite
        Whether NaN and infinity are refused.
    **limits
        ``above``, ``at_least``, ``below`` or ``at_most``, for every entry.

    Returns
    -------
    ndarray
        C-contiguous; the array itself where it is one of this kind already.
    """
    found = np.asarray(_plain(name, value, "iuf", "real numbers", shape), dtype=float, order="C")
    if finite and not np.isfinite(found).all():
        raise ValueError(f"{name} must be finite, {_first(found, ~np.isfinite(found))}")
    _refuse_outside(name, found, limits)
    return found


def indices(
    name: str, value: ArrayLike, shape: Shape | None = None, *, count: int | None = None
) -> NDArray[np.int64]:
    """An array of indices from 0, below ``count`` where there is one."""
    # an empty list has no kind of its own
    empty = isinstance(value, list | tuple) and not value
    found = np.zeros(0, dtype=np.int64) if empty else value
    found = np.asarray(_plain(name, found, "iu", "whole numbers", shape), np.int64, order="C")
    allowed = {"at_least": 0} if count is None else {"at_least": 0, "below": count}
    _refuse_outside(name, found, allowed)
    return found


def flags(name: str, value: ArrayLike, shape: Shape | None = None) -> NDArray[np.bool_]:
    """An array of booleans."""
    return _plain(name, value, "b", "booleans", shape)


def number(name: str, value: float, **limits: float) -> float:
    """A finite real number within limits, as for ``array``."""
    found = value if type(value) is float else _scalar(value)
    if not isinstance(found, (float, Real)) or isinstance(found, bool) or not _is_finite(found):
        raise ValueError(f"{name} is {_printed(value)}: it must be a finite number")
    _refuse_number_outside(name, found, limits)
    return float(found)


def _printed(value: object) -> str:
    """A value that is refused, on one line of some length."""
    # Python prints no whole number of thousands of digits
    if isinstance(value, Integral) and abs(value) > _LARGEST:
        return f"a whole number of {int(value).bit_length()} bits"
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _is_finite(value: Real) -> bool:
    try:
        return isfinite(value)
    except OverflowError:
        return False


def whole(name: str, value: int, **limits: int) -> int:
    """A whole number within limits, as for ``array``."""
    found = _scalar(value)
    if not isinstance(found, Integral) or isinstance(found, bool) or abs(found) > _LARGEST:
        raise ValueError(f"{name} is {_printed(value)}: it must be a whole number")
    _refuse_number_outside(name, found, limits)
    return int(found)


def flag(name: str, value: bool) -> bool:
    """True or false."""
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"{name} is {_printed(value)}: it must be True or False")
    return bool(value)


def choice(name: str, value: str, allowed: Collection[str]) -> str:
    """One of several words."""
    if not (isinstance(value, str) and value in allowed):
        raise ValueError(f"{name} {_printed(value)} is not known; allowed: {', '.join(allowed)}")
    return value


def numbers(name: str, value: ArrayLike) -> list[float]:
    """One or more finite numbers above zero."""
    found = array(name, value, ("values",), above=0)
    if not found.size:
        raise ValueError(f"{name} is empty: it must hold at least one value")
    return found.tolist()


def level(name: str, value: float) -> float:
    """An excitation level: a number above zero under which energies are numbers too."""
    return number(name, value, above=0, at_least=SMALLEST_LEVEL, at_most=LARGEST_LEVEL)


def levels(name: str, value: ArrayLike) -> list[float]:
    """One or more excitation levels."""
    return [level(f"{name}[{i}]", each) for i, each in enumerate(numbers(name, value))]


def ascending(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Two or more finite numbers, each above the one before."""
    found = array(name, value, ("values",))
    if found.size < 2 or not np.all(np.diff(found) > 0):
        raise ValueError(f"{name} is {found}: it must hold two or more values that increase")
    return found


def interval(name: str, value: ArrayLike) -> tuple[float, float]:
    """Two finite numbers above zero, the lower first."""
    low, high = array(name, value, (2,), above=0).tolist()
    if not low < high:
        raise ValueError(f"{name} is from {low:g} to {high:g}: it must increase")
    return low, high


def instance(name: str, value: object, *allowed: type) -> None:
    """An object of one of several classes."""
    if not isinstance(value, allowed):
        classes = " or ".join(each.__name__ for each in allowed)
        raise ValueError(f"{name} is of type {type(value).__name__}: it must be {classes}")


def subclass(name: str, value: type, base: type) -> None:
    """A class that is derived from another."""
    if not (isinstance(value, type) and issubclass(value, base)):
        raise ValueError(f"{name} is {_printed(value)}: it must be a class of {base.__name__}")


def path(name: str, value: str | PathLike[str]) -> Path:
    """Path of a file."""
    instance(name, value, str, PathLike)
    return Path(value)


def mapping(name: str, value: Mapping[str, Any], keys: Collection[str] | None = None) -> None:
    """Values by words, which are among ``keys`` where these are given."""
    instance(name, value, Mapping)
    for key in value:
        if not isinstance(key, str):
            raise ValueError(f"{name} has the key {_printed(key)}: keys must be words")
        if keys is not None:
            choice(f"key of {name}", key, keys)


def sequence(name: str, value: Sequence[Any], *allowed: type) -> None:
    """Objects in an order, each of one of several classes where these are given."""
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise ValueError(f"{name} is of type {type(value).__name__}: it must be a sequence")
    if allowed:
        for i, each in enumerate(value):
            instance(f"{name}[{i}]", each, *allowed)


def variable(
    name: str, dataset: "xr.Dataset", key: str, dims: Sequence[str], **limits: float
) -> NDArray[np.float64]:
    """A variable of a dataset, its dimensions in the order given, as for ``array``."""
    return array(f"{key} of {name}", _values(name, dataset, key, dims), **limits)


def index_variable(
    name: str, dataset: "xr.Dataset", key: str, dims: Sequence[str], *, count: int | None = None
) -> NDArray[np.int64]:
    """A variable of indices, as for ``indices``."""
    return indices(f"{key} of {name}", _values(name, dataset, key, dims), count=count)


def _values(name: str, dataset: "xr.Dataset", key: str, dims: Sequence[str]) -> NDArray:
    # imported here: it takes its time, and options of the configuration are checked without it
    from xarray import Dataset

    instance(name, dataset, Dataset)
    instance(f"variable of {name}", key, str)
    if key not in dataset:
        raise ValueError(f"{name} has no variable {key!r}")
    found = dataset[key]
    if set(found.dims) != set(dims):
        raise ValueError(
            f"{key} of {name} is over {', '.join(map(str, found.dims)) or 'nothing'}, "
            f"expected {', '.join(dims) or 'nothing'}"
        )
    return found.transpose(*dims).to_numpy()


def _plain(name: str, value: ArrayLike, kinds: str, what: str, shape: Shape | None) -> NDArray:
    # NumPy drops masks in silence
    rows = value if isinstance(value, list | tuple) else [value]
    if any(np.ma.isMaskedArray(row) for row in rows):
        raise ValueError(f"{name} is a masked array: it must be one without a mask")
    try:
        found = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} must be an array of {what}: its rows differ in length") from None
    except TypeError:
        kind = type(value).__name__
        raise ValueError(f"{name} must be an array of {what}, not of type {kind}") from None
    if found.dtype.kind not in kinds:
        raise ValueError(f"{name} must be an array of {what}, not of type {found.dtype}")
    if shape is not None and not _fits(found.shape, shape):
        expected = f"({', '.join(map(str, shape))}{',' * (len(shape) == 1)})"
        raise ValueError(f"{name} has shape {found.shape}, expected {expected}")
    return found


def _fits(found: tuple[int, ...], shape: Shape) -> bool:
    if len(found) != len(shape):
        return False
    for length, expected in zip(found, shape, strict=True):
        if length != expected and not isinstance(expected, str):
            return False
    return True


def _scalar(value: object) -> object:
    # NumPy's masked number would be zero
    if getattr(value, "ndim", None) != 0 or np.ma.isMaskedArray(value):
        return value
    return value.item()


def _refuse_outside(name: str, found: NDArray, limits: dict[str, float]) -> None:
    for limit, bound in limits.items():
        within = _LIMITS[limit][0](found, bound)
        if not within.all():
            raise ValueError(f"{name} must be {_in_words(limits)}, {_first(found, ~within)}")


def _refuse_number_outside(name: str, found: float, limits: dict[str, float]) -> None:
    for limit, bound in limits.items():
        if not _LIMITS[limit][0](found, bound):
            raise ValueError(f"{name} is {found}: it must be {_in_words(limits)}")


def _in_words(limits: dict[str, float]) -> str:
    return " and ".join(
        "positive" if (limit, bound) == ("above", 0) else f"{_LIMITS[limit][1]} {bound:g}"
        for limit, bound in limits.items()
    )


def _first(found: NDArray, wrong: NDArray[np.bool_]) -> str:
    """The first entry that is wrong, and where it is."""
    at = tuple(int(i) for i in np.argwhere(wrong)[0])
    where = "" if not at else f" at index {at[0] if len(at) == 1 else at}"
    return f"but is {found[at]:g}{where}"
