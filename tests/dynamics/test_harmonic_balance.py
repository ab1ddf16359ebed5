from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from harmonic_names import parse_component
from scipy.optimize import fsolve
from small_joint import make_joint

from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import energy_per_period
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.derived import merge_points
from boltjoint.joint.model import Joint
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

LOSS = 0.01


def merged(joint):
    return merge_points(joint, np.repeat([0, 1, 2, 3], 15))


def sampled(joint):
    return replace(joint, law=AlternatingFrequencyTime(joint.law, 3))


@pytest.fixture(params=["node-to-node", "regions"])
def balance(request, joint):
    return HarmonicBalance(joint if request.param == "node-to-node" else merged(joint), 0.01, 5.0)


@pytest.fixture(params=["constant", "constant-3", "variable", "variable-3", "variable-regions"])
def any_balance(request, joint):
    """Of either law, in closed form and by AFT with three harmonics, and with merged points."""
    made = make_joint(law="variable") if "variable" in request.param else joint
    made = sampled(made) if "3" in request.param else made
    return HarmonicBalance(merged(made) if "regions" in request.param else made, 0.01, 5.0)


def state(balance, size=1e-5):
    return size * np.random.default_rng(7).normal(size=balance.modal_force.size)


def test_jacobian_equals_differences(any_balance):
    balance, w = any_balance, 600.0
    x = state(balance, 3e-5)
    assert np.unique(balance.joint.law.contact_state(balance.motion(x))).size > 1
    residual, form_jacobian = balance.residual_and_jacobian(x, w)
    jacobian = form_jacobian()
    np.testing.assert_array_equal(residual, balance.residual(x, w))
    for j in range(x.size):
        step = np.zeros(x.size)
        step[j] = 1e-10
        difference = (balance.residual(x + step, w) - balance.residual(x - step, w)) / 2e-10
        # relative to the stiffest entry; second differences of a force that is smooth twice
        np.testing.assert_allclose(jacobian[:, j], difference, atol=1e-6 * np.abs(jacobian).max())
    along = np.random.default_rng(8).normal(size=x.size)
    tangent = balance.joint.law.evaluate_with_tangent(balance.motion(x), 0.0)[1]
    change = balance.change(along, w, tangent)
    np.testing.assert_allclose(change, jacobian @ along, rtol=1e-9)


def test_frequency_derivative_equals_differences(any_balance):
    balance, w = any_balance, 600.0
    x = state(balance)
    difference = (balance.residual(x, w + 0.01) - balance.residual(x, w - 0.01)) / 0.02
    np.testing.assert_allclose(
        balance.frequency_derivative(x, w), difference, atol=1e-8 * np.linalg.norm(difference)
    )


def test_every_harmonic_is_a_linear_structure_at_its_frequency(any_balance):
    balance, w = any_balance, 600.0
    L = np.diag((2 * np.pi * balance.joint.natural_frequency) ** 2)
    x = state(balance)
    part = dict(zip(balance.components, x.reshape(len(balance.components), -1), strict=True))
    left = balance.dynamic_stiffness(w) @ x
    left = dict(zip(balance.components, left.reshape(len(balance.components), -1), strict=True))
    for name in balance.components:
        what, harmonic = parse_component(name)
        if what == "bias":
            np.testing.assert_allclose(left[name], L @ part[name], rtol=1e-12)
        if what == "sin":
            cosine = f"cos{name[3:]}"
            dynamic = L * (1 + 1j * LOSS) - (harmonic * w) ** 2 * np.eye(3)
            expected = dynamic @ (part[name] + 1j * part[cosine])
            np.testing.assert_allclose(left[name] + 1j * left[cosine], expected, rtol=1e-12)


def test_a_joint_that_sticks_has_no_higher_harmonics(joint):
    linear = HarmonicBalance(sampled(joint), 0.01, 1e-6)
    x = linear.stuck_solution(500.0)
    assert linear.components == ("sin", "cos", "sin3", "cos3")
    np.testing.assert_array_equal(x[6:], 0)
    alone = HarmonicBalance(joint, 0.01, 1e-6).stuck_solution(500.0)
    np.testing.assert_allclose(x[:6], alone, rtol=1e-12)
    residual = np.linalg.norm(linear.residual(x, 500.0))
    assert residual < 1e-11 * np.linalg.norm(linear.modal_force)


def integrated_period(joint, force, w, start, steps):
    """A period of one mode on one element, by Runge-Kutta steps with the slider moved between."""
    R, N = (joint.rows[0][0, 0], joint.rows[-1][0, 0])
    law = joint.law
    k_u, stiffness = law.tangential_stiffness[0], (2 * np.pi * joint.natural_frequency[0]) ** 2
    if law.name == "constant":
        k_v, load, mu = 0.0, 1.0, law.slip_force[0]
    else:
        k_v, load, mu = law.normal_stiffness[0], law.normal_load[0], law.friction_coefficient[0]
    q, v, z = start
    h = 2 * np.pi / w / steps

    def acceleration(t, q):
        n = max(load + k_v * N * q, 0.0)
        friction = min(max(k_u * R * q - z, -mu * n), mu * n)
        contact = R * friction + N * (n - max(load, 0.0))
        return joint.excitation_mode[0] * force * np.sin(w * t) - stiffness * q - contact

    path = np.empty(steps)
    for i in range(steps):
        path[i], t = q, i * h
        a = acceleration(t, q)
        b = acceleration(t + h / 2, q + h / 2 * v)
        c = acceleration(t + h / 2, q + h / 2 * v + h**2 / 4 * a)
        d = acceleration(t + h, q + h * v + h**2 / 2 * b)
        x_before, n_before = k_u * R * q, load + k_v * N * q
        q, v = q + h * v + h**2 / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)
        x, n = k_u * R * q, load + k_v * N * q
        if n > 0 >= n_before:
            z = x_before + (x - x_before) * n_before / (n_before - n)
        z = min(max(z, x - mu * max(n, 0)), x + mu * max(n, 0))
    return np.array([q, v, z]), path


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_with_more_harmonics_the_balance_approaches_time_integration(law):
    """A cantilever on one element, against the periodic solution of its equation of motion."""
    force, w, steps = 40.0, 2 * np.pi * 95.0, 1000
    on, k_u = np.zeros(1, dtype=np.int64), np.array([3e7])
    cantilever = Joint(
        natural_frequency=np.array([70.0]),
        excitation_mode=np.array([2.0]),
        response_mode=np.array([2.0]),
        tangential_mode=np.array([[0.06]]),
        position=np.zeros((1, 3)),
        element_position=np.zeros((1, 3)),
        normal_mode=None if law == "constant" else np.array([[0.05]]),
        law=ConstantLoad(on, k_u, np.array([20.0]))
        if law == "constant"
        else VariableLoad(on, k_u, np.array([2e6]), np.array([8.0]), np.array([0.3])),
    )
    phase = 2 * np.pi * np.arange(steps) / steps

    def solved(harmonics):
        """The solution without structural loss, of which there is none in time."""
        made = replace(
            cantilever, law=AlternatingFrequencyTime(cantilever.law, harmonics, samples=2048)
        )
        balance = HarmonicBalance(made, 0.0, force)
        start = balance.stuck_solution(w)
        solution, _ = newton(
            BalanceEquations(balance), start, w, StepControl(maximum_iterations=50)
        )
        assert solution.converged
        assert balance.joint.law.contact_state(balance.motion(solution.x)) == (
            1 if law == "constant" else 2
        )
        of = {"bias": lambda _, t: np.ones_like(t), "sin": lambda h, t: np.sin(h * t)}
        of["cos"] = lambda h, t: np.cos(h * t)
        parts = [parse_component(name) for name in balance.components]
        return sum(x * of[what](h, phase) for x, (what, h) in zip(solution.x, parts, strict=True))

    first = solved(9)
    start = np.array([first[0], (first[1] - first[-1]) * steps * w / (4 * np.pi), 0.0])
    start[2] = integrated_period(cantilever, force, w, start, steps)[0][2]
    scale = np.abs(first).max() * np.array([1, w, k_u[0] * 0.06])

    def miss(start):
        return (integrated_period(cantilever, force, w, start * scale, steps)[0]) / scale - start

    periodic = fsolve(miss, start / scale, xtol=1e-10) * scale
    _, path = integrated_period(cantilever, force, w, periodic, steps)
    error = [np.linalg.norm(solved(h) - path) / np.linalg.norm(path) for h in (1, 5, 9)]
    # those of the force fall with the square of their number, of the motion with the fourth power
    assert error[0] > 1e-4
    assert error[1] < 5e-5
    assert error[2] < 1e-5


def test_stuck_solution_solves_the_equations_while_nothing_slips(balance):
    small = HarmonicBalance(balance.joint, balance.damping, 1e-6)
    x = small.stuck_solution(500.0)
    assert np.all(small.joint.law.contact_state(small.motion(x)) == 0)
    residual = np.linalg.norm(small.residual(x, 500.0))
    assert residual < 1e-11 * np.linalg.norm(small.modal_force)


def test_stuck_solution_is_the_complex_linear_response(balance):
    w, joint = 500.0, balance.joint
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    dynamic = L * (1 + 1j * LOSS) - w**2 * np.eye(len(L)) + joint.stuck_stiffness()
    complex_amplitude = np.linalg.solve(dynamic, joint.excitation_mode * balance.excitation_force)
    sine, cosine = np.split(balance.stuck_solution(w), 2)
    # F sin(wt) = Im(F exp(iwt)): the sine coefficient is the real part
    np.testing.assert_allclose(sine + 1j * cosine, complex_amplitude, rtol=1e-10)


def test_residual_turns_with_the_phase(balance):
    w, x = 500.0, state(balance)
    free = HarmonicBalance(balance.joint, balance.damping, 1e-300)
    c, s = np.cos(0.4), np.sin(0.4)

    def turned(vector):
        sine, cosine = np.split(vector, 2)
        return np.concatenate([c * sine - s * cosine, s * sine + c * cosine])

    np.testing.assert_allclose(
        free.residual(turned(x), w), turned(free.residual(x, w)), rtol=1e-9, atol=1e-9
    )


def test_residual_scales_with_force_slip_limit_and_motion(balance):
    """Twice the force on twice the slip limit moves twice as far."""
    joint, w, x = balance.joint, 500.0, state(balance)
    law = replace(joint.law, slip_force=2 * joint.law.slip_force)
    double = HarmonicBalance(replace(joint, law=law), balance.damping, 10.0)
    np.testing.assert_allclose(double.residual(2 * x, w), 2 * balance.residual(x, w), rtol=1e-12)


def test_describing_function_gives_the_force_back(balance):
    x = state(balance)
    motion = balance.motion(x)
    stiffness = balance.describing_function(x, 0.0)[:, 0]
    force = stiffness * (motion[:, 0] + 1j * motion[:, 1])
    np.testing.assert_allclose(
        np.column_stack([force.real, force.imag]), balance.joint.law.force(motion), rtol=1e-12
    )
    # friction takes energy out; a stuck pair takes none, but for rounding
    assert stiffness.imag.min() > -1e-14 * stiffness.real.max()


def test_describing_function_at_rest_is_that_of_the_springs(balance):
    at_rest = balance.describing_function(np.zeros(balance.modal_force.size), 0.0)
    np.testing.assert_array_equal(at_rest, balance.joint.law.stuck_stiffness(balance.joint.points))


def test_in_a_basis_the_equations_are_projected(any_balance):
    balance = any_balance
    basis = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 2)))[0]
    reduced = HarmonicBalance(balance.joint, balance.damping, 5.0, basis)
    V = np.kron(np.eye(len(balance.components)), basis)
    x, w = state(reduced), 600.0
    residual, jacobian = reduced.residual_and_jacobian(x, w)
    full_residual, full_jacobian = balance.residual_and_jacobian(V @ x, w)
    np.testing.assert_allclose(residual, V.T @ full_residual, rtol=1e-10)
    np.testing.assert_allclose(jacobian(), V.T @ full_jacobian() @ V, rtol=1e-9)
    np.testing.assert_allclose(
        reduced.frequency_derivative(x, w), V.T @ balance.frequency_derivative(V @ x, w), rtol=1e-12
    )
    np.testing.assert_allclose(
        reduced.describing_function(x, 0.0), balance.describing_function(V @ x, 0.0), rtol=1e-9
    )


def test_work_is_what_forces_do_over_a_period(any_balance):
    balance, x = any_balance, state(any_balance, 3e-5)
    t = 2 * np.pi * np.arange(64) / 64
    of = {"bias": lambda _: np.ones_like(t), "sin": lambda h: np.sin(h * t)}
    of["cos"] = lambda h: np.cos(h * t)
    rate = {"bias": lambda _: 0 * t, "sin": lambda h: h * np.cos(h * t)}
    rate["cos"] = lambda h: -h * np.sin(h * t)
    parts = [parse_component(name) for name in balance.components]

    def in_time(amplitudes, functions):
        rows = amplitudes.reshape(len(parts), -1)
        return sum(
            np.outer(functions[what](h), row) for (what, h), row in zip(parts, rows, strict=True)
        )

    velocity = in_time(x, rate)
    w = 600.0
    lossless = replace(balance, damping=0.0)
    contact = replace(balance, damping=0.0, excitation_force=1e-300)
    friction = contact.residual(x, w) - contact.dynamic_stiffness(w) @ x
    dissipated = (balance.dynamic_stiffness(w) - lossless.dynamic_stiffness(w)) @ x
    forces = balance.modal_force, dissipated, friction
    # the trapezoidal rule is exact for trigonometric functions of few harmonics
    expected = [np.sum(in_time(force, of) * velocity) * 2 * np.pi / t.size for force in forces]
    assert energy_per_period(balance, x, w) == pytest.approx(expected, rel=1e-10)
    assert min(map(abs, expected)) > 1e-6 * max(map(abs, expected))


def test_secants_are_forces_over_displacements(any_balance):
    balance, x = any_balance, state(any_balance, 3e-5)
    motion = balance.motion(x)
    force = balance.joint.law.force(motion)
    secant = balance.contact.describing_function(motion, force)
    np.testing.assert_array_equal(secant, balance.describing_function(x, 0.0))
    names = balance.components
    for d in range(len(balance.contact.rows)):
        sin, cos = (d * len(names) + names.index(name) for name in ("sin", "cos"))
        u, f = (part[:, sin] + 1j * part[:, cos] for part in (motion, force))
        np.testing.assert_allclose(secant[:, d] * u, f, rtol=1e-12)


def test_derivative_of_the_secants_equals_differences(any_balance):
    balance = any_balance
    motion = balance.motion(state(balance, 3e-5))
    law, directions, n = balance.joint.law, len(balance.contact.rows), len(balance.components)
    force, tangent = law.force_and_tangent(motion)
    contact = balance.contact
    D = contact.describing_function(motion, force)
    exact = contact.describing_function_derivative(motion, D, tangent)
    assert exact.shape == (len(motion), directions, directions, n)

    def secants(moved):
        return balance.contact.describing_function(moved, law.force(moved))

    largest = np.abs(exact).max(axis=(1, 2, 3))
    for column in range(directions * n):
        step = 1e-7 * np.abs(motion).max(axis=1)
        change = np.zeros_like(motion)
        change[:, column] = step
        near = (secants(motion + change) - secants(motion - change)) / (2 * step[:, None])
        found = exact[:, :, column // n, column % n]
        # second differences relative to the largest entry; few points stand at a change of state
        wrong = np.abs(near - found) > 1e-5 * np.maximum(largest, largest.mean())[:, None]
        assert not wrong.any()
    assert np.abs(exact.imag).max() > 0.01 * np.abs(exact).max()


def test_secants_of_points_at_rest_do_not_change(any_balance):
    balance = any_balance
    motion = np.zeros_like(balance.motion(state(balance)))
    force, tangent = balance.joint.law.force_and_tangent(motion)
    secant = balance.contact.describing_function(motion, force)
    np.testing.assert_array_equal(secant, balance.joint.law.stuck_stiffness(len(motion)))
    assert not balance.contact.describing_function_derivative(motion, secant, tangent).any()


def test_stiffness_with_springs_is_that_of_the_modes_they_strain(any_balance):
    balance = any_balance
    L = np.diag((2 * np.pi * balance.joint.natural_frequency) ** 2)
    stuck = balance.joint.law.stuck_stiffness(balance.joint.points)
    springs = balance.contact.spring_stiffness
    np.testing.assert_allclose(springs(stuck), balance.joint.stuck_stiffness(), rtol=1e-12)
    secant = balance.describing_function(state(balance, 3e-5), 0.0)
    matrix = balance.complex_stiffness(600.0) + springs(secant)
    expected = L * (1 + 1j * LOSS)
    for point in range(balance.joint.points):
        for d, B in enumerate(balance.joint.rows):
            expected += secant[point, d] * np.outer(B[point], B[point])
    np.testing.assert_allclose(matrix, expected, rtol=1e-12)
    # symmetric, not Hermitian
    np.testing.assert_allclose(matrix, matrix.T, rtol=1e-12)
    assert np.abs(matrix.imag).max() > 1e-3 * np.abs(matrix).max()


def test_weighted_products_say_how_the_force_of_the_secants_changes(any_balance):
    balance = any_balance
    x, shape = state(balance, 3e-5), np.array([0.3, -0.8, 0.5])
    motion = balance.motion(x)
    force, tangent = balance.joint.law.force_and_tangent(motion)
    contact = balance.contact
    D = contact.describing_function(motion, force)
    weight = contact.describing_function_derivative(motion, D, tangent).real
    exact = contact.spring_force_derivative(shape, weight)
    assert exact.shape == (3, x.size)

    def strained(x):
        return balance.contact.spring_stiffness(balance.describing_function(x, 0.0).real) @ shape

    step = 1e-10
    near = [(strained(x + h) - strained(x - h)) / (2 * step) for h in step * np.eye(x.size)]
    # second differences of a secant that is smooth but where the state changes
    np.testing.assert_allclose(np.column_stack(near), exact, atol=1e-6 * np.abs(exact).max())


def test_contact_that_is_given_takes_the_place_of_the_law(any_balance):
    balance, w = any_balance, 600.0
    x = state(balance)
    motion = balance.motion(x)
    springs = balance.joint.law.stuck_stiffness(balance.joint.points)
    n = len(balance.components)
    diagonal = np.repeat(springs, n, axis=1)
    tangent = diagonal[:, :, None] * np.eye(diagonal.shape[1])
    residual, form_jacobian = balance.assemble(x, w, diagonal * motion, tangent)
    stuck = np.kron(np.eye(n), balance.joint.stuck_stiffness())
    linear = balance.dynamic_stiffness(w) + stuck
    np.testing.assert_allclose(form_jacobian(), linear, atol=1e-12 * np.abs(linear).max())
    np.testing.assert_allclose(
        residual,
        linear @ x - balance.modal_force,
        atol=1e-12 * np.abs(linear).max() * np.abs(x).max(),
    )


@pytest.mark.parametrize("law", ["constant", "variable"])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_with_many_modes_the_jacobian_is_that_of_few_in_every_basis(law, harmonics):
    """Tangents are taken to many modes in another way, by the points that do not stick."""
    joint, random = make_joint(law=law), np.random.default_rng(4)
    few, many = 3, 20
    turn = np.linalg.qr(random.normal(size=(many, many)))[0][:, :few]
    joint = replace(
        joint,
        natural_frequency=np.geomspace(70.0, 5000.0, many),
        excitation_mode=random.normal(size=many),
        response_mode=random.normal(size=many),
        tangential_mode=joint.tangential_mode @ turn.T,
        normal_mode=None if law == "constant" else joint.normal_mode @ turn.T,
    )
    joint = sampled(joint) if harmonics == 3 else joint
    balance = HarmonicBalance(joint, 0.01, 5.0)
    x, w = state(balance, 1e-5), 600.0
    assert np.unique(joint.law.contact_state(balance.motion(x))).size > 1
    jacobian = balance.residual_and_jacobian(x, w)[1]()
    assert jacobian.shape == (x.size, x.size)
    tangent = joint.law.force_and_tangent(balance.motion(x))[1]
    # in a basis of few modes, by products of them; pairs of such bases hold every two modes
    several = np.split(np.linalg.qr(random.normal(size=(many, many)))[0], 5, axis=1)
    for one, other in combinations(several, 2):
        reduced = replace(balance, basis=np.hstack([one, other]))
        V = np.kron(np.eye(len(balance.components)), reduced.basis)
        _, projected = reduced.assemble(V.T @ x, w, np.zeros(tangent.shape[:2]), tangent)
        np.testing.assert_allclose(
            V.T @ jacobian @ V, projected(), atol=1e-12 * np.abs(jacobian).max()
        )
