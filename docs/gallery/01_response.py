r"""
Response from arrays
====================

Two modes without contact and six contact pairs, given as arrays, make a joint. Its resonance moves
from that of the sticking contact to that without contact as the force grows.
"""

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import ConstantLoad, Joint, solve_branch

x = np.linspace(0.0, 0.1, 6)  # places of the pairs along the lap [m]
# relative displacement of the pairs in the two modes, and the modes at the tip [kg^-1/2]
relative_mode = np.column_stack([0.05 + 0.3 * x, -0.1 + 1.5 * x])
at_tip = np.array([2.0, -1.9])
position = np.column_stack([x, np.zeros(6), np.zeros(6)])
slip_force = np.linspace(2.0, 12.0, 6)  # [N]
elements = ConstantLoad(np.arange(6), np.full(6, 5e6), slip_force)
joint = Joint(np.array([70.0, 360.0]), at_tip, at_tip, relative_mode, position, elements, position)

# %%
# One branch for each force. The largest response per force lies between the two linear ones.

figure, axes = plt.subplots(layout="constrained")
peak = {}
for force in (0.01, 1.0, 3.0, 10.0):  # N
    branch = solve_branch(joint, force, damping=0.002)
    peak[force] = branch.peak_frequency
    axes.semilogy(branch.frequency, 1e3 * branch.amplitude / force, label=f"{force:g} N")
axes.set(xlabel="Frequency (Hz)", ylabel="Response per force (mm/N)")
axes.legend()

# %%
# Resonance frequencies in Hz:

print({force: round(frequency, 2) for force, frequency in peak.items()})
