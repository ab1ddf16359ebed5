"""Table of the peaks of a case with more harmonics."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import table

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.study.results import Results


def _bases(contents: Contents) -> Iterator[dict[str, object]]:
    for case in contents.study.cases:
        for basis in contents.in_harmonics(case):
            yield {"case": case, "basis": basis}


def _solved(contents: Contents, artefact: Artefact) -> list[Artefact]:
    response = contents.in_harmonics(artefact.case)[artefact.basis]._asdict()
    return [
        *contents.select("joint", **artefact.which, joint=REFERENCE[0]),
        *contents.select("response", form="data", case=artefact.case, **response),
    ]


@table(
    "harmonic_peaks",
    of=_bases,
    reads=(_solved,),
    job="harmonic_peaks_{case}_{basis}",
    section="harmonics",
    title="peaks with more harmonics, in {basis}",
    options=lambda contents, artefact: {
        "response": contents.in_harmonics(artefact.case)[artefact.basis]._asdict(),
        "forces": contents.study.case(artefact.case).verification_forces_N,
    },
    stage="harmonics",
)
def harmonic_peaks(
    artefact: Artefact,
    results: "Results",
    response: Mapping[str, object],
    forces: Sequence[float],
) -> "pd.DataFrame":
    """Peaks of the node-to-node joint with increasing numbers of harmonics."""
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.verification.multi_harmonic import tabulate_peaks

    joint = results.dataset("joint", **artefact.which, joint=REFERENCE[0])
    solved = results.dataset("response", case=artefact.case, **response)
    return tabulate_peaks(joint_from_dataset(joint), solved, forces=forces)
