"""Figure of the sensors of a response."""

import xarray as xr
from matplotlib.figure import Figure

from boltjoint.report.figures.style import (
    MM,
    REFERENCE_LINE,
    add_legends,
    figure_style,
    level_colours,
)


@figure_style
def plot_sensors(response: xr.Dataset) -> Figure:
    """Amplitude of each sensor over frequency at all levels, divided by the level.

    Parameters
    ----------
    response
        ``response.nc``.
    """
    names, levels = response["sensor"].to_numpy(), response["force_level"].to_numpy()
    unit = response["force_level"].attrs["units"]
    figure = Figure(figsize=(8, 1 + 2.5 * names.size), layout="constrained")
    panels = figure.subplots(names.size, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(panels, names, strict=True):
        amplitude = response["sensor_amplitude"].sel(sensor=name).to_numpy()
        for level, colour in zip(levels, level_colours(levels.size), strict=True):
            at = (response["excitation_force"] == level) & (response["converged"] == 1)
            x = response["frequency"].to_numpy()[at]
            axes.semilogy(x, MM * amplitude[at] / level, color=colour, **REFERENCE_LINE)
        axes.set(ylabel=f"{name}\n(mm per {unit})")
        axes.grid(True)
    panels[-1].set_xlabel("frequency (Hz)")
    labels = [f"{level:g} {unit}" for level in levels]
    add_legends(panels[0], {"node to node, linear modes": REFERENCE_LINE}, "level", labels, {})
    return figure
