"""What the tables of further harmonics are made from: a joint and its response in one harmonic.

The tables are declared in files of their own: a change of one computes the other not again.
"""

from typing import TYPE_CHECKING

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr

    from boltjoint.joint.model import Joint
    from boltjoint.study.results import Results


def reads(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """The node-to-node joint of a case in a basis, and its response of the lowest mode."""
    response = contents.in_harmonics(artefact.case)[artefact.basis]._asdict()
    return [
        *contents.select("joint", **artefact.which, joint=REFERENCE[0]),
        *contents.select("response", form="data", case=artefact.case, **response),
    ]


def options(contents: Contents, artefact: Artefact) -> dict[str, object]:
    """That response, and the forces [N] at whose peaks it is verified."""
    return {
        "response": contents.in_harmonics(artefact.case)[artefact.basis]._asdict(),
        "forces": contents.study.case(artefact.case).verification_forces_N,
    }


def load(
    artefact: Artefact, results: "Results", response: "Mapping[str, object]"
) -> "tuple[Joint, xr.Dataset]":
    """What ``reads`` names."""
    from boltjoint.joint.io import joint_from_dataset

    joint = results.dataset("joint", **artefact.which, joint=REFERENCE[0])
    solved = results.dataset("response", case=artefact.case, **response)
    return joint_from_dataset(joint), solved
