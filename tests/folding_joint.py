"""A joint of one element whose contact opens or closes as it slips: its response folds."""

import numpy as np

from boltjoint.damping import ModalDamping
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.model import Joint

WINDOW = (35.0, 100.0)
#: viscous, so that it is the same for all harmonics and in time
DAMPING = ModalDamping((0.01,))


def make_folding_joint(normal_load: float = 60.0, modes: int = 2) -> Joint:
    """A structure of one or two modes on one element; a negative load is a gap.

    With 60 N and a force of 5 N the contact separates and the response softens, with a gap of 20 N
    it closes and hardens; both fold.
    """
    one = np.ones(1)
    return Joint(
        natural_frequency=np.array([50.0, 210.0])[:modes],
        excitation_mode=np.array([1.0, 0.7])[:modes],
        response_mode=np.array([1.5, -0.4])[:modes],
        tangential_mode=np.array([[0.2, -0.3]])[:, :modes],
        position=np.zeros((1, 3)),
        law=VariableLoad(np.array([0]), 4e5 * one, 3e5 * one, normal_load * one, 0.3 * one),
        element_position=np.zeros((1, 3)),
        normal_mode=np.array([[0.6, 0.6]])[:, :modes],
    )
