"""Figures and tables of structures: bodies, modes, contact and deformation under preload."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.report.comparison import Comparison
    from boltjoint.study.results import Results


Fields = Callable[[Contents], list[dict[str, Any]]]


def _other_assemblies(contents: Contents) -> list[dict[str, Any]]:
    return [
        {"assembly": name}
        for name, assembly in contents.study.assemblies.items()
        if assembly.HAS_SOLIDS
    ]


def _other_preloads(contents: Contents) -> list[dict[str, Any]]:
    return [
        {"assembly": name, "preload_N": preload}
        for name, preload in contents.preloads()
        if contents.study.assembly(name).HAS_SOLIDS
    ]


def _other_modes(contents: Contents) -> list[dict[str, Any]]:
    """Assemblies in each basis whose vectors are modes."""
    return [
        of_assembly | {"basis": basis}
        for basis in contents.bases()
        if not basis.is_contact_adapted
        for of_assembly in _other_assemblies(contents)
    ]


_OF_SOLIDS = {"job": "structure_{assembly}", "page": "structure"}
_ASSEMBLY = data_of("assembly", by=["assembly"])


@figure(
    "solids",
    of=_other_assemblies,
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
    of=_other_modes,
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
    of=_other_preloads,
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


_UNDER_PRELOAD = "{assembly} with {preload_N} N per bolt"


def _assemblies(contents: Contents) -> list[dict[str, Any]]:
    return [{"assembly": name} for name in contents.study.assemblies]


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


def _assemblies_in(
    bases: Callable[[Contents], list[dict[str, Any]]],
) -> Callable[[Contents], list[dict[str, Any]]]:
    """All assemblies in each of the bases."""

    def found(contents: Contents) -> list[dict[str, Any]]:
        return [
            of_assembly | of_basis
            for of_basis in bases(contents)
            for of_assembly in _assemblies(contents)
        ]

    return found


_MODES = {
    "reads": (data_of("assembly", by=["assembly"]), data_of("modes", by=["assembly", "basis"])),
    "job": "structure_{assembly}",
    "page": "structure",
    "section": "modes",
    "shows_mesh": True,
}


@figure(
    "mesh",
    of=_assemblies,
    reads=(data_of("assembly", by=["assembly"]),),
    job="structure_{assembly}",
    page="structure",
    section="dimensions",
    title="Mesh of {assembly}",
    caption="From above at an angle, the contact surface from above, and a cut along the middle of "
    "the width. The bolts are tied to the bars under head and nut, or to washers that are.",
    shows_mesh=True,
)
def mesh(artefact: Artefact, results: "Results") -> "Figure":
    """The mesh of an assembly."""
    from boltjoint.report.figures.half_lap import plot_mesh

    return plot_mesh(results.dataset("assembly", **artefact.fields))


def _draw_modes(artefact: Artefact, results: "Results") -> "Figure":
    from boltjoint.report.figures.half_lap import plot_modes

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_modes(assembly, results.dataset("modes", **artefact.fields))


@figure(
    "initial_gap",
    of=lambda contents: [
        {"assembly": name}
        for name, assembly in contents.study.assemblies.items()
        if assembly.has_initial_gap
    ],
    reads=(data_of("assembly", by=["assembly"]),),
    job="structure_{assembly}",
    page="structure",
    section="contact",
    title="Initial gap of {assembly}",
    caption="Form error of both surfaces together: their distance as they touch, before the bolts "
    "are tightened.",
    shows_mesh=True,
)
def initial_gap(artefact: Artefact, results: "Results") -> "Figure":
    """The gap of an assembly before its bolts are tightened."""
    from boltjoint.report.figures.half_lap import plot_initial_gap

    return plot_initial_gap(results.dataset("assembly", **artefact.fields))


@figure(
    "modes",
    of=_assemblies_in(_free_bases),
    title="Bending modes of {assembly}",
    caption="Cut along the middle of the width; displacements are enlarged.",
    **_MODES,
)
def modes(artefact: Artefact, results: "Results") -> "Figure":
    """The modes of an assembly without contact."""
    return _draw_modes(artefact, results)


@figure(
    "all_modes",
    of=_assemblies_in(_bases_of_all_families),
    title="Modes of {assembly} of all families",
    caption="Cut along the middle of the width, or, where that moves across itself, along the "
    "contact and seen from above; displacements are enlarged.",
    **_MODES,
)
def all_modes(artefact: Artefact, results: "Results") -> "Figure":
    """The modes of an assembly without contact, of all families."""
    return _draw_modes(artefact, results)


_OF_PRELOAD = {
    "of": _preloads,
    "reads": (
        data_of("assembly", by=["assembly"]),
        data_of("preload", by=["assembly", "preload_N"]),
    ),
    "job": "structure_{assembly}",
    "page": "structure",
    "section": "contact",
}


@figure(
    "contact",
    **_OF_PRELOAD,
    title=_UNDER_PRELOAD,
    caption="Every pair is drawn as the area that belongs to it. The load of a pair depends on "
    "that area as much as on the pressure: pairs on the edge of a hole have about half the area of "
    "their neighbours, and therefore half the slip force.",
)
def contact(artefact: Artefact, results: "Results") -> "Figure":
    """The contact of an assembly under preload."""
    from boltjoint.report.figures.contact import plot_contact

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_contact(assembly, results.dataset("preload", **artefact.fields))


@figure(
    "deformation",
    **_OF_PRELOAD,
    shows_mesh=True,
    title=f"Shape of {_UNDER_PRELOAD}",
    caption="Cut along the middle of the width; displacements are enlarged. The overlap at the cut "
    "through every shank is the shortening by which the bolt is tightened.",
)
def deformation(artefact: Artefact, results: "Results") -> "Figure":
    """The shape of an assembly under preload."""
    from boltjoint.report.figures.half_lap import plot_deformation

    assembly = results.dataset("assembly", assembly=artefact.assembly)
    return plot_deformation(assembly, results.dataset("preload", **artefact.fields))


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
