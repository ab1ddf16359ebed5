"""The joint of a case as a function of the parameters that are fitted to its measurement."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import FREQUENCY_RATIO, region_of
from boltjoint.config.varied_case import with_values
from boltjoint.config.varied_keys import path_of, value_at
from boltjoint.damping import Damping
from boltjoint.joint.model import Joint
from boltjoint.joint.rescaled import rescale_contact

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
            return float(self.base.structural_damping.loss_factor)
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
        preload = case.preload_N / self.base.preload_N
        joint = rescale_contact(self.joint, law, before, after, preload)
        elements = _with_regions(joint, of_regions)
        frequency = ratio * joint.natural_frequency
        joint = replace(joint, law=elements, natural_frequency=frequency)
        return joint, case.structural_damping


def _with_regions(joint: Joint, ratios: Mapping[str, float]):  # noqa: ANN202
    """The elements of a joint with other stiffnesses and friction of some regions."""
    elements = joint.law
    changed: dict[str, np.ndarray] = {}
    for key, ratio in ratios.items():
        region, quantity = region_of(key)
        name = quantity if quantity in elements.quantities else _LIMIT
        value = changed.setdefault(name, elements.quantity(name).copy())
        value[elements.point_of_element == region] *= ratio
    return elements.with_quantities(changed) if changed else elements
