r"""
An own friction law
===================

A law is a class with its quantities and what its elements are made of. Here every contact pair is
a row of sliders, whose slip displacements are evenly distributed up to the largest. Without a
closed form, the forces come from samples of a period (AFT).

With infinitely many sliders this is the four-parameter Iwan element with :math:`\chi = 0` and
:math:`\beta = 0`, which the library knows: the example compares both.
"""

from dataclasses import dataclass, replace

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import Joint, solve_branch
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.declarations import LawDeclaration
from boltjoint.friction.element_law import ElementLaw, check_elements
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.sliders_at_samples import Sliders

SLIDERS = 40


@dataclass(frozen=True)
class EvenRow(ElementLaw):
    """Elements of many sliders, whose slip displacements are evenly distributed."""

    point_of_element: np.ndarray
    tangential_stiffness: np.ndarray  # of all sliders of an element [N/m]
    slip_force: np.ndarray  # at which all of them slip [N]

    declaration = LawDeclaration(
        name="even-row",
        label="even row",
        meaning="Sliders with evenly distributed slip displacements.",
        keys=(),
        capabilities=(),
        has_closed_form=False,
    )
    quantities = {  # noqa: RUF012
        "tangential_stiffness": ("N/m", "stiffness of all sliders"),
        "slip_force": ("N", "force at which all sliders slip"),
    }
    closed_form = None

    def __post_init__(self) -> None:
        check_elements(self)

    @classmethod
    def from_contact(cls, pairs, *, tangential_stiffness, friction_coefficient):  # noqa: ANN001, ANN206
        loaded = np.flatnonzero(pairs.normal_load > 0)
        k = pairs.of_each("tangential_stiffness", tangential_stiffness, above=0)[loaded]
        mu = pairs.of_each("friction_coefficient", friction_coefficient, above=0)[loaded]
        return cls(np.arange(loaded.size), k, mu * pairs.normal_load[loaded]), loaded

    def stuck_stiffness(self, points: int) -> np.ndarray:
        return np.bincount(self.point_of_element, self.tangential_stiffness, points)[:, None]

    def sliders(self) -> Sliders:
        element = np.repeat(np.arange(self.slip_force.size), SLIDERS)
        stiffness = self.tangential_stiffness[element] / SLIDERS
        # the mean slip displacement is half of the largest
        place = np.tile((np.arange(SLIDERS) + 0.5) / SLIDERS, self.slip_force.size)
        largest = 2 * self.slip_force / self.tangential_stiffness
        limit = stiffness * largest[element] * place
        point = self.point_of_element[element]
        return Sliders(element, point, stiffness, None, np.ones_like(limit), limit)


# %%
# A joint with this law, and the same joint with Iwan elements.

one, place = np.ones(1), np.zeros((1, 3))
own = EvenRow(np.array([0]), 1e5 * one, 20.0 * one)
joint = Joint(70.0 * one, 2 * one, 2 * one, np.array([[0.6]]), place, own, place)
with_iwan = replace(
    joint, law=FourParameterIwan([0], own.tangential_stiffness, own.slip_force, [0.0], [0.0])
)
sampled = {
    "own law": replace(joint, law=AlternatingFrequencyTime(own, harmonics=1, samples=512)),
    "Iwan element": with_iwan,
}
figure, axes = plt.subplots(layout="constrained")
peak = {}
for name, each in sampled.items():
    branch = solve_branch(each, 5.0, damping=0.002)
    peak[name] = branch.peak_amplitude
    style = {"marker": "o", "linestyle": "none", "markevery": 8} if name == "own law" else {}
    axes.plot(branch.frequency, 1e3 * branch.amplitude, label=name, **style)
axes.set(xlabel="Frequency (Hz)", ylabel="Response to 5 N (mm)")
axes.legend()

# %%
# Difference of the peaks in percent:

print(f"{100 * (peak['own law'] / peak['Iwan element'] - 1):.3f} %")
