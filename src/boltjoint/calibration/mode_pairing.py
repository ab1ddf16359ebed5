"""Modes of a model that were measured: by their number, their shape or their frequency."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]

#: a mode whose frequency is off by more than this factor is not that of the measurement
_FARTHEST = 2.0

#: least modal assurance criterion of a mode with the shape that was measured, and the largest one
#: of another mode beside it
_LEAST_ASSURANCE, _LARGEST_OF_ANOTHER = 0.8, 0.7


def paired_mode(curve: MeasuredBackbone, joints: Sequence[Joint]) -> int:
    """Number of the mode of a measured backbone in a model, from 1.

    Parameters
    ----------
    curve
        With the number of its mode, with its shape, or with neither: then that of the nearest
        frequency.
    joints
        The model with several values of its parameters; shapes are those of the first, while
        nothing slips.

    Raises
    ------
    ValueError
        If the mode is not in the model, or sensors do not tell it from others.
    """
    if curve.resonance is not None and curve.resonance > joints[0].elastic_modes:
        raise ValueError(
            f"{curve.name}: mode {curve.resonance} is not in the model, which has "
            f"{joints[0].elastic_modes} elastic modes"
        )
    frequency = float(np.median(curve.frequency))
    ranges = np.array([joint.resonance_range() for joint in joints])
    lowest, highest = ranges[..., 0], ranges[..., 1]
    # distance of ln(frequency) from the range between open and sticking contact
    distance = np.maximum(np.log(lowest / frequency), np.log(frequency / highest))
    distance = np.maximum(distance, 0).min(axis=0)
    is_near = distance <= np.log(_FARTHEST)
    sought = "nearest"
    if curve.resonance is not None:
        place, sought = curve.resonance - 1, f"mode {curve.resonance}"
    elif curve.shape is not None and is_near.any():
        place = _place_of_shape(curve.name, curve.shape, joints[0], is_near)
    else:
        place = int(np.argmin(distance))
        if np.count_nonzero(distance == distance[place]) > 1:
            names = " and ".join(str(n + 1) for n in np.flatnonzero(distance == distance[place]))
            raise ValueError(
                f"{curve.name}: modes {names} of the model may be at {frequency:.4g} Hz, between "
                "open and sticking contact: tell its resonance, or its shape"
            )
    if not is_near[place]:
        raise ValueError(
            f"{curve.name}: mode at {frequency:.4g} Hz is not in the model, whose {sought} "
            f"is from {lowest[:, place].min():.4g} to {highest[:, place].max():.4g} Hz"
        )
    return place + 1


def _place_of_shape(
    name: str, shape: Mapping[str, float], joint: Joint, is_near: NDArray[np.bool_]
) -> int:
    """Place of the mode of a shape among elastic modes of about its frequency."""
    assurance = np.where(is_near, modal_assurance(shape, joint), 0.0)
    second, best = np.argsort(assurance)[-2:] if assurance.size > 1 else (0, 0)
    if assurance[best] < _LEAST_ASSURANCE:
        raise ValueError(
            f"{name}: its shape is that of no mode of the model: mode {best + 1} is nearest, with "
            f"a modal assurance criterion of {assurance[best]:.2f}"
        )
    if second != best and assurance[second] > _LARGEST_OF_ANOTHER:
        raise ValueError(
            f"{name}: its sensors do not tell modes {best + 1} and {second + 1} apart, with modal "
            f"assurance criteria of {assurance[best]:.2f} and {assurance[second]:.2f}"
        )
    return int(best)


def modal_assurance(shape: Mapping[str, float], joint: Joint) -> Array:
    """Modal assurance criterion (MAC) of a shape and each elastic mode while nothing slips.

    Parameters
    ----------
    shape
        Amplitudes of sensors, by the names of outputs of the joint.
    joint
        The model.

    Returns
    -------
    ndarray
        From 0 to 1, shape (elastic modes,); 0 of modes in which no sensor moves.

    References
    ----------
    R. J. Allemang: The modal assurance criterion: twenty years of use and abuse. Sound and
    Vibration 37 (2003) 14-21.
    """
    rows = np.array([joint.sensors.by_name[sensor] for sensor in shape])
    rigid = joint.natural_frequency.size - joint.elastic_modes
    modes = rows @ np.linalg.eigh(joint.stiffness_while_stuck())[1][:, rigid:]
    measured = np.array(list(shape.values()))
    square = np.sum(modes**2, axis=0) * (measured @ measured)
    return np.divide((measured @ modes) ** 2, square, out=np.zeros_like(square), where=square > 0)
