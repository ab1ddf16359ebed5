"""A half lap that nothing holds: harmonic balance against time integration and shooting."""

import numpy as np
import pytest
from examples import freed
from periodic_orbits import find_orbit

from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

LOSS_FACTOR, FORCE = 0.01, 60.0


@pytest.mark.parametrize("normal_stiffness", [None, 1e8])
def test_the_response_of_a_free_assembly_is_that_in_time(tiny, normal_stiffness):
    free = structure_of(freed(tiny))
    modes = find_modes(free, "free-3")
    joint = connect_nodes(modes, apply_preload(free, 8e3), 1e8, 0.1, normal_stiffness).distinct
    assert np.count_nonzero(joint.is_rigid) == 6
    response = solve_response(joint, [FORCE], damping=LOSS_FACTOR)
    frequency, motion = motion_at_peak(response, FORCE)
    excitation = frequency, FORCE, LOSS_FACTOR
    # higher than the stuck modes
    balance = solve_periodic(joint, *excitation, harmonics=33, samples=2048, start=motion)
    start = balance.in_time(1000)
    in_time = steady_state(joint, *excitation, start=start, steps=1000)
    orbit = find_orbit(joint, *excitation, start, steps=2000)
    assert balance.converged
    assert in_time.converged
    assert orbit.converged
    # a part of the joint slips, and that is the motion which is compared
    assert np.any(response["contact_state"].to_numpy() > 0)
    amplitude = abs(balance.amplitude(joint.response_mode))
    assert abs(in_time.amplitude) == pytest.approx(amplitude, rel=2e-4)
    elastic = ~joint.is_rigid
    for found in (in_time.motion, orbit.motion):
        expected = balance.in_time(len(found))
        largest = abs(expected).max(axis=0)
        # where contact closes between two samples, all three are off to first order
        for part, rounding in ((elastic, 1e-3), (~elastic, 1e-5)):
            error = abs(found - expected)[:, part].max(axis=0)
            assert np.all(error <= rounding * largest[part].max())
    assert abs(orbit.multipliers[0]) < 1
    # without damping, rigid bodies move as under the force alone
    rigid = FORCE * joint.excitation_mode[~elastic] / (2 * np.pi * frequency) ** 2
    np.testing.assert_allclose(abs(in_time.motion[:, ~elastic]).max(axis=0), abs(rigid), rtol=1e-9)
