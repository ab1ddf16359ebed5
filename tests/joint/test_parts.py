"""Parts of a joint: each knows what concerns it alone."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.modal_contact import ModalContact


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_contact_has_the_rows_and_elements_of_the_joint(law):
    joint = make_joint(law=law)
    contact = joint.contact
    assert contact.law is joint.law
    assert contact.points == joint.points == 60
    expected = (joint.tangential_mode, joint.normal_mode)[: len(joint.law.directions)]
    for rows, modes in zip(contact.rows, expected, strict=True):
        assert rows is modes
    assert len(contact.rows_in_plane) == 1
    springs = joint.law.stuck_stiffness(60)
    stiffness = sum(B.T @ np.diag(k) @ B for B, k in zip(expected, springs.T, strict=True))
    np.testing.assert_allclose(contact.stuck_stiffness(), stiffness, rtol=1e-12)
    assert contact.moves_in(1e-9).all()
    # forces in modal coordinates need the contact alone
    modal = ModalContact(contact)
    x = 1e-4 * np.random.default_rng(0).normal(size=len(modal.components) * 3)
    points = joint.law.force(modal.motion(x))
    parts = points.reshape(60, len(contact.rows), -1)
    of_modes = sum(np.einsum("pc,pm->cm", parts[:, d], B) for d, B in enumerate(contact.rows))
    np.testing.assert_allclose(modal.force(x, 0.0), of_modes.ravel(), rtol=1e-10)


def test_excitation_and_sensors_have_their_modes():
    joint = make_joint()
    assert joint.excitation.is_force
    assert joint.excitation.modes is joint.excitation_mode
    assert list(joint.sensors.by_name) == ["output"]
    assert joint.sensors.output is joint.response_mode
    cosine, tip = np.array([0.3, 0.7, -0.2]), np.array([1.0, -1.0, 1.0])
    other = replace(
        joint,
        excitation_mode_cos=cosine,
        excitation_unit="m/s2",
        sensor_mode=tip[None],
        sensor_name=("tip",),
    )
    np.testing.assert_array_equal(other.excitation.modes, joint.excitation_mode + 1j * cosine)
    assert not other.excitation.is_force
    np.testing.assert_array_equal(other.sensors.by_name["tip"], tip)
