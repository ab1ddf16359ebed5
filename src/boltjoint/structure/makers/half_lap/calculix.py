"""CalculiX on an assembly: input decks of modes and bolt preload, and their printed output.

CalculiX gets mesh, materials and clamp of an assembly, and is left to do the rest in its own way:
it has its own brick with incompatible modes (C3D8I), finds the contact by searching which node of
one surface is on which face of the other (penalty, node to surface), and cuts the shanks itself to
tighten them.

References
----------
G. Dhondt: CalculiX CrunchiX user's manual, version 2.20.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.bolt_tension import tension_of
from boltjoint.structure.calculix_program import fields, paragraphs, required_tables
from boltjoint.structure.elements.kinds import FACES_OF_HEXAHEDRON
from boltjoint.structure.makers.half_lap.parts import element_materials
from boltjoint.structure.makers.half_lap.structure import mesh_of

#: CalculiX needs some tension [Pa] between open surfaces, which smooths its law where they meet
_TENSION = 1e3


def write_modes_deck(assembly: xr.Dataset, number: int, path: str | Path) -> None:
    """Write the deck for the first modes without contact.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    number
        Number of modes, of all families.
    path
        The file to write, ending in ``.inp``; its folder is made.

    Raises
    ------
    ValueError
        If the number is not a positive whole one.
    """
    number = checks.whole("number", number, at_least=1)
    step = ["*STEP", "*FREQUENCY", f"{number}", "*NODE PRINT, NSET=ALL", "U", "*END STEP"]
    _write(path, [*_structure(assembly), *step])


def write_preload_deck(
    assembly: xr.Dataset,
    preload: float | Sequence[float],
    path: str | Path,
    *,
    modes: int = 0,
) -> None:
    """Write the deck for the preload of all bolts, with frictional contact between the bars.

    With a number of modes there is no friction, and these are found under the preload.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    preload
        Tension of the bolts [N]: a number for all, or one for each.
    path
        The file to write, ending in ``.inp``; its folder is made.
    modes
        Number of modes under the preload.

    Raises
    ------
    ValueError
        If the preload is not positive, or the assembly has an initial gap.
    """
    checks.instance("assembly", assembly, xr.Dataset)
    if "initial_gap" in assembly:
        raise ValueError(
            "assembly has an initial gap, which decks do not hold: must have flat surfaces"
        )
    tension = tension_of(preload, assembly.sizes["bolt"])
    side_a, side_b = assembly["pair_node"].to_numpy().T
    penalty = assembly["contact_penalty"].item()
    friction = 0.0 if modes else assembly["friction_coefficient"].item()
    # the nodes of the surface that is named first meet faces of the second
    contact = [
        *_set("SIDE_A", side_a),
        *_set("SIDE_B", side_b),
        *_surface("BAR_A", faces_among_nodes(assembly, side_a)),
        *_surface("BAR_B", faces_among_nodes(assembly, side_b)),
        "*SURFACE INTERACTION, NAME=CONTACT",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        fields(penalty, _TENSION),
        *(["*FRICTION", fields(friction, penalty)] if friction > 0 else []),
        "*CONTACT PAIR, INTERACTION=CONTACT, TYPE=NODE TO SURFACE, SMALL SLIDING",
        "BAR_A, BAR_B",
    ]
    # printed at the end only, whatever the number of increments
    step = [
        "*STEP",
        "*STATIC",
        "1., 1.",
        "*CLOAD",
        *(
            f"{node}, 1, {force:.12e}"
            for node, force in zip(_tightening_nodes(assembly), tension.tolist(), strict=True)
        ),
        *(
            line
            for name in ("SIDE_A", "SIDE_B", "TIGHTENING")
            for line in (f"*NODE PRINT, NSET={name}, FREQUENCY=1000", "U")
        ),
        "*CONTACT PRINT, FREQUENCY=1000",
        "CSTR",
        "*END STEP",
    ]
    if modes:
        held = (f"{node}, 1, 1" for node in _tightening_nodes(assembly))
        step += ["*STEP, PERTURBATION", "*BOUNDARY", *held, "*FREQUENCY", f"{modes}", "*END STEP"]
    _write(path, [*_structure(assembly), *_sections(assembly), *contact, *step])


def faces_among_nodes(assembly: xr.Dataset, node: NDArray[np.integer]) -> NDArray[np.int64]:
    """Faces of hexahedra with all corners among the nodes, shape (faces, 2): element, face."""
    among = np.zeros(assembly.sizes["node"], dtype=bool)
    among[node] = True
    corners = assembly["connectivity"].to_numpy()[:, FACES_OF_HEXAHEDRON]
    return np.argwhere(among[corners].all(axis=2))


def _structure(assembly: xr.Dataset) -> list[str]:
    """Mesh, materials and clamp; the pretension sections are closed by joining their nodes."""
    nut_side, head_side = assembly["section_node"].to_numpy().T
    node = np.arange(assembly.sizes["node"])
    node[head_side] = nut_side
    coordinate, connectivity = mesh_of(assembly)
    connectivity = node[connectivity]
    used = np.unique(connectivity)
    coordinate = coordinate[used]
    return [
        "*NODE, NSET=ALL",
        *(
            f"{label}, {fields(*point)}"
            for label, point in zip(_labels(used), coordinate, strict=True)
        ),
        # its corners are in the order of VTK
        "*ELEMENT, TYPE=C3D8I, ELSET=ALL",
        *(
            ", ".join(map(str, [element, *_labels(corners)]))
            for element, corners in enumerate(connectivity, start=1)
        ),
        *_set("CLAMPED", assembly["clamped_node"].to_numpy()),
        *_materials(assembly),
        "*BOUNDARY",
        "CLAMPED, 1, 3",
    ]


def _materials(assembly: xr.Dataset) -> Iterator[str]:
    """Each material that differs from the others, and the elements that are of it."""
    of_elements = np.column_stack(element_materials(assembly))
    materials, number = np.unique(of_elements, axis=0, return_inverse=True)
    for m, (modulus, ratio, density) in enumerate(materials, start=1):
        yield from (f"*MATERIAL, NAME=MATERIAL_{m}", "*ELASTIC", fields(modulus, ratio))
        yield from ("*DENSITY", fields(density))
        element = np.flatnonzero(number.ravel() == m - 1)
        yield from _set(f"OF_MATERIAL_{m}", element, "EL")
        yield f"*SOLID SECTION, ELSET=OF_MATERIAL_{m}, MATERIAL=MATERIAL_{m}"


def _sections(assembly: xr.Dataset) -> Iterator[str]:
    """Pretension sections: through the nodes on top of the elements of the nut's side.

    The displacement of the node of a bolt along x is the shortening, the force on it the tension,
    if the normal points away from the elements that the surface belongs to.
    """
    nut_side = assembly["section_node"].sel(section_side="nut").to_numpy()
    bolt = assembly["section_bolt"].to_numpy()
    for b, label in enumerate(_tightening_nodes(assembly)):
        position = fields(*assembly["bolt_position"].to_numpy()[b])
        yield from ("*NODE, NSET=TIGHTENING", f"{label}, {position}")
        # in the mesh of the assembly the sections are open, so only one side has these nodes
        yield from _surface(f"SECTION_{b + 1}", faces_among_nodes(assembly, nut_side[bolt == b]))
        yield f"*PRE-TENSION SECTION, SURFACE=SECTION_{b + 1}, NODE={label}"
        yield "0., 0., 1."


def _tightening_nodes(assembly: xr.Dataset) -> range:
    """Labels of the tightening nodes of the bolts: those after the mesh."""
    first = assembly.sizes["node"] + 1
    return range(first, first + assembly.sizes["bolt"])


def _set(name: str, member: NDArray[np.integer], kind: str = "N") -> list[str]:
    """A set of nodes, or with the kind EL of elements."""
    return [f"*{kind}SET, {kind}SET={name}", *(f"{label}," for label in _labels(member))]


def _surface(name: str, face: NDArray[np.integer]) -> list[str]:
    # faces of CalculiX are numbered as those of HEXAHEDRON_FACES
    return [f"*SURFACE, NAME={name}", *(f"{e}, S{f}" for e, f in (face + 1).tolist())]


def _labels(node: NDArray[np.integer]) -> list[int]:
    return (np.asarray(node) + 1).tolist()


def _write(path: str | Path, lines: Iterable[str]) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")


Array = NDArray[np.float64]


def read_modes(assembly: xr.Dataset, path: str | Path) -> xr.Dataset:
    """Modes that CalculiX printed.

    Parameters
    ----------
    assembly
        The assembly that the deck was written from.
    path
        The file ending in ``.dat``.

    Returns
    -------
    Dataset
        ``natural_frequency`` (mode) [Hz] and ``mode_shape`` (node, axis, mode) [kg^-1/2], as in
        ``modes.nc``.

    Raises
    ------
    ValueError
        If the file does not hold them.
    """
    printed = paragraphs(path)
    (table,) = required_tables("CYCLES/TIME", printed, path)
    shapes = [_of_nodes(assembly, each) for each in required_tables("set ALL", printed, path)]
    # the nodes across a closed section were one node
    nut_side, head_side = assembly["section_node"].to_numpy().T
    shape = np.stack(shapes, axis=-1)
    shape[head_side] = shape[nut_side]
    return xr.Dataset(
        {
            "natural_frequency": quantity("mode", table[:, 3], "Hz", "natural frequency"),
            "mode_shape": quantity(
                ("node", "axis", "mode"), shape, "kg^-1/2", "mass-normalised mode"
            ),
        },
        coords={"axis": assembly["axis"].variable},
    )


def read_preload(assembly: xr.Dataset, path: str | Path) -> xr.Dataset:
    """Contact under preload that CalculiX printed.

    Parameters
    ----------
    assembly
        The assembly that the deck was written from.
    path
        The file ending in ``.dat``.

    Returns
    -------
    Dataset
        ``normal_load`` (pair) [N], ``friction_force`` (pair, plane) [N], ``gap`` (pair) [m] and
        ``shank_shortening`` (bolt) [m], as in ``preload.nc``, but for the small tension of open
        pairs, whose normal load is negative.

    Raises
    ------
    ValueError
        If the file does not hold them.
    """
    printed = paragraphs(path)
    (on_a,) = required_tables("set SIDE_A", printed, path)
    (on_b,) = required_tables("set SIDE_B", printed, path)
    (bolts,) = required_tables("set TIGHTENING", printed, path)
    (stress,) = required_tables("contact stress", printed, path)

    side_a, side_b = assembly["pair_node"].to_numpy().T
    opening = _of_nodes(assembly, on_b)[side_b, 2] - _of_nodes(assembly, on_a)[side_a, 2]
    force = _of_nodes(assembly, stress)[side_a] * _slave_area(assembly)[:, None]
    # tangents of a face with a downward normal: the first along x, the second along -y
    friction = force[:, 1:] * [1, -1]
    return xr.Dataset(
        {
            "normal_load": quantity("pair", force[:, 0], "N", "normal load of the contact pair"),
            "friction_force": quantity(
                ("pair", "plane"), friction, "N", "friction force on side B"
            ),
            "gap": quantity("pair", np.maximum(opening, 0.0), "m", "opening"),
            "shank_shortening": quantity(
                "bolt", bolts[:, 1], "m", "shortening of the shank by tightening"
            ),
        },
        coords={"plane": ["x", "y"]},
    )


def _slave_area(assembly: xr.Dataset) -> Array:
    """Area that CalculiX gives to the contact nodes of bar A: a quarter of each face, (pairs,)."""
    side_a = assembly["pair_node"].sel(side="A").to_numpy()
    element, face = faces_among_nodes(assembly, side_a).T
    corners = assembly["connectivity"].to_numpy()[element[:, None], FACES_OF_HEXAHEDRON[face]]
    point = assembly["coordinate"].to_numpy()[corners]
    diagonals = point[:, 2] - point[:, 0], point[:, 3] - point[:, 1]
    quarter = np.linalg.norm(np.cross(*diagonals), axis=1) / 2 / 4
    area = np.bincount(corners.ravel(), np.repeat(quarter, 4), minlength=assembly.sizes["node"])
    return area[side_a]


def _of_nodes(assembly: xr.Dataset, printed: Array) -> Array:
    """Three values of each node from lines of label and values, (nodes, 3); 0 where none are."""
    values = np.zeros((assembly.sizes["node"], 3))
    values[printed[:, 0].astype(int) - 1] = printed[:, 1:]
    return values
