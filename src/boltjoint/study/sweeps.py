"""Sweeps: peaks and responses of many designs of one joint, and all of them in one dataset.

A design has its place in every file: one that is impossible, or was not solved, has the reason
there.
"""

import logging
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from tqdm import tqdm

from boltjoint import checks
from boltjoint.config.case import Case
from boltjoint.config.varied_keys import rescaled_keys
from boltjoint.dataset import quantity
from boltjoint.dynamics.balance.modal_contact import ModalContact
from boltjoint.dynamics.response.common_grid import amplitude_on_grid
from boltjoint.friction import contact_states
from boltjoint.joint.io import ImpossibleJoint
from boltjoint.joint.model import Joint
from boltjoint.study.common_to_designs import IMPOSSIBLE, common_amplitudes, common_window
from boltjoint.study.designs import values_of, varied
from boltjoint.study.swept_joint import SweptJoint

if TYPE_CHECKING:
    from boltjoint.dynamics.response.branch import Branch

Array = NDArray[np.float64]

logger = logging.getLogger(__name__)


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
    values = values_of(designs.isel(design=slice(chunk.start, chunk.stop)))
    impossible, joint_of = designs["reason"].to_numpy(), designs["variant"].to_numpy()
    joints = [each for each in variants if isinstance(each, SweptJoint)]
    if not joints:
        raise ValueError(f"no design is possible: {next(iter(variants), 'there is none')}")
    window = grid = sizes = None
    reasons: Mapping[int, str] = {}
    if frequencies is not None:
        *window, reasons = common_window(variants, designs)
        grid = np.linspace(*window, frequencies)
    if amplitudes is not None:
        sizes = np.geomspace(*(between or common_amplitudes(variants, designs)), amplitudes)
    levels = 1 if "force_level" in designs else len(joints[0].base.levels)
    elements = max(each.elements for each in joints)
    found = _Observed(len(chunk), levels, grid, sizes, elements if states else None)
    begun = time.monotonic()

    def solve(place: int, row: int) -> None:
        found.reason[place] = impossible[row] or reasons.get(row, "")
        if found.reason[place]:
            return
        variant = variants[joint_of[row]]
        if isinstance(variant, ImpossibleJoint):
            found.reason[place] = str(variant)
            return
        try:
            found.add(place, *variant.solve(values[place], window))
            if sizes is not None:
                found.backbone[place] = np.transpose(variant.backbone(values[place], sizes))
        except IMPOSSIBLE as error:
            found.reason[place] = str(error)

    words = f"designs {chunk.start} to {chunk.stop} of {impossible.size}"
    with ThreadPoolExecutor(threads) as pool:
        solved = pool.map(solve, range(len(chunk)), chunk)
        # on a terminal only
        for _ in tqdm(solved, words, len(chunk), leave=False, disable=None):
            pass
    logger.info("%s in %.0f s", words, time.monotonic() - begun)
    return found.dataset()


def gather_sweep(
    case: Mapping[str, object],
    designs: xr.Dataset,
    chunks: Sequence[xr.Dataset],
    grid: Mapping[str, int],
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

    Returns
    -------
    Dataset
        Its dimensions are the quantities that vary, of a grid, or else ``design``; and ``force``
        where that does not vary. The quantities are coordinates.
    """
    names, base = varied(designs), Case.model_validate(case)
    whole = xr.concat(chunks, "design", combine_attrs="override")
    # the rest is of the first chunk
    told = ("varied", "saltelli_samples")
    whole.attrs = {name: designs.attrs[name] for name in told if name in designs.attrs}
    if "force_level" in names:
        whole = whole.squeeze("force")
    else:
        level = next(each for each in rescaled_keys(base).values() if each.name == "force_level")
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
            np.moveaxis(spread(each).to_numpy(), place, 0).reshape(sizes[place], -1)[:, 0],
            each.attrs,
        )
        for place, (name, each) in enumerate(values.items())
    }
    return xr.Dataset(
        {name: spread(each) for name, each in whole.variables.items()}, axes, whole.attrs
    )


class _Observed:
    """What is kept of the designs of a chunk.

    Peaks only, with neither frequencies ``grid`` [Hz], amplitudes ``sizes`` [m] nor elements.
    """

    def __init__(
        self,
        designs: int,
        levels: int,
        grid: Array | None,
        sizes: Array | None,
        elements: int | None,
    ) -> None:
        self.peak = np.full((designs, levels, 2), np.nan)
        self.complete = np.zeros((designs, levels), dtype=np.int8)
        self.reason = np.full(designs, "", dtype=object)
        self.grid, self.sizes = grid, sizes
        self.backbone = np.full((designs, np.size(sizes), 2), np.nan)
        self.response = np.full((designs, levels, np.size(grid)), np.nan)
        self.state = None
        if elements is not None:
            shape = designs, levels, elements
            self.state = np.full(shape, contact_states.UNKNOWN, dtype=np.int8)

    def add(self, place: int, joint: Joint, branches: Sequence["Branch"]) -> None:
        """Keep what is observed of the responses of a design."""
        for level, branch in enumerate(branches):
            self.complete[place, level] = branch.complete
            if branch.peak is not None:
                at = branch.peak
                self.peak[place, level] = branch.frequency[at], branch.amplitude[at]
                if self.state is not None:
                    motion = ModalContact(joint.contact).motion(branch.modal_coordinate[at])
                    states = joint.law.contact_state(motion, branch.frequency[at])
                    self.state[place, level, : states.size] = states
            if self.grid is not None:
                along = branch.frequency, branch.amplitude
                self.response[place, level] = amplitude_on_grid(*along, self.grid)
        self.reason[place] = next((each.reason for each in branches if each.reason), "")

    def dataset(self) -> xr.Dataset:
        """All of it, by design and force."""
        each = ("design", "force")
        why = "why the design is impossible, or a branch ends before or has no peak"
        rows = {
            "peak_frequency": (each, self.peak[..., 0], "Hz", "frequency of the largest maximum"),
            "peak_amplitude": (each, self.peak[..., 1], "m", "largest maximum of the response"),
            "complete": (each, self.complete, "1", "1 where the branch crosses the whole window"),
            "reason": ("design", self.reason.astype(str), "1", why),
        }
        if self.grid is not None:
            meaning = "first-harmonic amplitude of the output point"
            rows["frequency"] = ("frequency", self.grid, "Hz", "excitation frequency")
            rows["response_amplitude"] = ((*each, "frequency"), self.response, "m", meaning)
        if self.sizes is not None:
            rows["amplitude"] = ("amplitude", self.sizes, "m", "amplitude of the output point")
            of_mode = ("natural_frequency", "Hz"), ("damping_ratio", "1")
            for (name, unit), values in zip(
                of_mode, np.moveaxis(self.backbone, -1, 0), strict=True
            ):
                meaning = f"{name.replace('_', ' ')} of the nonlinear mode"
                rows[name] = (("design", "amplitude"), values, unit, meaning)
        found = {name: quantity(*row) for name, row in rows.items()}
        if self.state is not None:
            dims = (*each, "element")
            found["contact_state"] = xr.Variable(dims, self.state, contact_states.ATTRIBUTES)
        return xr.Dataset(found)
