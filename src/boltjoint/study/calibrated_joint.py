"""Joint of a case as a function of fitted parameters, and the measured curves beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from boltjoint import checks
from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.calibration.parameters import Parameter, ParameterSpace, Prior
from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import FREQUENCY_RATIO, region_of
from boltjoint.config.measured import Measured, MeasuredCurve, read_backbone_table
from boltjoint.config.varied_case import with_values
from boltjoint.config.varied_keys import path_of, value_at
from boltjoint.damping import Damping, LossFactor
from boltjoint.friction.element_law import ElementLaw
from boltjoint.joint.derived import rescale_contact
from boltjoint.joint.model import Joint
from boltjoint.measurement.signals import UNITS

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
    """

    joint: Joint
    case: Mapping[str, Any]

    @cached_property
    def base(self) -> Case:
        """The case."""
        return Case.model_validate(self.case)

    def value(self, key: str) -> float:
        """The value of a parameter that the case has: 1 of all ratios."""
        if key == "loss_factor":
            return checks.instance("damping", self.base.structural_damping, LossFactor).loss_factor
        try:
            return float(value_at(self.case, path_of(key)))
        except (LookupError, TypeError):
            return 1.0

    def __call__(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        """The joint and the damping of the structure with these values, by their keys."""
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
        joint = rescale_contact(self.joint, law, before, after, preload)
        elements = _with_regions(joint, of_regions)
        frequency = ratio * joint.natural_frequency
        joint = replace(joint, law=elements, natural_frequency=frequency)
        return joint, case.structural_damping


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


def measured_backbones(
    measured: Sequence[MeasuredCurve], texts: Mapping[str, str]
) -> tuple[list[MeasuredBackbone], list[str]]:
    """Curves of a measurement, from the texts of their files, and units of their amplitudes.

    A unit that the file does not tell is empty.
    """
    curves, units = [], []
    for curve in measured:
        table = read_backbone_table(texts[curve.file], curve.file, curve.rows)
        units.append(UNITS.get(table.quantity, "kg^1/2 m") if table.has_unit else "")
        deviations = table.deviations(
            curve.frequency_error_percent or 0.0, curve.damping_error_percent or 0.0
        )
        curves.append(
            MeasuredBackbone(
                table.amplitude,
                table.frequency,
                deviations[0],
                table.damping_ratio,
                deviations[1],
                quantity=table.quantity,
                resonance=curve.resonance,
                sensor=curve.sensor,
                name=curve.label,
            )
        )
    return curves, units
