"""Misfit of hysteresis loops."""

import numpy as np
from joint_examples import many_elements

from boltjoint.joint.fit_jenkins import LoopMisfit


def test_jacobian_equals_differences():
    k, s = many_elements()
    loops = LoopMisfit(k, s, np.array([1e-8, 5e-8, 2e-7]))
    unknown = np.array([0.1, -0.4, 0.3, 0.0, 0.5, -0.2, 0.1, 0.7])
    for j in range(unknown.size):
        step = np.zeros(unknown.size)
        step[j] = 1e-6
        difference = (loops.residual(unknown + step) - loops.residual(unknown - step)) / 2e-6
        np.testing.assert_allclose(loops.jacobian(unknown)[:, j], difference, atol=1e-8)
