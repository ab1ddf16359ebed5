"""What is in a figure, and examples that several figures are drawn from."""

import numpy as np
from matplotlib.collections import PathCollection
from small_joint import make_joint, make_preload

from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.partition import partition_regions

FORCES = [0.01, 5.0, 20.0]


def shapes(axes):
    return [c for c in axes.collections if isinstance(c, PathCollection)]


def curves(axes):
    """What was drawn of each method and level, by name."""
    lines = (line for line in axes.get_lines() if not line.get_label().startswith("_"))
    return {line.get_label(): line.get_xydata() for line in lines}


def marks(axes, marker):
    return [line.get_xydata()[0] for line in axes.get_lines() if line.get_marker() == marker]


def legend_texts(axes):
    legends = [axes.get_legend(), *axes.figure.legends]
    return [text.get_text() for legend in legends for text in legend.get_texts()]


def texts_in(figure):
    return [text.get_text() for axes in figure.axes for text in axes.texts]


def polygon_area(polygons):
    """Area [of the square unit] of closed loops, those around holes running the other way."""
    return sum(
        np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) / 2 for x, y in (loop.T for loop in polygons)
    )


def on_pairs(assembly, loaded):
    """A joint of two regions on some pairs of the small assembly."""
    nodes = make_joint(len(loaded))
    part = joint_to_dataset(partition_regions(nodes, make_preload(nodes), 2))
    position = assembly["position"].isel(pair=loaded).rename(pair="element")
    load = np.arange(1.0, len(loaded) + 1)
    region = (np.arange(len(loaded)) >= 9).astype(int)
    return part.assign(
        element_position=position,
        slip_force=("element", load),
        point_of_element=("element", region),
    )
