r"""
A sweep: what decides a peak
============================

Friction, contact stiffness and damping are uncertain. Sobol indices tell which share of the
variance of a peak each one has. 320 joints are solved; a study does the same with a file of
``config/sweeps``.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import lognorm, sobol_indices, uniform

from boltjoint import ConstantLoad, Joint, ModalSynthesis, solve_branch

x = np.linspace(0.0, 0.1, 6)  # [m]
relative_mode = np.column_stack([0.05 + 0.3 * x, -0.1 + 1.5 * x])  # [kg^-1/2]
at_tip = np.array([2.0, -1.9])  # [kg^-1/2]
position = np.column_stack([x, np.zeros(6), np.zeros(6)])
elements = ConstantLoad(np.arange(6), np.full(6, 5e6), np.linspace(2.0, 12.0, 6))
joint = Joint(np.array([70.0, 360.0]), at_tip, at_tip, relative_mode, position, elements, position)

# %%
# Friction varies by 30 %, the stiffness by a decade, the loss factor by a factor of four.

distributions = [lognorm(0.3), lognorm(0.6), uniform(0.001, 0.003)]
names = ["friction", "contact stiffness", "loss factor"]


def peaks(samples: np.ndarray) -> np.ndarray:
    """Logarithm of the peak to 1 N of joints with these values, shape (1, samples)."""
    found = []
    for friction, stiffness, loss_factor in samples.T:
        law = replace(
            elements,
            slip_force=friction * elements.slip_force,
            tangential_stiffness=stiffness * elements.tangential_stiffness,
        )
        each = replace(joint, law=law)
        found.append(solve_branch(each, 1.0, ModalSynthesis(), damping=loss_factor).peak_amplitude)
    return np.log(found)[None]


indices = sobol_indices(func=peaks, n=64, dists=distributions, rng=np.random.default_rng(1))

# %%
# First-order indices, and total ones, which hold interactions too:

figure, axes = plt.subplots(layout="constrained")
place = np.arange(3)
axes.bar(place - 0.2, indices.first_order, 0.35, label="first order")
axes.bar(place + 0.2, indices.total_order, 0.35, label="total")
axes.set_xticks(place, names)
axes.set(ylabel="Share of the variance")
axes.legend()
print(dict(zip(names, indices.total_order.round(2).tolist(), strict=True)))
