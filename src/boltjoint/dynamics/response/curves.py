"""Response curves arranged: by excitation level for notebooks, on one grid to compare designs."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.joint.model import Joint

#: of the solutions that are arranged, as far as the response has them
_OF_SOLUTIONS = ("frequency", "response_amplitude", "stable", "error_estimate")


def by_force(response: xr.Dataset, joint: Joint | None = None) -> xr.Dataset:
    """The solutions of a response by excitation level, along each branch.

    Parameters
    ----------
    response
        As ``solve_response`` returns it, or ``response.nc``.
    joint
        The joint that was solved: with it, the motion of its sensors is told too.

    Returns
    -------
    Dataset
        ``force`` [N or m/s^2] is a coordinate. The variables of the levels are as before. Those of
        the solutions have the dimensions (force, point): branches that are shorter than the
        longest end with not a number, and so do solutions that did not converge. With a joint,
        ``complex_amplitude`` [m] (force, point, sensor) is the first harmonic of each sensor, sine
        coefficient + i cosine coefficient: its angle is the phase by which the motion leads the
        sine of the excitation.

    Raises
    ------
    ValueError
        If the response is no dataset of one, or of another joint.
    """
    checks.instance("response", response, xr.Dataset)
    levels = checks.variable("response", response, "force_level", ("force",))
    of_solution = checks.variable("response", response, "excitation_force", ("solution",))
    solved = response["converged"].to_numpy() == 1
    places = [np.flatnonzero((of_solution == level) & solved) for level in levels]
    longest = max((place.size for place in places), default=0)
    arranged = {name: response[name] for name in response if "solution" not in response[name].dims}

    def along(values: np.ndarray) -> np.ndarray:
        rows = np.full((levels.size, longest, *values.shape[1:]), np.nan, values.dtype)
        for row, place in zip(rows, places, strict=True):
            row[: place.size] = values[place]
        return rows

    for name in _OF_SOLUTIONS:
        if name in response:
            values = response[name].to_numpy().astype(float)
            arranged[name] = xr.Variable(("force", "point"), along(values), response[name].attrs)
    if joint is not None:
        checks.instance("joint", joint, Joint)
        q = response["modal_coordinate"].transpose("solution", "component", "mode")
        modes = np.array(list(joint.sensors.by_name.values()))
        if q.sizes["mode"] != modes.shape[1]:
            raise ValueError(
                f"the response has {q.sizes['mode']} modes, the joint {modes.shape[1]}"
            )
        missing = {"sin", "cos"} - set(q["component"].to_numpy().tolist())
        if missing:
            raise ValueError(f"the response has no component {min(missing)!r}")
        sine, cosine = (q.sel(component=part).to_numpy() @ modes.T for part in ("sin", "cos"))
        meaning = "first harmonic of the sensor, sine + i cosine coefficient"
        dims = ("force", "point", "sensor")
        arranged["complex_amplitude"] = quantity(dims, along(sine + 1j * cosine), "m", meaning)
    whole = xr.Dataset(arranged, attrs=response.attrs)
    unit = {"units": response["force_level"].attrs.get("units", "1")}
    whole = whole.assign_coords(force=xr.Variable("force", levels, unit))
    return whole if joint is None else whole.assign_coords(sensor=list(joint.sensors.by_name))


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
    largest = np.full(grid.size, np.nan)
    path = np.column_stack([frequency, amplitude])
    path = path[np.insert(np.any(np.diff(path, axis=0) != 0, axis=1), 0, True)]
    if len(path) < 2:
        return largest
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
    np.fmax.at(largest, at, below[piece] + share * (above - below)[piece])
    return largest


def _refined(path: Array) -> Array:
    """More points on a path, shape (points, 2), by its arc length with both columns scaled."""
    steps = np.diff(path, axis=0) / np.ptp(path, axis=0).clip(np.finfo(float).tiny)
    arc = np.insert(np.hypot(*steps.T).cumsum(), 0, 0.0)
    between = np.linspace(arc[:-1], arc[1:], _PIECES, endpoint=False).T.ravel()
    return Akima1DInterpolator(arc, path)(np.append(between, arc[-1]))
