"""Weights of contact pairs that hold the peaks of the designs of a sweep."""

import logging
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from boltjoint import checks
from boltjoint.dynamics.reduction.hyper_reduction import HeldPeaks, weigh_pairs
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl
from boltjoint.study.common_to_designs import IMPOSSIBLE
from boltjoint.study.designs import SweptJoint, values_of
from boltjoint.study.regression_of_peaks import spread_designs

logger = logging.getLogger(__name__)


def weigh_pairs_of_designs(
    joint: Joint,
    designs: xr.Dataset,
    case: Mapping[str, Any],
    variants: Sequence[int],
    *,
    control: StepControl | None = None,
    number: int = 8,
    **accuracy: Any,  # noqa: ANN401
) -> tuple[Joint, xr.Dataset]:
    """A few pairs of a joint, with weights that hold its peaks and those of designs of a sweep.

    Under the levels of the designs.

    Of the uncertain joint of the shipped sweeps, weights made for the base case alone were off by
    up to 2.5 % in amplitude in 40 designs drawn at random, and with eight designs more by 0.11 %.

    Parameters
    ----------
    joint
        Node to node, of the base case.
    designs
        All designs of the sweep (``list_designs``).
    case
        Content of the base case.
    variants
        Numbers of the variants of this case.
    control
        Step-length control of the backbones.
    number
        Of designs, spread over all of these variants.
    accuracy
        As for ``weigh_pairs``: ``count``, or tolerances.

    Returns
    -------
    joint : Joint
        Of the points that are kept.
    fit : Dataset
        As from ``weigh_pairs``.

    Raises
    ------
    ValueError
        As from ``weigh_pairs``, or if an argument is of another kind.
    RuntimeError
        As from ``weigh_pairs``.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("designs", designs, xr.Dataset)
    checks.whole("number", number, at_least=1)
    swept = SweptJoint(case, [joint])
    base, (block, *_), others = swept.base, swept.base.solve, {}
    own = designs.isel(design=np.isin(designs["variant"].to_numpy(), variants))
    for values in values_of(own.isel(design=spread_designs(own, number))):
        try:
            design, (rescaled,) = swept.rescaled(values)
        except IMPOSSIBLE as error:
            logger.warning("weights are not made for a design: %s", error)
        else:
            # designs may differ in the number of pairs alone
            held = HeldPeaks(rescaled, design.levels, design.structural_damping)
            others[tuple(values.items())] = held
    levels = [level for other in others.values() for level in other.forces]
    return weigh_pairs(
        joint,
        levels or base.levels,
        base.structural_damping,
        windows={block.resonance: block.window_Hz},
        control=control,
        others=list(others.values()),
        **accuracy,
    )
