"""The reductions of joints of regions, by their names in the names of joints."""

from collections.abc import Callable
from functools import partial

import xarray as xr

from boltjoint import checks
from boltjoint.joint.fit_iwan import fit_iwan_joint
from boltjoint.joint.model import Joint
from boltjoint.joint.reduced import fit_reduced_joint, tabulate_joint

#: each takes a joint of regions and its own options, and returns a joint with, if it is fitted, the
#: cost, loop errors, amplitudes and loops of the fit by point
REDUCTIONS: dict[str, Callable[..., tuple[Joint, xr.Dataset]]] = {
    "elements": partial(fit_reduced_joint, method="loops"),
    "harmonic": partial(fit_reduced_joint, method="describing-function"),
    "iwan": fit_iwan_joint,
    "table": lambda joint: (tabulate_joint(joint), xr.Dataset()),
}


def reduce_joint(joint: Joint, reduction: str, **options: object) -> tuple[Joint, xr.Dataset]:
    """Replace the elements of every region by those of a reduction.

    Parameters
    ----------
    joint
        A joint of regions.
    reduction
        One of ``names.REDUCTIONS``.
    options
        Options of that reduction, such as ``count``, the number of elements in each region.

    Returns
    -------
    joint : Joint
        On the same points.
    fit : Dataset
        Further variables of ``joint.nc``: what the fit is and how good.

    Raises
    ------
    ValueError
        If there is no such reduction, or it cannot be made of this joint.
    """
    return REDUCTIONS[checks.choice("reduction", reduction, REDUCTIONS)](joint, **options)
