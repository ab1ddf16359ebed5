r"""
An isolated branch
==================

A contact that opens as it slips loses its damping at large amplitudes. Then one force has several
peaks on the backbone, and the largest lie on a branch that is detached from the main one: a sweep
of the frequency does not find it.
"""

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import Joint, Resonance, VariableLoad, find_backbone, solve_response
from boltjoint.damping import ModalDamping

one, place = np.ones(1), np.zeros((1, 3))
elements = VariableLoad([0], 4e5 * one, 3e5 * one, 60.0 * one, 0.6 * one)
joint = Joint(
    50.0 * one, one, 1.5 * one, np.array([[0.8]]), place, elements, place, np.array([[0.6]])
)
damping, window = ModalDamping((0.001,)), (45.0, 160.0)
backbone = find_backbone(joint, [13.0, 15.0], damping=damping, window=window)
low, high = backbone["isolated_from"].item(), backbone["isolated_to"].item()

# %%
# The force of each peak over its amplitude is not monotone:

force, amplitude = backbone["peak_force"], 1e3 * backbone["response_amplitude"]
figure, axes = plt.subplots(layout="constrained")
axes.semilogx(amplitude, force)
axes.axhspan(low, high, alpha=0.2, label="forces with an isolated branch")
axes.set(xlabel="Amplitude of the peak (mm)", ylabel="Force (N)", xlim=(0.1, 3), ylim=(12, 16.5))
axes.set_xticks([0.1, 0.3, 1, 3], ["0.1", "0.3", "1", "3"])
axes.minorticks_off()
axes.legend()

# %%
# The response to a force in this range, continued over the frequency, ends at the lower peak.
# Range in N, that peak in mm, and the amplitude at which the isolated branch appears:

found = solve_response(joint, [14.3], damping=damping, resonance=Resonance(1, window))
peak = 1e3 * found["peak_amplitude"].item()
appears = 1e3 * backbone["isolated_amplitude"].item()
print(f"{low:.2f} to {high:.2f} N: {peak:.3f} mm, {appears:.3f} mm")
