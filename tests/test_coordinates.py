"""Response-dependent modes of a joint that moves along its surface and across it."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.balance import HarmonicBalance
from boltjoint.coordinates import pose
from boltjoint.friction.sampled import SampledInTime
from boltjoint.friction.states import STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.response import solve_branch

LOSS = 0.01


@pytest.fixture(params=["exact", "three harmonics"])
def variable(request):
    joint = make_joint(law="variable")
    if request.param == "exact":
        return joint
    return replace(joint, law=SampledInTime(joint.law, 3, samples=64))


def moved(joint):
    """A balance and amplitudes that make some points slip and some separate."""
    balance = HarmonicBalance(joint, LOSS, 5.0)
    x = 3e-5 * np.random.default_rng(7).normal(size=balance.modal_force.size)
    state = joint.law.contact_state(balance.motion(x))
    assert {STICK_SLIP, STICK_SLIP_SEPARATION} <= set(state)
    return balance, x


def secants(joint, x):
    """Complex force over displacement of each point, by direction, from the law alone."""
    names = joint.law.components
    q = dict(zip(names, x.reshape(len(names), -1), strict=True))
    modes = joint.tangential_mode, joint.normal_mode
    motion = np.column_stack([B @ q[name] for B in modes for name in names])
    force = joint.law.force(motion)
    found = []
    for d, B in enumerate(modes):
        begin = d * len(names)
        sine, cosine = begin + names.index("sin"), begin + names.index("cos")
        found.append((force[:, sine] + 1j * force[:, cosine]) / (B @ (q["sin"] + 1j * q["cos"])))
    return found


@pytest.mark.parametrize("force", [1.0, 20.0])
def test_all_response_dependent_modes_together_are_the_linear_ones(variable, force):
    full, same = (
        solve_branch(variable, force, loss_factor=LOSS, coordinates=coordinates)
        for coordinates in ("linear", "rdnm-3")
    )
    assert full.complete
    assert same.complete
    # Newton's steps do not depend on the basis: the two differ by rounding, amplified on the way
    assert same.frequency[same.peak] == pytest.approx(full.frequency[full.peak], rel=1e-9)
    assert same.amplitude[same.peak] == pytest.approx(full.amplitude[full.peak], rel=1e-9)
    np.testing.assert_allclose(same.frequency, full.frequency, rtol=1e-9)
    np.testing.assert_allclose(same.amplitude, full.amplitude, rtol=1e-9)
    np.testing.assert_allclose(
        same.modal_coordinate,
        full.modal_coordinate,
        atol=1e-9 * np.abs(full.modal_coordinate).max(),
    )


def test_secant_stiffness_of_each_direction_is_its_force_over_its_displacement(variable):
    balance, x = moved(variable)
    tangential, normal = secants(variable, x)
    # else swapped directions would pass, and springs that stick in place of secants
    stuck = variable.law.stuck_stiffness(variable.points)
    for found, wrong in ((tangential, normal), (tangential, stuck[:, 0]), (normal, stuck[:, 1])):
        assert np.linalg.norm(found - wrong) > 0.1 * np.linalg.norm(found)
    secant = balance.secant_stiffness(x)
    assert secant.shape == (variable.points, 2)
    # the same divisions in another order
    np.testing.assert_allclose(secant[:, 0], tangential, rtol=1e-10)
    np.testing.assert_allclose(secant[:, 1], normal, rtol=1e-10)


def test_response_dependent_modes_are_those_of_the_secants_of_both_directions(variable):
    balance, x = moved(variable)
    equations = pose("rdnm-3", balance, 1)
    equations.renew(equations.from_fixed(x), 500.0, np.zeros_like(x))
    tangential, normal = (k.real for k in secants(variable, x))
    R, N = variable.tangential_mode, variable.normal_mode
    L = np.diag((2 * np.pi * variable.natural_frequency) ** 2)
    projected = equations.basis.T @ (L + R.T * tangential @ R + N.T * normal @ N) @ equations.basis
    # eigenvectors make it diagonal to rounding
    off = projected - np.diag(np.diag(projected))
    assert np.abs(off).max() < 1e-11 * np.abs(projected).max()
    without_normal = equations.basis.T @ (L + R.T * tangential @ R) @ equations.basis
    off = without_normal - np.diag(np.diag(without_normal))
    assert np.abs(off).max() > 1e-3 * np.abs(projected).max()
