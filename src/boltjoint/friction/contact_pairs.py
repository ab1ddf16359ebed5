"""Contact pairs in the assembled state, and what a case gives of them."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.declarations import PER_AREA, is_per_area

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactPairs:
    """Contact pairs in the assembled state, of which a law makes its elements.

    ``normal_load`` [N], 0 where open, ``gap`` [m], 0 where closed, and ``position`` [m] have the
    shape (pairs,), the last (pairs, 3); so have ``area`` [m2] and the name of the ``surface``, of
    pairs whose keys are given per area or by surface.
    """

    normal_load: Array
    gap: Array
    position: Array
    area: Array | None = None
    surface: NDArray[np.str_] | None = None

    def of_each(self, name: str, value: float | Array, **limits: float) -> Array:
        """A quantity of every pair, shape (pairs,), from that of all or of each.

        ``limits`` as for ``checks.number``.
        """
        if np.ndim(value) == 0:
            return np.full(self.normal_load.size, checks.number(name, value, **limits))
        return checks.array(name, value, self.normal_load.shape, **limits)

    def at(self, some: NDArray[np.int64]) -> "ContactPairs":
        """Some of the pairs."""
        return ContactPairs(*(None if each is None else each[some] for each in vars(self).values()))

    def keys(
        self,
        keys: Mapping[str, float | Array],
        of_surfaces: Mapping[str, Mapping[str, Any]] | None = None,
        further: Collection[str] = (),
    ) -> dict[str, float | Array]:
        """Arguments of ``ElementLaw.from_contact``: those per area times the area of each pair.

        Parameters
        ----------
        keys
            By the names of ``ContactKey``, in SI units.
        of_surfaces
            By the names of surfaces, the keys whose values replace those of all there, in any form.
        further
            Names of keys that each surface may have where not all have them.

        Raises
        ------
        ValueError
            If a quantity is given for each pair and per area, there is no such surface, or it has a
            quantity that not all have.
        """
        checks.mapping("keys", keys)
        found = self._of_areas(keys)
        if not of_surfaces:
            return found
        checks.mapping("surfaces", of_surfaces)
        names = self.surface if self.surface is not None else np.array([""])
        for name, own in of_surfaces.items():
            checks.choice("surface", name, np.unique(names).tolist())
            checks.mapping(f"surface {name}", own)
            here = np.flatnonzero(names == name)
            for key, value in self.at(here)._of_areas(own).items():
                checks.choice(f"key of surface {name}", key, {**found, **dict.fromkeys(further)})
                # in turn: a surface may have values of each pair where all have one
                of_all = found.get(key, np.nan)
                of_pairs = np.array(np.broadcast_to(of_all, self.normal_load.shape), dtype=float)
                of_pairs[here] = value
                found[key] = of_pairs
        return found

    def _of_areas(self, keys: Mapping[str, float | Array]) -> dict[str, float | Array]:
        """Quantities of each pair, of which some are given per area."""
        found = {}
        for name, value in keys.items():
            of_pair = name.removesuffix(PER_AREA)
            if of_pair in found:
                raise ValueError(f"{of_pair} is given for each pair and per area: give one of them")
            found[of_pair] = value * self.area if is_per_area(name) else value
        return found
