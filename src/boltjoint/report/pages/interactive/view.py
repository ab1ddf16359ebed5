"""The joint of a case in space: mesh, modes, deflections, contact, and loops of its pairs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.config.case import Case
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.friction import contact_states
from boltjoint.harmonics import Components, harmonics_of_level, in_words
from boltjoint.joint.io import joint_from_dataset
from boltjoint.joint.model import Joint
from boltjoint.names import REFERENCE
from boltjoint.number_format import number
from boltjoint.report.figures.outlines import ContactSurface, outer_faces, positions_of
from boltjoint.report.pages.document import pack
from boltjoint.study.response_list import headline_basis
from boltjoint.study.stage_inputs import Results

Array = NDArray[np.float64]


def hysteresis_loops(
    joint: Joint, motion: PeriodicMotion, samples: int, frequency: float = 0.0
) -> tuple[Array, Array] | None:
    """Displacement and friction force of all elements over a steady period.

    The springs with sliders of the law follow the motion from rest through one period, which
    brings them to their steady state, and through that which is returned. Dashpots of the law act
    beside them.

    Parameters
    ----------
    joint
        The joint, as its file holds it.
    motion
        Coordinates of its modes.
    samples
        Samples of a period, from its start.
    frequency
        Frequency of the motion [Hz], for forces that depend on it.

    Returns
    -------
    tuple
        Relative displacement along the first tangent [m] and the force of its friction [N], each
        (elements, samples); None where friction acts in two directions, whose loops are no lines
        in a plane, or is not that of sliders.
    """
    law = joint.contact.element_law
    sliders = law.sliders()
    if sliders is None or "lateral" in law.directions_in_time:
        return None
    q = motion.in_time(samples).T
    u = joint.tangential_mode @ q
    spring = sliders.tangential_stiffness[:, None] * u[sliders.point]
    load = np.broadcast_to(sliders.normal_load[:, None], spring.shape)
    if sliders.normal_stiffness is not None and joint.normal_mode is not None:
        load = load + sliders.normal_stiffness[:, None] * (joint.normal_mode @ q)[sliders.point]
    bound = sliders.friction_coefficient[:, None] * np.maximum(load, 0)
    force = np.empty_like(spring)
    anchor = np.zeros(len(spring))
    for _ in range(2):
        for at in range(samples):
            force[:, at] = np.clip(spring[:, at] - anchor, -bound[:, at], bound[:, at])
            anchor = spring[:, at] - force[:, at]
    of_element = np.zeros((law.point_of_element.size, samples))
    np.add.at(of_element, sliders.element, force)
    if law.dashpots is not None:
        turn = 2 * np.pi * frequency * Components(motion.components).phase_derivative
        velocity = PeriodicMotion(motion.components, turn @ motion.modal_coordinate)
        of_points = joint.tangential_mode @ velocity.in_time(samples).T
        viscous = law.dashpots.damping[:, None] * of_points[law.dashpots.point]
        np.add.at(of_element, law.dashpots.element, viscous)
    return u[law.point_of_element], of_element


def loop_of_joint(joint: Joint, motion: PeriodicMotion, friction: Array) -> tuple[Array, Array]:
    """Displacement of the output point over a period, and the friction of all elements there.

    The force at the output point does the work that the elements do in a motion of the shape that
    the structure has when this point is farthest.

    Parameters
    ----------
    joint, motion
        As for ``hysteresis_loops``.
    friction
        The forces that it returns [N], (elements, samples).

    Returns
    -------
    tuple
        Displacement [m] and force [N], (samples,).
    """
    shape = _farthest(joint, motion)
    along = (joint.tangential_mode @ shape)[joint.law.point_of_element]
    displacement = joint.response_mode @ motion.in_time(friction.shape[1]).T
    return displacement, along @ friction / (joint.response_mode @ shape)


def _farthest(joint: Joint, motion: PeriodicMotion) -> Array:
    """First harmonic of the modal coordinates when the output point is farthest, (modes,)."""
    sine, cosine = motion.in_components(("sin", "cos"))
    output = motion.amplitude(joint.response_mode)
    return np.real((sine + 1j * cosine) * np.exp(-1j * np.angle(output)))


@dataclass(frozen=True)
class NaturalModes:
    """Natural frequencies [Hz] and modes of a joint in one linear state of its contact.

    ``frequency`` (resonances,), and ``vector`` (modes of the basis, resonances), normalised by
    mass; without those of a rigid body.
    """

    frequency: Array
    vector: Array


def natural_modes(joint: Joint, most: int) -> dict[str, NaturalModes]:
    """The lowest natural modes by the state of the contact.

    ``without contact``; ``slipping``, where only the normal springs of the loaded pairs act; and
    ``sticking``, where the tangential ones act too. Slipping is left out where the law has no
    normal springs: then it is as without contact.

    Parameters
    ----------
    joint
        The structure and its friction elements.
    most
        Number of resonances.
    """
    stiffness = joint.law.stuck_stiffness(joint.points)
    parts = dict(zip(joint.law.directions, zip(joint.rows, stiffness.T, strict=True), strict=True))
    free = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    states = {"without contact": free}
    if "normal" in parts:
        rows, springs = parts["normal"]
        states["slipping"] = free + rows.T @ (springs[:, None] * rows)
    states["sticking"] = free + joint.stuck_stiffness()
    rigid = joint.natural_frequency.size - joint.elastic_modes
    shapes = {}
    for name, matrix in states.items():
        squared, vector = np.linalg.eigh(matrix)
        chosen = slice(rigid, rigid + most)
        frequency = np.sqrt(np.maximum(squared[chosen], 0)) / (2 * np.pi)
        shapes[name] = NaturalModes(frequency, vector[:, chosen])
    return shapes


#: nodes of the surface, whose numbers have sixteen bits
_MOST_NODES = 2**16 - 1
#: of an element whose faces are known
_CORNERS = 8
_MM, _UM, _MPA = 1e3, 1e6, 1e-6
#: largest number of fifteen bits
_LARGEST_OF_TWO_BYTES = 32767


@dataclass(frozen=True)
class Surface:
    """Nodes and faces of the outer surface.

    Parameters
    ----------
    node
        Numbers of the nodes in the mesh, shape (nodes,).
    position
        Their places [m], shape (nodes, 3).
    face
        Corners of the faces by their place among the nodes, shape (faces, 4).
    part
        Values of each face, shape (faces,).
    """

    node: NDArray[np.int64]
    position: Array
    face: NDArray[np.int64]
    part: NDArray[np.int64]

    @classmethod
    def of(cls, assembly: xr.Dataset) -> "Surface | None":
        """The surface of an assembly without its contact; None without a mesh, or a fine one."""
        if "connectivity" not in assembly or assembly.sizes["corner"] != _CORNERS:
            return None
        faces, part = outer_faces(assembly)
        node, face = np.unique(faces, return_inverse=True)
        if node.size > _MOST_NODES:
            return None
        face = face.reshape(-1, 4)
        if "pair_node" in assembly:
            # the contact is drawn by its pairs
            drawn = ~np.isin(faces, assembly["pair_node"]).all(axis=1)
            face, part = face[drawn], part[drawn]
        return cls(node, positions_of(assembly, "coordinate", "node")[node], face, part)

    def packed(self, assembly: xr.Dataset) -> dict[str, Any]:
        """Places [mm], faces, edges and parts, as JSON can hold them."""
        names = _names_of_parts(assembly)
        parts = []
        for part in np.unique(self.part).tolist():
            faces = self.face[self.part == part]
            parts.append(
                {
                    "words": names.get(part, f"part {part}"),
                    "faces": pack(faces, "<u2"),
                    "edges": pack(_edges(faces), "<u2"),
                }
            )
        return {"nodes": pack(self.position * _MM), "parts": parts}


def packed_displacement(displacement: Array) -> dict[str, Any]:
    """A displacement, shape (nodes, 3), in whole numbers of a unit that suits it."""
    largest = float(np.abs(displacement).max()) or 1.0
    numbers = np.rint(displacement / largest * _LARGEST_OF_TWO_BYTES)
    return {"values": pack(numbers, "<i2"), "unit": largest / _LARGEST_OF_TWO_BYTES}


def packed_contact(assembly: xr.Dataset, surface: Surface | None) -> dict[str, Any]:
    """Pairs, and the cells of the contact surface that belong to each, as JSON can hold them.

    The place of a corner of a cell is the mean of four pairs, so that it moves with them. Of
    contact points without a mesh there are no cells.
    """
    contact = ContactSurface.of(assembly)
    content: dict[str, Any] = {"places": pack(contact.position * _MM)}
    if len(contact.facet):
        facet = contact.facet
        pairs = np.arange(len(contact.position))
        # as ``ContactSurface`` numbers them: pairs, middles of edges, centres of facets
        edges = np.stack([facet, np.roll(facet, -1, axis=1)], axis=-1).reshape(-1, 2)
        edge = np.unique(np.sort(edges), axis=0)
        corners = np.concatenate(
            [np.repeat(pairs[:, None], 4, axis=1), np.tile(edge, (1, 2)), facet]
        )
        content |= {
            "corners": pack(corners, "<u2"),
            "cells": pack(contact.share, "<u2"),
            "owners": pack(contact.owner, "<u2"),
        }
    if surface is not None and "pair_node" in assembly:
        of_pair = assembly["pair_node"].transpose("pair", "side").to_numpy()[:, 0]
        place = np.searchsorted(surface.node, of_pair)
        is_there = surface.node[np.minimum(place, surface.node.size - 1)] == of_pair
        if is_there.all():
            content["nodes"] = pack(place, "<u2")
    return content


def _names_of_parts(assembly: xr.Dataset) -> Mapping[int, str]:
    attributes = assembly["part"].attrs
    if "flag_meanings" not in attributes:
        return {}
    words = [name.replace("_", " ") for name in attributes["flag_meanings"].split()]
    return dict(zip(np.atleast_1d(attributes["flag_values"]).tolist(), words, strict=True))


def _edges(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Edges of faces, each once, shape (edges, 2)."""
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.unique(np.sort(edges), axis=0)


#: modes that are drawn of each state of the contact
_MODES = 4
#: of a period of a hysteresis loop
_SAMPLES = 48
#: of a byte
_LARGEST_OF_A_BYTE = 127


def view_of_case(name: str, case: Case, results: Results) -> dict[str, Any] | None:
    """The joint of a case in its most trusted basis, as JSON can hold it.

    None where the contact under preload is not among the results.

    Parameters
    ----------
    name, case
        The case.
    results
        ``assembly.nc``, ``preload.nc``, ``modes.nc``, the node-to-node ``joint.nc`` and its
        ``response.nc`` in linear modes, as far as there are any.
    """
    basis = headline_basis(case)
    of_preload = {"assembly": case.assembly, "preload_N": case.preload}
    of_joint = {"case": name, "basis": basis, "joint": REFERENCE[0]}
    if not (results.has("preload", **of_preload) and results.has("joint", **of_joint)):
        return None
    assembly = results.dataset("assembly", assembly=case.assembly)
    preload = results.dataset("preload", **of_preload)
    stored = results.dataset("joint", **of_joint)
    surface = Surface.of(assembly)
    pair = ContactSurface.of(assembly).pairs_at(stored)
    load = preload["normal_load"].to_numpy()
    view: dict[str, Any] = {
        "case": name,
        "basis": basis,
        "unit": "m/s²" if case.is_base_excited else "N",
        "surface": None if surface is None else surface.packed(assembly),
        "contact": packed_contact(assembly, surface),
        "pressure": pack(load / assembly["area"].to_numpy() * _MPA),
        "load": pack(load),
        "gap": pack(preload["gap"].to_numpy() * _UM),
        "states": list(contact_states.MEANINGS),
        "elements": pack(pair, "<u2"),
        "slipForce": pack(stored["slip_force"].to_numpy()),
        "shapes": [],
        "peaks": [],
    }
    joint = joint_from_dataset(stored)
    shape = None
    fields = {"assembly": case.assembly, "basis": basis}
    if surface is not None and results.has("modes", **fields):
        modes = results.dataset("modes", **fields)["mode_shape"]
        shape = modes.transpose("node", "axis", "mode").to_numpy()[surface.node]
    if surface is not None and "displacement" in preload:
        under = positions_of(preload, "displacement", "node")[surface.node]
        view["shapes"].append({"words": "under preload", **packed_displacement(under)})
    if shape is not None:
        view["shapes"] += _modes(joint, shape)
    resonance = case.resonances(basis)[0]
    solved = of_joint | {"coordinates": REFERENCE[1], "resonance": resonance}
    if results.has("response", **solved):
        view["peaks"] = _peaks(joint, results.dataset("response", **solved), shape)
    return view


def _modes(joint: Joint, shape: NDArray[np.float64]) -> list[dict[str, Any]]:
    """The lowest modes by the state of the contact, as displacements of the surface."""
    return [
        {
            "words": f"mode {place}, {state}: {number(frequency)} Hz",
            **packed_displacement(shape @ vector),
        }
        for state, modes in natural_modes(joint, _MODES).items()
        for place, (frequency, vector) in enumerate(
            zip(modes.frequency, modes.vector.T, strict=True), start=1
        )
    ]


def _peaks(
    joint: Joint, response: xr.Dataset, shape: NDArray[np.float64] | None
) -> list[dict[str, Any]]:
    """Deflection, contact states, motion and loops at the peak of each level."""
    peaks = []
    states = response["contact_state"].transpose("force", "element").to_numpy()
    for place, level in enumerate(response["force_level"].to_numpy().tolist()):
        at_peak = motion_at_peak(response, level)
        if at_peak is None or not np.isfinite(response["peak_amplitude"][place]):
            continue
        frequency, motion = at_peak
        peak = {
            "level": level,
            "frequency": frequency,
            "amplitude": abs(motion.amplitude(joint.response_mode)) * _MM,
            "harmonics": in_words([harmonics_of_level(response, place)]),
            "state": pack(states[place], "<i1"),
            **_loops(joint, motion, frequency),
        }
        if shape is not None:
            peak |= packed_displacement(shape @ _farthest(joint, motion))
        peaks.append(peak)
    return peaks


def _loops(joint: Joint, motion: PeriodicMotion, frequency: float) -> dict[str, Any]:
    """Relative motion of the elements [µm], and their loops where friction acts along a line."""
    loops = hysteresis_loops(joint, motion, _SAMPLES, frequency)
    if loops is None:
        sine, cosine = motion.in_components(("sin", "cos"))
        at = joint.law.point_of_element
        moved = [np.hypot(B @ sine, B @ cosine)[at] for B in joint.contact.rows_in_plane]
        return {"slide": pack(np.hypot(*moved) * _UM)}
    displacement, force = loops
    scale = np.abs(force).max(axis=1)
    byte = np.rint(force / np.where(scale, scale, 1.0)[:, None] * _LARGEST_OF_A_BYTE)
    low, high = displacement.min(axis=1), displacement.max(axis=1)
    of_output, of_joint = loop_of_joint(joint, motion, force)
    within = (displacement - low[:, None]) / np.where(high > low, high - low, 1.0)[:, None]
    return {
        "slide": pack((high - low) / 2 * _UM),
        "middle": pack((high + low) / 2 * _UM),
        "displacement": pack(np.rint((2 * within - 1) * _LARGEST_OF_A_BYTE), "<i1"),
        "force": pack(byte, "<i1"),
        "largestForce": pack(scale),
        "output": pack(of_output * _MM),
        "friction": pack(of_joint),
        "samples": _SAMPLES,
        "work": float(np.sum(force * np.diff(displacement, axis=1, append=displacement[:, :1])))
        * _MM,
    }
