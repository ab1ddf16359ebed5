"""Phased excitation, base excitation and sensors, against closed forms and dense equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import root
from small_joint import make_joint

from boltjoint.damping import RayleighDamping
from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.model import Joint
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.residual_in_time import residuals_in_time
from boltjoint.verification.time_integration import steady_state

LOSS = 0.01

#: so that a solution is as good as rounding lets it be
EXACT = StepControl(tolerance=1e-13)

#: base excitation in these tests [m/s2]: the chain slips at some of its elements
ACCELERATION = 2.0


@pytest.fixture(params=["constant", "variable"])
def either(request):
    return make_joint(law=request.param)


def phased(joint, phase):
    """The same joint under an excitation that leads by a phase [rad]."""
    mode = joint.excitation_mode
    return replace(
        joint, excitation_mode=np.cos(phase) * mode, excitation_mode_cos=np.sin(phase) * mode
    )


@pytest.mark.parametrize("coordinates", ["linear", "rdnm-1", "complex-rdnm-1", "backbone"])
def test_a_phase_of_all_points_shifts_the_response_alone(either, coordinates):
    options = {"damping": LOSS, "method": coordinates, "control": StepControl(1e-11)}
    one = solve_branch(either, 5.0, **options)
    other = solve_branch(phased(either, 0.7), 5.0, **options)
    assert one.complete and other.complete
    assert other.frequency[other.peak] == pytest.approx(one.frequency[one.peak], rel=1e-7)
    assert other.amplitude[other.peak] == pytest.approx(one.amplitude[one.peak], rel=1e-7)
    turned = one.modal_coordinate[one.peak].reshape(-1, 3)
    s, c = turned[-2:]
    turned[-2:] = np.cos(0.7) * s - np.sin(0.7) * c, np.sin(0.7) * s + np.cos(0.7) * c
    found = other.modal_coordinate[other.peak].reshape(-1, 3)
    # the peak is located by a width of its frequency, about which phases change most
    np.testing.assert_allclose(found, turned, atol=2e-4 * abs(turned).max())


def test_forces_out_of_phase_add_as_complex_amplitudes(either):
    joint = replace(either, excitation_mode_cos=np.array([0.5, 1.0, -2.0]))
    balance = HarmonicBalance(joint, LOSS, 1e-6)
    w = 2 * np.pi * 90.0
    s, c = balance.stuck_solution(w).reshape(-1, 3)[-2:]
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    dynamic = L * (1 + 1j * LOSS) + joint.stuck_stiffness() - w**2 * np.eye(3)
    force = 1e-6 * (joint.excitation_mode + 1j * joint.excitation_mode_cos)
    np.testing.assert_allclose(s + 1j * c, np.linalg.solve(dynamic, force), rtol=1e-10)


def test_phased_responses_balance_power_and_hold_in_time(either):
    joint = replace(either, excitation_mode_cos=np.array([0.5, 1.0, -2.0]))
    response = solve_response(joint, [0.5, 20.0], damping=LOSS)
    assert response["complete"].all()
    assert abs(response["energy_error"]).max() < 1e-6
    some = response.isel(solution=slice(0, None, 15))
    assert residuals_in_time(joint_to_dataset(joint), some).max() < 2e-6


def test_a_phased_excitation_is_integrated_in_time(either):
    joint = replace(either, excitation_mode_cos=np.array([0.5, 1.0, -2.0]))
    found = steady_state(joint, 90.0, 1e-6, LOSS, ramp=20, steps=1000)
    expected = solve_periodic(joint, 90.0, 1e-6, LOSS, harmonics=3).amplitude(joint.response_mode)
    assert found.amplitude == pytest.approx(expected, rel=1e-7)


class ClampedChain:
    """Four masses on a support that moves, with friction between neighbours, in absolute motion."""

    def __init__(self):
        random = np.random.default_rng(5)
        self.mass = np.array([3.0, 1.0, 2.0, 1.5, 0.5])  # of the support first
        k = np.array([4e5, 3e5, 5e5, 2e5])
        between = np.diff(np.eye(5), axis=0)
        self.K = between.T @ np.diag(k) @ between
        # consistent mass couples the support with its neighbour
        self.M = np.diag(self.mass) + 0.2 * np.abs(between).T @ np.abs(between)
        self.beta = 2e-5
        # elements between two masses or the support: no force under rigid motion
        self.lever = random.uniform(-1, 1, (100, 4)) @ between
        self.k, self.slip = random.uniform(500, 1500, 100), random.uniform(0.01, 0.2, 100)
        squared, self.modes = eigh(self.K[1:, 1:], self.M[1:, 1:])
        self.frequency = np.sqrt(squared) / (2 * np.pi)

    def joint(self):
        at = np.zeros((100, 3))
        return Joint(
            natural_frequency=self.frequency,
            excitation_mode=-self.modes.T @ (self.M @ np.ones(5))[1:],
            response_mode=self.modes[-1],
            tangential_mode=self.lever[:, 1:] @ self.modes,
            position=at,
            law=ConstantLoad(np.arange(100), self.k, self.slip),
            element_position=at,
            excitation_unit="m/s2",
            sensor_mode=self.modes[[-1, 0]],
            sensor_name=("tip", "root"),
        )

    def friction(self, u):
        size = np.maximum(abs(u), 1e-300)
        theta = np.arccos(1 - 2 * np.minimum(self.slip / (self.k * size), 1))
        in_phase = self.k / np.pi * (theta - np.sin(theta) * np.cos(theta))
        lost = 4 * self.slip / (np.pi * size) * np.maximum(1 - self.slip / (self.k * size), 0)
        return (in_phase + 1j * lost) * u

    def absolute(self, w, acceleration, guess):
        """Displacements of the masses [m] while the support moves by -acceleration / w^2."""
        support = -acceleration / w**2
        dynamic = self.K * (1 + 1j * w * self.beta) - w**2 * self.M
        stuck = self.K + self.lever.T @ (self.k[:, None] * self.lever) - w**2 * self.M
        flexible = np.linalg.inv(stuck[1:, 1:] + 1j * w * self.beta * self.K[1:, 1:])
        size = abs(guess).max()

        def residual(unknown):
            x = np.concatenate([[support], size * (unknown[:4] + 1j * unknown[4:])])
            left = dynamic @ x + self.lever.T @ self.friction(self.lever @ x)
            scaled = flexible @ left[1:] / size
            return np.concatenate([scaled.real, scaled.imag])

        found = root(residual, np.concatenate([guess.real, guess.imag]) / size, tol=1e-14).x
        return size * (found[:4] + 1j * found[4:])


@pytest.mark.parametrize("coordinates", ["linear", "complex-rdnm-4"])
def test_base_excitation_is_an_imposed_motion_of_the_support(coordinates):
    chain = ClampedChain()
    joint, damping = chain.joint(), RayleighDamping(0.0, chain.beta)
    branch = solve_branch(joint, ACCELERATION, method=coordinates, damping=damping, control=EXACT)
    assert branch.complete and branch.peak is not None
    balance = HarmonicBalance(joint, damping, ACCELERATION)
    states = joint.law.contact_state(balance.motion(branch.modal_coordinate[branch.peak]))
    assert set(states) == {0, 1}
    for i in (0, branch.peak // 2, branch.peak, branch.peak + 3, -1):
        s, c = branch.modal_coordinate[i].reshape(2, -1)
        w = 2 * np.pi * branch.frequency[i]
        found = chain.modes @ (s + 1j * c) - ACCELERATION / w**2
        expected = chain.absolute(w, ACCELERATION, 1.02 * found)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * abs(expected).max())


def test_one_mass_on_a_moving_base_has_its_closed_form():
    """Relative motion of a mass on a spring: -a / (w_0^2 (1 + i eta) - w^2)."""
    mass, frequency = 2.5, 40.0
    one = np.array([1 / np.sqrt(mass)])
    at = np.zeros((1, 3))
    # the element is weak and sticks: 1e-6 of the spring, which the closed form has too
    k, spring = 1e-6 * mass * (2 * np.pi * frequency) ** 2, mass * (2 * np.pi * frequency) ** 2
    law = ConstantLoad(np.array([0]), np.array([k]), np.array([1e9]))
    joint = Joint(
        np.array([frequency]), -mass * one, one, one[None], at, law, at, excitation_unit="m/s2"
    )
    response = solve_response(
        joint, [3.0], damping=LOSS, control=EXACT, resonance=Resonance(1, (30.0, 50.0))
    )
    w = 2 * np.pi * response["frequency"].to_numpy()
    expected = 3.0 * mass / abs(spring * (1 + 1j * LOSS) + k - mass * w**2)
    np.testing.assert_allclose(response["response_amplitude"], expected, rtol=1e-9)
    for name in ("excitation_force", "force_level"):
        assert response[name].attrs["units"] == "m/s2"


def test_sensors_have_amplitudes_and_peaks_of_their_own():
    chain = ClampedChain()
    joint, damping = chain.joint(), RayleighDamping(0.0, chain.beta)
    response = solve_response(joint, [0.01, ACCELERATION], damping=damping)
    assert response["sensor"].to_numpy().tolist() == ["tip", "root"]
    amplitude = response["sensor_amplitude"].transpose("solution", "sensor").to_numpy()
    np.testing.assert_allclose(amplitude[:, 0], response["response_amplitude"], rtol=1e-14)
    s, c = response["modal_coordinate"].sel(component=["sin", "cos"]).to_numpy().T
    np.testing.assert_allclose(amplitude[:, 1], abs(chain.modes[0] @ (s + 1j * c)), rtol=1e-12)
    np.testing.assert_allclose(
        response["sensor_peak_amplitude"].sel(sensor="tip"), response["peak_amplitude"], rtol=1e-14
    )
    np.testing.assert_allclose(
        response["sensor_peak_frequency"].sel(sensor="tip"), response["peak_frequency"], rtol=1e-14
    )
    assert np.all(response["sensor_peak_amplitude"].sel(sensor="root") < response["peak_amplitude"])


def test_an_output_point_alone_is_a_sensor(joint):
    response = solve_response(joint, [1.0], damping=LOSS)
    assert response["sensor"].to_numpy().tolist() == ["output"]
    np.testing.assert_allclose(
        response["sensor_amplitude"][:, 0], response["response_amplitude"], rtol=1e-14
    )


def test_backbones_under_base_excitation_have_accelerations():
    joint = ClampedChain().joint()
    found = find_backbone(joint, [1.0], damping=LOSS, window=frequency_window(joint))
    assert found["peak_force"].attrs["units"] == "m/s2"
    # without excitation the backbone is the same
    free = replace(joint, excitation_unit="N")
    again = find_backbone(free, [1.0], damping=LOSS, window=frequency_window(joint))
    np.testing.assert_array_equal(found["natural_frequency"], again["natural_frequency"])


def test_excitation_and_sensors_survive_the_file():
    joint = replace(ClampedChain().joint(), excitation_mode_cos=np.arange(4.0))
    stored = joint_to_dataset(joint)
    assert stored["excitation_mode"].attrs["units"] == "kg^1/2"
    again = joint_from_dataset(stored)
    for name in ("excitation_mode", "excitation_mode_cos", "sensor_mode"):
        np.testing.assert_array_equal(getattr(again, name), getattr(joint, name))
    assert again.sensor_name == ("tip", "root")
    assert again.excitation_unit == "m/s2"


def test_what_is_not_excited_is_refused_by_parts_and_units(joint):
    silent = replace(joint, excitation_mode=np.zeros(3), excitation_mode_cos=np.ones(3))
    assert solve_branch(silent, 1.0, damping=LOSS).complete  # by its cosine part alone
    still = replace(silent, excitation_mode_cos=1e-12 * np.ones(3))
    with pytest.raises(ValueError, match="this force does not excite"):
        still.check_excitation(1)
    blind = replace(joint, excitation_mode=np.zeros(3), excitation_unit="m/s2")
    with pytest.raises(ValueError, match="this acceleration does not excite"):
        blind.check_excitation(1)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"excitation_mode_cos": np.ones(2)}, "excitation_mode_cos has shape"),
        ({"excitation_unit": "kN"}, "excitation_unit 'kN' is not known"),
        ({"sensor_name": ("tip",)}, "sensor_mode"),
        ({"sensor_mode": np.ones((2, 3)), "sensor_name": ("tip",)}, "sensor_mode has shape"),
    ],
)
def test_fields_that_do_not_fit_are_refused(joint, changes, problem):
    with pytest.raises(ValueError, match=problem):
        replace(joint, **changes)
