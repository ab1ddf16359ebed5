"""Random friction elements in both directions of the contact plane, and their motion."""

import numpy as np

CONSTANT, VARIABLE = "constant", "variable"


def constant_load(count, harmonics=1, seed=0):
    """Elements from deep in stick to deep in slip, and their motion along x and along y."""
    random = np.random.default_rng(seed)
    k = 10 ** random.uniform(6, 9, count)
    slip = 10 ** random.uniform(-1, 3, count)
    size = (slip / k * 10 ** random.uniform(-1, 1.5, count))[:, None]
    x, y = size * random.normal(size=(2, count, 2 * ((harmonics + 1) // 2)))
    return (np.arange(count), k, slip), [x, random.uniform(0, 1, (count, 1)) * y]


def variable_load(count, harmonics=1, seed=0):
    """Elements in every state of contact, some with a gap, and their motion along x, y and z."""
    random = np.random.default_rng(seed)
    k_u, k_v = 10 ** random.uniform(6, 9, (2, count))
    load = 10 ** random.uniform(-1, 3, count)
    mu = random.uniform(0.05, 0.8, count)
    sign = random.choice([1, 1, 1, -1], count)
    x, y, v = random.normal(size=(3, count, 1 + 2 * harmonics))
    size = (mu * load / k_u * 10 ** random.uniform(-1, 1.5, count))[:, None]
    v *= (load / k_v * 10 ** random.uniform(-1, 0.5, count))[:, None]
    y *= random.uniform(0, 1, (count, 1))
    return (np.arange(count), k_u, k_v, sign * load, mu), [size * x, size * y, v]
