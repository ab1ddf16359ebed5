"""The grammar of harmonic components."""

import numpy as np
import pytest
from harmonic_names import parse_component

from boltjoint.harmonics import Components


@pytest.mark.parametrize(("highest", "is_odd"), [(1, False), (1, True), (4, False), (5, True)])
def test_components_know_their_harmonics_and_places(highest, is_odd):
    components = Components.up_to(highest, is_odd=is_odd)
    parsed = [parse_component(name) for name in components]
    np.testing.assert_array_equal(components.number, [number for _, number in parsed])
    np.testing.assert_array_equal(components.is_sine, [part == "sin" for part, _ in parsed])
    assert components.highest == highest
    assert components.has_bias == (not is_odd)
    numbers = [h for h, _, _ in components.harmonics]
    assert numbers == list(range(1, highest + 1, 2 if is_odd else 1))
    for h, s, c in components.harmonics:
        assert parsed[s] == ("sin", h) and parsed[c] == ("cos", h)
        assert (s, c) == (components.sin(h), components.cos(h))
    if not is_odd:
        assert components[components.bias] == "bias"
    # they are names like any other
    assert components == tuple(components)


def test_a_motion_a_quarter_later_is_its_derivative():
    components, samples = Components.up_to(3), 240
    x = np.random.default_rng(0).normal(size=len(components))
    place, sign = components.quarter_later()
    # the phase moves by a quarter of the period of each harmonic on its own
    t = np.arange(samples) / samples
    for h, s, c in components.harmonics:
        moved = (sign * x[place])[[s, c]] @ components.at_samples(samples)[[s, c]]
        phase = 2 * np.pi * (h * t + 0.25)
        expected = x[s] * np.sin(phase) + x[c] * np.cos(phase)
        np.testing.assert_allclose(moved, expected, atol=1e-12)
    assert sign[components.bias] == 0


def test_a_turned_motion_is_that_of_later_times():
    components, samples, steps = Components.up_to(4), 60, 7
    x = np.random.default_rng(1).normal(size=(len(components), 2))
    turned = components.turned(x, steps * 2 * np.pi / samples)
    values = components.at_samples(samples)
    np.testing.assert_allclose(turned.T @ values, np.roll(x.T @ values, -steps, axis=1), atol=1e-12)


def test_samples_are_sines_and_cosines_of_whole_periods():
    components, samples = Components.up_to(30), 64
    values = components.at_samples(samples)
    phase = 2 * np.pi * np.arange(samples) / samples
    for name, row in zip(components, values, strict=True):
        part, h = parse_component(name)
        expected = np.sin(h * phase) if part == "sin" else np.cos(h * phase)
        np.testing.assert_allclose(row, expected, atol=1e-12)


def test_rows_stand_one_component_after_another():
    components = Components(("sin", "cos"))
    np.testing.assert_array_equal(components.rows(np.arange(6.0)), [[0, 1, 2], [3, 4, 5]])
