"""The joint of a case in space: mesh, modes, deflections, contact, and loops of its pairs."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.config.case import Case
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.friction import contact_states
from boltjoint.joint.io import joint_from_dataset
from boltjoint.joint.model import Joint
from boltjoint.names import REFERENCE
from boltjoint.report.figures.outlines import ContactSurface, positions_of
from boltjoint.report.pages.interactive.hysteresis import hysteresis_loops
from boltjoint.report.pages.interactive.natural_modes import natural_modes
from boltjoint.report.pages.interactive.packing import pack
from boltjoint.report.pages.interactive.surface import (
    Surface,
    packed_contact,
    packed_displacement,
)
from boltjoint.study.response_list import headline_basis
from boltjoint.study.results import Results
from boltjoint.study.tables.html import number

_MM, _UM, _MPA = 1e3, 1e6, 1e-6
#: modes that are drawn of each state of the contact
_MODES = 4
#: of a period of a hysteresis loop
_SAMPLES = 48
#: of a byte
_LARGEST = 127


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
        sine, cosine = motion.in_components(("sin", "cos"))
        output = motion.amplitude(joint.response_mode)
        # when the output point is farthest
        farthest = ((sine + 1j * cosine) * np.exp(-1j * np.angle(output))).real
        peak = {
            "level": level,
            "frequency": frequency,
            "amplitude": abs(output) * _MM,
            "state": pack(states[place], "<i1"),
            **_loops(joint, motion, frequency),
        }
        if shape is not None:
            peak |= packed_displacement(shape @ farthest)
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
    byte = np.rint(force / np.where(scale, scale, 1.0)[:, None] * _LARGEST)
    low, high = displacement.min(axis=1), displacement.max(axis=1)
    within = (displacement - low[:, None]) / np.where(high > low, high - low, 1.0)[:, None]
    return {
        "slide": pack((high - low) / 2 * _UM),
        "middle": pack((high + low) / 2 * _UM),
        "displacement": pack(np.rint((2 * within - 1) * _LARGEST), "<i1"),
        "force": pack(byte, "<i1"),
        "largestForce": pack(scale),
        "samples": _SAMPLES,
    }
