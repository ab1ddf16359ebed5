"""Tables of a case: natural frequencies, errors and residuals, harmonics, fits, states, times."""

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.names import REFERENCE, JointName
from boltjoint.report.pages.case.joints import CaseBasis
from boltjoint.report.pages.content import (
    PageContent,
    StudyTable,
    format_residual_in_time,
    harmonics_in_words,
    largest_errors,
    with_fewest_harmonics,
)
from boltjoint.report.pages.document import prose, table_with_caption
from boltjoint.study.response_list import by_trust

_TEXT = prose("case")
_GROUPS = ["joint", "coordinates", "resonance"]
#: columns of every response on a page, with their names there
_OF_RESPONSES = {
    "force_N": "force_N",
    "complete": "complete",
    "converged_peak_frequency_Hz": "frequency_with_all_harmonics_Hz",
    "converged_peak_mm_per_N": "response_with_all_harmonics_mm_per_N",
    "converged_amplitude_error_bar_percent": "±_percent",
    "peak_frequency_Hz": "frequency_Hz",
    "peak_mm_per_N": "response_mm_per_N",
    "peak_frequency_error_percent": "frequency_error_percent",
    "peak_amplitude_error_percent": "amplitude_error_percent",
    "residual": "residual_over_force",
    "residual_in_time": "residual_in_time",
    "reason": "reason",
}


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
    text = _TEXT.harmonic_peaks(harmonics_in_words(fewest), largest_errors(fewest))
    # the error of the basis, the same in all rows, stands with the peaks of the case
    frame = table.frame.drop(columns="basis_amplitude_error_percent", errors="ignore")
    return text + table.html("Peaks by harmonics", groups=["force_N"], frame=frame)


def _time_integration(table: StudyTable) -> Markup:
    if table.frame.empty:
        return _TEXT.no_time_integration()
    difference = table.frame.set_index("harmonics")["difference_percent"].abs()
    largest = difference.groupby(level=0).max()
    highest, lowest = largest.index.max(), largest.index.min()
    text = _TEXT.time_integration(highest, f"{largest[highest]:.2g}", f"{largest[lowest]:.3g}")
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
    notes = [prose("case").natural_frequencies("slipping_Hz" in rows[0])]
    return table_with_caption(
        pd.DataFrame(rows), f"Natural frequencies of {name}", notes, groups=["basis"]
    )
