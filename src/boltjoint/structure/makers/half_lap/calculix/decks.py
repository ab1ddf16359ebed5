"""CalculiX input decks of an assembly: modes without contact and bolt preload.

CalculiX gets mesh, materials and clamp of an assembly, and is left to do the rest in its own way:
it has its own brick with incompatible modes (C3D8I), finds the contact by searching which node of
one surface is on which face of the other (penalty, node to surface), and cuts the shanks itself to
tighten them.

References
----------
G. Dhondt: CalculiX CrunchiX user's manual, version 2.20.
"""

import os
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.structure.hexahedron import HEXAHEDRON_FACES
from boltjoint.structure.makers.half_lap.constraints import mesh_of
from boltjoint.structure.makers.half_lap.materials import element_materials

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


def write_preload_deck(assembly: xr.Dataset, preload: float, path: str | Path) -> None:
    """Write the deck for the preload of all bolts, with frictional contact between the bars.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    preload
        Tension of each bolt [N].
    path
        The file to write, ending in ``.inp``; its folder is made.

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
    preload = checks.number("preload", preload, above=0)
    side_a, side_b = assembly["pair_node"].to_numpy().T
    penalty = assembly["contact_penalty"].item()
    friction = assembly["friction_coefficient"].item()
    # the nodes of the surface that is named first meet faces of the second
    contact = [
        *_set("SIDE_A", side_a),
        *_set("SIDE_B", side_b),
        *_surface("BAR_A", faces_among_nodes(assembly, side_a)),
        *_surface("BAR_B", faces_among_nodes(assembly, side_b)),
        "*SURFACE INTERACTION, NAME=CONTACT",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        _fields(penalty, _TENSION),
        *(["*FRICTION", _fields(friction, penalty)] if friction > 0 else []),
        "*CONTACT PAIR, INTERACTION=CONTACT, TYPE=NODE TO SURFACE, SMALL SLIDING",
        "BAR_A, BAR_B",
    ]
    # printed at the end only, whatever the number of increments
    step = [
        "*STEP",
        "*STATIC",
        "1., 1.",
        "*CLOAD",
        *(f"{node}, 1, {preload:.12e}" for node in _tightening_nodes(assembly)),
        *(
            line
            for name in ("SIDE_A", "SIDE_B", "TIGHTENING")
            for line in (f"*NODE PRINT, NSET={name}, FREQUENCY=1000", "U")
        ),
        "*CONTACT PRINT, FREQUENCY=1000",
        "CSTR",
        "*END STEP",
    ]
    _write(path, [*_structure(assembly), *_sections(assembly), *contact, *step])


def run(deck: str | Path, log: str | Path) -> None:
    """Run CalculiX on a deck; its printed output is beside the deck, ending in ``.dat``.

    Parameters
    ----------
    deck
        A file ending in ``.inp``.
    log
        File for the progress messages of CalculiX.

    Raises
    ------
    RuntimeError
        If CalculiX is not installed, or stops before the end.
    """
    deck, log = Path(deck), Path(log)
    log.parent.mkdir(parents=True, exist_ok=True)
    # one thread: sums in another order would change the last digits from machine to machine
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    command = ["ccx", "-i", deck.stem]
    try:
        with log.open("w") as messages:
            done = subprocess.run(
                command, cwd=deck.parent, env=environment, stdout=messages, stderr=subprocess.STDOUT
            )
    except FileNotFoundError:
        raise RuntimeError("there is no program ccx: install CalculiX") from None
    if done.returncode:
        raise RuntimeError(f"CalculiX could not solve {deck}, see {log}")


def faces_among_nodes(assembly: xr.Dataset, node: NDArray[np.integer]) -> NDArray[np.int64]:
    """Faces of hexahedra with all corners among the nodes, shape (faces, 2): element, face."""
    among = np.zeros(assembly.sizes["node"], dtype=bool)
    among[node] = True
    corners = assembly["connectivity"].to_numpy()[:, HEXAHEDRON_FACES]
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
            f"{label}, {_fields(*point)}"
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
        yield from (f"*MATERIAL, NAME=MATERIAL_{m}", "*ELASTIC", _fields(modulus, ratio))
        yield from ("*DENSITY", _fields(density))
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
        position = _fields(*assembly["bolt_position"].to_numpy()[b])
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


def _fields(*number: float) -> str:
    # CalculiX reads twenty characters of a number and ignores the rest silently
    return ", ".join(f"{value:.12e}" for value in number)


def _write(path: str | Path, lines: Iterable[str]) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")
