"""The overview: main results, validity, and an index of the source if any case is compared."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.study import Study
from boltjoint.names import REFERENCE, JointName
from boltjoint.report.pages.content import PageContent, StudyTable, select
from boltjoint.report.pages.document import Section, render_page
from boltjoint.report.pages.headline import ALL, NOT_TESTED, ONE, peaks_of_reference, summary
from boltjoint.report.pages.markup import joined, link, prose, table_with_caption
from boltjoint.report.pages.reduced_models import identity
from boltjoint.report.pages.references import anchor_of, figures_in_source, page_of
from boltjoint.report.pages.statements import format_residual_in_time
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.published import BASIS, Published
from boltjoint.study.results import Results
from boltjoint.study.trusted_bases import by_trust, headline_basis

_TEXT = prose("overview")

#: by case and basis
_Accuracies = Mapping[tuple[str, str], StudyTable | None]

_TABLES = {
    "material": "Material",
    "stiffness": "Stiffness and friction of a contact element",
    "times": "Solution times",
    "reductions": "Reduction of solution times",
    "parameters": "Fitted elements",
}


def overview_page(
    study: Study,
    artefacts: Sequence[Artefact],
    all_artefacts: Sequence[Artefact],
    results: Results,
    published: Published,
) -> str:
    """The main results of all cases, and an index of the source if any is compared with it.

    Parameters
    ----------
    study
        As configured.
    artefacts
        Figures and tables of all cases together, the tables of accuracy of every case and basis, a
        figure of each assembly and the response of each case.
    all_artefacts
        Figures and tables of all pages.
    results
        The content of the tables, the node-to-node joint (``joint.nc``) of every case and basis,
        and the record of the machine (``environment.json``).
    published
        The source's tables; empty where no case is compared with them.
    """
    content = PageContent(artefacts, results, published)
    index = (study, all_artefacts, published)
    is_compared = not published.is_empty
    accuracies = _accuracies(study, content)
    lead = _TEXT.answers(_answers(study, content, accuracies)) + _TEXT.lead(is_compared)
    validity = _TEXT.validity_of_source() if is_compared else _TEXT.validity()
    sections = [
        Section("results", "Peaks", _peaks(study, content, accuracies)),
        Section("joints", "Joints and responses", _pictures(study, content)),
        Section("validity", "Validity", validity),
    ]
    if is_compared:
        sections += [
            Section("tables", "Tables of the source", _index_of_tables(*index), is_folded=True),
            Section("figures", "Figures of the source", _index_of_figures(*index), is_folded=True),
        ]
    sections += [
        Section("machine", "Computer and software", _machine(content)),
        *content.remainder(),
    ]
    title = "Nonlinear vibration of bolted lap joints"
    return render_page(title, "Overview", lead, sections, list(study.cases), "overview.html")


def _accuracies(study: Study, content: PageContent) -> _Accuracies:
    """The table of accuracy of each case and basis, where the study has one."""
    return {
        (name, family): content.table("accuracy", case=name, basis=family)
        for name, case in study.cases.items()
        for family in case.bases
    }


def _answers(
    study: Study, content: PageContent, accuracies: _Accuracies
) -> Iterator[tuple[Markup, Markup]]:
    """A link to each case, and a sentence on what its joint does."""
    for name, case in study.cases.items():
        accuracy = accuracies[name, headline_basis(case)]
        if accuracy is not None and len(accuracy.frame):
            yield link(f"{name}.html", name), summary(name, case, accuracy.frame, content)


def _pictures(study: Study, content: PageContent) -> Markup:
    """A picture of each assembly, and the response of each case in its most trusted basis."""
    assemblies = dict.fromkeys(case.assembly for case in study.cases.values())
    body = joined(content.figures("mesh", assembly=name) for name in assemblies)
    responses = Markup()
    for name, case in study.cases.items():
        basis = headline_basis(case)
        title = f"{name}, node to node in {basis}"
        note = _TEXT.response(link(f"{name}.html", name))
        of_case = {"case": name, "basis": basis, "resonance": case.resonances(basis)[0]}
        reference = {"joint": REFERENCE[0], "coordinates": REFERENCE[1]}
        responses += content.figures("response", note, title=title, **of_case, **reference)
    return body + Markup('<div class="gallery">{}</div>').format(responses)


def _peaks(study: Study, content: PageContent, accuracies: _Accuracies) -> Markup:
    rows = []
    for name, case in study.cases.items():
        for family in by_trust(case.bases):
            accuracy = accuracies[name, family]
            row = identity(study.cases, name, family)
            row[("", "friction_law")] = case.contact.declaration.name
            row[("", "preload_N")] = case.preload_N
            row[("", "friction_elements")] = content.friction_elements(name, family)
            if accuracy is not None:
                row |= _peaks_of(study, case, family, accuracy.frame)
            rows.append(row)
    frame = pd.DataFrame(rows)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    return table_with_caption(frame, "The cases", [_TEXT.cases()])


def _peaks_of(
    study: Study, case: Case, family: str, accuracy: pd.DataFrame
) -> dict[tuple[str, str], object]:
    row: dict[tuple[str, str], object] = {}
    peaks = peaks_of_reference(accuracy, case.resonances(family)[0])
    columns = ["frequency_Hz", "frequency_±_percent", "response_mm_per_N", "response_±_percent"]
    for which, extreme in (("lowest", min), ("highest", max)):
        force = extreme(case.levels)
        is_common = all(extreme(each.levels) == force for each in study.cases.values())
        span = f"peak at {force:g} N" if is_common else f"peak at the {which} force"
        of_force = peaks[peaks["", "force_N"] == force]
        for column in columns:
            known = [(under, column) for under in (ALL, ONE) if (under, column) in peaks]
            value = of_force[known[0]].iloc[0] if known and len(of_force) else None
            value = None if pd.isna(value) else value
            has_peak = row.get((span, "frequency_Hz")) is not None
            row[span, column] = NOT_TESTED if not known and has_peak else value
    if "residual_in_time" in accuracy:
        row[("", "residual_in_time")] = format_residual_in_time(accuracy["residual_in_time"].max())
    return row


def _index_of_tables(study: Study, artefacts: Sequence[Artefact], published: Published) -> Markup:
    index = published.tables()
    rows = []
    for printed in index.itertuples():
        content = _TABLES[printed.kind]
        if printed.joint:
            content += f": {JointName(printed.joint).label}"
        # one table may print the stiffness of the elements and another their slip forces
        same = select(index, case=printed.case, kind=printed.kind, joint=printed.joint)
        anchor = {
            "stiffness": "case-table",
            "parameters": f"table-{'-'.join(same['table'])}-{BASIS}",
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
    printed: NamedTuple, name: str, case: Case, artefacts: Sequence[Artefact]
) -> bool:
    """Whether a case has what a table of the source prints."""
    kind = "elements" if printed.kind == "parameters" else "times"
    joint = printed.joint if kind == "elements" else None
    table = Artefact(kind, "table", case=name, basis=BASIS, joint=joint)
    return printed.joint in case.joints(BASIS) and table in artefacts


def _index_of_figures(study: Study, artefacts: Sequence[Artefact], published: Published) -> Markup:
    links: dict[str, list[str]] = {}
    for each in artefacts:
        case = study.cases.get(each.case)
        of_case = Published(published.folder, case.published if case else None)
        for figure in figures_in_source(each, of_case):
            links.setdefault(figure, []).append(_link(page_of(each), anchor_of(each)))
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


def _links_or_reason(links: Sequence[str], study: Study, case: str) -> str:
    if links:
        return Markup(", ").join(dict.fromkeys(links))
    if case and all(each.published != case for each in study.cases.values()):
        return "no case of this study is compared with it"
    return "not computed in this study"


def _machine(content: PageContent) -> Markup:
    if not content.results.has("environment"):
        return Markup()
    return _TEXT.machine(content.results.record("environment"))
