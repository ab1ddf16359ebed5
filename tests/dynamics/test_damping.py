"""Damping models: against dense equations in physical coordinates, and in every formulation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, solve
from scipy.optimize import root
from small_joint import make_joint

from boltjoint import dataset
from boltjoint.damping import (
    MODELS,
    LossFactor,
    ModalDamping,
    ModalStructure,
    RayleighDamping,
    damping_of_attributes,
    make_damping,
)
from boltjoint.dynamics.backbone.backbone import find_backbone, trace_backbone
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.frequency_response import method_of, solve_branch, solve_response
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.joint.io import joint_to_dataset
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.residual_in_time import residuals_in_time
from boltjoint.verification.time_integration import steady_state

#: so that a solution is as good as rounding lets it be
EXACT = StepControl(tolerance=1e-13)

EXAMPLES = {
    "loss_factor": {"loss_factor": 0.01},
    "modal": {"damping_ratios": (0.01, 0.003, 0.006)},
    "rayleigh": {"mass_coefficient": 5.0, "stiffness_coefficient": 1e-5},
}
ALL = [make_damping(name, **EXAMPLES[name]) for name in MODELS]
VISCOUS = [damping for damping in ALL if not isinstance(damping, LossFactor)]


def named(damping):
    return damping.name


@pytest.fixture(params=["constant", "variable"])
def either(request):
    return make_joint(law=request.param)


class Chain:
    """Masses between springs with a row of 100 friction elements, in physical coordinates.

    Elements connect each mass to the ground through a lever of their own. Nothing is shared with
    the library but the parameters: M, C and K are dense, forces of elements closed forms.
    """

    def __init__(self, damping):
        random = np.random.default_rng(3)
        self.M = np.diag([1.0, 2.0, 1.5, 0.5])
        k = np.array([4e5, 3e5, 5e5, 2e5])
        self.K = np.diag(k + np.append(k[1:], 0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
        squared, self.modes = eigh(self.K, self.M)
        self.w = np.sqrt(squared)
        self.C = self.viscosity(damping)
        self.lever = random.uniform(-1, 1, (100, 4))
        self.k, self.slip = random.uniform(500, 1500, 100), random.uniform(0.01, 0.2, 100)
        self.force = np.array([0.0, 0.0, 0.3, 1.0])

    def viscosity(self, damping):
        if isinstance(damping, RayleighDamping):
            return damping.mass_coefficient * self.M + damping.stiffness_coefficient * self.K
        given = damping.damping_ratios
        ratios = [*given, given[-1]]
        weighted = self.M @ self.modes
        return weighted @ np.diag(2 * np.array(ratios) * self.w) @ weighted.T

    def friction(self, u):
        """Complex forces of Jenkins elements over u by the integrals of their loop."""
        size = np.maximum(abs(u), 1e-300)
        theta = np.arccos(1 - 2 * np.minimum(self.slip / (self.k * size), 1))
        in_phase = self.k / np.pi * (theta - np.sin(theta) * np.cos(theta))
        lost = 4 * self.slip / (np.pi * size) * np.maximum(1 - self.slip / (self.k * size), 0)
        return (in_phase + 1j * lost) * u

    def force_of_contact(self, x):
        return self.lever.T @ self.friction(self.lever @ x)

    def joint(self):
        at = np.zeros((100, 3))
        return Joint(
            natural_frequency=self.w / (2 * np.pi),
            excitation_mode=self.force @ self.modes,
            response_mode=self.modes[-1],
            tangential_mode=self.lever @ self.modes,
            position=at,
            law=ConstantLoad(np.arange(100), self.k, self.slip),
            element_position=at,
        )

    def response(self, w, force, guess):
        """Displacements [m], of both parts of the equations in all four unknowns."""
        dynamic = self.K + 1j * w * self.C - w**2 * self.M
        # equations in units of the unknowns, so that the tolerance is one of the displacements
        flexible = np.linalg.inv(dynamic + self.lever.T @ (self.k[:, None] * self.lever))
        size = abs(guess).max()

        def residual(unknown):
            x = size * (unknown[:4] + 1j * unknown[4:])
            left = flexible @ (dynamic @ x + self.force_of_contact(x) - force * self.force) / size
            return np.concatenate([left.real, left.imag])

        found = root(residual, np.concatenate([guess.real, guess.imag]) / size, tol=1e-14)
        return size * (found.x[:4] + 1j * found.x[4:])

    def mode(self, amplitude, phi, eigenvalue):
        """Mode of unit modal mass and eigenvalue at a modal amplitude."""
        scale = abs(eigenvalue)

        def residual(unknown):
            x, value = unknown[:4] + 1j * unknown[4:8], scale * complex(*unknown[8:])
            dynamic = self.K + 1j * np.sqrt(value.real) * self.C - value * self.M
            left = dynamic @ x + self.force_of_contact(amplitude * x) / amplitude
            norm = (x.conj() @ self.M @ x).real - 1
            phase = (phi.conj() @ self.M @ x).imag
            return np.concatenate([left.real / scale, left.imag / scale, [norm, phase]])

        start = np.concatenate(
            [phi.real, phi.imag, [eigenvalue.real / scale, eigenvalue.imag / scale]]
        )
        return scale * complex(*root(residual, start, tol=1e-14).x[8:])


@pytest.fixture(params=VISCOUS, ids=named)
def chain_and_damping(request):
    return Chain(request.param), request.param


FORCE = 2.0
"""Some of the elements of the chain slip and some stick [N]."""


@pytest.mark.parametrize("coordinates", ["linear", "complex-rdnm-4"])
def test_responses_are_those_of_dense_viscous_equations(chain_and_damping, coordinates):
    chain, damping = chain_and_damping
    joint = chain.joint()
    branch = solve_branch(joint, FORCE, method=coordinates, damping=damping, control=EXACT)
    assert branch.complete and branch.peak is not None
    states = joint.law.contact_state(
        HarmonicBalance(joint, damping, FORCE).motion(branch.modal_coordinate[branch.peak])
    )
    assert set(states) == {0, 1}
    for i in (0, branch.peak // 2, branch.peak, branch.peak + 3, -1):
        s, c = branch.modal_coordinate[i].reshape(2, -1)
        found = chain.modes @ (s + 1j * c)
        w = 2 * np.pi * branch.frequency[i]
        # from elsewhere: the independent solution does not begin with what it is to find
        expected = chain.response(w, FORCE, 1.02 * found)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * abs(expected).max())


def test_backbones_are_those_of_dense_viscous_equations(chain_and_damping):
    chain, damping = chain_and_damping
    joint = chain.joint()
    window = frequency_window(joint)
    backbone = trace_backbone(
        equations := EPMCEquations(joint, damping),
        equations.amplitudes_for([0.01, 50.0], window),
        EXACT,
    )
    ratios = [state.damping_ratio for state in backbone.states]
    assert max(ratios) > 1.5 * min(ratios)  # friction damps too, on a part of the backbone
    for state in backbone.states[::8]:
        phi = chain.modes @ state.mode
        expected = chain.mode(state.amplitude, phi, state.eigenvalue * (1 + 0.001j))
        assert state.eigenvalue == pytest.approx(expected, rel=1e-9)
    first = backbone.states[0]
    stuck = chain.K + chain.lever.T @ (chain.k[:, None] * chain.lever)
    squared, modes = eigh(stuck, chain.M)
    assert first.damping_ratio == pytest.approx(
        modes[:, 0] @ chain.C @ modes[:, 0] / (2 * np.sqrt(squared[0])), rel=1e-3
    )


@pytest.mark.parametrize("damping", ALL, ids=named)
def test_the_synthesised_response_of_a_stuck_joint_is_the_linear_one(damping, either):
    """Off the peak too, where the damping is not that of the natural frequency."""
    window = frequency_window(either)
    equations = EPMCEquations(either, damping)
    backbone = trace_backbone(equations, equations.amplitudes_for([1e-6], window), EXACT)
    response = synthesise_response(backbone, 1e-6, window)
    balance = HarmonicBalance(either, damping, 1e-6)
    assert response.complete and response.peak is not None
    for f, x in zip(response.frequency, response.modal_coordinate, strict=True):
        expected = balance.stuck_solution(2 * np.pi * f)
        # modes coupled by damping are a small part of the response of a light damping
        np.testing.assert_allclose(x, expected, rtol=0, atol=5e-4 * abs(expected).max())
    branch = solve_branch(either, 1e-6, damping=damping, resonance=Resonance(1, window))
    assert response.frequency[response.peak] == pytest.approx(
        branch.frequency[branch.peak], rel=1e-6
    )


@pytest.mark.parametrize("damping", ALL, ids=named)
@pytest.mark.parametrize("harmonics", [1, 3])
def test_derivatives_equal_differences(damping, either, harmonics):
    joint = either
    if harmonics > 1:
        joint = replace(joint, law=AlternatingFrequencyTime(joint.law, harmonics))
    balance = HarmonicBalance(joint, damping, 5.0)
    x = 3e-5 * np.random.default_rng(7).normal(size=balance.modal_force.size)
    equations = [BalanceEquations(balance)]
    if harmonics == 1:
        equations.append(ComplexRDNM(balance, 2))
        equations[1].update(x, 600.0)
    for each in equations:
        y = each.from_fixed(x) if isinstance(each, ComplexRDNM) else x
        _, form_jacobian = each.evaluate(y, 600.0)
        jacobian = form_jacobian()
        for j in range(y.size):
            step = 1e-10 * (np.arange(y.size) == j)
            rise = each.evaluate(y + step, 600.0)[0] - each.evaluate(y - step, 600.0)[0]
            # relative to the stiffest entry; second differences of a force that is smooth twice
            np.testing.assert_allclose(
                jacobian[:, j], rise / 2e-10, atol=2e-6 * abs(jacobian).max()
            )
        rise = each.evaluate(y, 600.01)[0] - each.evaluate(y, 599.99)[0]
        np.testing.assert_allclose(
            each.parameter_derivative(y, 600.0),
            rise / 0.02,
            atol=1e-7 * np.linalg.norm(rise / 0.02),
        )


@pytest.mark.parametrize("damping", ALL, ids=named)
def test_the_jacobian_of_the_backbone_equals_differences(damping, either):
    equations = EPMCEquations(either, damping)
    x = equations.start()
    x[:-2] += 0.05 * np.random.default_rng(2).normal(size=x.size - 2)
    x[-2:] = 0.9, 0.02
    p = np.log(3e-5)
    jacobian = equations.evaluate(x, p)[1]()
    for j in range(x.size):
        step = 1e-6 * (np.arange(x.size) == j)
        rise = equations.evaluate(x + step, p)[0] - equations.evaluate(x - step, p)[0]
        np.testing.assert_allclose(jacobian[:, j], rise / 2e-6, atol=1e-6 * abs(jacobian).max())


@pytest.mark.parametrize("damping", ALL, ids=named)
def test_power_is_balanced_and_the_equations_hold_in_time(damping, either, tmp_path):
    response = solve_response(either, [0.5, 20.0], damping=damping)
    assert response["complete"].all()
    assert abs(response["energy_error"]).max() < 1e-6
    path = tmp_path / "response.nc"
    dataset.save(response, path, {})
    stored = dataset.load(path)
    assert damping_of_attributes(stored.attrs) == damping
    some = stored.isel(solution=slice(0, None, 15))
    assert residuals_in_time(joint_to_dataset(either), some).max() < 2e-6


@pytest.mark.parametrize("damping", ALL, ids=named)
@pytest.mark.parametrize("law", ["tabulated", "iwan"])
def test_power_is_balanced_under_the_other_laws(damping, law):
    joint = make_joint()
    elements = joint.law.point_of_element, joint.law.tangential_stiffness, joint.law.slip_force
    if law == "iwan":
        ones = np.ones(elements[0].size)
        joint = replace(joint, law=FourParameterIwan(*elements, -0.5 * ones, 0.5 * ones))
    else:
        joint = replace(joint, law=TabulatedLoad(*elements))
    response = solve_response(joint, [0.5, 20.0], damping=damping)
    assert response["complete"].all()
    assert abs(response["energy_error"]).max() < 1e-6


@pytest.mark.parametrize("coordinates", ["rdnm-1", "complex-rdnm-1", "backbone"])
@pytest.mark.parametrize(
    "options", [{}, {"basis_update": "lagged"}, {"jacobian": "forward-difference"}]
)
def test_every_formulation_peaks_as_the_linear_one(coordinates, options):
    joint, damping = make_joint(), VISCOUS[0]
    full = solve_branch(joint, 5.0, damping=damping)
    other = solve_branch(joint, 5.0, method_of(coordinates, **options), damping=damping)
    assert other.complete
    # one real mode of three: without the damping of the structure the peak would be twice as high
    assert other.amplitude[other.peak] == pytest.approx(full.amplitude[full.peak], rel=0.02)
    assert other.frequency[other.peak] == pytest.approx(full.frequency[full.peak], rel=1e-2)


@pytest.mark.parametrize("damping", ALL, ids=named)
def test_a_stuck_joint_vibrates_in_time_as_its_dense_equations(damping, either):
    """Viscous damping is the same at all frequencies: no equivalent is needed."""
    frequency, force = 90.0, 1e-6
    w = 2 * np.pi * frequency
    natural = 2 * np.pi * either.natural_frequency
    D = damping.matrix(ModalStructure(natural)).at(w)
    dynamic = np.diag(natural**2) + either.stuck_stiffness() + 1j * D - w**2 * np.eye(3)
    expected = either.response_mode @ solve(dynamic, either.excitation_mode * force)
    in_time = steady_state(either, frequency, force, damping, ramp=20, steps=1000)
    assert in_time.amplitude == pytest.approx(expected, rel=1e-7)
    motion = solve_periodic(either, frequency, force, damping, harmonics=5)
    assert motion.amplitude(either.response_mode) == pytest.approx(expected, rel=1e-9)


def test_backbone_files_hold_the_model(joint):
    damping = VISCOUS[0]
    found = find_backbone(joint, [5.0], damping=damping, window=frequency_window(joint))
    assert damping_of_attributes(found.attrs) == damping
    state = found.isel(state=np.argmin(abs(found["peak_force"].to_numpy() - 5.0)))
    branch = solve_branch(joint, float(state["peak_force"]), method="backbone", damping=damping)
    amplitude = np.linalg.norm(branch.modal_coordinate[branch.peak])
    assert amplitude == pytest.approx(float(state["modal_amplitude"]), rel=1e-3)


def test_one_ratio_holds_for_all_modes_and_the_last_for_further_ones():
    w = np.array([10.0, 20.0, 40.0])
    for given, expected in ((0.01, [0.01] * 3), ((0.01, 0.02), [0.01, 0.02, 0.02])):
        found = ModalDamping(given).matrix(ModalStructure(w)).at(3.0)
        wanted = np.diag(3.0 * 2 * np.array(expected) * w)
        np.testing.assert_allclose(found, wanted, rtol=1e-14)
    found = LossFactor(0.003).matrix(ModalStructure(w)).at(3.0)
    np.testing.assert_allclose(found, np.diag(0.003 * w**2), rtol=1e-14)


@pytest.mark.parametrize(("ratios", "vectors"), [((0.02, 0.001, 0.0), 5), ((0.02, 0.001, 0.01), 8)])
def test_ratios_by_mode_are_those_of_the_modes_in_any_vectors(ratios, vectors):
    """Exact in few vectors but for the last ratio, and in vectors that span all motion."""
    rng = np.random.default_rng(4)
    K = rng.normal(size=(8, 8))
    squared, modes = np.linalg.eigh(K @ K.T)
    zeta = np.array(ratios)[np.minimum(np.arange(8), 2)]
    C = modes @ np.diag(2 * zeta * np.sqrt(squared)) @ modes.T
    V = np.linalg.qr(rng.normal(size=(8, vectors)))[0]
    own, turn = np.linalg.eigh(V.T @ K @ K.T @ V)
    V = V @ turn
    Q = np.linalg.qr(rng.normal(size=(vectors, 3)))[0]
    for basis, wanted in ((None, V), (Q, V @ Q)):
        structure = ModalStructure(np.sqrt(own), basis, np.sqrt(squared[:4]), modes.T[:4] @ V)
        found = ModalDamping(ratios).matrix(structure).at(3.0)
        np.testing.assert_allclose(found, 3.0 * wanted.T @ C @ wanted, atol=1e-13)
    with pytest.raises(ValueError, match="holds 6 ratios, but the basis knows 4 modes"):
        ModalDamping([0.01] * 6).matrix(structure)


def test_coefficients_of_rayleigh_damping_are_numbers_from_zero():
    w = np.array([10.0, 20.0])
    found = RayleighDamping(0.4, 0.002).matrix(ModalStructure(w)).at(3.0)
    np.testing.assert_allclose(found, np.diag(3.0 * (0.4 + 0.002 * w**2)), rtol=1e-14)
    for given in ((-1.0, 0.0), (0.0, np.nan)):
        with pytest.raises(ValueError, match="coefficient is"):
            RayleighDamping(*given)


@pytest.mark.parametrize("ratios", [[], [0.1, -0.1], [[0.1]], np.nan, "much"])
def test_ratios_are_numbers_from_zero(ratios):
    with pytest.raises(ValueError, match="damping_ratios"):
        ModalDamping(ratios)
