"""The overview: main results, validity, and an index of the source if any case is compared."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.study import Study
from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.report.pages.content import PageContent, StudyTable, select
from boltjoint.report.pages.document import Section, render_page
from boltjoint.report.pages.headline import ALL, NOT_TESTED, ONE, peaks_of_reference, summary
from boltjoint.report.pages.markup import link, prose, table_with_caption
from boltjoint.report.pages.references import anchor_of, figures_in_source, page_of
from boltjoint.report.pages.statements import format_residual_in_time
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.published import BASIS, Published
from boltjoint.study.results import Results
from boltjoint.study.trusted_bases import by_trust, headline_basis

_TEXT = prose("overview")

#: by case and basis
_Accuracies = Mapping[tuple[str, str], StudyTable | None]

#: time saved with numeric Jacobians, as in the source
_NUMERIC = ("time saved", "numeric_percent")

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
        Figures and tables of all cases together, and the tables of accuracy, times and peaks with
        more harmonics of every case and basis.
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
        Section("results", "Results at a glance", _results(study, content, accuracies)),
        Section("validity", "Validity", validity + _sampling(content)),
    ]
    if is_compared:
        sections += [
            Section("tables", "Tables of the source", _index_of_tables(*index)),
            Section("figures", "Figures of the source", _index_of_figures(*index)),
        ]
    sections += [
        Section("machine", "Computer and software", _machine(content)),
        *content.remainder(),
    ]
    title = "Nonlinear vibration of bolted lap joints"
    return render_page(title, "Overview", lead, sections, list(study.cases), "overview.html")


def _sampling(content: PageContent) -> Markup:
    """Error of forces by AFT against the closed forms."""
    body = content.figures("sampling")
    if table := content.table("sampling"):
        body += table.html("Error of forces by AFT", groups=["case", "law", "samples"])
    return body


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


def _results(study: Study, content: PageContent, accuracies: _Accuracies) -> Markup:
    rows, published = [], []
    for name, case in study.cases.items():
        for family in by_trust(case.bases):
            accuracy = accuracies[name, family]
            times = content.table("times", case=name, basis=family)
            row = _identity(study, name, family, content)
            if accuracy is not None:
                row |= _peaks_and_errors(study, case, family, accuracy.frame)
            if times is not None:
                row |= _time_saved(case, family, times.frame)
                if family == BASIS:
                    published.append(_time_saved_beside_published(name, times.frame))
            rows.append(row)
    frame = pd.DataFrame(rows)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    peaks = [column for column in frame if column[0] == "" or column[0].startswith("peak")]
    names = [column for column in peaks if column[1] in ("case", "basis")]
    errors = names + [column for column in frame if column not in peaks]
    body = table_with_caption(frame[peaks], "The cases", [_TEXT.cases()])
    if not (numeric := not content.published.is_empty):
        errors = [column for column in errors if column != _NUMERIC]
    body += table_with_caption(
        frame[errors], "Errors of reduced models and time saved", [_TEXT.reduced_models(numeric)]
    )
    beside = pd.concat([pd.DataFrame(), *published])
    if len(beside):
        title, note = "Time saved, here and in the source", _TEXT.time_saved()
        body += table_with_caption(beside, title, [note], groups=["case"])
    return body


def _identity(
    study: Study, name: str, family: str, content: PageContent
) -> dict[tuple[str, str], object]:
    case = study.cases[name]
    row: dict[tuple[str, str], object] = {
        ("", "case"): link(f"{name}.html", name),
        ("", "friction_law"): case.contact.declaration.name,
        ("", "preload_N"): case.preload_N,
    }
    if any(len(each.bases) > 1 for each in study.cases.values()):
        row[("", "basis")] = family
    row[("", "friction_elements")] = content.friction_elements(name, family)
    return row


def _peaks_and_errors(
    study: Study, case: Case, family: str, accuracy: pd.DataFrame
) -> dict[tuple[str, str], object]:
    row: dict[tuple[str, str], object] = {}
    resonance = case.resonances(family)[0]
    nodes = select(accuracy, joint=REFERENCE[0], resonance=resonance)
    peaks = peaks_of_reference(accuracy, resonance)
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
    kinds = nodes["coordinates"].map(lambda name: Coordinates(name).kind)
    for kind, title in (("real", "RDNM"), ("complex", "complex RDNM"), ("backbone", "backbone")):
        rows = nodes[kinds == kind]
        row[(title, "amplitude_error_percent")] = rows["peak_amplitude_error_percent"].abs().max()
        broken_off = f"{int((~rows['complete']).sum())} of {len(rows)}"
        row[(title, "broken_off")] = broken_off if len(rows) else None
    if "residual_in_time" in accuracy:
        row[("", "residual_in_time")] = format_residual_in_time(accuracy["residual_in_time"].max())
    return row


def _time_saved(case: Case, family: str, times: pd.DataFrame) -> dict[tuple[str, str], object]:
    first = case.resonances(family)[0]
    joints = dict.fromkeys(
        joint
        for basis, joint, _, resonance in case.responses
        if (basis, resonance) == (family, first)
    )
    fitted = [joint for joint in joints if JointName(joint).elements is not None]
    smallest = min(fitted, key=_elements_in_all, default=None)
    saved = select(times, joint=smallest, coordinates=REFERENCE[1], resonance=first)
    return {
        ("time saved", "analytic_percent"): saved["reduction_percent"].median(),
        _NUMERIC: saved["reduction_forward_difference_percent"].median(),
    }


def _elements_in_all(joint: str) -> int:
    name = JointName(joint)
    # how many regions a tolerance asks for is not known here: it makes no difference to the order
    return (1 if name.count == "auto" else name.count or 0) * (name.elements or 0)


def _time_saved_beside_published(name: str, times: pd.DataFrame) -> pd.DataFrame:
    keys = ["source_table", "joint", "coordinates"]
    here, source = "reduction_forward_difference_percent", "published_reduction_percent"
    printed = times.dropna(subset=[source, "source_table"]) if source in times else times.iloc[:0]
    is_reference = (printed["joint"] == REFERENCE[0]) & (printed["coordinates"] == REFERENCE[1])
    printed = printed[~is_reference]
    if printed.empty:
        return pd.DataFrame()
    medians = printed.groupby(keys, sort=False)[[here, source]].median().reset_index()
    medians.insert(0, "case", [link(f"{name}.html", name)] * len(medians))
    return medians.rename(columns={here: "here_percent", source: "source_percent"})


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
