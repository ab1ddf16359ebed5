"""Figure and table of the sensors of a case, where it has several."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import data_of, figure, table

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.study.results import Results

_OF_RESPONSE = ("case", "basis", "joint", "coordinates", "resonance")


def _references(contents: Contents) -> Iterator[dict[str, Any]]:
    """Responses of the node-to-node joints in linear modes, in cases with several sensors."""
    for case, described in contents.study.cases.items():
        named = (*described.sensors, *described.outputs)
        sensors = named or contents.study.assembly(described.assembly).output_names
        for response in contents.responses(case):
            if len(sensors) > 1 and (response.joint, response.coordinates) == REFERENCE:
                yield {"case": case, **response._asdict()}


_DECLARED = {
    "of": _references,
    "reads": (data_of("response", by=_OF_RESPONSE),),
    "section": "responses",
}


@figure(
    "sensors",
    **_DECLARED,
    job="responses_{case}_{basis}",
    order=1,
    title="Sensors around resonance {resonance} in {basis}",
    caption="First-harmonic amplitude of each sensor over the excitation level, node to node in "
    "linear modes; under base excitation it is relative to the supports.",
)
def sensors(artefact: Artefact, results: "Results") -> "Figure":
    """Amplitude of each sensor over frequency."""
    from boltjoint.report.figures.responses import plot_sensors

    return plot_sensors(results.dataset("response", **artefact.fields))


@table(
    "sensors",
    **_DECLARED,
    job="basis_{case}_{basis}",
    order=2,
    title="sensors around resonance {resonance} in {basis}",
    caption="Largest amplitude of each sensor in the response, and where it is.",
)
def peaks_of_sensors(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Largest amplitude of each sensor, by level."""
    from boltjoint.study.tables.sensors import tabulate_sensors

    return tabulate_sensors(results.dataset("response", **artefact.fields))
