"""A friction law that tests add: glue, springs that never slip, each with a dashpot beside it."""

_CLASS = '''"""Glue: springs that never slip, each with a dashpot beside it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from boltjoint.friction.dashpot_forms import Dashpots
from boltjoint.friction.element_law import ElementLaw, check_elements
from boltjoint.friction.sliders_at_samples import Sliders
{declaration}


@dataclass(frozen=True)
class Glue(ElementLaw):
    """Springs with dashpots, any number of them on each contact point."""

    point_of_element: np.ndarray
    tangential_stiffness: np.ndarray
    viscosity: np.ndarray

    declaration = DECLARATION
    quantities = {
        "tangential_stiffness": ("N/m", "stiffness"), "viscosity": ("N s/m", "viscosity"),
    }
    closed_form = None

    def __post_init__(self):
        check_elements(self)

    @property
    def slip_force(self):
        return 1e6 * np.ones_like(self.viscosity)

    @classmethod
    def from_contact(cls, pairs, *, tangential_stiffness, viscosity):
        every = np.arange(pairs.normal_load.size)
        keys = {"tangential_stiffness": tangential_stiffness, "viscosity": viscosity}
        return cls(every, *(pairs.of_each(name, v, above=0) for name, v in keys.items())), every

    def stuck_stiffness(self, points):
        k = np.bincount(self.point_of_element, self.tangential_stiffness, minlength=points)
        return k[:, None]

    def sliders(self):
        every = np.arange(self.viscosity.size)
        k, limit = self.tangential_stiffness, self.slip_force
        return Sliders(every, self.point_of_element, k, None, np.ones_like(limit), limit)

    @cached_property
    def dashpots(self):
        every = np.arange(self.viscosity.size)
        return Dashpots(every, self.point_of_element, self.viscosity)
'''


def glue_law(declaration: str) -> str:
    """The module of the law, with the line that imports its ``DECLARATION``."""
    return _CLASS.replace("{declaration}", declaration)
