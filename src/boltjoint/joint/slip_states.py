"""Slip states of a joint: nested states of stick between fully stuck and full slip.

They give the resonance while an increasing slip fraction of the contact is released, before any
response is solved. Regions are made and judged by them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from boltjoint import checks
from boltjoint.joint.model import Joint
from boltjoint.options import Options

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class SlipStateOptions(Options):
    """How many slip states regions are made and judged by.

    Parameters
    ----------
    states
        From fully stuck to full slip, the released load growing evenly. Half or twice as many move
        the peaks of the default study under constant load (``free-4``, 1 to 50 N) by at most 2e-3
        in frequency and 3e-2 in amplitude with 12 clusters, 2e-2 and 0.2 with 6. The numbers of
        clusters chosen by tolerances of 1e-2 and 3e-3 change by at most 3. The error of bands of
        equal load does not change.

    Raises
    ------
    ValueError
        If they are not two or more.
    """

    states: int = 9

    def __post_init__(self) -> None:
        """Refuse fewer than the two ends."""
        checks.whole("states", self.states, at_least=2)


@dataclass(frozen=True)
class SlipStates:
    """Modes of a joint whose elements are released one after another, as they slip.

    With one displacement of all that is those of least load over stiffness first.

    ``stick`` has the shape (states, elements), ``mode`` (states, resonances, modes), ``frequency``
    [rad/s] and ``amplitude`` (states, resonances); modes are of unit length, and at the amplitude
    [kg^1/2 m] about as much of the load slips in the mode as is released.
    """

    stick: Flags
    frequency: Array
    mode: Array
    amplitude: Array


def find_slip_states(
    joint: Joint, resonances: int, options: SlipStateOptions = SlipStateOptions()
) -> SlipStates:
    """Slip states of a node-to-node joint for its first resonances.

    Raises
    ------
    ValueError
        If there are fewer modes than resonances, or no element carries load.
    """
    check_resonances(joint, resonances)
    checks.instance("options", options, SlipStateOptions)
    steps = np.arange(options.states)
    released_load = steps / (options.states - 1)
    # within the ends: where the very last element slips depends on how near it is to rest
    slip_fraction_of_state = (steps + 0.5) / options.states
    modes = joint.natural_frequency.size
    load, stiffness = joint.law.slip_force, joint.law.tangential_stiffness
    if not load.any():
        raise ValueError("no element of the joint carries load: there is nothing to slip")
    # as slip displacements, but to the bit the loads where all have one stiffness
    grade = load * (stiffness.max() / stiffness)
    order = np.argsort(grade, kind="stable")
    released = np.cumsum(load[order]) / load.sum()
    # by a threshold, so that elements that slip together are released together
    first = np.searchsorted(released, released_load[:-1], "right")
    threshold = np.append(grade[order][first], np.inf)
    stick = (grade >= threshold[:, None]) & (load > 0)
    shape = (len(stick), resonances)
    frequency, amplitude = np.empty(shape), np.empty(shape)
    mode = np.empty((*shape, modes))
    loaded = load > 0
    limit = load[loaded] / stiffness[loaded]
    on = joint.law.point_of_element[loaded]
    places = [joint.place_of(1), joint.place_of(resonances)]
    for i, stuck in enumerate(stick):
        square, vectors = eigh(modal_stiffness_where(joint, stuck), subset_by_index=places)
        frequency[i], mode[i] = np.sqrt(square), vectors.T
        for r in range(resonances):
            in_plane = [B @ mode[i, r] for B in joint.contact.rows_in_plane]
            moved = np.linalg.norm(in_plane, axis=0)[on]
            onset = limit / np.maximum(moved, np.finfo(float).tiny)
            by_onset = np.argsort(onset, kind="stable")
            slip_fraction = np.cumsum(load[loaded][by_onset]) / load.sum()
            last = np.searchsorted(slip_fraction, slip_fraction_of_state[i])
            amplitude[i, r] = onset[by_onset[last]]
    return SlipStates(stick, frequency, mode, amplitude)


def modal_stiffness_where(joint: Joint, stuck: Flags) -> Array:
    """Modal stiffness of a joint where only some elements stick [s^-2], shape (modes, modes)."""
    total = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    for B, k in zip(joint.rows, stiffness_at_points(joint, stuck), strict=True):
        total += B.T @ (k[:, None] * B)
    return total


def stiffness_at_points(joint: Joint, stuck: Flags | None = None) -> list[Array]:
    """Stiffness of all elements, or the stuck ones, at each point by direction [N/m], (points,)."""
    law = joint.law
    of_elements = [law.stiffness_along(direction) for direction in law.directions]
    return [
        np.bincount(law.point_of_element, k if stuck is None else k * stuck, joint.points)
        for k in of_elements
    ]


def check_resonances(joint: Joint, resonances: int) -> None:
    """Refuse more resonances than the joint has modes."""
    checks.instance("joint", joint, Joint)
    checks.whole("resonances", resonances, at_least=1, at_most=joint.elastic_modes)
