"""How large a structure is, and where it moves most: what tells how far it is linear."""

import numpy as np
import xarray as xr

from boltjoint.dataset import quantity

#: share of its length by which a structure may move in a linear model: the tip of a cantilever that
#: is deflected by a tenth of its length moves back by 0.6 % of it, which is left out
LINEAR = 0.1


def extent(assembly: xr.Dataset, modes: xr.Dataset) -> dict[str, xr.Variable]:
    """Length of a structure, and the modes of the nodes that move most in any of them.

    Parameters
    ----------
    assembly, modes
        ``assembly.nc`` with the ``coordinate`` (node, axis) of its nodes [m], and ``modes.nc`` with
        their ``mode_shape`` (node, axis, mode).

    Returns
    -------
    dict
        ``structure_length`` [m], the largest extent along an axis, and ``farthest_mode`` (farthest,
        axis, mode) [kg^-1/2] of one node for each mode, each node once; nothing of a structure
        without nodes.
    """
    if "coordinate" not in assembly or "mode_shape" not in modes:
        return {}
    length = np.ptp(assembly["coordinate"].transpose("node", "axis").to_numpy(), axis=0).max()
    shape = modes["mode_shape"].transpose("node", "axis", "mode").to_numpy()
    farthest = np.unique(np.linalg.norm(shape, axis=1).argmax(axis=0))
    meaning = "mode of a node that moves most in one of them"
    return {
        "structure_length": quantity((), float(length), "m", "largest extent of the structure"),
        "farthest_mode": quantity(
            ("farthest", "axis", "mode"), shape[farthest], "kg^-1/2", meaning
        ),
    }
