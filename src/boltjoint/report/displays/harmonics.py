"""Peaks of a case with several harmonics: their motion, tables, and verification in time."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table
from boltjoint.study.response_list import Response

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from boltjoint.joint.model import Joint
    from boltjoint.study.stage_inputs import Results


def _with_several_harmonics(contents: Contents) -> Iterator[dict[str, Any]]:
    """Node-to-node responses in linear modes whose peaks have several harmonics, or all."""
    study = contents.study
    has_several = study.solver.harmonics != 1 or study.harmonic_convergence
    for case in study.cases if has_several else ():
        for response in contents.references(case):
            yield {"case": case, **response._asdict()}


@figure(
    "peak_motions",
    of=_with_several_harmonics,
    reads=(
        data_of("joint", by=("case", "basis", "joint")),
        data_of("response", by=("case", *Response._fields)),
    ),
    job="responses_{case}_{basis}",
    section="motion",
    title="Motion at the peaks around resonance {resonance} in {basis}",
    caption="Above, the displacement of the output point over one period, from phase 0 of the "
    "excitation; below, the amplitudes of its harmonics: both at the peak of each level, with all "
    "harmonics where that is known, over the first-harmonic amplitude that stands beside the "
    "frequency of the peak. Motions that are nearly sines coincide. Harmonic 0 is the mean "
    "displacement from the assembled state; harmonics that are not drawn vanish, or were not "
    "solved. Under base excitation displacements are relative to the supports.",
)
def peak_motions(artefact: Artefact, results: "Results") -> "Figure":
    """Time history and spectrum of the motion at the peaks."""
    from boltjoint.report.figures.peak_motions import plot_peak_motions

    joint = {name: getattr(artefact, name) for name in ("case", "basis", "joint")}
    mode = results.dataset("joint", **joint)["response_mode"].to_numpy()
    return plot_peak_motions(results.dataset("response", **artefact.fields), mode)


def _bases(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases if contents.study.harmonic_convergence else ():
        for basis in contents.lowest_references(case):
            yield {"case": case, "basis": basis}


def _response(contents: Contents, artefact: Artefact) -> dict[str, Any]:
    return _integrated(contents, artefact)._asdict()


def _reads(contents: Contents, artefact: Artefact) -> list[Artefact]:
    fields = _response(contents, artefact)
    return contents.select("response", form="data", case=artefact.case, **fields)


@table(
    "harmonic_peaks",
    of=_bases,
    reads=(_reads,),
    job="basis_{case}_{basis}",
    section="harmonics",
    title="peaks with more harmonics, in {basis}",
    options=lambda contents, artefact: {"response": _response(contents, artefact)},
)
def harmonic_peaks(
    artefact: Artefact, results: "Results", response: Mapping[str, Any]
) -> "pd.DataFrame":
    """Peaks of the node-to-node joint with increasing numbers of harmonics."""
    from boltjoint.study.tables.harmonic_peaks import tabulate_harmonic_peaks

    solved = results.dataset("response", case=artefact.case, **response)
    return tabulate_harmonic_peaks(solved)


def _smaller_bases(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases if contents.study.harmonic_convergence else ():
        bases = contents.bases_of_integration(case)
        if len(bases) > 1:
            yield {"case": case, "basis": bases[0]}


def _in_larger_basis(contents: Contents, artefact: Artefact) -> dict[str, Any]:
    """The node-to-node joint of a case in the basis larger than its converged one."""
    basis = contents.bases_of_integration(artefact.fields["case"])[1]
    return {"case": artefact.case, "basis": basis, "joint": REFERENCE[0]}


@table(
    "larger_basis",
    of=_smaller_bases,
    reads=(
        lambda contents, artefact: contents.select("joint", **_in_larger_basis(contents, artefact)),
        _reads,
    ),
    job="larger_basis_{case}_{basis}",
    page="accuracy",
    section="bases",
    title="peaks with more harmonics in {basis}, against those in the largest basis",
    options=lambda contents, artefact: {
        "response": _response(contents, artefact),
        "joint": _in_larger_basis(contents, artefact),
        "forces": contents.integrated_levels(artefact.case),
        "steps": contents.study.solver.steps,
    },
    stage="larger_basis",
)
def larger_basis(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, Any],
    joint: Mapping[str, Any],
    forces: Sequence[float],
    steps: Mapping[str, Any],
) -> "pd.DataFrame":
    """Converged peaks of the reference model against those in a larger basis."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.solvers.step_control import StepControl
    from boltjoint.study.tables.harmonic_peaks import tabulate_larger_basis

    return tabulate_larger_basis(
        results.dataset("response", case=artefact.case, **response),
        joint_from_dataset(results.dataset("joint", **joint)),
        forces,
        StepControl(**steps),
    )


def _in_free_modes(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        if response := contents.integrated(case):
            yield {"case": case, "basis": response.basis}


def _reference_models(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        if bases := contents.bases_of_integration(case):
            yield {"case": case, "basis": bases[0]}


def _integrated(contents: Contents, artefact: Artefact) -> Response:
    fields = artefact.fields
    return contents.lowest_references(fields["case"])[fields["basis"]]


def _joint_and_response(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """The node-to-node joint of a case in a basis, and its response of the lowest mode."""
    response = _integrated(contents, artefact)._asdict()
    return [
        *contents.select("joint", **artefact.fields, joint=REFERENCE[0]),
        *contents.select("response", form="data", case=artefact.case, **response),
    ]


@table(
    "harmonics",
    of=_in_free_modes,
    reads=(_joint_and_response,),
    job="harmonics_{case}_{basis}",
    section="harmonics",
    title="more harmonics, and time integration, in {basis}",
    options=lambda contents, artefact: {
        "response": _integrated(contents, artefact)._asdict(),
        "forces": contents.study.case(artefact.case).verification_forces_N,
    },
    stage="harmonics",
)
def harmonics(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, Any],
    forces: Sequence[float],
) -> "pd.DataFrame":
    """Peaks by multi-harmonic balance and by time integration."""
    from boltjoint.verification.multi_harmonic import tabulate_time_integration

    joint, solved = _load(artefact, results, response)
    return tabulate_time_integration(joint, solved, forces=forces)


@table(
    "steady_states",
    of=_reference_models,
    reads=(_joint_and_response,),
    job="steady_states_{case}_{basis}",
    section="harmonics",
    title="converged peaks against time integration, in {basis}",
    options=lambda contents, artefact: {
        "response": _integrated(contents, artefact)._asdict(),
        "forces": contents.integrated_levels(artefact.case),
    },
    stage="steady_states",
)
def steady_states(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, Any],
    forces: Sequence[float],
) -> "pd.DataFrame":
    """Converged peaks of the reference model against the steady state of time integration."""
    from boltjoint.verification.multi_harmonic import tabulate_steady_states

    joint, solved = _load(artefact, results, response)
    return tabulate_steady_states(joint, solved, forces=forces)


def _load(
    artefact: Artefact, results: "Results", response: Mapping[str, Any]
) -> "tuple[Joint, xr.Dataset]":
    from boltjoint.joint.io import joint_from_dataset

    joint = results.dataset("joint", **artefact.fields, joint=REFERENCE[0])
    solved = results.dataset("response", case=artefact.case, **response)
    return joint_from_dataset(joint), solved
