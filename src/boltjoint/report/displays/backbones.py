"""Figures and tables of backbones: microslip, full slip, and a joint fitted to its measurement."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table, table_of_same

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from boltjoint.study.stage_inputs import Results


def _resonances(contents: Contents) -> Iterator[dict[str, Any]]:
    for case, basis in contents.cases_and_bases():
        for resonance in contents.study.case(case).resonances(basis):
            if contents.backbones(case, basis, resonance):
                yield {"case": case, "basis": basis, "resonance": resonance}


def _responses(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """The responses that are made from the backbones."""
    fields = {**artefact.fields, "coordinates": Coordinates("backbone")}
    return contents.select("response", form="data", **fields)


@figure(
    "backbone",
    of=_resonances,
    reads=(data_of("backbone", by=["case", "basis", "resonance"]), _responses),
    job="responses_{case}_{basis}",
    section="backbones",
    title="Backbones of resonance {resonance}",
    caption="Natural frequency and damping ratio of the nonlinear mode over the amplitude of the "
    "output point, from full stick to full slip; a dot is the peak under a force of this case. "
    "Beyond the dashed line the model does not hold: displacement or stress is beyond its limit.",
    options=lambda contents, artefact: {
        "joints": contents.backbones(**artefact.fields),
        "forces": contents.study.case(artefact.case).levels,
    },
)
def backbone(
    artefact: Artefact, results: "Results", joints: list[JointName], forces: list[float]
) -> "Figure":
    """Natural frequency and damping ratio over amplitude."""
    from boltjoint.report.figures.backbones import plot_backbones
    from boltjoint.report.figures.curves import response_curves

    backbones: dict[str, xr.Dataset] = {
        joint: results.dataset("backbone", **artefact.fields, joint=joint) for joint in joints
    }
    limits = [
        curve.model_limit * curve.level
        for joint in joints
        for fields in [{**artefact.fields, "joint": joint, "coordinates": "backbone"}]
        if results.has("response", **fields)
        for curve in response_curves(results.dataset("response", **fields))
    ]
    finite = [limit for limit in limits if math.isfinite(limit)]
    return plot_backbones(backbones, forces, min(finite, default=None))


def _joints(contents: Contents, artefact: Artefact) -> dict[str, list[JointName]]:
    return {"joints": contents.backbones(**artefact.fields)}


def _of_linear(contents: Contents, artefact: Artefact) -> Iterator[Artefact]:
    """Responses in linear modes of the joints with backbones, and these joints."""
    of_basis = {"case": artefact.case, "basis": artefact.basis}
    for joint in _joints(contents, artefact)["joints"]:
        yield from contents.select("joint", form="data", **of_basis, joint=joint)
        solved = artefact.fields | {"joint": joint, "coordinates": REFERENCE[1]}
        yield from contents.select("response", form="data", **solved)


_OF_BACKBONES = {
    "of": _resonances,
    "section": "backbones",
    "options": _joints,
}


@figure(
    "microslip",
    **_OF_BACKBONES,
    reads=(
        table_of_same,
        data_of("backbone", by=["case", "basis", "resonance"]),
        _of_linear,
    ),
    job="responses_{case}_{basis}",
    order=1,
    title="Microslip and macroslip around resonance {resonance}",
    caption="Friction dissipation in a period and natural frequency of the nonlinear mode over the "
    "amplitude of the output point; a dot is the peak of a response in linear modes. In microslip "
    "the dissipation grows with a power of the amplitude, the slope of the broad line: 3 for "
    "smooth spheres, 3 + χ with −1 < χ ≤ 0 for an Iwan element. In macroslip it is 1 under "
    "constant normal load.",
)
def microslip(artefact: Artefact, results: "Results", joints: Sequence[JointName]) -> "Figure":
    """Friction dissipation and natural frequency over amplitude, and the power of microslip."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.report.figures.backbones import Peaks, plot_microslip
    from boltjoint.study.tables.backbones import peak_dissipation

    peaks: dict[str, Peaks] = {}
    for name in joints:
        fields = artefact.fields | {"joint": name, "coordinates": REFERENCE[1]}
        if results.has("response", **fields):
            of_joint = {key: fields[key] for key in ("case", "basis", "joint")}
            joint = joint_from_dataset(results.dataset("joint", **of_joint))
            peaks[name] = Peaks(*peak_dissipation(joint, results.dataset("response", **fields)))
    backbones: dict[str, xr.Dataset] = {
        name: results.dataset("backbone", **artefact.fields, joint=name) for name in joints
    }
    return plot_microslip(backbones, results.table("microslip", **artefact.fields), peaks)


@table(
    "microslip",
    **_OF_BACKBONES,
    reads=(data_of("backbone", by=["case", "basis", "resonance"]),),
    job="basis_{case}_{basis}",
    order=2,
    title="power of microslip around resonance {resonance} in {basis}",
    caption="The power is fitted where the damping ratio by friction is between a hundredth and a "
    "tenth of its maximum, at which macroslip begins.",
)
def power_laws(
    artefact: Artefact, results: "Results", joints: Sequence[JointName]
) -> "pd.DataFrame":
    """The power law of microslip of each joint."""
    from boltjoint.study.tables.backbones import tabulate_microslip

    return tabulate_microslip(
        {joint: results.dataset("backbone", **artefact.fields, joint=joint) for joint in joints}
    )


SECTION_OF_CALIBRATION = "measured"


def _measured(key: str | None = None) -> Callable[[Contents], Iterator[dict[str, Any]]]:
    """Calibrated joints of cases with a measurement, or with one that has a key."""

    def of(contents: Contents) -> Iterator[dict[str, Any]]:
        for case, configured in contents.study.cases.items():
            measured = configured.measured
            if measured is not None and (key is None or getattr(measured, key)):
                yield contents.calibrated(case)

    return of


_OF_CALIBRATION = {
    "of": _measured(),
    "reads": (data_of("calibration", by=["case", "basis", "joint"]),),
    "section": SECTION_OF_CALIBRATION,
    "job": "calibration_{case}",
}


_OF_PREDICTION = {
    **_OF_CALIBRATION,
    "of": _measured("predicted"),
    "reads": (data_of("prediction", by=["case", "basis", "joint"]),),
}


def _of(artefact: Artefact, results: "Results") -> "xr.Dataset":
    return results.dataset("calibration", **artefact.fields)


@figure(
    "calibration",
    **_OF_CALIBRATION | {"of": _measured("curves")},
    title="Measured backbone, and the fitted joint",
    caption="Natural frequency and damping ratio over the measured amplitude: points with their "
    "stated scatter, the fitted joint with the band that its parameters leave. Residuals are model "
    "less measurement over the stated standard deviation; grey is 95 % of them.",
)
def calibration(artefact: Artefact, results: "Results") -> "Figure":
    """Measured points, fitted curves and residuals."""
    from boltjoint.report.figures.calibration import plot_calibration

    return plot_calibration(_of(artefact, results))


@figure(
    "fitted_responses",
    **_OF_CALIBRATION | {"of": _measured("responses")},
    order=1,
    title="Measured stepped sines, and the fitted joint",
    caption="Response per excitation over the frequency: points as measured, lines by the "
    "excitation that the fitted joint needs for the measured amplitude. Residuals are those of the "
    "logarithm of the excitation over its stated standard deviation; grey is 95 % of them.",
)
def fitted_responses(artefact: Artefact, results: "Results") -> "Figure":
    """Measured responses, those of the fitted joint and residuals."""
    from boltjoint.report.figures.calibration import plot_fitted_responses

    return plot_fitted_responses(_of(artefact, results))


@table(
    "fitted_parameters",
    **_OF_CALIBRATION,
    order=1,
    title="fitted parameters",
    caption="95 % intervals are those that the stated scatter makes: by the covariance, or by the "
    "profile where the sum of squares is no parabola. For a profile all others are fitted anew; "
    "one that ends at a bound does not close. A parameter is not determined where its interval is "
    "as wide as half of its bounds, or ends at one.",
)
def parameters(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Values with intervals and bounds."""
    from boltjoint.study.tables.calibration import tabulate_parameters

    return tabulate_parameters(_of(artefact, results))


@table(
    "posterior",
    **_OF_CALIBRATION,
    order=2,
    title="posterior draws",
    caption="Draws around the best fit, weighted by the true sum of squares: where Pareto k is "
    "above 0.7 they do not stand for the posterior, and their quantiles are left out. All draws "
    "are in calibration.nc.",
)
def posterior(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Quantiles of the draws, and how far they can be trusted."""
    from boltjoint.study.tables.calibration import tabulate_posterior

    return tabulate_posterior(_of(artefact, results))


@table(
    "parameter_correlation",
    **_OF_CALIBRATION,
    order=3,
    title="correlation of the parameters",
    caption="Near 1 or -1 only one of two can be told, or both together.",
)
def correlation(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Correlation of each two parameters."""
    from boltjoint.study.tables.calibration import tabulate_correlation

    return tabulate_correlation(_of(artefact, results))


@table(
    "calibration_residuals",
    **_OF_CALIBRATION,
    order=4,
    title="residuals of the fit",
    caption="Over the stated scatter a right model has some 1. Small probabilities of residuals so "
    "large, or of so few changes of their sign along the curve, speak against the model. Errors of "
    "phases are in hundredths of a radian.",
)
def residuals(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Size and order of the residuals of each curve."""
    from boltjoint.study.tables.calibration import tabulate_residuals

    return tabulate_residuals(_of(artefact, results))


@figure(
    "prediction",
    **_OF_PREDICTION,
    order=5,
    title="Measured backbones that were held aside, and what the fit predicts",
    caption="None of these points was fitted. The band holds 95 % of what would be measured if the "
    "model were right: by the scatter of the fitted parameters, and that stated of the points.",
)
def prediction(artefact: Artefact, results: "Results") -> "Figure":
    """Measured points and predicted curves."""
    from boltjoint.report.figures.calibration import plot_prediction

    return plot_prediction(results.dataset("prediction", **artefact.fields))


@table(
    "predicted_curves",
    **_OF_PREDICTION,
    order=6,
    title="curves held aside",
    caption="The shift is the frequency at the largest amplitude less that at the lowest.",
)
def predicted_curves(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Errors, shifts and points within the bands."""
    from boltjoint.study.tables.calibration import tabulate_prediction

    return tabulate_prediction(results.dataset("prediction", **artefact.fields))
