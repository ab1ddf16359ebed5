"""Elements of several laws in one joint, against each law alone."""

import itertools

import numpy as np
import pytest
from small_joint import connect_small

from boltjoint.dynamics.reduction.hyper_reduction import weigh_pairs
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.combined import CombinedLaw, elements_of_pairs
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.element_law import ContactPairs
from boltjoint.friction.registry import LAWS
from boltjoint.joint.derived import merge_points, rescale_contact
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.joint.model import keep_elements
from boltjoint.joint.reduced import fit_reduced_joint, tabulate_joint
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

KEYS = {
    "tangential_stiffness": 1e8,
    "normal_stiffness": 2e8,
    "friction_coefficient": 0.3,
    "chi": -0.5,
    "beta": 0.2,
}
#: pairs of laws, and whether they have a closed form together
TOGETHER = {
    ("constant", "iwan"): True,
    ("constant", "variable"): True,
    ("variable", "constant"): True,
    ("constant", "uncoupled-constant"): True,
    ("uncoupled-constant", "variable"): True,
    ("uncoupled-variable", "iwan"): False,
    ("iwan", "variable"): False,
    ("coupled-variable", "constant"): False,
    ("coupled-constant", "variable"): False,
}
in_closed_form = [names for names, closed in TOGETHER.items() if closed]
of_lines = [names for names in TOGETHER if not any(each.startswith("coupled") for each in names)]


def elements_of(name, points, seed=0):
    """Elements of a law on points, two on the last of them; some are open where they may be."""
    random = np.random.default_rng(seed)
    on = np.append(points, points[-1])
    load = random.uniform(5, 20, on.size)
    gap = np.zeros(on.size)
    if "variable" in name:
        load[::4], gap[::4] = 0, 2e-8
    pairs = ContactPairs(load, gap, np.zeros((on.size, 3)))
    law = LAWS[name]
    keys = {each.name: KEYS[each.name] * random.uniform(0.5, 2) for each in law.declaration.keys}
    elements, carrying = law.from_contact(pairs, **keys)
    return elements.moved_to(on[carrying])


def two_laws(names, count=40):
    """Elements of two laws, which have points of their own and share some."""
    first, second = np.arange(count), np.arange(count // 2, 2 * count)
    parts = elements_of(names[0], first), elements_of(names[1], second, seed=1)
    return CombinedLaw(parts)


def motion_of(law, points, harmonics=1, seed=3):
    columns = len(law.directions) * len(
        AlternatingFrequencyTime(law, harmonics, samples=64).components
    )
    amplitude = np.geomspace(1e-9, 1e-6, points)[:, None]
    return amplitude * np.random.default_rng(seed).normal(size=(points, columns))


def columns(law, part, components):
    """Places in a motion of all directions and components of what a law of one part takes."""
    return [
        law.directions.index(direction) * len(components) + components.index(component)
        for direction in part.directions
        for component in part.components
    ]


def test_parts_are_two_laws_or_more():
    one, other = elements_of("constant", np.arange(3)), elements_of("variable", np.arange(3))
    both = CombinedLaw((one, other))
    for parts in [(), (one,), (one, one), (both, one), (one, 3.0)]:
        with pytest.raises(ValueError, match="parts"):
            CombinedLaw(parts)


def in_common(law, motion, components, of_parts):
    """The motion in those components alone that all parts know: each is itself then."""
    known = [all(name in own for own in of_parts) for name in components]
    return motion * np.tile(known, len(law.directions))


def sum_of_parts(law, motion, components, parts):
    """Sum of the forces of the parts in those directions and components that they take."""
    total = np.zeros_like(motion)
    for part in parts:
        at = columns(law, part, components)
        total[:, at] += part.force(motion[:, at])
    return total


@pytest.mark.parametrize("names", in_closed_form)
def test_forces_are_the_sums_of_those_of_each_law(names):
    law = two_laws(names)
    of_parts = [part.components for part in law.parts]
    motion = in_common(law, motion_of(law, 80), law.components, of_parts)
    expected = sum_of_parts(law, motion, law.components, law.parts)
    atol = 1e-12 * abs(expected).max()
    np.testing.assert_allclose(law.force(motion), expected, rtol=0, atol=atol)
    states = [
        part.contact_state(motion[:, columns(law, part, law.components)]) for part in law.parts
    ]
    np.testing.assert_array_equal(law.contact_state(motion), np.concatenate(states))


@pytest.mark.parametrize("names", in_closed_form)
def test_tangents_are_central_differences(names):
    law = two_laws(names)
    motion = motion_of(law, 80)
    force, tangent = law.force_and_tangent(motion)
    np.testing.assert_array_equal(force, law.force(motion))
    scale = law.stuck_stiffness(80).max()
    for j in range(motion.shape[1]):
        step = np.zeros_like(motion)
        step[:, j] = 1e-6 * abs(motion).max(axis=1)
        difference = (law.force(motion + step) - law.force(motion - step)) / (2 * step[:, j, None])
        assert abs(tangent[:, :, j] - difference).max() < 1e-5 * scale


@pytest.mark.parametrize("names", in_closed_form)
def test_closed_forms_are_the_limit_of_samples(names):
    law = two_laws(names)
    motion = motion_of(law, 80)
    if "bias" not in law.components:
        assert all("bias" not in part.components for part in law.parts)
    exact = law.force(motion)
    errors = [
        abs(AlternatingFrequencyTime(law, samples=samples).force(motion) - exact).max()
        for samples in (512, 2048)
    ]
    assert errors[1] < 1e-4 * abs(exact).max()
    assert errors[1] < errors[0] / 8


@pytest.mark.parametrize("names", TOGETHER)
@pytest.mark.parametrize("harmonics", [1, 4])
def test_sampled_forces_are_the_sums_of_those_of_each_law(names, harmonics):
    law = two_laws(names)
    sampled = AlternatingFrequencyTime(law, harmonics, samples=64)
    alone = [AlternatingFrequencyTime(part, harmonics, samples=64) for part in law.parts]
    of_parts = [each.components for each in alone]
    of_all = sampled.components
    motion = in_common(law, motion_of(law, 80, harmonics), of_all, of_parts)
    expected = sum_of_parts(law, motion, of_all, alone)
    force, tangent = sampled.force_and_tangent(motion)
    # reversals of Iwan elements lie between samples: halves of a period differ by that little
    share = 1e-7 if "iwan" in names else 1e-12
    np.testing.assert_allclose(force, expected, rtol=0, atol=share * abs(expected).max())
    # directions and components that a part does not know have no part in its tangent
    of_sum = np.zeros_like(tangent)
    for part in alone:
        at = columns(law, part, of_all)
        of_sum[:, np.array(at)[:, None], at] += part.force_and_tangent(motion[:, at])[1]
    in_all = np.tile([all(name in own for own in of_parts) for name in of_all], len(law.directions))
    block = np.ix_(np.ones(80, bool), in_all, in_all)
    np.testing.assert_allclose(
        tangent[block], of_sum[block], rtol=0, atol=1e-12 * abs(tangent).max()
    )


@pytest.mark.parametrize("names", of_lines)
def test_forces_in_modal_coordinates_are_those_of_points(names):
    law = two_laws(names)
    sampled = AlternatingFrequencyTime(law, 3, samples=64)
    random = np.random.default_rng(5)
    rows = tuple(random.normal(size=(80, 4)) for _ in law.directions)
    amplitude = 1e-7 * random.normal(size=(len(sampled.components), 4))
    motion = np.hstack([B @ amplitude.T for B in rows])
    at_points, of_points = sampled.force_and_tangent(motion)
    count = len(sampled.components)
    expected = sum(at_points[:, d * count : (d + 1) * count].T @ B for d, B in enumerate(rows))
    force, tangent = sampled.modal_force_and_tangent(rows, amplitude, 0.0)
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-11 * abs(expected).max())
    blocks = of_points.reshape(80, len(rows), count, len(rows), count)
    by_modes = sum(
        np.einsum("pr,pij,ps->irjs", rows[d], blocks[:, d, :, e], rows[e])
        for d, e in itertools.product(range(len(rows)), repeat=2)
    )
    np.testing.assert_allclose(tangent(), by_modes, rtol=0, atol=1e-10 * abs(by_modes).max())
    single = tangent(np.float32)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, by_modes, rtol=0, atol=1e-5 * abs(by_modes).max())
    change = random.normal(size=amplitude.shape)
    along = np.einsum("irjs,js->ir", by_modes, change)
    np.testing.assert_allclose(tangent.along(change), along, rtol=0, atol=1e-10 * abs(along).max())


@pytest.mark.parametrize("names", TOGETHER)
def test_forces_in_time_and_states_are_those_of_each_law(names):
    law = two_laws(names)
    points, in_time = 80, len(law.directions_in_time)
    motion = 1e-7 * np.random.default_rng(2).normal(size=(points, 3 * in_time))
    found, expected = law.forces_in_time(motion, 64), np.zeros_like(motion)
    displacement = 1e-7 * np.random.default_rng(4).normal(size=(points, len(law.directions), 32))
    states = []
    for part in law.parts:
        places = [law.directions_in_time.index(each) for each in part.directions_in_time]
        at = np.concatenate([np.arange(3 * d, 3 * d + 3) for d in places])
        expected[:, at] += part.forces_in_time(motion[:, at], 64)
        own = displacement[:, [law.directions.index(each) for each in part.directions]]
        states.append(part.at_samples.states(own, 0.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * abs(expected).max())
    np.testing.assert_array_equal(law.at_samples.states(displacement, 0.0), np.concatenate(states))


@pytest.mark.parametrize("names", [("coupled-constant", "variable"), ("iwan", "variable")])
def test_laws_without_a_closed_form_together_are_refused_without_samples(names):
    law = two_laws(names)
    with pytest.raises(ValueError, match="has no closed form"):
        law.force(motion_of(law, 80))


LAP, FLANGE = ["lap"] * 35, ["flange"] * 25


def two_surfaces(law="constant", own="variable", ratio=1.0, **changed):
    """The small joint, of which the second surface has a law of its own."""
    keys = KEYS | {"tangential_stiffness": 5e6, "normal_stiffness": 1e7} | changed
    of_law = {each.name: keys[each.name] for each in LAWS[law].declaration.keys}
    of_own = {each.name: keys[each.name] for each in LAWS[own].declaration.keys}
    surfaces = {"flange": {"law": own, **of_own}}
    return connect_small(law, {**of_law, "surfaces": surfaces}, ratio, LAP + FLANGE)[0]


def test_a_surface_lacks_no_key_of_its_law():
    pairs = ContactPairs(
        np.ones(2), np.zeros(2), np.zeros((2, 3)), np.ones(2), np.array(["lap", "flange"])
    )
    keys = {"tangential_stiffness": 1e8, "friction_coefficient": 0.3}
    own = {"law": "variable", "normal_stiffness": 2e8}
    law, on = elements_of_pairs(pairs, "constant", {"flange": own}, **keys)
    assert law.name == "variable + constant"
    np.testing.assert_array_equal(on, [0, 1])
    np.testing.assert_array_equal(law.point_of_element, [1, 0])
    np.testing.assert_array_equal(law.tangential_stiffness, [1e8, 1e8])
    with pytest.raises(ValueError, match="surface flange has no normal_stiffness, which the law"):
        elements_of_pairs(pairs, "constant", {"flange": {"law": "variable"}}, **keys)
    with pytest.raises(ValueError, match=r"surface .* is not known; allowed: flange, lap"):
        elements_of_pairs(pairs, "constant", {"flnge": own}, **keys)
    with pytest.raises(ValueError, match=r"law of surface flange .* is not known"):
        elements_of_pairs(pairs, "constant", {"flange": {"law": "magic"}}, **keys)
    with pytest.raises(ValueError, match="key of surface flange"):
        elements_of_pairs(pairs, "constant", {"flange": {**own, "chi": -0.5}}, **keys)
    # what a law does not know does not count on its surfaces
    everywhere = elements_of_pairs(
        pairs, "variable", {"flange": {"law": "constant"}}, **keys, normal_stiffness=1e8
    )[0]
    assert isinstance(everywhere.parts[0], ConstantLoad)


def test_a_joint_of_two_laws_survives_its_file():
    joint = two_surfaces()
    again = joint_from_dataset(joint_to_dataset(joint))
    assert again.law.name == joint.law.name == "variable + constant"
    for one, other in zip(again.law.parts, joint.law.parts, strict=True):
        for name in vars(other):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    with pytest.raises(ValueError, match="law_of_element of stored must not fall"):
        stored = joint_to_dataset(joint)
        joint_from_dataset(stored.isel(element=slice(None, None, -1)))


@pytest.mark.parametrize("laws", [("constant", "variable"), ("variable", "constant")])
def test_a_rescaled_joint_is_the_one_made_from_the_new_contact(laws):
    def keys(factor):
        law, own = (
            {each.name: factor * KEYS[each.name] for each in LAWS[name].declaration.keys}
            for name in laws
        )
        return {**law, "surfaces": {"flange": {"law": laws[1], **own}}}

    before, after = keys(0.1), keys(0.15)
    base, expected = (
        connect_small(laws[0], each, ratio, LAP + FLANGE)[0]
        for each, ratio in ((before, 1.0), (after, 1.3))
    )
    found = rescale_contact(base, laws[0], before, after, 1.3)
    for one, other in zip(found.law.parts, expected.law.parts, strict=True):
        for name in other.quantities:
            np.testing.assert_allclose(one.quantity(name), other.quantity(name), rtol=1e-12)


def test_regions_and_their_elements_keep_the_law_of_their_surface():
    joint = two_surfaces()
    surface = joint.surface_places.name
    regions = merge_points(joint, np.where(surface == "lap", 0, 1))
    reduced, fit = fit_reduced_joint(regions, 3)
    assert [type(each) for each in reduced.law.parts] == [type(each) for each in joint.law.parts]
    np.testing.assert_array_equal(reduced.law.point_of_element, [1, 1, 1, 0, 0, 0])
    np.testing.assert_array_equal(
        reduced.element_position, regions.position[reduced.law.point_of_element]
    )
    for point in (0, 1):
        mine, fitted = (each.law.point_of_element == point for each in (regions, reduced))
        total = regions.law.slip_force[mine].sum()
        assert reduced.law.slip_force[fitted].sum() == pytest.approx(total, rel=1e-12)
    assert np.all(np.isfinite(fit["fit_cost"]))
    with pytest.raises(ValueError, match="cannot be reduced so"):
        tabulate_joint(regions)


def test_kept_elements_have_their_own_law_and_weight():
    joint = two_surfaces()
    count = joint.law.point_of_element.size
    weight = np.where(np.arange(count) % 3 == 0, 2.0, 0.0)
    found = keep_elements(joint, weight)
    kept = np.flatnonzero(weight)
    np.testing.assert_array_equal(found.law.part_of_element, joint.law.part_of_element[kept])
    np.testing.assert_array_equal(found.law.slip_force, 2 * joint.law.slip_force[kept])
    mu = joint.law.quantity("friction_coefficient")[kept]
    np.testing.assert_array_equal(found.law.quantity("friction_coefficient"), mu)
    # elements of two laws are never alike, whatever their quantities
    twins = CombinedLaw((elements_of("constant", np.arange(3)), two_twins()))
    assert len(np.unique(twins.features[0])) == 2


def two_twins():
    law = elements_of("constant", np.arange(3))
    quantities = {name: law.quantity(name) for name in law.quantities}
    return LAWS["uncoupled-constant"](point_of_element=law.point_of_element, **quantities)


@pytest.mark.parametrize("laws", [("constant", "variable"), ("variable", "constant")])
def test_motion_of_many_harmonics_is_that_of_time_integration(laws):
    joint, force, loss_factor = two_surfaces(*laws), 12.0, 0.01
    response = solve_response(joint, [force], damping=loss_factor)
    frequency = float(response["peak_frequency"][0])
    motion = None
    for harmonics in (1, 9, 33):
        motion = solve_periodic(
            joint, frequency, force, loss_factor, harmonics=harmonics, start=motion, samples=2048
        )
    steady = steady_state(joint, frequency, force, damping=loss_factor, steps=1000)
    assert motion.converged and steady.converged
    amplitude = motion.amplitude(joint.response_mode)
    assert abs(amplitude - steady.amplitude) < 1e-5 * abs(steady.amplitude)
    # friction is not small, so the closed form of one harmonic is another motion
    assert abs(response["peak_amplitude"][0] - abs(amplitude)) > 1e-3 * abs(amplitude)


def test_weighted_pairs_stand_for_the_elements_of_both_laws():
    joint, forces = two_surfaces(), [6.0, 12.0]
    reduced, _ = weigh_pairs(joint, forces, damping=0.01, windows={1: None})
    assert reduced.points < joint.points
    assert len(reduced.law.parts) == 2
    whole, few = (solve_response(each, forces, damping=0.01) for each in (joint, reduced))
    np.testing.assert_allclose(few["peak_frequency"], whole["peak_frequency"], rtol=1e-3)
    np.testing.assert_allclose(few["peak_amplitude"], whole["peak_amplitude"], rtol=1e-2)
