"""Designs of a sweep: values of the keys that vary, and the joint of each and how it is solved."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.case import Case
from boltjoint.config.csv_table import read_file
from boltjoint.config.distributions import DISTRIBUTIONS, Values
from boltjoint.config.entries import Entry
from boltjoint.config.sampling import Design, Grid, Saltelli, Samples, design_columns
from boltjoint.config.varied_case import read_table, refused, with_values
from boltjoint.config.varied_keys import Quantity, is_rescaled, rescaled_keys
from boltjoint.dataset import quantity
from boltjoint.dynamics.backbone.backbone_at import backbone_at
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.converged_peaks import find_converged_peak
from boltjoint.dynamics.response.error_bars import ConvergedPeak
from boltjoint.dynamics.response.frequency_response import as_method
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.dynamics.response.left_out_harmonics import LeftOutHarmonics
from boltjoint.dynamics.response.limits_at_peaks import KnownLimits
from boltjoint.dynamics.response.methods import LinearModes, Problem
from boltjoint.dynamics.response.windows import Resonance, WindowMargins, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.harmonics import Components
from boltjoint.joint.derived import rescale_contact
from boltjoint.joint.io import joint_from_dataset, model_errors
from boltjoint.joint.model import Joint
from boltjoint.options import CONVERGING
from boltjoint.solvers.step_control import StepControl
from boltjoint.structure.model_limits import LIMITS

if TYPE_CHECKING:
    from boltjoint.dynamics.response.branch import Branch


Value = TypeVar("Value")

#: steps of a branch of which only the peak is kept, over those of one that is drawn: the peak is
#: located between solutions, and the same
_STEPS_TO_PEAK = 8.0
#: window of such a branch: no peak of a lightly damped joint leaves the range of its resonance
_AROUND_PEAK = WindowMargins(below=0.99, above=1.02)

_ONE_JOINT: tuple[Mapping[str, Any], ...] = ({"values": {}, "reason": ""},)


def list_designs(
    vary: Mapping[str, Values],
    design: Design,
    case: Mapping[str, Any],
    variants: Sequence[Mapping[str, Any]] = _ONE_JOINT,
    quantities: Mapping[str, Quantity] | None = None,
    table: str | Path | None = None,
) -> xr.Dataset:
    """The designs of a sweep.

    Parameters
    ----------
    vary, design
        Values of the keys that vary, and which of their combinations are designs.
    case
        Content of the base case.
    variants
        ``values`` of the keys that need another joint, and ``reason`` why they are impossible,
        empty where they are not; by default none needs one.
    quantities
        What the keys that may vary are called; by default those that need no other joint.
    table
        File of the designs, with ``kind: table``.

    Returns
    -------
    Dataset
        By ``design`` the value of each key, under the name of the quantity and with the key as an
        attribute, the number of its ``variant``, and ``reason``, why the design is impossible,
        empty where it is not. Its attributes are ``varied``, the names in their order, and of
        ``kind: saltelli`` ``saltelli_samples``, the designs of each sample.

    Raises
    ------
    ValueError
        If an argument is of another kind, or a key may not vary.
    """
    checks.mapping("case", case)
    _check_variants(variants)
    if quantities is None:
        quantities = rescaled_keys(Case.model_validate(case))
    checks.mapping("quantities", quantities)
    if table is None:
        checks.mapping("vary", vary, quantities)
        for key, values in vary.items():
            if isinstance(values, Entry):
                checks.instance(f"vary[{key!r}]", values, *DISTRIBUTIONS.values())
            else:
                checks.array(f"vary[{key!r}]", values, ("values",))
        checks.instance("design", design, Grid, Samples, Saltelli)
        columns = design_columns(vary, design)
    else:
        columns = read_table(read_file(table), str(table), quantities)
    columns_of_designs = {}
    for key, column in columns.items():
        name, unit, meaning, factor = quantities[key]
        columns_of_designs[name] = quantity("design", factor * column, unit, meaning)
        columns_of_designs[name].attrs["key"] = key
    entries = zip(*(column.tolist() for column in columns.values()), strict=True)
    rows = [dict(zip(columns, row, strict=True)) for row in entries]
    by_values = {tuple(one["values"].values()): one["reason"] for one in variants}
    possible = (values for values, reason in by_values.items() if not reason)
    numbers = {values: n for n, values in enumerate(possible)}
    own = [tuple(row[key] for key in variants[0]["values"]) for row in rows]
    reasons = [
        by_values[values] or "; ".join(refused(with_values(case, _rescaled(row)), Case))
        for values, row in zip(own, rows, strict=True)
    ]
    columns_of_designs["reason"] = quantity("design", reasons, "1", "why the design is impossible")
    number = [numbers.get(values, -1) for values in own]
    meaning = "number of the joint that is rescaled, or -1 where there is none"
    columns_of_designs["variant"] = quantity("design", number, "1", meaning)
    attributes: dict[str, Any] = {"varied": " ".join(quantities[key].name for key in columns)}
    if isinstance(design, Saltelli):
        attributes["saltelli_samples"] = design.number
    return xr.Dataset(columns_of_designs, attrs=attributes)


def _check_variants(variants: Sequence[Mapping[str, Any]]) -> None:
    checks.sequence("variants", variants, Mapping)
    if not variants:
        raise ValueError("variants is empty: there is one of the base case at least")
    for i, variant in enumerate(variants):
        checks.instance(f"values of variants[{i}]", variant.get("values"), Mapping)
        checks.mapping(f"values of variants[{i}]", variant["values"])
        checks.instance(f"reason of variants[{i}]", variant.get("reason"), str)


def values_of(designs: xr.Dataset) -> list[dict[str, float]]:
    """The values of those keys of each design for which its joint is rescaled."""
    columns = {}
    for name in varied(designs):
        values = checks.variable("designs", designs, name, ("design",))
        key = checks.instance(f"key of {name}", designs[name].attrs.get("key"), str)
        columns[key] = values
    columns = _rescaled(columns)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows] or [{}] * designs.sizes["design"]


def varied(dataset: xr.Dataset) -> list[str]:
    """The names of the quantities that vary, in a list of designs or in a sweep.

    Raises
    ------
    ValueError
        If it does not tell them, or has one that is no quantity of its designs with units.
    """
    places = places_of(dataset)
    names = checks.instance("attribute varied of the designs", dataset.attrs.get("varied"), str)
    for name in names.split():
        dims = tuple(map(str, dataset[name].dims)) if name in dataset else ()
        checks.variable("designs", dataset, name, dims)
        if not set(dims) <= set(places):
            raise ValueError(f"{name} is over {', '.join(map(str, dims))}, but designs are not")
        checks.instance(f"units of {name}", dataset[name].attrs.get("units"), str)
    return names.split()


def places_of(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dimensions of the designs, in a list of designs or in a sweep.

    Raises
    ------
    ValueError
        If it has no designs.
    """
    checks.instance("designs", dataset, xr.Dataset)
    if "reason" not in dataset:
        raise ValueError("designs has no variable 'reason'")
    return tuple(map(str, dataset["reason"].dims))


def _rescaled(of_keys: Mapping[str, Value]) -> dict[str, Value]:
    return {key: value for key, value in of_keys.items() if is_rescaled(key)}


Array = NDArray[np.float64]


def _problem(
    case: Case, joint: Joint, window: tuple[float, float], control: StepControl
) -> Problem:
    """The resonance of a case, of a joint that is excited there."""
    resonance = Resonance(case.solve[0].resonance, window)
    problem = Problem.of(joint, case.structural_damping, resonance, control)
    joint.check_excitation(problem.resonance)
    return problem


def _to_peak(control: StepControl) -> StepControl:
    """Longer steps, with which a peak is located more narrowly: designs are what cases are."""
    longer = control.with_shorter_steps(1 / _STEPS_TO_PEAK)
    return replace(longer, peak_tolerance=control.peak_tolerance / _STEPS_TO_PEAK**2)


def _peak(
    method: LinearModes, near: Problem, whole: Callable[[], Problem], level: float
) -> "Branch":
    """A response of which the peak is kept: up to behind it, or across a narrow or whole window."""
    branch = method.to_peak(near, level)
    if branch is None:
        branch = method.solve(near, level)
    return branch if branch.complete and branch.peak is not None else method.solve(whole(), level)


def _motion_at(branch: "Branch", place: int, joint: Joint) -> PeriodicMotion:
    """The motion of a solution of a branch."""
    components = Components(joint.law.components)
    return PeriodicMotion(components, components.rows(branch.modal_coordinate[place]))


@dataclass(frozen=True)
class SweptJoint:
    """The joint of a sweep, as each design has it.

    Parameters
    ----------
    case
        Content of the base case, with the resonance, joint and coordinates that are solved.
    joints
        Joints of the base case: node to node, then those that it was reduced to; the last one is
        solved, in a frequency window that suits all.
    sampling
        Harmonics and time samples of AFT, None for analytic forces.
    control
        Tolerance and step lengths; the defaults if None.
    harmonics
        Numbers of harmonics and tolerances of converged peaks.
    limits
        Limits of the model that the joint knows.
    errors
        What is estimated of the errors of its model, as from ``joint.io.model_errors``; nothing by
        default.
    """

    case: Mapping[str, Any]
    joints: Sequence[Joint]
    sampling: Mapping[str, int] | None = None
    control: StepControl | None = None
    harmonics: HarmonicConvergence = HarmonicConvergence()
    limits: KnownLimits = KnownLimits()
    errors: xr.Dataset = field(default_factory=lambda: model_errors(xr.Dataset()))

    @classmethod
    def of_datasets(
        cls,
        case: Mapping[str, Any],
        joints: Sequence[xr.Dataset],
        sampling: Mapping[str, int] | None,
        control: StepControl,
        harmonics: HarmonicConvergence,
    ) -> Self:
        """The joint of a sweep by its ``joint.nc``, node to node first, as for the class.

        Raises
        ------
        ImpossibleJoint
            If one of them is impossible.
        """
        loaded = [joint_from_dataset(joint) for joint in joints]
        # of the node-to-node joint: all of them have its modes
        limits, errors = KnownLimits.of(joints[0]), model_errors(joints[-1])
        return cls(case, loaded, sampling, control, harmonics, limits, errors)

    @cached_property
    def base(self) -> Case:
        """The base case."""
        return Case.model_validate(self.case)

    @property
    def elements(self) -> int:
        """Number of elements of the joint that is solved."""
        return self.joints[-1].law.point_of_element.size

    def window(self, values: Mapping[str, float]) -> tuple[float, float]:
        """Frequency window of the design with these values of its keys [Hz]."""
        return self._window(self.rescaled(values)[1], WindowMargins())

    def rescaled(self, values: Mapping[str, float]) -> tuple[Case, list[Joint]]:
        """The case of the design with these values of its keys, and all joints with its contact."""
        case = self._case(values)
        before, after = dict(self.base.contact.options), dict(case.contact.options)
        law, _ = before.pop("law"), after.pop("law")
        ratio = case.nominal_preload / self.base.nominal_preload
        return case, [rescale_contact(joint, law, before, after, ratio) for joint in self.joints]

    def solve(
        self, values: Mapping[str, float], window: tuple[float, float] | None = None
    ) -> tuple[Joint, list["Branch"]]:
        """The joint of a design, and its response at each level.

        Parameters
        ----------
        values
            Values of the keys that vary.
        window
            Frequencies [Hz] of responses that are kept. By default only their peaks are: they may
            end behind these, and have longer steps where such lead there.
        """
        case, joints = self.rescaled(values)
        joint, control = self._solved(joints), self.control or StepControl()
        method = as_method(str(case.coordinates[0]))

        def whole() -> Problem:
            return _problem(case, joint, window or self._window(joints, WindowMargins()), control)

        if window is None and isinstance(method, LinearModes):
            near = _problem(case, joint, self._window(joints, _AROUND_PEAK), _to_peak(control))
            return joint, [_peak(method, near, whole, level) for level in case.levels]
        problem = whole()
        method = method.prepared(problem, case.levels)
        return joint, [method.solve(problem, level) for level in case.levels]

    def converge(
        self,
        values: Mapping[str, float],
        joint: Joint,
        branches: Sequence["Branch"],
        *,
        highest: int = CONVERGING[-1],
        error_bars: bool = True,
    ) -> list[ConvergedPeak]:
        """The peaks of a design with harmonics up to the highest, from its responses.

        Without error bars motions at one phase stand for those with most harmonics
        (``converge_peak``), and truncation errors are extrapolated.
        """
        options = self.harmonics.up_to(highest)
        damping = self._case(values).structural_damping
        left_out = LeftOutHarmonics() if error_bars else None
        peaks = []
        for branch in branches:
            if branch.peak is None:
                peaks.append(ConvergedPeak())
                continue
            at = float(branch.frequency[branch.peak]), _motion_at(branch, branch.peak, joint)
            solved = joint, *at, branch.force, damping, options, left_out
            peak = find_converged_peak(*solved, at_one_phase=not error_bars)
            peaks.append(peak if error_bars else peak.extrapolated)
        return peaks

    def reached(self, joint: Joint, branches: Sequence["Branch"]) -> Array:
        """Share of each of ``LIMITS`` that is reached at the peaks of a design, (levels, limits).

        Not a number without a peak, and of limits that are not known.
        """
        shares = np.full((len(branches), len(LIMITS)), np.nan)
        for own, branch in zip(shares, branches, strict=True):
            if branch.peak is not None:
                own[:] = self.limits.reached(_motion_at(branch, branch.peak, joint))
        return shares

    def backbone(self, values: Mapping[str, float], amplitudes: Array) -> tuple[Array, Array]:
        """Natural frequency [Hz] and damping ratio of a design at amplitudes [m]."""
        case, joints = self.rescaled(values)
        return backbone_at(
            self._solved(joints),
            amplitudes,
            resonance=case.solve[0].resonance,
            damping=case.structural_damping,
            control=self.control,
        )

    def largest_peak(self, level: float) -> float:
        """Amplitude of the peak of the base case under a level [m]; 0 without one."""
        key = "accelerations_m_per_s2" if self.base.is_base_excited else "forces_N"
        _, (branch,) = self.solve({key: level})
        return 0.0 if branch.peak is None else float(branch.amplitude[branch.peak])

    def _solved(self, joints: Sequence[Joint]) -> Joint:
        """That of all joints which is solved."""
        if self.sampling is None:
            return joints[-1]
        law = AlternatingFrequencyTime(joints[-1].contact.element_law, **self.sampling)
        return replace(joints[-1], law=law)

    def _case(self, values: Mapping[str, float]) -> Case:
        return Case.model_validate(with_values(self.case, values))

    def _window(self, joints: Sequence[Joint], margins: WindowMargins) -> tuple[float, float]:
        block = self.base.solve[0]
        given = block.window_Hz
        return frequency_window(*joints, resonance=block.resonance, given=given, margins=margins)
