"""Table of time integration and multi-harmonic balance at the peaks of a case."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from boltjoint.report.displays import further_harmonics
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import table

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.study.results import Results


def _cases(contents: Contents) -> Iterator[dict[str, object]]:
    for case in contents.study.cases:
        if response := contents.integrated(case):
            yield {"case": case, "basis": response.basis}


@table(
    "harmonics",
    of=_cases,
    reads=(further_harmonics.reads,),
    job="harmonics_{case}_{basis}",
    section="harmonics",
    title="more harmonics, and time integration, in {basis}",
    options=further_harmonics.options,
    stage="harmonics",
)
def harmonics(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, object],
    forces: Sequence[float],
) -> "pd.DataFrame":
    """Peaks by multi-harmonic balance and by time integration."""
    from boltjoint.verification.harmonics_table import tabulate_time_integration

    joint, solved = further_harmonics.load(artefact, results, response)
    return tabulate_time_integration(joint, solved, forces=forces)
