"""Figures and tables of sweeps, on the page of their base case."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table, table_of_same

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.config.sweep import Sweep
    from boltjoint.study.results import Results


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
    from boltjoint.study.tables.sweeps import tabulate_sensitivity

    return tabulate_sensitivity(results.dataset("sweep", sweep=artefact.sweep))


@figure(
    "sweep_bands",
    **_OF_SWEEP,
    of=_sweeps(_with_responses),
    title="Responses of the designs of {sweep}",
    caption="Median of all designs at each frequency, and the bands in which half and nine tenths "
    "of them lie. The largest solution counts where a response folds.",
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
