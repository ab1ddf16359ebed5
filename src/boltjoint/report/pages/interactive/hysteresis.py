"""Hysteresis loops of friction elements at the peak of a response."""

import numpy as np
from numpy.typing import NDArray

from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


def hysteresis_loops(
    joint: Joint, motion: PeriodicMotion, samples: int, frequency: float = 0.0
) -> tuple[Array, Array] | None:
    """Displacement and friction force of all elements over a steady period.

    The springs with sliders of the law follow the motion from rest through one period, which
    brings them to their steady state, and through that which is returned. Dashpots of the law act
    beside them.

    Parameters
    ----------
    joint
        The joint, as its file holds it.
    motion
        Coordinates of its modes.
    samples
        Samples of a period, from its start.
    frequency
        Frequency of the motion [Hz], for forces that depend on it.

    Returns
    -------
    tuple
        Relative displacement along the first tangent [m] and the force of its friction [N], each
        (elements, samples); None where friction acts in two directions, whose loops are no lines
        in a plane.
    """
    law = joint.law
    if "lateral" in law.directions_in_time:
        return None
    q = motion.in_time(samples).T
    u = joint.tangential_mode @ q
    sliders = law.sliders()
    spring = sliders.tangential_stiffness[:, None] * u[sliders.point]
    load = np.broadcast_to(sliders.normal_load[:, None], spring.shape)
    if sliders.normal_stiffness is not None and joint.normal_mode is not None:
        load = load + sliders.normal_stiffness[:, None] * (joint.normal_mode @ q)[sliders.point]
    bound = sliders.friction_coefficient[:, None] * np.maximum(load, 0)
    force = np.empty_like(spring)
    anchor = np.zeros(len(spring))
    for _ in range(2):
        for at in range(samples):
            force[:, at] = np.clip(spring[:, at] - anchor, -bound[:, at], bound[:, at])
            anchor = spring[:, at] - force[:, at]
    of_element = np.zeros((law.point_of_element.size, samples))
    np.add.at(of_element, sliders.element, force)
    if law.dashpots is not None:
        turn = 2 * np.pi * frequency * motion.components.phase_derivative
        velocity = PeriodicMotion(motion.components, turn @ motion.modal_coordinate)
        of_points = joint.tangential_mode @ velocity.in_time(samples).T
        viscous = law.dashpots.damping[:, None] * of_points[law.dashpots.point]
        np.add.at(of_element, law.dashpots.element, viscous)
    return u[law.point_of_element], of_element
