"""Loading curves and hysteresis loops."""

import numpy as np
import pytest
from joint_examples import many_elements

from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.fit_jenkins import fit_elements
from boltjoint.joint.hysteresis import (
    amplitude_of_load,
    loading_curve,
    loop_error,
    unloading_branch,
)


def test_unloading_branch_has_the_harmonics_of_the_law():
    k, s = many_elements()
    amplitude = 5e-8
    phase = np.linspace(0, np.pi, 20001)
    force = unloading_branch(amplitude, amplitude * np.cos(phase), k, s)
    in_phase = 2 / np.pi * np.trapezoid(force * np.cos(phase), phase)
    quadrature = -2 / np.pi * np.trapezoid(force * np.sin(phase), phase)
    law = ConstantLoad(np.zeros(k.size, dtype=np.int64), k, s)
    # u = A cos: the sine coefficient is minus the part in phase with velocity
    expected = law.force(np.array([[0.0, amplitude]]))[0]
    np.testing.assert_allclose([-quadrature, in_phase], expected, rtol=1e-7)


def test_unloading_branch_closes_the_loop():
    k, s = many_elements()
    up, down = unloading_branch(1e-7, np.array([1e-7, -1e-7]), k, s)
    assert up == pytest.approx(-down)
    assert up == pytest.approx(loading_curve(np.array(1e-7), k, s))


def test_amplitude_of_load_inverts_the_loading_curve():
    k, s = many_elements()
    for fraction in (0.1, 0.5, 0.99):
        amplitude = amplitude_of_load(fraction, k, s)
        assert loading_curve(np.array(amplitude), k, s) == pytest.approx(fraction * s.sum())


def test_loop_error_is_found_on_the_loops():
    k, s = many_elements()
    fit = fit_elements(k, s, 4)
    few = fit.tangential_stiffness, fit.slip_force
    error = loop_error(k, s, *few)
    onset = s / k
    phase = np.pi * (np.arange(64) + 0.5) / 64
    largest, squares = 0.0, []
    for amplitude in np.geomspace(onset.min(), onset.max(), 120):
        for u in (amplitude * np.cos(phase), amplitude * np.linspace(-1, 1, 1000)):
            many, fitted = (unloading_branch(amplitude, u, *one) for one in ((k, s), few))
            difference = (fitted - many) / s.sum()
            largest = max(largest, np.abs(difference).max())
            if u.size == phase.size:
                squares.append(difference**2)
    assert error.rms == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-9)
    # the largest of the loops that were tried is that of some other amplitude at best
    assert 0.95 * error.largest < largest <= error.largest * (1 + 1e-9)


def test_loops_of_the_same_elements_do_not_differ():
    k, s = many_elements()
    error = loop_error(k, s, 2 * k[::2], s[::2] + s[1::2])
    assert error.largest > error.rms > 0
    same = loop_error(k, s, k[::-1], s[::-1])
    assert same.largest < 1e-13
