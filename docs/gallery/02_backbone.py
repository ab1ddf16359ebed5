r"""
Backbone: frequency and damping over amplitude
==============================================

A backbone holds the natural frequency and the damping ratio of a nonlinear mode at every
amplitude. One backbone gives the peaks of the responses to all forces.
"""

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import (
    ConstantLoad,
    Joint,
    ModalSynthesis,
    find_backbone,
    frequency_window,
    solve_response,
)

x = np.linspace(0.0, 0.1, 6)  # [m]
relative_mode = np.column_stack([0.05 + 0.3 * x, -0.1 + 1.5 * x])  # [kg^-1/2]
at_tip = np.array([2.0, -1.9])  # [kg^-1/2]
position = np.column_stack([x, np.zeros(6), np.zeros(6)])
elements = ConstantLoad(np.arange(6), np.full(6, 5e6), np.linspace(2.0, 12.0, 6))
joint = Joint(np.array([70.0, 360.0]), at_tip, at_tip, relative_mode, position, elements, position)

# %%
# The backbone covers the responses to all forces between the given ones.

window = frequency_window(joint)
backbone = find_backbone(joint, [0.01, 10.0], damping=0.002, window=window)
amplitude = 1e3 * backbone["response_amplitude"]
damping = 100 * backbone["damping_ratio"]

# %%
# Peaks of responses in all linear modes lie on it. Responses that are synthesised from the
# backbone have the same peaks, and need no continuation.

forces = [0.1, 0.3, 1.0, 2.0]
response = solve_response(joint, forces, damping=0.002)
synthesis = solve_response(joint, forces, ModalSynthesis(backbone), damping=0.002)

figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
left.semilogx(amplitude, backbone["natural_frequency"], label="backbone")
left.plot(1e3 * response["peak_amplitude"], response["peak_frequency"], "o", label="peaks")
left.set(xlabel="Amplitude (mm)", ylabel="Natural frequency (Hz)")
left.legend()
right.semilogx(amplitude, damping, color="tab:red")
right.set(xlabel="Amplitude (mm)", ylabel="Damping ratio (%)")

# %%
# Largest damping ratio, where it is, and the largest difference of the peaks in percent:

difference = abs(synthesis["peak_amplitude"] / response["peak_amplitude"] - 1)
largest = int(np.argmax(damping.to_numpy()))
print(f"{damping[largest]:.1f} % at {amplitude[largest]:.3f} mm")
print(f"{100 * difference.max():.2f} %")
