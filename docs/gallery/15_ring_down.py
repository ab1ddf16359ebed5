r"""
A ring-down, identified
=======================

A free decay holds frequency and damping at all amplitudes that it passes. Here the decay is
computed in time, from a hammer's impulse, with one per cent of noise; what is identified from it
is compared with the backbone of the joint.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import (
    ConstantLoad,
    Joint,
    find_backbone,
    frequency_window,
    identify_ring_down,
    simulate_ring_down,
)
from boltjoint.damping import ModalDamping

count = 40
one, places = np.ones(1), np.zeros((count, 3))
slip_force = 80 / count * np.linspace(0.02, 1.0, count) ** 2  # [N]
elements = ConstantLoad(np.arange(count), np.full(count, 4e5 / count), slip_force)
joint = Joint(95.0 * one, one, one, np.full((count, 1), 0.5), places, elements, places)
damping = ModalDamping((0.005,))

decay = simulate_ring_down(
    joint, damping, impulse=0.5, duration=1.5, sampling_rate=6400.0, quantity="displacement"
)
rng = np.random.default_rng(1)
noise = 0.01 * abs(decay.values).max() * rng.standard_normal(decay.values.shape)
measured = replace(decay, values=decay.values + noise)
mode = identify_ring_down(measured, band=(75.0, 135.0))

# %%
# Both over amplitude, with twice the standard errors:

window = frequency_window(joint)
backbone = find_backbone(joint, [1e-3, 20.0], damping=damping, window=window)
amplitude = backbone["response_amplitude"].to_numpy()
figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
curves = (
    (axes[0], 1, mode.frequency, mode.frequency_error, "natural_frequency"),
    (axes[1], 100, mode.damping_ratio, mode.damping_error, "damping_ratio"),
)
for axis, factor, values, errors, name in curves:
    axis.semilogx(1e3 * amplitude, factor * backbone[name], color="0.5", label="backbone")
    axis.errorbar(
        1e3 * mode.amplitude,
        factor * values,
        2 * factor * errors,
        fmt=".",
        label="identified",
    )
    axis.set(
        xlabel="Amplitude (mm)", xlim=(1e3 * mode.amplitude.min() / 2, 2e3 * mode.amplitude.max())
    )
axes[0].set(ylabel="Natural frequency (Hz)")
axes[1].set(ylabel="Damping ratio (%)")
axes[0].legend()

# %%
# Median errors against the backbone in percent, of frequency and damping:

for name, values in (("natural_frequency", mode.frequency), ("damping_ratio", mode.damping_ratio)):
    expected = np.interp(np.log(mode.amplitude), np.log(amplitude), backbone[name])
    print(f"{name}: {100 * np.median(abs(values / expected - 1)):.3f} %")
