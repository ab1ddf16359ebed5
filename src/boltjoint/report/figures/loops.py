"""Figures of hysteresis loops."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from boltjoint.report.figures.contact import slip_force
from boltjoint.report.figures.style import (
    MODEL_LINE,
    REFERENCE_LINE,
    UM,
    add_legends,
    figure_style,
    level_colours,
)


@figure_style
def plot_loops(reduced: xr.Dataset, regions: xr.Dataset, region: int = 1) -> Figure:
    """Hysteresis loops of a region with all its elements, and with the few fitted elements.

    The normal load is that of the assembled state, so elements on open pairs carry no force.

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
        slip_force(joint)[joint["point_of_element"].to_numpy() == region - 1]
        for joint in (reduced, regions)
    )
    loaded = np.count_nonzero(many)
    elements = f"all {many.size} elements"
    if loaded < many.size:
        elements = f"{loaded} of {many.size} elements under load"
    here = reduced.isel(point=region - 1).transpose(..., "loop", "sample")
    amplitude = here["loop_amplitude"].to_numpy() * UM
    figure = Figure(figsize=(8, 4.8), layout="constrained")
    axes = figure.subplots()
    original, fitted = f"region {region}, {elements}", f"{few.size} fitted elements"
    levels = [f"{a:.3g} μm" for a in amplitude]
    branches = ("loop_displacement", "loop_force_of_region", "loop_force_of_fit")
    loops = zip(*(here[name].to_numpy() for name in branches), strict=True)
    for loop, level, colour in zip(loops, levels, level_colours(len(levels)), strict=True):
        u, of_region, of_fit = (_whole_loop(branch) for branch in loop)
        axes.plot(u * UM, of_fit, color=colour, label=f"{fitted}, {level}", **MODEL_LINE)
        axes.plot(u * UM, of_region, color=colour, label=f"{original}, {level}", **REFERENCE_LINE)
    axes.set(xlabel="relative displacement (μm)", ylabel="friction force (N)")
    axes.grid(True)
    add_legends(axes, {original: REFERENCE_LINE, fitted: MODEL_LINE}, "amplitude", levels)
    return figure


def _whole_loop(unloading: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement or force over a whole loop; loading is unloading with both signs changed."""
    return np.concatenate([unloading, -unloading])
