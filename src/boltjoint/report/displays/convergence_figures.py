"""Figures of convergence: errors of forces, bases and regions.

They are apart from their tables, which take long to compute: a new drawing computes none of them.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from boltjoint.report.displays import convergence_tables
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.display import figure, table_of_same

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from boltjoint.study.stage_inputs import Results


@figure(
    "sampling",
    of=convergence_tables.solved_in_linear_modes,
    reads=(table_of_same,),
    job="convergence",
    page="accuracy",
    section="sampling",
    title="Error of friction forces by alternating frequency/time (AFT)",
    caption="Forces of the solutions by AFT, over the number of time samples per period, against "
    "the closed forms.",
)
def sampling(artefact: Artefact, results: "Results") -> "Figure":
    """Errors of forces by AFT over the number of samples."""
    from boltjoint.report.figures.convergence import plot_sampling

    return plot_sampling(results.table("sampling", **artefact.fields))


@figure(
    "patterns",
    of=convergence_tables.compared_assemblies,
    reads=(table_of_same,),
    job="convergence",
    page="accuracy",
    section="patterns",
    title="Resonances of {assembly} in bases",
    caption="Against the full finite-element model with the same springs on the sticking pairs: "
    "the largest error over all patterns of sticking pairs. Modes without contact converge slowly; "
    "enriched bases are made for such patterns.",
)
def patterns(artefact: Artefact, results: "Results") -> "Figure":
    """Errors of resonances over the size of the basis."""
    from boltjoint.report.figures.convergence import plot_patterns

    return plot_patterns(results.table("patterns", **artefact.fields))


@figure(
    "bases",
    of=convergence_tables.cases_in_several_bases,
    reads=(table_of_same,),
    job="convergence",
    page="accuracy",
    section="bases",
    title="Error against the size of the basis",
    caption="Peaks of the node-to-node joint in linear modes, against those in the largest basis.",
)
def bases(artefact: Artefact, results: "Results") -> "Figure":
    """Errors of peaks over the size of the basis."""
    from boltjoint.report.figures.convergence import plot_bases

    return plot_bases(results.table("bases", **artefact.fields))


@figure(
    "divisions",
    of=convergence_tables.divided_cases,
    reads=(table_of_same,),
    job="convergence",
    page="accuracy",
    section="divisions",
    title="Error against the number of regions",
    caption="Peaks of regions in linear modes of {basis}, against those of all pairs, the largest "
    "error over all forces. Dotted: the largest error of the resonance over nested slip states, "
    "which needs no response; regions to a tolerance are chosen by it.",
)
def divisions(artefact: Artefact, results: "Results") -> "Figure":
    """Errors of peaks over the number of regions."""
    from boltjoint.report.figures.convergence import plot_divisions

    return plot_divisions(results.table("divisions", **artefact.fields))


@figure(
    "reductions",
    of=convergence_tables.any_reduced,
    reads=(lambda contents, _: contents.select("reductions", form="table"),),
    job="convergence",
    page="accuracy",
    section="reductions",
    title="Error of reductions against cost",
    caption="Largest errors over all forces of all cases, against all contact pairs in the same "
    "basis; the time of a response is the mean over forces, of the case where it is longest. "
    "Numbers: of regions, clusters or pairs. A cross: some branches broke off. Dotted: the time of "
    "all pairs, and the tolerances of weighted pairs (auto).",
    options=lambda contents, _: {
        "cases": {
            table["case"]: {
                **table,
                "law": contents.study.case(table["case"]).contact.declaration.name,
            }
            for table in convergence_tables.reduced_cases(contents)
        },
        "tolerances": contents.study.hyper_reduction.model_dump(),
    },
)
def reductions(
    _: Artefact,
    results: "Results",
    cases: Mapping[str, Mapping[str, str]],
    tolerances: Mapping[str, float],
) -> "Figure":
    """Errors of reduced joints over their time."""
    from boltjoint.report.figures.convergence import plot_reductions

    tables = {
        (table["law"], case): results.table("reductions", case=case, basis=table["basis"])
        for case, table in cases.items()
    }
    return plot_reductions(tables, tolerances)
