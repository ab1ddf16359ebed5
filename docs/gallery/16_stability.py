r"""
Stability where a response folds
================================

A contact that closes as it moves hardens: the response bends over, and three motions exist at one
frequency. The middle one is unstable. A slow sweep up jumps down where the branch turns back.
"""

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import Joint, Resonance, VariableLoad, by_force, solve_response
from boltjoint.damping import ModalDamping

one, place = np.ones(1), np.zeros((1, 3))
# a negative normal load is a gap: 100 N over 3e5 N/m
elements = VariableLoad([0], 4e5 * one, 3e5 * one, -100.0 * one, 0.3 * one)
joint = Joint(
    np.array([50.0, 210.0]),
    np.array([1.0, 0.7]),
    np.array([1.5, -0.4]),
    np.array([[0.2, -0.3]]),
    place,
    elements,
    place,
    normal_mode=np.array([[0.6, 0.6]]),
)
response = solve_response(
    joint, [2.0], damping=ModalDamping((0.005,)), resonance=Resonance(1, window=(35.0, 100.0))
)

# %%
# Stability is found where the branch folds, by Hill's method:

curve = by_force(response).sel(force=2.0)
frequency, amplitude = curve["frequency"].to_numpy(), 1e3 * curve["response_amplitude"].to_numpy()
unstable = np.where(curve["stable"] == 0, amplitude, np.nan)
figure, axes = plt.subplots(layout="constrained")
axes.plot(frequency, amplitude, label="response to 2 N")
axes.plot(frequency, unstable, "r--", lw=2.5, label="unstable")
axes.plot(
    response["fold_frequency"], 1e3 * response["fold_amplitude"], "ko", label="turning points"
)
axes.set(xlabel="Frequency (Hz)", ylabel="Amplitude (mm)", xlim=(45, 62))
axes.legend()

# %%
# Turning points in Hz, and the number of unstable solutions:

print(response["fold_frequency"].round(2).values, int(np.isfinite(unstable).sum()))
