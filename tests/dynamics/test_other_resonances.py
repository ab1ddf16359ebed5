"""Larger peaks of other resonances in the window of a synthesised response."""

import logging

import numpy as np
import pytest
from random_joints import random_joint

from boltjoint import frequency_window, solve_branch
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.windows import Resonance


@pytest.mark.parametrize(
    ("law", "index", "resonance"),
    [("constant", 130, 2), ("constant", 165, 2), ("variable", 187, 3)],
)
def test_a_larger_peak_of_another_resonance_in_the_window_is_told(law, index, resonance, caplog):
    joint, force, loss_factor = random_joint(law, index, seed=7171)
    window = frequency_window(joint)
    known = {"damping": loss_factor, "resonance": Resonance(1, window)}
    linear = solve_branch(joint, force, **known)
    assert linear.larger_resonance is None
    of_other = solve_branch(
        joint, force, "backbone", **known | {"resonance": Resonance(resonance, window)}
    )
    assert of_other.larger_resonance == 0
    assert of_other.peak_amplitude == pytest.approx(linear.peak_amplitude, rel=0.05)
    assert not caplog.records

    with caplog.at_level(logging.WARNING):
        first = solve_branch(joint, force, method="backbone", **known)
    assert first.complete
    assert first.larger_resonance == resonance
    assert first.peak_amplitude < 0.5 * linear.peak_amplitude
    told = f"{force:g} N: resonance {resonance} has a larger peak in the window"
    assert told in caplog.text


def test_the_result_says_which_resonance_is_larger():
    joint, force, loss_factor = random_joint("constant", 165, seed=7171)
    wide = {"damping": loss_factor, "resonance": Resonance(1, frequency_window(joint))}
    found = solve_response(joint, [force], method="backbone", **wide)
    np.testing.assert_array_equal(found["larger_resonance"], [2])
    linear = solve_response(joint, [force], **wide)
    np.testing.assert_array_equal(linear["larger_resonance"], [-1])
