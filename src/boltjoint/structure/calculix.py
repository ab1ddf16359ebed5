"""Does another finite-element program find the same? Decks for CalculiX, and a comparison.

CalculiX gets mesh, material and clamp of an assembly, and is left to do the rest in its own way: it
has its own brick with incompatible modes (C3D8I), finds the contact by searching which node of one
surface is on which face of the other (penalty, node to surface), and cuts the shanks itself to
tighten them. What its keywords mean is in Dhondt, CalculiX CrunchiX user's manual, version 2.20.
"""

import logging
import os
import re
import subprocess
from collections.abc import Iterable, Iterator
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.dataset import quantity
from boltjoint.structure.constraints import assemble_assembly
from boltjoint.structure.mesh import HEXAHEDRON_FACES

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: what the comparison has to keep: relative differences, and the least likeness
FREQUENCY_BOUND, LOAD_BOUND = 3e-3, 1e-3
SHAPE_BOUND, CORRELATION_BOUND = 0.99, 0.999

#: CalculiX needs some tension [Pa] between open surfaces, which smooths its law where they meet
_TENSION = 1e3

#: where Fortran leaves out the E, before an exponent of three digits
_LEFT_OUT = re.compile(r"(?<=\d)(?=[+-]\d{3})")


def write_modes_deck(assembly: xr.Dataset, number: int, path: str | Path) -> None:
    """Write the search for the first modes without contact.

    Parameters
    ----------
    assembly
        As from ``build_assembly``.
    number
        Modes to find, of whatever family.
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
    """Write the tightening of all bolts, with frictional contact between the bars.

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
        If the preload is not positive.
    """
    preload = checks.number("preload", preload, above=0)
    side_a, side_b = assembly["pair_node"].to_numpy().T
    penalty = assembly["contact_penalty"].item()
    rubbing = assembly["friction_coefficient"].item()
    # the nodes of the surface that is named first meet faces of the second
    contact = [
        *_set("SIDE_A", side_a),
        *_set("SIDE_B", side_b),
        *_surface("BAR_A", _faces_on(assembly, side_a)),
        *_surface("BAR_B", _faces_on(assembly, side_b)),
        "*SURFACE INTERACTION, NAME=CONTACT",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        _fields(penalty, _TENSION),
        *(["*FRICTION", _fields(rubbing, penalty)] if rubbing > 0 else []),
        "*CONTACT PAIR, INTERACTION=CONTACT, TYPE=NODE TO SURFACE, SMALL SLIDING",
        "BAR_A, BAR_B",
    ]
    # only what is reached at the end is printed, however many increments lead there
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
    """Have CalculiX solve a deck; what it prints is beside it, ending in ``.dat``.

    Parameters
    ----------
    deck
        A file ending in ``.inp``.
    log
        File for what CalculiX tells about its progress.

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
        with log.open("w") as told:
            done = subprocess.run(
                command, cwd=deck.parent, env=environment, stdout=told, stderr=subprocess.STDOUT
            )
    except FileNotFoundError:
        raise RuntimeError("there is no program ccx: install CalculiX") from None
    if done.returncode:
        raise RuntimeError(f"CalculiX could not solve {deck}, see {log}")


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
    paragraphs = _paragraphs(path)
    (table,) = _after("CYCLES/TIME", paragraphs, path)
    shapes = [_of_nodes(assembly, printed) for printed in _after("set ALL", paragraphs, path)]
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
    """What CalculiX printed of the tightened assembly.

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
    paragraphs = _paragraphs(path)
    (on_a,) = _after("set SIDE_A", paragraphs, path)
    (on_b,) = _after("set SIDE_B", paragraphs, path)
    (bolts,) = _after("set TIGHTENING", paragraphs, path)
    (stress,) = _after("contact stress", paragraphs, path)

    side_a, side_b = assembly["pair_node"].to_numpy().T
    opening = _of_nodes(assembly, on_b)[side_b, 2] - _of_nodes(assembly, on_a)[side_a, 2]
    force = _of_nodes(assembly, stress)[side_a] * _slave_area(assembly)[:, None]
    # tangents of a face that looks down: the first along x, the second along -y
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


def compare(
    assembly: xr.Dataset,
    modes: xr.Dataset,
    preload: xr.Dataset,
    other_modes: xr.Dataset,
    other_preload: xr.Dataset,
) -> pd.DataFrame:
    """Natural frequencies and contact of an assembly from both programs, and how they differ.

    A mode is compared with the one of CalculiX that is most like it (modal assurance criterion,
    weighted by mass), since modes of other families lie between.

    Parameters
    ----------
    assembly, modes, preload
        As from ``build_assembly``, ``find_modes`` and ``apply_preload``.
    other_modes, other_preload
        As from ``read_modes`` and ``read_preload``.

    Returns
    -------
    DataFrame
        A row for each quantity: both values, their difference, the likeness of the fields behind
        them and what it is measured by; the bound and whether it holds, where there is one.
    """
    rows = [
        *_compare_modes(assembly, modes, other_modes),
        *_compare_contact(preload, other_preload),
    ]
    table = pd.DataFrame(rows)
    broken = table.loc[table["holds"].eq(False), "quantity"]
    if len(broken):
        logger.warning("CalculiX differs by more than the bound in: %s", ", ".join(broken))
    return table


def _compare_modes(
    assembly: xr.Dataset, modes: xr.Dataset, other: xr.Dataset
) -> Iterator[dict[str, object]]:
    _, M = assemble_assembly(assembly)
    ours, theirs = (
        each["mode_shape"].to_numpy().reshape(M.shape[0], -1) for each in (modes, other)
    )
    own, others = (np.einsum("im,im->m", each, M @ each) for each in (ours, theirs))
    assurance = (ours.T @ M @ theirs) ** 2 / np.outer(own, others)
    for mode, like in enumerate(np.argmax(assurance, axis=1)):
        yield _row(
            f"natural frequency of bending mode {mode + 1}",
            "Hz",
            modes["natural_frequency"][mode],
            other["natural_frequency"][like],
            likeness=assurance[mode, like],
            measure="MAC of the shapes",
            most_difference=FREQUENCY_BOUND,
            least_likeness=SHAPE_BOUND,
        )


def _compare_contact(preload: xr.Dataset, other: xr.Dataset) -> Iterator[dict[str, object]]:
    load, other_load = (each["normal_load"].to_numpy() for each in (preload, other))
    gap, other_gap = (each["gap"].to_numpy() for each in (preload, other))
    friction, other_friction = (
        each["friction_force"].transpose("pair", "plane").to_numpy() for each in (preload, other)
    )
    yield _row(
        "normal load of all pairs",
        "N",
        load.sum(),
        other_load.sum(),
        most_difference=LOAD_BOUND,
    )
    yield _row(
        "largest normal load of a pair",
        "N",
        load.max(),
        other_load.max(),
        likeness=_correlation(load, other_load),
        measure="correlation of the pairs",
        least_likeness=CORRELATION_BOUND,
    )
    yield _row(
        "pairs in contact",
        "",
        np.count_nonzero(load > 0),
        np.count_nonzero(other_load > 0),
        likeness=np.mean((load > 0) == (other_load > 0)),
        measure="share of pairs in the same state",
    )
    yield _row(
        "largest gap of a pair",
        "µm",
        1e6 * gap.max(),
        1e6 * other_gap.max(),
        likeness=_correlation(gap, other_gap),
        measure="correlation of the pairs",
    )
    if friction.any():
        yield _row(
            "friction force of all pairs, without direction",
            "N",
            np.linalg.norm(friction, axis=1).sum(),
            np.linalg.norm(other_friction, axis=1).sum(),
            likeness=_correlation(friction, other_friction),
            measure="correlation of the pairs",
        )
    yield _row(
        "mean shortening of the shanks",
        "µm",
        1e6 * preload["shank_shortening"].mean(),
        1e6 * other["shank_shortening"].mean(),
    )


def _row(
    name: str,
    unit: str,
    ours: float,
    theirs: float,
    *,
    likeness: float | None = None,
    measure: str = "",
    most_difference: float | None = None,
    least_likeness: float | None = None,
) -> dict[str, object]:
    ours, theirs = float(ours), float(theirs)
    difference = theirs / ours - 1
    bounds, holds = [], True
    if most_difference is not None:
        bounds.append(f"difference within {100 * most_difference:g} %")
        holds &= abs(difference) <= most_difference
    if least_likeness is not None:
        bounds.append(f"likeness above {least_likeness:g}")
        holds &= float(likeness) > least_likeness
    return {
        "quantity": name,
        "unit": unit,
        "boltjoint": ours,
        "calculix": theirs,
        "difference_percent": 100 * difference,
        "likeness": None if likeness is None else float(likeness),
        "measured_by": measure,
        "bound": ", ".join(bounds),
        "holds": bool(holds) if bounds else None,
    }


def _correlation(ours: Array, theirs: Array) -> float:
    return float(np.corrcoef(ours.ravel(), theirs.ravel())[0, 1])


def _structure(assembly: xr.Dataset) -> list[str]:
    """Mesh, material and clamp, the sections closed: the nodes that face there are one node."""
    nut_side, head_side = assembly["section_node"].to_numpy().T
    node = np.arange(assembly.sizes["node"])
    node[head_side] = nut_side
    connectivity = node[assembly["connectivity"].to_numpy()]
    used = np.unique(connectivity)
    coordinate = assembly["coordinate"].to_numpy()[used]
    modulus, ratio, density = (
        assembly[name].item() for name in ("youngs_modulus", "poissons_ratio", "density")
    )
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
        "*MATERIAL, NAME=STEEL",
        "*ELASTIC",
        _fields(modulus, ratio),
        "*DENSITY",
        _fields(density),
        "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL",
        "*BOUNDARY",
        "CLAMPED, 1, 3",
    ]


def _sections(assembly: xr.Dataset) -> Iterator[str]:
    """Where CalculiX cuts the shanks: through the nodes on top of the elements of the nut's side.

    The displacement of a bolt's own node along x is the shortening, the force on it the tension,
    if the normal points away from the elements that the surface belongs to.
    """
    nut_side = assembly["section_node"].sel(section_side="nut").to_numpy()
    bolt = assembly["section_bolt"].to_numpy()
    for b, label in enumerate(_tightening_nodes(assembly)):
        position = _fields(*assembly["bolt_position"].to_numpy()[b])
        yield from ("*NODE, NSET=TIGHTENING", f"{label}, {position}")
        # in the mesh of the assembly the sections are open, so only one side has these nodes
        yield from _surface(f"SECTION_{b + 1}", _faces_on(assembly, nut_side[bolt == b]))
        yield f"*PRE-TENSION SECTION, SURFACE=SECTION_{b + 1}, NODE={label}"
        yield "0., 0., 1."


def _tightening_nodes(assembly: xr.Dataset) -> range:
    """Labels of the nodes that stand for the tightening of a bolt: those after the mesh."""
    first = assembly.sizes["node"] + 1
    return range(first, first + assembly.sizes["bolt"])


def _faces_on(assembly: xr.Dataset, node: NDArray[np.integer]) -> NDArray[np.int64]:
    """Faces of hexahedra with all corners among the nodes, shape (faces, 2): element, face."""
    among = np.zeros(assembly.sizes["node"], dtype=bool)
    among[node] = True
    corners = assembly["connectivity"].to_numpy()[:, HEXAHEDRON_FACES]
    return np.argwhere(among[corners].all(axis=2))


def _slave_area(assembly: xr.Dataset) -> Array:
    """Area that CalculiX gives to the contact nodes of bar A: a quarter of each face, (pairs,)."""
    side_a = assembly["pair_node"].sel(side="A").to_numpy()
    element, face = _faces_on(assembly, side_a).T
    corners = assembly["connectivity"].to_numpy()[element[:, None], HEXAHEDRON_FACES[face]]
    point = assembly["coordinate"].to_numpy()[corners]
    diagonals = point[:, 2] - point[:, 0], point[:, 3] - point[:, 1]
    quarter = np.linalg.norm(np.cross(*diagonals), axis=1) / 2 / 4
    area = np.bincount(corners.ravel(), np.repeat(quarter, 4), minlength=assembly.sizes["node"])
    return area[side_a]


def _set(name: str, node: NDArray[np.integer]) -> list[str]:
    return [f"*NSET, NSET={name}", *(f"{label}," for label in _labels(node))]


def _surface(name: str, face: NDArray[np.integer]) -> list[str]:
    # faces of CalculiX are numbered as those of HEXAHEDRON_FACES
    return [f"*SURFACE, NAME={name}", *(f"{e}, S{f}" for e, f in (face + 1).tolist())]


def _labels(node: NDArray[np.integer]) -> list[int]:
    return (np.asarray(node) + 1).tolist()


def _fields(*number: float) -> str:
    # CalculiX reads twenty characters of a number and ignores the rest without a word
    return ", ".join(f"{value:.12e}" for value in number)


def _write(path: str | Path, lines: Iterable[str]) -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")


def _paragraphs(path: str | Path) -> list[list[str]]:
    """Lines of a printed file between empty ones: a table is the paragraph after its title."""
    with Path(path).open(encoding="ascii") as lines:
        return [
            list(group) for filled, group in groupby(lines, lambda x: not x.isspace()) if filled
        ]


def _after(title: str, paragraphs: list[list[str]], path: str | Path) -> list[Array]:
    """The tables after the paragraphs whose last line holds a title."""
    tables = [
        np.array([_LEFT_OUT.sub("E", line).split() for line in table], dtype=float)
        for head, table in pairwise(paragraphs)
        if title in head[-1]
    ]
    if not tables:
        raise ValueError(f"{path}: CalculiX printed no {title!r}")
    return tables


def _of_nodes(assembly: xr.Dataset, printed: Array) -> Array:
    """Three values of each node from lines of label and values, (nodes, 3); 0 where none are."""
    values = np.zeros((assembly.sizes["node"], 3))
    values[printed[:, 0].astype(int) - 1] = printed[:, 1:]
    return values
