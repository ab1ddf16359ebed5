"""Joint of a case as a function of fitted parameters, and the measured curves beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks, dataset
from boltjoint.calibration.bolt_preloads import LEVELS, BoltPreloads, bolt_of
from boltjoint.calibration.measured_backbone import MeasuredBackbone, Measurement
from boltjoint.calibration.measured_response import MeasuredResponse
from boltjoint.calibration.parameters import Parameter, ParameterSpace, Prior
from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import FREQUENCY_RATIO, region_of, table_of
from boltjoint.config.measured import (
    Measured,
    MeasuredCurve,
    MeasuredSteppedSine,
    MeasuredTable,
)
from boltjoint.config.measured_tables import BackboneTable, ResponseTable
from boltjoint.config.varied_case import with_values
from boltjoint.config.varied_keys import path_of, value_at
from boltjoint.damping import Damping, LossFactor
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.derived import rescale_contact, with_elements
from boltjoint.joint.model import Joint
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.measurement.signals import UNITS
from boltjoint.structure.excitation import place_excitation
from boltjoint.structure.structure_file import load_structure

Array = NDArray[np.float64]

#: the quantity of elements by which a friction coefficient acts, where they have none
_LIMIT = "slip_force"


@dataclass(frozen=True)
class CalibratedJoint:
    """A joint of a case with other values of its parameters.

    Parameters
    ----------
    joint
        As the case has it.
    case
        Content of the case, as ``config.conflicts_of_measured.calibrated_content`` has it.
    bolts
        Its node-to-node joint by the preload of each bolt, where these are parameters too.
    """

    joint: Joint
    case: Mapping[str, Any]
    bolts: BoltPreloads | None = None

    @cached_property
    def base(self) -> Case:
        """The case."""
        return Case.model_validate(self.case)

    def value(self, key: str) -> float:
        """The value of a parameter that the case has: 1 of all ratios."""
        if (bolt := bolt_of(key)) is not None:
            return float(self.state[bolt])
        if key == "loss_factor":
            return checks.instance("damping", self.base.structural_damping, LossFactor).loss_factor
        try:
            return float(value_at(self.case, path_of(key)))
        except (LookupError, TypeError):
            return 1.0

    @property
    def state(self) -> Array:
        """Preload of each bolt over that of the case, beside which others vary, (bolts,)."""
        return self._bolts.state

    def state_with(self, values: Mapping[str, float]) -> Array:
        """The state with preloads of bolts among values by their keys."""
        state = self.state.copy()
        for key, value in values.items():
            if (bolt := bolt_of(key)) is not None:
                state[bolt] = value
        return state

    def at_state(self, state: Sequence[float] | Array) -> "CalibratedJoint":
        """The same joint around another state of its bolts."""
        return replace(self, bolts=self._bolts.at_state(state))

    @property
    def _bolts(self) -> BoltPreloads:
        return checks.instance("bolts of the joint", self.bolts, BoltPreloads)

    def __call__(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        """The joint and the damping of the structure with these values, by their keys."""
        of_bolts = {key: value for key, value in values.items() if bolt_of(key) is not None}
        values = {key: value for key, value in values.items() if key not in of_bolts}
        tightened = self.joint if self.bolts is None else self.bolts(of_bolts)[0]
        of_regions = {key: value for key, value in values.items() if region_of(key) is not None}
        ratio = values.get(FREQUENCY_RATIO, 1.0)
        own = {
            key: value
            for key, value in values.items()
            if key not in of_regions and key != FREQUENCY_RATIO
        }
        case = Case.model_validate(with_values(self.case, own))
        before, after = dict(self.base.contact.options), dict(case.contact.options)
        law, _ = before.pop("law"), after.pop("law")
        preload = case.nominal_preload / self.base.nominal_preload
        joint = rescale_contact(tightened, law, before, after, preload)
        elements = _with_regions(joint, of_regions)
        frequency = ratio * joint.natural_frequency
        return with_elements(joint, elements, frequency), case.structural_damping


def _with_regions(joint: Joint, ratios: Mapping[str, float]) -> ElementLaw:
    """The elements of a joint with other stiffnesses and friction of some regions."""
    elements = joint.contact.element_law
    changed: dict[str, np.ndarray] = {}
    for key, ratio in ratios.items():
        named = region_of(key)
        if named is None:
            raise ValueError(f"{key} is no parameter of a region")
        region, quantity = named
        name = quantity if quantity in elements.quantities else _LIMIT
        value = changed.setdefault(name, elements.quantity(name).copy())
        value[elements.point_of_element == region] *= ratio
    return elements.with_quantities(changed) if changed else elements


def fitted_parameters(model: CalibratedJoint, measured: Measured) -> ParameterSpace:
    """What is fitted of a joint: bounds, starts and priors."""
    return ParameterSpace(
        tuple(
            Parameter(
                *(key, bounds.low, bounds.high, bounds.log),
                _start(model, key, bounds.start, measured),
                Prior(known.mean, known.standard_deviation) if (known := bounds.prior) else None,
            )
            for key, bounds in measured.parameters.items()
        )
    )


def _start(
    model: CalibratedJoint, key: str, start: float | None, measured: Measured
) -> float | None:
    """Where the first fit begins: as given, or at the value of the case within the bounds."""
    if start is not None:
        return start
    parameter, own = measured.parameters[key], model.value(key)
    return own if parameter.low <= own <= parameter.high else None


def bolts_of_case(
    files: Sequence[str],
    case: Mapping[str, Any],
    excited: tuple[Any, Sequence[Any]] | None,
    ratios: tuple[float, float] | None,
) -> BoltPreloads | None:
    """The node-to-node joint of a case by the preload of each bolt over ``preload_N``.

    Parameters
    ----------
    files
        ``structure``, ``assembly.nc`` and ``modes.nc``; none where no preload is fitted.
    case
        As of ``CalibratedJoint``.
    excited
        Excitation and sensors, as of ``structure.excitation.place_excitation``.
    ratios
        Lowest and highest preload of a bolt over that of the case, fitted or of a configuration.

    Returns
    -------
    BoltPreloads
        Around the preloads of the case; None without files.
    """
    if not files or excited is None or ratios is None:
        return None
    own = Case.model_validate(case)
    structure = load_structure(files[0])
    assembly, modes = (dataset.load(file) for file in files[1:])
    placed = place_excitation(assembly, modes, *excited)
    low, high = ratios
    levels = sorted({low, high, *(level for level in LEVELS if low < level < high)})

    def connect(preload: xr.Dataset) -> Joint:
        return connect_pairs(placed, preload, **own.contact.options)

    preload = own.nominal_preload
    state = own.preload_ratios
    return BoltPreloads(structure, preload, connect, own.structural_damping, levels, state)


def measured_curves(
    measured: Sequence[tuple[Any, MeasuredTable]], texts: Mapping[str, str]
) -> tuple[list[Measurement], list[str]]:
    """Curves of a measurement, from the texts of their files, and units of their amplitudes.

    Parameters
    ----------
    measured
        Places and entries, as ``Measured.fitted_curves``.
    texts
        By the names of their files.

    Returns
    -------
    curves : list
        Backbones, then responses.
    units : list of str
        Empty where a file does not tell it.
    """
    curves: list[Measurement] = []
    units = []
    for _, curve in measured:
        table = table_of(curve, texts[curve.file])
        if isinstance(table, BackboneTable):
            curves.append(_backbone(checks.instance("curve", curve, MeasuredCurve), table))
        else:
            curves.append(_response(checks.instance("curve", curve, MeasuredSteppedSine), table))
        units.append(UNITS.get(table.quantity, "kg^1/2 m") if table.has_unit else "")
    return curves, units


def _backbone(curve: MeasuredCurve, table: BackboneTable) -> MeasuredBackbone:
    of_frequency, of_damping = table.deviations(
        curve.frequency_error_percent or 0.0, curve.damping_error_percent or 0.0
    )
    return MeasuredBackbone(
        table.amplitude,
        table.frequency,
        of_frequency,
        table.damping_ratio,
        of_damping,
        quantity=table.quantity,
        resonance=curve.resonance,
        sensor=curve.sensor,
        name=curve.label,
        shape=curve.shape,
        configuration=curve.configuration or {},
    )


def _response(curve: MeasuredSteppedSine, table: ResponseTable) -> MeasuredResponse:
    phase = None if curve.phase_error_deg is None else table.phase
    return MeasuredResponse(
        table.frequency,
        table.amplitude,
        table.level,
        curve.excitation_error_percent / 100 * table.level,
        phase,
        None if phase is None else np.deg2rad(curve.phase_error_deg or 0.0),
        quantity=table.quantity,
        sensor=curve.sensor,
        configuration=curve.configuration or {},
        name=curve.name,
    )
