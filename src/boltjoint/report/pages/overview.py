"""The overview: main results, validity, and indices of the source that they are beside."""

from collections.abc import Iterator, Mapping, Sequence

import pandas as pd
from markupsafe import Markup, escape

from boltjoint.config.case import Case
from boltjoint.config.study import Study
from boltjoint.harmonics import in_words
from boltjoint.names import REFERENCE
from boltjoint.report.answer_values import (
    BEYOND_FROM,
    SHOWS,
    answer_in_columns,
    calibration_answer,
    summary,
)
from boltjoint.report.comparison import Comparison
from boltjoint.report.pages.accuracy import identity
from boltjoint.report.pages.content import PageContent, StudyTable, format_residual_in_time
from boltjoint.report.pages.document import (
    Section,
    joined,
    link,
    prose,
    render_page,
    table_with_caption,
)
from boltjoint.report.pages.peaks import ALL, NOT_TESTED, SOLVED, peaks_of_reference
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.response_list import by_trust, headline_basis
from boltjoint.study.stage_inputs import Results

_TEXT = prose("overview")

#: cases that sentences tell of; more are rows of a table
_FEW = 2

#: by case and basis
_Accuracies = Mapping[tuple[str, str], StudyTable | None]


def overview_page(
    study: Study,
    artefacts: Sequence[Artefact],
    all_artefacts: Sequence[Artefact],
    results: Results,
    comparison: Comparison,
) -> str:
    """The main results of all cases, and an index of the source that they are compared with.

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
        fits and predictions (``calibration.nc``, ``prediction.nc``), and the record of the machine
        (``environment.json``).
    comparison
        The source that the study is compared with.
    """
    content = PageContent(artefacts, results, comparison)
    accuracies = _accuracies(study, content)
    lead = _lead(study, content, accuracies) + _TEXT.lead(comparison.words)
    validity = comparison.words("validity") or _TEXT.validity()
    sections = [
        Section("results", "Peaks", _peaks(study, content, accuracies)),
        Section("joints", "Joints and responses", _pictures(study, content, accuracies)),
        Section("validity", "Validity", validity),
        *comparison.sections(study, all_artefacts),
        Section("machine", "Computer and software", _machine(content)),
        *content.remainder(),
    ]
    title = "Nonlinear vibration of bolted joints"
    return render_page(title, "Overview", lead, sections, list(study.cases), "overview.html")


def _accuracies(study: Study, content: PageContent) -> _Accuracies:
    """The table of accuracy of each case and basis, where the study has one."""
    return {
        (name, family): content.table("accuracy", case=name, basis=family)
        for name, case in study.cases.items()
        for family in case.bases
    }


def _lead(study: Study, content: PageContent, accuracies: _Accuracies) -> Markup:
    """Sentences on each of a few cases; of more, fits in sentences and a table of the rest."""
    if len(study.cases) <= _FEW:
        return _TEXT.answers(_answers(study, content, accuracies))
    fits = [
        (link(f"{name}.html", name), told)
        for name, case in study.cases.items()
        if (told := calibration_answer(name, case, content.results))
    ]
    rows = []
    for name, case in study.cases.items():
        basis = headline_basis(case)
        accuracy = accuracies[name, basis]
        if accuracy is not None and len(accuracy.frame):
            row = {("", "case"): link(f"{name}.html", name), ("", "basis"): basis}
            rows.append(row | answer_in_columns(name, case, accuracy.frame, content))
    lead = _TEXT.answers(fits) if fits else Markup()
    if not rows:
        return lead
    frame = pd.DataFrame(rows).dropna(axis="columns", how="all")
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    title, bases = "What each joint does", set(frame["", "basis"])
    if len(bases) == 1:
        frame = frame.drop(columns=[("", "basis")])
        title += f", in {bases.pop()}"
    notes = [
        _TEXT.behaviour(
            ("friction", "near") in frame, 100 * SHOWS, BEYOND_FROM in frame, bool(fits)
        )
    ]
    return lead + table_with_caption(frame, title, notes)


def _answers(
    study: Study, content: PageContent, accuracies: _Accuracies
) -> Iterator[tuple[Markup, Markup]]:
    """A link to each case, and sentences on its fit and on what its joint does."""
    for name, case in study.cases.items():
        told = [escape(calibration_answer(name, case, content.results))]
        accuracy = accuracies[name, headline_basis(case)]
        if accuracy is not None and len(accuracy.frame):
            told.append(summary(name, case, accuracy.frame, content))
        if any(told):
            yield link(f"{name}.html", name), Markup(" ").join(filter(None, told))


def _pictures(study: Study, content: PageContent, accuracies: _Accuracies) -> Markup:
    """A picture of each assembly, and the response of each case in its most trusted basis."""
    assemblies = dict.fromkeys(case.assembly for case in study.cases.values())
    body = joined(content.figures("mesh", assembly=name) for name in assemblies)
    responses = Markup()
    for name, case in study.cases.items():
        basis = headline_basis(case)
        title = f"{name}, node to node in {basis}"
        resonance, accuracy = case.resonances(basis)[0], accuracies[name, basis]
        harmonics, has_bars = "", False
        if accuracy is not None:
            peaks = peaks_of_reference(accuracy.frame, resonance)
            harmonics, has_bars = in_words(peaks[SOLVED, "harmonics"]), ALL in peaks
        note = _TEXT.response(link(f"{name}.html", name), harmonics, has_bars)
        of_case = {"case": name, "basis": basis, "resonance": resonance}
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
            row[("", "preload_N")] = case.nominal_preload
            row[("", "friction_elements")] = content.friction_elements(name, family)
            if accuracy is not None:
                row |= _peaks_of(study, case, family, accuracy.frame)
            rows.append(row)
    frame = pd.DataFrame(rows)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    has_residual = ("", "residual_in_time") in frame
    return table_with_caption(frame, "The cases", [_TEXT.cases(has_residual)])


def _peaks_of(
    study: Study, case: Case, family: str, accuracy: pd.DataFrame
) -> dict[tuple[str, str], object]:
    row: dict[tuple[str, str], object] = {}
    peaks = peaks_of_reference(accuracy, case.resonances(family)[0])
    columns = ["frequency_Hz", "frequency_±_percent", "response_mm_per_N", "response_±_percent"]
    for end, extreme in (("lowest", min), ("highest", max)):
        force = extreme(case.levels)
        is_common = all(extreme(of_study.levels) == force for of_study in study.cases.values())
        span = f"peak at {force:g} N" if is_common else f"peak at the {end} force"
        of_force = peaks[peaks["", "force_N"] == force]
        for column in columns:
            present = [(under, column) for under in (ALL, SOLVED) if (under, column) in peaks]
            value = of_force[present[0]].iloc[0] if present and len(of_force) else None
            value = None if pd.isna(value) else value
            has_peak = row.get((span, "frequency_Hz")) is not None
            row[span, column] = NOT_TESTED if not present and has_peak else value
    if "residual_in_time" in accuracy:
        row[("", "residual_in_time")] = format_residual_in_time(accuracy["residual_in_time"].max())
    return row


def _machine(content: PageContent) -> Markup:
    if not content.results.has("environment"):
        return Markup()
    return _TEXT.machine(content.results.record("environment"))
