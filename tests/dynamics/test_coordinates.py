"""Modes that depend on the response, of joints that move along their surface and across it."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.continuation import LoadStepping
from boltjoint.dynamics.response.frequency_response import method_of, solve_branch
from boltjoint.dynamics.response.methods import ResponseDependentModes
from boltjoint.dynamics.response.rdnm import LaggedRDNM, SelfConsistentRDNM
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.contact_states import STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.solvers.arc_length import trace
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl

LOSS = 0.01
W = 600.0
LAWS = ("constant", "variable", "constant, three harmonics", "variable, three harmonics")


def joint_of(law):
    name, *sampled = law.split(", ")
    joint = make_joint(law=name)
    return (
        replace(joint, law=AlternatingFrequencyTime(joint.law, 3, samples=64)) if sampled else joint
    )


@pytest.fixture(params=["exact", "three harmonics"])
def variable(request):
    return joint_of("variable" if request.param == "exact" else f"variable, {request.param}")


@pytest.fixture(params=["constant", "variable"])
def either(request):
    return joint_of(request.param)


@pytest.fixture(params=LAWS)
def any_joint(request):
    return joint_of(request.param)


def moved(joint):
    """A balance and amplitudes that make some points slip and, where they may, some separate."""
    balance = HarmonicBalance(joint, LOSS, 5.0)
    x = 3e-5 * np.random.default_rng(7).normal(size=balance.modal_force.size)
    state = joint.law.contact_state(balance.motion(x))
    separate = {STICK_SLIP_SEPARATION} if joint.normal_mode is not None else set()
    assert {STICK_SLIP, *separate} <= set(state)
    return balance, x


def differences(function, x, step):
    """Central differences of a function, one column for each entry of x."""
    columns = [(function(x + h) - function(x - h)) / (2 * step) for h in step * np.eye(x.size)]
    return np.column_stack(columns)


def distance(x, y):
    """Of two states, as a share of the second."""
    return np.linalg.norm(x - y) / np.linalg.norm(y)


def secants(joint, x):
    """Complex force over displacement of each point, by direction, from the law alone."""
    names = joint.law.components
    q = dict(zip(names, x.reshape(len(names), -1), strict=True))
    motion = np.column_stack([B @ q[name] for B in joint.rows for name in names])
    force = joint.law.force(motion)
    found = []
    for d, B in enumerate(joint.rows):
        begin = d * len(names)
        sine, cosine = begin + names.index("sin"), begin + names.index("cos")
        found.append((force[:, sine] + 1j * force[:, cosine]) / (B @ (q["sin"] + 1j * q["cos"])))
    return found


def stiffness_with(joint, secants):
    """That of the structure with springs at its contact points."""
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    return L + sum(B.T * k @ B for B, k in zip(joint.rows, secants, strict=True))


@pytest.mark.parametrize(
    ("law", "coordinates", "basis_update", "force"),
    [
        ("variable", "rdnm-3", "implicit", 20.0),
        ("variable", "rdnm-3", "lagged", 20.0),
        ("variable", "complex-rdnm-3", "implicit", 20.0),
        ("constant", "complex-rdnm-3", "implicit", 1.0),
        ("variable, three harmonics", "rdnm-3", "implicit", 1.0),
    ],
)
def test_all_response_dependent_modes_together_are_the_linear_ones(
    law, coordinates, basis_update, force
):
    joint, control = joint_of(law), StepControl(largest_step=0.2)
    full = solve_branch(joint, force, damping=LOSS, control=control)
    same = solve_branch(
        joint,
        force,
        method=method_of(coordinates, basis_update=basis_update),
        damping=LOSS,
        control=control,
    )
    assert full.complete
    assert same.complete
    # maxima are located within 1e-6 of a step
    assert same.frequency[same.peak] == pytest.approx(full.frequency[full.peak], rel=1e-6)
    assert same.amplitude[same.peak] == pytest.approx(full.amplitude[full.peak], rel=1e-8)
    balance = HarmonicBalance(joint, LOSS, force)
    for q, f in zip(same.modal_coordinate, same.frequency, strict=True):
        left = np.linalg.norm(balance.residual(q, 2 * np.pi * f))
        # 1e-9, as long as a complex basis stretches it
        assert left < 3e-9 * np.linalg.norm(balance.modal_force)


def test_describing_function_of_each_direction_is_its_force_over_its_displacement(variable):
    balance, x = moved(variable)
    tangential, normal = secants(variable, x)
    # else swapped directions would pass, and springs that stick in place of secants
    stuck = variable.law.stuck_stiffness(variable.points)
    for found, wrong in ((tangential, normal), (tangential, stuck[:, 0]), (normal, stuck[:, 1])):
        assert np.linalg.norm(found - wrong) > 0.1 * np.linalg.norm(found)
    secant = balance.describing_function(x, W)
    assert secant.shape == (variable.points, 2)
    # the same divisions in another order
    np.testing.assert_allclose(secant[:, 0], tangential, rtol=1e-10)
    np.testing.assert_allclose(secant[:, 1], normal, rtol=1e-10)


@pytest.mark.parametrize("basis_update", ["implicit", "lagged"])
def test_response_dependent_modes_are_those_of_the_secants_of_both_directions(
    variable, basis_update
):
    balance, x = moved(variable)
    equations = method_of("rdnm-3", basis_update=basis_update).formulate(balance, 1)
    (equations.update(x, W) if basis_update == "lagged" else equations.accept(x))
    basis = equations.basis if basis_update == "lagged" else equations.state()
    tangential, normal = (k.real for k in secants(variable, x))
    matrix = stiffness_with(variable, [tangential, normal])
    projected = basis.T @ matrix @ basis
    # eigenvectors make it diagonal to rounding
    off = projected - np.diag(np.diag(projected))
    assert np.abs(off).max() < 1e-11 * np.abs(projected).max()
    matrix = stiffness_with(variable, [tangential, 0 * normal])
    without_normal = basis.T @ matrix @ basis
    off = without_normal - np.diag(np.diag(without_normal))
    assert np.abs(off).max() > 1e-3 * np.abs(projected).max()


@pytest.mark.parametrize(
    ("name", "basis_update", "jacobian", "kind"),
    [
        ("linear", "implicit", "analytic", BalanceEquations),
        ("rdnm-2", "implicit", "analytic", SelfConsistentRDNM),
        ("rdnm-2", "lagged", "analytic", LaggedRDNM),
        ("rdnm-2", "implicit", "forward-difference", LaggedRDNM),
        ("complex-rdnm-2", "implicit", "analytic", ComplexRDNM),
    ],
)
def test_coordinates_are_given_by_their_name(joint, name, basis_update, jacobian, kind):
    balance = HarmonicBalance(joint, LOSS, 5.0)
    method = method_of(name, jacobian=jacobian, basis_update=basis_update)
    assert method.name == name
    assert type(method.formulate(balance, 1)) is kind


@pytest.mark.parametrize("count", [1, 2, 3])
def test_jacobian_contains_the_derivative_of_the_modes(any_joint, count):
    balance, x = moved(any_joint)
    equations = SelfConsistentRDNM(balance, count)
    exact = equations.evaluate(x, W)[1]()
    # an error of second order in the step, where the law is smooth, and rounding over the step
    near = differences(lambda x: equations.evaluate(x, W)[0], x, 1e-9)
    np.testing.assert_allclose(near, exact, atol=1e-8 * np.abs(exact).max())
    held = LaggedRDNM(balance, count)
    held.update(x, W)
    P = np.kron(np.eye(len(balance.components)), held.basis @ held.basis.T)
    still = P @ balance.residual_and_jacobian(x, W)[1]()
    # else one of modes held where they are would pass; all of them together move nowhere
    assert (np.abs(P @ exact - still).max() > 1e-3 * np.abs(exact).max()) == (count < 3)


@pytest.mark.parametrize("name", ["linear", "rdnm-1", "rdnm-2"])
def test_derivatives_by_frequency_and_load_factor_equal_differences(any_joint, name):
    balance, x = moved(any_joint)
    equations = method_of(name).formulate(balance, 1)

    def residual(w, load_factor=1.0):
        return equations.evaluate(x, w, load_factor)[0]

    # of a parabola and of a line, differences are exact but for rounding
    near = (residual(W + 0.1) - residual(W - 0.1)) / 0.2
    by_frequency = equations.parameter_derivative(x, W)
    np.testing.assert_allclose(near, by_frequency, atol=1e-9 * np.linalg.norm(near))
    near = (residual(W, 0.7) - residual(W, 0.3)) / 0.4
    by_load_factor = equations.load_factor_derivative(x)
    np.testing.assert_allclose(near, by_load_factor, atol=1e-9 * np.linalg.norm(near))


@pytest.mark.parametrize("count", [1, 2])
def test_a_self_consistent_solution_lies_in_its_own_modes(any_joint, count):
    branch = solve_branch(
        any_joint,
        5.0,
        method=f"rdnm-{count}",
        damping=LOSS,
        resonance=Resonance(1, (80.0, 120.0)),
        control=StepControl(largest_step=0.4),
    )
    assert branch.complete
    balance = HarmonicBalance(any_joint, LOSS, 5.0)
    left_out = []
    for q, f in list(zip(branch.modal_coordinate, branch.frequency, strict=True))[::4]:
        secant = [k.real for k in secants(any_joint, q)]
        modes = np.linalg.eigh(stiffness_with(any_joint, secant))[1]
        V, others = modes[:, :count], modes[:, count:]
        parts = q.reshape(-1, 3)
        # residuals below 1e-9 of the force, the motion being what the softest of them makes of it
        assert np.abs(parts @ others).max() < 1e-8 * np.abs(parts).max()
        residual = balance.residual(q, 2 * np.pi * f).reshape(-1, 3)
        scale = np.linalg.norm(balance.modal_force)
        assert np.linalg.norm(residual @ V) < 1e-8 * scale
        left_out.append(np.linalg.norm(residual @ others) / scale)
    # else the full balance would hold, whatever the modes
    assert max(left_out) > 0.1


def test_lagged_modes_converge_to_self_consistent_ones(either):
    """By the length of the steps, as the source updates the basis once a solution."""
    moving, lag = SelfConsistentRDNM(HarmonicBalance(either, LOSS, 5.0), 1), []
    for step in (0.16, 0.04):
        control = StepControl(largest_step=step, first_step=step)
        lagging = solve_branch(
            either,
            5.0,
            method=method_of("rdnm-1", basis_update="lagged"),
            damping=LOSS,
            resonance=Resonance(1, (80.0, 100.0)),
            control=control,
        )
        assert lagging.complete
        apart = []
        for q, f in zip(lagging.modal_coordinate[1::4], lagging.frequency[1::4], strict=True):
            itself, _ = newton(moving, q, 2 * np.pi * f, StepControl())
            assert itself.converged
            moving.accept(itself.x)
            apart.append(distance(q, itself.x))
        lag.append(np.median(apart))
    assert lag[0] > 1e-6  # far above what a corrector leaves
    assert np.log(lag[0] / lag[1]) / np.log(4) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("name", ["linear", "rdnm-1"])
def test_load_stepping_ends_where_the_corrector_converges(either, name):
    balance = HarmonicBalance(either, LOSS, 20.0)
    equations = method_of(name).formulate(balance, 1)
    stuck = balance.stuck_solution(W)
    there, _ = newton(equations, stuck, W, StepControl())
    assert there.converged
    assert distance(there.x, stuck) > 0.2  # under this force it does not stick

    control = StepControl(largest_step=0.2)
    little = 1e-3 * stuck
    path = trace(LoadStepping(equations, W), little, (np.log(1e-3), 0.0), control, scale=1.0)
    assert path.complete
    # under so little of it all does, but the motion may be that of one mode
    assert distance(path.solutions[0].x, little) < 0.2
    # both to residuals of 1e-9 of the force
    assert distance(path.solutions[-1].x, there.x) < 1e-7


@pytest.mark.parametrize("name", ["linear", "rdnm-1"])
def test_load_stepping_has_the_derivative_by_the_logarithm_of_the_load_factor(either, name):
    balance, x = moved(either)
    equations = method_of(name).formulate(balance, 1)
    whole, _ = equations.evaluate(x, W)
    loading, p, h = LoadStepping(equations, W), -1.0, 1e-4
    near = (loading.evaluate(x, p + h)[0] - loading.evaluate(x, p - h)[0]) / (2 * h)
    # second differences of an exponential: a sixth of the step squared, and rounding over the step
    np.testing.assert_allclose(
        near, loading.parameter_derivative(x, p), atol=1e-7 * np.linalg.norm(near)
    )
    # what has been loaded in part is excited in full again
    np.testing.assert_array_equal(equations.evaluate(x, W)[0], whole)


def complex_at(balance, x, count, quasi_static_correction=True):
    """Complex modes updated at a state, and their unknown there."""
    equations = ComplexRDNM(balance, count, quasi_static_correction=quasi_static_correction)
    equations.update(x, W)
    return equations, equations.from_fixed(x)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_complex_modes_are_eigenvectors_orthogonal_without_conjugation(either, count):
    balance, x = moved(either)
    equations, _ = complex_at(balance, x, count)
    phi, _ = equations.basis
    # eigenvectors to rounding
    np.testing.assert_allclose(phi.T @ phi, np.eye(count), atol=1e-12)
    lossy = 1j * LOSS * np.diag((2 * np.pi * either.natural_frequency) ** 2)
    matrix = stiffness_with(either, secants(either, x)) + lossy
    projected = phi.T @ matrix @ phi
    np.testing.assert_allclose(
        matrix @ phi, phi * np.diag(projected), atol=1e-11 * np.abs(matrix).max()
    )
    # real modes would have the same products, and these springs are far from real
    assert np.abs(phi.conj().T @ phi - np.eye(count)).max() > 1e-5
    assert (matrix - lossy)[0, 0].imag > 0.1 * matrix[0, 0].real


@pytest.mark.parametrize("quasi_static_correction", [True, False])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_derivatives_in_complex_modes_equal_differences(either, count, quasi_static_correction):
    balance, x = moved(either)
    equations, y = complex_at(balance, x, count, quasi_static_correction)
    exact = equations.evaluate(y, W)[1]()
    near = differences(lambda y: equations.evaluate(y, W)[0], y, 1e-9)
    np.testing.assert_allclose(near, exact, atol=1e-8 * np.abs(exact).max())
    near = (equations.evaluate(y, W + 0.1)[0] - equations.evaluate(y, W - 0.1)[0]) / 0.2
    by_frequency = equations.parameter_derivative(y, W)
    np.testing.assert_allclose(near, by_frequency, atol=1e-9 * np.linalg.norm(near))
    forward = ComplexRDNM(
        balance,
        count,
        jacobian="forward-difference",
        quasi_static_correction=quasi_static_correction,
    )
    forward.basis = equations.basis
    np.testing.assert_allclose(forward.evaluate(y, W)[1](), exact, atol=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize("count", [1, 2])
def test_complex_modes_give_the_fixed_form_back(either, count):
    equations, y = complex_at(*moved(either), count)
    assert equations.basis[1].any()
    np.testing.assert_allclose(equations.from_fixed(equations.to_fixed(y)), y, rtol=1e-9)
    change = 0.1 * np.random.default_rng(2).normal(size=y.size) * np.abs(y).max()
    np.testing.assert_allclose(
        equations.change_to_fixed(change),
        equations.to_fixed(y + change) - equations.to_fixed(y),
        atol=1e-12 * np.abs(y).max(),
    )


def test_the_equations_in_complex_modes_are_the_balance_projected(either):
    balance, x = moved(either)
    equations, y = complex_at(balance, x, 2)
    phi, _ = equations.basis
    full = balance.residual(equations.to_fixed(y), W)
    *bias, s, c = full.reshape(-1, 3)
    left = phi.T @ (s + 1j * c)
    np.testing.assert_allclose(
        equations.evaluate(y, W)[0],
        np.concatenate([*bias, left.real, left.imag]),
        atol=1e-10 * np.linalg.norm(full),
    )


def near_resonance(joint, force):
    """The balance, and its solution beside the peak."""
    balance = HarmonicBalance(joint, LOSS, force)
    control = StepControl(largest_step=0.14)
    full = solve_branch(joint, force, damping=LOSS, control=control)
    at = full.peak - 2
    assert set(joint.law.contact_state(balance.motion(full.modal_coordinate[at]))) - {0}
    return balance, full.modal_coordinate[at], 2 * np.pi * full.frequency[at]


@pytest.mark.parametrize("force", [1.0, 5.0, 20.0])
def test_with_residual_modes_an_implicit_complex_mode_is_the_whole_solution(either, force):
    balance, x, w = near_resonance(either, force)
    real = SelfConsistentRDNM(balance, 1)
    real.accept(x)
    one, _ = newton(real, x, w, StepControl())
    assert one.converged
    found = {}
    for quasi_static_correction in (True, False):
        equations = ComplexRDNM(balance, 1, quasi_static_correction=quasi_static_correction)
        # not there, but at the real mode's, so that repeating has a way to go
        at = one.x
        for _ in range(40):
            equations.update(at, w)
            solution, _ = newton(equations, equations.from_fixed(at), w, StepControl())
            assert solution.converged
            at = (at + equations.to_fixed(solution.x)) / 2
        found[quasi_static_correction] = at
    # the sum of all modes of the matrix that the motion itself makes
    assert distance(found[True], x) < 1e-7
    assert distance(one.x, x) > 1e-4
    assert distance(found[False], x) > 1e-4


def test_the_lag_of_complex_modes_is_of_second_order_in_the_step(either):
    linear, lag = BalanceEquations(HarmonicBalance(either, LOSS, 5.0)), []
    for step in (0.16, 0.04):
        branch = solve_branch(
            either,
            5.0,
            method=ResponseDependentModes(1, is_complex=True, is_lagged=True),
            damping=LOSS,
            resonance=Resonance(1, (80.0, 120.0)),
            control=StepControl(largest_step=step, first_step=step),
        )
        assert branch.complete
        apart = []
        for q, f in zip(branch.modal_coordinate, branch.frequency, strict=True):
            itself, _ = newton(linear, q, 2 * np.pi * f, StepControl())
            assert itself.converged
            apart.append(distance(q, itself.x))
        # updated at the peak itself until that changes the motion by 1e-6
        assert apart[branch.peak] < 1e-6
        lag.append(np.median(apart))
    # steps are made longer and shorter on the way
    assert np.log(lag[0] / lag[1]) / np.log(4) > 1.7


def test_complex_modes_need_a_motion_of_one_harmonic():
    for law in LAWS[2:]:
        balance = HarmonicBalance(joint_of(law), LOSS, 5.0)
        with pytest.raises(ValueError, match="one harmonic"):
            ComplexRDNM(balance, 1)


@pytest.mark.parametrize("name", ["rdnm-4", "complex-rdnm-4"])
@pytest.mark.parametrize("basis_update", ["implicit", "lagged"])
def test_no_more_modes_than_the_structure_has(joint, name, basis_update):
    with pytest.raises(ValueError, match="4 response-dependent modes of 3 linear ones"):
        method = method_of(name, basis_update=basis_update)
        method.formulate(HarmonicBalance(joint, LOSS, 5.0), 1)
