r"""
A joint fitted to a measurement
===============================

Frequency and damping of the first mode of a bolted beam over its amplitude: public numbers of the
assembly CD1 (N. N. Balaji, M. R. W. Brake and others; ``resources/measured`` has all of them and
their source). One Iwan element on one mode is fitted to both at once.
"""

import matplotlib.pyplot as plt
import numpy as np

from boltjoint import Joint, MeasuredBackbone, Parameter, fit
from boltjoint.friction.iwan import FourParameterIwan

# modal amplitude [kg^1/2 m], frequency [Hz], damping ratio
measured = np.array(
    [
        [6.06297e-06, 177.71282, 1.19999e-03],
        [7.21594e-06, 177.66220, 1.29602e-03],
        [8.18859e-06, 177.62508, 1.39569e-03],
        [9.04643e-06, 177.58563, 1.51306e-03],
        [9.97926e-06, 177.53984, 1.64945e-03],
        [1.09787e-05, 177.49615, 1.73878e-03],
        [1.20398e-05, 177.44292, 1.88287e-03],
        [1.32387e-05, 177.39193, 1.95320e-03],
        [1.47676e-05, 177.31423, 2.16503e-03],
        [1.71884e-05, 177.19550, 2.32514e-03],
        [2.00141e-05, 177.08833, 2.40573e-03],
        [2.3491e-05, 176.95529, 2.64964e-03],
        [2.77877e-05, 176.74582, 3.01764e-03],
        [3.8745e-05, 176.05567, 4.50407e-03],
    ]
)
amplitude, frequency, damping = measured.T
curve = MeasuredBackbone(
    amplitude,
    frequency,
    0.02 * np.ptp(frequency),  # stated deviations
    damping,
    0.05 * damping,
    quantity="modal",
)

# %%
# Bounds are what the curve tells: the element makes the measured shift of the squared frequency,
# and up to ten times as much.

shift = (2 * np.pi) ** 2 * (frequency.max() ** 2 - frequency.min() ** 2)
one, place = np.ones(1), np.zeros((1, 3))
law = FourParameterIwan([0], [shift], [shift * amplitude.max()], [-0.5], [1.0])
joint = Joint(frequency.min() * one, one, one, one[:, None], place, law, place)
lowest = np.sqrt(10 * frequency.min() ** 2 - 9 * frequency.max() ** 2)
calibration = fit(
    joint,
    curve,
    [
        Parameter("natural_frequency[1]", lowest, frequency.min()),
        Parameter("tangential_stiffness", shift, 10 * shift),
        Parameter("slip_force", 0.01 * shift * amplitude.max(), 10 * shift * amplitude.max()),
        Parameter("chi", -0.99, 0, logarithmic=False),
        Parameter("beta", 0.01, 100),
        Parameter("loss_factor", 1e-5, 2 * damping.min()),
    ],
)

# %%
# The curve of the model, and twice its standard deviation:

at = np.geomspace(amplitude.min(), amplitude.max(), 100)
(model,), (deviation,) = calibration.curves([at]), calibration.bands([at])
figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
labels = ("Natural frequency (Hz)", "Damping ratio (%)")
for n, (axis, factor, label) in enumerate(zip(axes, (1, 100), labels, strict=True)):
    middle, reach = factor * model[:, n], 2 * factor * deviation[:, n]
    axis.fill_between(1e6 * at, middle - reach, middle + reach, alpha=0.3)
    axis.plot(1e6 * at, middle, label="model")
    axis.plot(1e6 * amplitude, factor * measured[:, n + 1], "ko", mfc="white", label="measured")
    axis.set(xlabel="Modal amplitude (10$^{-6}$ kg$^{1/2}$ m)", ylabel=label)
axes[0].legend()

# %%
# What was found, and errors relative to the measurement; a sentence that the model cannot be right
# comes first, where it is so:

print(calibration.summary())
