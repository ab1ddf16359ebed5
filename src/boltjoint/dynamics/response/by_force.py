"""A response arranged by its excitation levels, for notebooks: ``r.sel(force=5)``."""

import numpy as np
import xarray as xr

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
        found = np.full((levels.size, longest, *values.shape[1:]), np.nan, values.dtype)
        for row, place in zip(found, places, strict=True):
            row[: place.size] = values[place]
        return found

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
