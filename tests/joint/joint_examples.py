"""Jenkins elements, positions and joints that the tests of this package share."""

from dataclasses import replace

import numpy as np
from small_joint import make_joint


def many_elements(count=200):
    random = np.random.default_rng(4)
    return np.full(count, 1e8), random.gamma(0.8, 3.0, count) + 1e-3


def grid(x, y):
    """Positions on all places x along the bar and y across it, one column after another."""
    return np.column_stack([np.repeat(x, len(y)), np.tile(y, len(x))]).astype(float)


def frozen_in_groups(law, groups=5):
    """A joint whose pairs move as one of a few points each, at random places."""
    joint = make_joint(law=law)
    group = np.random.default_rng(2).integers(0, groups, joint.points)
    normal = None if joint.normal_mode is None else joint.normal_mode[group]
    return replace(joint, tangential_mode=joint.tangential_mode[group], normal_mode=normal), group
