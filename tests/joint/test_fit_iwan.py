"""Regions of one four-parameter Iwan element, fitted to Jenkins elements."""

import numpy as np
import pytest
from joint_examples import many_elements
from small_joint import make_joint

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint.bands import bands_of_equal_load
from boltjoint.joint.derived import merge_points
from boltjoint.joint.fit_iwan import fit_iwan_element, fit_iwan_joint
from boltjoint.joint.reductions import REDUCTIONS, reduce_joint
from boltjoint.names import REDUCTIONS as DECLARED


def test_every_reduction_is_declared():
    assert set(REDUCTIONS) == set(DECLARED)


@pytest.mark.parametrize(("chi", "beta"), [(-0.5, 0.8), (-0.2, 0.1), (-0.35, 3.0)])
def test_it_finds_the_element_that_its_sliders_stand_for(chi, beta):
    element = FourParameterIwan(np.array([0]), *np.reshape((1e8, 3.0, chi, beta), (4, 1)))
    # the error of beta is of second order in the logarithm of the ratio: 2e-2 with 1.08, 2e-5 here;
    # nearer to chi = -1 what slips below the smallest slider would count
    sliders = element.sliders(1.005)
    found = fit_iwan_element(sliders.tangential_stiffness, sliders.friction_coefficient)
    assert found.tangential_stiffness[0] == pytest.approx(1e8)
    assert found.slip_force[0] == pytest.approx(3.0)
    assert found.chi[0] == pytest.approx(chi, abs=1e-4)
    assert found.beta[0] == pytest.approx(beta, rel=1e-4)


def test_no_other_shape_is_nearer():
    k, s = many_elements()
    found = fit_iwan_element(k, s)
    amplitude = np.geomspace(0.8 * (s / k).min(), (s / k).max(), 120)

    def distance(chi, beta):
        # relative to the slip force; small losses count little here beside the largest errors
        element = FourParameterIwan(
            np.array([0]), *np.reshape((k.sum(), s.sum(), chi, beta), (4, 1))
        )
        many = ConstantLoad(np.zeros(k.size, dtype=int), k, s)
        motions = np.column_stack([amplitude, np.zeros(120)])
        pairs = [(element.force(u[None]), many.force(u[None])) for u in motions]
        return np.sqrt(np.mean([np.sum((a - b) ** 2) for a, b in pairs])) / s.sum()

    best = min(
        distance(chi, beta) for chi in np.linspace(-0.9, 0, 7) for beta in (0.01, 0.1, 1, 10)
    )
    assert distance(found.chi[0], found.beta[0]) < 1.1 * best


def regions():
    joint = make_joint()
    return merge_points(joint, bands_of_equal_load(joint.position[:, :2], joint.law.slip_force, 3))


def test_a_joint_keeps_its_totals_and_writes_its_loops():
    joint = regions()
    reduced, fit = reduce_joint(joint, "iwan", load_fractions=(0.2, 0.5, 0.8))
    assert reduced.law.name == "iwan" and reduced.law.slip_force.size == joint.points
    for name in ("tangential_stiffness", "slip_force"):
        totals = np.bincount(joint.law.point_of_element, getattr(joint.law, name))
        np.testing.assert_allclose(getattr(reduced.law, name), totals, rtol=1e-12)
    top, bottom = fit["loop_force_of_region"][..., 0], fit["loop_force_of_region"][..., -1]
    np.testing.assert_allclose(top, -bottom)
    share = top / reduced.law.slip_force[:, None]
    np.testing.assert_allclose(share, np.tile([0.2, 0.5, 0.8], (3, 1)))
    difference = fit["loop_force_of_fit"] - fit["loop_force_of_region"]
    np.testing.assert_allclose(fit["fit_cost"], 2 * (difference**2).sum(("loop", "sample")))
    # no loop has a larger error than the largest of all amplitudes
    largest = abs(difference).max(("loop", "sample")) / reduced.law.slip_force
    assert (largest <= fit["largest_loop_error"] * (1 + 1e-3)).all()
    assert (fit["rms_loop_error"] < fit["largest_loop_error"]).all()


def test_only_coulomb_elements_under_constant_load_are_fitted():
    with pytest.raises(ValueError, match="needs constant normal load"):
        fit_iwan_joint(make_joint(law="variable"))
    with pytest.raises(ValueError, match="needs Coulomb friction elements"):
        fit_iwan_joint(fit_iwan_joint(regions())[0])
