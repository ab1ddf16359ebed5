"""Superharmonic resonances of a joint whose second mode is near a multiple of the first."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import find_superharmonic, motion_at_peak
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.phase_resonance import find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime

LOSS, FORCE, HARMONICS = 0.01, 5.0, 5


def at_peak(second_frequency, force=FORCE, loss=LOSS):
    """Balance, motion and frequency at the peak of a joint by its second natural frequency."""
    joint = make_joint()
    joint = replace(joint, natural_frequency=np.array([70.0, second_frequency, 2000.0]))
    response = solve_response(joint, [force], damping=loss)
    peak = motion_at_peak(response, force)
    frequency, motion, *_ = find_peak(joint, peak[0], force, loss, peak[1], harmonics=HARMONICS)
    law = AlternatingFrequencyTime(joint.law, HARMONICS, 256)
    return HarmonicBalance(replace(joint, law=law), loss, force), motion, frequency


def superharmonic(balance, motion, frequency, **options):
    """The superharmonic resonance of a solution."""
    q = motion.in_components(balance.components).ravel()
    jacobian = balance.residual_and_jacobian(q, 2 * np.pi * frequency)[1]()
    return find_superharmonic(balance, jacobian, motion, frequency, **options)


def test_the_third_harmonic_is_largest_where_it_is_named():
    seconds = np.linspace(290.0, 350.0, 13)
    named, third = [], []
    for second in seconds:
        balance, motion, frequency = at_peak(second)
        found = superharmonic(balance, motion, frequency)
        named.append(found is not None and found.order == 3)
        amplitudes = motion.in_components(("sin3", "cos3"))
        first = motion.in_components(("sin", "cos"))
        third.append(np.linalg.norm(amplitudes) / np.linalg.norm(first))
        if named[-1]:
            assert found.frequency == pytest.approx(3 * frequency, rel=0.2)
            assert 0.5 * third[-1] < found.share < 2 * third[-1]
    named, third = np.array(named), np.array(third)
    assert named[np.argmax(third)]
    # on its flanks it is far below, and not named
    assert 0 < named.sum() < 0.5 * named.size
    assert np.max(third) > 2 * np.median(third[~named])


def test_what_sticks_has_no_harmonic_in_resonance():
    joint = make_joint()
    response = solve_response(joint, [1e-3], damping=LOSS)
    frequency, motion = motion_at_peak(response, 1e-3)
    law = AlternatingFrequencyTime(joint.law, HARMONICS, 256)
    balance = HarmonicBalance(replace(joint, law=law), LOSS, 1e-3)
    assert superharmonic(balance, motion, frequency) is None


def test_a_harmonic_beside_the_narrow_band_of_a_mode_is_in_resonance():
    # all slips, at 70 Hz; by the loss factor the band is 0.05 % wide on either side
    for second, is_named in ((211.0, True), (214.0, False)):
        balance, motion, frequency = at_peak(second, force=20.0, loss=1e-3)
        assert superharmonic(balance, motion, frequency, near=0.0) is None
        found = superharmonic(balance, motion, frequency)
        assert (found is not None) == is_named
        if is_named:
            assert found.order == 3 and found.frequency == pytest.approx(second, rel=1e-3)
