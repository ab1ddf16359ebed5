"""Sweeps: peaks and responses of many designs of one joint, and all of them in one dataset.

A design has its place in every file: one that is impossible, or was not solved, has the reason
there.
"""

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from tqdm import tqdm

from boltjoint import checks
from boltjoint.config.case import Case
from boltjoint.config.varied_keys import rescaled_keys
from boltjoint.dataset import quantity
from boltjoint.joint.io import ImpossibleJoint
from boltjoint.study.common_to_designs import (
    IMPOSSIBLE,
    ObservedDesigns,
    common_amplitudes,
    common_window,
)
from boltjoint.study.designs import SweptJoint, values_of, varied
from boltjoint.study.errors_of_sweep import errors_of_check
from boltjoint.study.regression_of_peaks import (
    harmonics_of_designs,
    is_predicted,
    with_predicted_peaks,
)

Array = NDArray[np.float64]

#: part of a frequency by which branches reach beyond their grid, more than its rounding
_BESIDE = 1e-9

logger = logging.getLogger(__name__)


def _observe(
    observed: ObservedDesigns,
    place: int,
    variant: SweptJoint | ImpossibleJoint,
    values: Mapping[str, float],
    window: tuple[float, float] | None,
    amplitudes: Array | None,
    *,
    harmonics: int,
    error_bars: bool,
) -> None:
    """Solve a design and add what is observed of it, or why it is impossible."""
    if isinstance(variant, ImpossibleJoint):
        observed.reason[place] = str(variant)
        return
    try:
        joint, branches = variant.solve(values, window)
        observed.add(place, joint, branches)
        observed.add_limits(place, variant.reached(joint, branches))
        if harmonics:
            solved = values, joint, branches
            peaks = variant.converge(*solved, highest=harmonics, error_bars=error_bars)
            observed.add_converged(place, peaks, harmonics)
        if amplitudes is not None:
            observed.backbone[place] = np.transpose(variant.backbone(values, amplitudes))
    except IMPOSSIBLE as error:
        observed.reason[place] = str(error)


def solve_designs(
    variants: Sequence[SweptJoint | ImpossibleJoint],
    designs: xr.Dataset,
    chunk: range,
    threads: int = 1,
    *,
    frequencies: int | None = None,
    amplitudes: int | None = None,
    between: tuple[float, float] | None = None,
    states: bool = False,
    converged: bool = False,
    error_bars: bool = True,
    converged_designs: Mapping[int, int] | None = None,
) -> xr.Dataset:
    """Peaks of some designs of a sweep, and their responses, backbones and contact states.

    Parameters
    ----------
    variants
        The joints with their base cases, by the number of ``variant`` in ``designs``, or why there
        is none.
    designs
        All designs of the sweep (``list_designs``): their responses have one grid of frequencies,
        over a window that suits them all.
    chunk
        Which of them are solved.
    threads
        Designs solved at the same time.
    frequencies
        Number of frequencies of the grid of responses; None where these are not wanted.
    amplitudes
        Number of amplitudes of the grid of backbones; None where these are not wanted.
    between
        Lowest and highest of them [m]; by default three decades up to the largest peak of the base
        case.
    states
        Whether the contact state of each element at the peak is wanted.
    converged
        Whether the peaks with all harmonics are wanted.
    error_bars
        Whether error bars of these are wanted; else their truncation errors are extrapolated.
    converged_designs
        Of how many designs of the sweep, by the highest harmonic, which ascends while they do not;
        of all by default. Those of the others are not a number, and ``is_predicted`` tells which
        (``regression_of_peaks``).

    Returns
    -------
    Dataset
        By ``design`` and ``force``. A design without a peak is not a number there, and ``reason``
        says why.

    Raises
    ------
    ValueError
        If no design is possible, or the base case has no peak up to which backbones go.
    """
    checks.instance("designs", designs, xr.Dataset)
    checks.instance("chunk", chunk, range)
    checks.sequence("variants", variants, SweptJoint, ImpossibleJoint)
    checks.whole("threads", threads, at_least=1)
    for name, points in (("frequencies", frequencies), ("amplitudes", amplitudes)):
        if points is not None:
            checks.whole(name, points, at_least=1)
    if converged_designs is not None:
        checks.instance("converged_designs", converged_designs, Mapping)
        if not (converged and converged_designs):
            raise ValueError("converged_designs must have a number, and converged be true")
        for harmonics, number in converged_designs.items():
            checks.whole(f"converged_designs[{harmonics}]", number, at_least=1)
    highest = converged * harmonics_of_designs(designs, converged_designs)
    values = values_of(designs.isel(design=slice(chunk.start, chunk.stop)))
    impossible, joint_of = designs["reason"].to_numpy(), designs["variant"].to_numpy()
    joints = _possible_joints(variants)
    window = grid = sizes = None
    reasons: Mapping[int, str] = {}
    if frequencies is not None:
        low, high, reasons = common_window(variants, designs)
        window = low * (1 - _BESIDE), high * (1 + _BESIDE)
        grid = np.linspace(low, high, frequencies)
    if amplitudes is not None:
        sizes = np.geomspace(*(between or common_amplitudes(variants, designs)), amplitudes)
    levels = 1 if "force_level" in designs else len(joints[0].base.levels)
    elements = max(joint.elements for joint in joints)
    observed = ObservedDesigns(
        *(len(chunk), levels, grid, sizes, elements if states else None),
        converged=converged,
        error_bars=error_bars,
        harmonics=sorted(converged_designs or ()),
        limits={limit for joint in joints for limit in joint.limits.known},
    )

    def solve(place: int, row: int) -> None:
        observed.reason[place] = impossible[row] or reasons.get(row, "")
        if not observed.reason[place]:
            how = variants[joint_of[row]], values[place], window, sizes
            number = int(highest[row])
            _observe(observed, place, *how, harmonics=number, error_bars=error_bars)

    _solve_each(solve, chunk, threads, impossible.size)
    if converged_designs is None:
        return observed.dataset()
    tried = highest[chunk.start : chunk.stop] > 0
    lost = tried & np.isnan(observed.by_harmonics[:, :, 0, 0]).any(axis=1)
    predicted = is_predicted(designs, highest, chunk)
    # what was not found is not told by others
    return observed.dataset().assign(is_predicted=predicted.copy(data=predicted & ~lost))


def _possible_joints(variants: Sequence[SweptJoint | ImpossibleJoint]) -> list[SweptJoint]:
    """The joints among the variants; a ``ValueError`` if there is none."""
    joints = [variant for variant in variants if isinstance(variant, SweptJoint)]
    if not joints:
        raise ValueError(f"no design is possible: {next(iter(variants), 'there is none')}")
    return joints


def _solve_each(
    solve: Callable[[int, int], None], chunk: range, threads: int, designs: int
) -> None:
    """Solve the designs of a chunk, by their place in it and their row, some at the same time."""
    words = f"designs {chunk.start} to {chunk.stop} of {designs}"
    begun = time.monotonic()
    with ThreadPoolExecutor(threads) as pool:
        solved = pool.map(solve, range(len(chunk)), chunk)
        # on a terminal only
        for _ in tqdm(solved, words, len(chunk), leave=False, disable=None):
            pass
    logger.info("%s in %.0f s", words, time.monotonic() - begun)


def check_designs(
    variants: Sequence[SweptJoint | ImpossibleJoint],
    designs: xr.Dataset,
    number: int,
    seed: int = 0,
    threads: int = 1,
    *,
    error_bars: bool = True,
    converged_designs: Mapping[int, int] | None = None,
) -> xr.Dataset:
    """Peaks of some designs of a sweep in a larger model.

    Parameters
    ----------
    variants
        The joints of the larger model, as for ``solve_designs``.
    designs
        All designs of the sweep (``list_designs``).
    number
        How many are drawn at random of those that the sweep solves with most harmonics; all, if
        there are not more.
    seed
        Seed of the random numbers.
    threads, error_bars, converged_designs
        As for ``solve_designs``.

    Returns
    -------
    Dataset
        ``checked.nc``: by ``checked`` the ``checked_design``, counted from 0, and by ``checked``
        and ``force`` its peaks as ``solve_designs`` gives them, and the largest estimated errors of
        the larger model, as from ``joint.io.model_errors``.

    Raises
    ------
    ValueError
        As for ``solve_designs``.
    """
    checks.instance("designs", designs, xr.Dataset)
    checks.whole("number", number, at_least=1)
    checks.whole("seed", seed, at_least=0)
    highest = harmonics_of_designs(designs, converged_designs)
    solved = np.flatnonzero(highest == highest.max())
    random = np.random.default_rng(seed)
    rows = np.sort(random.choice(solved, min(number, solved.size), replace=False))
    drawn, every = designs.isel(design=rows), range(rows.size)
    peaks = solve_designs(variants, drawn, every, threads, converged=True, error_bars=error_bars)
    row = quantity("checked", rows, "1", "number of the design, from 0")
    of_model = xr.concat([joint.errors for joint in _possible_joints(variants)], "variant")
    # not known of one, not known of all
    errors = of_model.max("variant", skipna=False, keep_attrs=True)
    return peaks.rename(design="checked").assign(checked_design=row).merge(errors)


def gather_sweep(
    case: Mapping[str, Any],
    designs: xr.Dataset,
    chunks: Sequence[xr.Dataset],
    grid: Mapping[str, int],
    check: xr.Dataset | None = None,
) -> xr.Dataset:
    """All designs of a sweep as one dataset: ``sweep.nc``.

    Parameters
    ----------
    case
        Content of the base case.
    designs
        As from ``list_designs``.
    chunks
        As from ``solve_designs``, in order.
    grid
        Number of values of each key in a grid; empty for other designs.
    check
        As from ``check_designs``; None where no design is solved again.

    Returns
    -------
    Dataset
        Its dimensions are the quantities that vary, of a grid, or else ``design``; and ``force``
        where that does not vary. The quantities are coordinates.
    """
    names, base = varied(designs), Case.model_validate(case)
    whole = xr.concat(chunks, "design", combine_attrs="override")
    if "is_predicted" in whole:
        by_keys = [designs[name].to_numpy() for name in names]
        slip_force = whole["joint_slip_force"].to_numpy()
        if "force_level" in names:
            slip_force = slip_force / designs["force_level"].to_numpy()
        whole = with_predicted_peaks(whole, [*by_keys, slip_force])
    if check is not None:
        whole = whole.merge(errors_of_check(whole, check))
    # the rest is of the first chunk
    told = ("varied", "saltelli_samples")
    whole.attrs = {name: designs.attrs[name] for name in told if name in designs.attrs}
    if "force_level" in names:
        whole = whole.squeeze("force")
    else:
        level = next(
            rescaled for rescaled in rescaled_keys(base).values() if rescaled.name == "force_level"
        )
        levels = quantity("force", list(base.levels), level.unit, level.meaning)
        whole = whole.assign_coords(force_level=levels)
    values = {name: designs[name].variable for name in names}
    return _on_grid(whole, values, list(grid.values())) if grid else whole.assign_coords(values)


def _on_grid(whole: xr.Dataset, values: Mapping[str, xr.Variable], sizes: list[int]) -> xr.Dataset:
    """Designs along the quantities that vary, the last of which varies first."""

    def spread(variable: xr.Variable) -> xr.Variable:
        if "design" not in variable.dims:
            return variable
        first = variable.transpose("design", ...)
        shape = *sizes, *first.shape[1:]
        dims = *values, *first.dims[1:]
        return xr.Variable(dims, first.to_numpy().reshape(shape), first.attrs)

    axes = {
        name: xr.Variable(
            name,
            np.moveaxis(spread(axis).to_numpy(), place, 0).reshape(sizes[place], -1)[:, 0],
            axis.attrs,
        )
        for place, (name, axis) in enumerate(values.items())
    }
    return xr.Dataset(
        {name: spread(axis) for name, axis in whole.variables.items()}, axes, whole.attrs
    )
