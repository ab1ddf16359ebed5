"""What a check tells of a model from files, in words that are the same for all makers."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: millimetres of a metre
MM = 1e3


def direction_in_words(components: Array) -> str:
    """Components along x, y, z."""
    return f"({', '.join(f'{component:.3g}' for component in components)})"


def contact_in_words(name: str, area: Array, gap: Array) -> str:
    """Points of a surface, their area [m2] and gaps [m], shape (points,)."""
    return (
        f"{name}: {len(area)} points, {1e4 * area.sum():.5g} cm², gaps {MM * gap.min():.3g} to "
        f"{MM * gap.max():.3g} mm"
    )


def doubts_of_size(
    what: str, position: Array, usual: tuple[float, float], key: str
) -> Iterator[str]:
    """A line where nodes or points, (points, 3) [m], take less or more room than usual [m].

    The key is that of their unit.
    """
    size = float(np.ptp(position, axis=0).max())
    if size and not usual[0] <= size <= usual[1]:
        yield f"{what} {MM * size:.4g} mm is unusual: is {key} right?"
