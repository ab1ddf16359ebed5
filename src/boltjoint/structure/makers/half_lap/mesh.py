"""Finite-element model of a half-lap assembly: hexahedra, contact pairs with gaps, named nodes.

The form error of both surfaces together is a field that is known up to a constant, since the bars
approach each other until they touch: the smallest gap is 0.

Two bars and their bolts are plan views extruded along z and joined node by node. Bar A is the
lower, clamped one and has the lower half of the lap; bar B is the upper one with the free end. They
meet at z = 0 in coincident node pairs. Heads and nuts are tied to the bars, or to washers that are
tied to the bars: they share nodes. In the middle of a shank, the pretension section, the nodes are
double.
"""

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.extrusion.blocks import Blocks
from boltjoint.structure.extrusion.bolt_mesh import BoltLevels, add_bolt, radii_of, washer_levels
from boltjoint.structure.extrusion.bolt_plan import bolt_plan
from boltjoint.structure.extrusion.cell import CellDivisions
from boltjoint.structure.extrusion.plan import Labels, rectangle_plan, tributary_area
from boltjoint.structure.makers.half_lap.parts import (
    BAR_A,
    BAR_B,
    FIRST_BOLT,
    first_washer,
    material_variables,
    part_variable,
)
from boltjoint.structure.makers.half_lap.plan import LapPlan, lap_plan

if TYPE_CHECKING:
    from boltjoint.config.gap_map import GapMap
    from boltjoint.config.lap_joint import LapJoint


Array = NDArray[np.float64]

_MM, _UM = 1e-3, 1e-6


def initial_gap(
    assembly: "LapJoint", position: Array, gap_map: "GapMap | None" = None
) -> Array | None:
    """Initial gap of contact pairs [m], shape (pairs,); None where surfaces are flat.

    With L and W the length and the width of the lap, and x, y from its centre::

        g = -h (x^2 + y^2) / ((L/2)^2 + (W/2)^2) + w cos(2 pi x / lambda) - smallest

    h is the flatness, the distance of two parallel planes that the paraboloid lies between over
    the lap, w the amplitude of the waviness and lambda its wavelength; or g is that of the map.

    Parameters
    ----------
    assembly
        Dimensions, and ``contact.gap_um``.
    position
        Positions of the pairs, shape (pairs, 3) [m].
    gap_map
        The map where ``contact.gap_um`` is the name of a file.

    Raises
    ------
    ValueError
        If the map is missing, does not cover the lap or is not symmetric about its middle.
    """
    check_described(assembly)
    position = checks.array("position", position, ("pairs", 3))
    form, lap, width = assembly.contact.gap_um, assembly.bar.lap_mm, assembly.bar.width_mm
    if form is None:
        return None
    # To a picometre, and on one side: the same bytes on both, which preload and joint rely on.
    x = np.round(position[:, 0] / _MM - assembly.bar.free_length_mm[0] - lap / 2, 9)
    y = np.round(abs(position[:, 1]) / _MM, 9)
    if isinstance(form, str):
        if gap_map is None:
            raise ValueError(f"gap_map is None: contact.gap_um needs the map in {form}")
        for sentence in gap_map.conflicts(lap, width):
            raise ValueError(f"gap_map {sentence}")
        field = (gap_map.at(x, y) + gap_map.at(x, -y)) / 2
    else:
        field = -form.flatness_um * (x**2 + y**2) / ((lap / 2) ** 2 + (width / 2) ** 2)
        if form.wavelength_mm is not None:
            field += form.waviness_um * np.cos(2 * np.pi * x / form.wavelength_mm)
    return _UM * (field - field.min())


def check_described(assembly: "LapJoint") -> None:
    """Refuse what is no description of an assembly."""
    # imported here: jobs that only read an assembly do without
    from boltjoint.config.lap_joint import LapJoint

    checks.instance("assembly", assembly, LapJoint)


logger = logging.getLogger(__name__)


def build_assembly(assembly: "LapJoint", gap_map: "GapMap | None" = None) -> xr.Dataset:
    """Finite-element model of a half-lap assembly, as ``assembly.nc`` holds it.

    It has everything the later stages need: mesh, contact pairs, pretension sections, clamped
    nodes, excitation and output nodes, material and static contact. Pairs are ordered by x, then y.

    Parameters
    ----------
    assembly
        Dimensions, material and mesh divisions.
    gap_map
        The map where ``contact.gap_um`` of the assembly is the name of a file.

    Returns
    -------
    Dataset
        ``coordinate`` (node, axis) [m]; ``connectivity`` (element, corner) in the order of VTK;
        ``part`` (element); ``pair_node`` (pair, side); ``position`` (pair, axis) [m]; ``area``
        (pair) [m2]; ``section_node`` (section_pair, section_side); ``section_bolt``
        (section_pair); ``bolt_position`` (bolt, axis) [m]; ``clamped_node`` (clamped);
        ``excitation_node`` and ``response_node`` with their direction; material of the bars, and of
        each part (part_number) where bolts or washers have another; contact; ``initial_gap`` (pair)
        [m] where the surfaces have a form error.

    Raises
    ------
    ValueError
        If bolts, cells and lap do not fit together, or if an odd number of elements across the
        width leaves no nodes on the plane of symmetry; or as for ``initial_gap``.
    """
    check_described(assembly)
    bar, mesh = assembly.bar, assembly.mesh
    if mesh.ring_cells_across_width % 2:
        raise ValueError(
            f"ring_cells_across_width is {mesh.ring_cells_across_width}: it must be even, so that "
            "nodes lie on the plane of symmetry"
        )
    axes = _MM * np.array(assembly.bolt_positions_mm)
    lap = _plan_of(assembly)
    blocks = Blocks()
    bars = _add_bars(blocks, assembly, lap)
    bolt, levels = (
        bolt_plan(radii_of(assembly.bolts), divisions_of(assembly)),
        bolt_levels(assembly),
    )
    sections = []
    for b, axis in enumerate(_MM * bar.free_length_mm[0] + axes):
        on_bars = bars.lap_a[0, lap.seat[b]], bars.lap_b[-1, lap.seat[b]]
        parts = FIRST_BOLT + b, first_washer(len(axes)) + b
        sections.append(add_bolt(blocks, bolt.moved(axis), levels, on_bars, parts))
    coordinate, hexahedron, part, label = blocks.joined()

    pair = label[np.stack([bars.lap_a[-1], bars.lap_b[0]], axis=-1)]
    order = _along_and_across(coordinate[pair[:, 0]])
    pair = pair[order]
    section = label[np.concatenate(sections)]
    clamped = bars.clamped if assembly.has_support else bars.clamped[:0]
    gap = initial_gap(assembly, coordinate[pair[:, 0]], gap_map)

    dataset = xr.Dataset(
        {
            "coordinate": quantity(("node", "axis"), coordinate, "m", "position of the node"),
            "connectivity": quantity(
                ("element", "corner"), hexahedron, "1", "nodes of the hexahedron, order of VTK"
            ),
            "part": part_variable(assembly, part),
            **_pairs(pair, coordinate[pair[:, 0]], tributary_area(lap.plan)[order]),
            "clamped_node": quantity(
                "clamped", np.sort(label[clamped]), "1", "nodes that are held"
            ),
            **_bolts(section, _MM * bar.free_length_mm[0] + axes),
            **_points(assembly, coordinate, hexahedron[part < FIRST_BOLT]),
            **_properties(assembly),
            **({} if gap is None else {"initial_gap": quantity("pair", gap, "m", "initial gap")}),
        },
        coords={"axis": ["x", "y", "z"], "side": ["A", "B"], "section_side": ["nut", "head"]},
    )
    logger.info(
        "mesh: %d nodes, %d hexahedra, %d contact pairs",
        len(coordinate),
        len(hexahedron),
        len(pair),
    )
    return dataset


def _plan_of(assembly: "LapJoint") -> LapPlan:
    """The plan view of the lap of an assembly."""
    bar, mesh = assembly.bar, assembly.mesh
    return lap_plan(
        _MM * np.array(assembly.bolt_positions_mm),
        length=_MM * bar.lap_mm,
        width=_MM * bar.width_mm,
        cell_length=_MM * mesh.bolt_cell_length_mm,
        radii=radii_of(assembly.bolts),
        divisions=divisions_of(assembly),
        columns_between=mesh.columns_between_bolt_cells,
        columns_at_ends=mesh.columns_at_each_lap_end,
    )


def _along_and_across(position: Array) -> NDArray[np.intp]:
    """Order of points along the bars, then across them."""
    # to a picometre: nodes on one line across the bar have the same x but for rounding
    along, across, _ = np.round(position, 12).T
    return np.lexsort([across, along])


def _pairs(node: NDArray[np.int64], position: Array, area: Array) -> dict[str, xr.Variable]:
    """Contact pairs: nodes of both sides, places [m] and areas [m2]."""
    return {
        "pair_node": quantity(("pair", "side"), node, "1", "nodes that touch"),
        "position": quantity(("pair", "axis"), position, "m", "position of the contact pair"),
        "area": quantity("pair", area, "m2", "tributary area of the contact pair"),
    }


def _bolts(section: NDArray[np.int64], axis: Array) -> dict[str, xr.Variable]:
    """Pretension sections, as many pairs of nodes for each bolt, and the bolts' axes at x [m]."""
    bolt_position = np.zeros((len(axis), 3))
    bolt_position[:, 0] = axis
    return {
        "section_node": quantity(
            ("section_pair", "section_side"), section, "1", "nodes of the pretension sections"
        ),
        "section_bolt": quantity(
            "section_pair",
            np.repeat(np.arange(len(axis)), len(section) // len(axis)),
            "1",
            "bolt of the section pair, counted from 0",
        ),
        "bolt_position": quantity(
            ("bolt", "axis"), bolt_position, "m", "where the bolt's axis crosses the contact"
        ),
    }


@dataclass(frozen=True)
class _Bars:
    """Labels of the nodes of both halves of the lap, shape (levels, points), and of the clamp."""

    lap_a: Labels
    lap_b: Labels
    clamped: Labels


def _add_bars(blocks: Blocks, assembly: "LapJoint", lap: LapPlan) -> _Bars:
    bar, mesh = assembly.bar, assembly.mesh
    lower, upper = levels_of(assembly)
    full_height = np.concatenate([lower, upper[1:]])
    y = _MM * np.linspace(-bar.width_mm / 2, bar.width_mm / 2, mesh.ring_cells_across_width + 1)
    lap_start = _MM * bar.free_length_mm[0]
    lap_end = lap_start + _MM * bar.lap_mm

    in_lap = lap.plan.moved(lap_start)
    lap_a = blocks.add(BAR_A, in_lap, lower)
    lap_b = blocks.add(BAR_B, in_lap, upper)
    # the end of a bar in the lap faces the shoulder of the other bar and has separate nodes
    elements = [int(number) for number in assembly.elements_outside_lap]
    x_a = np.linspace(0.0, lap_start, elements[0] + 1)
    x_b = np.linspace(lap_end, lap_end + _MM * bar.free_length_mm[1], elements[1] + 1)
    free_a = blocks.add(BAR_A, rectangle_plan(x_a, y), full_height)
    free_b = blocks.add(BAR_B, rectangle_plan(x_b, y), full_height)
    blocks.join(lap_a[:, lap.first], free_a[: len(lower), -len(y) :])
    blocks.join(lap_b[:, lap.last], free_b[-len(upper) :, : len(y)])
    return _Bars(lap_a, lap_b, clamped=free_a[:, : len(y)].ravel())


def _points(assembly: "LapJoint", coordinate: Array, hexahedron: Labels) -> dict[str, xr.Variable]:
    """Node of the bars at the default of the excitation and the output point."""
    candidates, point = np.unique(hexahedron), assembly.default_point
    wanted = _MM * np.array([point.x_mm, point.y_mm, point.z_mm])
    nearest = candidates[np.argmin(np.linalg.norm(coordinate[candidates] - wanted, axis=1))]
    variables = {}
    for name in ("excitation", "response"):
        node = quantity((), nearest, "1", f"node of the {name}, where a case gives none")
        node.attrs["direction"] = point.direction
        variables[f"{name}_node"] = node
    return variables


def _properties(assembly: "LapJoint") -> dict[str, xr.Variable]:
    contact = assembly.contact
    return {
        "hole_clearance": quantity(
            (),
            _MM * assembly.bolts.hole_clearance_mm,
            "m",
            "diameter of the bolt holes less that of the shanks",
        ),
        # quotients of decimal numbers: 9 mm are exactly 0.009 m
        "hole_diameter": quantity(
            (), assembly.bolts.hole_diameter_mm / 1e3, "m", "diameter of the bolt holes"
        ),
        "head_diameter": quantity(
            (), assembly.bolts.head_diameter_mm / 1e3, "m", "diameter of the bolt heads"
        ),
        **material_variables(assembly),
        "contact_penalty": quantity(
            (), float(contact.penalty_N_per_m3), "N/m3", "static contact stiffness per area"
        ),
        "friction_coefficient": quantity(
            (), float(contact.friction_coefficient), "1", "Coulomb friction between the bars"
        ),
    }


def divisions_of(assembly: "LapJoint") -> CellDivisions:
    """Divisions of the cell of a bolt."""
    mesh = assembly.mesh
    return CellDivisions(
        across=mesh.ring_cells_across_width,
        along=mesh.ring_cells_along_bar,
        rings_in_shank=mesh.rings_in_shank,
        rings_under_head=mesh.rings_under_head,
        rings_head_to_edge=mesh.rings_head_to_cell_edge,
        rings_head_to_washer=assembly.rings_head_to_washer_edge,
    )


def levels_of(assembly: "LapJoint") -> tuple[Array, Array]:
    """Levels along z of the lower and of the upper half of the height [m]."""
    half, layers = _MM * assembly.bar.height_mm / 2, assembly.mesh.layers_per_half_height
    return np.linspace(-half, 0.0, layers + 1), np.linspace(0.0, half, layers + 1)


def bolt_levels(assembly: "LapJoint") -> BoltLevels:
    """Levels of nodes along the axis of a bolt [m]."""
    bolts, layers = assembly.bolts, int(assembly.layers_in_washer)
    return BoltLevels.of_stack(
        levels_of(assembly),
        (washer_levels(bolts, "nut", layers), washer_levels(bolts, "head", layers)),
        (_MM * bolts.nut_height_mm, _MM * bolts.head_height_mm),
        assembly.mesh.layers_in_head,
    )
