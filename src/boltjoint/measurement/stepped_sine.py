"""Frequency and damping of a mode from stepped sines at constant response.

At a constant amplitude a of the response the joint is a linear oscillator. Near a resonance, force
over response is that of one mode and its surroundings::

    F / q = m (w0^2 - w^2 + 2 i zeta w0 w)

which is linear in m, ``m w0^2`` and ``2 m zeta w0``: least squares give frequency and damping at a
without a peak, which the level of the response may never have.

References
----------
S. Karaağaçlı, H. N. Özgüven: Experimental modal analysis of nonlinear systems by using
response-controlled stepped-sine testing. Mechanical Systems and Signal Processing 146 (2021)
107023.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]

#: largest spread of the response over its mean that counts as constant
_CONSTANT = 0.1

#: fewest frequencies: as many complex values as twice the unknowns
_FEWEST = 6


@dataclass(frozen=True)
class ConstantResponse:
    """A mode at one amplitude of the response.

    Parameters
    ----------
    amplitude, amplitude_spread
        Mean of the amplitudes [unit of the quantity] and their standard deviation.
    frequency, frequency_error
        Natural frequency w0 and its standard error [Hz].
    damping_ratio, damping_error
        zeta and its standard error [-].
    modal_mass
        m of the sensor and the force [kg], negative where they move against each other.
    """

    amplitude: float
    amplitude_spread: float
    frequency: float
    frequency_error: float
    damping_ratio: float
    damping_error: float
    modal_mass: float


def identify_constant_response(
    frequency: Array, response: Array, force: Array, phase: Array, quantity: str
) -> ConstantResponse:
    """Identify a mode from a stepped sine at constant response.

    Parameters
    ----------
    frequency
        Excitation frequencies [Hz], shape (steps,).
    response, force
        Amplitudes of the response [SI unit of the quantity] and of the force [N], shape (steps,).
    phase
        Phase of the response from the force [rad], shape (steps,).
    quantity
        ``displacement``, ``velocity`` or ``acceleration``.

    Raises
    ------
    ValueError
        If shapes differ, there are fewer than six frequencies, the response is not constant, or
        no resonance fits.
    """
    frequency = checks.array("frequency", frequency, ("steps",), above=0)
    response = checks.array("response", response, frequency.shape, above=0)
    force = checks.array("force", force, frequency.shape, above=0)
    phase = checks.array("phase", phase, frequency.shape)
    order = MOTIONS[checks.choice("quantity", quantity, MOTIONS)]
    if frequency.size < _FEWEST:
        raise ValueError(f"frequency has {frequency.size} steps: at least {_FEWEST} are needed")
    a, spread = float(response.mean()), float(response.std())
    if spread > _CONSTANT * a:
        raise ValueError(
            f"response spreads by {100 * spread / a:.2g} % of its mean: "
            f"at constant response it stays within {100 * _CONSTANT:g} %"
        )
    w = 2 * np.pi * frequency
    displacement = response * np.exp(1j * phase) / (1j * w) ** order
    stiffness = force / displacement
    # relative errors of the measurement are alike; the weight is that of a smooth receptance
    scale = np.abs(stiffness).min()
    rows = np.zeros((2, w.size, 3))
    rows[0, :, 0], rows[0, :, 1], rows[1, :, 2] = -(w**2), 1.0, w
    A, b = rows.reshape(-1, 3), np.concatenate([stiffness.real, stiffness.imag])
    weight = np.tile(1 / np.maximum(abs(stiffness), scale), 2)
    column = np.linalg.norm(weight[:, None] * A, axis=0)
    scaled = weight[:, None] * A / column
    solution, residual, rank, _ = np.linalg.lstsq(scaled, weight * b, rcond=None)
    m, k, c = solution / column
    if rank < 3 or not (m * k > 0 and c * m > 0):
        raise ValueError(
            f"response at {a:g} has no resonance from {frequency.min():g} to "
            f"{frequency.max():g} Hz: mass, stiffness and damping must have one sign"
        )
    inverse = np.linalg.inv(scaled.T @ scaled)
    variance = float(residual[0]) / (b.size - 3) if residual.size else 0.0
    covariance = variance * inverse / np.outer(column, column)
    w0, zeta = np.sqrt(k / m), abs(c) / (2 * np.sqrt(k * m))
    by_w0 = w0 * np.array([-0.5 / m, 0.5 / k, 0.0])
    by_zeta = zeta * np.array([-0.5 / m, -0.5 / k, 1 / c])
    w0_error, zeta_error = (float(np.sqrt(g @ covariance @ g)) for g in (by_w0, by_zeta))
    return ConstantResponse(
        a,
        spread,
        float(w0 / (2 * np.pi)),
        w0_error / (2 * np.pi),
        float(zeta),
        zeta_error,
        float(m),
    )
