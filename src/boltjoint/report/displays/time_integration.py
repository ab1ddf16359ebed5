"""Table of time integration and multi-harmonic balance at the peaks of a case."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import table

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.study.results import Results


def _cases(contents: Contents) -> Iterator[dict[str, object]]:
    for case in contents.study.cases:
        if response := contents.integrated(case):
            yield {"case": case, "basis": response.basis}


def _integrated(contents: Contents, artefact: Artefact) -> list[Artefact]:
    response = contents.integrated(artefact.case)._asdict()
    return [
        *contents.select("joint", **artefact.which, joint=REFERENCE[0]),
        *contents.select("response", form="data", case=artefact.case, **response),
    ]


@table(
    "harmonics",
    of=_cases,
    reads=(_integrated,),
    job="harmonics_{case}_{basis}",
    section="harmonics",
    title="more harmonics, and time integration, in {basis}",
    options=lambda contents, artefact: {
        "response": contents.integrated(artefact.case)._asdict(),
        "forces": contents.study.case(artefact.case).verification_forces_N,
    },
    stage="harmonics",
)
def harmonics(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, object],
    forces: Sequence[float],
) -> "pd.DataFrame":
    """Peaks by multi-harmonic balance and by time integration."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.verification.harmonics_table import tabulate_time_integration

    joint = results.dataset("joint", **artefact.which, joint=REFERENCE[0])
    solved = results.dataset("response", case=artefact.case, **response)
    return tabulate_time_integration(joint_from_dataset(joint), solved, forces=forces)
