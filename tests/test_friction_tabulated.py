"""Tabulated describing functions against those of the elements."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint, make_preload

from boltjoint import dataset
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.joint.io import joint_to_dataset, load_joint
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import tabulate_joint
from boltjoint.verification.residual_in_time import check_solutions


def many_elements(count=300, points=3, seed=4):
    random = np.random.default_rng(seed)
    on = np.arange(count) % points
    return on, random.uniform(0.5e8, 2e8, count), random.gamma(0.8, 3.0, count) + 1e-2


def random_motion(points, lowest=-10, highest=-3, seed=0):
    random = np.random.default_rng(seed)
    amplitude = 10 ** random.uniform(lowest, highest, points)
    phase = random.uniform(0, 2 * np.pi, points)
    return np.column_stack([amplitude * np.cos(phase), amplitude * np.sin(phase)])


def relative_error(found, exact):
    return (np.linalg.norm(found - exact, axis=-1) / np.linalg.norm(exact, axis=-1)).max()


@pytest.mark.parametrize("count", [1, 2, 300])
def test_force_is_that_of_the_elements_at_every_amplitude(count):
    elements = many_elements(count, points=1)
    exact, table = ConstantLoad(*elements), TabulatedLoad(*elements)
    # 7 decades: from where nothing slips to the series beyond the table
    errors = [
        relative_error(table.force(motion[None]), exact.force(motion[None]))
        for motion in random_motion(4000)
    ]
    assert max(errors) < 1e-6


def test_force_is_exact_while_nothing_slips():
    on, k, s = many_elements()
    motion = random_motion(3, -12, -11)
    table = TabulatedLoad(on, k, s)
    np.testing.assert_array_equal(table.contact_state(motion), 0)
    stuck = np.bincount(on, k)[:, None]
    np.testing.assert_allclose(table.force(motion), stuck * motion, rtol=1e-14)
    np.testing.assert_array_equal(table.force(np.zeros((3, 2))), 0.0)


def test_dissipation_is_exact_where_elements_slip():
    on, k, s = many_elements(points=1)
    exact, table = ConstantLoad(on, k, s), TabulatedLoad(on, k, s)
    for amplitude in np.geomspace(2, 1e5, 50) * (s / k).min():
        motion = np.array([[amplitude, 0.0]])
        # closed form on both sides: only sums over elements are in another order
        assert table.force(motion)[0, 1] == pytest.approx(exact.force(motion)[0, 1], rel=1e-10)


def test_tangent_is_the_derivative_of_the_tabulated_force():
    law = TabulatedLoad(*many_elements(points=1))
    for motion in random_motion(300, -9.5, -4, seed=1):
        amplitude = np.hypot(*motion)
        force, tangent = law.force_and_tangent(motion[None])
        np.testing.assert_array_equal(force, law.force(motion[None]))
        for j in range(2):
            step = np.zeros(2)
            step[j] = 1e-6 * amplitude
            ahead, behind = (law.force((motion + d)[None])[0] for d in (step, -step))
            # rounding over the step, and a kink of the loss at one of 300 onsets within it
            np.testing.assert_allclose(
                tangent[0, :, j] * amplitude,
                (ahead - behind) / 2e-6,
                atol=1e-4 * np.linalg.norm(force),
            )


def test_tangent_is_near_that_of_the_elements():
    elements = many_elements()
    exact, table = ConstantLoad(*elements), TabulatedLoad(*elements)
    stiffness = np.bincount(elements[0], elements[1])[:, None, None]
    for seed in range(100):
        motion = random_motion(3, -9, -5, seed)
        difference = table.force_and_tangent(motion)[1] - exact.force_and_tangent(motion)[1]
        # slopes err by the error of values over the spacing of knots
        assert np.abs(difference / stiffness).max() < 1e-3


def test_force_is_continuous_where_the_series_takes_over():
    on, k, s = many_elements(points=1)
    law = TabulatedLoad(on, k, s)
    end = 100 * (s / k).max()
    below, above = (law.force(np.array([[end * (1 + d), 0.0]])) for d in (-1e-9, 1e-9))
    assert relative_error(below, above) < 1e-8


def test_elements_that_slip_together_need_no_more_knots():
    law = TabulatedLoad(np.zeros(40, dtype=np.int64), np.full(40, 1e8), np.full(40, 3.0))
    one = TabulatedLoad(np.array([0]), np.array([4e9]), np.array([120.0]))
    motion = random_motion(1, -7, -6)
    assert len(law.compiled_elements.table) == len(one.compiled_elements.table)
    np.testing.assert_allclose(law.force(motion), one.force(motion), rtol=1e-12)


def test_a_point_without_elements_has_no_force():
    law = TabulatedLoad(np.array([1]), np.array([1e8]), np.array([3.0]))
    force, tangent = law.force_and_tangent(np.full((3, 2), 1e-6))
    for values in (force, tangent):
        np.testing.assert_array_equal(values[[0, 2]], 0.0)
        assert np.any(values[1] != 0)


def test_force_does_not_depend_on_units():
    on, k, s = many_elements()
    motion = random_motion(3, -8, -6)
    force = TabulatedLoad(on, k, s).force(motion)
    scaled = TabulatedLoad(on, 1e-3 * k, 1e3 * s).force(1e6 * motion)
    np.testing.assert_allclose(scaled, 1e3 * force, rtol=2e-6)


def test_states_are_those_of_the_elements():
    elements = many_elements()
    motion = random_motion(3, -8, -7)
    states = TabulatedLoad(*elements).contact_state(motion)
    np.testing.assert_array_equal(states, ConstantLoad(*elements).contact_state(motion))
    assert set(states) == {0, 1}


def regions():
    joint = make_joint()
    return partition_regions(joint, make_preload(joint), 3)


@pytest.mark.parametrize("coordinates", ["linear", "rdnm-1"])
def test_response_is_that_of_the_elements(coordinates):
    joint = regions()
    options = {"damping": 0.002, "method": coordinates}
    exact = solve_response(joint, [0.1, 5.0], **options)
    table = solve_response(tabulate_joint(joint), [0.1, 5.0], **options)
    for name in ("peak_frequency", "peak_amplitude"):
        np.testing.assert_allclose(table[name], exact[name], rtol=1e-5)
    np.testing.assert_array_equal(table["contact_state"], exact["contact_state"])
    np.testing.assert_array_equal(table["complete"], 1)


def test_tabulated_joint_is_saved_and_its_solutions_hold_in_time(tmp_path):
    joint = tabulate_joint(regions())
    dataset.save(joint_to_dataset(joint), tmp_path / "joint.nc")
    again = load_joint(tmp_path / "joint.nc")
    assert isinstance(again.law, TabulatedLoad)
    motion = random_motion(3, -8, -6)
    np.testing.assert_array_equal(again.law.force(motion), joint.law.force(motion))
    response = solve_response(again, [5.0], damping=0.002).isel(solution=slice(0, None, 10))
    checked = check_solutions(dataset.load(tmp_path / "joint.nc"), response)
    # force of the table, and of time integration
    assert checked["residual_in_time"].max() < 3e-6


def test_other_elements_take_their_place_tabulated_too():
    law = tabulate_joint(regions()).law
    other = law.replaced_by(np.array([0]), np.array([1e8]), np.array([3.0]))
    assert isinstance(other, TabulatedLoad)
    exact = ConstantLoad(np.array([0]), np.array([1e8]), np.array([3.0]))
    motion = random_motion(1, -7, -6)
    assert relative_error(other.force(motion), exact.force(motion)) < 1e-6


def test_a_joint_under_variable_load_is_refused():
    with pytest.raises(ValueError, match=r"'variable' of the joint .* needs constant normal load"):
        tabulate_joint(make_joint(law="variable"))


def test_impossible_elements_are_refused():
    with pytest.raises(ValueError, match="slip_force must be positive"):
        replace(tabulate_joint(regions()).law, slip_force=np.zeros(60))
