"""Figure and tables of the joint of a case that is fitted to its measurement."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from boltjoint.study.results import Results

SECTION = "measured"


def _calibrated(contents: Contents) -> Iterator[dict[str, Any]]:
    """Cases with a measurement, with the joint that is fitted."""
    for case, found in contents.study.cases.items():
        if found.measured is not None:
            yield contents.calibrated(case)


_DECLARED = {
    "of": _calibrated,
    "reads": (data_of("calibration", by=["case", "basis", "joint"]),),
    "section": SECTION,
    "job": "calibration_{case}",
}


def _of(artefact: Artefact, results: "Results") -> "xr.Dataset":
    return results.dataset("calibration", **artefact.fields)


@figure(
    "calibration",
    **_DECLARED,
    title="Measured backbone, and the fitted joint",
    caption="Natural frequency and damping ratio over the measured amplitude: points with their "
    "stated scatter, the fitted joint with the band that its parameters leave. Residuals are model "
    "less measurement over the stated standard deviation; grey is 95 % of them.",
)
def calibration(artefact: Artefact, results: "Results") -> "Figure":
    """Measured points, fitted curves and residuals."""
    from boltjoint.report.figures.backbones import plot_calibration

    return plot_calibration(_of(artefact, results))


@table(
    "fitted_parameters",
    **_DECLARED,
    order=1,
    title="fitted parameters",
    caption="95 % intervals are those that the stated scatter makes. A parameter is not determined "
    "where its interval is as wide as half of its bounds, or the best fit lies at one.",
)
def parameters(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Values with intervals and bounds."""
    from boltjoint.study.tables.calibration import tabulate_parameters

    return tabulate_parameters(_of(artefact, results))


@table(
    "parameter_correlation",
    **_DECLARED,
    order=2,
    title="correlation of the parameters",
    caption="Near 1 or -1 only one of two can be told, or both together.",
)
def correlation(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Correlation of each two parameters."""
    from boltjoint.study.tables.calibration import tabulate_correlation

    return tabulate_correlation(_of(artefact, results))


@table(
    "calibration_residuals",
    **_DECLARED,
    order=3,
    title="residuals of the fit",
    caption="Over the stated scatter a right model has some 1. Small probabilities of residuals so "
    "large, or of so few changes of their sign over the amplitude, speak against the model.",
)
def residuals(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Size and order of the residuals of each curve."""
    from boltjoint.study.tables.calibration import tabulate_residuals

    return tabulate_residuals(_of(artefact, results))
