"""Figures that a study has of half laps: mesh, modes, initial gap, and shape under preload."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from boltjoint.config.lap_joint import LapJoint
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from boltjoint.study.stage_inputs import Results


def _half_laps(contents: Contents) -> dict[str, LapJoint]:
    """The half laps of a study by their names."""
    assemblies = contents.study.assemblies.items()
    return {name: each for name, each in assemblies if isinstance(each, LapJoint)}


def _all(contents: Contents) -> list[dict[str, Any]]:
    return [{"assembly": name} for name in _half_laps(contents)]


def _with_initial_gap(contents: Contents) -> list[dict[str, Any]]:
    laps = _half_laps(contents).items()
    return [{"assembly": name} for name, each in laps if each.has_initial_gap]


def _preloads(contents: Contents) -> list[dict[str, Any]]:
    laps = _half_laps(contents)
    return [
        {"assembly": name, "preload_N": preload}
        for name, preload in contents.preloads()
        if name in laps
    ]


def _modes_of(all_families: bool) -> Callable[[Contents], list[dict[str, Any]]]:
    """Half laps in each basis whose vectors are modes: bending ones, or those of all families."""

    def found(contents: Contents) -> list[dict[str, Any]]:
        return [
            {"basis": basis, "assembly": name}
            for basis in contents.bases()
            if not basis.is_contact_adapted and basis.has_all_families == all_families
            for name in _half_laps(contents)
        ]

    return found


_ASSEMBLY = data_of("assembly", by=["assembly"])
_PLACED = {"job": "structure_{assembly}", "page": "structure"}
_MODES = {"reads": (_ASSEMBLY, data_of("modes", by=["assembly", "basis"])), "section": "modes"}


@figure(
    "mesh",
    of=_all,
    reads=(_ASSEMBLY,),
    section="dimensions",
    title="Mesh of {assembly}",
    caption="From above at an angle, the contact surface from above, and a cut along the middle of "
    "the width. The bolts are tied to the bars under head and nut, or to washers that are.",
    **_PLACED,
)
def mesh(artefact: Artefact, results: "Results") -> "Figure":
    """The mesh of a half lap."""
    from boltjoint.structure.makers.half_lap.figures import plot_mesh

    return plot_mesh(results.dataset("assembly", **artefact.fields))


def _draw_modes(artefact: Artefact, results: "Results") -> "Figure":
    from boltjoint.structure.makers.half_lap.figures import plot_modes

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_modes(assembly, results.dataset("modes", **artefact.fields))


@figure(
    "initial_gap",
    of=_with_initial_gap,
    reads=(_ASSEMBLY,),
    section="contact",
    title="Initial gap of {assembly}",
    caption="Form error of both surfaces together: their distance as they touch, before the bolts "
    "are tightened.",
    **_PLACED,
)
def initial_gap(artefact: Artefact, results: "Results") -> "Figure":
    """The gap of a half lap before its bolts are tightened."""
    from boltjoint.structure.makers.half_lap.figures import plot_initial_gap

    return plot_initial_gap(results.dataset("assembly", **artefact.fields))


@figure(
    "modes",
    of=_modes_of(all_families=False),
    title="Bending modes of {assembly}",
    caption="Cut along the middle of the width; displacements are enlarged.",
    **_PLACED,
    **_MODES,
)
def modes(artefact: Artefact, results: "Results") -> "Figure":
    """The modes of a half lap without contact."""
    return _draw_modes(artefact, results)


@figure(
    "all_modes",
    of=_modes_of(all_families=True),
    title="Modes of {assembly} of all families",
    caption="Cut along the middle of the width, or, where that moves across itself, along the "
    "contact and seen from above; displacements are enlarged.",
    **_PLACED,
    **_MODES,
)
def all_modes(artefact: Artefact, results: "Results") -> "Figure":
    """The modes of a half lap without contact, of all families."""
    return _draw_modes(artefact, results)


@figure(
    "deformation",
    of=_preloads,
    reads=(_ASSEMBLY, data_of("preload", by=["assembly", "preload_N"])),
    section="contact",
    order=2,
    title="Shape of {assembly} with {preload_N} N per bolt",
    caption="Cut along the middle of the width; displacements are enlarged. The overlap at the cut "
    "through every shank is the shortening by which the bolt is tightened.",
    **_PLACED,
)
def deformation(artefact: Artefact, results: "Results") -> "Figure":
    """The shape of a half lap under preload."""
    from boltjoint.structure.makers.half_lap.figures import plot_deformation

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_deformation(assembly, results.dataset("preload", **artefact.fields))
