"""Slip states between stick and full slip."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.joint.clusters import find_slip_states


def divided(joint, shares):
    """Every element as several on its point, with these shares of all but its ratios."""
    law, parts = joint.law, len(shares)
    share = np.tile(shares, law.point_of_element.size)
    quantities = {
        name: np.repeat(getattr(law, name), parts) * (1.0 if unit == "1" else share)
        for name, (unit, _) in law.quantities.items()
    }
    on = np.repeat(law.point_of_element, parts)
    position = np.repeat(joint.element_position, parts, axis=0)
    return replace(joint, law=type(law)(on, **quantities), element_position=position)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_states_do_not_depend_on_the_areas_that_pairs_stand_for(law):
    """Elements are released as they slip, not by the load that their area gives them."""
    joint = make_joint(law=law)
    expected = find_slip_states(joint, 2)
    # powers of two, so that the slip displacements are the same to the bit
    found = find_slip_states(divided(joint, (1 / 2, 1 / 4, 1 / 4)), 2)
    np.testing.assert_array_equal(found.stick, np.repeat(expected.stick, 3, axis=1))
    np.testing.assert_allclose(found.frequency, expected.frequency, rtol=1e-12)
    np.testing.assert_allclose(found.amplitude, expected.amplitude, rtol=1e-9)
