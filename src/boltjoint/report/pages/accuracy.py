"""The page of the accuracy: models of every case, and what the reduced ones lose and save."""

from collections.abc import Mapping, Sequence

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.names import REFERENCE, Basis, Coordinates, JointName
from boltjoint.report.comparison import Comparison
from boltjoint.report.pages.content import PageContent, reference_statement, select
from boltjoint.report.pages.document import Section, link, prose, render_page, table_with_caption
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.response_list import by_trust
from boltjoint.study.stage_inputs import Results

_TEXT_OF_MODELS = prose("accuracy")

#: time saved with numeric Jacobians
_NUMERIC = ("time saved", "numeric_percent")


def reduced_models(cases: Mapping[str, Case], content: PageContent) -> Markup:
    """Tables of the errors of reduced models against all elements, and of the time they save.

    Parameters
    ----------
    cases
        By name.
    content
        Content of a page with the tables of accuracy and times of all, which it takes.
    """
    rows = []
    times_of: dict[tuple[str, str], pd.DataFrame] = {}
    for name, case in cases.items():
        for family in by_trust(case.bases):
            accuracy = content.table("accuracy", case=name, basis=family)
            times = content.table("times", case=name, basis=family)
            row: dict[tuple[str, str], object] = {}
            if accuracy is not None:
                row |= _errors(case, family, accuracy.frame)
            if times is not None:
                row |= _time_saved(case, family, times.frame)
                times_of[name, family] = times.frame
            # of a case that only the reference was solved of there is nothing to tell
            if not pd.isna(list(row.values())).all():
                rows.append(identity(cases, name, family) | row)
    if not rows:
        return Markup()
    frame = pd.DataFrame(rows)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    if not (has_numeric := not content.comparison.is_empty):
        frame = frame.drop(columns=[_NUMERIC], errors="ignore")
    body = table_with_caption(
        frame,
        "Errors of reduced models and time saved",
        [_TEXT_OF_MODELS.reduced_models(has_numeric)],
    )
    return body + content.comparison.time_saved(times_of)


def identity(cases: Mapping[str, Case], name: str, family: str) -> dict[tuple[str, str], object]:
    """The columns that tell a case in a basis from others, with a link to its page."""
    row: dict[tuple[str, str], object] = {("", "case"): link(f"{name}.html", name)}
    if any(len(case.bases) > 1 for case in cases.values()):
        row[("", "basis")] = family
    return row


def _errors(case: Case, family: str, accuracy: pd.DataFrame) -> dict[tuple[str, str], object]:
    row: dict[tuple[str, str], object] = {}
    resonance = case.resonances(family)[0]
    nodes = select(accuracy, joint=REFERENCE[0], resonance=resonance)
    kinds = nodes["coordinates"].map(lambda name: Coordinates(name).kind)
    for kind, title in (("real", "RDNM"), ("complex", "complex RDNM"), ("backbone", "backbone")):
        rows = nodes[kinds == kind]
        row[(title, "amplitude_error_percent")] = rows["peak_amplitude_error_percent"].abs().max()
        broken_off = f"{int((~rows['complete']).sum())} of {len(rows)}"
        row[(title, "broken_off")] = broken_off if len(rows) else None
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


_TEXT = prose("accuracy")
_MODEL = ["modes", "joint", "coordinates"]
_LARGEST = "Largest errors over all forces of {of}: {case}"


def accuracy_page(
    artefacts: Sequence[Artefact],
    results: Results,
    comparison: Comparison,
    cases: Mapping[str, Case],
) -> str:
    """Errors of bases, models and regions against converged responses, case by case.

    Parameters
    ----------
    artefacts
        Figures and tables of the page, the tables of peaks with more harmonics, and those of
        accuracy and times of every case and basis.
    results
        The content of the tables.
    comparison
        The source that the study is compared with.
    cases
        The study's cases by name, to which the page links.
    """
    content = PageContent(artefacts, results, comparison)
    sections = []
    adapted = [
        artefact
        for artefact in artefacts
        if artefact.basis is not None and artefact.basis.is_contact_adapted
    ]
    if adapted:
        has_all = any(artefact.kind == "harmonic_peaks" for artefact in adapted)
        body = _TEXT.reading(comparison.words, has_all)
        sections.append(Section("reading", "Reading the results", body))
    if body := _patterns(content):
        sections.append(Section("patterns", "Bases against the finite-element model", body))
    if figure := content.figures("reductions"):
        sections.append(Section("all-reductions", "Reductions of the contact", figure))
    if body := reduced_models(cases, content):
        sections.append(Section("reduced-models", "Reduced models", body))
    for name in cases:
        parts = {
            "models": ("Models", _models(content, name)),
            "bases": ("Size of the basis", _bases(content, name)),
            "divisions": ("Number of regions", _divisions(content, name)),
            "reductions": ("Reductions of the contact", _reductions(content, name)),
        }
        if any(body for _, body in parts.values()):
            sections.append(Section(f"case-{name}", name, ""))
        sections += [
            Section(f"{kind}-{name}", title, body, level=3)
            for kind, (title, body) in parts.items()
            if body
        ]
    lead = reference_statement(content, bool(adapted)) + _TEXT.lead()
    if body := _sampling(content):
        sections.append(Section("sampling", "Friction forces by AFT", body, is_folded=True))
    sections += content.remainder()
    return render_page("Accuracy", "Models", lead, sections, list(cases), "accuracy.html")


def _sampling(content: PageContent) -> Markup:
    """Error of forces by AFT against the closed forms."""
    body = content.figures("sampling")
    if table := content.table("sampling"):
        body += table.html("Error of forces by AFT", groups=["case", "law", "samples"])
    return body


def _patterns(content: PageContent) -> Markup:
    body = Markup()
    while table := content.table("patterns"):
        assembly = table.artefact.assembly
        body += content.figures("patterns", assembly=assembly)
        rows = []
        for (basis, vectors), of_basis in table.frame.groupby(["basis", "vectors"], sort=False):
            largest = of_basis.groupby(["springs", "resonance"])["error_percent"].max()
            errors = {
                (f"springs along {' and '.join(springs)}", f"resonance_{number}_percent"): error
                for (springs, number), error in largest.items()
            }
            rows.append({("", "basis"): basis, ("", "vectors"): vectors, **errors})
        title = f"Largest errors in {assembly}, over all patterns"
        body += table_with_caption(pd.DataFrame(rows), title)
        groups = ["basis", "vectors", "springs", "pattern"]
        body += table.html(f"Every pattern of {assembly}", groups=groups)
    return body


def _models(content: PageContent, case: str) -> Markup:
    if not (table := content.table("models", case=case)):
        return Markup()
    return (
        content.figures("models", case=case)
        + table_with_caption(
            summary(table.frame), _LARGEST.format(of="models", case=case), groups=["basis"]
        )
        + table.html("Errors of every model", groups=_MODEL)
    )


def _bases(content: PageContent, case: str) -> Markup:
    if not (table := content.table("bases", case=case)):
        return Markup()
    by = ["basis", "vectors"]
    last = table.frame["basis"].iloc[-1]
    with_harmonics = content.table("larger_basis", case=case)
    return (
        content.figures(
            "bases",
            f"Peaks of the node-to-node joint in linear modes, against those in {last}.",
            case=case,
        )
        + table_with_caption(
            largest(table.frame, by).reset_index(), _LARGEST.format(of="bases", case=case)
        )
        + table.html("Peaks of every basis", groups=by)
        + (with_harmonics.html(groups=["force_N"]) if with_harmonics else Markup())
    )


def _divisions(content: PageContent, case: str) -> Markup:
    if not (table := content.table("divisions", case=case)):
        return Markup()
    by = ["division", "motion", "regions"]
    errors = largest(table.frame, [*by, "region_error_percent"]).reset_index()
    return (
        content.figures("divisions", case=case)
        + table_with_caption(
            errors,
            _LARGEST.format(of="regions", case=case),
            [_TEXT.kinds_of_regions()],
            groups=by[:2],
        )
        + table.html("Peaks of every division", groups=by)
    )


def _reductions(content: PageContent, case: str) -> Markup:
    if not (table := content.table("reductions", case=case)):
        return Markup()
    by = ["joint", "points", "elements"]
    errors = largest(table.frame, by)
    errors["cpu_s"] = table.frame.groupby(by, sort=False)["cpu_s"].sum()
    errors = errors.reset_index()
    errors["joint"] = [JointName(joint).label for joint in errors["joint"]]
    title = _LARGEST.format(of="reductions", case=case)
    return table_with_caption(errors, title) + table.html("Peaks of every reduction", groups=by)


def largest(frame: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    """The largest errors of a peak over all forces; a response without a peak does not count.

    Parameters
    ----------
    frame
        As ``tabulate_basis_peaks``, ``tabulate_divisions`` or ``tabulate_reductions`` returns it.
    by
        Columns that become the index.
    """
    errors = ["peak_frequency_error_percent", "peak_amplitude_error_percent"]
    return frame.assign(**frame[errors].abs()).groupby(by, sort=False)[errors].max()


def summary(frame: pd.DataFrame) -> pd.DataFrame:
    """The largest errors of every model over all forces, and its time, the converged one first.

    Parameters
    ----------
    frame
        As ``tabulate_models`` returns it.
    """
    models = []
    for (modes, joint, coordinates), rows in frame.groupby(_MODEL, sort=False):
        models.append(
            {
                "basis": modes,
                "joint": JointName(joint).label,
                "solved_in": Coordinates(coordinates).label,
                "branches_solved": f"{int(rows['complete'].sum())} of {len(rows)}",
                "frequency_error_percent": rows["peak_frequency_error_percent"].abs().max(),
                "amplitude_error_percent": rows["peak_amplitude_error_percent"].abs().max(),
                "cpu_s": rows["cpu_s"].sum(),
            }
        )
    models.sort(key=lambda row: not Basis(row["basis"]).is_contact_adapted)
    return pd.DataFrame(models)
