"""Modes at the excitation and the sensors of a case, from the modes of its structure.

Mesh, modes and preload know neither: a moved shaker or sensor needs only the modes again. Kinds of
excitation are described in ``config.excitation``. The levels, forces or accelerations, are the same
at all frequencies; ``HarmonicBalance.modal_force`` multiplies them in.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.config.error_messages import choice
from boltjoint.dataset import quantity
from boltjoint.structure.makers import registry

if TYPE_CHECKING:
    from boltjoint.config.excitation import Excitation, ForceAtInput, ForcePoint, Point, Sensor

Array = NDArray[np.float64]

_MM = 1e-3

_AXES = ("x", "y", "z")


def _at_sensors(
    modes: xr.Dataset, places: "_Places", sensors: "Sequence[Sensor | str]", largest: float
) -> dict[str, NDArray]:
    """Modes at the sensors by name; at the outputs of the structure where none are given."""
    at_sensors = {}
    observed = sensors or modes["output"].to_numpy().tolist()
    if not observed:
        raise ValueError("the structure has no outputs: give sensors")
    for sensor in observed:
        name = sensor if isinstance(sensor, str) else sensor.name
        mode = places.named("output", name) if isinstance(sensor, str) else places.at(sensor)
        if sensors:
            _check_moves(f"sensor {name}", mode, largest)
        at_sensors[name] = mode
    return at_sensors


def place_excitation(
    assembly: xr.Dataset,
    modes: xr.Dataset,
    excitation: "Excitation | None" = None,
    sensors: "Sequence[Sensor | str]" = (),
) -> xr.Dataset:
    """Modes with the excitation and the sensors of a case.

    Parameters
    ----------
    assembly, modes
        As from ``build_assembly``, or ``assembly.nc``, and from ``find_modes``.
    excitation
        Excitation of the case; by default at the first input of the structure, of a half lap the
        middle of the free end's top edge, along z.
    sensors
        Sensors of the case, points or names of outputs, the first one being the output point; by
        default all outputs of the structure, of a half lap at the same place.

    Returns
    -------
    Dataset
        The modes with ``excitation_mode`` (mode), ``excitation_mode_cos`` (mode) where points are
        not in phase, ``response_mode`` (mode) and ``sensor_mode`` (sensor, mode). Under base
        excitation ``excitation_mode`` is ``-Phi^T M r`` of a unit acceleration r of the supports
        [kg^1/2]. Its attribute ``level_units`` is the unit of the excitation level.

    Raises
    ------
    ValueError
        If there is no such input or output, a point is given without a mesh, or the excitation or
        a sensor has no part in the modes, as where it is held, or across the width of a symmetric
        assembly.
    """
    per_mode = checks.variable("modes", modes, "relative_mode", ("pair", "axis", "mode"))
    places = _Places(assembly, modes)
    largest = abs(places.shape if "mode_shape" in modes else per_mode).max()
    sin, cos, unit = modes["excitation_mode"].to_numpy(), None, "N"
    if excitation is not None and excitation.kind == "base":
        if "base_excitation_mode" not in modes:
            raise ValueError("nothing holds the structure: there is no support to accelerate")
        rows = checks.variable("modes", modes, "base_excitation_mode", ("axis", "mode"))
        sin, unit = rows[_AXES.index(excitation.direction)], "m/s2"
        _check_moves("the acceleration of the supports", sin, float(np.linalg.norm(rows)))
    elif excitation is not None:
        if excitation.kind == "distributed":
            axis = _AXES.index(excitation.direction)
            load = registry.load_on_surface(assembly, excitation.surface)
            force = load @ places.shape[:, axis] + 0j
        elif excitation.kind == "inputs":
            force = _sum_of(excitation.inputs, lambda point: places.named("input", point.name))
        else:
            force = _sum_of(excitation.points, places.at)
        _check_moves("the excitation", force, largest)
        sin, cos = force.real.copy(), force.imag.copy()
    of_excitation = {"excitation_mode": sin}
    # a phase of 180 degrees leaves rounding only
    if cos is not None and np.linalg.norm(cos) > 1e-12 * np.linalg.norm(sin):
        of_excitation["excitation_mode_cos"] = cos
    per_level = "kg^-1/2" if unit == "N" else "kg^1/2"
    variables = {
        name: quantity("mode", mode, per_level, "mode at the excitation")
        for name, mode in of_excitation.items()
    }
    variables["excitation_mode"].attrs["level_units"] = unit
    at_sensors = _at_sensors(modes, places, sensors, largest)
    per_mass = "kg^-1/2", "mode at the sensor"
    sensor_mode = np.array(list(at_sensors.values()))
    variables["response_mode"] = quantity("mode", sensor_mode[0], *per_mass)
    variables["sensor_mode"] = quantity(("sensor", "mode"), sensor_mode, *per_mass)
    placed = modes.drop_dims(["input", "output"]).assign(variables)
    return placed.assign_coords(sensor=list(at_sensors))


class _Places:
    """Modes of an assembly at its nodes, inputs and outputs."""

    def __init__(self, assembly: xr.Dataset, modes: xr.Dataset) -> None:
        self._assembly, self._modes = assembly, modes

    @property
    def shape(self) -> Array:
        """Mode shapes of the nodes, shape (nodes, 3, modes)."""
        if "mode_shape" not in self._modes:
            raise ValueError("the structure has no nodes: name its inputs and outputs")
        return checks.variable("modes", self._modes, "mode_shape", ("node", "axis", "mode"))

    def at(self, point: "Point") -> Array:
        """Modes at the node that is nearest to a point, in its direction, shape (modes,)."""
        shape = self.shape
        nodes = registry.loaded_nodes(self._assembly)
        coordinate = self._assembly["coordinate"].to_numpy()[nodes]
        wanted = _MM * np.array([point.x_mm, point.y_mm, point.z_mm])
        nearest = nodes[np.argmin(np.linalg.norm(coordinate - wanted, axis=1))]
        return shape[nearest, _AXES.index(point.direction)]

    def named(self, kind: str, name: str) -> Array:
        """Modes at an input or output of this name, shape (modes,)."""
        names = self._modes[kind].to_numpy().tolist()
        if name not in names:
            raise ValueError(f"{name} is no {kind} of the structure{choice(name, names)}")
        rows = checks.variable("modes", self._modes, f"{kind}_mode", (kind, "mode"))
        return rows[names.index(name)]


def _sum_of(
    points: "Sequence[ForcePoint | ForceAtInput]", mode_at: Callable[..., Array]
) -> NDArray[np.complex128]:
    """Modes at forces of several amplitudes and phases together, shape (modes,)."""
    return sum(
        point.relative_amplitude * np.exp(1j * np.deg2rad(point.phase_deg)) * mode_at(point)
        for point in points
    )


def _check_moves(what: str, mode: NDArray, largest: float) -> None:
    if np.all(abs(mode) <= checks.ROUNDING_OF_MODES * largest):
        raise ValueError(
            f"{what} has no part in the modes: it is where the structure is held, or where modes "
            "do not move, as across the width of a symmetric assembly"
        )
