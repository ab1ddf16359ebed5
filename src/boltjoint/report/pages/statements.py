"""Statements on errors and residuals that several pages make."""

import pandas as pd
from markupsafe import Markup

from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.markup import prose
from boltjoint.study.tables.html import number

#: residual in time below which the error of the time integration is larger
RESOLUTION_IN_TIME = 1e-6

_ERROR = "peak_amplitude_error_percent"


def reference_statement(content: PageContent) -> Markup:
    """The reference of all errors, and the error of few harmonics against it, as HTML.

    It takes the tables of peaks with more harmonics from the content: those of contact-adapted
    bases, where there are any.
    """
    tables = []
    while table := content.table("harmonic_peaks"):
        tables.append(table)
    tables = [table for table in tables if table.artefact.basis.is_contact_adapted] or tables
    peaks = pd.concat(
        [pd.DataFrame(columns=["force_N", "harmonics", _ERROR])]
        + [with_fewest_harmonics(table.frame) for table in tables]
    )
    forces = (
        sorted(peaks.dropna(subset="peak_amplitude_error_percent")["force_N"].unique())
        if len(peaks)
        else []
    )
    return prose("statements").reference(
        harmonics_in_words(peaks),
        largest_errors(peaks),
        ", ".join(f"{force:g}" for force in forces),
    )


def with_fewest_harmonics(peaks: pd.DataFrame) -> pd.DataFrame:
    """The peaks with the fewest harmonics, as in all results but these."""
    return peaks[peaks["harmonics"] == peaks["harmonics"].min()]


def largest_errors(peaks: pd.DataFrame) -> str:
    """The largest errors of peaks in amplitude and frequency; empty where there are none."""
    known = peaks.dropna(subset=_ERROR)
    return " and ".join(
        f"{number(known[f'peak_{quantity}_error_percent'].abs().max(), 2)} % in {quantity}"
        for quantity in ("amplitude", "frequency")
        if len(known)
    )


def harmonics_in_words(peaks: pd.DataFrame) -> str:
    """The number of harmonics of some peaks."""
    numbers = peaks["harmonics"].unique()
    return "one harmonic" if list(numbers) in ([], [1]) else f"harmonics up to {max(numbers)}"


def format_residual_in_time(residual: float) -> str | None:
    """A residual in time as a cell of a table, no smaller than its resolution.

    >>> format_residual_in_time(3e-7), format_residual_in_time(2.5e-4)
    ('below 10⁻⁶', '0.00025')
    """
    if pd.isna(residual):
        return None
    return "below 10⁻⁶" if residual <= RESOLUTION_IN_TIME else number(residual, 2)
