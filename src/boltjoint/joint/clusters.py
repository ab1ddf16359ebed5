"""Clusters of contact pairs by their relative motion, stuck, released, and in slip states between.

The stiffness that a joint of regions lacks is that of the springs under the scatter of the motion
within each region. Pairs are therefore clustered by their relative displacement in the modes of the
joint, scaled so that the scatter is the loss of stiffness: stuck, without contact, and with the
pairs that slip first released in between. Ward's method merges what adds least to the scatter, and
k-means improves the result. A region moves as the mean of its pairs, so each pair counts alike,
whatever its stiffness: weighed by that, pairs of one motion and other areas would be set apart.

Slip states are nested states of stick between fully stuck and full slip. They give the resonance
while an increasing slip fraction of the contact is released, before any response is solved.
Regions are made and judged by them.

References
----------
J. H. Ward: Hierarchical grouping to optimize an objective function. Journal of the American
Statistical Association 58 (1963) 236-244.
"""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.cluster.vq import ClusterError, kmeans2
from scipy.linalg import eigh

from boltjoint import checks
from boltjoint.joint.bands import refuse_fewer_than_surfaces
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
    law, points = joint.contact.element_law, joint.points
    of_elements = [law.stiffness_along(direction) for direction in law.directions]
    return [
        np.asarray(
            np.bincount(law.point_of_element, k if stuck is None else k * stuck, points), float
        )
        for k in of_elements
    ]


def check_resonances(joint: Joint, resonances: int) -> None:
    """Refuse more resonances than the joint has modes."""
    checks.instance("joint", joint, Joint)
    checks.whole("resonances", resonances, at_least=1, at_most=joint.elastic_modes)


Labels = NDArray[np.int64]


def cluster_by_motion(
    joint: Joint,
    count: int,
    *,
    resonances: int = 1,
    options: SlipStateOptions = SlipStateOptions(),
) -> Labels:
    """Cluster the pairs by their motion while a resonance passes from stick to slip.

    Parameters
    ----------
    joint
        Node-to-node joint.
    count
        Number of clusters.
    resonances
        Number of resonances whose modes are compared, from the first.
    options
        Number of slip states.

    Returns
    -------
    ndarray
        Cluster of every pair, shape (pairs,), numbered surface by surface by their centres along
        the first tangent. A cluster lies on one surface.

    Raises
    ------
    ValueError
        If there are fewer pairs than clusters, fewer clusters than surfaces, or fewer modes than
        resonances.
    """
    checks.instance("joint", joint, Joint)
    return MotionClusters(joint, find_slip_states(joint, resonances, options)).regions(count)


class MotionClusters:
    """Clusters of the points of a joint for any count, from one hierarchical tree."""

    def __init__(self, joint: Joint, states: SlipStates) -> None:
        places = joint.surface_places
        self._surface, self._place = places.number, places.place
        # scaled so that scatter is the loss of squared frequency, relative, of each mode
        modes = (states.mode / states.frequency[..., None]).reshape(
            -1, joint.natural_frequency.size
        )
        self._motion = np.hstack(
            [
                np.sqrt(k.mean()) * (B @ modes.T)
                for B, k in zip(joint.rows, stiffness_at_points(joint), strict=True)
            ]
        )
        if self._surface.any():
            self._motion = np.hstack([self._motion, self._apart()])
        self._tree = linkage(self._motion, "ward")

    def regions(self, count: int) -> Labels:
        """Cluster of every point, as from ``cluster_by_motion``."""
        points = len(self._motion)
        if not 1 <= checks.whole("count", count) <= points:
            raise ValueError(f"{points} pairs do not divide into {count} regions")
        refuse_fewer_than_surfaces(count, self._surface.max() + 1)
        # the first merges of the tree, by their order: equal heights would merge too many at once
        merges = np.arange(points - 1, dtype=float)
        labels = fcluster(self._tree, points - count - 1, "monocrit", monocrit=merges) - 1
        centres = _centres(self._motion, labels)
        # k-means may empty a cluster where pairs move the same: then those of the tree stay
        with suppress(ClusterError):
            labels = kmeans2(self._motion, centres, 50, minit="matrix", missing="raise")[1]
        centres = np.column_stack([self._surface, self._place])
        first = np.lexsort(_centres(centres, labels).T[::-1])
        rank = np.empty(count, dtype=np.int64)
        rank[first] = np.arange(count)
        return rank[labels]

    def _apart(self) -> Array:
        """Columns that keep surfaces apart: a merger across them adds more than all scatter."""
        scatter = np.sum((self._motion - self._motion.mean(axis=0)) ** 2)
        return 2 * (np.sqrt(scatter) or 1.0) * np.eye(self._surface.max() + 1)[self._surface]


def _centres(values: Array, region: Labels) -> Array:
    """Mean of every column of values over each region, shape (regions, columns)."""
    size = np.bincount(region)
    return np.column_stack([np.bincount(region, column) / size for column in values.T])
