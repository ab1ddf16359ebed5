"""Verification of modes and contact of an assembly against CalculiX.

CalculiX has its own element, contact search and pretension (``half_lap.calculix``), so agreement
within the bounds below verifies all of them.
"""

import logging
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint.structure.calculix_comparison import (
    PRESTRESSED_MODES,
    Agreement,
    Verified,
    compare_frequencies,
    elastic,
    prestressed_frequencies,
    row,
)
from boltjoint.structure.calculix_program import paragraphs, required_tables
from boltjoint.structure.makers.half_lap.calculix import (
    read_modes,
    read_preload,
    write_modes_deck,
    write_preload_deck,
)
from boltjoint.structure.makers.half_lap.structure import assemble_assembly

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: largest relative differences of frequencies and loads
FREQUENCY_BOUND, LOAD_BOUND = 3e-3, 1e-3

#: smallest modal assurance criterion of mode shapes, and correlation of fields of the contact
SHAPE_BOUND, CORRELATION_BOUND = 0.99, 0.999


def write_decks(
    model: Verified,
    modes: xr.Dataset,
    preload: float | tuple[float, ...],
    paths: Mapping[str, str | Path],
) -> None:
    """Write the decks of modes without contact, of the preload, and of modes under it.

    Parameters
    ----------
    model
        The assembly.
    modes
        As from ``find_modes``: as many are asked for.
    preload
        Tension of each bolt [N].
    paths
        ``modes``, ``preload`` and ``prestressed``: files ending in ``.inp``, whose folders are
        made.

    Raises
    ------
    ValueError
        As for ``write_preload_deck``.
    """
    write_modes_deck(model.assembly, modes.sizes["candidate"], paths["modes"])
    write_preload_deck(model.assembly, preload, paths["preload"])
    write_preload_deck(model.assembly, preload, paths["prestressed"], modes=PRESTRESSED_MODES)


def compare(
    model: Verified, modes: xr.Dataset, preload: xr.Dataset, printed: Mapping[str, str | Path]
) -> pd.DataFrame:
    """What both programs find.

    Parameters
    ----------
    model, modes, preload
        As for ``compare_with_calculix``, with the assembly in ``model``.
    printed
        ``modes``, ``preload`` and ``prestressed``: files ending in ``.dat``.

    Raises
    ------
    ValueError
        If CalculiX did not solve one of the decks.
    """
    assembly = model.assembly
    other_modes = read_modes(assembly, printed["modes"])
    other_preload = read_preload(assembly, printed["preload"])
    table = compare_with_calculix(assembly, modes, preload, other_modes, other_preload)
    under = printed["prestressed"]
    (frequencies,) = required_tables("CYCLES/TIME", paragraphs(under), under)
    ours = prestressed_frequencies(model.structure, preload.attrs["preload_N"])
    rows = compare_frequencies(
        "frequency under preload",
        ours,
        elastic(frequencies[:, 3]),
        FREQUENCY_BOUND,
    )
    return pd.concat([table, pd.DataFrame(rows)], ignore_index=True)


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
        yield row(
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
    yield row("normal load of all pairs", "N", load.sum(), other_load.sum(), LOAD_BOUND)
    yield row(
        "largest normal load of a pair",
        "N",
        load.max(),
        other_load.max(),
        agreement=_correlation(load, other_load, CORRELATION_BOUND),
    )
    yield row("pairs in contact", "", closed.sum(), other_closed.sum(), agreement=same_state)
    yield row(
        "largest gap of a pair",
        "µm",
        1e6 * gap.max(),
        1e6 * other_gap.max(),
        agreement=_correlation(gap, other_gap),
    )
    if friction.any():
        yield row(
            "friction force of all pairs, without direction",
            "N",
            np.linalg.norm(friction, axis=1).sum(),
            np.linalg.norm(other_friction, axis=1).sum(),
            agreement=_correlation(friction, other_friction),
        )
    shortening, other_shortening = (
        float(1e6 * model["shank_shortening"].mean()) for model in (preload, other)
    )
    yield row("mean shortening of the shanks", "µm", shortening, other_shortening)


def _correlation(ours: Array, theirs: Array, bound: float | None = None) -> Agreement:
    """Correlation of the pairs, and its lower bound."""
    value = float(np.corrcoef(ours.ravel(), theirs.ravel())[0, 1])
    return value, "correlation of the pairs", bound
