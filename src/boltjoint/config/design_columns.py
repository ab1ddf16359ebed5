"""Designs of a sweep: the values of each key by design."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.distributions import Range, Values
from boltjoint.config.sweep import Design, Grid, Saltelli

Array = NDArray[np.float64]


def design_columns(vary: Mapping[str, Values], design: Design) -> dict[str, Array]:
    """Values of each key by design; of a grid the last key varies first."""
    if isinstance(design, Grid):
        axes = np.meshgrid(*map(grid_values, vary.values()), indexing="ij")
        return {key: axis.ravel() for key, axis in zip(vary, axes, strict=True)}
    # it takes half a second to import
    from scipy.stats import qmc

    if isinstance(design, Saltelli):
        # as scipy.stats.sobol_indices draws them
        both = qmc.Sobol(2 * len(vary), rng=design.seed).random(design.number).T
        shares = exchanged(*np.split(both, 2))
    else:
        kinds = {"sobol": qmc.Sobol, "latin-hypercube": qmc.LatinHypercube}
        shares = kinds[design.kind](len(vary), rng=design.seed).random(design.number).T
    drawn = zip(vary.items(), shares, strict=True)
    return {key: _quantile(values, share) for (key, values), share in drawn}


def exchanged(first: Array, second: Array) -> Array:
    """Both samples, (keys, designs), and the first with each key in turn of the second."""
    keys = len(first)
    mixed = np.repeat(first[:, None], keys, axis=1)
    mixed[range(keys), range(keys)] = second
    return np.concatenate([first, second, mixed.reshape(keys, -1)], axis=1)


def _quantile(values: Values, share: Array) -> Array:
    if isinstance(values, tuple):
        return np.array(values)[(share * len(values)).astype(int)]
    return values.quantile(share)


def grid_values(values: Values) -> Array:
    """Values of a key in a grid."""
    if isinstance(values, Range):
        return values.quantile(np.linspace(0, 1, values.number))
    return np.array(values)
