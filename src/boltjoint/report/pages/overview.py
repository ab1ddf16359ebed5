"""The page that comes first: what was computed, how far to trust it, and where it all is."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from boltjoint import dataset
from boltjoint.config.case import Case
from boltjoint.config.study import Study
from boltjoint.names import REFERENCE, joint_in_words, parse_coordinates, parse_joint
from boltjoint.report.pages import markup
from boltjoint.report.pages.markup import Section, number, table
from boltjoint.report.pages.shown import Shelf, Shown, figures_and_tables, menu, one_harmonic, those
from boltjoint.study import layout
from boltjoint.study.published import BASIS, Published

_TABLES = {
    "material": "Material",
    "stiffness": "Stiffness and friction of a contact element",
    "times": "Solution times",
    "reductions": "Reduction of solution times",
    "parameters": "Fitted elements",
}


def page(study: Study, files: Sequence[str], shown: Sequence[str], published: Published) -> str:
    """The cases at a glance, and an index of the source's tables and figures.

    Parameters
    ----------
    study
        As configured.
    files
        Accuracy and times (CSV) and the node-to-node joint (``joint.nc``) of every case and basis,
        figures and tables that are about all cases, and the record of the machine
        (``environment.json``).
    shown
        Figures and tables that stand on the pages.
    published
        The source's tables.
    """
    shelf = Shelf(files, published)
    first = one_harmonic(shelf)
    sections = [
        Section("results", "Results at a glance", _glance(study, shelf)),
        Section("trust", "How far to trust it", _TRUST + _sampling(shelf)),
        Section("tables", "Tables of the source", _index_of_tables(study, shown, published)),
        Section("figures", "Figures of the source", _index_of_figures(study, shown, published)),
        Section("machine", "What it ran on", _machine(shelf)),
        *shelf.rest(),
    ]
    lead = (
        f"{first}<p>Friction between the bars of a bolted lap joint decides how it vibrates. This "
        "study computes that response with one friction element on every pair of contact nodes, "
        "and asks how little of it is needed: joints of a few regions, of a few elements in each "
        "region, and one mode that depends on the response in place of all linear modes. It "
        "repeats chapter 3 of the thesis <cite>Nonlinear vibrations and reduced order modeling of "
        "bolted joints</cite> and sets the published values beside its own.</p>"
    )
    title = "Nonlinear vibration of bolted lap joints"
    return markup.page(title, "Overview", lead, sections, menu(list(study.cases)), "overview.html")


_TRUST = """
<p>The source describes the structure by four bending modes without contact. Cases with that basis
(<i>free-4</i>) repeat its study; they do not endorse it. Such modes cannot show the local
compliance around the bolts: for the three-bolt assembly with the contact stuck, they put the first
resonance about a third above that of the full finite-element model, and they understate peaks
severalfold. <i>Accuracy</i> on the pages of the cases therefore means agreement with the
node-to-node joint in the same modes: it tells what a reduction costs, not how close the answer is
to the structure. That is what the page <a href="accuracy.html">Accuracy</a> tells: it sets every
model beside the answer that is converged in a basis that holds the contact, with one harmonic, and
beside its cost.</p>
<p>What the source does not say had to be chosen: the loss factor, the dimensions (calibrated to the
published frequencies), the frequency windows, the excited and observed points, and the amplitudes
of the fit. The clamping force of 10 kN per bolt is what the source states; the slip forces in its
tables imply 38 kN.</p>
<p>Of the source's figures only the captions are known: figures here can be set beside them by
number, but not by value.</p>
"""


def _sampling(shelf: Shelf) -> str:
    """Closed forms of the friction forces against sums over time, by whatever the study has."""
    body = shelf.draw(
        "sampling",
        "Friction forces in closed form against sums over time",
        "Forces of the solutions, sampled at so many points a period, against the exact ones.",
    )
    if found := shelf.table("sampling"):
        shown, frame = found
        title = "Error of forces sampled in time"
        body += table(frame, title, (), shown.anchor, shown.from_page, ["case", "law", "samples"])
    return body


def _glance(study: Study, shelf: Shelf) -> str:
    rows, saved = [], []
    for name, case in study.cases.items():
        for family in case.bases:
            accuracy = shelf.table("accuracy", subject=name, modes=family)
            times = shelf.table("times", subject=name, modes=family)
            row = _identity(study, name, family, shelf)
            if accuracy is not None:
                row |= _answers(study, case, family, accuracy[1])
            if times is not None:
                row |= _savings(case, family, times[1])
                if family == BASIS:
                    saved.append(_savings_beside_published(name, times[1]))
            rows.append(row)
    frame = pd.DataFrame(rows)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    response = "response" if study.solver.harmonics == 1 else "first-harmonic response"
    answers = [column for column in frame if column[0] == "" or column[0].startswith("peak")]
    which = [column for column in answers if column[1] in ("case", "basis")]
    body = table(
        frame[answers],
        "The cases",
        [
            f"The peak is that of the node-to-node joint in linear modes, {response} divided by "
            "force, around the first resonance solved. A dash stands where its branch broke off. "
            "The residual is the largest that is left of the equations when friction is marched "
            "in time, and no measure below what the march itself resolves; the pages of the cases "
            "say where it is largest."
        ],
    )
    body += table(
        frame[which + [column for column in frame if column not in answers]],
        "What is cheaper",
        [
            "RDNM are response-dependent nonlinear modes, one of which the same joint is solved "
            "in, and the backbone is such a mode over its amplitude: the largest error of a peak's "
            "amplitude, and how many branches broke off. Time is saved by the joint of fewest "
            "fitted elements, in linear modes, with the analytic Jacobian or a numeric one by "
            "forward differences; this is the median over all forces. A dash stands where nothing "
            "such was solved."
        ],
    )
    published = pd.concat(saved) if saved else pd.DataFrame()
    if len(published):
        body += table(
            published,
            "Time saved, here and in the source",
            [
                "Reduction of the solution time against the node-to-node joint in linear modes, "
                "both with forward differences; medians over all forces."
            ],
            groups=["case"],
        )
    return body


def _identity(study: Study, name: str, family: str, shelf: Shelf) -> dict[tuple[str, str], object]:
    case = study.cases[name]
    row: dict[tuple[str, str], object] = {
        ("", "case"): markup.link(f"{name}.html", name),
        ("", "normal_load"): case.contact.law,
        ("", "preload_N"): case.preload_N,
    }
    if any(len(each.bases) > 1 for each in study.cases.values()):
        row[("", "basis")] = family
    nodes = layout.path("joint", case=name, basis=family, joint=REFERENCE[0])
    known = nodes in shelf.files
    row[("", "friction_elements")] = dataset.load(nodes).sizes["element"] if known else None
    return row


def _answers(
    study: Study, case: Case, family: str, accuracy: pd.DataFrame
) -> dict[tuple[str, str], object]:
    row: dict[tuple[str, str], object] = {}
    solved = those(accuracy, joint=REFERENCE[0], resonance=case.resonances(family)[0])
    linear = those(solved, coordinates=REFERENCE[1])
    for which, extreme in (("lowest", min), ("highest", max)):
        force = extreme(case.forces_N)
        alike = all(extreme(each.forces_N) == force for each in study.cases.values())
        span = f"peak at {force:g} N" if alike else f"peak at the {which} force"
        at = those(linear, force_N=force)
        # the largest response of a part of a path need not be the peak
        at = at[at["complete"]]
        found = at.iloc[0] if len(at) else {}
        row |= {
            (span, "frequency_Hz"): found.get("peak_frequency_Hz"),
            (span, "response_mm_per_N"): found.get("peak_mm_per_N"),
        }
    kinds = solved["coordinates"].map(lambda name: parse_coordinates(name).kind)
    for kind, title in (("real", "RDNM"), ("complex", "complex RDNM"), ("backbone", "backbone")):
        some = solved[kinds == kind]
        row[(title, "amplitude_error_percent")] = some["peak_amplitude_error_percent"].abs().max()
        broken_off = f"{int((~some['complete']).sum())} of {len(some)}"
        row[(title, "broken_off")] = broken_off if len(some) else None
    if "residual_in_time" in accuracy:
        row[("", "residual_in_time")] = markup.in_time(accuracy["residual_in_time"].max())
    return row


def _savings(case: Case, family: str, times: pd.DataFrame) -> dict[tuple[str, str], object]:
    first = case.resonances(family)[0]
    joints = dict.fromkeys(
        joint
        for basis, joint, _, resonance in case.responses
        if (basis, resonance) == (family, first)
    )
    fitted = [joint for joint in joints if parse_joint(joint).elements is not None]
    smallest = min(fitted, key=_elements_in_all, default=None)
    saved = those(times, joint=smallest, coordinates=REFERENCE[1], resonance=first)
    return {
        ("time saved", "analytic_percent"): saved["reduction_percent"].median(),
        ("time saved", "numeric_percent"): saved["reduction_forward_difference_percent"].median(),
    }


def _elements_in_all(joint: str) -> int:
    parsed = parse_joint(joint)
    # how many regions a tolerance asks for is not known here: it makes no difference to the order
    return (1 if parsed.count == "auto" else parsed.count or 0) * (parsed.elements or 0)


def _savings_beside_published(name: str, times: pd.DataFrame) -> pd.DataFrame:
    keys = ["source_table", "joint", "coordinates"]
    ours, theirs = "reduction_forward_difference_percent", "published_reduction_percent"
    printed = times.dropna(subset=[theirs, "source_table"]) if theirs in times else times.iloc[:0]
    is_reference = (printed["joint"] == REFERENCE[0]) & (printed["coordinates"] == REFERENCE[1])
    printed = printed[~is_reference]
    if printed.empty:
        return pd.DataFrame()
    medians = printed.groupby(keys, sort=False)[[ours, theirs]].median().reset_index()
    medians.insert(0, "case", [markup.link(f"{name}.html", name)] * len(medians))
    return medians.rename(columns={ours: "here_percent", theirs: "source_percent"})


def _index_of_tables(study: Study, shown: Sequence[str], published: Published) -> str:
    standing = figures_and_tables(shown)
    index = published.tables()
    rows = []
    for printed in index.itertuples():
        what = _TABLES[printed.kind]
        if printed.joint:
            what += f": {joint_in_words(printed.joint)}"
        # one table may print the stiffness of the elements and another their slip forces
        same = those(index, case=printed.case, kind=printed.kind, joint=printed.joint)
        anchor = {
            "stiffness": "case-table",
            "parameters": f"table-{'-'.join(same['table'])}-{BASIS}",
        }.get(printed.kind, f"table-{printed.table}-{BASIS}")
        places = [
            _link(name, anchor)
            for name, case in study.cases.items()
            if case.published == printed.case
            and (printed.kind == "stiffness" or _stands(printed, name, case, standing))
        ]
        if printed.kind == "material":
            theirs = any(name in published.assemblies for name in study.assemblies)
            places = [_link("structure", "dimensions-table")] if theirs else []
        rows.append(
            {
                "table": printed.table,
                "of": printed.case or "all",
                "shows": what,
                "where": _where(places, study, printed.case),
            }
        )
    return table(pd.DataFrame(rows), "Tables 3.1 to 3.23", ["Published values stand beside ours."])


def _stands(printed: NamedTuple, name: str, case: Case, standing: Sequence[Shown]) -> bool:
    """Whether a case has what a table of the source prints."""
    kind = "elements" if printed.kind == "parameters" else "times"
    joint = printed.joint if kind == "elements" else None
    return printed.joint in case.joints(BASIS) and any(
        (each.kind, each.subject, each.modes, each.joint, each.is_figure)
        == (kind, name, BASIS, joint, False)
        for each in standing
    )


def _index_of_figures(study: Study, shown: Sequence[str], published: Published) -> str:
    places: dict[str, list[str]] = {}
    for each in figures_and_tables(shown):
        if each.is_figure:
            name = each.page(study.cases)
            case = study.cases.get(name)
            mine = Published(published.folder, case.published if case else None)
            for figure in each.in_source(mine):
                places.setdefault(figure, []).append(_link(name, each.anchor))
    rows = [
        {
            "figure": printed.figure,
            "of": printed.case or printed.assembly,
            "shows": printed.shows,
            "where": (printed.not_made and f"not made: {printed.not_made}")
            or _where(places.get(printed.figure, []), study, printed.case),
        }
        for printed in published.figures().itertuples()
    ]
    return table(pd.DataFrame(rows), "Figures 3.1 to 3.84")


def _link(name: str, anchor: str) -> str:
    return markup.link(f"{name}.html#{anchor}", "Structure" if name == "structure" else name)


def _where(places: Sequence[str], study: Study, case: str) -> str:
    if places:
        return markup.Html(", ".join(dict.fromkeys(places)))
    if case and all(each.published != case for each in study.cases.values()):
        return "no case of this study is compared with it"
    return "not computed in this study"


def _machine(shelf: Shelf) -> str:
    body = ""
    for path in shelf.data("environment.json"):
        record = json.loads(Path(path).read_text(encoding="utf-8"))
        packages = ", ".join(
            f"{name} {record['packages'][name]}"
            for name in ("boltjoint", "numpy", "scipy", "numba", "snakemake")
            if name in record["packages"]
        )
        body += (
            f"<p>{record['processor']}, {number(record['cores'])} cores, {record['system']}; "
            f"Python {record['python']}, {packages}. All versions are in "
            '<a href="../environment.json">environment.json</a>.</p>\n'
        )
    return body
