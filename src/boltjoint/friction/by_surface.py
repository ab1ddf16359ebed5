"""Elements of contact pairs whose surfaces differ in their friction law."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.contact_pairs import ContactPairs
from boltjoint.friction.element_law import Array, ElementLaw


def elements_by_surface(
    pairs: ContactPairs,
    law: type[ElementLaw],
    surfaces: Mapping[str, Mapping[str, Any]],
    keys: Mapping[str, float | Array],
) -> list[tuple[ElementLaw, NDArray[np.int64]]]:
    """Elements of each law, and those of the pairs that carry them.

    Parameters
    ----------
    pairs
        The contact under preload, with the surface of each pair, and its area where a key is given
        per area.
    law
        That of surfaces which name none.
    surfaces
        By the names of surfaces, ``law`` and the keys whose values replace those of all there.
    keys
        Keys of all surfaces, as for ``from_contact`` of the laws or per area. Those that the law of
        a surface does not know do not count there.

    Raises
    ------
    ValueError
        As for ``ContactPairs.keys`` and the laws, or if there is no such surface, or one lacks a
        key of its law.
    """
    names = np.full(pairs.normal_load.shape, "") if pairs.surface is None else pairs.surface
    there = np.unique(names).tolist()
    for name in surfaces:
        checks.choice("surface", name, there)
    law_of = {name: surfaces.get(name, {}).get("law", law) for name in there}
    found = []
    for each in dict.fromkeys(law_of.values()):
        mine = [name for name in there if law_of[name] is each]
        here = np.flatnonzero(np.isin(names, mine))
        of_mine = {name: surfaces[name] for name in mine if name in surfaces}
        given = _keys_of(each, pairs.at(here), keys, of_mine)
        elements, carrying = each.from_contact(pairs.at(here), **given)
        found.append((elements, here[carrying]))
    return found


def _keys_of(
    law: type[ElementLaw],
    pairs: ContactPairs,
    keys: Mapping[str, float | Array],
    surfaces: Mapping[str, Mapping[str, Any]],
) -> dict[str, float | Array]:
    """Arguments of ``from_contact`` of a law, for the pairs of all surfaces that follow it."""
    known = [each.name for each in law.declaration.keys or ()]
    forms = {form.name for each in law.declaration.keys or () for form in each.forms}
    own = {
        name: {key: value for key, value in each.items() if key != "law"}
        for name, each in surfaces.items()
    }
    of_all = {name: value for name, value in keys.items() if name in forms}
    found = pairs.keys(of_all, own, further=known)
    for name in known:
        lacking = np.broadcast_to(np.isnan(found.get(name, np.nan)), pairs.normal_load.shape)
        if lacking.any():
            raise ValueError(
                f"surface {pairs.surface[np.flatnonzero(lacking)[0]]} has no {name}, which the law "
                f"{law.declaration.name!r} needs"
            )
    return found
