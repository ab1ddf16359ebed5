"""Clusters of contact pairs by their relative motion.

The stiffness that a joint of regions lacks is that of the springs under the scatter of the motion
within each region. Pairs are therefore clustered by their relative displacement in the modes of the
joint, scaled so that the scatter is the loss of stiffness: stuck, without contact, and with the
pairs that slip first released in between. Ward's method merges what adds least to the scatter, and
k-means improves the result. A region moves as the mean of its pairs, so each pair counts alike,
whatever its stiffness: weighed by that, pairs of one motion and other areas would be set apart.

References
----------
J. H. Ward: Hierarchical grouping to optimize an objective function. Journal of the American
Statistical Association 58 (1963) 236-244.
"""

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.cluster.vq import ClusterError, kmeans2

from boltjoint import checks
from boltjoint.joint.bands import refuse_fewer_than_surfaces
from boltjoint.joint.model import Joint
from boltjoint.joint.slip_states import (
    SlipStateOptions,
    SlipStates,
    find_slip_states,
    stiffness_at_points,
)

Array = NDArray[np.float64]
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
        found = fcluster(self._tree, points - count - 1, "monocrit", monocrit=merges) - 1
        centres = _centres(self._motion, found)
        # k-means may empty a cluster where pairs move the same: then those of the tree stay
        with suppress(ClusterError):
            found = kmeans2(self._motion, centres, 50, minit="matrix", missing="raise")[1]
        centres = np.column_stack([self._surface, self._place])
        first = np.lexsort(_centres(centres, found).T[::-1])
        rank = np.empty(count, dtype=np.int64)
        rank[first] = np.arange(count)
        return rank[found]

    def _apart(self) -> Array:
        """Columns that keep surfaces apart: a merger across them adds more than all scatter."""
        scatter = np.sum((self._motion - self._motion.mean(axis=0)) ** 2)
        return 2 * (np.sqrt(scatter) or 1.0) * np.eye(self._surface.max() + 1)[self._surface]


def _centres(values: Array, region: Labels) -> Array:
    """Mean of every column of values over each region, shape (regions, columns)."""
    size = np.bincount(region)
    return np.column_stack([np.bincount(region, column) / size for column in values.T])
