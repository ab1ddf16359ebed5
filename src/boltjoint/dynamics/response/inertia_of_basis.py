"""What further harmonics ask of a contact-adapted basis: the inertia of vectors that are no modes.

Most vectors of such a basis are static shapes of the contact. Their inertia makes natural
frequencies that the structure does not have: far above the resonance, where it hardly counts in the
first harmonic, but among the further ones. A harmonic near such a frequency moves the peak: on a
lap of two bolts a vector at 2386 Hz of 40, which lies at 2077 Hz of 80, moved a peak at 146.4 Hz
by 0.1 %, beside its seventeenth harmonic. Without the inertia of these vectors in further harmonics
the peak is within 0.01 % of that of 80 vectors. How far it is moved by that tells how much of it
rests on inertia that the basis was not made for.
"""

from dataclasses import replace

import numpy as np

from boltjoint import checks
from boltjoint.dynamics.response.left_out_harmonics import LeftOutHarmonics
from boltjoint.dynamics.response.phase_resonance import LocatedPeak, PeakSearch, PhaseResonance
from boltjoint.joint.model import Joint

#: share of a mode without contact in a vector from which the vector is that mode
_IS_MODE = 0.999
#: error over the change: where a harmonic is at the frequency of a vector, that of one and of the
#: others moved peaks of small joints by up to twice as much
_SAFETY = 2.0


def count_modes(joint: Joint) -> int | None:
    """How many vectors of a basis, from the first, are modes without contact.

    None of a joint in such modes, whose vectors all are.
    """
    checks.instance("joint", joint, Joint)
    if joint.free_participation is None:
        return None
    share = (joint.free_participation**2).max(axis=0)
    # rigid-body modes are not among the free ones
    is_mode = (share > _IS_MODE) | joint.is_rigid
    return int(is_mode.size if is_mode.all() else np.argmin(is_mode))


def inertia_error(
    resonance: PhaseResonance, peak: LocatedPeak, options: LeftOutHarmonics = LeftOutHarmonics()
) -> tuple[float, float]:
    """Relative errors of a peak by inertia of vectors that are no modes, in further harmonics.

    Parameters
    ----------
    resonance
        Motions near the peak.
    peak
        The peak that they gave.
    options
        How the motion without that inertia is solved: tolerance and iterations.

    Returns
    -------
    tuple of float
        Of frequency and amplitude: twice the changes without it, 0 in a basis of modes; not a
        number where no such motion is near.
    """
    checks.instance("peak", peak, LocatedPeak)
    balance = checks.instance("resonance", resonance, PhaseResonance).balance
    modes = count_modes(balance.joint)
    if modes is None:
        return 0.0, 0.0
    search = PeakSearch(
        tolerance=options.tolerance, iterations=options.iterations, smallest_step=np.pi
    )
    balance = replace(balance, inertial=modes)
    without = PhaseResonance(balance, peak.frequency, peak.motion, fewer=resonance, search=search)
    start = without.start()
    if start is None:
        return np.nan, np.nan
    (motion, frequency), mode = start, balance.joint.response_mode
    amplitude = abs(abs(motion.amplitude(mode) / peak.motion.amplitude(mode)) - 1)
    moved = peak.moved_by(amplitude, abs(without.slope_of_change(resonance, peak.phase)))
    return _SAFETY * float(abs(frequency / peak.frequency - 1) + moved), _SAFETY * float(amplitude)
