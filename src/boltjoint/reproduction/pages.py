"""Pages beside the thesis: indices of its tables and figures, and its solution times."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.study import Study
from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.report.pages.case.basis import side_by_side
from boltjoint.report.pages.content import anchor_of, page_of
from boltjoint.report.pages.document import Section, link, table_with_caption
from boltjoint.reproduction.comparison import (
    ThesisComparison,
    numbers_in_source,
    numbers_of_figures,
    thesis,
)
from boltjoint.reproduction.published import BASIS, Published
from boltjoint.study.artefact_list import Artefact

_TABLES = {
    "material": "Material",
    "stiffness": "Stiffness and friction of a contact element",
    "times": "Solution times",
    "reductions": "Reduction of solution times",
    "parameters": "Fitted elements",
}


def sections_of_indices(
    study: Study, artefacts: Sequence[Artefact], published: Published
) -> list[Section]:
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


def beside_published(joint: str, times: pd.DataFrame) -> Markup:
    """Times of a joint beside those that the source prints, a table for each of its tables.

    Parameters
    ----------
    joint
        Name of the joint.
    times
        Times of every response in the basis of the source, with published ones.
    """
    if "source_table" not in times:
        return Markup()
    of_joint = times[times["joint"] == joint].dropna(subset="source_table")
    body = Markup()
    for printed, of_table in of_joint.groupby("source_table", sort=False):
        parts = {
            Coordinates(coordinates).label: _here_and_there(
                rows.set_index("force_N"), is_reference=(joint, coordinates) == REFERENCE
            )
            for coordinates, rows in of_table.groupby("coordinates", sort=False)
        }
        body += table_with_caption(
            side_by_side(parts),
            f"Solution times: {JointName(joint).label} (table {printed})",
            [thesis().times(), numbers_in_source("Table", [str(printed)])],
            anchor=f"table-{printed}-{BASIS}",
        )
    return body


def _here_and_there(times: pd.DataFrame, *, is_reference: bool) -> pd.DataFrame:
    columns: dict[str, pd.Series] = {}
    if times["published_s"].notna().any():
        columns |= {"here_s": times["cpu_forward_difference_s"], "source_s": times["published_s"]}
    if not is_reference:
        columns |= {
            "reduction_here_percent": times["reduction_forward_difference_percent"],
            "reduction_in_source_percent": times["published_reduction_percent"],
        }
    return pd.DataFrame(columns)


def time_saved(times: Mapping[str, pd.DataFrame]) -> Markup:
    """Medians of the time saved, here and in the source; empty where nothing is published.

    Parameters
    ----------
    times
        Times of every response in the basis of the source by the case.
    """
    medians = pd.concat([pd.DataFrame(), *(_medians(*of_case) for of_case in times.items())])
    if medians.empty:
        return Markup()
    title = "Time saved, here and in the source"
    return table_with_caption(medians, title, [thesis().time_saved()], groups=["case"])


def _medians(case: str, times: pd.DataFrame) -> pd.DataFrame:
    keys = ["source_table", "joint", "coordinates"]
    here, source = "reduction_forward_difference_percent", "published_reduction_percent"
    printed = times.dropna(subset=[source, "source_table"]) if source in times else times.iloc[:0]
    is_reference = (printed["joint"] == REFERENCE[0]) & (printed["coordinates"] == REFERENCE[1])
    printed = printed[~is_reference]
    if printed.empty:
        return pd.DataFrame()
    # over the forces at which no path breaks off here
    printed = printed.assign(**{source: printed[source].where(printed[here].notna())})
    medians = printed.groupby(keys, sort=False)[[here, source]].median().reset_index()
    medians.insert(0, "case", [link(f"{case}.html", case)] * len(medians))
    return medians.rename(columns={here: "here_percent", source: "source_percent"})


class PagesBesideThesis(ThesisComparison):
    """Pages of a study that is compared with the thesis."""

    def times(self, basis: str, joint: str, table: pd.DataFrame) -> Markup:
        """Times of a joint beside those that the source prints, in its arrangement."""
        return beside_published(joint, table) if basis == BASIS else Markup()

    def time_saved(self, times: Mapping[tuple[str, str], pd.DataFrame]) -> Markup:
        """The time that reduced models save, here and in the source, by case and basis."""
        return time_saved({case: table for (case, basis), table in times.items() if basis == BASIS})

    def sections(self, study: Study, artefacts: Sequence[Artefact]) -> list[Section]:
        """Indices of the source's tables and figures."""
        return sections_of_indices(study, artefacts, self.published)
