"""Figure and table of all models of a case: errors against the reference model, and cost."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.display import figure, table, table_of_same
from boltjoint.study.response_list import Response

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from boltjoint.study.results import Results


def _cases(contents: Contents) -> Iterator[dict[str, Any]]:
    for case in contents.study.cases:
        if contents.converged(case) and "timing" not in contents.study.omit:
            yield {"case": case}


def _compared(contents: Contents, artefact: Artefact) -> list[Artefact]:
    """Responses and times around the resonance of the converged response."""
    return [
        data
        for kind in ("response", "timing")
        for response in contents.compared(artefact.case)
        for data in contents.select(kind, form="data", case=artefact.case, **response._asdict())
    ]


@figure(
    "models",
    of=_cases,
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
    of=_cases,
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

    fields = {
        tuple(response): {"case": artefact.case, **response._asdict()} for response in compared
    }
    return tabulate_models(
        {model: results.dataset("response", **of) for model, of in fields.items()},
        {model: results.data("timing", **of) for model, of in fields.items()},
        tuple(converged),
    )
