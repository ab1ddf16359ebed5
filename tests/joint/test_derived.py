"""Joints under other contact coefficients and preloads: as made from these, to rounding."""

from dataclasses import fields, replace

import numpy as np
import pytest
from small_joint import connect_small, make_joint

from boltjoint.friction.registry import LAWS
from boltjoint.joint.derived import rescale_contact, with_elements
from boltjoint.joint.fit_iwan import fit_iwan_joint
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint, tabulate_joint

BEFORE = {
    "constant": {"tangential_stiffness": 5e6, "friction_coefficient": 0.1},
    "variable": {
        "tangential_stiffness": 5e6,
        "friction_coefficient": 0.1,
        "normal_stiffness": 1e7,
    },
    "iwan": {"tangential_stiffness": 5e6, "friction_coefficient": 0.1, "chi": -0.5, "beta": 0.0},
}
AFTER = {
    "constant": {"tangential_stiffness": 7e6, "friction_coefficient": 0.23},
    "variable": {
        "tangential_stiffness": 7e6,
        "friction_coefficient": 0.23,
        "normal_stiffness": 0.3e7,
    },
    "iwan": {"tangential_stiffness": 7e6, "friction_coefficient": 0.23, "chi": -0.2, "beta": 0.7},
}
RATIO = 1.7


def per_area(keys):
    """The same numbers of an area of 1 mm2."""
    return {
        f"{name}_per_area" if name.endswith("stiffness") else name: (
            1e6 * value if name.endswith("stiffness") else value
        )
        for name, value in keys.items()
    }


def same(found, expected):
    assert type(found.law) is type(expected.law)
    np.testing.assert_array_equal(found.law.point_of_element, expected.law.point_of_element)
    for name in found.law.quantities:
        ours, theirs = getattr(found.law, name), getattr(expected.law, name)
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, err_msg=name)
    np.testing.assert_allclose(found.tangential_mode, expected.tangential_mode, rtol=1e-13)


def regions(law, keys, ratio=1.0):
    joint, preload = connect_small(law, keys, ratio)
    return partition_regions(joint, preload, 3)


MADE = {
    "node-to-node": lambda *of: connect_small(*of)[0],
    "regions": regions,
    "elements": lambda *of: fit_reduced_joint(regions(*of), 3, starts=4)[0],
    "harmonic": lambda *of: fit_reduced_joint(regions(*of), 3, method="describing-function")[0],
    "iwan": lambda *of: fit_iwan_joint(regions(*of))[0],
    "table": lambda *of: tabulate_joint(regions(*of)),
}


@pytest.mark.parametrize(
    ("law", "made"),
    [(law, made) for law in BEFORE for made in ("node-to-node", "regions")]
    + [(law, made) for law in ("constant", "variable") for made in ("elements", "harmonic")]
    + [("constant", "iwan"), ("constant", "table")],
)
def test_a_rescaled_joint_is_the_one_made_from_the_new_contact(law, made):
    base, expected = MADE[made](law, BEFORE[law]), MADE[made](law, AFTER[law], RATIO)
    found = rescale_contact(base, LAWS[law], BEFORE[law], AFTER[law], RATIO)
    same(found, expected)


@pytest.mark.parametrize("made", ["node-to-node", "regions", "elements"])
def test_stiffnesses_per_area_are_rescaled_too(made):
    before, after = per_area(BEFORE["variable"]), per_area(AFTER["variable"])
    base, expected = MADE[made]("variable", before), MADE[made]("variable", after, RATIO)
    assert np.ptp(base.law.tangential_stiffness) > 0
    same(rescale_contact(base, LAWS["variable"], before, after, RATIO), expected)


SURFACE = ["lap"] * 35 + ["flange"] * 25


@pytest.mark.parametrize("law", BEFORE)
def test_surfaces_are_rescaled_by_their_own_values(law):
    before = {**BEFORE[law], "surfaces": {"flange": {"friction_coefficient": 0.3}}}
    after = {**AFTER[law], "surfaces": {"flange": {"friction_coefficient": 0.45}}}
    base, expected = (
        connect_small(law, keys, ratio, SURFACE)[0] for keys, ratio in ((before, 1), (after, RATIO))
    )
    same(rescale_contact(base, LAWS[law], before, after, RATIO), expected)
    of_all = rescale_contact(base, LAWS[law], BEFORE[law], AFTER[law], RATIO)
    assert not np.allclose(of_all.law.slip_force, expected.law.slip_force, rtol=0.1)


def test_keys_of_a_surface_do_not_become_others():
    joint, _ = connect_small("constant", BEFORE["constant"])
    of_pairs, of_area = (
        BEFORE["constant"] | {"surfaces": {"contact": {name: 1e8}}}
        for name in ("tangential_stiffness", "tangential_stiffness_per_area")
    )
    with pytest.raises(ValueError, match="after must have the keys of before"):
        rescale_contact(joint, LAWS["constant"], of_pairs, of_area)


def test_a_stiffness_of_pairs_does_not_become_one_per_area():
    joint, _ = connect_small("constant", BEFORE["constant"])
    with pytest.raises(ValueError, match="after must have the keys of before"):
        rescale_contact(joint, LAWS["constant"], BEFORE["constant"], per_area(AFTER["constant"]))


def test_what_does_not_change_stays():
    joint, _ = connect_small("variable", BEFORE["variable"])
    found = rescale_contact(joint, LAWS["variable"], BEFORE["variable"], BEFORE["variable"])
    for name in joint.law.quantities:
        np.testing.assert_array_equal(getattr(found.law, name), getattr(joint.law, name))


@pytest.mark.parametrize("ratio", [0.0, -1.0, np.nan])
def test_a_preload_is_positive(ratio):
    joint, _ = connect_small("constant", BEFORE["constant"])
    with pytest.raises(ValueError, match="preload_ratio"):
        rescale_contact(joint, LAWS["constant"], BEFORE["constant"], AFTER["constant"], ratio)


def test_a_joint_with_other_values_is_the_one_that_is_made_of_them():
    joint = make_joint()
    assert joint.contact.law is joint.law  # which a copy must not keep
    law = joint.law.with_quantities({"slip_force": 2 * joint.law.slip_force})
    frequency = 1.1 * joint.natural_frequency
    found = with_elements(joint, law, frequency)
    made = replace(joint, law=law, natural_frequency=frequency)
    assert found.contact.law is law and found.law is law
    for entry in fields(made):
        np.testing.assert_array_equal(getattr(found, entry.name), getattr(made, entry.name))
    np.testing.assert_array_equal(found.stiffness_while_stuck(), made.stiffness_while_stuck())
    with pytest.raises(ValueError, match="natural_frequency must be at least 0"):
        with_elements(joint, law, -frequency)
    with pytest.raises(ValueError, match="must be on the points of those of the joint"):
        with_elements(joint, law.moved_to(law.point_of_element[::-1].copy()), frequency)
    with pytest.raises(ValueError, match="natural_frequency has shape"):
        with_elements(joint, law, frequency[:-1])
