"""Table of the peaks of a case with more harmonics."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import table

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.study.results import Results


def _bases(contents: Contents) -> Iterator[dict[str, object]]:
    for case in contents.study.cases if contents.study.harmonic_convergence else ():
        for basis in contents.lowest_references(case):
            yield {"case": case, "basis": basis}


def _response(contents: Contents, artefact: Artefact) -> dict[str, object]:
    return contents.lowest_references(artefact.case)[artefact.basis]._asdict()


@table(
    "harmonic_peaks",
    of=_bases,
    reads=(
        lambda contents, artefact: contents.select(
            "response", form="data", case=artefact.case, **_response(contents, artefact)
        ),
    ),
    job="basis_{case}_{basis}",
    section="harmonics",
    title="peaks with more harmonics, in {basis}",
    options=lambda contents, artefact: {"response": _response(contents, artefact)},
)
def harmonic_peaks(
    artefact: Artefact, results: "Results", response: Mapping[str, object]
) -> "pd.DataFrame":
    """Peaks of the node-to-node joint with increasing numbers of harmonics."""
    from boltjoint.study.tables.harmonics import tabulate_harmonic_peaks

    solved = results.dataset("response", case=artefact.case, **response)
    return tabulate_harmonic_peaks(solved)
