"""Responses of many designs are those of each alone."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.response.designs import solve_branches
from boltjoint.dynamics.response.frequency_response import solve_branch

FORCES, LOSS = [2.0, 5.0, 10.0, 20.0, 30.0, 50.0], 0.01


def joints(law):
    joint = make_joint(law=law)
    of_joint = joint.law
    return [
        replace(
            joint,
            law=replace(of_joint, tangential_stiffness=factor * of_joint.tangential_stiffness),
        )
        for factor in np.linspace(0.8, 1.2, len(FORCES))
    ]


@pytest.mark.parametrize("threads", [1, 3, None])
@pytest.mark.parametrize("law", ["constant", "variable"])
def test_designs_together_are_those_of_each_alone(law, threads):
    found = solve_branches(joints(law), FORCES, threads=threads, loss_factor=LOSS)
    for joint, force, branch in zip(joints(law), FORCES, found, strict=True):
        alone = solve_branch(joint, force, loss_factor=LOSS)
        assert branch.force == force
        assert branch.complete
        np.testing.assert_array_equal(branch.frequency, alone.frequency)
        np.testing.assert_array_equal(branch.modal_coordinate, alone.modal_coordinate)


def test_wrong_numbers_are_refused():
    with pytest.raises(ValueError, match="6 joints, but 5 forces"):
        solve_branches(joints("constant"), FORCES[1:], loss_factor=LOSS)
    with pytest.raises(ValueError, match="threads"):
        solve_branches(joints("constant"), FORCES, threads=-1, loss_factor=LOSS)
