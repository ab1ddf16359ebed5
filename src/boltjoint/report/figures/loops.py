"""Figures of hysteresis loops."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from boltjoint.joint.io import joint_from_dataset
from boltjoint.report.figures.style import (
    MODEL_LINE,
    REFERENCE_LINE,
    UM,
    add_legends,
    level_colours,
    styled,
)


@styled
def plot_loops(reduced: xr.Dataset, regions: xr.Dataset, region: int = 1) -> Figure:
    """Hysteresis loops of a region: all its elements against the few fitted to them.

    The loops are those of constant normal load, that of the assembled state; elements on open pairs
    have no part in them.

    Parameters
    ----------
    reduced
        A reduced joint (``joint.nc``) with the loops of its fit.
    regions
        The joint of regions that it was fitted to.
    region
        Which region, from 1 at the clamped end.

    Raises
    ------
    ValueError
        If there is no such region.
    """
    if not 1 <= region <= reduced.sizes["point"]:
        raise ValueError(f"region {region} of {reduced.sizes['point']}")
    few, many = (
        law.slip_force[law.point_of_element == region - 1]
        for law in (joint_from_dataset(joint).law for joint in (reduced, regions))
    )
    loaded = np.count_nonzero(many)
    of_them = f"all its {many.size} elements"
    if loaded < many.size:
        of_them = f"its {loaded} elements under load, of {many.size}"
    here = reduced.isel(point=region - 1).transpose(..., "loop", "sample")
    amplitude = here["loop_amplitude"].to_numpy() * UM
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.subplots()
    all_of_them, fitted = f"region {region}, {of_them}", f"the {few.size} fitted to them"
    levels = [f"{a:.3g} μm" for a in amplitude]
    branches = ("loop_displacement", "loop_force_of_region", "loop_force_of_fit")
    loops = zip(*(here[name].to_numpy() for name in branches), strict=True)
    for loop, level, colour in zip(loops, levels, level_colours(len(levels)), strict=True):
        u, of_region, of_fit = (_whole_loop(branch) for branch in loop)
        axes.plot(u * UM, of_fit, color=colour, label=f"{fitted}, {level}", **MODEL_LINE)
        axes.plot(
            u * UM, of_region, color=colour, label=f"{all_of_them}, {level}", **REFERENCE_LINE
        )
    axes.set(xlabel="relative displacement (μm)", ylabel="friction force (N)")
    axes.grid(True)
    add_legends(axes, {all_of_them: REFERENCE_LINE, fitted: MODEL_LINE}, "amplitude", levels)
    return figure


def _whole_loop(unloading: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement or force round a whole loop; loading is unloading with both signs changed."""
    return np.concatenate([unloading, -unloading])
