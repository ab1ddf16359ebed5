"""Modes at 0 Hz in time integration, shooting and Hill's method: closed forms, and without them."""

from dataclasses import replace

import numpy as np
import pytest
from folding_joint import DAMPING, WINDOW, make_folding_joint
from periodic_orbits import find_orbit
from small_joint import make_joint

from boltjoint.damping import ModalDamping, RayleighDamping
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

FREQUENCY, FORCE = 105.0, 20.0
#: of the rigid-body modes at the excitation and the output point
EXCITED, OBSERVED = np.array([0.8, -0.3]), np.array([2.2, 0.4])


def freed(joint):
    """The joint with two rigid-body modes before its own."""
    rows = joint.moved_as(lambda B: np.hstack([np.zeros((len(B), 2)), B]))
    return replace(
        joint,
        natural_frequency=np.append([0.0, 0.0], joint.natural_frequency),
        excitation_mode=np.append(EXCITED, joint.excitation_mode),
        response_mode=np.append(OBSERVED, joint.response_mode),
        **rows,
    )


@pytest.mark.parametrize("law", ["constant", "variable"])
@pytest.mark.parametrize("damping", [0.02, RayleighDamping(300.0, 1e-5)])
def test_rigid_body_motion_is_added_in_time_and_by_harmonics(law, damping):
    joint = make_joint(12, law=law)
    assert freed(joint).is_rigid.tolist() == [True, True, False, False, False]
    alone, free = (
        steady_state(each, FREQUENCY, FORCE, damping, steps=500) for each in (joint, freed(joint))
    )
    assert free.converged
    w = 2 * np.pi * FREQUENCY
    alpha = getattr(damping, "mass_coefficient", 0.0)
    rigid = FORCE * EXCITED / (1j * w * alpha - w**2)
    assert free.amplitude == pytest.approx(alone.amplitude + rigid @ OBSERVED, rel=1e-12)
    np.testing.assert_array_equal(free.motion[:, 2:], alone.motion)
    phase = 2 * np.pi * np.arange(free.steps) / free.steps
    expected = np.outer(np.exp(1j * phase), rigid).imag
    np.testing.assert_allclose(free.motion[:, :2], expected, atol=1e-12 * abs(rigid).max())
    balance = solve_periodic(freed(joint), FREQUENCY, FORCE, damping, harmonics=15)
    assert balance.converged
    # steps and samples are this fine
    found = balance.amplitude(freed(joint).response_mode)
    assert found == pytest.approx(free.amplitude, rel=1e-3)
    # rigid-body motion is much of it
    assert abs(rigid @ OBSERVED) > 0.05 * abs(free.amplitude)


def test_an_orbit_has_the_multipliers_of_elastic_motion():
    joint = make_folding_joint()
    response = solve_response(joint, [5.0], damping=DAMPING, resonance=Resonance(1, WINDOW))
    motion = solve_periodic(joint, 60.0, 5.0, DAMPING, harmonics=9)
    start = motion.in_time(500)
    at_rest = np.hstack([np.zeros((500, 2)), start])
    alone = find_orbit(joint, 60.0, 5.0, DAMPING, start, steps=500)
    free = find_orbit(freed(joint), 60.0, 5.0, DAMPING, at_rest, steps=500)
    assert alone.converged
    np.testing.assert_array_equal(free.multipliers, alone.multipliers)
    np.testing.assert_array_equal(free.motion[:, 2:], alone.motion)
    w = 2 * np.pi * 60.0
    np.testing.assert_allclose(abs(free.motion[:, :2]).max(axis=0), 5.0 * abs(EXCITED) / w**2)

    # the same marks at folds by Hill's method, where those of rigid-body motion would be 1
    moved = solve_response(freed(joint), [5.0], damping=DAMPING, resonance=Resonance(1, WINDOW))
    for each in (response, moved):
        assert each["turning_points"].item() == 2
    found, expected = (
        each["largest_multiplier"].to_numpy()[each["stable"].to_numpy() >= 0]
        for each in (moved, response)
    )
    assert (found < 1).any()
    assert (found > 1).any()
    assert found.min() == pytest.approx(expected.min(), abs=0.02)
    assert found.max() == pytest.approx(expected.max(), rel=0.02)


def test_damping_ratios_count_from_the_first_elastic_mode():
    joint = make_joint()
    ratios = ModalDamping((0.01, 0.03, 0.05))
    alone, free = (ratios.matrix(each.structure()).at(1.0) for each in (joint, freed(joint)))
    np.testing.assert_array_equal(free[2:, 2:], alone)
    assert not free[:2].any()
