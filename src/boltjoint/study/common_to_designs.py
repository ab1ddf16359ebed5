"""Windows and grids that designs of a sweep have in common, and what is observed of each."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator

from boltjoint import checks
from boltjoint.config.varied_keys import is_rescaled
from boltjoint.dataset import Quantity, quantities
from boltjoint.dynamics.balance.modal_contact import ModalContact
from boltjoint.dynamics.response.error_bars import ConvergedPeak
from boltjoint.dynamics.response.harmonic_convergence import HarmonicPeak, PeakSequence
from boltjoint.friction import contact_states
from boltjoint.joint.model import Joint
from boltjoint.structure.model_limits import LIMITS, Limit
from boltjoint.study.designs import varied

if TYPE_CHECKING:
    from boltjoint.dynamics.response.branch import Branch
    from boltjoint.joint.io import ImpossibleJoint
    from boltjoint.study.designs import SweptJoint


Array = NDArray[np.float64]


#: straight pieces between two solutions of a path: with as many the error of the interpolation
#: between solutions is larger than that of the pieces
_PIECES = 8


def amplitude_on_grid(frequency: Array, amplitude: Array, grid: Array) -> Array:
    """Amplitude of a response at given frequencies; where it folds, the largest of its solutions.

    Between two solutions of the path, frequency and amplitude are interpolated along it (Akima),
    which has no overshoot where the contact changes its state.

    Parameters
    ----------
    frequency, amplitude
        Frequencies and amplitudes of the solutions along the path, of any units, shape
        (solutions,).
    grid
        Ascending frequencies, shape (frequencies,).

    Returns
    -------
    ndarray
        Shape (frequencies,); not a number where the path does not reach.

    Raises
    ------
    ValueError
        If the shapes differ, or the grid does not ascend.
    """
    frequency = checks.array("frequency", frequency, ("solutions",))
    amplitude = checks.array("amplitude", amplitude, frequency.shape)
    grid = checks.array("grid", grid, ("frequencies",))
    if np.any(np.diff(grid) <= 0):
        raise ValueError("grid must ascend")
    largest = np.full(grid.size, np.nan)
    path = np.column_stack([frequency, amplitude])
    path = path[np.insert(np.any(np.diff(path, axis=0) != 0, axis=1), 0, True)]
    if len(path) < 2:
        return largest
    if len(path) > 2:
        path = _refined(path)
    (left, below), (right, above) = path[:-1].T, path[1:].T
    first, last = (
        np.searchsorted(grid, np.minimum(left, right), "left"),
        np.searchsorted(grid, np.maximum(left, right), "right"),
    )
    # each piece of the path with each frequency that it passes
    count = last - first
    piece = np.repeat(np.arange(count.size), count)
    at = np.arange(piece.size) - np.repeat(np.cumsum(count) - count, count) + first[piece]
    run = (right - left)[piece]
    share = np.divide(grid[at] - left[piece], run, out=np.ones(run.size), where=run != 0)
    np.fmax.at(largest, at, below[piece] + share * (above - below)[piece])
    return largest


def _refined(path: Array) -> Array:
    """More points on a path, shape (points, 2), by its arc length with both columns scaled."""
    steps = np.diff(path, axis=0) / np.ptp(path, axis=0).clip(np.finfo(float).tiny)
    arc = np.insert(np.hypot(*steps.T).cumsum(), 0, 0.0)
    between = np.linspace(arc[:-1], arc[1:], _PIECES, endpoint=False).T.ravel()
    return Akima1DInterpolator(arc, path)(np.append(between, arc[-1]))


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
        As for ``solved_designs.solve_designs``.

    Raises
    ------
    ValueError
        If no design has a window.
    """
    windows: list[tuple[float, float]] = []
    reasons: dict[int, str] = {}
    for variant, rows in _possible_rows(variants, designs):
        own = designs.isel(design=rows)
        stiffnesses = {
            own[name].attrs["key"]: own[name].to_numpy()
            for name in varied(designs)
            if is_rescaled(own[name].attrs["key"]) and own[name].attrs["units"] in _STIFFNESSES
        }
        window = variant.window
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
            outcome = of_values[conditions]
            if isinstance(outcome, str):
                reasons[int(row)] = outcome
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
        As for ``solved_designs.solve_designs``.

    Raises
    ------
    ValueError
        If the base case has no peak.
    """
    largest, reason = 0.0, _first_reason(variants, designs)
    for variant, rows in _possible_rows(variants, designs):
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
) -> Iterator[tuple["SweptJoint", np.ndarray]]:
    """The variants with a joint, and the rows of their possible designs."""
    possible, of_variant = designs["reason"].to_numpy() == "", designs["variant"].to_numpy()
    for number in np.unique(of_variant[possible]):
        variant = variants[number]
        if not isinstance(variant, Exception):
            yield variant, np.flatnonzero(possible & (of_variant == number))


def _first_reason(variants: Sequence["SweptJoint | ImpossibleJoint"], designs: xr.Dataset) -> str:
    """Why a design is impossible; empty where all are possible."""
    told = [
        *designs["reason"].to_numpy(),
        *(str(variant) for variant in variants if isinstance(variant, Exception)),
    ]
    return next(filter(None, told), "")


#: of the peaks with all harmonics
_CONVERGED = (
    ("peak_frequency_converged", "Hz", "peak with as many harmonics as change nothing"),
    ("peak_amplitude_converged", "m", "its amplitude with as many harmonics as change nothing"),
    ("peak_harmonics", "1", "highest of these harmonics"),
    ("peak_frequency_truncation_error", "1", "of the converged peak"),
    ("peak_amplitude_truncation_error", "1", "of its amplitude"),
)
#: and where they have error bars
_BARS = (
    ("peak_frequency_inertia_error", "1", "of the converged peak, by inertia of its basis"),
    ("peak_amplitude_inertia_error", "1", "of its amplitude, by inertia of its basis"),
)


def _with_harmonics(sequence: PeakSequence, number: int) -> HarmonicPeak | None:
    """The peak with a number of harmonics, or with those that were enough before; None without."""
    found = [peak for peak in sequence.peaks if peak.harmonics <= number]
    if not found or not (found[-1].harmonics == number or sequence.converged):
        return None
    return found[-1]


_COMPLETE = "1 where the branch ends with its window, or behind its peak"
_SLIP_FORCE = "slip force of all elements as assembled"


class ObservedDesigns:
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
        *,
        converged: bool = False,
        error_bars: bool = True,
        harmonics: Sequence[int] = (),
        limits: Collection[Limit] = (),
    ) -> None:
        self.peak = np.full((designs, levels, 2), np.nan)
        self.complete = np.zeros((designs, levels), dtype=np.int8)
        self.reason = np.full(designs, "", dtype=object)
        self.slip_force = np.full(designs, np.nan)
        self.grid, self.sizes = grid, sizes
        self.backbone = np.full((designs, 1 if sizes is None else sizes.size, 2), np.nan)
        self.response = np.full((designs, levels, 1 if grid is None else grid.size), np.nan)
        self._of_peaks = _CONVERGED + _BARS * error_bars
        shape = designs, levels, len(self._of_peaks)
        self.converged = np.full(shape, np.nan) if converged else None
        self.harmonics = list(harmonics)
        self.by_harmonics = np.full((designs, levels, len(self.harmonics), 2), np.nan)
        self.known = limits
        self.reached = np.full((designs, levels, len(LIMITS)), np.nan)
        self.state: NDArray[np.int8] | None = None
        if elements is not None:
            shape = designs, levels, elements
            self.state = np.full(shape, contact_states.UNKNOWN, dtype=np.int8)

    def add(self, place: int, joint: Joint, branches: Sequence["Branch"]) -> None:
        """Keep what is observed of the responses of a design."""
        self.slip_force[place] = joint.law.slip_force.sum()
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
                self.response[place, level] = amplitude_on_grid(
                    branch.frequency, branch.amplitude, self.grid
                )
        self.reason[place] = next((branch.reason for branch in branches if branch.reason), "")

    def add_converged(self, place: int, peaks: Sequence[ConvergedPeak], highest: int) -> None:
        """Keep the peaks of a design, solved with harmonics up to the highest."""
        if self.converged is None:
            raise ValueError("the peaks with all harmonics are not observed")
        for level, peak in enumerate(peaks):
            if not self.harmonics or highest == self.harmonics[-1]:
                values = *peak.values, *peak.truncation_error, *peak.inertia_error
                self.converged[place, level] = values[: len(self._of_peaks)]
            for column, number in enumerate(self.harmonics):
                if number <= highest and (at := _with_harmonics(peak.sequence, number)):
                    self.by_harmonics[place, level, column] = at.frequency, at.amplitude

    def add_limits(self, place: int, shares: Array) -> None:
        """Keep how much of each of ``LIMITS`` the peaks of a design reach, (levels, limits)."""
        self.reached[place] = shares

    def dataset(self) -> xr.Dataset:
        """All of it, by design and force."""
        along = "design", "force"
        why = "why the design is impossible, or a branch ends before or has no peak"
        rows: list[Quantity] = [
            ("peak_frequency", along, self.peak[..., 0], "Hz", "frequency of the largest maximum"),
            ("peak_amplitude", along, self.peak[..., 1], "m", "largest maximum of the response"),
            ("complete", along, self.complete, "1", _COMPLETE),
            ("reason", "design", self.reason.astype(str), "1", why),
            ("joint_slip_force", "design", self.slip_force, "N", _SLIP_FORCE),
        ]
        scale = np.ones(self.complete.shape)
        if self.converged is not None:
            # the amplitude with all harmonics counts, where it is known
            ratio = self.converged[..., 1] / self.peak[..., 1]
            scale = np.where(np.isfinite(ratio), ratio, 1.0)
            for place, (name, unit, meaning) in enumerate(self._of_peaks):
                rows.append((name, along, self.converged[..., place], unit, meaning))
        if self.harmonics:
            meaning = "highest harmonic of peaks from which those of other designs follow"
            rows.append(("harmonics", "harmonics", self.harmonics, "1", meaning))
            for column, (what, unit) in enumerate((("frequency", "Hz"), ("amplitude", "m"))):
                row = (*along, "harmonics"), self.by_harmonics[..., column], unit
                rows.append((f"harmonic_peak_{what}", *row, "with so many harmonics"))
        for limit, reached in zip(LIMITS, np.moveaxis(self.reached, -1, 0), strict=True):
            if limit in self.known:
                rows.append((f"peak_{limit.name}", along, scale * reached, "1", limit.meaning))
        if self.grid is not None:
            meaning = "first-harmonic amplitude of the output point"
            rows.append(("frequency", "frequency", self.grid, "Hz", "excitation frequency"))
            rows.append(("response_amplitude", (*along, "frequency"), self.response, "m", meaning))
        if self.sizes is not None:
            rows.append(
                ("amplitude", "amplitude", self.sizes, "m", "amplitude of the output point")
            )
            of_mode = ("natural_frequency", "Hz"), ("damping_ratio", "1")
            for (name, unit), values in zip(
                of_mode, np.moveaxis(self.backbone, -1, 0), strict=True
            ):
                meaning = f"{name.replace('_', ' ')} of the nonlinear mode"
                rows.append((name, ("design", "amplitude"), values, unit, meaning))
        variables = quantities(rows)
        if self.state is not None:
            dims = (*along, "element")
            variables["contact_state"] = xr.Variable(dims, self.state, contact_states.ATTRIBUTES)
        return xr.Dataset(variables)
