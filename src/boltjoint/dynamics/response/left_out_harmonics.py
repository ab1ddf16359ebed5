"""What the harmonics that a peak leaves out would change: the estimate of its truncation error.

The contact forces of a motion with H harmonics have harmonics beyond H, which nothing balances.
Newton corrections of the motion with several times the harmonics, at the same phase of the output
point, are the response of the structure with its contact to them. At a peak the amplitude does not
change with the phase to first order, so that its change at that phase is the one of the peak.

Their linear equations are solved by GMRES, preconditioned by the Jacobian of the H harmonics
together, and by the structure alone in each harmonic beyond, with the stiffness that the contact
has in the highest of the H: a few iterations where one factorization of all harmonics together
would cost as much as the peak itself.

References
----------
A. Grolet, F. Thouverez: On a new harmonic selection technique for harmonic balance method.
Mechanical Systems and Signal Processing 30 (2012) 43-60.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from boltjoint import checks
from boltjoint.dynamics.balance.harmonic_balance import (
    HarmonicBalance,
    stiffness_of_harmonic,
)
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.balance.phase_equations import PhaseEquations
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.options import Options

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LeftOutHarmonics(Options):
    """Corrections of a peak by the harmonics it leaves out.

    Parameters
    ----------
    times
        Highest harmonic of the corrections, over that of the peak. Forces of harmonics fall with
        the square of their number; with twice as many, resonances of the contact with harmonics
        beyond stay unseen.
    finer
        Time samples a period over those of the peak, so that corrections hold their error too,
        which falls with their square.
    corrections
        At most. Contact states change with them, so that one is not enough.
    settled
        Part of a change that the last correction may change, for it to be the last.
    tolerance, iterations
        Residual of GMRES over the right side, and its iterations at most.
    safety
        Factor of the largest change by corrections, for what further ones would add.
    """

    times: int = 3
    finer: int = 2
    corrections: int = 5
    settled: float = 0.2
    tolerance: float = 0.1
    iterations: int = 60
    safety: float = 2.0

    def __post_init__(self) -> None:
        """Refuse options without a correction."""
        checks.whole("times", self.times, at_least=2)
        checks.whole("finer", self.finer, at_least=1)
        for name in ("corrections", "iterations"):
            checks.whole(name, getattr(self, name), at_least=1)
        for name in ("settled", "tolerance", "safety"):
            checks.number(name, getattr(self, name), above=0)

    def error(self, changes: Array) -> Array:
        """Error that a quantity may have by its relative changes, one row for each correction."""
        before = np.zeros(changes.shape[1]) if len(changes) == 1 else changes[-2]
        return self.safety * abs(changes).max(axis=0) + abs(changes[-1] - before)


def changes_by_left_out_harmonics(
    balance: HarmonicBalance,
    jacobian: Array,
    motion: PeriodicMotion,
    frequency: float,
    options: LeftOutHarmonics = LeftOutHarmonics(),
) -> Array:
    """Relative changes of frequency and amplitude of a peak by corrections with more harmonics.

    Parameters
    ----------
    balance
        In linear modes, with AFT in the harmonics of the motion.
    jacobian
        Of the balance at the motion.
    motion, frequency
        The peak, and its frequency [Hz].
    options
        Harmonics and number of corrections.

    Returns
    -------
    ndarray
        Changes from the peak after each correction, shape (corrections, 2); not a number where
        there is none.
    """
    law = balance.joint.law
    highest = options.times * law.harmonics
    samples = max(options.finer * law.samples, 3 * highest)
    extended = AlternatingFrequencyTime(law.elements, highest, samples)
    more = replace(balance, joint=replace(balance.joint, law=extended))
    equations, y, phase = PhaseEquations.near(more, motion, frequency)
    precondition = _Preconditioner(balance, jacobian, motion, frequency, more)
    begin = _frequency_and_amplitude(equations, y)
    changes = np.zeros((0, 2))
    for _ in range(options.corrections):
        residual, derivative = equations.evaluate(y, phase)
        operator = LinearOperator(
            (y.size, y.size), lambda z, along=derivative.along: along(precondition(z)), dtype=float
        )
        if not np.all(np.isfinite(residual)):
            return np.full((1, 2), np.nan)
        correction, _ = gmres(
            operator, residual, rtol=options.tolerance, restart=options.iterations, maxiter=1
        )
        y = y - precondition(correction)
        change = _frequency_and_amplitude(equations, y) / begin - 1
        before = changes[-1] if len(changes) else np.zeros(2)
        changes = np.vstack([changes, change])
        if np.all(abs(change - before) <= options.settled * abs(change)):
            break
    return changes


def _frequency_and_amplitude(equations: PhaseEquations, y: Array) -> Array:
    """Frequency [rad/s] and amplitude of the output point [m] of an unknown."""
    x, w = equations.solution(y)
    return np.array([w, equations.output.value(x)])


def _without_contact(balance: HarmonicBalance, h: int, w: float) -> NDArray[np.complex128]:
    """``L - (hw)^2 + i H(hw)`` of the harmonic h, shape (modes, modes)."""
    return balance.complex_stiffness(w, h) - (h * w) ** 2 * np.eye(len(balance.stiffness))


class _Preconditioner:
    """Approximate solutions of the linear equations of more harmonics than those of a peak."""

    def __init__(
        self,
        balance: HarmonicBalance,
        jacobian: Array,
        motion: PeriodicMotion,
        frequency: float,
        more: HarmonicBalance,
    ) -> None:
        equations, y, phase = PhaseEquations.near(balance, motion, frequency)
        self._low, self._modes = y.size - 1, len(balance.stiffness)
        self._factors = lu_factor(equations.bordered(jacobian, y, phase))
        w = 2 * np.pi * frequency
        numbers = more.components.number.tolist()
        most = numbers[self._low // self._modes - 1]
        contact = stiffness_of_harmonic(jacobian, balance.components, most)
        contact -= _without_contact(balance, most, w)
        # sine and cosine of each harmonic beyond, one after another
        self._beyond = [
            lu_factor(_without_contact(more, h, w) + contact) for h in numbers if h > most
        ][::2]

    def __call__(self, right: Array) -> Array:
        """Approximate solution with a right side."""
        solution = np.empty_like(right)
        low = [*range(self._low), -1]
        solution[low] = lu_solve(self._factors, right[low])
        rows = right[self._low : -1].reshape(-1, 2, self._modes)
        found = solution[self._low : -1].reshape(-1, 2, self._modes)
        for factors, (s, c), place in zip(self._beyond, rows, found, strict=True):
            q = lu_solve(factors, s + 1j * c)
            place[:] = q.real, q.imag
        return solution
