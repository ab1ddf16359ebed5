"""A function of many arrays, shared among forked processes."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from math import ceil
from multiprocessing import get_all_start_methods, get_context
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Result = TypeVar("Result")

#: arrays that a process is given at a time, at most, and how often it is given some
_AT_ONCE, _TIMES = 100, 4

_kept: list[Callable[[Array], Any]] = []


def forked_map(
    function: Callable[[Array], Result], arrays: Sequence[Array] | Array, processes: int
) -> Iterator[Result]:
    """Results in the order of the arrays, the same of any number of processes.

    Parameters
    ----------
    function
        Of one array. A fork has functions of a script too, which no other process is given.
    arrays
        One after another.
    processes
        Forked from this one, so that no threads of one's own should run; with 1 there are none.

    Raises
    ------
    ValueError
        If several processes are asked for where a process cannot be forked.
    """
    if processes == 1 or len(arrays) == 0:
        yield from map(function, arrays)
        return
    if "fork" not in get_all_start_methods():
        raise ValueError(f"processes is {processes}: it must be 1 where a process cannot be forked")
    at_once = min(_AT_ONCE, ceil(len(arrays) / (_TIMES * processes)))
    parts = (arrays[first : first + at_once] for first in range(0, len(arrays), at_once))
    with ProcessPoolExecutor(
        processes, get_context("fork"), initializer=_keep, initargs=(function,)
    ) as pool:
        for results in pool.map(_of_kept, parts):
            yield from results


def _keep(function: Callable[[Array], Any]) -> None:
    """Keep the function of a process."""
    _kept[:] = [function]


def _of_kept(arrays: Sequence[Array]) -> list[Any]:
    return [_kept[0](array) for array in arrays]
