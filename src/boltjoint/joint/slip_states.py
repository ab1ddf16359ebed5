"""States of a joint between stuck and full slip, by which partitions are judged."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from boltjoint import checks
from boltjoint.joint.model import Joint

#: shares of the load that has let go in the states of slip by which regions are made and judged
_LET_GO = np.arange(9) / 8


#: shares of the load that slips at the amplitudes of these states, within the ends: where the very
#: last element slips depends on how near it is to rest
_SLIPS = (np.arange(9) + 0.5) / 9


@dataclass(frozen=True)
class SlipStates:
    """A joint while its elements let go one after another, those of least load first.

    ``sticks`` has the shape (states, elements), ``mode`` (states, resonances, modes), ``frequency``
    [rad/s] and ``amplitude`` (states, resonances); modes are of unit length, and at the amplitude
    [kg^1/2 m] about as much of the load slips in the mode as has let go.
    """

    sticks: NDArray[np.bool_]
    frequency: NDArray[np.float64]
    mode: NDArray[np.float64]
    amplitude: NDArray[np.float64]


def find_slip_states(joint: Joint, resonances: int) -> SlipStates:
    check_resonances(joint, resonances)
    modes = joint.natural_frequency.size
    load = joint.law.slip_force
    if not load.any():
        raise ValueError("no element of the joint carries load: there is nothing to slip")
    order = np.argsort(load, kind="stable")
    let_go = np.cumsum(load[order]) / load.sum()
    # by a threshold, so that elements with the same load let go together
    threshold = np.append(load[order][np.searchsorted(let_go, _LET_GO[:-1], "right")], np.inf)
    sticks = (load >= threshold[:, None]) & (load > 0)
    shape = (len(sticks), resonances)
    frequency, amplitude = np.empty(shape), np.empty(shape)
    mode = np.empty((*shape, modes))
    loaded = load > 0
    limit = load[loaded] / joint.law.tangential_stiffness[loaded]
    on = joint.law.point_of_element[loaded]
    for i, stuck in enumerate(sticks):
        square, vectors = eigh(
            modal_stiffness_where(joint, stuck), subset_by_index=[0, resonances - 1]
        )
        frequency[i], mode[i] = np.sqrt(square), vectors.T
        for r in range(resonances):
            moved = np.abs(joint.tangential_mode @ mode[i, r])[on]
            slips_at = limit / np.maximum(moved, np.finfo(float).tiny)
            by_amplitude = np.argsort(slips_at, kind="stable")
            share = np.cumsum(load[loaded][by_amplitude]) / load.sum()
            amplitude[i, r] = slips_at[by_amplitude[np.searchsorted(share, _SLIPS[i])]]
    return SlipStates(sticks, frequency, mode, amplitude)


def modal_stiffness_where(joint: Joint, stuck: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Modal stiffness of a joint where only some elements stick [s^-2], shape (modes, modes)."""
    total = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    for B, k in zip(joint.rows, stiffness_at_points(joint, stuck), strict=True):
        total += B.T @ (k[:, None] * B)
    return total


def stiffness_at_points(
    joint: Joint, counts: NDArray[np.bool_] | None = None
) -> list[NDArray[np.float64]]:
    """Stiffness of all elements that count, at each point and by direction [N/m], (points,)."""
    law = joint.law
    of_elements = [getattr(law, f"{direction}_stiffness") for direction in law.directions]
    return [
        np.bincount(law.point_of_element, k if counts is None else k * counts, joint.points)
        for k in of_elements
    ]


def check_resonances(joint: Joint, resonances: int) -> None:
    checks.whole("resonances", resonances, at_least=1, at_most=joint.natural_frequency.size)
