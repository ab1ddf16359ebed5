"""Joints under other contact coefficients and another preload than they were made with.

Contact without initial gap is homogeneous: loads and gaps of the assembled state are those of
another preload times the ratio of both. With coefficients that are the same on all pairs of a
surface, or per area, every quantity of an element is then a constant times one of these, and of the
preload.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.declarations import keys_of_pairs
from boltjoint.friction.law import ContactPairs, ElementLaw
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


def rescale_contact(
    joint: Joint,
    law: type[ElementLaw],
    before: Mapping[str, Any],
    after: Mapping[str, Any],
    preload_ratio: float = 1.0,
) -> Joint:
    """The joint as it is with other coefficients of its contact pairs and another preload.

    A node-to-node joint, regions of given bands and elements that were fitted to them are those
    that are made from these coefficients; of clusters and weighted pairs, those chosen before stay.

    Parameters
    ----------
    joint
        A joint made from contact pairs of the law with the coefficients ``before``.
    law
        One of ``friction.laws.LAWS``: that of the pairs, which a reduction may have replaced.
    before, after
        As for ``node_to_node.connect_pairs``, with ``surfaces``: the same keys, each in the same
        form.
    preload_ratio
        The new preload of the bolts over that before; 1 of pairs with an initial gap, whose loads
        do not grow with the preload.

    Raises
    ------
    ValueError
        If the law of the joint has no elements, a coefficient or the ratio is out of range, or the
        keys differ.
    """
    checks.instance("joint", joint, Joint)
    checks.instance("law of the joint", joint.law, ElementLaw)
    checks.subclass("law", law, ElementLaw)
    for name, keys in (("before", before), ("after", after)):
        checks.mapping(name, keys)
    ratio = checks.number("preload_ratio", preload_ratio, above=0)
    pairs = ContactPairs(np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.zeros((2, 3)))
    scaled = ContactPairs(ratio * pairs.normal_load, ratio * pairs.gap, pairs.position)
    if _all_keys(before) != _all_keys(after):
        raise ValueError(f"after must have the keys of before: {', '.join(before)}")
    surface = joint.surface_places.name[joint.law.point_of_element]
    elements = joint.law
    for name in np.unique(surface):
        # of pairs of the same area, whatever it is
        old, new = (
            law.from_contact(contact, **_keys_on(str(name), keys, np.ones(2)))[0]
            for contact, keys in ((pairs, before), (scaled, after))
        )
        elements = _rescaled(elements, old, new, surface == name)
    return replace(joint, law=elements)


def _all_keys(keys: Mapping[str, Any]) -> dict[str, set[str]]:
    """Names of the keys, and of those of each surface."""
    of_surfaces = {name: set(own) for name, own in keys.get("surfaces", {}).items()}
    return {"": set(keys), **of_surfaces}


def _keys_on(surface: str, keys: Mapping[str, Any], area: Array) -> dict[str, Any]:
    """Arguments of ``from_contact`` for pairs of these areas on one surface."""
    of_all = {name: value for name, value in keys.items() if name != "surfaces"}
    own = {name: each for name, each in keys.get("surfaces", {}).items() if name == surface}
    return keys_of_pairs(of_all, area, np.full(area.shape, surface), own)


def _rescaled(
    elements: ElementLaw, old: ElementLaw, new: ElementLaw, mine: NDArray[np.bool_]
) -> ElementLaw:
    """Elements of which some change as those of a closed pair, and of an open one if any, do."""
    normal_load = getattr(elements, "normal_load", None)
    of = 0 if normal_load is None else np.where(normal_load[mine] > 0, 0, -1)
    changed = {}
    for name, (unit, _) in elements.quantities.items():
        if name not in old.quantities:
            continue
        before, after = getattr(old, name), getattr(new, name)
        changed[name] = getattr(elements, name).copy()
        # ratios are those of the pairs; all else belongs to the element
        changed[name][mine] = (
            after[0] if unit == "1" else changed[name][mine] * (after / before)[of]
        )
    return replace(elements, **changed)
