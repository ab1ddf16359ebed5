"""Statements on errors and residuals that several pages make."""

import pandas as pd
from markupsafe import Markup

from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.markup import prose
from boltjoint.study.tables.html import number

#: residual in time below which the error of the time integration is larger
RESOLUTION_IN_TIME = 1e-6

_ERROR = "peak_amplitude_error_percent"
_BASIS = "basis_amplitude_error_percent"
_LEFT_OUT = "amplitude_truncation_error_percent"


def reference_statement(content: PageContent) -> Markup:
    """The reference of all errors, what is known of its own, and what few harmonics leave out.

    It takes the tables of peaks with more harmonics from the content: those of contact-adapted
    bases count, where there are any.
    """
    tables = []
    while table := content.table("harmonic_peaks"):
        tables.append(table)
    adapted = [table for table in tables if table.artefact.basis.is_contact_adapted]
    peaks = pd.concat(
        [pd.DataFrame(columns=["force_N", "harmonics", _ERROR, _BASIS, _LEFT_OUT])]
        + [table.frame for table in adapted or tables]
    )
    fewest = with_fewest_harmonics(peaks)
    forces = sorted(fewest.dropna(subset=_ERROR)["force_N"].unique())
    return prose("statements").reference(
        bool(adapted),
        *(_largest(peaks, column) for column in (_BASIS, _LEFT_OUT)),
        harmonics_in_words(fewest),
        largest_errors(fewest),
        ", ".join(f"{force:g}" for force in forces),
    )


def _largest(peaks: pd.DataFrame, column: str) -> str:
    """The largest of some errors [%]; empty where none is known."""
    errors = peaks[column].dropna() if column in peaks else pd.Series(dtype=float)
    return number(errors.abs().max(), 2) if len(errors) else ""


def with_fewest_harmonics(peaks: pd.DataFrame) -> pd.DataFrame:
    """The peaks with the fewest harmonics, as in all results but these."""
    return peaks[peaks["harmonics"] == peaks["harmonics"].min()]


def largest_errors(peaks: pd.DataFrame) -> str:
    """The largest errors of peaks in amplitude and frequency; empty where there are none."""
    tested = peaks.dropna(subset=_ERROR)
    return " and ".join(
        f"{number(tested[f'peak_{quantity}_error_percent'].abs().max(), 2)} % in {quantity}"
        for quantity in ("amplitude", "frequency")
        if len(tested)
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
