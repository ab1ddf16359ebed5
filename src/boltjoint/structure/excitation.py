"""Modes at the excitation and the sensors of a case, from the mode shapes of its structure.

Mesh, modes and preload know neither: a moved shaker or sensor needs only the mode shapes again.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.makers.half_lap.constraints import mesh_of
from boltjoint.structure.makers.half_lap.mesh import FIRST_BOLT

if TYPE_CHECKING:
    from boltjoint.config.excitation import BaseExcitation, PointForces, SurfaceLoad
    from boltjoint.config.points import Point, Sensor

Array = NDArray[np.float64]

_MM = 1e-3

_AXES = ("x", "y", "z")

#: outer surfaces of the bars: axis along which they lie at the end, and which end
_SURFACES = {"top": (2, 1), "bottom": (2, -1), "free-end": (0, 1), "left": (1, 1), "right": (1, -1)}

#: corners of the faces of a hexahedron in the order of VTK, in turn around each face
_FACES = np.array(
    [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)


def place_excitation(
    assembly: xr.Dataset,
    modes: xr.Dataset,
    excitation: "PointForces | SurfaceLoad | BaseExcitation | None" = None,
    sensors: "Sequence[Sensor]" = (),
) -> xr.Dataset:
    """Modes with the excitation and the sensors of a case.

    Parameters
    ----------
    assembly, modes
        As from ``build_assembly`` and ``find_modes``.
    excitation
        Of the case; by default at the middle of the free end's top edge, along z.
    sensors
        Of the case, the first one being the output point; by default at the same place.

    Returns
    -------
    Dataset
        The modes with ``excitation_mode`` (mode), ``excitation_mode_cos`` (mode) where points are
        not in phase, ``response_mode`` (mode) and ``sensor_mode`` (sensor, mode). Under base
        excitation ``excitation_mode`` is ``-Phi^T M r`` of a unit acceleration r of the clamp
        [kg^1/2]. Its attribute ``level_units`` is the unit of the excitation level.

    Raises
    ------
    ValueError
        If the excitation or a sensor has no part in the modes, as in the clamp, or across the width
        of a symmetric assembly.
    """
    shape = checks.variable("modes", modes, "mode_shape", ("node", "axis", "mode"))
    sin, cos, unit = modes["excitation_mode"].to_numpy(), None, "N"
    if excitation is not None and excitation.kind == "base":
        rows = checks.variable("modes", modes, "base_excitation_mode", ("axis", "mode"))
        sin, unit = rows[_AXES.index(excitation.direction)], "m/s2"
        _check_moves("the acceleration of the clamp", sin, np.linalg.norm(rows))
    elif excitation is not None:
        if excitation.kind == "distributed":
            axis = _AXES.index(excitation.direction)
            force = _load_on_surface(assembly, excitation.surface) @ shape[:, axis] + 0j
        else:
            force = sum(
                point.relative_amplitude
                * np.exp(1j * np.deg2rad(point.phase_deg))
                * _mode_at(assembly, shape, point)
                for point in excitation.points
            )
        _check_moves("the excitation", force, abs(shape).max())
        sin, cos = force.real.copy(), force.imag.copy()
    found = {"excitation_mode": sin}
    # a phase of 180 degrees leaves rounding only
    if cos is not None and np.linalg.norm(cos) > 1e-12 * np.linalg.norm(sin):
        found["excitation_mode_cos"] = cos
    per_level = "kg^-1/2" if unit == "N" else "kg^1/2"
    variables = {
        name: quantity("mode", mode, per_level, "mode at the excitation")
        for name, mode in found.items()
    }
    variables["excitation_mode"].attrs["level_units"] = unit
    names, at_sensors = ["output"], modes["response_mode"].to_numpy()[None]
    if sensors:
        names = [sensor.name for sensor in sensors]
        at_sensors = np.array([_mode_at(assembly, shape, sensor) for sensor in sensors])
        for name, mode in zip(names, at_sensors, strict=True):
            _check_moves(f"sensor {name}", mode, abs(shape).max())
    per_mass = "kg^-1/2", "mode at the sensor"
    variables["response_mode"] = quantity("mode", at_sensors[0], *per_mass)
    variables["sensor_mode"] = quantity(("sensor", "mode"), at_sensors, *per_mass)
    return modes.assign(variables).assign_coords(sensor=names)


def _mode_at(assembly: xr.Dataset, shape: Array, point: "Point") -> Array:
    """Mode shapes at the node of the bars that is nearest to a point, in its direction."""
    nodes = np.unique(assembly["connectivity"].to_numpy()[_of_bars(assembly)])
    coordinate = assembly["coordinate"].to_numpy()[nodes]
    wanted = _MM * np.array([point.x_mm, point.y_mm, point.z_mm])
    nearest = nodes[np.argmin(np.linalg.norm(coordinate - wanted, axis=1))]
    return shape[nearest, _AXES.index(point.direction)]


def _load_on_surface(assembly: xr.Dataset, surface: str) -> Array:
    """Consistent nodal forces of an even load of one newton on an outer surface of the bars."""
    coordinate, connectivity = mesh_of(assembly)
    faces = connectivity[:, _FACES].reshape(-1, 4)
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = faces[np.sort(first[(count == 1) & np.repeat(_of_bars(assembly), 6)[first]])]
    axis, end = _SURFACES[surface]
    of_bars = coordinate[np.unique(connectivity[_of_bars(assembly)])]
    level = (end * of_bars[:, axis]).max()
    on = end * coordinate[outer][:, :, axis] > level - 1e-9 * np.ptp(of_bars[:, 0])
    outer = outer[on.all(axis=1)]
    force = np.zeros(len(coordinate))
    for point in np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / np.sqrt(3):
        s, t = point
        N = np.array([(1 - s) * (1 - t), (1 + s) * (1 - t), (1 + s) * (1 + t), (1 - s) * (1 + t)])
        by_s = np.array([t - 1, 1 - t, 1 + t, -1 - t]) / 4
        by_t = np.array([s - 1, -1 - s, 1 + s, 1 - s]) / 4
        along = (np.einsum("c,fca->fa", by, coordinate[outer]) for by in (by_s, by_t))
        area = np.linalg.norm(np.cross(*along), axis=1)
        np.add.at(force, outer, area[:, None] * N / 4)
    return force / force.sum()


def _of_bars(assembly: xr.Dataset) -> NDArray[np.bool_]:
    return assembly["part"].to_numpy() < FIRST_BOLT


def _check_moves(what: str, mode: NDArray, largest: float) -> None:
    if np.all(abs(mode) <= checks.ROUNDING_OF_MODES * largest):
        raise ValueError(
            f"{what} has no part in the modes: it is in the clamp, or where the modes do not move, "
            "as across the width of a symmetric assembly"
        )
