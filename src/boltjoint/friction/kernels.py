"""Forces of the elements of any law in compiled loops: each law brings its kernel.

Its compiled function ``add_forces(elements, motion, force, tangent)`` adds the forces of all
``Elements`` to ``force``, and their tangents to ``tangent`` unless that is empty; motion, force and
tangent are those of ``FrictionLaw.force_and_tangent``.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint.compiled import address_of

Array = NDArray[np.float64]


class Elements(NamedTuple):
    """Arrays of the elements of a law.

    Attributes
    ----------
    indices
        By element, as a rule the point it acts on, shape (elements,).
    quantities
        What describes each element, shape (quantities, elements).
    table
        Empty, or whatever else the kernel needs.
    """

    indices: NDArray[np.int64]
    quantities: Array
    table: Array

    @classmethod
    def of(
        cls, indices: NDArray[np.int64], quantities: Sequence[Array], table: Array | None = None
    ) -> "Elements":
        """Copies of these arrays, as kernels are compiled for them."""
        table = np.zeros((0, 0)) if table is None else table
        # a law without elements has quantities too
        rows = np.array(quantities, float).reshape(len(quantities), -1)
        return cls(np.array(indices, np.int64), rows, np.array(table, float))


class Kernel(NamedTuple):
    """The compiled function that adds the forces of a law, and the elements that it is given."""

    add_forces: Callable
    elements: Elements


@cache
def address_of_kernel(add_forces: Callable) -> int:
    """Where compiled loops find the function that adds the forces of a law."""
    none = np.zeros((0, 2))
    elements = Elements.of(np.zeros(0, np.int64), [np.zeros(0)])
    return address_of(add_forces, elements, none, none, np.zeros((0, 2, 2)))
