"""Figures and tables of frequency responses: curves, sensors, contact, errors, costs, times."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from boltjoint.names import REFERENCE
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import assembly_of_case, data_of, figure, table, table_of_same
from boltjoint.study.response_list import Response

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from boltjoint.report.comparison import Comparison
    from boltjoint.study.stage_inputs import Results


_OF_JOINT = ("case", "basis", "joint")
_OF_RESPONSE = (*_OF_JOINT, "coordinates", "resonance")


def _bases(contents: Contents) -> list[dict[str, Any]]:
    return [{"case": case, "basis": basis} for case, basis in contents.cases_and_bases()]


def _timed_bases(contents: Contents) -> list[dict[str, Any]]:
    return [] if "timing" in contents.study.omit else _bases(contents)


def _timed_resonances(contents: Contents) -> Iterator[dict[str, Any]]:
    for fields in _timed_bases(contents):
        for resonance in contents.study.case(fields["case"]).resonances(fields["basis"]):
            yield fields | {"resonance": resonance}


def _responses(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        for response in contents.responses(case):
            yield {"case": case, **response._asdict()}


def _node_to_node(contents: Contents) -> Iterator[dict[str, Any]]:
    """Responses that have contact states of every pair."""
    for fields in _responses(contents):
        if fields["joint"] == REFERENCE[0] and fields["coordinates"].kind != "backbone":
            yield fields


def _reference(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """The response that others around the same resonance are compared with."""
    fields = artefact.fields | dict(zip(("joint", "coordinates"), REFERENCE, strict=True))
    return contents.select("response", form="data", **fields)


def _responses_of(contents: Contents, artefact: Artefact) -> dict[str, Any]:
    return {"responses": contents.responses(**artefact.fields)}


def _in_words(artefact: Artefact) -> str:
    fields = artefact.fields
    words = f"{fields['joint'].label}, {fields['coordinates'].label}"
    resonance = fields["resonance"]
    return words + (f" around resonance {resonance}" if resonance > 1 else "")


@figure(
    "response",
    of=_responses,
    reads=(data_of("response", by=_OF_RESPONSE), _reference),
    job="responses_{case}_{basis}",
    section="responses",
    title=lambda artefact: _in_words(artefact)[:1].upper() + _in_words(artefact)[1:],
)
def response(artefact: Artefact, results: "Results") -> "Figure":
    """Frequency responses of a joint, over those of the node-to-node joint in linear modes."""
    from boltjoint.report.figures.responses import plot_response

    reference = artefact.fields | dict(zip(("joint", "coordinates"), REFERENCE, strict=True))
    has_reference = reference != artefact.fields and results.has("response", **reference)
    return plot_response(
        results.dataset("response", **artefact.fields),
        artefact.fields["joint"],
        artefact.fields["coordinates"],
        reference=results.dataset("response", **reference) if has_reference else None,
    )


@figure(
    "states",
    of=_node_to_node,
    reads=(
        assembly_of_case,
        data_of("joint", by=_OF_JOINT),
        data_of("response", by=_OF_RESPONSE),
    ),
    job="responses_{case}_{basis}",
    section="responses",
    title=lambda artefact: f"Contact at the peaks: {_in_words(artefact)}",
    caption="Contact state of every pair over one period, at the peak of each response.",
    options=lambda contents, artefact: {"assembly": contents.study.case(artefact.case).assembly},
)
def states(artefact: Artefact, results: "Results", assembly: str) -> "Figure":
    """Contact states at the peaks, on the contact surface."""
    from boltjoint.report.figures.contact import plot_states

    joint = {name: getattr(artefact, name) for name in _OF_JOINT}
    return plot_states(
        results.dataset("assembly", assembly=assembly),
        results.dataset("joint", **joint),
        results.dataset("response", **artefact.fields),
    )


@figure(
    "times",
    of=_timed_resonances,
    reads=(
        lambda contents, artefact: contents.select(
            "times", form="table", case=artefact.case, basis=artefact.basis
        ),
    ),
    job="responses_{case}_{basis}",
    section="times",
    title="Solution times around resonance {resonance}",
    caption="Above, the times; below, their ratios to those of the node-to-node joint in linear "
    "modes.",
    is_compared=True,
)
def times(artefact: Artefact, results: "Results", comparison: "Comparison") -> "Figure":
    """Solution times over force."""
    from boltjoint.report.figures.responses import plot_times

    table = results.table("times", case=artefact.case, basis=artefact.basis)
    return plot_times(table, artefact.fields["resonance"], comparison.reductions_of_time)


@table(
    "accuracy",
    of=_bases,
    reads=(data_of("response", "check", by=["case", "basis"]),),
    job="basis_{case}_{basis}",
    section="accuracy",
    title="accuracy in {basis}",
    options=_responses_of,
)
def accuracy(
    artefact: Artefact, results: "Results", responses: Iterable[Response]
) -> "pd.DataFrame":
    """Errors of all responses, with the residuals in time where they were found."""
    from boltjoint.study.tables.accuracy import tabulate_accuracy

    checks: dict[tuple[str, str, int], pd.DataFrame] = {
        response[1:]: results.data("check", case=artefact.case, **response._asdict())
        for response in responses
        if results.has("check", case=artefact.case, **response._asdict())
    }
    return tabulate_accuracy(_load(artefact, results, responses), checks)


@table(
    "states",
    of=_bases,
    reads=(data_of("joint", "response", by=["case", "basis"]),),
    job="basis_{case}_{basis}",
    section="states",
    title="contact states at the peaks in {basis}",
    options=_responses_of,
)
def shares_of_states(
    artefact: Artefact, results: "Results", responses: Iterable[Response]
) -> "pd.DataFrame":
    """Contact states at the peaks of all responses."""
    from boltjoint.study.tables.joints import tabulate_states

    joints: dict[str, xr.Dataset] = {
        joint: results.dataset("joint", **artefact.fields, joint=joint)
        for joint in dict.fromkeys(response.joint for response in responses)
    }
    return tabulate_states(_load(artefact, results, responses), joints)


@table(
    "times",
    of=_timed_bases,
    reads=(data_of("timing", "forward_differences", by=["case", "basis"]),),
    job="basis_{case}_{basis}",
    section="times",
    title="solution times in {basis}",
    options=_responses_of,
    is_compared=True,
)
def processor_times(
    artefact: Artefact,
    results: "Results",
    responses: Iterable[Response],
    comparison: "Comparison",
) -> "pd.DataFrame":
    """Solution times of all responses."""
    import pandas as pd

    from boltjoint.study.timing import tabulate_times

    of_response = {
        response[1:]: {"case": artefact.case, **response._asdict()} for response in responses
    }
    timings: dict[tuple[str, str, int], pd.DataFrame] = {
        response: pd.concat(
            results.data(kind, **fields)
            for kind in ("timing", "forward_differences")
            if results.has(kind, **fields)
        )
        for response, fields in of_response.items()
    }
    return comparison.beside(artefact, tabulate_times(timings))


def _load(
    artefact: Artefact, results: "Results", responses: Iterable[Response]
) -> "dict[tuple[str, str, int], xr.Dataset]":
    return {
        response[1:]: results.dataset("response", case=artefact.case, **response._asdict())
        for response in responses
    }


def _with_several_sensors(contents: Contents) -> Iterator[dict[str, Any]]:
    """Responses of the node-to-node joints in linear modes, in cases with several sensors."""
    for case, described in contents.study.cases.items():
        named = (*described.sensors, *described.outputs)
        sensors = named or contents.study.assembly(described.assembly).output_names
        for response in contents.responses(case):
            if len(sensors) > 1 and (response.joint, response.coordinates) == REFERENCE:
                yield {"case": case, **response._asdict()}


_OF_SENSORS = {
    "of": _with_several_sensors,
    "reads": (data_of("response", by=_OF_RESPONSE),),
    "section": "responses",
}


@figure(
    "sensors",
    **_OF_SENSORS,
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
    **_OF_SENSORS,
    job="basis_{case}_{basis}",
    order=2,
    title="sensors around resonance {resonance} in {basis}",
    caption="Largest amplitude of each sensor in the response, and where it is. Its own error is "
    "not tested: that of the output point, of the same motion, stands beside it where it is known.",
)
def peaks_of_sensors(artefact: Artefact, results: "Results") -> "pd.DataFrame":
    """Largest amplitude of each sensor, by level."""
    from boltjoint.study.tables.accuracy import tabulate_sensors

    return tabulate_sensors(results.dataset("response", **artefact.fields))


def _converged_cases(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        if contents.converged(case) and "timing" not in contents.study.omit:
            yield {"case": case}


def _compared(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """Responses and times around the resonance of the converged response."""
    return [
        data
        for kind in ("response", "timing")
        for response in contents.compared(artefact.fields["case"])
        for data in contents.select(kind, form="data", case=artefact.case, **response._asdict())
    ]


@figure(
    "models",
    of=_converged_cases,
    reads=(table_of_same,),
    job="convergence",
    page="accuracy",
    section="models",
    title="Error against cost",
    caption="Largest errors of the peak over all forces, and the time for all of them. Where "
    "branches broke off, a cross marks the largest error of the others.",
)
def models(artefact: Artefact, results: "Results") -> "Figure":
    """Errors of all models beside their cost."""
    from boltjoint.report.figures.convergence import plot_models

    return plot_models(results.table("models", **artefact.fields))


@table(
    "models",
    of=_converged_cases,
    reads=(_compared,),
    job="models_{case}",
    page="accuracy",
    section="models",
    title="all models against the reference model",
    options=lambda contents, artefact: {
        "compared": contents.compared(artefact.case),
        "converged": contents.converged(artefact.case),
    },
)
def errors_and_costs(
    artefact: Artefact, results: "Results", compared: list[Response], converged: Response
) -> "pd.DataFrame":
    """Errors and costs of all models."""
    from boltjoint.study.tables.accuracy import tabulate_models

    fields = {(*response,): {"case": artefact.case, **response._asdict()} for response in compared}
    return tabulate_models(
        {model: results.dataset("response", **of) for model, of in fields.items()},
        {model: results.data("timing", **of) for model, of in fields.items()},
        (*converged,),
    )
