"""Stability of periodic solutions: Floquet multipliers by Hill's method, where a branch folds.

A small change of a periodic motion is sought as ``exp(r t)`` times a change with the harmonics of
the solution. With the Jacobian J of the balance at the solution, the exponents r obey::

    (r^2 I + r (D + G) + J) p = 0

where D and G are the derivatives by r of the linear part of the balance and of the contact forces:
of a harmonic h, D has 2 h w between sine and cosine, and the damping ``H(hw) / (hw)``; G is due to
sliders, which hold what the motion was when they stopped (``friction.modal_aft.slider_delay``). A
multiplier is ``exp(2 pi r / w)``; the motion is stable where all lie inside the unit circle. As
``r = 0`` needs ``det J = 0``, a real multiplier is 1 where the branch turns in frequency.

References
----------
G. von Groll, D. J. Ewins: The harmonic balance method with arc-length continuation in rotor/stator
contact problems. Journal of Sound and Vibration 241 (2001) 223-233.

A. Lazarus, O. Thomas: A harmonic-based method for computing the stability of periodic solutions of
dynamical systems. Comptes Rendus Mécanique 338 (2010) 510-517: which exponents to keep.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.folds import Folds
from boltjoint.dynamics.harmonic_balance import HarmonicBalance, parse_component
from boltjoint.friction.aft import by_samples
from boltjoint.options import Options

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StabilityOptions(Options):
    """Where the stability of a branch is found, and how.

    Parameters
    ----------
    further_solutions
        Solutions on either side of those in the range of frequencies with several solutions whose
        stability is found too. Where a branch does not fold, none is.
    delay_samples
        Time samples of a period at which sliders are followed: their delay is off by a sample at
        most. Of a balance by AFT they are its own.
    largest_exponent
        Modulus of an exponent, over the excitation frequency, up to which it is kept. Of the
        exponents of a multiplier one has an imaginary part within a half, and is the most accurate;
        larger exponents are not those of the motion, since the delay of sliders is linear in them.

    Raises
    ------
    ValueError
        If a number is negative, not finite or not whole, or there are fewer than three samples.
    """

    further_solutions: int = 2
    delay_samples: int = 256
    largest_exponent: float = 0.5

    def __post_init__(self) -> None:
        """Refuse options with which nothing is found."""
        checks.whole("further_solutions", self.further_solutions, at_least=0)
        checks.whole("delay_samples", self.delay_samples, at_least=3)
        checks.number("largest_exponent", self.largest_exponent, above=0)


class Stability(NamedTuple):
    """Stability of the solutions of a branch, shape (solutions,).

    ``stable``: 1 or 0, -1 where it was not found, as with friction that has a circular limit;
    ``largest_multiplier``: modulus of the largest Floquet multiplier, there NaN.
    """

    stable: NDArray[np.int8]
    largest_multiplier: Array


def floquet_exponents(
    balance: HarmonicBalance, x: Array, w: float, samples: int = StabilityOptions.delay_samples
) -> NDArray[np.complex128]:
    """Exponents of Hill's method at a solution of the balance [rad/s].

    Of n unknowns there are 2 n. With all harmonics they would be the exponents of the motion and
    all that differ from these by multiples of iw; few harmonics leave those that are small right.

    Parameters
    ----------
    balance
        The modal equations.
    x, w
        Their unknown, and the frequency [rad/s].
    samples
        Of the period, at which sliders are followed.
    """
    jacobian = balance.residual_and_jacobian(x, w)[1]()
    n = x.size
    first_order = np.zeros((2 * n, 2 * n))
    first_order[:n, n:] = np.eye(n)
    first_order[n:, :n] = -jacobian
    first_order[n:, n:] = -_rate_derivative(balance, x, w, samples)
    return np.linalg.eigvals(first_order)


def largest_multiplier(
    balance: HarmonicBalance, x: Array, w: float, options: StabilityOptions = StabilityOptions()
) -> float:
    """Modulus of the largest Floquet multiplier of a solution.

    Parameters
    ----------
    balance, x, w
        As for ``floquet_exponents``.
    options
        Which exponents are kept. Where the motion is so far from all resonances that none is, the
        one nearest to zero counts.
    """
    exponents = floquet_exponents(balance, x, w, options.delay_samples)
    size = abs(exponents)
    kept = size <= max(options.largest_exponent * w, size.min())
    return float(np.exp(2 * np.pi / w * exponents[kept].real.max()))


def find_stability(
    balance: HarmonicBalance,
    frequency: Array,
    x: Array,
    folds: Folds,
    options: StabilityOptions = StabilityOptions(),
) -> Stability:
    """Stability of the solutions of a branch where it folds.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    frequency
        Of the solutions [Hz], shape (solutions,).
    x
        Their modal coordinates, shape (solutions, components * modes).
    folds
        Of the branch (``find_folds``).
    options
        Where it is found, and how.
    """
    low, high = folds.frequency_range
    folded = np.flatnonzero((frequency >= low) & (frequency <= high))
    around = np.arange(-options.further_solutions, options.further_solutions + 1)
    multiplier = np.full(frequency.size, np.nan)
    if not by_samples(balance.joint.law, options.delay_samples).sums_in_modal_coordinates:
        # sliders in the plane have no delay of their own
        folded = folded[:0]
    for i in np.intersect1d(folded[:, None] + around, np.flatnonzero(np.isfinite(x).all(axis=1))):
        multiplier[i] = largest_multiplier(balance, x[i], 2 * np.pi * frequency[i], options)
    stable = np.where(np.isnan(multiplier), -1, multiplier < 1)
    return Stability(stable.astype(np.int8), multiplier)


def _rate_derivative(balance: HarmonicBalance, x: Array, w: float, samples: int) -> Array:
    """D + G: derivative by the exponent of the balance of a growing change [rad/s], (n, n)."""
    parts = {parse_component(name): i for i, name in enumerate(balance.components)}
    modes, count = len(balance.stiffness), len(parts)
    found = np.zeros((count, modes, count, modes))
    mass = np.eye(modes)
    for (part, harmonic), i in parts.items():
        # damping is viscous at each harmonic; the mean has that of the excitation frequency
        at = max(harmonic, 1) * w
        found[i, :, i, :] += balance.damping_matrix.at(at) / at
        if part == "sin":
            j = parts["cos", harmonic]
            found[i, :, j, :] -= 2 * at * mass
            found[j, :, i, :] += 2 * at * mass
    law = by_samples(balance.joint.law, samples)
    delay = law.modal_slider_delay(balance.contact.rows, x.reshape(count, modes))
    return (found + 2 * np.pi / w * delay).reshape(x.size, x.size)
