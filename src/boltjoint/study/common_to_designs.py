"""Frequency window and amplitudes that are common to all designs of a sweep."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from boltjoint.config.varied_keys import is_rescaled
from boltjoint.study.designs import varied

if TYPE_CHECKING:
    from boltjoint.joint.io import ImpossibleJoint
    from boltjoint.study.swept_joint import SweptJoint

#: units of contact stiffness, of a pair and per area
_STIFFNESSES = ("N/m", "N/m3")

#: smallest amplitude of the grid of backbones, over the largest
_SMALLEST_AMPLITUDE = 1e-3

#: what an impossible design raises
IMPOSSIBLE = (ValueError, ArithmeticError, np.linalg.LinAlgError)


class CommonWindow(NamedTuple):
    """Frequencies [Hz] that hold the resonance of all possible designs.

    ``reasons`` are those of the others, by their rows.
    """

    lowest: float
    highest: float
    reasons: Mapping[int, str]


def common_window(
    variants: Sequence["SweptJoint | ImpossibleJoint"], designs: xr.Dataset
) -> CommonWindow:
    """Frequency window of all designs: their resonances rise with each stiffness.

    Parameters
    ----------
    variants, designs
        As for ``sweeps.solve_designs``.

    Raises
    ------
    ValueError
        If no design has a window.
    """
    windows: list[tuple[float, float]] = []
    reasons: dict[int, str] = {}
    for number, rows in _possible_rows(variants, designs):
        own = designs.isel(design=rows)
        stiffnesses = {
            own[name].attrs["key"]: own[name].to_numpy()
            for name in varied(designs)
            if is_rescaled(own[name].attrs["key"]) and own[name].attrs["units"] in _STIFFNESSES
        }
        window = variants[number].window
        try:
            windows.append(
                window({key: float(stiffness.max()) for key, stiffness in stiffnesses.items()})
            )
            continue
        except IMPOSSIBLE:
            # not of all together, but perhaps of most
            combinations = np.column_stack([*stiffnesses.values(), rows])
        of_values: dict[tuple[float, ...], tuple[float, float] | str] = {}
        for *values, row in combinations.tolist():
            conditions = tuple(values)
            if conditions not in of_values:
                try:
                    of_values[conditions] = window(dict(zip(stiffnesses, conditions, strict=True)))
                except IMPOSSIBLE as error:
                    of_values[conditions] = str(error)
            if isinstance(of_values[conditions], str):
                reasons[int(row)] = of_values[conditions]
        windows += [stiffness for stiffness in of_values.values() if not isinstance(stiffness, str)]
    if not windows:
        first = next(iter(reasons.values()), _first_reason(variants, designs))
        raise ValueError(f"no design is possible: {first}")
    lows, highs = zip(*windows, strict=True)
    return CommonWindow(min(lows), max(highs), reasons)


def common_amplitudes(
    variants: Sequence["SweptJoint | ImpossibleJoint"], designs: xr.Dataset
) -> tuple[float, float]:
    """Amplitudes of backbones [m]: three decades up to the largest peak of any variant.

    Parameters
    ----------
    variants, designs
        As for ``sweeps.solve_designs``.

    Raises
    ------
    ValueError
        If the base case has no peak.
    """
    largest, reason = 0.0, _first_reason(variants, designs)
    for number, rows in _possible_rows(variants, designs):
        variant = variants[number]
        if "force_level" in designs:
            level = float(designs["force_level"][rows].max())
        else:
            level = max(variant.base.levels)
        try:
            largest = max(largest, variant.largest_peak(level))
        except IMPOSSIBLE as error:
            reason = str(error)
    if not largest > 0:
        told = f" ({reason})" if reason else ""
        raise ValueError(f"the base case has no peak{told}: backbones need amplitudes_mm")
    return _SMALLEST_AMPLITUDE * largest, largest


def _possible_rows(
    variants: Sequence["SweptJoint | ImpossibleJoint"], designs: xr.Dataset
) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the variants with a joint, and the rows of their possible designs."""
    possible, of_variant = designs["reason"].to_numpy() == "", designs["variant"].to_numpy()
    for number in np.unique(of_variant[possible]):
        if not isinstance(variants[number], Exception):
            yield number, np.flatnonzero(possible & (of_variant == number))


def _first_reason(variants: Sequence["SweptJoint | ImpossibleJoint"], designs: xr.Dataset) -> str:
    """Why a design is impossible; empty where all are possible."""
    told = [
        *designs["reason"].to_numpy(),
        *(str(variant) for variant in variants if isinstance(variant, Exception)),
    ]
    return next(filter(None, told), "")
