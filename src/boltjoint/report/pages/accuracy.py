"""The page that compares all models of a case with the response converged in the basis."""

from collections.abc import Sequence

import pandas as pd

from boltjoint.names import coordinates_in_words, is_enriched, joint_in_words
from boltjoint.report.pages import markup
from boltjoint.report.pages.markup import Section, table
from boltjoint.report.pages.shown import Shelf, menu, one_harmonic
from boltjoint.study.published import Published

_MODEL = ["modes", "joint", "coordinates"]

_HOW = """
<p>Errors of models are those of the first resonance's peak, the largest over all forces, against
the node-to-node joint in linear modes of the largest basis that holds the contact
(<i>enriched</i>; <i>docs/theory.md</i> says how it is made). How far that answer is from one in
still more vectors the tables of bases show, which a study with <i>config/convergence.yaml</i> has,
and <i>docs/accuracy.md</i>: frequencies settle first, amplitudes last, at forces under which the
weakest pairs alone slip, or all of them. The time is that of all forces together, the solver alone,
compiled, on one thread.</p>
<ul>
<li>To <b>design a joint</b>, take an enriched basis, and the backbone where one resonance is of
interest: it is as accurate as the full solution and gives damping over amplitude besides.</li>
<li>Modes <b>without contact</b> (<i>free</i>), as the source takes them, put the resonance of a
joint that sticks far too high and its peak too low, however the contact is reduced: they are for
repeating the source.</li>
<li>To <b>reduce the contact</b>, gather pairs that move alike (<i>clusters</i>), and replace the
elements of each by a few with the same first harmonic at all amplitudes (<i>harmonic</i>).</li>
<li>All of this has <b>one harmonic</b>. Where much of the contact slips, further ones matter.</li>
</ul>
"""


def page(files: Sequence[str], published: Published, cases: Sequence[str]) -> str:
    """Errors of bases, models and regions against converged answers, case by case.

    Parameters
    ----------
    files
        The tables (CSV) and figures to show.
    published
        The source.
    cases
        Names of the study's cases, to which the page links.
    """
    shelf = Shelf(files, published)
    sections = [Section("how", "How to read it", _HOW)]
    if body := _patterns(shelf):
        sections.append(Section("patterns", "Bases and the structure", body))
    for name in cases:
        parts = {
            "models": ("Models", _models(shelf, name)),
            "bases": ("Size of the basis", _bases(shelf, name)),
            "divisions": ("Number of regions", _divisions(shelf, name)),
        }
        if any(body for _, body in parts.values()):
            sections.append(Section(f"case-{name}", name, ""))
        sections += [
            Section(f"{kind}-{name}", title, body, level=3)
            for kind, (title, body) in parts.items()
            if body
        ]
    lead = (
        one_harmonic(shelf)
        + "<p>How far is each model from that answer, and what does it cost? For every case "
        "that is also solved in a basis that holds the contact.</p>"
    )
    sections += shelf.rest()
    return markup.page("Accuracy", "Models", lead, sections, menu(cases), "accuracy.html")


def _patterns(shelf: Shelf) -> str:
    body = ""
    while found := shelf.table("patterns"):
        shown, frame = found
        body += shelf.draw(
            "patterns",
            "Resonances of {subject} in bases",
            "Against the full finite-element model with the same springs on the pairs that stick: "
            "the largest error over all patterns of such pairs. Modes without contact approach it "
            "slowly; <i>enriched</i> bases are made for it.",
            subject=shown.subject,
        )
        rows = []
        for (basis, vectors), of_basis in frame.groupby(["basis", "vectors"], sort=False):
            worst = of_basis.groupby(["springs", "resonance"])["error_percent"].max()
            errors = {
                (f"springs along {' and '.join(springs)}", f"resonance_{number}_percent"): error
                for (springs, number), error in worst.items()
            }
            rows.append({("", "basis"): basis, ("", "vectors"): vectors, **errors})
        title = f"Largest errors in {shown.subject}, over all patterns"
        body += table(pd.DataFrame(rows), title)
        title = f"Every pattern of {shown.subject}"
        groups = ["basis", "vectors", "springs", "pattern"]
        body += table(frame, title, (), shown.anchor, shown.from_page, groups)
    return body


def _models(shelf: Shelf, case: str) -> str:
    found = shelf.table("models", subject=case)
    if not found:
        return ""
    shown, frame = found
    return (
        shelf.draw(
            "models",
            "Error against cost",
            "Largest errors of the peak over all forces, and time for all of them. Where a branch "
            "broke off, a cross stands for the largest error of the others.",
            subject=case,
        )
        + table(summary(frame), "Largest errors over all forces", groups=["basis"])
        + table(frame, "Every response", (), shown.anchor, shown.from_page, _MODEL)
    )


def _bases(shelf: Shelf, case: str) -> str:
    found = shelf.table("bases", subject=case)
    if not found:
        return ""
    shown, frame = found
    last = frame["basis"].iloc[-1]
    return (
        shelf.draw(
            "bases",
            "Error against the size of the basis",
            f"Peaks of the node-to-node joint in linear modes, against those in {last}.",
            subject=case,
        )
        + table(
            largest(frame, ["basis", "vectors"]).reset_index(), "Largest errors over all forces"
        )
        + table(frame, "Every peak", (), shown.anchor, shown.from_page, ["basis", "vectors"])
    )


def _divisions(shelf: Shelf, case: str) -> str:
    found = shelf.table("divisions", subject=case)
    if not found:
        return ""
    shown, frame = found
    ways = ["division", "motion", "regions"]
    return (
        shelf.draw(
            "divisions",
            "Error against the number of regions",
            f"Peaks of regions in linear modes of {shown.modes}, against those of all pairs, the "
            "largest error over all forces. Dotted: the error of the resonance that is found "
            "without solving for a response, by which regions to a tolerance are chosen.",
            subject=case,
        )
        + table(
            largest(frame, [*ways, "region_error_percent"]).reset_index(),
            "Largest errors over all forces",
            [
                "Bands along the bar move as the mean of their pairs, as their mean weighted by "
                "load, or as a straight line along the bar; <i>inner-outer</i> bands are divided "
                "across the width too; <i>clusters</i> are pairs that move alike."
            ],
            groups=ways[:2],
        )
        + table(frame, "Every peak", (), shown.anchor, shown.from_page, ways)
    )


def largest(frame: pd.DataFrame, by: list[str]) -> pd.DataFrame:
    """The largest errors of a peak over all forces; a response without a peak does not count.

    Parameters
    ----------
    frame
        As ``convergence.tabulate_basis_peaks`` or ``tabulate_divisions`` gives it.
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
        As ``compare.tabulate_models`` gives it.
    """
    rows = []
    for (modes, joint, coordinates), some in frame.groupby(_MODEL, sort=False):
        rows.append(
            {
                "basis": modes,
                "joint": joint_in_words(joint),
                "solved_in": coordinates_in_words(coordinates),
                "branches_solved": f"{int(some['complete'].sum())} of {len(some)}",
                "frequency_error_percent": some["peak_frequency_error_percent"].abs().max(),
                "amplitude_error_percent": some["peak_amplitude_error_percent"].abs().max(),
                "cpu_s": some["cpu_s"].sum(),
            }
        )
    rows.sort(key=lambda row: not is_enriched(row["basis"]))
    return pd.DataFrame(rows)
