"""How designs of a sweep are drawn: grids, samples and tables, and the values of each key."""

from collections.abc import Mapping
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from boltjoint.config.distributions import Range, Values
from boltjoint.config.entries import Entry
from boltjoint.config.types import INTEGRAL, Count, DataFile, Problems

Array = NDArray[np.float64]


class Grid(Entry):
    """All combinations of the values of all keys: lists, and ranges with a ``number``."""

    kind: Literal["grid"]
    """How designs are chosen."""


class Samples(Entry):
    """Designs drawn from the values of all keys, each key independently of the others.

    Correlated keys are rows of a table instead: ``design: {kind: table}``.
    From a list its values are drawn equally often. In a Latin hypercube every key is spread evenly
    by itself; a scrambled Sobol sequence fills the space more evenly, best with a power of two of
    designs.
    """

    kind: Literal["latin-hypercube", "sobol"]
    """How designs are chosen."""
    number: Count
    """Number of designs."""
    seed: Annotated[int, Field(strict=True, ge=0), INTEGRAL] = 0
    """Seed of the random numbers: with the same one the designs are the same."""


class Saltelli(Entry):
    """Two samples of all keys, and the first again with each key of the second.

    Sobol indices, the shares of the keys in the variance, are found from their
    ``number * (keys + 2)`` designs.
    """

    kind: Literal["saltelli"]
    """How designs are chosen."""
    number: Count
    """Designs of each sample: a power of two."""
    seed: Annotated[int, Field(strict=True, ge=0), INTEGRAL] = 0
    """Seed of the random numbers: with the same one the designs are the same."""

    def conflicts(self) -> Problems:
        if self.number & (self.number - 1):
            yield ("number",), "must be a power of two, as 1024"


class Table(Entry):
    """Designs as the rows of a CSV file, whose columns are the keys that vary."""

    kind: Literal["table"]
    """How designs are chosen."""
    file: DataFile
    """The file, seen from the folder of ``config/``."""


Design = Annotated[Grid | Samples | Saltelli | Table, Field(discriminator="kind")]


def design_columns(vary: Mapping[str, Values], design: Design) -> dict[str, Array]:
    """Values of each key by design; of a grid the last key varies first."""
    if isinstance(design, Grid):
        axes = np.meshgrid(*map(grid_values, vary.values()), indexing="ij")
        return {key: axis.ravel() for key, axis in zip(vary, axes, strict=True)}
    # it takes half a second to import
    from scipy.stats import qmc

    if isinstance(design, Table):
        raise ValueError("the values of a table of designs are those of its columns")
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
        if values.number is None:
            raise ValueError("a range in a grid has a number of values")
        return values.quantile(np.linspace(0, 1, values.number))
    return np.array(values)
