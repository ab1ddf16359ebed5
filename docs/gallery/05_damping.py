r"""
An own damping model
====================

The force of a damping model is a sum of terms :math:`c\,\omega^p\,H` with real symmetric matrices.
The power :math:`p` may be any number that is not negative: here a viscoelastic bar has :math:`p =
1/2`, between a loss factor (0) and viscous damping (1).
"""

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import ConstantLoad, Joint, frequency_window, solve_branch
from boltjoint.damping import Damping, LossFactor, ModalStructure, RayleighDamping, Term


@dataclass(frozen=True)
class FractionalDamping(Damping):
    """Damping with a fractional derivative, proportional to the stiffness."""

    name = "fractional"
    quantities = {"factor": ("s^1/2", "of the stiffness")}  # noqa: RUF012
    factor: float

    def terms(self, structure: ModalStructure) -> tuple[Term, ...]:
        return (Term(0.5, self.factor, structure.stiffness),)


# %%
# All three have the same loss factor, 0.01, at 70 Hz, the resonance without contact.

reference = 2 * np.pi * 70.0
models = {
    "loss factor": LossFactor(0.01),
    "fractional": FractionalDamping(0.01 / reference**0.5),
    "viscous": RayleighDamping(0.0, 0.01 / reference),
}
one, place = np.ones(1), np.zeros((1, 3))
elements = ConstantLoad([0], [2e6], [30.0])
joint = Joint(70.0 * one, 2 * one, 2 * one, np.array([[0.4]]), place, elements, place)

figure, axes = plt.subplots(layout="constrained")
peak = {}
for name, damping in models.items():
    branch = solve_branch(joint, 0.02, damping=damping)
    peak[name] = 1e3 * branch.peak_amplitude
    axes.plot(branch.frequency, 1e3 * branch.amplitude, label=name)
stuck = branch.peak_frequency
axes.set(xlabel="Frequency (Hz)", ylabel="Response to 0.02 N (mm)", xlim=(stuck - 4, stuck + 4))
axes.legend()
print(f"window: {frequency_window(joint)[0]:.1f} to {frequency_window(joint)[1]:.1f} Hz")

# %%
# Here the contact sticks, at a higher frequency: so viscous damping is stronger by the ratio of
# the frequencies, the fractional one by its square root. Peaks in mm, and that ratio:

print({name: round(value, 4) for name, value in peak.items()}, round(stuck / 70.0, 3))
