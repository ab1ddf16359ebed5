"""Iwan elements along motions of several harmonics, against many thousands of sliders."""

import numpy as np
import pytest
from numba import njit

from boltjoint.friction import iwan_at_samples
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.iwan import FourParameterIwan

HARMONICS, SAMPLES = 9, 256
SLIDERS = 20_000


def element(chi, beta, count=1):
    springs = np.full(count, 1e8), np.full(count, 3.0)
    return FourParameterIwan(np.arange(count), *springs, np.full(count, chi), np.full(count, beta))


def slider_set(law, count=SLIDERS):
    """Stiffnesses of sliders, and displacements at which they slip, of the first element."""
    chi, beta = law.chi[0], law.beta[0]
    phi_max = law.largest_slip_displacement[0]
    cut = np.append(0.0, np.geomspace(1e-8, 1.0, count))
    stiffness = np.diff(cut ** (chi + 1))
    phi = np.diff(cut ** (chi + 2)) * (chi + 1) / (chi + 2) / stiffness
    stiffness = law.tangential_stiffness[0] / (1 + beta) * np.append(stiffness, beta)
    return stiffness, phi_max * np.append(phi, 1.0)


def follow(sliders, u):
    """Force along displacements from rest."""
    force = np.zeros_like(u)
    add_forces(*sliders, u, force)
    return force


@njit(error_model="numpy")
def add_forces(stiffness, phi, u, force):
    for e in range(phi.size):
        k, limit, position = stiffness[e], phi[e], 0.0
        for i in range(u.size):
            position = min(max(position, u[i] - limit), u[i] + limit)
            force[i] += k * (u[i] - position)


def through_vertices(u):
    """A period of displacements with the vertices between them, and where the samples are."""
    path, at = [], []
    for i, now in enumerate(u):
        before, after = u[i - 1], u[(i + 1) % u.size]
        time, vertex = 0.0, None
        if (now - before) * (after - now) <= 0:
            curve = np.polyfit([-1, 0, 1], [before, now, after], 2)
            time = -curve[1] / 2 / curve[0]
            vertex = np.polyval(curve, time)
        if vertex is not None and time < 0:
            path.append(vertex)
        at.append(len(path))
        path.append(now)
        if vertex is not None and time >= 0:
            path.append(vertex)
    return np.array(path), np.array(at)


def component_values(law, samples=SAMPLES):
    """Values of the odd components and of their derivatives, each (components, samples)."""
    phase = 2 * np.pi * np.arange(samples) / samples
    number = np.array([int(name[3:] or 1) for name in law.components])[:, None]
    sine = np.array([name.startswith("sin") for name in law.components])[:, None]
    values = np.where(sine, np.sin(number * phase), np.cos(number * phase))
    return values, number * np.where(sine, np.cos(number * phase), -np.sin(number * phase))


def random_motion(law, size, seed):
    """Harmonics that fall with their number and reverse several times, of a largest value."""
    motion = np.random.default_rng(seed).normal(size=(1, len(law.components)))
    motion /= np.repeat(np.arange(1, HARMONICS + 1, 2), 2)
    values = component_values(law)[0]
    return motion * size / abs(motion @ values).max()


@pytest.mark.parametrize(("chi", "beta"), [(-0.9, 0.0), (-0.5, 0.3), (-0.1, 3.0), (0.0, 0.0)])
def test_forces_and_dissipation_are_those_of_many_sliders_over_five_decades(chi, beta):
    elements = element(chi, beta)
    law = AlternatingFrequencyTime(elements, HARMONICS, SAMPLES)
    sliders = slider_set(elements)
    values, rates = component_values(law)
    for seed, size in enumerate(np.geomspace(1e-4, 10.0, 6)):
        motion = random_motion(law, size * elements.largest_slip_displacement[0], seed)
        path, at = through_vertices((motion @ values)[0])
        assert path.size > SAMPLES + 1
        force = follow(sliders, np.tile(path, 2))[path.size :][at]
        expected = 2 / SAMPLES * values @ force
        found = law.force(motion)[0]
        # the error of sliders: the square of the logarithm of their ratio, 1e-3
        assert np.linalg.norm(found - expected) < 1e-6 * np.linalg.norm(expected)
        power = motion[0] @ rates @ values.T
        assert power @ found == pytest.approx(power @ expected, rel=1e-6)


def test_in_microslip_the_error_of_samples_is_of_third_order():
    samples, errors = np.array([32, 64, 128, 256]), []
    phase = np.linspace(0, np.pi, 50)
    for chi in (-0.9, -0.4, 0.0):
        elements = element(chi, 0.3, phase.size)
        size = 0.3 * elements.largest_slip_displacement[:1]
        motion = size * np.column_stack([np.sin(phase), np.cos(phase)])
        exact = elements.force(motion)
        found = [AlternatingFrequencyTime(elements, samples=int(n)).force(motion) for n in samples]
        errors.append([np.linalg.norm(f - exact) / np.linalg.norm(exact) for f in found])
    for error in errors:
        assert error[-1] < 1e-6
        assert -np.polyfit(np.log(samples), np.log(error), 1)[0] > 2.8


def test_delay_is_the_derivative_by_the_rate_of_growth():
    chi, fine, periods, change, rate = -0.4, 2048, 3, 1e-12, 1e-2
    elements = element(chi, 0.5)
    law = AlternatingFrequencyTime(elements, 3, SAMPLES)
    values = component_values(law, fine)[0]
    random = np.random.default_rng(4)
    motion, direction = random.normal(size=(2, 4))
    motion *= elements.largest_slip_displacement[0] / abs(motion @ values).max()
    sliders = slider_set(elements, 3000)
    time = np.arange(periods * fine) / fine - (periods - 1)
    u, du = (np.tile(each @ values, periods) for each in (motion, direction))
    start = follow(sliders, u)[-fine:]
    tangents = []
    for growing in (rate, -rate):
        growth = np.exp(growing * time)
        force = follow(sliders, u + change * growth * du)[-fine:]
        derivative = (force - start) / change / growth[-fine:]
        tangents.append(2 / fine * values @ derivative)
    expected = (tangents[0] - tangents[1]) / (2 * rate), (tangents[0] + tangents[1]) / 2
    rows, amplitude = (np.ones((1, 1)),), motion[:, None]
    delay = law.modal_slider_delay(rows, amplitude, 0.0)[:, 0, :, 0] @ direction
    tangent = law.modal_force_and_tangent(rows, amplitude, 0.0)[1]()[:, 0, :, 0] @ direction
    # which of 3000 sliders slips last is known to 0.6 % of their displacement
    for found, of_sliders in zip((delay, tangent), expected, strict=True):
        np.testing.assert_allclose(found, of_sliders, atol=5e-3 * abs(of_sliders).max())


def test_many_elements_are_summed_in_parts(monkeypatch):
    random = np.random.default_rng(0)
    law = AlternatingFrequencyTime(element(-0.5, 0.2, 60), 3, 64)
    rows, amplitude = (random.normal(size=(60, 3)),), 1e-8 * random.normal(size=(4, 3))

    def found():
        tangent = law.modal_force_and_tangent(rows, amplitude, 0.0)[1]()
        return tangent, law.modal_slider_delay(rows, amplitude, 0.0)

    whole = found()
    monkeypatch.setattr(iwan_at_samples, "_ELEMENTS_AT_ONCE", 7)
    for parts, together in zip(found(), whole, strict=True):
        assert together.any()
        np.testing.assert_allclose(parts, together, rtol=1e-9, atol=1e-12 * abs(together).max())


def test_a_standstill_within_the_period_is_no_reversal():
    """At rest it is a spring; a constant displacement is the end of first loading."""
    elements = element(-0.5, 0.2)
    law = AlternatingFrequencyTime(elements, 3, 64)
    force, tangent = law.force_and_tangent(np.zeros((1, 4)))
    assert not force.any()
    np.testing.assert_allclose(tangent[0], 1e8 * np.eye(4), atol=1e-4)
    size = 0.5 * elements.largest_slip_displacement[0]
    held = elements.forces_in_time(np.array([[size, 0, 0, 0, 0, 0]]), 64)
    expected = [elements.loading_curve(np.array([size]))[0, 0], 0, 0]
    np.testing.assert_allclose(held[0, :3], expected, atol=1e-12)
