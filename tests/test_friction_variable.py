"""Friction under variable normal load against time integration and closed forms."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from scipy.integrate import quad

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.contact_states import SEPARATION, STICK, STICK_SLIP, STICK_SLIP_SEPARATION
from boltjoint.friction.coupled import CoupledVariableLoad
from boltjoint.friction.uncoupled import UncoupledVariableLoad
from boltjoint.friction.variable import VariableLoad

OPEN, STUCK, POSITIVE_SLIP, NEGATIVE_SLIP = range(4)


@njit(cache=True)
def integrate(x, n, mu, samples, start=0.0):
    """Time integration of elements through two periods, in short steps.

    ``x = k_u u`` and ``n = n0 + k_v v`` hold bias, sine and cosine. The slider z is kept between
    the bounds at every sample. Where n rose through zero between two samples, z is what x was
    there, by linear interpolation: with x of the last open sample instead, the error is of first
    order.

    Returns harmonics of friction force and normal load in the second period, and its successive
    states, -1 after the last. There are more than the array holds only where a bound moves by
    rounding.
    """
    sines = np.sin(2 * np.pi * np.arange(samples) / samples)
    cosines = np.cos(2 * np.pi * np.arange(samples) / samples)
    force, runs = np.zeros((len(mu), 6)), np.full((len(mu), 16), -1)
    for e in range(len(mu)):
        x_0, x_s, x_c = x[e]
        n_0, n_s, n_c = n[e]
        z, x_before, n_before, run = start, x_0 + x_c, n_0 + n_c, -1
        for i in range(2 * samples + 1):
            sine, cosine = sines[i % samples], cosines[i % samples]
            x_now, n_now = x_0 + x_s * sine + x_c * cosine, n_0 + n_s * sine + n_c * cosine
            state = OPEN
            if n_now <= 0:
                z = x_now
            else:
                state = STUCK
                if n_before <= 0:
                    z = x_before + (x_now - x_before) * n_before / (n_before - n_now)
                lower, upper = x_now - mu[e] * n_now, x_now + mu[e] * n_now
                if z < lower:
                    z, state = lower, POSITIVE_SLIP
                elif z > upper:
                    z, state = upper, NEGATIVE_SLIP
            x_before, n_before = x_now, n_now
            if i <= samples:
                continue
            if run < 0 or runs[e, run] != state:
                run = min(run + 1, runs.shape[1] - 1)
                runs[e, run] = state
            for j, part in enumerate((1.0, 2 * sine, 2 * cosine)):
                force[e, j] += part * (x_now - z) / samples
                force[e, 3 + j] += part * max(n_now, 0.0) / samples
    return force, runs


class Elements(NamedTuple):
    """Elements on one point each, and the motion of the points."""

    law: VariableLoad
    motion: np.ndarray

    @property
    def x(self):
        """Force of the tangential spring without slip."""
        return self.law.tangential_stiffness[:, None] * self.motion[:, :3]

    @property
    def n(self):
        """Force of the normal spring, negative in separation."""
        n = self.law.normal_stiffness[:, None] * self.motion[:, 3:]
        n[:, 0] += self.law.normal_load
        return n

    @property
    def scale(self):
        """Scale of the forces of every element: the amplitudes of x and n."""
        x, n, mu = self.x, self.n, self.law.friction_coefficient
        return np.hypot(x[:, 1], x[:, 2]) + (1 + mu) * np.hypot(n[:, 1], n[:, 2])

    @property
    def size(self):
        """The same with the constant parts: the scale of rounding errors."""
        x, n, mu = self.x, self.n, self.law.friction_coefficient
        return np.abs(x).sum(axis=1) + (1 + mu) * (
            np.abs(n).sum(axis=1) + np.abs(self.law.normal_load)
        )

    def part(self, chosen):
        values = [getattr(self.law, name)[chosen] for name in self.law.quantities]
        return Elements(VariableLoad(np.arange(chosen.sum()), *values), self.motion[chosen])

    def and_of(self, others):
        values = [
            np.concatenate([getattr(self.law, name), getattr(others.law, name)])
            for name in self.law.quantities
        ]
        motion = np.vstack([self.motion, others.motion])
        return Elements(VariableLoad(np.arange(len(motion)), *values), motion)

    def integrate(self, samples, start=0.0):
        force, runs = integrate(self.x, self.n, self.law.friction_coefficient, samples, start)
        # the structure is in equilibrium with the load of the assembled state
        force[:, 3] -= np.maximum(self.law.normal_load, 0)
        return force, runs


def elements_of(x, n, mu, normal_load=0.0):
    """Elements of unit stiffness by bias, sine and cosine of x and n."""
    x, n, mu = np.atleast_2d(x), np.atleast_2d(n), np.atleast_1d(np.asarray(mu, dtype=float))
    count = len(mu)
    one = np.ones(count)
    law = VariableLoad(np.arange(count), one, one, normal_load * one, mu)
    motion = np.hstack([x, n]).astype(float)
    motion[:, 3] -= normal_load
    return Elements(law, motion)


def random_elements(count, seed=0):
    """Elements closed and open, every ratio of their motions and loads spread evenly in logarithm.

    Over three decades for a half, over less than one for the other, so that none outweighs another.
    A few move in one direction only, and a few just close or just separate.
    """
    random = np.random.default_rng(seed)
    width = random.choice([0.45, 1.5], count)

    def ratio():
        return 10 ** (width * random.uniform(-1, 1, count))

    def either():
        return random.choice([-1, 1], count)

    def motion(bias, swing):
        phase = random.uniform(0, 2 * np.pi, count)
        return np.column_stack([bias, swing * np.cos(phase), swing * np.sin(phase)])

    k_u, mu = 10 ** random.uniform(6, 9, count), 0.4 * ratio()
    k_v = k_u * ratio()
    normal_load = 10 ** random.uniform(-1, 3, count) * either()
    swing, bias = np.abs(normal_load) * ratio(), np.abs(normal_load) * ratio() * either()
    special = random.choice(5, count, p=[0.8, 0.05, 0.05, 0.05, 0.05])
    margin = swing * 10 ** random.uniform(-12, -3, count)
    bias = np.where(special == 1, margin - swing - normal_load, bias)
    bias = np.where(special == 2, swing - margin - normal_load, bias)
    across = motion(bias, swing)
    slip_force = mu * np.maximum(normal_load + bias + swing, swing)
    along = motion(slip_force * ratio() * either(), slip_force * ratio())
    across[special == 3] = 0.0
    along[special == 4] = 0.0
    law = VariableLoad(np.arange(count), k_u, k_v, normal_load, mu)
    return Elements(law, np.hstack([along / k_u[:, None], across / k_v[:, None]]))


def matched_elements(count):
    """Elements that close and open, with a tangential motion near the slip limit."""
    random = np.random.default_rng(14)
    mu, phase = 10 ** random.uniform(-1, 0.4, count), random.uniform(0, 2 * np.pi, (2, count))
    x, n = np.zeros((count, 3)), np.zeros((count, 3))
    n[:, 0], amplitude = random.uniform(-0.5, 1, count), mu * 10 ** random.uniform(-0.1, 0.3, count)
    n[:, 1], n[:, 2] = np.cos(phase[0]), np.sin(phase[0])
    x[:, 1], x[:, 2] = amplitude * np.cos(phase[1]), amplitude * np.sin(phase[1])
    return elements_of(x, n, mu)


def sequence(runs):
    """Successive states of an element over the period, as in SEQUENCES."""
    runs = [int(state) for state in runs if state >= 0]
    if len(runs) > 1 and runs[0] == runs[-1]:
        runs.pop()
    turns = [runs[i:] + runs[:i] for i in range(len(runs))]
    return "".join("os+-"[state] for state in min(turns))


def reverses_while_closed(elements):
    """Whether the contact is closed at an extreme of the tangential motion."""
    x, n = elements.x, elements.n
    swing = np.hypot(x[:, 1], x[:, 2])
    return n[:, 0] * swing + np.abs(n[:, 1] * x[:, 1] + n[:, 2] * x[:, 2]) > 0


#: All sequences of states of an element in a period (o open, s stick, + and - slip) among nine
#: million random motions, beginning at contact closing or, without separation, in stick.
SEQUENCES = {
    *("o", "s", "s+s-"),
    *("os", "os+", "os-", "os+s", "os-s", "os+s-", "os-s+"),
    *("o+", "o-", "o+s", "o-s", "o+s-", "o-s+", "o+s-s", "o-s+s", "o+s-s+", "o-s+s-"),
}
#: Sequences with a share below one in a thousand.
RARE = {"os+s", "os-s", "o+s", "o-s", "o+s-s", "o-s+s"}

#: Error of time integration over (2 pi / samples)^2 and the amplitude of x and (1 + mu) n. It is an
#: eighth where a turning point lies midway between samples.
INTEGRATION_ERROR = 0.15


@pytest.fixture(scope="module")
def integrated():
    """Random elements with the force and the sequence of time integration in short steps.

    With those of many others whose sequence is rare by time integration in long steps.
    """
    more = matched_elements(50_000)
    rare = np.array([sequence(one) in RARE for one in more.integrate(1000)[1]])
    elements, samples = random_elements(12_000).and_of(more.part(rare)), 20_000
    force, runs = elements.integrate(samples)
    return elements, samples, force, np.array([sequence(one) for one in runs])


def assert_agrees(elements, force, integrated, samples):
    # and rounding where the constant parts outweigh the amplitudes
    allowed = (
        INTEGRATION_ERROR * (2 * np.pi / samples) ** 2 * elements.scale + 1e-13 * elements.size
    )
    error = np.abs(force - integrated).max(axis=1)
    worst = np.argmax(error - allowed)
    assert error[worst] <= allowed[worst], (
        elements.x[worst],
        elements.n[worst],
        elements.law.friction_coefficient[worst],
    )


# the analytic solution against time integration


def test_forces_equal_time_integration(integrated):
    elements, samples, force, _ = integrated
    assert_agrees(elements, elements.law.force(elements.motion), force, samples)


def test_time_integration_converges_to_the_forces_with_second_order():
    elements = random_elements(3000, seed=1)
    exact = elements.law.force(elements.motion)
    moves = elements.scale > 0
    errors = []
    for samples in (500, 1000, 2000):
        force, _ = elements.integrate(samples)
        assert_agrees(elements, exact, force, samples)
        error = np.abs(force - exact).max(axis=1)[moves] / elements.scale[moves]
        # a mean over elements, since single errors depend on where samples meet corners
        errors.append(np.sqrt(np.mean(error**2)))
    np.testing.assert_allclose(np.diff(np.log2(errors)), -2, rtol=0, atol=0.1)


def test_states_are_those_of_time_integration(integrated):
    elements, _, _, sequences = integrated
    state = elements.law.contact_state(elements.motion)
    # separation shorter than a sample is told by the range of the normal load
    swing = np.hypot(elements.n[:, 1], elements.n[:, 2])
    opens, closes = elements.n[:, 0] < swing, elements.n[:, 0] > -swing
    slips = np.char.count(sequences, "s+") + np.char.count(sequences, "s-") > 0
    expected = np.where(slips, STICK_SLIP, STICK)
    expected[opens] = STICK_SLIP_SEPARATION
    expected[~closes] = SEPARATION
    np.testing.assert_array_equal(state, expected)
    assert np.all(np.bincount(state) > 500)


def test_random_elements_have_all_sequences_of_states(integrated):
    elements, _, _, sequences = integrated
    found, count = np.unique(sequences, return_counts=True)
    assert set(found) == SEQUENCES
    assert count.min() >= 10

    law, n = elements.law, elements.n
    swing = np.hypot(n[:, 1], n[:, 2])
    both = [one for one in SEQUENCES if "s" in one and ("+" in one or "-" in one)]
    situations = {
        "always open": sequences == "o",
        "always stuck": sequences == "s",
        "open without bias, closed by it": (law.normal_load < -swing) & (n[:, 0] > swing),
        "separated by the bias": (law.normal_load > swing) & (n[:, 0] < -swing),
        "closes for a vanishing time": np.abs(n[:, 0] / np.maximum(swing, 1e-300) + 1) < 1e-6,
        "separates for a vanishing time": np.abs(n[:, 0] / np.maximum(swing, 1e-300) - 1) < 1e-6,
        "slips without reversal": np.isin(sequences, both) & ~reverses_while_closed(elements),
        "no tangential motion": ~np.any(elements.motion[:, :3], axis=1) & (sequences != "o"),
        "no normal motion": ~np.any(elements.motion[:, 3:], axis=1) & (sequences != "o"),
        "friction above the normal load": law.friction_coefficient > 1,
    }
    rare = {name: chosen.sum() for name, chosen in situations.items() if chosen.sum() < 100}
    assert not rare


def test_whole_numbers_at_which_transitions_coincide():
    """Bounds with an extreme at closing, constant bounds, and contact for one phase only."""
    random, count, samples = np.random.default_rng(2), 20_000, 1000
    x, n = random.integers(-2, 3, (2, count, 3))
    mu = random.choice([0.1, 0.3, 1 / 3, 0.5, 1, 2], count)
    elements = elements_of(x, n, mu)
    force, tangent = elements.law.force_and_tangent(elements.motion)
    assert_agrees(elements, force, elements.integrate(samples)[0], samples)
    assert np.all(np.isfinite(tangent))


def test_a_constant_bound_causes_no_slip():
    random, count, samples = np.random.default_rng(3), 5000, 1000
    n, mu = random.normal(size=(count, 3)), 10 ** random.uniform(-1, 0.4, count)
    # some are open for one phase only; in others the bound moves by rounding
    closed, moves = np.arange(count) % 2 == 0, np.arange(count) % 3 == 0
    n[closed, 0] = np.sqrt(n[closed, 1] ** 2 + n[closed, 2] ** 2)
    x = mu[:, None] * n * random.choice([-1, 1], (count, 1))
    x[:, 0] *= random.integers(-1, 3, count)
    x[moves, 1:] *= 1 + 2.0 ** -random.integers(50, 53, (moves.sum(), 1))
    elements = elements_of(x, n, mu)
    integrated, _ = elements.integrate(samples)
    assert_agrees(elements, elements.law.force(elements.motion), integrated, samples)
    assert np.all(elements.law.contact_state(elements.motion)[closed & ~moves] == STICK)


@pytest.mark.parametrize("ratio", [1e-20, 1e-12, 1e12, 1e20])
def test_motions_and_loads_of_any_ratio(ratio):
    random, count, samples = np.random.default_rng(4), 2000, 1000
    x, n = ratio * random.normal(size=(count, 3)), random.normal(size=(count, 3))
    elements = elements_of(x, n, np.full(count, 0.3))
    integrated, _ = elements.integrate(samples)
    assert_agrees(elements, elements.law.force(elements.motion), integrated, samples)


TURN = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])

#: x, n and mu on the border between two sequences of states, and a step across it
BORDERS = {
    "closes": ([0.2, 0.7, 0.4], [-1, 0, 1], 0.4, [0, 0, 0], [1, 0, 0]),
    "separates": ([0.2, 0.7, 0.4], [1, 0, 1], 0.4, [0, 0, 0], [1, 0, 0]),
    "slips": ([0, 0, 1], [2, 0, 0], 0.5, [0, 0, 1], [0, 0, 0]),
    "slips under varying load": ([0.1, 0.3, 0.2], [1, 0.3, 0.2], 1.0, [1, 0, 0], [0, 1, 0]),
    "meets with a bound at its bottom": ([0, 0.5, -1], [0, 1, 0], 0.5, [0, 1, 0], [0, 0, 0]),
    "meets with a bound at its top": ([0, 0.5, 1], [0, 1, 0], 0.5, [0, 1, 0], [0, 0, 0]),
    "meets with a bound at rest": ([0.3, 0.5, 0], [0, 1, 0], 0.5, [0, 1, 0], [0, 0, 0]),
    "is carried from the surface to the bound": ([0.5, 0.2, 0], [1, 0, 0], 0.3, [1, 0, 0], [0] * 3),
    "is at rest": ([0, 0, 0], [1, 0, 0], 0.5, [0, 1, 0], [0, 0, 1]),
    "is at rest under the bound": ([0.5, 0, 0], [1, 0, 0], 0.5, [0, 1, 0], [0, 0, 1]),
}


@pytest.mark.parametrize("side", [1, -1], ids=["positive", "negative"])
@pytest.mark.parametrize("turn", [np.eye(2), TURN], ids=["exactly", "by-rounding"])
@pytest.mark.parametrize("border", BORDERS)
def test_forces_are_continuous_across_every_border(border, turn, side):
    x, n, mu, x_step, n_step = BORDERS[border]
    distance = np.concatenate([[0.0], np.outer([-1, 1], 10.0 ** np.arange(-17, -2)).ravel()])
    x = side * (np.array(x) + np.outer(distance, x_step))
    n = np.array(n) + np.outer(distance, n_step)
    x[:, 1:], n[:, 1:] = x[:, 1:] @ turn.T, n[:, 1:] @ turn.T
    elements = elements_of(x, n, np.full(len(x), mu))
    force = elements.law.force(elements.motion)
    change = np.abs(force - force[0]).max(axis=1)
    # a bound moves by (1 + mu) of the step, the slider by no more, and a harmonic by 4 / pi of both
    assert np.all(change <= 8 / np.pi * (1 + mu) * np.abs(distance) + 1e-14)


# dependence of the forces on the inputs


@pytest.mark.parametrize("variation", [0.0, 1e-18])
def test_forces_where_the_load_hardly_varies_are_those_of_constant_load(variation):
    random, count = np.random.default_rng(5), 5000
    points, phase = np.arange(count), random.uniform(0, 2 * np.pi, count)
    k_u, load = 10 ** random.uniform(6, 9, count), 10 ** random.uniform(-1, 3, count)
    mu = 10 ** random.uniform(-2, 0.4, count)
    # from deep in stick to deep in slip
    amplitude = mu * load / k_u * 10 ** random.uniform(-1, 2.5, count)
    along = np.column_stack([amplitude * np.cos(phase), amplitude * np.sin(phase)])
    constant, constant_tangent = ConstantLoad(points, k_u, mu * load).force_and_tangent(along)
    across = variation * load[:, None] / k_u[:, None] * random.normal(size=(count, 3))
    motion = np.hstack([np.zeros((count, 1)), along, across])
    force, tangent = VariableLoad(points, k_u, 0.3 * k_u, load, mu).force_and_tangent(motion)
    expected = np.hstack([np.zeros((count, 1)), constant])
    # in deep slip the friction force is a small difference of spring force and slider position
    rounding = 1e-14 * (k_u * amplitude + mu * load)
    assert np.all(np.abs(force[:, :3] - expected).max(axis=1) <= rounding)
    error = np.abs(tangent[:, 1:3, 1:3] - constant_tangent).max(axis=(1, 2))
    assert np.all(error <= 1e-13 * k_u)


def test_forces_next_to_the_slip_limit_are_exact():
    beyond = 10.0 ** np.arange(-16, 0, 0.25)
    amplitude = np.concatenate([1 - beyond, 1 + beyond])
    along = np.column_stack([0 * amplitude, amplitude, 0 * amplitude])
    count = amplitude.size
    elements = elements_of(along, np.tile([2.0, 0, 0], (count, 1)), np.full(count, 0.5))
    ratio = np.minimum(1 / amplitude, 1)
    # the harmonics of the loop, by a slip angle that keeps its digits at pi
    angle = 2 * np.arctan2(np.sqrt(ratio), np.sqrt(1 - ratio))
    sine = 2 * np.sqrt(ratio * (1 - ratio)) * (1 - 2 * ratio)
    expected = np.column_stack([angle - sine, 4 * ratio * (1 - ratio)]) * amplitude[:, None] / np.pi
    np.testing.assert_allclose(
        elements.law.force(elements.motion)[:, 1:3], expected, rtol=0, atol=2e-15
    )


def test_a_shift_in_time_turns_the_forces_along():
    elements = random_elements(3000, seed=6)
    law, motion = elements.law, elements.motion

    def turned(harmonics):
        later = harmonics.copy()
        for at in (1, 4):
            later[:, at : at + 2] = harmonics[:, at : at + 2] @ TURN.T
        return later

    error = np.abs(law.force(turned(motion)) - turned(law.force(motion))).max(axis=1)
    assert np.all(error <= 1e-13 * elements.size)


def test_the_mirrored_motion_mirrors_friction_and_keeps_the_normal_load():
    elements = random_elements(3000, seed=7)
    mirror = np.array([-1, -1, -1, 1, 1, 1])
    force = elements.law.force(elements.motion)
    mirrored = elements.law.force(mirror * elements.motion)
    assert np.all(np.abs(mirrored - mirror * force).max(axis=1) <= 1e-13 * elements.size)


def test_forces_scale_with_stiffness_load_and_motion():
    elements = random_elements(1000, seed=8)
    law, force = elements.law, elements.law.force(elements.motion)
    stiffer = replace(
        law,
        tangential_stiffness=3e3 * law.tangential_stiffness,
        normal_stiffness=3e3 * law.normal_stiffness,
        normal_load=6e3 * law.normal_load,
    )
    error = np.abs(stiffer.force(2 * elements.motion) / 6e3 - force).max(axis=1)
    assert np.all(error <= 1e-13 * elements.size)


def test_elements_on_one_point_add_up_in_any_order():
    law, motion = random_elements(50, seed=9).law, np.array([[2, 1, -3, 1, -2, 4]]) * 1e-7
    every = [getattr(law, name) for name in law.quantities]
    point = np.zeros(50, dtype=np.int64)
    together = VariableLoad(point, *every).force_and_tangent(motion)
    back = VariableLoad(point, *(values[::-1].copy() for values in every)).force_and_tangent(motion)
    alone = law.force_and_tangent(np.repeat(motion, 50, axis=0))
    for of_all, of_back, of_each in zip(together, back, alone, strict=True):
        rounding = 1e-13 * np.abs(of_each).sum(axis=0)
        assert np.all(np.abs(of_all[0] - of_each.sum(axis=0)) <= rounding)
        assert np.all(np.abs(of_back[0] - of_each.sum(axis=0)) <= rounding)


def test_steady_state_depends_on_the_start_only_in_stick():
    elements, samples = random_elements(2000, seed=10), 1000
    far = elements.integrate(samples, start=1e9)[0]
    force = elements.law.force(elements.motion)
    stuck = elements.law.contact_state(elements.motion) == STICK
    assert_agrees(elements.part(~stuck), force[~stuck], far[~stuck], samples)


# inputs with closed-form solutions


def force_of(x, n, mu, normal_load=0.0):
    elements = elements_of(x, n, mu, normal_load)
    (force,) = elements.law.force(elements.motion)
    (state,) = elements.law.contact_state(elements.motion)
    return force, state


def test_always_open():
    for n in ([-1, 0.6, 0.7], [-1, 0.6, 0.8], [0, 0, 0]):
        force, state = force_of([0.3, 2, -1], n, 0.4)
        np.testing.assert_array_equal(force, 0)
        assert state == SEPARATION


def test_separation_removes_the_assembled_load_from_the_bias():
    force, state = force_of([0.3, 2, -1], [-1, 0.6, 0.7], 0.4, normal_load=5.0)
    np.testing.assert_array_equal(force, [0, 0, 0, -5, 0, 0])
    assert state == SEPARATION


@pytest.mark.parametrize("slips", [False, True])
def test_a_change_far_smaller_than_the_load_keeps_its_digits(slips):
    law = VariableLoad(np.array([0]), *(np.array([v]) for v in (1e8, 1e8, 1e3, 0.1)))
    motion = np.zeros((1, 6))
    motion[0, 3:] = 3e-23, 1e-23, -2e-23
    motion[0, 1] = 2e-6 if slips else 0.0
    assert (law.contact_state(motion)[0] == STICK_SLIP) == slips
    force = law.force(motion)[0, 3:]
    # a difference of the loads would lose all their digits
    assert 1e3 + 1e8 * 3e-23 == 1e3
    np.testing.assert_allclose(force, 1e8 * motion[0, 3:], rtol=1e-12)


def test_stick_around_the_assembled_state():
    x, n = [0.1, 0.2, -0.3], [3, -0.5, 0.5]
    force, state = force_of(x, n, 0.4)
    np.testing.assert_array_equal(force, x + n)
    assert state == STICK


@pytest.mark.parametrize("side", [1, -1])
def test_residual_traction_in_stick_is_the_least_possible(side):
    """In stick far from the assembled state, friction is at its limit once in the period."""
    # mu n - x is least where 2 + 0.3 sin - 0.4 cos - 0.2 sin is: x reaches beyond it by 5 - 1.59
    slider = 5 - (2 - np.hypot(0.3 - 0.2, 0.4))
    force, state = force_of(np.array([5, 0.2, 0]) * side, [4, 0.6, -0.8], 0.5)
    np.testing.assert_allclose(force[:3], np.array([5 - slider, 0.2, 0]) * side, rtol=1e-14)
    assert state == STICK


def test_friction_under_a_tangential_bias_is_that_of_the_least_load():
    force, state = force_of([5, 0, 0], [4, 0.6, -0.8], 0.5)
    np.testing.assert_allclose(force, [0.5 * (4 - 1), 0, 0, 4, 0.6, -0.8], rtol=1e-14)
    assert state == STICK
    force, state = force_of([5, 0, 0], [0.5, 0.6, -0.8], 0.5)
    np.testing.assert_allclose(force[:3], 0, rtol=0, atol=1e-16)
    assert state == STICK_SLIP_SEPARATION


def test_normal_load_of_an_element_that_separates():
    # n = cos t while that is positive
    force, _ = force_of([0, 0, 0], [0, 0, 1], 0.5)
    np.testing.assert_allclose(force[3:], [1 / np.pi, 0, 0.5], rtol=0, atol=1e-16)


def test_closing_only_by_the_bias():
    # n = -5 + 8 in place of -5: constant load
    force, state = force_of([7, 3, 0], [3, 0, 0], 0.5, normal_load=-5.0)
    expected = ConstantLoad(np.array([0]), np.array([1.0]), np.array([1.5]))
    (along,) = expected.force(np.array([[3.0, 0.0]]))
    # the element slips: its steady state does not depend on the start
    np.testing.assert_allclose(force, [0, *along, 3, 0, 0], rtol=0, atol=1e-15)
    assert state == STICK_SLIP


@pytest.mark.parametrize("margin", 10.0 ** np.arange(-15, -2))
def test_contact_for_a_vanishing_time(margin):
    x, mu = np.array([0.4, 1, 2]), 0.3
    force, state = force_of(x, [margin - 1, 0, 1], mu)
    half = np.arccos(1 - margin)
    # the load is a parabola of height margin; friction is at most mu times it
    np.testing.assert_allclose(
        force[3:], np.array([1, 0, 2]) * 2 / 3 * margin * half / np.pi, rtol=margin, atol=1e-16
    )
    assert np.all(np.abs(force[:3]) <= mu * 2 * force[3] + 1e-16)
    assert state == STICK_SLIP_SEPARATION


def test_slip_begins_without_reversal_of_the_tangential_motion():
    # closed from -pi/2 to pi/2, in which x = b sin increases; stick at first, and the
    # spring's b (1 + sin) meets mu cos at
    b, mu = 0.7, 0.4
    begin = 2 * np.arctan(mu / b) - np.pi / 2
    force, state = force_of([0.2, b, 0], [0, 0, 1], mu)

    def harmonic(of):
        stuck, _ = quad(lambda t: b * (1 + np.sin(t)) * of(t), -np.pi / 2, begin)
        slips, _ = quad(lambda t: mu * np.cos(t) * of(t), begin, np.pi / 2)
        return (stuck + slips) / np.pi

    expected = [harmonic(lambda t: 0.5), harmonic(np.sin), harmonic(np.cos)]
    np.testing.assert_allclose(force[:3], expected, rtol=1e-13)
    assert state == STICK_SLIP_SEPARATION


def test_friction_in_full_slip_follows_the_direction_of_motion():
    # k_u -> infinity: mu n = 1 + cos / 2, in the direction of x' = cos
    force, _ = force_of([0, 1e9, 0], [2, 0, 1], 0.5)
    # while the spring reverses, for a time of sqrt(mu n / (k_u u)) in its unit, it differs
    np.testing.assert_allclose(force[:3], [1 / np.pi, 0, 4 / np.pi], rtol=0, atol=1e-4)


# energy


def test_friction_dissipates_energy_and_the_normal_load_none():
    elements = random_elements(10_000, seed=11)
    force = elements.law.force(elements.motion)

    def work(direction):
        (_, s, c), (_, f_s, f_c) = (
            of[:, 3 * direction : 3 * direction + 3].T for of in (elements.motion, force)
        )
        stiffness = (elements.law.tangential_stiffness, elements.law.normal_stiffness)[direction]
        return np.pi * (f_c * s - f_s * c) * stiffness

    rounding = 1e-13 * elements.size * elements.scale
    by_friction, by_load = work(0), work(1)
    assert np.all(np.abs(by_load) <= rounding)
    assert np.all(by_friction >= -rounding)
    slips = elements.law.contact_state(elements.motion) == STICK_SLIP
    assert np.all(by_friction[slips] > 0)


# the tangent


def test_tangent_equals_central_differences():
    elements, step = random_elements(10_000, seed=12), 1e-6
    n, scale = elements.n, np.where(elements.scale > 0, elements.scale, elements.size)
    # not where contacts just close or just separate: both are kinks, on both sides
    away = np.abs(np.abs(n[:, 0]) - np.hypot(n[:, 1], n[:, 2])) > 100 * step * scale
    assert away.mean() > 0.85
    elements, scale = elements.part(away), scale[away]
    law, motion = elements.law, elements.motion
    force, tangent = law.force_and_tangent(motion)
    np.testing.assert_array_equal(force, law.force(motion))
    errors = []
    for j in range(6):
        stiffness = law.tangential_stiffness if j < 3 else law.normal_stiffness
        moved = np.zeros_like(motion)
        moved[:, j] = step * scale / stiffness
        further, back = law.force(motion + moved), law.force(motion - moved)
        of_step = (step * scale)[:, None]
        error = np.abs((further - back) / (2 * of_step) - tangent[:, :, j] / stiffness[:, None])
        kink = np.abs(further - 2 * force + back) / of_step
        # a kink on one side of the step goes half into the central difference; one of the slope is
        # as steep as the step is long, against the mu n in which it is passed
        assert np.all(error.max(axis=1) <= kink.max(axis=1) / 2 + 100 * step)
        errors.append(error.max(axis=1))
    # error of the step and of rounding elsewhere
    assert np.quantile(errors, 0.99) < step


def test_forces_are_of_first_degree_in_motion_and_load():
    """Euler's theorem: they are their tangent times the motion and the load of the assembly."""
    elements = random_elements(3000, seed=13)
    law, motion = elements.law, elements.motion
    force, tangent = law.force_and_tangent(motion)
    force[:, 3] += np.maximum(law.normal_load, 0)
    by_load = tangent[:, :, 3] * (law.normal_load / law.normal_stiffness)[:, None]
    error = np.abs(np.einsum("pij,pj->pi", tangent, motion) + by_load - force).max(axis=1)
    assert np.all(error <= 1e-13 * elements.size)


def test_normal_load_does_not_depend_on_the_tangential_motion():
    _, tangent = random_elements(100).law.force_and_tangent(random_elements(100).motion)
    assert not np.any(tangent[:, 3:, :3])
    np.testing.assert_allclose(tangent[:, 3, 4], tangent[:, 4, 3] / 2, rtol=1e-12)


# protocol of a friction law


def two_on_a_point():
    """A closed and an open element on point 1, another closed one on point 0."""
    return VariableLoad(
        point_of_element=np.array([1, 1, 0]),
        tangential_stiffness=np.array([1e8, 2e8, 4e8]),
        normal_stiffness=np.array([3e8, 1e8, 2e8]),
        normal_load=np.array([10.0, -20.0, 40.0]),
        friction_coefficient=np.array([0.1, 0.2, 0.3]),
    )


def test_at_rest_the_structure_keeps_the_assembled_state():
    law = two_on_a_point()
    force, tangent = law.force_and_tangent(np.zeros((2, 6)))
    np.testing.assert_array_equal(force, 0)
    stiffness = law.stuck_stiffness(2)
    np.testing.assert_array_equal(stiffness, [[4e8, 2e8], [1e8, 3e8]])
    for point in range(2):
        np.testing.assert_array_equal(tangent[point], np.diag(np.repeat(stiffness[point], 3)))


def test_a_point_without_elements_has_no_stiffness():
    np.testing.assert_array_equal(two_on_a_point().stuck_stiffness(4)[2:], 0)


def test_slip_force_is_that_of_the_assembled_state():
    np.testing.assert_allclose(two_on_a_point().slip_force, [1, 0, 12])


def test_states_of_elements_on_one_point():
    motion = np.zeros((2, 6))
    motion[1, 1] = 2e-8  # k_u u of 2 N beyond the slip force of 1 N
    np.testing.assert_array_equal(
        two_on_a_point().contact_state(motion), [STICK_SLIP, SEPARATION, STICK]
    )


@pytest.mark.parametrize("kind", [VariableLoad, UncoupledVariableLoad, CoupledVariableLoad])
def test_elements_in_place_of_others_keep_the_law_and_the_ratios_of_the_closed_ones(kind):
    law = kind(
        point_of_element=np.array([0, 0, 0, 1]),
        tangential_stiffness=np.array([1e8, 3e8, 7e8, 1e8]),
        normal_stiffness=np.array([2e8, 2e8, 9e8, 5e8]),
        normal_load=np.array([10.0, 30.0, -5.0, 8.0]),
        friction_coefficient=np.array([0.1, 0.3, 0.7, 0.5]),
    )
    stiffness, slip_force = np.array([4e8, 2e8, 1e8]), np.array([2.0, 5.0, 4.0])
    few = law.replaced_by(np.array([0, 0, 1]), stiffness, slip_force)
    assert (type(few), few.directions) == (kind, law.directions)
    assert few.tangential_stiffness is stiffness
    np.testing.assert_allclose(few.slip_force, slip_force)
    np.testing.assert_allclose(few.normal_stiffness, [4e8, 2e8, 5e8])
    np.testing.assert_allclose(few.friction_coefficient, [0.25, 0.25, 0.5])
    np.testing.assert_allclose(few.normal_load, [8, 20, 8])


@pytest.mark.parametrize(
    "name", ["tangential_stiffness", "normal_stiffness", "friction_coefficient"]
)
@pytest.mark.parametrize("value", [-1.0, 0.0, np.nan])
def test_impossible_elements_are_refused(name, value):
    with pytest.raises(ValueError, match=rf"{name} must be (positive|finite), but is .* index 1$"):
        replace(two_on_a_point(), **{name: np.array([1.0, value, 1.0])})


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_load_that_is_no_number_is_refused(value):
    with pytest.raises(ValueError, match=r"normal_load must be finite, but is .* at index 1"):
        replace(two_on_a_point(), normal_load=np.array([1.0, value, 1.0]))


def test_arrays_of_different_length_are_refused():
    with pytest.raises(ValueError, match="normal_load has shape"):
        replace(two_on_a_point(), normal_load=np.array([1.0, 2.0]))
