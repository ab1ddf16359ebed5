"""Four-parameter Iwan elements: forces, dissipation and tangents against their distribution."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from random_joints import random_joint
from scipy.integrate import quad
from small_joint import make_joint

from boltjoint.config.case import Case
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.dynamics.response.phase_resonance import find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.contact_states import STICK, STICK_SLIP
from boltjoint.friction.declarations import DECLARATIONS
from boltjoint.friction.element_law import ContactPairs
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.registry import LAWS
from boltjoint.friction.slider_forms import SlidersInTime
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.verification.residual_in_time import check_solutions
from boltjoint.verification.time_integration import steady_state

#: K_T, F_S, chi and beta
SHAPES = [
    (1e8, 3.0, 0.0, 0.0),
    (1e8, 3.0, -0.3, 0.4),
    (2e7, 8.0, -0.75, 5.0),
    (5e8, 0.2, -0.98, 0.02),
    (1e8, 3.0, 0.0, 1e3),
]
#: amplitudes over phi_max
AMPLITUDES = [1e-3, 0.3, 0.999, 1.0, 1.001, 1.7, 1.999, 2.001, 4.0, 60.0, 5e3]


def element(shape):
    return FourParameterIwan(np.array([0]), *np.reshape(shape, (4, 1)))


def over_distribution(law, of_slider, kink=None):
    """Sum over all sliders of an element, those that slip at phi_max last.

    With phi = phi_max v^(1 / (chi + 1)) the power law has the constant density K_p over v.
    """
    k_t, chi, beta = law.tangential_stiffness[0], law.chi[0], law.beta[0]
    phi_max, k_p = law.largest_slip_displacement[0], k_t / (1 + beta)
    points = sorted({0.0, 1.0, *([] if kink is None else [min(kink / phi_max, 1) ** (chi + 1)])})
    total = 0.0
    for low, high in pairwise(points):
        # squares at both ends: roots of the integrand there are smooth then
        def integrand(w, low=low, high=high):
            v = low + (high - low) * w * w * (3 - 2 * w)
            slope = (high - low) * 6 * w * (1 - w)
            return slope * of_slider(phi_max * v ** (1 / (chi + 1)))

        total += quad(integrand, 0, 1, epsabs=0, epsrel=1e-12, limit=400)[0]
    return k_p * (total + beta * of_slider(phi_max))


def stiffness_in_phase(phi, amplitude):
    r = min(phi / amplitude, 1.0)
    theta = 2 * np.arctan2(np.sqrt(r), np.sqrt(1 - r))
    if r < 1e-3:  # the difference below loses its digits
        return 8 / np.pi * r**1.5 * (2 / 3 - r / 5 - r * r / 28)
    return (theta - np.sin(theta) * np.cos(theta)) / np.pi


def stiffness_in_quadrature(phi, amplitude):
    r = min(phi / amplitude, 1.0)
    return 4 / np.pi * r * (1 - r)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_distribution_has_its_stiffness_and_slip_force(shape):
    law = element(shape)
    assert over_distribution(law, lambda phi: 1.0) == pytest.approx(shape[0], rel=1e-12)
    assert over_distribution(law, lambda phi: phi) == pytest.approx(shape[1], rel=1e-10)


@pytest.mark.parametrize("shape", SHAPES)
def test_first_harmonic_and_dissipation_are_those_of_the_distribution(shape):
    law = element(shape)
    for ratio in AMPLITUDES:
        a = ratio * law.largest_slip_displacement[0]
        in_phase, quadrature = law.force(np.array([[a, 0.0]]))[0] / a
        exact = over_distribution(law, lambda phi, a=a: stiffness_in_phase(phi, a), a)
        assert in_phase == pytest.approx(exact, rel=1e-9)
        # the dissipation is pi A^2 times this
        exact = over_distribution(law, lambda phi, a=a: stiffness_in_quadrature(phi, a), a)
        assert quadrature == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
def test_first_loading_is_that_of_the_distribution_and_of_segalman(shape):
    law = element(shape)
    for ratio in (0.01, 0.5, 1.0, 3.0):
        u = ratio * law.largest_slip_displacement[0]
        exact = over_distribution(law, lambda phi, u=u: min(phi, u), u)
        assert law.loading_curve(np.array(u))[0] == pytest.approx(exact, rel=1e-10)
    # dissipation of microslip, 4 R A^(chi + 3) / ((chi + 2) (chi + 3))
    k_t, _, chi, beta = shape
    a = 0.1 * law.largest_slip_displacement[0]
    of_power = k_t / (1 + beta) * (chi + 1) / law.largest_slip_displacement[0] ** (chi + 1)
    printed = 4 * of_power * a ** (chi + 3) / ((chi + 2) * (chi + 3))
    assert np.pi * a * law.force(np.array([[a, 0.0]]))[0, 1] == pytest.approx(printed, rel=1e-12)


def test_alone_at_phi_max_it_is_a_slider_with_its_spring():
    k, s = np.array([1e8]), np.array([3.0])
    # all but 1e-9 of the stiffness slips at once
    law = FourParameterIwan(np.array([0]), k, s, np.array([0.0]), np.array([1e9]))
    motion = np.array([[4e-8, 3e-8]])
    one = ConstantLoad(np.array([0]), k, s)
    np.testing.assert_allclose(law.force(motion), one.force(motion), rtol=1e-8)


def many(count=300):
    random = np.random.default_rng(3)
    on = np.concatenate([[0, 1, 2], random.integers(0, 3, count - 3)])
    shapes = random.uniform(-0.95, 0.0, count), random.choice([0.0, 0.1, 3.0], count)
    return FourParameterIwan(
        on, 10 ** random.uniform(6, 9, count), random.gamma(1, 4, count), *shapes
    )


def test_tangent_is_the_derivative_of_the_force():
    random = np.random.default_rng(1)
    law = many()
    for size in 10.0 ** np.arange(-10, -3):
        motion = size * random.normal(size=(3, 2))
        force, tangent = law.force_and_tangent(motion)
        np.testing.assert_array_equal(force, law.force(motion))
        for j in range(2):
            step = np.zeros((3, 2))
            step[:, j] = 1e-5 * size
            found = (law.force(motion + step) - law.force(motion - step)) / (2e-5 * size)
            # central differences: error of the order of 1e-10, and rounding of the same
            error = abs(tangent[:, :, j] - found).max()
            assert error < 1e-7 * abs(tangent).max()


def test_at_rest_it_sticks_and_moving_it_slips():
    law = many()
    force, tangent = law.force_and_tangent(np.zeros((3, 2)))
    assert not force.any()
    np.testing.assert_allclose(tangent[:, 0, 0], law.stuck_stiffness(3)[:, 0])
    assert set(law.contact_state(np.zeros((3, 2)))) == {STICK}
    assert set(law.contact_state(np.full((3, 2), 1e-9))) == {STICK_SLIP}


@pytest.mark.parametrize("law", [many(), replace(many(), beta=np.zeros(300))])
def test_followed_in_time_it_has_the_same_force(law):
    motion = np.zeros((3, 6))
    motion[:, 1:3] = np.random.default_rng(5).normal(scale=1e-7, size=(3, 2))
    exact, errors = law.force(motion[:, 1:3]), []
    for samples in (500, 4000):
        found = law.forces_in_time(motion, samples)
        assert not found[:, 3:].any()
        errors.append(np.linalg.norm(found[:, 1:3] - exact) / np.linalg.norm(exact))
    assert errors[0] < 1e-5
    # of second order at the corners where all of an element slips, and they hardly count
    assert errors[0] / errors[1] > 64


def test_about_another_mean_its_rule_is_that_of_its_sliders():
    law = many(12)
    motion = np.random.default_rng(6).normal(scale=1e-7, size=(3, 6))
    exact, by_sliders = law.forces_in_time(motion, 2048), SlidersInTime(law.sliders())
    difference = by_sliders.evaluate(motion, 0.0, 2048)[:, :3] - exact[:, :3]
    assert abs(difference).max() < 1e-4 * abs(exact).max()
    found = law.sliders()
    for total, values in (
        (law.tangential_stiffness, found.tangential_stiffness),
        (law.slip_force, found.friction_coefficient),
    ):
        np.testing.assert_allclose(np.bincount(found.element, values), total, rtol=1e-12)


@pytest.mark.parametrize("chi", [-0.9, -0.5, 0.0])
@pytest.mark.parametrize("ratio", [1.15, 1.02])
def test_its_sliders_err_as_their_ratio_tells(chi, ratio):
    law = element((1e8, 3.0, chi, 0.0))
    found = law.sliders(ratio)
    slip_force = found.friction_coefficient
    phi = slip_force / found.tangential_stiffness
    amplitude = law.largest_slip_displacement[0] * np.geomspace(1e-3, 1.0, 3000)
    slips = phi < amplitude[:, None]
    force = np.where(slips, slip_force, found.tangential_stiffness * amplitude[:, None]).sum(axis=1)
    error = force / law.loading_curve(amplitude)[:, 0] - 1
    assert -1e-12 < error.min() < error.max() < 0.23 * np.log(ratio) ** 2
    loss = np.where(slips, 4 * slip_force * (amplitude[:, None] - phi), 0.0).sum(axis=1)
    motion = np.column_stack([amplitude, np.zeros_like(amplitude)])
    many_alike = replace(
        law,
        point_of_element=np.arange(amplitude.size),
        **{name: np.full(amplitude.size, getattr(law, name)[0]) for name in law.quantities},
    )
    error = loss / (np.pi * amplitude * many_alike.force(motion)[:, 1]) - 1
    assert 0.09 * np.log(ratio) ** 2 < abs(error).max() < 0.65 * np.log(ratio) ** 2


def test_aft_of_one_harmonic_has_its_force_tangent_and_state():
    law = many(12)
    motion = 1e-7 * np.random.default_rng(7).normal(size=(3, 2))
    force, tangent = AlternatingFrequencyTime(law, samples=512).force_and_tangent(motion)
    exact = law.force_and_tangent(motion)
    np.testing.assert_allclose(force, exact[0], atol=2e-5 * abs(exact[0]).max())
    # the corner where all of an element slips lies within a sample
    np.testing.assert_allclose(tangent, exact[1], atol=2e-3 * abs(exact[1]).max())
    at_rest = motion * [[1], [0], [1]]
    states = AlternatingFrequencyTime(law).contact_state(at_rest)
    assert set(states) == {STICK, STICK_SLIP}
    np.testing.assert_array_equal(states, law.contact_state(at_rest))


def joint_of_iwan_elements():
    joint = make_joint()
    old = joint.law
    shape = np.full(old.slip_force.size, -0.5), np.full(old.slip_force.size, 0.3)
    law = FourParameterIwan(old.point_of_element, old.tangential_stiffness, old.slip_force, *shape)
    return replace(joint, law=law)


def test_a_joint_is_stored_solved_and_holds_in_time():
    joint = joint_of_iwan_elements()
    stored = joint_to_dataset(joint)
    assert joint_from_dataset(stored).law.name == "iwan"
    response = solve_response(joint, [0.1, 5.0], damping=0.002)
    assert response["complete"].all()
    assert check_solutions(stored, response)["residual_in_time"].max() < 1e-6


def test_it_is_made_of_pairs_under_load_by_the_keys_of_a_case():
    pairs = ContactPairs(np.array([10.0, 0.0, 30.0]), np.array([0, 1e-6, 0]), np.zeros((3, 3)))
    keys = {"tangential_stiffness": 1e8, "friction_coefficient": 0.1, "chi": -0.5, "beta": 0.3}
    law, on = FourParameterIwan.from_contact(pairs, **keys)
    np.testing.assert_array_equal(on, [0, 2])
    np.testing.assert_allclose(law.slip_force, [1.0, 3.0])
    contact = Case.model_validate(
        {
            "assembly": "a",
            "preload_N": 1.0,
            "contact": {
                "law": "iwan",
                "tangential_stiffness_N_per_m": 1e8,
                "friction_coefficient": 0.1,
                "chi": -0.5,
                "beta": 0.3,
            },
            "forces_N": [1.0],
            "modes": ["free-4"],
            "coordinates": ["linear"],
            "solve": [{"resonance": 1, "joints": ["node-to-node", "regions=2"]}],
        }
    ).contact
    assert contact.options == {"law": "iwan", **keys}


@pytest.mark.parametrize(("chi", "beta"), [(-1.0, 0.1), (0.1, 0.1), (-0.5, -0.1)])
def test_impossible_shapes_are_refused(chi, beta):
    with pytest.raises(ValueError, match=r"(chi|beta) must be"):
        element((1e8, 3.0, chi, beta))


def test_every_law_is_declared():
    assert set(LAWS) == set(DECLARATIONS)


def test_peaks_by_aft_are_the_analytic_ones():
    joint = make_joint(6, law="iwan")
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law))
    forces = [0.1, 1.0, 10.0, 40.0]
    exact, found = (solve_response(one, forces, damping=0.002) for one in (joint, sampled))
    error = found["peak_amplitude"] / exact["peak_amplitude"] - 1
    # that of samples at the corners where all of an element slips
    assert abs(error).max() < 5e-6


def test_error_bars_of_converged_peaks_hold():
    held = []
    for index in range(8):
        joint, force, loss_factor = random_joint("iwan", index, seed=31)
        response = solve_response(joint, [force], damping=loss_factor)
        found = add_converged_peaks(response, converge_peaks(joint, response))
        highest = 3 * int(found["peak_harmonics"][0])
        further = HarmonicConvergence(
            (highest // 2, highest), amplitude_tolerance=1e-12, samples=2048
        )
        best = converge_peaks(joint, response, further)
        assert best["peak_harmonics"] == highest
        for what in ("frequency", "amplitude"):
            exact = best[f"peak_{what}_converged"]
            for name, bar in (
                (f"peak_{what}", f"peak_{what}_error"),
                (f"peak_{what}_converged", f"peak_{what}_truncation_error"),
            ):
                held.append(bool((abs(found[name] / exact - 1) <= found[bar]).all()))
    assert len(held) == 32
    assert all(held)


def test_time_integration_reaches_the_motion_of_many_harmonics():
    joint = make_joint(2, law="iwan")
    response = solve_response(joint, [20.0], damping=0.01)
    start = motion_at_peak(response, 20.0)
    located = find_peak(joint, start[0], 20.0, 0.01, start[1], harmonics=17, samples=512)
    peak, motion = located.frequency, located.motion
    found = steady_state(joint, peak, 20.0, 0.01, start=motion.in_time(300), steps=300)
    assert found.converged
    amplitude = abs(motion.amplitude(joint.response_mode))
    # what its sliders and the steps, in square, leave out
    assert abs(found.amplitude) == pytest.approx(amplitude, rel=3e-4)
