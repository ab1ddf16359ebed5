import numpy as np
import pytest

from boltjoint.balance import HarmonicBalance
from boltjoint.partition import partition_regions


@pytest.fixture(params=["node-to-node", "regions"])
def balance(request, joint):
    return HarmonicBalance(
        joint if request.param == "node-to-node" else partition_regions(joint, 4), 0.01, 5.0
    )


def state(balance, size=1e-5):
    return size * np.random.default_rng(7).normal(size=balance.modal_force.size)


def test_jacobian_equals_differences(balance):
    x, w = state(balance), 600.0
    residual, jacobian = balance.residual_and_jacobian(x, w)
    np.testing.assert_array_equal(residual, balance.residual(x, w))
    for j in range(x.size):
        step = np.zeros(x.size)
        step[j] = 1e-10
        difference = (balance.residual(x + step, w) - balance.residual(x - step, w)) / 2e-10
        # relative to the stiffest entry; second differences of a force that is smooth twice
        np.testing.assert_allclose(jacobian[:, j], difference, atol=1e-6 * np.abs(jacobian).max())


def test_frequency_derivative_equals_differences(balance):
    x, w = state(balance), 600.0
    difference = (balance.residual(x, w + 0.01) - balance.residual(x, w - 0.01)) / 0.02
    np.testing.assert_allclose(
        balance.frequency_derivative(x, w), difference, atol=1e-8 * np.linalg.norm(difference)
    )


def test_stuck_solution_solves_the_equations_while_nothing_slips(balance):
    small = HarmonicBalance(balance.joint, balance.loss_factor, 1e-6)
    x = small.stuck_solution(500.0)
    assert np.all(small.joint.law.contact_state(small.motion(x)) == 0)
    residual = np.linalg.norm(small.residual(x, 500.0))
    assert residual < 1e-11 * np.linalg.norm(small.modal_force)


def test_stuck_solution_is_the_complex_linear_response(balance):
    w, joint = 500.0, balance.joint
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    dynamic = L * (1 + 1j * balance.loss_factor) - w**2 * np.eye(len(L)) + joint.stuck_stiffness()
    complex_amplitude = np.linalg.solve(dynamic, joint.excitation_mode * balance.excitation_force)
    sine, cosine = np.split(balance.stuck_solution(w), 2)
    # F sin(wt) = Im(F exp(iwt)): the sine coefficient is the real part
    np.testing.assert_allclose(sine + 1j * cosine, complex_amplitude, rtol=1e-10)


def test_residual_turns_with_the_phase(balance):
    w, x = 500.0, state(balance)
    free = HarmonicBalance(balance.joint, balance.loss_factor, 1e-300)
    c, s = np.cos(0.4), np.sin(0.4)

    def turned(vector):
        sine, cosine = np.split(vector, 2)
        return np.concatenate([c * sine - s * cosine, s * sine + c * cosine])

    np.testing.assert_allclose(
        free.residual(turned(x), w), turned(free.residual(x, w)), rtol=1e-9, atol=1e-9
    )


def test_residual_scales_with_force_slip_limit_and_motion(balance):
    """Twice the force on twice the slip limit moves twice as far."""
    from dataclasses import replace

    joint, w, x = balance.joint, 500.0, state(balance)
    law = replace(joint.law, slip_force=2 * joint.law.slip_force)
    double = HarmonicBalance(replace(joint, law=law), balance.loss_factor, 10.0)
    np.testing.assert_allclose(double.residual(2 * x, w), 2 * balance.residual(x, w), rtol=1e-12)


def test_secant_stiffness_gives_the_force_back(balance):
    x = state(balance)
    motion = balance.motion(x)
    stiffness = balance.secant_stiffness(x)[:, 0]
    force = stiffness * (motion[:, 0] + 1j * motion[:, 1])
    np.testing.assert_allclose(
        np.column_stack([force.real, force.imag]), balance.joint.law.force(motion), rtol=1e-12
    )
    # friction takes energy out; a stuck pair takes none, but for rounding
    assert stiffness.imag.min() > -1e-14 * stiffness.real.max()


def test_secant_stiffness_at_rest_is_that_of_the_springs(balance):
    at_rest = balance.secant_stiffness(np.zeros(balance.modal_force.size))
    np.testing.assert_array_equal(at_rest, balance.joint.law.stuck_stiffness(balance.joint.points))


def test_in_a_basis_the_equations_are_projected(balance):
    basis = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 2)))[0]
    reduced = HarmonicBalance(balance.joint, balance.loss_factor, 5.0, basis)
    V = np.kron(np.eye(2), basis)
    x, w = state(reduced), 600.0
    residual, jacobian = reduced.residual_and_jacobian(x, w)
    full_residual, full_jacobian = balance.residual_and_jacobian(V @ x, w)
    np.testing.assert_allclose(residual, V.T @ full_residual, rtol=1e-10)
    np.testing.assert_allclose(jacobian, V.T @ full_jacobian @ V, rtol=1e-9)
    np.testing.assert_allclose(
        reduced.frequency_derivative(x, w), V.T @ balance.frequency_derivative(V @ x, w), rtol=1e-12
    )
    np.testing.assert_allclose(
        reduced.secant_stiffness(x), balance.secant_stiffness(V @ x), rtol=1e-9
    )
