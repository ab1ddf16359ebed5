"""Checks of arguments where data enters: type, shape, finiteness and range.

Every check returns what it checked as the library computes with it, or raises a ``ValueError`` that
names the argument, what it is and what is allowed. Lists are converted to arrays and whole numbers
to floating point; the other way round, nothing is rounded: a float is no index, be it whole or not.
"""

import operator
from collections.abc import Callable, Collection, Mapping, Sequence
from math import isfinite
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import xarray as xr

_Class = TypeVar("_Class")
_Word = TypeVar("_Word", bound=str)


class Limits(TypedDict, total=False):
    """Limits of a number, or of each of an array."""

    above: float
    at_least: float
    below: float
    at_most: float


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
_LIMITS: dict[str, tuple[Callable[[Any, Any], Any], str]] = {
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
    **limits: Unpack[Limits],
) -> NDArray[np.float64]:
    """An array of real numbers.

    Parameters
    ----------
    name
        Name of the argument.
    value
        Value of the argument.
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
    entries = np.asarray(_plain(name, value, "iuf", "real numbers", shape), dtype=float, order="C")
    if finite and not np.isfinite(entries).all():
        raise ValueError(f"{name} must be finite, {_first(entries, ~np.isfinite(entries))}")
    _refuse_outside(name, entries, limits)
    return entries


def is_number(value: object) -> bool:
    """Whether a value is one of all, not an array with one of each; of any type."""
    return bool(np.isscalar(value)) or getattr(value, "ndim", None) == 0


def of_each(
    name: str, value: ArrayLike, shape: tuple[int, ...], **limits: Unpack[Limits]
) -> NDArray[np.float64]:
    """An array of this shape, from a number of all or from one of each."""
    if is_number(value):
        return np.full(shape, number(name, value, **limits))
    return array(name, value, shape, **limits)


def indices(
    name: str, value: ArrayLike, shape: Shape | None = None, *, count: int | None = None
) -> NDArray[np.int64]:
    """An array of indices from 0, below ``count`` where there is one."""
    # an empty list has no kind of its own
    is_empty = isinstance(value, list | tuple) and not value
    plain = _plain(
        name, np.zeros(0, dtype=np.int64) if is_empty else value, "iu", "whole numbers", shape
    )
    entries = np.asarray(plain, np.int64, order="C")
    _refuse_outside(name, entries, {"at_least": 0} | ({} if count is None else {"below": count}))
    return entries


def flags(name: str, value: ArrayLike, shape: Shape | None = None) -> NDArray[np.bool_]:
    """An array of booleans."""
    return _plain(name, value, "b", "booleans", shape)


def number(name: str, value: ArrayLike, **limits: Unpack[Limits]) -> float:
    """A finite real number within limits, as for ``array``."""
    plain = value if type(value) is float else _scalar(value)
    if not isinstance(plain, (float, Real)) or isinstance(plain, bool) or not _is_finite(plain):
        raise ValueError(f"{name} is {_printed(value)}: it must be a finite number")
    _refuse_number_outside(name, plain, limits)
    return float(plain)


def _printed(value: object) -> str:
    """A value that is refused, on one line of some length."""
    # Python prints no whole number of thousands of digits
    if isinstance(value, Integral) and abs(int(value)) > _LARGEST:
        return f"a whole number of {int(value).bit_length()} bits"
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _is_finite(value: float | Real) -> bool:
    try:
        return isfinite(value)
    except OverflowError:
        return False


def whole(name: str, value: ArrayLike, **limits: int) -> int:
    """A whole number within limits, as for ``array``."""
    plain = _scalar(value)
    if not isinstance(plain, Integral) or isinstance(plain, bool) or abs(int(plain)) > _LARGEST:
        raise ValueError(f"{name} is {_printed(value)}: it must be a whole number")
    _refuse_number_outside(name, plain, limits)
    return int(plain)


def flag(name: str, value: bool) -> bool:
    """True or false."""
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"{name} is {_printed(value)}: it must be True or False")
    return bool(value)


def choice(name: str, value: _Word, allowed: Collection[str]) -> _Word:
    """One of several words."""
    if not (isinstance(value, str) and value in allowed):
        raise ValueError(f"{name} {_printed(value)} is not known; allowed: {', '.join(allowed)}")
    return value


def numbers(name: str, value: ArrayLike) -> list[float]:
    """One or more finite numbers above zero."""
    entries = array(name, value, ("values",), above=0)
    if not entries.size:
        raise ValueError(f"{name} is empty: it must hold at least one value")
    return entries.tolist()


def level(name: str, value: float) -> float:
    """An excitation level: a number above zero under which energies are numbers too."""
    return number(name, value, above=0, at_least=SMALLEST_LEVEL, at_most=LARGEST_LEVEL)


def levels(name: str, value: ArrayLike) -> list[float]:
    """One or more excitation levels."""
    return [level(f"{name}[{i}]", entry) for i, entry in enumerate(numbers(name, value))]


def ascending(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Two or more finite numbers, each above the one before."""
    entries = array(name, value, ("values",))
    if entries.size < 2 or not np.all(np.diff(entries) > 0):
        raise ValueError(f"{name} is {entries}: it must hold two or more values that increase")
    return entries


def interval(name: str, value: ArrayLike) -> tuple[float, float]:
    """Two finite numbers above zero, the lower first."""
    low, high = array(name, value, (2,), above=0).tolist()
    if not low < high:
        raise ValueError(f"{name} is from {low:g} to {high:g}: it must increase")
    return low, high


def instance(name: str, value: object, *allowed: type[_Class]) -> _Class:
    """An object of one of several classes."""
    if not isinstance(value, allowed):
        classes = " or ".join(kind.__name__ for kind in allowed)
        raise ValueError(f"{name} is of type {type(value).__name__}: it must be {classes}")
    return value


def subclass(name: str, value: type, base: type) -> None:
    """A class that is derived from another."""
    if not (isinstance(value, type) and issubclass(value, base)):
        raise ValueError(f"{name} is {_printed(value)}: it must be a class of {base.__name__}")


def path(name: str, value: str | PathLike[str]) -> Path:
    """Path of a file."""
    instance(name, value, str, PathLike)
    return Path(value)


def mapping(name: str, value: Mapping[str, Any], keys: Collection[str] | None = None) -> None:
    """Values by words, which are among ``keys`` where there are any."""
    instance(name, value, Mapping)
    for key in value:
        if not isinstance(key, str):
            raise ValueError(f"{name} has the key {_printed(key)}: keys must be words")
        if keys is not None:
            choice(f"key of {name}", key, keys)


def sequence(name: str, value: Sequence[Any], *allowed: type) -> None:
    """Objects in an order, each of one of several classes where there are any."""
    if isinstance(value, str | bytes) or not isinstance(value, Sequence):
        raise ValueError(f"{name} is of type {type(value).__name__}: it must be a sequence")
    if allowed:
        for i, entry in enumerate(value):
            instance(f"{name}[{i}]", entry, *allowed)


def variable(
    name: str,
    dataset: "xr.Dataset",
    key: str,
    dims: Sequence[str],
    *,
    finite: bool = True,
    **limits: float,
) -> NDArray[np.float64]:
    """A variable of a dataset, its dimensions in this order, as for ``array``."""
    values = _values(name, dataset, key, dims)
    return array(f"{key} of {name}", values, None, finite=finite, **limits)


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
    values = dataset[key]
    if set(values.dims) != set(dims):
        raise ValueError(
            f"{key} of {name} is over {', '.join(map(str, values.dims)) or 'nothing'}, "
            f"expected {', '.join(dims) or 'nothing'}"
        )
    return values.transpose(*dims).to_numpy()


def _plain(name: str, value: ArrayLike, kinds: str, what: str, shape: Shape | None) -> NDArray:
    entries = value if type(value) is np.ndarray else _as_entries(name, value, what)
    if entries.dtype.kind not in kinds:
        raise ValueError(f"{name} must be an array of {what}, not of type {entries.dtype}")
    if shape is not None and not _fits(entries.shape, shape):
        expected = f"({', '.join(map(str, shape))}{',' * (len(shape) == 1)})"
        raise ValueError(f"{name} has shape {entries.shape}, expected {expected}")
    return entries


def _as_entries(name: str, value: ArrayLike, what: str) -> NDArray:
    # NumPy drops masks in silence
    rows = value if isinstance(value, list | tuple) else [value]
    if any(np.ma.isMaskedArray(row) for row in rows):
        raise ValueError(f"{name} is a masked array: it must be one without a mask")
    try:
        return np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} must be an array of {what}: its rows differ in length") from None
    except TypeError:
        kind = type(value).__name__
        raise ValueError(f"{name} must be an array of {what}, not of type {kind}") from None


def _fits(lengths: tuple[int, ...], shape: Shape) -> bool:
    if len(lengths) != len(shape):
        return False
    for length, expected in zip(lengths, shape, strict=True):
        if length != expected and not isinstance(expected, str):
            return False
    return True


def _scalar(value: Any) -> object:  # noqa: ANN401
    # NumPy's masked number would be zero
    if getattr(value, "ndim", None) != 0 or np.ma.isMaskedArray(value):
        return value
    return value.item()


def _refuse_outside(name: str, entries: NDArray, limits: Mapping[str, Any]) -> None:
    for limit, bound in limits.items():
        within = _LIMITS[limit][0](entries, bound)
        if not within.all():
            raise ValueError(f"{name} must be {_in_words(limits)}, {_first(entries, ~within)}")


def _refuse_number_outside(
    name: str, value: float | Real | Integral, limits: Mapping[str, Any]
) -> None:
    for limit, bound in limits.items():
        if not _LIMITS[limit][0](value, bound):
            raise ValueError(f"{name} is {value}: it must be {_in_words(limits)}")


def _in_words(limits: Mapping[str, float]) -> str:
    return " and ".join(
        "positive" if (limit, bound) == ("above", 0) else f"{_LIMITS[limit][1]} {bound:g}"
        for limit, bound in limits.items()
    )


def _first(entries: NDArray, wrong: NDArray[np.bool_]) -> str:
    """The first entry that is wrong, and where it is."""
    at = tuple(int(i) for i in np.argwhere(wrong)[0])
    where = "" if not at else f" at index {at[0] if len(at) == 1 else at}"
    return f"but is {entries[at]:g}{where}"
