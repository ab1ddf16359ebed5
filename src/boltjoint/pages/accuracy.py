"""The page that compares all models of a case with its converged response, beside their cost."""

from collections.abc import Sequence

import pandas as pd

from boltjoint.names import coordinates_in_words, is_enriched, joint_in_words
from boltjoint.pages import markup
from boltjoint.pages.markup import Section, table
from boltjoint.pages.shown import Shelf, menu
from boltjoint.published import Published

_MODEL = ["modes", "joint", "coordinates"]

_HOW = """
<p>Errors are those of the first resonance's peak, the largest over all forces, against the
node-to-node joint in linear modes of the largest basis that holds the contact (<i>enriched</i>):
the answer to which more vectors add nothing that matters (<i>docs/theory.md</i> says how such a
basis is made). The time is that of all forces together, the solver alone, compiled, on one
thread.</p>
<ul>
<li>To <b>design a joint</b>, take an enriched basis, and the backbone where one resonance is of
interest: it is as accurate as the full solution and gives damping over amplitude besides.</li>
<li>Modes <b>without contact</b> (<i>free</i>), as the source takes them, put the resonance of a
joint that sticks far too high and its peak too low, however the contact is reduced: they are for
repeating the source.</li>
<li>All of this has <b>one harmonic</b>. Where most of the contact slips, further ones matter: the
pages of cases that were marched in time say by how much.</li>
</ul>
"""


def page(files: Sequence[str], published: Published, cases: Sequence[str]) -> str:
    """Errors of every model against the converged response, case by case.

    Parameters
    ----------
    files
        The tables (CSV) and figures of the models.
    published
        The source.
    cases
        Names of the study's cases, to which the page links.
    """
    shelf = Shelf(files, published)
    sections = [Section("how", "How to read it", _HOW)]
    for name in cases:
        if found := shelf.table("models", subject=name):
            shown, frame = found
            body = shelf.draw(
                "models",
                "Error against cost",
                "Largest error of the peak amplitude over all forces, and time for all of them. "
                "Models that broke off at a force are crosses.",
                subject=name,
            )
            body += table(summary(frame), "Largest errors over all forces", groups=_MODEL[:1])
            body += table(frame, "Every response", (), shown.anchor, shown.from_page, _MODEL)
            sections.append(Section(f"models-{name}", name, body))
    sections += shelf.rest()
    lead = (
        "<p>How far is each model from the converged answer, and what does it cost? For every case "
        "that is also solved in a basis that holds the contact.</p>"
    )
    return markup.page("Accuracy", "Models", lead, sections, menu(cases), "accuracy.html")


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
                "paths_solved": f"{int(some['complete'].sum())} of {len(some)}",
                "frequency_error_percent": some["peak_frequency_error_percent"].abs().max(),
                "amplitude_error_percent": some["peak_amplitude_error_percent"].abs().max(),
                "cpu_s": some["cpu_s"].sum(),
            }
        )
    rows.sort(key=lambda row: not is_enriched(row["basis"]))
    return pd.DataFrame(rows)
