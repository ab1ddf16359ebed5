"""The power law of microslip: of joints whose power is known, and of those that have none."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.backbone.backbone import find_backbone
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.windows import frequency_window
from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.model import Joint
from boltjoint.study.tables.backbones import MicroslipOptions, peak_dissipation, tabulate_microslip

LOSS, FORCES = 0.01, [1e-4, 1e-2, 0.1, 1.0]


def joint_of_power(chi, elements=4000):
    """One mode, and elements of one stiffness on its one point that slip from phi on.

    Their density is phi^chi: up to the largest phi, D(A) = sum 4 k phi (A - phi) goes with
    A^(3 + chi) (Segalman 2005).
    """
    share = (np.arange(elements) + 0.5) / elements
    slips_at = 1e-5 * share ** (1 / (1 + chi))
    k = np.full(elements, 1e4 / elements)
    law = ConstantLoad(np.zeros(elements, dtype=int), k, k * slips_at)
    at = np.zeros((1, 3))
    mode = np.ones(1)
    return Joint(np.array([70.0]), mode, mode, mode[None], at, law, np.zeros((elements, 3)))


def backbone_of(joint, forces=FORCES):
    window = frequency_window(joint)
    return find_backbone(joint, forces, damping=LOSS, window=window)


@pytest.mark.parametrize("chi", [0.0, -0.3, -0.6])
def test_an_iwan_joint_has_the_power_of_its_distribution(chi):
    (row,) = tabulate_microslip({"node-to-node": backbone_of(joint_of_power(chi))}).itertuples()
    # what the sum over elements and the fall of the frequency leave of it
    assert row.power == pytest.approx(3 + chi, abs=2e-4)
    assert row.rms_error_percent < 0.02
    assert row.from_amplitude_mm < 0.15 * row.to_amplitude_mm
    # all elements slip from 0.01 mm on
    assert row.to_amplitude_mm < 0.01 < row.macroslip_amplitude_mm
    assert row.macroslip_frequency_Hz < row.stuck_frequency_Hz


def test_the_power_of_a_power_law_does_not_depend_on_the_points():
    found = {"node-to-node": backbone_of(joint_of_power(0.0))}
    few, many = (
        tabulate_microslip(found, MicroslipOptions(points=count)).iloc[0] for count in (20, 200)
    )
    assert few["power"] == pytest.approx(many["power"], rel=0.01)
    assert few["power"] != many["power"]


def test_the_range_ends_where_the_friction_damping_has_its_shares():
    found = {"node-to-node": backbone_of(joint_of_power(0.0))}
    narrow, wide = (
        tabulate_microslip(found, MicroslipOptions(0.01, share)).iloc[0] for share in (0.03, 0.1)
    )
    # damping goes with the amplitude where dissipation goes with its cube
    for row, share in ((narrow, 0.03), (wide, 0.1)):
        assert row["to_amplitude_mm"] / row["from_amplitude_mm"] == pytest.approx(
            share / 0.01, rel=0.1
        )
    assert narrow["from_amplitude_mm"] == wide["from_amplitude_mm"]
    assert narrow["to_amplitude_mm"] < wide["to_amplitude_mm"]


def test_at_its_peak_a_response_dissipates_what_the_backbone_does():
    joint = joint_of_power(-0.3)
    backbone = backbone_of(joint)
    response = solve_response(joint, FORCES, damping=LOSS)
    amplitude, frequency, dissipation = peak_dissipation(joint, response)
    assert amplitude.size == int(response["complete"].sum()) == len(FORCES)
    along, at = np.log(backbone["response_amplitude"]), np.log(amplitude)
    lost = np.log(backbone["friction_dissipation"].clip(1e-300))
    # between states the curves are drawn as lines
    np.testing.assert_allclose(dissipation, np.exp(np.interp(at, along, lost)), rtol=5e-3)
    expected = np.interp(at, along, backbone["natural_frequency"])
    np.testing.assert_allclose(frequency, expected, rtol=1e-4)


def test_a_joint_that_sticks_has_no_power():
    joint = make_joint()
    stuck = replace(joint, law=replace(joint.law, slip_force=1e9 * joint.law.slip_force))
    (row,) = tabulate_microslip({"node-to-node": backbone_of(stuck)}).to_dict("records")
    # what is left of the dissipation is rounding
    assert row["joint"] == "node-to-node"
    assert np.isnan(row["power"]) or row["largest_friction_damping_percent"] < 1e-10


def test_a_single_element_slips_at_once():
    joint = joint_of_power(0.0, elements=1)
    (row,) = tabulate_microslip({"node-to-node": backbone_of(joint)}).to_dict("records")
    # it slips at 0.005 mm, and its damping is largest at twice that: there is no microslip before
    assert np.isnan(row["power"])
    assert row["macroslip_amplitude_mm"] == pytest.approx(0.01, rel=0.1)
