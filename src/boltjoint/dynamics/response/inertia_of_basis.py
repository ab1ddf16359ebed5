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
from boltjoint.dynamics.response.amplitude_by_phase import LocatedPeak
from boltjoint.dynamics.response.left_out_harmonics import LeftOutHarmonics
from boltjoint.dynamics.response.phase_resonance import PhaseResonance
from boltjoint.joint.model import Joint

#: modes without contact this near in frequency, relative, are of a vector which they make
_NEAR = 0.01
#: share of them in a vector from which it is a mode
_IS_MODE = 0.999
#: error over the change: where a harmonic is at the frequency of a vector, that of one and of the
#: others moved peaks of small joints by up to twice as much
_SAFETY = 2.0


def count_modes(joint: Joint) -> int:
    """How many vectors of a basis, from the first, are modes of the structure without contact."""
    frequency = checks.instance("joint", joint, Joint).natural_frequency
    free, participation = joint.free_frequency, joint.free_participation
    if free is None or participation is None:
        return frequency.size
    near = abs(free[:, None] - frequency) < _NEAR * frequency
    # rigid-body modes are not among the free ones
    is_mode = ((participation**2 * near).sum(axis=0) > _IS_MODE) | joint.is_rigid
    return frequency.size if is_mode.all() else int(np.argmin(is_mode))


def inertia_error(
    resonance: PhaseResonance, peak: LocatedPeak, options: LeftOutHarmonics = LeftOutHarmonics()
) -> tuple[float, float]:
    """Relative errors of a peak by inertia of vectors that are no modes, in further harmonics.

    Where corrections do not converge, fewer vectors lose their inertia at once.

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
    modes, inertial = count_modes(balance.joint), balance.joint.natural_frequency.size
    motion, frequency, fewer = peak.motion, peak.frequency, resonance
    lost = inertial - modes
    while inertial > modes:
        left = max(inertial - lost, modes)
        partial = replace(balance, inertial=left)
        without = PhaseResonance(partial, frequency, motion, fewer=fewer, search=options.search)
        if (start := without.start()) is not None:
            (motion, frequency), inertial, fewer = start, left, without
        elif lost == 1:
            return np.nan, np.nan
        else:
            lost //= 2
    if fewer is resonance:
        return 0.0, 0.0
    mode = balance.joint.response_mode
    amplitude = abs(abs(motion.amplitude(mode) / peak.motion.amplitude(mode)) - 1)
    moved = peak.moved_by(amplitude, abs(fewer.slope_of_change(resonance, peak.phase)))
    change = abs(frequency / peak.frequency - 1) + moved
    return _SAFETY * float(change), _SAFETY * float(amplitude)
