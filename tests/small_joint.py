"""A joint small enough for tests, with loads and relative modes that vary along it."""

import numpy as np

from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint import Joint


def make_joint(pairs: int = 60, seed: int = 1) -> Joint:
    """A bar with three modes and many pairs whose loads and relative modes vary along it."""
    random = np.random.default_rng(seed)
    x = np.sort(random.uniform(0.0, 0.1, pairs))
    y = random.uniform(-0.01, 0.01, pairs)
    along = np.column_stack([0.04 + 0.3 * x, -0.1 + 1.5 * x, 0.1 * np.sin(60 * x)])
    load = 300.0 / pairs * (1.2 + np.cos(2 * np.pi * x / 0.033)) * random.uniform(0.5, 1.5, pairs)
    position = np.column_stack([x, y, np.zeros(pairs)])
    return Joint(
        natural_frequency=np.array([70.0, 360.0, 950.0]),
        excitation_mode=np.array([2.0, -1.9, 1.8]),
        response_mode=np.array([2.0, -1.9, 1.8]),
        tangential_mode=along,
        position=position,
        law=ConstantLoad(np.arange(pairs), np.full(pairs, 3e8 / pairs), load),
        element_position=position,
    )
