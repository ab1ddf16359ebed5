"""Springs with sliders, and their forces at the samples of a period (AFT)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint.friction.aft_kernels import Array, SampleTables, add_forces


@dataclass(frozen=True)
class Sliders:
    """Springs in series with sliders, whose forces add up to those of the elements of a law.

    They follow any motion, so they are what AFT and time integration know of a law. Each belongs to
    an ``element``, acts on a ``point``, both counted from 0, and slips at the friction coefficient
    times the normal load [N], which is constant where ``normal_stiffness`` is None; all have the
    shape (sliders,). Those that are ``lateral`` slide along the second tangent, and have the
    normal spring in common with another slider of their element; None where all slide along it.
    """

    element: NDArray[np.int64]
    point: NDArray[np.int64]
    tangential_stiffness: Array
    normal_stiffness: Array | None
    normal_load: Array
    friction_coefficient: Array
    lateral: NDArray[np.bool_] | None = None


def joined(parts: Sequence[Sliders], first: Sequence[int]) -> Sliders:
    """Sliders of several sets of elements, by the number of the first element of each."""
    absent = {"normal_stiffness": 0.0, "lateral": False}
    values = {name: [getattr(part, name) for part in parts] for name in vars(parts[0])}
    values["element"] = [start + each for start, each in zip(first, values["element"], strict=True)]
    for name, none in absent.items():
        if all(each is None for each in values[name]):
            del values[name]
            continue
        values[name] = [
            np.full(part.point.shape, none) if each is None else each
            for part, each in zip(parts, values[name], strict=True)
        ]
    whole = {name: np.concatenate(each) for name, each in values.items()}
    return Sliders(**{**dict.fromkeys(absent), **whole})


def slider_forces(sliders: Sliders, motion: Array, tables: SampleTables, tangent: Array) -> Array:
    """Harmonic forces of sliders on their points, and their tangents.

    Each direction of motion is on its own.

    Parameters
    ----------
    sliders
        The springs with sliders of a law.
    motion
        As for ``FrictionLaw.force``.
    tables
        Components of motion and force at the samples.
    tangent
        To which the tangents are added, or empty.
    """
    if sliders.lateral is None:
        return _forces(sliders, slice(None), motion, tables, tangent)
    count = tables.weight.size
    blocks = np.arange(motion.shape[1]).reshape(-1, count)
    normal = blocks[2:].ravel()
    force = np.zeros_like(motion)
    for own, mine in zip(blocks[:2], (~sliders.lateral, sliders.lateral), strict=True):
        at = np.concatenate([own, normal])
        of_direction = np.zeros((len(tangent), at.size, at.size))
        found = _forces(sliders, mine, motion[:, at], tables, of_direction)
        # both directions have the normal load in common, and it acts once
        acting = slice(None) if own[0] == 0 else slice(count)
        force[:, at[acting]] += found[:, acting]
        tangent[:, at[acting, None], at] += of_direction[:, acting]
    return force


def _forces(
    sliders: Sliders,
    mine: Array | slice,
    motion: Array,
    tables: SampleTables,
    tangent: Array,
) -> Array:
    """Forces of some sliders along one direction, and across the contact."""
    on, k_u = sliders.point[mine], sliders.tangential_stiffness[mine]
    k_v = sliders.normal_stiffness
    k_v = np.zeros_like(k_u) if k_v is None else k_v[mine]
    of_element = k_u, k_v, sliders.normal_load[mine], sliders.friction_coefficient[mine]
    order = np.argsort(on, kind="stable")
    first = np.searchsorted(on[order], np.arange(len(motion) + 1))
    motion, force = np.ascontiguousarray(motion), np.zeros(motion.shape)
    add_forces(order, first, of_element, motion, tables, force, tangent)
    return force * np.tile(tables.weight, motion.shape[1] // tables.weight.size)
