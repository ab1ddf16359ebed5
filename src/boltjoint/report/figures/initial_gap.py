"""Figure of the initial gap: where the surfaces of the bars stand apart before tightening."""

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from boltjoint.report.figures.contact import set_plan_view
from boltjoint.report.figures.outlines import ContactSurface
from boltjoint.report.figures.style import MM, UM, figure_style, fill_shapes


@figure_style
def plot_initial_gap(assembly: xr.Dataset) -> Figure:
    """Initial gap over the contact, and along the middle and the edges of its width.

    Parameters
    ----------
    assembly
        As ``build_assembly`` returns it, of surfaces with a form error.

    Raises
    ------
    ValueError
        If the assembly has no initial gap.
    """
    if "initial_gap" not in assembly:
        raise ValueError("assembly has no initial gap: its surfaces are flat")
    surface = ContactSurface.of(assembly)
    gap = assembly["initial_gap"].to_numpy() * UM
    figure = Figure(figsize=(8, 4.2), layout="compressed")
    plan, profile = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.2])
    colours = ListedColormap(matplotlib.colormaps["GnBu"](np.linspace(0.08, 1.0, 256)))
    norm = Normalize(0, gap.max() or 1)
    cells = [surface.area_of([pair]) for pair in range(gap.size)]
    fill_shapes(plan, cells, facecolors=colours(norm(gap)), edgecolors="face", linewidths=0.2)
    figure.colorbar(
        ScalarMappable(norm, colours), ax=plan, label="initial gap (μm)", pad=0.01, aspect=8
    )
    set_plan_view(plan, surface)
    x, y = (surface.place * MM).T
    edges = surface.edges_along_middle()
    lines = [np.c_[x[edge], gap[edge]] for edge in edges]
    # a hole interrupts the middle
    profile.add_collection(LineCollection(lines, colors="black", label="middle of the width"))
    on_edge = np.flatnonzero(np.isclose(y, y.max()))
    profile.plot(x[on_edge], gap[on_edge], color="black", linestyle="--", label="edge of the width")
    profile.set(xlabel="x (mm)", ylabel="initial gap (μm)")
    profile.set_ylim(bottom=0)
    profile.legend(loc="lower right", bbox_to_anchor=(1, 1), borderpad=0, ncols=2)
    profile.grid(True)
    return figure
