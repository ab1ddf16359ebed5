"""Excitations with isolated branches, of curves that are known and of one mode."""

from dataclasses import replace

import numpy as np
import pytest
from folding_joint import make_folding_joint

from boltjoint.damping import ModalDamping
from boltjoint.dynamics.backbone.backbone import find_backbone, trace_for_forces
from boltjoint.dynamics.backbone.peak_force import find_isolated_branches
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import method_of, solve_response
from boltjoint.dynamics.response.windows import Resonance

DAMPING = ModalDamping((0.001,))
WINDOW = (45.0, 160.0)


def test_an_excitation_that_rises_has_no_isolated_branch():
    for force in ([], [1.0], [1.0, 1.0, 2.0], [1.0, 2.0, 2.0 * (1 - 1e-8), 3.0]):
        found = find_isolated_branches(np.array(force))
        assert found.appears.size == found.merges.size == 0


def test_ranges_are_from_the_lowest_to_the_highest_before_it():
    force = np.array([1.0, 3.0, 2.5, 2.7, 4.0, 6.0, 5.0, 5.5])
    found = find_isolated_branches(force)
    np.testing.assert_array_equal(force[found.appears], [2.5, 5.0])
    # the last is not passed again before the backbone ends
    np.testing.assert_array_equal(force[found.merges], [3.0, 6.0])


@pytest.fixture
def joint():
    """One mode whose contact opens as it slips."""
    joint = make_folding_joint(modes=1)
    law = replace(joint.law, friction_coefficient=np.array([0.6]))
    return replace(joint, law=law, tangential_mode=np.array([[0.8]]))


def test_ranges_end_at_extremes_between_the_states_of_a_backbone(joint):
    backbone = trace_for_forces(joint, [13.0, 15.0], damping=DAMPING, window=WINDOW)
    coarse, fine = backbone.to_dataset(), backbone.with_shorter_steps(10.0).to_dataset()
    assert fine.sizes["state"] > 3 * coarse.sizes["state"]
    for name in ("isolated_from", "isolated_to"):
        assert coarse[name].item() == pytest.approx(fine[name].item(), rel=1e-8)
        # which no state tells as well
        assert abs(coarse["peak_force"] / coarse[name].item() - 1).min() > 1e-6
    appears = "isolated_amplitude"
    assert coarse[appears].item() == pytest.approx(fine[appears].item(), rel=1e-3)


def test_the_isolated_branch_of_one_mode_is_one_of_the_balance(joint):
    forces = [13.0, 14.3, 15.0]
    backbone = find_backbone(joint, forces, damping=DAMPING, window=WINDOW)
    low, high = backbone["isolated_from"].item(), backbone["isolated_to"].item()
    appears = backbone["isolated_amplitude"].item()
    assert 13.0 < low < 14.3 < high < 15.0
    known = {"damping": DAMPING, "resonance": Resonance(1, WINDOW)}
    given = solve_response(joint, forces, method=method_of("backbone", backbone=backbone), **known)
    np.testing.assert_array_equal(given["isolated_branch"], [0, 1, 0])
    # one linear mode: synthesis is exact, and continuation gives the same peaks
    linear = solve_response(joint, forces, **known)
    np.testing.assert_allclose(given["peak_amplitude"], linear["peak_amplitude"], rtol=1e-6)
    peak, beyond = linear["peak_amplitude"].to_numpy()[1:]
    assert peak < appears < beyond
    # states from there are solutions under their peak force, a quarter of a period behind it
    force, amplitude = (backbone[name].to_numpy() for name in ("peak_force", "response_amplitude"))
    (state, *_) = np.flatnonzero((amplitude >= appears) & (force < high))
    balance = HarmonicBalance(joint, DAMPING, force[state])
    at = backbone.isel(state=state, mode=0)
    parts = {"bias": at["bias"].item(), "sin": 0.0, "cos": -at["modal_amplitude"].item()}
    x = np.array([parts[name] for name in balance.components])
    w = 2 * np.pi * at["natural_frequency"].item()
    assert np.linalg.norm(balance.residual(x, w)) < 1e-6 * force[state]
    # of which the branch under that force has none
    (branch,) = solve_response(joint, [force[state]], **known)["peak_amplitude"].to_numpy()
    assert branch < 0.97 * amplitude[state]


def test_an_excitation_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="force"):
        find_isolated_branches(np.array([1.0, np.nan]))
