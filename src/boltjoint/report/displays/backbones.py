"""Figures of backbones."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from boltjoint.names import Coordinates, JointName
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from boltjoint.study.results import Results


def _resonances(contents: Contents) -> Iterator[dict[str, object]]:
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
    "Beyond the dashed line the structure moves by more than a tenth of its length.",
    options=lambda contents, artefact: {
        "joints": contents.backbones(artefact.case, artefact.basis, artefact.resonance),
        "forces": contents.study.case(artefact.case).levels,
    },
)
def backbone(
    artefact: Artefact, results: "Results", joints: list[JointName], forces: list[float]
) -> "Figure":
    """Natural frequency and damping ratio over amplitude."""
    from boltjoint.report.figures.curves import response_curves
    from boltjoint.report.figures.responses import plot_backbones

    backbones = {
        joint: results.dataset("backbone", **artefact.fields, joint=joint) for joint in joints
    }
    limits = [
        curve.linear_limit * curve.level
        for joint in joints
        for fields in [{**artefact.fields, "joint": joint, "coordinates": "backbone"}]
        if results.has("response", **fields)
        for curve in response_curves(results.dataset("response", **fields))
    ]
    finite = [limit for limit in limits if math.isfinite(limit)]
    return plot_backbones(backbones, forces, min(finite, default=None))
