"""Verification of modes and contact of an assembly against CalculiX.

CalculiX has its own element, contact search and pretension (``calculix.decks``), so agreement
within the bounds below verifies all of them.
"""

import logging
from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint.structure.makers.half_lap.structure import assemble_assembly

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: agreement of two fields: its value, what measures it, and its lower bound if there is one
Agreement = tuple[float | None, str, float | None]

#: largest relative differences of frequencies and loads
FREQUENCY_BOUND, LOAD_BOUND = 3e-3, 1e-3

#: smallest modal assurance criterion of mode shapes, and correlation of fields of the contact
SHAPE_BOUND, CORRELATION_BOUND = 0.99, 0.999


def compare_with_calculix(
    assembly: xr.Dataset,
    modes: xr.Dataset,
    preload: xr.Dataset,
    other_modes: xr.Dataset,
    other_preload: xr.Dataset,
) -> pd.DataFrame:
    """Natural frequencies and contact of an assembly from both programs, and their differences.

    A mode is compared with that of CalculiX of the largest modal assurance criterion (MAC, weighted
    by mass), since modes of other families lie between.

    Parameters
    ----------
    assembly, modes, preload
        As from ``build_assembly``, ``find_modes`` and ``apply_preload``.
    other_modes, other_preload
        As from ``read_modes`` and ``read_preload``.

    Returns
    -------
    DataFrame
        A row for each quantity: both values, their difference, and the agreement of their fields
        (``likeness``) by the measure named; the bound and whether it holds, where there is one.
    """
    rows = [
        *_compare_modes(assembly, modes, other_modes),
        *_compare_contact(preload, other_preload),
    ]
    table = pd.DataFrame(rows)
    broken = table.loc[table["holds"].eq(False), "quantity"]
    if len(broken):
        logger.warning("CalculiX differs by more than the bound in: %s", ", ".join(broken))
    return table


def _compare_modes(
    assembly: xr.Dataset, modes: xr.Dataset, other: xr.Dataset
) -> Iterator[dict[str, object]]:
    _, M = assemble_assembly(assembly)
    ours, theirs = (
        model["mode_shape"].to_numpy().reshape(M.shape[0], -1) for model in (modes, other)
    )
    own, others = (np.einsum("im,im->m", mode, M @ mode) for mode in (ours, theirs))
    assurance = (ours.T @ M @ theirs) ** 2 / np.outer(own, others)
    for mode, match in enumerate(np.argmax(assurance, axis=1)):
        yield _row(
            f"natural frequency of bending mode {mode + 1}",
            "Hz",
            float(modes["natural_frequency"][mode]),
            float(other["natural_frequency"][match]),
            FREQUENCY_BOUND,
            (assurance[mode, match], "MAC of the shapes", SHAPE_BOUND),
        )


def _compare_contact(preload: xr.Dataset, other: xr.Dataset) -> Iterator[dict[str, object]]:
    load, other_load = (model["normal_load"].to_numpy() for model in (preload, other))
    gap, other_gap = (model["gap"].to_numpy() for model in (preload, other))
    friction, other_friction = (
        model["friction_force"].transpose("pair", "plane").to_numpy() for model in (preload, other)
    )
    closed, other_closed = load > 0, other_load > 0
    same_state = np.mean(closed == other_closed), "share of pairs in the same state", None
    yield _row("normal load of all pairs", "N", load.sum(), other_load.sum(), LOAD_BOUND)
    yield _row(
        "largest normal load of a pair",
        "N",
        load.max(),
        other_load.max(),
        agreement=_correlation(load, other_load, CORRELATION_BOUND),
    )
    yield _row("pairs in contact", "", closed.sum(), other_closed.sum(), agreement=same_state)
    yield _row(
        "largest gap of a pair",
        "µm",
        1e6 * gap.max(),
        1e6 * other_gap.max(),
        agreement=_correlation(gap, other_gap),
    )
    if friction.any():
        yield _row(
            "friction force of all pairs, without direction",
            "N",
            np.linalg.norm(friction, axis=1).sum(),
            np.linalg.norm(other_friction, axis=1).sum(),
            agreement=_correlation(friction, other_friction),
        )
    shortening, other_shortening = (
        float(1e6 * model["shank_shortening"].mean()) for model in (preload, other)
    )
    yield _row("mean shortening of the shanks", "µm", shortening, other_shortening)


def _row(
    name: str,
    unit: str,
    ours: float,
    theirs: float,
    maximum_difference: float | None = None,
    agreement: Agreement = (None, "", None),
) -> dict[str, object]:
    ours, theirs = float(ours), float(theirs)
    likeness, measure, minimum = agreement
    difference = theirs / ours - 1
    bounds, holds = [], True
    if maximum_difference is not None:
        bounds.append(f"difference within {100 * maximum_difference:g} %")
        holds &= abs(difference) <= maximum_difference
    if minimum is not None and likeness is not None:
        bounds.append(f"likeness above {minimum:g}")
        holds &= float(likeness) > minimum
    return {
        "quantity": name,
        "unit": unit,
        "boltjoint": ours,
        "calculix": theirs,
        "difference_percent": 100 * difference,
        "likeness": None if likeness is None else float(likeness),
        "measured_by": measure,
        "bound": ", ".join(bounds),
        "holds": bool(holds) if bounds else None,
    }


def _correlation(ours: Array, theirs: Array, bound: float | None = None) -> Agreement:
    """Correlation of the pairs, and its lower bound."""
    value = float(np.corrcoef(ours.ravel(), theirs.ravel())[0, 1])
    return value, "correlation of the pairs", bound
