"""Indices of the tables and figures of the source, with links to what a study has of them."""

from collections.abc import Sequence
from typing import Any

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.study import Study
from boltjoint.names import JointName
from boltjoint.report.pages.content import anchor_of, page_of
from boltjoint.report.pages.document import Section
from boltjoint.report.pages.markup import link, table_with_caption
from boltjoint.reproduction.published import BASIS, Published
from boltjoint.reproduction.words import numbers_of_figures
from boltjoint.study.artefact_list import Artefact

_TABLES = {
    "material": "Material",
    "stiffness": "Stiffness and friction of a contact element",
    "times": "Solution times",
    "reductions": "Reduction of solution times",
    "parameters": "Fitted elements",
}


def sections(study: Study, artefacts: Sequence[Artefact], published: Published) -> list[Section]:
    """The sections of the overview about the source.

    Parameters
    ----------
    study
        The study, as it is configured.
    artefacts
        Figures and tables of all pages.
    published
        The published tables.
    """
    tables = _index_of_tables(study, artefacts, published)
    figures = _index_of_figures(study, artefacts, published)
    return [
        Section("tables", "Tables of the source", tables, is_folded=True),
        Section("figures", "Figures of the source", figures, is_folded=True),
    ]


def _index_of_tables(study: Study, artefacts: Sequence[Artefact], published: Published) -> Markup:
    index = published.tables()
    rows = []
    for printed in index.itertuples():
        content = _TABLES[printed.kind]
        if printed.joint:
            content += f": {JointName(printed.joint).label}"
        # one table may print the stiffness of the elements and another their slip forces
        is_same = (
            (index["case"] == printed.case)
            & (index["kind"] == printed.kind)
            & (index["joint"] == printed.joint)
        )
        anchor = {
            "stiffness": "case-table",
            "parameters": f"table-{'-'.join(index['table'][is_same])}-{BASIS}",
        }.get(printed.kind, f"table-{printed.table}-{BASIS}")
        links = [
            _link(name, anchor)
            for name, case in study.cases.items()
            if case.published == printed.case
            and (printed.kind == "stiffness" or _is_reproduced(printed, name, case, artefacts))
        ]
        if printed.kind == "material":
            in_source = any(name in published.assemblies for name in study.assemblies)
            links = [_link("structure", "dimensions-table")] if in_source else []
        rows.append(
            {
                "table": printed.table,
                "case": printed.case or "all",
                "content": content,
                "on_page": _links_or_reason(links, study, printed.case),
            }
        )
    notes = ["Published values stand beside those computed here."]
    return table_with_caption(pd.DataFrame(rows), "Tables 3.1 to 3.23", notes)


def _is_reproduced(
    printed: Any,  # noqa: ANN401
    name: str,
    case: Case,
    artefacts: Sequence[Artefact],
) -> bool:
    """Whether a case has what a table of the source prints."""
    kind = "elements" if printed.kind == "parameters" else "times"
    joint = JointName(printed.joint) if kind == "elements" else None
    table = Artefact(kind, "table", case=name, basis=BASIS, joint=joint)
    return printed.joint in case.joints(BASIS) and table in artefacts


def _index_of_figures(study: Study, artefacts: Sequence[Artefact], published: Published) -> Markup:
    links: dict[str, list[Markup]] = {}
    for artefact in artefacts:
        case = study.cases.get(artefact.case or "")
        of_case = Published(published.folder, case.published if case else None)
        for figure in numbers_of_figures(artefact, of_case):
            links.setdefault(figure, []).append(_link(page_of(artefact), anchor_of(artefact)))
    rows = [
        {
            "figure": printed.figure,
            "case_or_assembly": printed.case or printed.assembly,
            "content": printed.shows,
            "on_page": (printed.not_made and f"not made: {printed.not_made}")
            or _links_or_reason(links.get(printed.figure, []), study, printed.case),
        }
        for printed in published.figures().itertuples()
    ]
    return table_with_caption(pd.DataFrame(rows), "Figures 3.1 to 3.84")


def _link(name: str, anchor: str) -> Markup:
    return link(f"{name}.html#{anchor}", "Structure" if name == "structure" else name)


def _links_or_reason(links: Sequence[Markup], study: Study, case: str) -> str:
    if links:
        return Markup(", ").join(dict.fromkeys(links))
    if case and all(of_study.published != case for of_study in study.cases.values()):
        return "no case of this study is compared with it"
    return "not computed in this study"
