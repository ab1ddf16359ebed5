"""Tables of time integration and multi-harmonic balance at the peaks of a case."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import table
from boltjoint.study.response_list import Response

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from boltjoint.joint.model import Joint
    from boltjoint.study.results import Results


def _in_free_modes(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        if response := contents.integrated(case):
            yield {"case": case, "basis": response.basis}


def _reference_models(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        if bases := contents.bases_of_integration(case):
            yield {"case": case, "basis": bases[0]}


def _integrated(contents: Contents, artefact: Artefact) -> Response:
    return contents.lowest_references(artefact.case)[artefact.basis]


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
