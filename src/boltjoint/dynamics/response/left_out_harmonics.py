"""What the harmonics that a peak leaves out would change: the estimate of its truncation error.

The contact forces of a motion with H harmonics have harmonics beyond H, which nothing balances. The
motion with several times as many, sought from it at the same phase of the output point, holds the
response of the structure with its contact to them. At a peak the amplitude does not change with
the phase to first order, so that its change at that phase is the one of the peak. Its frequency
does: by how much more the amplitude changes on one side of the peak than on the other, the peak
moves in the phase.

It has to be solved. Few corrections of the motion, by GMRES with a preconditioner that leaves the
harmonics beyond H uncoupled, told a change of 1e-5 where it is 4.6e-3: their residual stayed at
half of the force, as a harmonic beyond H was near a mode of the contact.

Where twice as many harmonics are solved, the next H of them may be near such a mode: 66 harmonics
changed a peak of 33 by 1.2e-4 that 99 change by 1.1e-3. Their acceleration is predicted from the
forces left over, each harmonic by itself; where it does not fall, they are solved too.

References
----------
A. Grolet, F. Thouverez: On a new harmonic selection technique for harmonic balance method.
Mechanical Systems and Signal Processing 30 (2012) 43-60.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response.amplitude_by_phase import LocatedPeak
from boltjoint.dynamics.response.phase_resonance import PeakSearch, PhaseResonance
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.harmonics import Components
from boltjoint.options import Options


@dataclass(frozen=True)
class LeftOutHarmonics(Options):
    """The motion at a peak with harmonics that it leaves out.

    Parameters
    ----------
    times
        Highest harmonic, over that of the peak: twice always, more where the accelerations of the
        next harmonics are predicted not to fall.
    finer
        Time samples a period over those of the peak, at least, so that the change holds their error
        too, which falls with their square.
    tolerance, iterations
        Residual of the equations over the force, and corrections at most; beyond them fewer
        harmonics are added at once.
    smallest_fall
        Predicted acceleration of the next harmonics over that of the last as many, from which the
        next are solved too. The prediction leaves couplings of harmonics out and was too low by a
        factor of up to six; motion without resonances, by forces that fall with the square of the
        harmonic, has a third.
    safety
        Factor of the largest change, for what further harmonics would add: the change by three
        times the harmonics was up to 2.5 times that by twice as many, on three assemblies of two to
        five bolts.
    """

    times: int = 3
    finer: int = 2
    tolerance: float = 1e-5
    iterations: int = 30
    smallest_fall: float = 0.5
    safety: float = 3.0

    def __post_init__(self) -> None:
        """Refuse options without further harmonics."""
        checks.whole("times", self.times, at_least=2)
        for name in ("finer", "iterations"):
            checks.whole(name, getattr(self, name), at_least=1)
        for name in ("tolerance", "smallest_fall", "safety"):
            checks.number(name, getattr(self, name), above=0)

    @property
    def search(self) -> PeakSearch:
        """The search of a motion, without solutions between, which would take as long again."""
        return PeakSearch(tolerance=self.tolerance, iterations=self.iterations, smallest_step=np.pi)


class LeftOutChange(NamedTuple):
    """Relative changes of frequency and amplitude of a peak at its phase, without sign.

    ``slope``: derivative of the amplitude's by the phase [1/rad], which moves the peak; not a
    number where it is not known. All are where the motion is not found.
    """

    frequency: float = np.nan
    amplitude: float = np.nan
    slope: float = np.nan


def change_by_left_out_harmonics(
    resonance: PhaseResonance,
    peak: LocatedPeak,
    options: LeftOutHarmonics = LeftOutHarmonics(),
) -> LeftOutChange:
    """Relative changes of frequency and amplitude of a peak with further harmonics.

    Parameters
    ----------
    resonance
        Motions near the peak, by AFT.
    peak
        The peak that they gave.
    options
        Harmonics, and how they are solved.

    Returns
    -------
    LeftOutChange
        The largest; not a number where the motion is not found, or so far from the peak that an
        error bar would be as large as that.
    """
    balance = checks.instance("resonance", resonance, PhaseResonance).balance
    checks.instance("peak", peak, LocatedPeak)
    law = checks.instance("law of the balance", balance.joint.law, AlternatingFrequencyTime)
    mode = balance.joint.response_mode
    before = np.array([peak.frequency, abs(peak.motion.amplitude(mode))])
    motion, frequency = peak.motion, peak.frequency
    changes: list[NDArray[np.float64]] = []
    for times in range(2, options.times + 1):
        finer = options.finer, options.finer + 1
        more = [_with_times(balance, law, times, samples=one * law.samples) for one in finer]
        if times > 2 and _fall(more[0], motion, frequency, law.harmonics) < options.smallest_fall:
            break
        # where sliders stop near a sample there may be none, but one with other samples
        at = motion, frequency, options
        tried = (with_more_harmonics(each, *at, fewer=resonance) for each in more)
        if (found := next(filter(None, tried), None)) is None:
            return LeftOutChange()
        motion, frequency, at_phases = found
        after = np.array([frequency, abs(motion.amplitude(mode))])
        changes.append(abs(after / before - 1))
        if options.safety * changes[-1][1] >= 1:
            return LeftOutChange()
        if times == 2:
            slope = abs(at_phases.slope_of_change(resonance, peak.phase))
    largest = np.max(changes, axis=0)
    if amplitude := changes[0][1]:
        # as the amplitudes at all phases
        slope *= largest[1] / amplitude
    return LeftOutChange(float(largest[0]), float(largest[1]), float(slope))


def _with_times(
    balance: HarmonicBalance, law: AlternatingFrequencyTime, times: int, samples: int
) -> HarmonicBalance:
    """A balance with several times its harmonics, and samples, as many as these need at least."""
    harmonics = times * law.harmonics
    extended = AlternatingFrequencyTime(law.elements, harmonics, max(samples, 4 * harmonics))
    return replace(balance, joint=replace(balance.joint, law=extended))


def with_more_harmonics(
    balance: HarmonicBalance,
    motion: PeriodicMotion,
    frequency: float,
    options: LeftOutHarmonics,
    *,
    fewer: PhaseResonance | None = None,
) -> tuple[PeriodicMotion, float, PhaseResonance] | None:
    """A motion with the harmonics of a balance at the same phase, and its frequency [Hz].

    Where corrections do not converge, fewer harmonics are added at once: 33 at once took 77
    corrections on three bolts, from residuals that grew to a hundred times the force.

    Parameters
    ----------
    balance
        In linear modes, with AFT.
    motion, frequency
        With fewer harmonics, and its frequency [Hz].
    options
        How it is solved.
    fewer
        Motions at other phases, whose changes with it are those to expect.

    Returns
    -------
    tuple or None
        Motion, frequency [Hz], and the motions at other phases; None where it is not found.
    """
    law = checks.instance("law of the balance", balance.joint.law, AlternatingFrequencyTime)
    highest = Components(motion.components).highest
    added = law.harmonics - highest
    while True:
        partial = replace(law, harmonics=min(highest + added, law.harmonics))
        with_some = replace(balance, joint=replace(balance.joint, law=partial))
        resonance = PhaseResonance(with_some, frequency, motion, fewer=fewer, search=options.search)
        start = resonance.start()
        if start is not None:
            motion, frequency = start
            highest = partial.harmonics
            if highest == law.harmonics:
                return motion, frequency, resonance
        elif added == 1:
            return None
        else:
            added //= 2


def _fall(balance: HarmonicBalance, motion: PeriodicMotion, frequency: float, count: int) -> float:
    """Predicted acceleration of harmonics beyond those of a motion, over that of its last ones.

    Each further harmonic is moved by the forces of the motion alone, against the structure and the
    mean stiffness of the contact, as slip of the motion leaves it.

    Parameters
    ----------
    balance
        With the further harmonics.
    motion, frequency
        Without them, and its frequency [Hz].
    count
        How many harmonics are its last.
    """
    components, w = balance.components, 2 * np.pi * frequency
    q = motion.in_components(components)
    force, tangent = balance.contact.force_and_tangent(q.ravel(), w)
    force = components.rows(force)
    _, sin, cos = components.harmonics[-1]
    modes = q.shape[1]
    contact = np.empty((modes, modes), dtype=complex)
    for mode in range(modes):
        unit = np.zeros_like(q)
        unit[sin, mode] = 1.0
        along = components.rows(tangent.along(unit.ravel()))
        contact[:, mode] = along[sin] + 1j * along[cos]
    last = Components(motion.components).highest
    squares = np.zeros(2)
    for h, sin, cos in components.harmonics:
        if h > last:
            inertia = (h * w) ** 2 * np.eye(modes)
            stiffness = balance.complex_stiffness(w, h) + contact - inertia
            amplitude = np.linalg.solve(stiffness, force[sin] + 1j * force[cos])
        else:
            amplitude = q[sin] + 1j * q[cos]
        if h > last - count:
            squares[int(h > last)] += np.linalg.norm(h**2 * amplitude) ** 2
    return float(np.sqrt(squares[1] / squares[0])) if squares[0] else np.inf
