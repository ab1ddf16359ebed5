"""Figures of solid bodies that are no half laps: bodies, modes, and shape under preload."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from boltjoint.study.results import Results

Fields = Callable[[Contents], list[dict[str, Any]]]


def _assemblies(contents: Contents) -> list[dict[str, Any]]:
    return [
        {"assembly": name}
        for name, assembly in contents.study.assemblies.items()
        if assembly.HAS_SOLIDS
    ]


def _preloads(contents: Contents) -> list[dict[str, Any]]:
    return [
        {"assembly": name, "preload_N": preload}
        for name, preload in contents.preloads()
        if contents.study.assembly(name).HAS_SOLIDS
    ]


def _modes(contents: Contents) -> list[dict[str, Any]]:
    """Assemblies in each basis whose vectors are modes."""
    return [
        of_assembly | {"basis": basis}
        for basis in contents.bases()
        if not basis.is_contact_adapted
        for of_assembly in _assemblies(contents)
    ]


_OF_PAGE = {"job": "structure_{assembly}", "page": "structure"}
_ASSEMBLY = data_of("assembly", by=["assembly"])


@figure(
    "solids",
    of=_assemblies,
    reads=(_ASSEMBLY,),
    section="dimensions",
    title="Bodies of {assembly}",
    caption="Seen from above at an angle; below, the contact points through the bodies.",
    **_OF_PAGE,
)
def solids(artefact: Artefact, results: "Results") -> "Figure":
    """The bodies of an assembly and its contact points."""
    from boltjoint.report.figures.solids import plot_solids

    return plot_solids(results.dataset("assembly", **artefact.fields))


@figure(
    "solid_modes",
    of=_modes,
    reads=(_ASSEMBLY, data_of("modes", by=["assembly", "basis"])),
    section="modes",
    title="Modes of {assembly}, basis {basis}",
    caption="Displacements are enlarged, and by colour, from dark for none to light.",
    **_OF_PAGE,
)
def solid_modes(artefact: Artefact, results: "Results") -> "Figure":
    """The modes of an assembly."""
    from boltjoint.report.figures.solids import plot_solid_modes

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_solid_modes(assembly, results.dataset("modes", **artefact.fields))


@figure(
    "solid_deformation",
    of=_preloads,
    reads=(_ASSEMBLY, data_of("preload", by=["assembly", "preload_N"])),
    section="contact",
    title="Shape of {assembly} with {preload_N} N per bolt",
    caption="Displacements are enlarged, and by colour, from dark for none to light.",
    **_OF_PAGE,
)
def solid_deformation(artefact: Artefact, results: "Results") -> "Figure":
    """The shape of an assembly under preload."""
    from boltjoint.report.figures.solids import plot_solid_deformation

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_solid_deformation(assembly, results.dataset("preload", **artefact.fields))
