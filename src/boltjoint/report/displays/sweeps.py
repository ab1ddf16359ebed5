"""Figures and tables of sweeps, those of the mesh alone first, on the page of their base case."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table, table_of_same

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.config.sweep import Sweep
    from boltjoint.study.stage_inputs import Results
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
                basis=contents.study.sweeps[str(artefact.sweep)].basis,
                joint=REFERENCE[0],
            ),
        }
        for variant in contents.study.possible_variants(str(artefact.sweep))
    ]


def _joints(contents: Contents, artefact: Artefact) -> list[Artefact]:
    return [joint for mesh in _meshes(contents, artefact) for joint in mesh.values()]


_OF_MESHES = {
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
    **_OF_MESHES,
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
    **_OF_MESHES,
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


def _sweeps(
    has: Callable[["Sweep"], bool] = lambda _: True,
) -> Callable[[Contents], Iterator[dict[str, Any]]]:
    """The sweeps of a study that have something, and whose base case has a page."""

    def of(contents: Contents) -> Iterator[dict[str, Any]]:
        for name, sweep in contents.study.sweeps.items():
            if sweep.case in contents.study.cases and has(sweep):
                yield {"case": sweep.case, "sweep": name}

    return of


def _with_responses(sweep: "Sweep") -> bool:
    return "responses" in sweep.observe


def _with_backbones(sweep: "Sweep") -> bool:
    return "backbone" in sweep.observe


def _with_indices(sweep: "Sweep") -> bool:
    return sweep.design.kind == "saltelli"


_OF_SWEEP = {
    "reads": (data_of("sweep", by=["sweep"]),),
    "job": "sweep_{sweep}",
    "section": "sweeps",
}
#: what the ends of a key are
_ENDS = (
    "Mean peak of the tenth of the designs with the lowest values of a key (≤) and of that with "
    "the highest (≥), whatever their other keys are: these vary independently of it in all designs "
    "but tables. Designs without any peak do not count. Where most designs share a value, the ends "
    "are the lowest and the highest value."
)


@table(
    "sweep_statistics",
    **_OF_SWEEP,
    of=_sweeps(),
    title="peaks of the designs of {sweep}",
    caption="Mean, standard deviation and quantiles over the designs that have a peak. The error "
    "is the largest of those designs that were solved again in a larger model; where none was, it "
    "is not tested.",
)
def sweep_statistics(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Statistics of the peaks."""
    from boltjoint.study.tables.sweeps import tabulate_statistics

    return tabulate_statistics(results.dataset("sweep", sweep=artefact.sweep))


@table(
    "sweep_extremes",
    **_OF_SWEEP,
    of=_sweeps(),
    title="peaks at the ends of the keys of {sweep}",
    caption=f"{_ENDS} The half width is of the interval of 95 % of the mean, if the designs were "
    "drawn at random; those of a grid are not drawn.",
)
def sweep_extremes(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Peaks at the low and the high end of each key."""
    from boltjoint.study.tables.sweeps import tabulate_extremes

    return tabulate_extremes(results.dataset("sweep", sweep=artefact.sweep))


@table(
    "sweep_sensitivity",
    **_OF_SWEEP,
    of=_sweeps(_with_indices),
    title="Sobol indices of {sweep}",
    caption="Shares of the keys in the variance of the peaks, by themselves (first order) and "
    "with all others (total), with intervals of 95 %.",
)
def sweep_sensitivity(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Sobol indices of the peaks."""
    from boltjoint.study.tables.sobol_indices import tabulate_sensitivity

    return tabulate_sensitivity(results.dataset("sweep", sweep=artefact.sweep))


@figure(
    "sweep_bands",
    **_OF_SWEEP,
    of=_sweeps(_with_responses),
    title="Responses of the designs of {sweep}",
    caption="Median of all designs at each frequency, and the bands in which half and nine tenths "
    "of them lie. Where designs peak at different frequencies, this median is below the median "
    "peak. The largest solution counts where a response folds.",
)
def sweep_bands(artefact: Artefact, results: "Results") -> "Figure":
    """Bands of the responses."""
    from boltjoint.report.figures.sweeps import plot_bands

    return plot_bands(results.dataset("sweep", sweep=artefact.sweep))


@figure(
    "sweep_backbones",
    **_OF_SWEEP,
    of=_sweeps(_with_backbones),
    title="Backbones of the designs of {sweep}",
    caption="Natural frequency and damping ratio over the amplitude of the output point: of each "
    "design, or of many the median and the bands in which half and nine tenths of them lie.",
)
def sweep_backbones(artefact: Artefact, results: "Results") -> "Figure":
    """Backbones."""
    from boltjoint.report.figures.sweeps import plot_backbones

    return plot_backbones(results.dataset("sweep", sweep=artefact.sweep))


@figure(
    "sweep_peaks",
    **_OF_SWEEP,
    of=_sweeps(),
    order=1,
    title="Peaks of the designs of {sweep}",
    caption="Over each key that varies; of many designs some hundred are drawn.",
)
def sweep_peaks(artefact: Artefact, results: "Results") -> "Figure":
    """Peaks over the keys."""
    from boltjoint.report.figures.sweeps import plot_peaks

    return plot_peaks(results.dataset("sweep", sweep=artefact.sweep))


@figure(
    "sweep_extremes",
    of=_sweeps(),
    reads=(table_of_same,),
    job="sweep_{sweep}",
    section="sweeps",
    order=2,
    title="How far each key of {sweep} moves the peaks",
    caption=f"{_ENDS} Bars are the distances of these means from the mean of all designs, pale at "
    "the low end and dark at the high end; lines on them are intervals of 95 %, if the designs "
    "were drawn at random.",
)
def extremes(artefact: Artefact, results: "Results") -> "Figure":
    """Tornado of the peaks."""
    from boltjoint.report.figures.sweeps import plot_tornado

    return plot_tornado(results.table("sweep_extremes", **artefact.fields))


@figure(
    "sweep_sensitivity",
    of=_sweeps(_with_indices),
    reads=(table_of_same,),
    job="sweep_{sweep}",
    section="sweeps",
    order=3,
    title="Sobol indices of {sweep}",
    caption="Shares of the keys in the variance of the peaks: narrow and dark by themselves (first "
    "order), broad and pale with all others (total); with intervals of 95 %.",
)
def sensitivity(artefact: Artefact, results: "Results") -> "Figure":
    """Sobol indices of the peaks."""
    from boltjoint.report.figures.sweeps import plot_sensitivity

    return plot_sensitivity(results.table("sweep_sensitivity", **artefact.fields))
