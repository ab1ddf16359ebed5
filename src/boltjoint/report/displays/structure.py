"""Figures and tables of structures: bodies, modes, contact and deformation under preload."""

from typing import TYPE_CHECKING, Any

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.report.comparison import Comparison
    from boltjoint.study.stage_inputs import Results


def _assemblies_of_solids(contents: Contents) -> list[dict[str, Any]]:
    return [
        {"assembly": name}
        for name, assembly in contents.study.assemblies.items()
        if assembly.HAS_SOLIDS
    ]


def _preloads_of_solids(contents: Contents) -> list[dict[str, Any]]:
    return [
        {"assembly": name, "preload_N": preload}
        for name, preload in contents.preloads()
        if contents.study.assembly(name).HAS_SOLIDS
    ]


def _modes_of_solids(contents: Contents) -> list[dict[str, Any]]:
    """Assemblies of solids in each basis whose vectors are modes."""
    return [
        of_assembly | {"basis": basis}
        for basis in contents.bases()
        if not basis.is_contact_adapted
        for of_assembly in _assemblies_of_solids(contents)
    ]


_OF_SOLIDS = {"job": "structure_{assembly}", "page": "structure"}
_ASSEMBLY = data_of("assembly", by=["assembly"])


@figure(
    "solids",
    of=_assemblies_of_solids,
    reads=(_ASSEMBLY,),
    section="dimensions",
    title="Bodies of {assembly}",
    caption="Seen from above at an angle; below, the contact points through the bodies.",
    **_OF_SOLIDS,
)
def solids(artefact: Artefact, results: "Results") -> "Figure":
    """The bodies of an assembly and its contact points."""
    from boltjoint.report.figures.solids import plot_solids

    return plot_solids(results.dataset("assembly", **artefact.fields))


@figure(
    "solid_modes",
    of=_modes_of_solids,
    reads=(_ASSEMBLY, data_of("modes", by=["assembly", "basis"])),
    section="modes",
    title="Modes of {assembly}, basis {basis}",
    caption="Displacements are enlarged, and by colour, from dark for none to light.",
    **_OF_SOLIDS,
)
def solid_modes(artefact: Artefact, results: "Results") -> "Figure":
    """The modes of an assembly."""
    from boltjoint.report.figures.solids import plot_solid_modes

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_solid_modes(assembly, results.dataset("modes", **artefact.fields))


@figure(
    "solid_deformation",
    of=_preloads_of_solids,
    reads=(_ASSEMBLY, data_of("preload", by=["assembly", "preload_N"])),
    section="contact",
    title="Shape of {assembly} with {preload_N} N per bolt",
    caption="Displacements are enlarged, and by colour, from dark for none to light.",
    **_OF_SOLIDS,
)
def solid_deformation(artefact: Artefact, results: "Results") -> "Figure":
    """The shape of an assembly under preload."""
    from boltjoint.report.figures.solids import plot_solid_deformation

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_solid_deformation(assembly, results.dataset("preload", **artefact.fields))


def _preloads(contents: Contents) -> list[dict[str, Any]]:
    return [{"assembly": name, "preload_N": preload} for name, preload in contents.preloads()]


def _free_bases(contents: Contents, all_families: bool = False) -> list[dict[str, Any]]:
    """Bases whose vectors are modes of the structure: bending ones, or those of all families."""
    return [
        {"basis": basis}
        for basis in contents.bases()
        if not basis.is_contact_adapted and basis.has_all_families == all_families
    ]


def _bases_of_all_families(contents: Contents) -> list[dict[str, Any]]:
    return _free_bases(contents, all_families=True)


@figure(
    "contact",
    of=_preloads,
    reads=(_ASSEMBLY, data_of("preload", by=["assembly", "preload_N"])),
    job="structure_{assembly}",
    page="structure",
    section="contact",
    order=1,
    title="{assembly} with {preload_N} N per bolt",
    caption="Every pair is drawn as the area that belongs to it. The load of a pair depends on "
    "that area as much as on the pressure: pairs on the edge of a hole have about half the area of "
    "their neighbours, and therefore half the slip force.",
)
def contact(artefact: Artefact, results: "Results") -> "Figure":
    """The contact of an assembly under preload."""
    from boltjoint.report.figures.contact import plot_contact

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_contact(assembly, results.dataset("preload", **artefact.fields))


@table(
    "all_frequencies",
    of=_bases_of_all_families,
    reads=(data_of("modes", by=["basis"]),),
    job="structure",
    page="structure",
    section="modes",
    title="natural frequencies of the basis {basis}",
    options=lambda contents, _: {"assemblies": list(contents.study.assemblies)},
)
def all_frequencies(
    artefact: Artefact, results: "Results", assemblies: list[str]
) -> "pd.DataFrame":
    """Natural frequencies of all assemblies without contact, with their families."""
    from boltjoint.study.tables.structure import tabulate_families

    return tabulate_families(
        {name: results.dataset("modes", assembly=name, basis=artefact.basis) for name in assemblies}
    )


@table(
    "natural_frequencies",
    of=_free_bases,
    reads=(data_of("modes", by=["basis"]),),
    job="structure",
    page="structure",
    section="modes",
    title="natural frequencies of the basis {basis}",
    options=lambda contents, _: {"assemblies": list(contents.study.assemblies)},
    is_compared=True,
)
def natural_frequencies(
    artefact: Artefact, results: "Results", assemblies: list[str], comparison: "Comparison"
) -> "pd.DataFrame":
    """Natural frequencies of all assemblies without contact."""
    from boltjoint.study.tables.structure import tabulate_frequencies

    modes = {
        name: results.dataset("modes", assembly=name, basis=artefact.basis) for name in assemblies
    }
    return comparison.beside(artefact, tabulate_frequencies(modes))


@table(
    "contact",
    of=lambda _: [{}],
    reads=(data_of("preload"),),
    job="structure",
    page="structure",
    section="contact",
    title="contact of every assembly and preload",
    options=lambda contents, _: {"preloads": contents.preloads()},
    is_compared=True,
)
def contact_of_preloads(
    artefact: Artefact,
    results: "Results",
    preloads: list[tuple[str, str]],
    comparison: "Comparison",
) -> "pd.DataFrame":
    """Loads and gaps of the contact of all assemblies."""
    from boltjoint.study.tables.structure import tabulate_contact

    datasets = {
        (name, preload): results.dataset("preload", assembly=name, preload_N=preload)
        for name, preload in preloads
    }
    return comparison.beside(artefact, tabulate_contact(datasets))
