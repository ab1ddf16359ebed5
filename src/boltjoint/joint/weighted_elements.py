"""Elements that stand for several: those of a joint, with all their forces times a weight.

A weighted element has its stiffness and slip force times the weight, so it slips at the same
displacement as one without.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.friction.law import ElementLaw
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]

#: elements are alike whose modes and quantities differ by this share of the largest: by rounding
_ALIKE = 1e-11

_TINY = np.finfo(float).tiny


def keep_elements(joint: Joint, weight: Array) -> Joint:
    """A joint of those elements that have a weight, which bear all forces times it.

    Parameters
    ----------
    joint
        A joint whose law is made of elements.
    weight
        Of each element, zero of those that are left out, shape (elements,). Points without elements
        are left out, too.

    Raises
    ------
    ValueError
        If a weight is negative, or none is positive.
    """
    law = joint.law
    weight = checks.array("weight", weight, law.point_of_element.shape, at_least=0)
    kept = np.flatnonzero(weight)
    if not kept.size:
        raise ValueError("weight is zero of all elements")
    points, on = np.unique(law.point_of_element[kept], return_inverse=True)
    # forces and stiffnesses belong to the elements, ratios of them do not
    scaled = {
        name: getattr(law, name)[kept] * (1.0 if unit == "1" else weight[kept])
        for name, (unit, _) in law.quantities.items()
    }
    return replace(
        joint,
        law=type(law)(point_of_element=on, **scaled),
        tangential_mode=joint.tangential_mode[points],
        normal_mode=None if joint.normal_mode is None else joint.normal_mode[points],
        position=joint.position[points],
        element_position=joint.element_position[kept],
    )


def count_alike(joint: Joint) -> Array:
    """How many elements move and slip as each does; 0 of those that another one stands for.

    Elements on both sides of a plane of symmetry are alike in motion that is symmetric too.

    Parameters
    ----------
    joint
        A joint whose law is made of elements.

    Returns
    -------
    ndarray
        Shape (elements,).
    """
    law = joint.law
    described = [B[law.point_of_element] for B in joint.rows]
    described += [getattr(law, name)[:, None] for name in law.quantities]
    features = np.hstack([each / max(abs(each).max(), _TINY) for each in described])
    # alike elements are next to each other in the order of any sum of what describes them
    order = np.argsort(features @ np.cos(np.arange(features.shape[1])))
    changes = abs(np.diff(features[order], axis=0)).max(axis=1) > _ALIKE
    first = np.flatnonzero(np.concatenate([[True], changes]))
    alike = np.zeros(len(features))
    alike[np.minimum.reduceat(order, first)] = np.diff(first, append=len(features))
    return alike


def merge_alike(joint: Joint) -> Joint:
    """The joint in which one element stands for all that move and slip alike.

    Its responses and backbones are those of the whole joint, at half the work where that is
    symmetric about a plane. A joint whose law is not made of elements is returned as it is.
    """
    if not isinstance(joint.law, ElementLaw):
        return joint
    alike = count_alike(joint)
    return joint if alike.all() else keep_elements(joint, alike)
