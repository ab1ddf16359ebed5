"""Responses on one grid of frequencies, so that those of many designs can be set side by side."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator

from boltjoint import checks

Array = NDArray[np.float64]

#: straight pieces between two solutions of a path: with as many the error of the interpolation
#: between solutions is larger than that of the pieces
_PIECES = 8


def amplitude_on_grid(frequency: Array, amplitude: Array, grid: Array) -> Array:
    """Amplitude of a response at given frequencies; where it folds, the largest of its solutions.

    Between two solutions of the path, frequency and amplitude are interpolated along it (Akima),
    which has no overshoot where the contact changes its state.

    Parameters
    ----------
    frequency, amplitude
        Frequencies and amplitudes of the solutions along the path, of any units, shape
        (solutions,).
    grid
        Ascending frequencies, shape (frequencies,).

    Returns
    -------
    ndarray
        Shape (frequencies,); not a number where the path does not reach.

    Raises
    ------
    ValueError
        If the shapes differ, or the grid does not ascend.
    """
    frequency = checks.array("frequency", frequency, ("solutions",))
    amplitude = checks.array("amplitude", amplitude, frequency.shape)
    grid = checks.array("grid", grid, ("frequencies",))
    if np.any(np.diff(grid) <= 0):
        raise ValueError("grid must ascend")
    found = np.full(grid.size, np.nan)
    path = np.column_stack([frequency, amplitude])
    path = path[np.insert(np.any(np.diff(path, axis=0) != 0, axis=1), 0, True)]
    if len(path) < 2:
        return found
    if len(path) > 2:
        path = _refined(path)
    (left, below), (right, above) = path[:-1].T, path[1:].T
    first, last = (
        np.searchsorted(grid, np.minimum(left, right), "left"),
        np.searchsorted(grid, np.maximum(left, right), "right"),
    )
    # each piece of the path with each frequency that it passes
    count = last - first
    piece = np.repeat(np.arange(count.size), count)
    at = np.arange(piece.size) - np.repeat(np.cumsum(count) - count, count) + first[piece]
    run = (right - left)[piece]
    share = np.divide(grid[at] - left[piece], run, out=np.ones(run.size), where=run != 0)
    np.fmax.at(found, at, below[piece] + share * (above - below)[piece])
    return found


def _refined(path: Array) -> Array:
    """More points on a path, shape (points, 2), by its arc length with both columns scaled."""
    steps = np.diff(path, axis=0) / np.ptp(path, axis=0).clip(np.finfo(float).tiny)
    arc = np.insert(np.hypot(*steps.T).cumsum(), 0, 0.0)
    between = np.linspace(arc[:-1], arc[1:], _PIECES, endpoint=False).T.ravel()
    return Akima1DInterpolator(arc, path)(np.append(between, arc[-1]))
