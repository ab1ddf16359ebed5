"""Natural frequencies and modes of a joint: without contact, slipping and sticking."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NaturalModes:
    """Natural frequencies [Hz] and modes of a joint in one linear state of its contact.

    ``frequency`` (resonances,), and ``vector`` (modes of the basis, resonances), normalised by
    mass; without those of a rigid body.
    """

    frequency: Array
    vector: Array


def natural_modes(joint: Joint, most: int) -> dict[str, NaturalModes]:
    """The lowest natural modes by the state of the contact.

    ``without contact``; ``slipping``, where only the normal springs of the loaded pairs act; and
    ``sticking``, where the tangential ones act too. Slipping is left out where the law has no
    normal springs: then it is as without contact.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    most
        Number of resonances.
    """
    stiffness = joint.law.stuck_stiffness(joint.points)
    parts = dict(zip(joint.law.directions, zip(joint.rows, stiffness.T, strict=True), strict=True))
    free = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    states = {"without contact": free}
    if "normal" in parts:
        rows, springs = parts["normal"]
        states["slipping"] = free + rows.T @ (springs[:, None] * rows)
    states["sticking"] = free + joint.stuck_stiffness()
    rigid = joint.natural_frequency.size - joint.elastic_modes
    shapes = {}
    for name, matrix in states.items():
        squared, vector = np.linalg.eigh(matrix)
        chosen = slice(rigid, rigid + most)
        frequency = np.sqrt(np.maximum(squared[chosen], 0)) / (2 * np.pi)
        shapes[name] = NaturalModes(frequency, vector[:, chosen])
    return shapes
