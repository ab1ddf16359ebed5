"""The page of a case: its answer, its peaks, its responses, then its joints and their tables.

The table of peaks is made by ``pages.peaks``, the sentences above it by ``report.answer_values``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.numerical_options import Solver
from boltjoint.harmonics import in_words
from boltjoint.names import REFERENCE, JointName
from boltjoint.report.answer_values import (
    SENTENCE_END,
    calibration_answer,
    calibration_section,
    summary,
)
from boltjoint.report.comparison import Comparison
from boltjoint.report.pages.case.basis import (
    CaseBasis,
    joint_figures,
    peaks,
    responses,
    statement_of_response,
)
from boltjoint.report.pages.case.configuration import facts
from boltjoint.report.pages.content import (
    PageContent,
    StudyTable,
    address_of_sweep,
    capitalize,
    format_residual_in_time,
    largest_errors,
    with_fewest_harmonics,
)
from boltjoint.report.pages.document import Section, joined, prose, render_page, table_with_caption
from boltjoint.report.pages.interactive.curves import InteractiveParts
from boltjoint.report.pages.peaks import error_bars, table_of_peaks
from boltjoint.study import layout
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.response_list import by_trust
from boltjoint.study.stage_inputs import Results

_TEXT = prose("case")
_STAGES = {
    "nodes": "Node-to-node joint",
    "pairs": "Weighted pairs",
    "regions": "Regions",
    "elements": "Few elements in each region",
}
_GROUPS = ["joint", "coordinates", "resonance"]
#: columns of every response on a page, with their names there
_BAR = "converged_amplitude_error_bar_percent"
_OF_RESPONSES = {
    "force_N": "force_N",
    "complete": "complete",
    "converged_peak_frequency_Hz": "frequency_with_all_harmonics_Hz",
    "converged_peak_mm_per_N": "response_with_all_harmonics_mm_per_N",
    _BAR: "±_percent",
    "peak_frequency_Hz": "frequency_Hz",
    "peak_mm_per_N": "response_mm_per_N",
    "peak_frequency_error_percent": "frequency_error_percent",
    "peak_amplitude_error_percent": "amplitude_error_percent",
    "residual": "residual_over_force",
    "residual_in_time": "residual_in_time",
    "reason": "reason",
}


def case_page(
    name: str,
    case: Case,
    solver: Solver,
    artefacts: Sequence[Artefact],
    results: Results,
    comparison: Comparison,
    cases: Sequence[str],
) -> str:
    """The answer of a case: its peaks, responses and joint; folded, all of its models.

    Parameters
    ----------
    name, case
        The case and how it is configured.
    solver
        How friction was solved: in closed form or by AFT, in how many harmonics.
    artefacts
        Figures and tables of the page.
    results
        The content of the tables, and the node-to-node joint (``joint.nc``) of every basis. Where
        they hold responses, backbones, mesh, modes and preload too, drawings answer the pointer.
    comparison
        The source that this case is compared with.
    cases
        Names of the study's cases, to which the page links.
    """
    content = PageContent(artefacts, results, comparison)
    bases = [CaseBasis.of(case, basis, content) for basis in by_trust(case.bases)]
    first = bases[0].accuracy
    answer = first.frame if first is not None and len(first.frame) else None
    parts = InteractiveParts.of_case(name, case, results)
    of_peaks = Markup() if answer is None else table_of_peaks(name, case, answer, content)
    said = "" if answer is None else summary(name, case, answer, content)
    sections = {
        "measured": ("The fit to the measurement", calibration_section(name, case, content)),
        "answer": ("Peaks", of_peaks),
        "explore-responses": ("Responses", parts.responses + _still_response(bases[0])),
        "motion": ("Motion at the peaks", bases[0].content.section("motion", basis=bases[0].name)),
        "natural-frequencies": ("Natural frequencies", natural_frequencies(name, case, content)),
        "joint-in-space": ("The joint in space", parts.view),
        "case": ("The case", facts(name, case, solver, content)),
    }
    shown = [
        Section(anchor, *content_of) for anchor, content_of in sections.items() if content_of[1]
    ]
    details = [
        *(section for basis in bases for section in _sections(basis)),
        *_sweeps(artefacts, content),
        *content.remainder(),
    ]
    shown += [replace(section, is_folded=bool(section.body)) for section in details]
    fitted = SENTENCE_END.split(calibration_answer(name, case, results), maxsplit=1)
    lead = _TEXT.lead(
        fitted, said, comparison.words, case, case.contact.declaration.label, solver.harmonics
    )
    return render_page(
        name, "Case study", lead, shown, cases, f"{name}.html", scripts=parts.scripts
    )


def _still_response(basis: CaseBasis) -> Markup:
    """The response of the node-to-node joint as a printed page and one without scripts have it."""
    values = {"joint": REFERENCE[0], "coordinates": REFERENCE[1]}
    resonance = basis.case.resonances(basis.name)[0]
    note = statement_of_response(basis, **values, resonance=resonance)
    figure = basis.content.figures(
        "response", note, basis=basis.name, **values, resonance=resonance
    )
    return Markup('<div class="still">{}</div>').format(figure) if figure else Markup()


def _sweeps(artefacts: Sequence[Artefact], content: PageContent) -> Iterator[Section]:
    """The sweeps of a case, each with a link to its interactive page."""
    names = dict.fromkeys(artefact.sweep for artefact in artefacts if artefact.sweep is not None)
    bodies = {
        name: _TEXT.sweep(address_of_sweep(name), layout.path("sweep_page", sweep=name))
        + content.section("sweeps", sweep=name)
        for name in names
    }
    if len(bodies) == 1:
        yield Section("sweeps", f"Sweep {next(iter(bodies))}", joined(bodies.values()))
    elif bodies:
        yield Section("sweeps", "Sweeps", Markup())
        for name, body in bodies.items():
            yield Section(f"sweep-{name}", name, body, level=3)


def _sections(basis: CaseBasis) -> Iterator[Section]:
    """All sections of a case in one basis."""
    where = "" if len(basis.case.bases) == 1 else f" in {basis.name}"
    first, *others = basis.case.resonances(basis.name)
    yield from _stages(basis, first, where)
    bodies = {
        **{
            f"resonance-{resonance}": (f"Resonance {resonance}", _joints(basis, resonance))
            for resonance in others
        },
        "fits": ("Fits of elements", fits(basis)),
        "motion": ("Motion at the peaks", Markup()),
        "backbones": ("Backbones", Markup()),
        "harmonics": higher_harmonics(basis),
        "states": ("Contact at the peaks", contact_states(basis)),
        "accuracy": ("Accuracy", accuracy(basis)),
        "times": ("Solution times", solution_times(basis)),
    }
    for anchor, (title, of_anchor) in bodies.items():
        if body := of_anchor + basis.content.section(anchor, basis=basis.name):
            yield Section(f"{anchor}-{basis.name}", title + where, body)


def _stages(basis: CaseBasis, resonance: int, where: str) -> Iterator[Section]:
    """Node-to-node joint, weighted pairs, regions and few elements at the first resonance."""
    for stage, title in _STAGES.items():
        bodies = {
            joint: joint_figures(basis, joint)
            + responses(basis, joint, resonance)
            + _times_of_source(basis, joint)
            for joint in basis.coordinates_by_joint(resonance)
            if _stage_of(joint) == stage
        }
        if not bodies:
            continue
        body = getattr(_TEXT, stage)(basis.content.comparison.words)
        if stage == "nodes":
            body += peaks(basis, resonance) + joined(bodies.values())
        yield Section(f"{stage}-{basis.name}", title + where, body)
        if stage != "nodes":
            for joint, body in bodies.items():
                words = capitalize(JointName(joint).label) + where
                yield Section(f"{JointName(joint).file_name}-{basis.name}", words, body, level=3)


def _times_of_source(basis: CaseBasis, joint: str) -> Markup:
    """Times of a joint as the source that the case is compared with arranges them."""
    if basis.times is None:
        return Markup()
    return basis.content.comparison.times(basis.name, joint, basis.times.frame)


def _stage_of(joint: str) -> str:
    name = JointName(joint)
    if name.pairs is not None:
        return "pairs"
    if name.division is None:
        return "nodes"
    return "regions" if name.reduction is None else "elements"


def _joints(basis: CaseBasis, resonance: int) -> Markup:
    return joined(
        joint_figures(basis, joint) + responses(basis, joint, resonance)
        for joint in basis.coordinates_by_joint(resonance)
    )


def accuracy(basis: CaseBasis) -> Markup:
    """Errors and residuals of every response, and the largest over all forces."""
    if basis.accuracy is None:
        return Markup()
    frame = basis.accuracy.frame
    largest = []
    for key, rows in frame.groupby(_GROUPS, sort=False):
        row = dict(zip(_GROUPS, key, strict=True))
        row["branches_solved"] = f"{int(rows['complete'].sum())} of {len(rows)}"
        row["branches_folded"] = int((rows["turning_points"] > 0).sum())
        for column in (
            "peak_frequency_error_percent",
            "peak_amplitude_error_percent",
            "curve_error_dB",
            "estimated_peak_error_percent",
            "residual",
            "energy_error",
        ):
            row[f"largest_{column.removeprefix('estimated_')}"] = rows[column].abs().max()
        if "residual_in_time" in rows:
            row["residual_in_time"] = format_residual_in_time(rows["residual_in_time"].max())
        largest.append(row)
    if "residual_in_time" in frame:
        frame = frame.assign(
            residual_in_time=frame["residual_in_time"].map(format_residual_in_time)
        )
    title = f"Largest errors over all forces in {basis.name}"
    # the file that the table links to has all columns; a page is not as wide
    told = frame.dropna(axis="columns", how="all")
    if _BAR in told:
        told = told.assign(**{_BAR: error_bars(frame, "amplitude")})
    frame = told[[name for name in (*_GROUPS, *_OF_RESPONSES) if name in told]]
    frame = frame.rename(columns=_OF_RESPONSES)
    return (
        _TEXT.accuracy()
        + table_with_caption(pd.DataFrame(largest), title, groups=_GROUPS[:2])
        + basis.accuracy.html("Errors of every response", groups=_GROUPS, frame=frame)
    )


def higher_harmonics(basis: CaseBasis) -> tuple[str, Markup]:
    """Title and body of the section on more harmonics and on time integration."""
    peaks, integrated = (
        basis.content.table(kind, basis=basis.name) for kind in ("harmonic_peaks", "harmonics")
    )
    body = _peaks_by_harmonics(peaks) if peaks else Markup()
    if integrated is None:
        return "Higher harmonics", body
    return "Higher harmonics and time integration", body + _time_integration(integrated)


def _peaks_by_harmonics(table: StudyTable) -> Markup:
    fewest = with_fewest_harmonics(table.frame)
    text = _TEXT.harmonic_peaks(in_words(fewest["harmonics"]), largest_errors(fewest))
    # the error of the basis, the same in all rows, stands with the peaks of the case
    frame = table.frame.drop(columns="basis_amplitude_error_percent", errors="ignore")
    return text + table.html("Peaks by harmonics", groups=["force_N"], frame=frame)


def _time_integration(table: StudyTable) -> Markup:
    if table.frame.empty:
        return _TEXT.no_time_integration()
    difference = table.frame.set_index("harmonics")["difference_percent"].abs()
    largest = difference.groupby(level=0).max()
    highest, lowest = largest.index.max(), largest.index.min()
    fewest = in_words([lowest]), f"{largest[lowest]:.3g}"
    text = _TEXT.time_integration(in_words([highest]), f"{largest[highest]:.2g}", *fewest)
    return text + table.html("First harmonic of the response")


def fits(basis: CaseBasis) -> Markup:
    """Cost and errors of the fitted elements of all joints."""
    if not (table := basis.content.table("fits", basis=basis.name)):
        return Markup()
    frame = table.frame.assign(joint=table.frame["joint"].map(lambda name: JointName(name).label))
    return _TEXT.fits(basis.content.comparison.words) + table.html("Fits of elements", frame=frame)


def contact_states(basis: CaseBasis) -> Markup:
    """Shares of the contact states at the peaks of all responses."""
    if not (table := basis.content.table("states", basis=basis.name)):
        return Markup()
    return _TEXT.states() + table.html("Contact states of every response", groups=_GROUPS)


def solution_times(basis: CaseBasis) -> Markup:
    """Times of all responses, as figures and as a table."""
    if basis.times is None:
        return Markup()
    figures = basis.content.figures("times", basis=basis.name)
    comparison = basis.content.comparison
    frame = comparison.on_page(basis.name, basis.times.frame)
    table = basis.times.html("Times of every response", groups=_GROUPS, frame=frame)
    return _TEXT.times(comparison.words) + figures + table


#: resonances in the table
_MOST = 6


def natural_frequencies(name: str, case: Case, content: PageContent) -> Markup:
    """Table of the lowest natural frequencies by basis and state of the contact.

    Parameters
    ----------
    name, case
        The case.
    content
        Content of a page that has its node-to-node joints.
    """
    # it takes long to import
    from boltjoint.joint.io import joint_from_dataset
    from boltjoint.report.pages.interactive.view import natural_modes

    rows = []
    for basis in by_trust(case.bases):
        fields = {"case": name, "basis": basis, "joint": REFERENCE[0]}
        if not content.results.has("joint", **fields):
            continue
        stored = content.results.dataset("joint", **fields)
        if "natural_frequency" not in stored:
            continue
        modes = natural_modes(joint_from_dataset(stored), _MOST)
        rows += [
            {
                "basis": basis,
                "resonance": number + 1,
                **{
                    f"{state.replace(' ', '_')}_Hz": frequencies.frequency[number]
                    for state, frequencies in modes.items()
                },
            }
            for number in range(len(modes["sticking"].frequency))
        ]
    if not rows:
        return Markup()
    notes = [_TEXT.natural_frequencies("slipping_Hz" in rows[0])]
    return table_with_caption(
        pd.DataFrame(rows), f"Natural frequencies of {name}", notes, groups=["basis"]
    )
