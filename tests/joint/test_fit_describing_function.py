"""Misfit of describing functions."""

import numpy as np
from joint_examples import many_elements

from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.fit_jenkins import DescribingFunctionMisfit


def test_jacobian_of_harmonics_equals_differences():
    k, s = many_elements()
    harmonics = DescribingFunctionMisfit(k, s, 0.1)
    unknown = np.array([0.1, -0.4, 0.3, 0.0, 0.5, -0.2, 0.1, 0.7])
    for j in range(unknown.size):
        step = np.zeros(unknown.size)
        step[j] = 1e-6
        difference = (
            harmonics.residual(unknown + step) - harmonics.residual(unknown - step)
        ) / 2e-6
        jacobian = harmonics.jacobian(unknown)[:, j]
        # the derivative of the loss jumps where an element begins to slip
        np.testing.assert_allclose(jacobian, difference, atol=1e-6 * np.abs(jacobian).max())


def test_harmonics_compared_are_those_of_the_law():
    k, s = many_elements()
    harmonics = DescribingFunctionMisfit(k, s, 0.1)
    law = ConstantLoad(np.arange(k.size), k, s)
    for i in (0, 60, 119):
        amplitude = harmonics.amplitude[i]
        force = law.force(np.tile([amplitude, 0.0], (k.size, 1))).sum(axis=0)
        found = harmonics._target[[i, i + harmonics.amplitude.size]] * amplitude
        np.testing.assert_allclose(found, force, rtol=1e-10, atol=1e-12 * s.sum())
