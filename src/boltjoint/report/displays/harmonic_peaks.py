"""Table of the peaks of a case with more harmonics."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from boltjoint.report.displays import further_harmonics
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import table

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.study.results import Results


def _bases(contents: Contents) -> Iterator[dict[str, object]]:
    for case in contents.study.cases:
        for basis in contents.in_harmonics(case):
            yield {"case": case, "basis": basis}


@table(
    "harmonic_peaks",
    of=_bases,
    reads=(further_harmonics.reads,),
    job="harmonic_peaks_{case}_{basis}",
    section="harmonics",
    title="peaks with more harmonics, in {basis}",
    options=further_harmonics.options,
    stage="harmonics",
)
def harmonic_peaks(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, object],
    forces: Sequence[float],
) -> "pd.DataFrame":
    """Peaks of the node-to-node joint with increasing numbers of harmonics."""
    from boltjoint.verification.harmonic_peaks import tabulate_peaks

    joint, solved = further_harmonics.load(artefact, results, response)
    return tabulate_peaks(joint, solved, forces=forces)
