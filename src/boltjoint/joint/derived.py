"""Joints made from others: with other values, merged points, or other contact and preload.

For the last, contact without initial gap is homogeneous: loads and gaps of the assembled state
are those of another preload times the ratio of both. With coefficients that are the same on all
pairs of a surface, or per area, every quantity of an element is then a constant times one of these,
and of the preload.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: eq. 3.1 and 3.2.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.combined import elements_of_pairs
from boltjoint.friction.element_law import ContactPairs, ElementLaw
from boltjoint.friction.protocol import FrictionLaw
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]


def with_elements(joint: Joint, law: FrictionLaw, natural_frequency: Array) -> Joint:
    """The same joint with other values of its elements and of its structure.

    Fits make thousands of them: what stays is not checked again.

    Parameters
    ----------
    joint
        Any joint.
    law
        Of the same kind, with as many elements, on the same points.
    natural_frequency
        As of the joint [Hz], shape (modes,).

    Raises
    ------
    ValueError
        If a natural frequency is negative or not finite, there are not as many, or the elements are
        on other points.
    """
    checks.instance("law", law, type(joint.law))
    if not np.array_equal(law.point_of_element, joint.law.point_of_element):
        raise ValueError("law: its elements must be on the points of those of the joint")
    size = joint.natural_frequency.shape
    frequency = checks.array("natural_frequency", natural_frequency, size, at_least=0)
    values = {entry.name: getattr(joint, entry.name) for entry in fields(joint)}
    values |= {"law": law, "natural_frequency": frequency}
    updated = object.__new__(type(joint))
    vars(updated).update(values, contact=replace(joint.contact, law=law))
    return updated


def merge_points(joint: Joint, region: NDArray[np.int64], weight: Array | None = None) -> Joint:
    """Joint of regions, each moving as one artificial point, the mean of its points (eq. 3.1, 3.2).

    Every element stays; those of a region all see the displacement of its point.

    Parameters
    ----------
    joint
        A joint with any number of points.
    region
        Region of every point, from 0 without gaps, shape (points,).
    weight
        Weight of every point in the mean of its region, shape (points,); equal by default.

    Returns
    -------
    Joint
        With as many points as regions, and the elements of the joint.

    Raises
    ------
    ValueError
        If the regions do not fit the points, a number is left out, a region has points of two
        surfaces, or a weight is negative or all weights of a region are zero.
    """
    checks.instance("joint", joint, Joint)
    region = checks.indices("region", region, (joint.points,))
    size = np.bincount(region)
    if np.any(size == 0):
        raise ValueError(f"region must count from 0 without gaps: no point has {np.argmin(size)}")
    if weight is None:
        share = 1 / size[region]
    else:
        weight = checks.array("weight", weight, region.shape, at_least=0)
        total = np.bincount(region, weight)
        if np.any(total == 0):
            raise ValueError(f"weight is zero in all of region {np.argmin(total)}")
        share = weight / total[region]
    mean = np.zeros((size.size, joint.points))
    mean[region, np.arange(joint.points)] = share
    return replace(
        joint,
        **joint.moved_as(lambda B: mean @ B),
        position=mean @ joint.position,
        places=joint.places and joint.places.merged(mean, region),
        law=joint.contact.element_law.moved_to(region[joint.law.point_of_element]),
    )


def rescale_contact(
    joint: Joint,
    law: type[ElementLaw] | str,
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
        One of ``friction.registry.LAWS``, or its name: that of the pairs, which a reduction may
        have replaced.
    before, after
        As for ``node_to_node.connect_pairs``, with ``surfaces``: the same keys, each in the same
        form.
    preload_ratio
        The new preload of the bolts over that before; 1 of pairs with an initial gap, whose loads
        do not grow with the preload.

    Returns
    -------
    Joint
        Of the same points and elements.

    Raises
    ------
    ValueError
        If the law of the joint has no elements, a coefficient or the ratio is out of range, or the
        keys differ.
    """
    elements = checks.instance("joint", joint, Joint).contact.element_law
    for name, keys in (("before", before), ("after", after)):
        checks.mapping(name, keys)
    ratio = checks.number("preload_ratio", preload_ratio, above=0)
    if _all_keys(before) != _all_keys(after):
        raise ValueError(f"after must have the keys of before: {', '.join(before)}")
    surface = joint.surface_places.name[joint.law.point_of_element]
    for name in np.unique(surface):
        old, new = (
            elements_of_pairs(_two_pairs(str(name), ratio), law, **_keys_on(str(name), keys))[0]
            for ratio, keys in ((1.0, before), (ratio, after))
        )
        elements = _rescaled(elements, old, new, surface == name)
    return replace(joint, law=elements)


def _all_keys(keys: Mapping[str, Any]) -> dict[str, set[str]]:
    """Names of the keys, and of those of each surface."""
    of_surfaces = {name: set(own) for name, own in keys.get("surfaces", {}).items()}
    return {"": set(keys), **of_surfaces}


def _two_pairs(surface: str, ratio: float) -> ContactPairs:
    """A closed and an open pair, whose load and gap are this; of one area, whatever it is."""
    load, gap = np.array([ratio, 0.0]), np.array([0.0, ratio])
    return ContactPairs(load, gap, np.zeros((2, 3)), np.ones(2), np.full(2, surface))


def _keys_on(surface: str, keys: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of all surfaces, and those of one."""
    own = {
        name: keys_of_surface
        for name, keys_of_surface in keys.get("surfaces", {}).items()
        if name == surface
    }
    return {**keys, "surfaces": own}


def _rescaled(
    elements: ElementLaw, old: ElementLaw, new: ElementLaw, mine: NDArray[np.bool_]
) -> ElementLaw:
    """Elements of which some change as those of a closed pair, and of an open one if any, do."""
    varies = "normal_load" in elements.quantities
    of = np.where(elements.quantity("normal_load")[mine] > 0, 0, -1) if varies else 0
    changed = {}
    for name, (unit, _) in elements.quantities.items():
        if name not in old.quantities:
            continue
        before, after = old.quantity(name), new.quantity(name)
        changed[name] = elements.quantity(name).copy()
        # ratios are those of the pairs; all else belongs to the element
        changed[name][mine] = (
            after[0] if unit == "1" else changed[name][mine] * (after / before)[of]
        )
    return elements.with_quantities(changed)
