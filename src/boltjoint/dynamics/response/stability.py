"""Stability of periodic motions: Floquet multipliers by Hill's method, where a branch folds.

The motion that belongs to a solution of one harmonic, or of few, is balanced with more first
(``folds.FoldedBranch``): at a turning point, which one harmonic misplaces, its multipliers are not
those of the solution. To a solution that does not balance all linear modes no motion belongs.

A small change of a periodic motion is sought as ``exp(r t)`` times a change with the harmonics of
the solution. With the Jacobian J of the balance at the solution, the exponents r obey::

    (r^2 I + r (D + G) + J) p = 0

where D and G are the derivatives by r of the linear part of the balance and of the contact forces:
of a harmonic h, D has 2 h w between sine and cosine, and the damping ``H(hw) / (hw)``; G is due to
sliders, which hold what the motion was when they stopped (``friction.modal_aft.slider_delay``). A
multiplier is ``exp(2 pi r / w)``; the motion is stable where all lie inside the unit circle, those
of rigid-body motion, which are 1, left out. As
``r = 0`` needs ``det J = 0``, a real multiplier is 1 where the branch turns in frequency.

References
----------
G. von Groll, D. J. Ewins: The harmonic balance method with arc-length continuation in rotor/stator
contact problems. Journal of Sound and Vibration 241 (2001) 223-233.

A. Lazarus, O. Thomas: A harmonic-based method for computing the stability of periodic solutions of
dynamical systems. Comptes Rendus Mécanique 338 (2010) 510-517: which exponents to keep.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs

from boltjoint import checks
from boltjoint.dataset import quantities
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.folds import FoldedBranch, Folds
from boltjoint.friction.aft import by_samples
from boltjoint.options import Options

Array = NDArray[np.float64]

#: unknowns up to which all exponents take less time than those that are kept
_FEW_UNKNOWNS = 60
#: imaginary part of exponents over the frequency: 1/2, where a period doubles, and the error of few
#: harmonics
_HALF = 0.52
#: motions in a row that are not found, after which no more are sought
_GIVEN_UP = 5


@dataclass(frozen=True)
class StabilityOptions(Options):
    """Where the stability of a branch is found, and how.

    Parameters
    ----------
    further_solutions
        Solutions on either side of those in the range of frequencies with several solutions whose
        stability is found too. Where a branch does not fold, none is.
    harmonics
        Highest harmonic of the motion whose stability is found. With 15, marks of 98 of 100 random
        motions at folds are those in time, with one 84. Solutions with as many or more are their
        own motion.
    samples
        Time samples of a period at which forces are sampled and sliders followed, at least twice
        the harmonics and one: contact states change at a sample. With 256, a multiplier of 1.037
        was found to be 0.994. Of a balance by AFT with as many harmonics they are its own.
    largest_exponent
        Modulus of the real part of an exponent, over the excitation frequency, up to which it is
        kept: a multiplier up to 23. Larger exponents are not those of the motion, since the delay
        of sliders is linear in them. Of the exponents of a multiplier that with an imaginary part
        within half the frequency is kept, the most accurate.

    Raises
    ------
    ValueError
        If a number is negative, not finite or not whole, or there are too few samples.
    """

    further_solutions: int = 2
    harmonics: int = 15
    samples: int = 1024
    largest_exponent: float = 0.5

    def __post_init__(self) -> None:
        """Refuse options with which nothing is found."""
        checks.whole("further_solutions", self.further_solutions, at_least=0)
        checks.whole("harmonics", self.harmonics, at_least=1)
        checks.whole("samples", self.samples, at_least=2 * self.harmonics + 1)
        checks.number("largest_exponent", self.largest_exponent, above=0)


class Stability(NamedTuple):
    """Stability of the motions that belong to the solutions of a branch, shape (solutions,).

    ``stable``: 1 or 0, -1 where it was not found, as with friction that has a circular limit;
    ``largest_multiplier``: modulus of the largest Floquet multiplier, there NaN; ``harmonics`` of
    the motion, there 0: those of the solution where no motion with more was found.
    ``frequency_range``: lowest and highest frequency [Hz] between which there are several motions
    with all these harmonics, NaN where there are none or it is not known.
    """

    stable: NDArray[np.int8]
    largest_multiplier: Array
    harmonics: NDArray[np.int64]
    frequency_range: tuple[float, float]


def floquet_exponents(
    balance: HarmonicBalance, x: Array, w: float, samples: int = StabilityOptions.samples
) -> NDArray[np.complex128]:
    """Exponents of Hill's method at a solution of the balance [rad/s].

    Of n unknowns of elastic modes there are 2 n. With all harmonics they would be the exponents of
    the motion and all that differ from these by multiples of iw; few harmonics leave those that are
    small right.

    Parameters
    ----------
    balance
        The modal equations.
    x, w
        Their unknown, and the frequency [rad/s].
    samples
        Samples of the period, at which sliders are followed.
    """
    return _all_exponents(*_exponent_problem(balance, x, w, samples))


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
    half, largest = _HALF * w, options.largest_exponent * w
    stiffness, rate = _exponent_problem(balance, x, w, options.samples)
    exponents = None
    if len(stiffness) > _FEW_UNKNOWNS:
        modes = len(stiffness) // len(balance.components)
        exponents = _exponents_within(stiffness, rate, np.hypot(half, largest), 2 * modes)
    if exponents is None:
        exponents = _all_exponents(stiffness, rate)
    kept = (abs(exponents.imag) <= half) & (abs(exponents.real) <= largest)
    if not kept.any():
        kept = np.arange(exponents.size) == abs(exponents).argmin()
    return float(np.exp(2 * np.pi / w * exponents[kept].real.max()))


def find_stability(
    balance: HarmonicBalance,
    frequency: Array,
    x: Array,
    folds: Folds,
    options: StabilityOptions = StabilityOptions(),
    *,
    holds: NDArray[np.bool_] | None = None,
) -> Stability:
    """Stability of the motions at the solutions of a branch where it folds.

    Parameters
    ----------
    balance
        The modal equations, in linear modes.
    frequency
        Frequencies of the solutions [Hz], shape (solutions,).
    x
        Their modal coordinates, shape (solutions, components * modes).
    folds
        Folds of the branch (``find_folds``).
    options
        Where it is found, and how.
    holds
        Solutions for which the balance holds, shape (solutions,), by default all: the motions of
        others are not known. Where some that are folded do, the branch is followed from all.
    """
    holds = np.ones(frequency.size, bool) if holds is None else holds
    multiplier, harmonics = np.full(frequency.size, np.nan), np.zeros(frequency.size, np.int64)
    low, high = folds.frequency_range
    several = np.nan, np.nan
    # sliders in the plane have no delay of their own
    elements = by_samples(balance.joint.law, options.samples).elements
    has_delay = elements.at_samples.in_modes(balance.contact.rows, 0.0) is not None
    folded = (frequency >= low) & (frequency <= high)
    if (folded & holds).any() and has_delay:
        finite = np.isfinite(x).all(axis=1)
        of_few = balance.components.highest
        finer = None
        if of_few >= options.harmonics:
            several = low, high
        elif finite.all():
            finer = FoldedBranch(balance, frequency, x, folds, options.harmonics, options.samples)
            several = finer.frequency_range
        low, high = np.fmin(low, several[0]), np.fmax(high, several[1])
        missing = 0
        inside = np.flatnonzero((frequency >= low) & (frequency <= high))
        around = np.arange(-options.further_solutions, options.further_solutions + 1)
        for i in np.intersect1d(inside[:, None] + around, np.flatnonzero(finite & holds)):
            w, motion = 2 * np.pi * frequency[i], None
            if finer is not None and missing < _GIVEN_UP:
                motion = finer.motion_of(int(i))
                missing = missing + 1 if motion is None else 0
            if motion is None or finer is None:
                multiplier[i] = largest_multiplier(balance, x[i], w, options)
                harmonics[i] = of_few
            else:
                multiplier[i] = largest_multiplier(finer.balance, motion, w, options)
                harmonics[i] = options.harmonics
    stable = np.where(np.isnan(multiplier), -1, multiplier < 1)
    return Stability(stable.astype(np.int8), multiplier, harmonics, several)


def stability_variables(stabilities: Sequence[Stability]) -> dict[str, xr.Variable]:
    """Variables of ``response.nc`` by the stability of its branches."""
    stable, multiplier, harmonics = (
        np.concatenate([getattr(one, name) for one in stabilities])
        for name in ("stable", "largest_multiplier", "harmonics")
    )
    low, high = np.array([one.frequency_range for one in stabilities]).T
    rows = (
        ("stable", "solution", stable, "1", "1 where its motion is stable, 0 if not, -1 not found"),
        ("largest_multiplier", "solution", multiplier, "1", "largest Floquet multiplier of that"),
        ("stability_harmonics", "solution", harmonics, "1", "of that motion, 0 where not found"),
        ("folded_from_converged", "force", low, "Hz", "folded_from with stability_harmonics"),
        ("folded_to_converged", "force", high, "Hz", "folded_to with stability_harmonics"),
    )
    return quantities(rows)


def _exponent_problem(
    balance: HarmonicBalance, x: Array, w: float, samples: int
) -> tuple[Array, Array]:
    """J [rad^2/s^2] and D + G [rad/s] of the exponents, both (n, n)."""
    jacobian = balance.residual_and_jacobian(x, w)[1]()
    rate = _rate_derivative(balance, x, w, samples)
    rigid = balance.joint.is_rigid
    if balance.basis is None and rigid.any():
        # rigid-body motion stays where it is, and nothing depends on it
        kept = np.flatnonzero(np.tile(~rigid, len(balance.components)))
        jacobian, rate = (matrix[np.ix_(kept, kept)] for matrix in (jacobian, rate))
    return jacobian, rate


def _all_exponents(jacobian: Array, rate: Array) -> NDArray[np.complex128]:
    """All exponents [rad/s], shape (2 n,)."""
    n = len(jacobian)
    first_order = np.zeros((2 * n, 2 * n))
    first_order[:n, n:] = np.eye(n)
    first_order[n:, :n] = -jacobian
    first_order[n:, n:] = -rate
    return np.asarray(np.linalg.eigvals(first_order), complex)


def _exponents_within(
    jacobian: Array, rate: Array, limit: float, count: int
) -> NDArray[np.complex128] | None:
    """Those exponents whose modulus is within a limit [rad/s], by inverse iteration (Arnoldi).

    Parameters
    ----------
    jacobian, rate
        J and D + G.
    limit
        Limit of the modulus.
    count
        How many are expected there.

    Returns
    -------
    ndarray or None
        At least these; None where that takes more work than all exponents, or does not converge.
    """
    n, factors = len(jacobian), lu_factor(jacobian / limit**2)
    rate = rate / limit

    def inverse(y: Array) -> Array:
        position, velocity = y[:n], y[n:]
        return np.append(-lu_solve(factors, velocity + rate @ position), position)

    operator, start = LinearOperator((2 * n, 2 * n), inverse, dtype=float), np.ones(2 * n)
    while count < n // 4:
        try:
            inverses = eigs(operator, count, v0=start, return_eigenvectors=False)
        except ArpackError:
            return None
        if abs(inverses).min() < 1:
            return limit / inverses
        count *= 2
    return None


def _rate_derivative(balance: HarmonicBalance, x: Array, w: float, samples: int) -> Array:
    """D + G: derivative by the exponent of the balance of a growing change [rad/s], (n, n)."""
    components, modes = balance.components, len(balance.stiffness)
    count = len(components)
    derivative = np.zeros((count, modes, count, modes))
    mass = np.eye(modes)
    for place, number in enumerate(components.number):
        # damping is viscous at each harmonic; the mean has that of the excitation frequency
        at = max(int(number), 1) * w
        derivative[place, :, place, :] += balance.damping_matrix.at(at) / at
    for h, s, c in components.harmonics:
        derivative[s, :, c, :] -= 2 * h * w * mass
        derivative[c, :, s, :] += 2 * h * w * mass
    law = by_samples(balance.joint.law, samples)
    delay = law.modal_slider_delay(balance.contact.rows, x.reshape(count, modes), w)
    if delay is None:
        raise ValueError(f"the delay of the sliders of the law {law.name!r} is not known")
    return (derivative + 2 * np.pi / w * delay).reshape(x.size, x.size)
