"""Tables of mesh studies: sweeps in which nothing but the mesh varies."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, table

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.study.results import Results
    from boltjoint.study.tables.meshes import Mesh

#: where a key of the mesh begins
_MESH = "assembly.mesh."
#: meshes from which an order of convergence follows
_FEWEST = 3


def _mesh_studies(contents: Contents) -> Iterator[dict[str, Any]]:
    """The sweeps of three meshes or more, whose base case has a page."""
    study = contents.study
    for name, sweep in study.sweeps.items():
        of_mesh = all(key.startswith(_MESH) for key in study.swept[name].keys)
        if of_mesh and sweep.case in study.cases and study.swept[name].has_several(_FEWEST):
            yield {"case": sweep.case, "sweep": name}


def _meshes(contents: Contents, artefact: Artefact) -> list[dict[str, Artefact]]:
    """The assembly, the preload and the joint of each variant."""
    return [
        {
            "assembly": Artefact("assembly", assembly=variant.assembly_name),
            "preload": Artefact(
                "preload", assembly=variant.assembly_name, preload_N=variant.case.preload
            ),
            "joint": Artefact(
                "joint",
                case=variant.case_name,
                basis=contents.study.sweeps[artefact.sweep].basis,
                joint=REFERENCE[0],
            ),
        }
        for variant in contents.study.possible_variants(artefact.sweep)
    ]


def _joints(contents: Contents, artefact: Artefact) -> list[Artefact]:
    return [joint for mesh in _meshes(contents, artefact) for joint in mesh.values()]


_DECLARED = {
    "of": _mesh_studies,
    "job": "sweep_{sweep}",
    "section": "sweeps",
    "options": lambda contents, artefact: {
        "meshes": [
            {kind: data.fields for kind, data in mesh.items()}
            for mesh in _meshes(contents, artefact)
        ]
    },
}


@table(
    "meshes",
    **_DECLARED,
    reads=(_joints,),
    title="contact of the meshes of {sweep}",
    caption="Pairs of the plane of contact and those under load. The stiffness is that of all "
    "loaded pairs while they stick, and over their area; the slip displacement is the slip force "
    "of all over this stiffness.",
)
def meshes(_: Artefact, results: "Results", meshes: Sequence[Mapping[str, Any]]) -> "pd.DataFrame":
    """The contact of each mesh."""
    from boltjoint.study.tables.meshes import tabulate_meshes

    return tabulate_meshes(_load(results, meshes))


@table(
    "mesh_convergence",
    **_DECLARED,
    reads=(data_of("sweep", "designs", by=["sweep"]), _joints),
    order=1,
    title="convergence over the meshes of {sweep}",
    caption="Peaks under each force, and the backbone at amplitudes of the output point, in the "
    "three finest meshes, and the order of their convergence by the size of the elements, the cube "
    "root of their mean volume (Roache 1997). No order is given where changes do not fall as those "
    "of any, or have both signs.",
)
def mesh_convergence(
    artefact: Artefact, results: "Results", meshes: Sequence[Mapping[str, Any]]
) -> "pd.DataFrame":
    """Peaks and backbone by mesh, with orders of convergence."""
    from boltjoint.study.tables.meshes import element_size, tabulate_convergence

    variant = results.dataset("designs", sweep=artefact.sweep)["variant"].to_numpy()
    # -1, of an impossible design, is the last
    sizes = [*map(element_size, _load(results, meshes)), float("nan")]
    sweep = results.dataset("sweep", sweep=artefact.sweep)
    return tabulate_convergence(sweep, [sizes[number] for number in variant])


def _load(results: "Results", meshes: Sequence[Mapping[str, Any]]) -> "list[Mesh]":
    from boltjoint.study.tables.meshes import Mesh

    return [
        Mesh(**{kind: results.dataset(kind, **fields) for kind, fields in mesh.items()})
        for mesh in meshes
    ]
