"""Tables of peaks with error bars, and peaks in sentences: the first table of a case's page."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.harmonics import in_words
from boltjoint.names import REFERENCE
from boltjoint.number_format import number
from boltjoint.report.pages.content import PageContent, select
from boltjoint.report.pages.document import prose, table_with_caption
from boltjoint.structure.model_limits import LIMITS, STRESS, Limit
from boltjoint.study.response_list import headline_basis

#: peaks that a sentence tells all of
_FEW = 4

_TEXT = prose("peaks")

#: headings above the columns of the peaks
ALL, SOLVED = "peak with all harmonics", "as solved"

#: columns of the shares of limits that are reached at the peak
REACHED = {
    limit.name: ("reached at the peak", f"{limit.name.replace('_over_', '_of_')}_percent")
    for limit in LIMITS
}

#: estimated error of a basis from which pages recommend a larger one [%]: harmonics leave less
LARGE_BASIS_ERROR = 5.0

#: what stands in place of an error that nobody knows
NOT_TESTED = "not tested"


def peaks_of_reference(accuracy: pd.DataFrame, resonance: int) -> pd.DataFrame:
    """Peaks of the node-to-node joint by force, with all harmonics and as solved.

    Parameters
    ----------
    accuracy
        The table of accuracy of a case in a basis.
    resonance
        Around which they lie.

    Returns
    -------
    DataFrame
        Columns under ``ALL``: frequency, response over force and their error bars, where the study
        has such peaks; bars are not tested in a basis whose error is not estimated, and where no
        motion with further harmonics was found. Under ``SOLVED``, the harmonics that the branch
        has, its peaks and how far the response is off; empty where there is no peak or a branch
        broke off. Last ``REACHED``, of the limits that are known.
    """
    fields = {"joint": REFERENCE[0], "coordinates": REFERENCE[1], "resonance": resonance}
    return peaks_of_coordinates(select(accuracy, **fields))


def peaks_of_coordinates(rows: pd.DataFrame) -> pd.DataFrame:
    """As ``peaks_of_reference``, of some rows of a table of accuracy in any coordinates."""
    # the largest response of a part of a branch need not be the peak
    solved = rows[["peak_frequency_Hz", "peak_mm_per_N"]].where(rows["complete"])
    unknown = pd.Series(np.nan, rows.index)
    columns = {("", "force_N"): rows["force_N"]}
    if "converged_peak_mm_per_N" in rows:
        all_harmonics, off = rows["converged_peak_mm_per_N"], "off_by_percent"
        of_frequency, of_response = (error_bars(rows, what) for what in ("frequency", "amplitude"))
        columns |= {
            (ALL, "frequency_Hz"): rows["converged_peak_frequency_Hz"],
            (ALL, "frequency_±_percent"): of_frequency,
            (ALL, "response_mm_per_N"): all_harmonics,
            (ALL, "response_±_percent"): of_response,
        }
        error = 100 * (solved["peak_mm_per_N"] / all_harmonics - 1).abs()
    else:
        off, error = "error", _or_not_tested(unknown, solved["peak_mm_per_N"])
    columns |= {
        (SOLVED, "harmonics"): rows.get("response_harmonics", unknown),
        (SOLVED, "frequency_Hz"): solved["peak_frequency_Hz"],
        (SOLVED, "response_mm_per_N"): solved["peak_mm_per_N"],
        (SOLVED, off): error,
    }
    columns |= {
        column: rows[f"{name}_percent"]
        for name, column in REACHED.items()
        if f"{name}_percent" in rows
    }
    frame = pd.DataFrame(columns)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    return frame


def error_bars(rows: pd.DataFrame, what: str) -> pd.Series:
    """Error bars [%] of the peaks with all harmonics of a table of accuracy, of two digits.

    Parameters
    ----------
    rows
        Of any coordinates, in a basis: where its error is not estimated, bars that lack it would
        say too little, and are not tested.
    what
        ``frequency`` or ``amplitude``.
    """
    bars = rows[f"converged_{what}_error_bar_percent"]
    if rows["basis_amplitude_error_percent"].isna().all():
        bars = pd.Series(np.nan, rows.index)
    rounded = bars.map(lambda bar: float(f"{bar:.2g}"), na_action="ignore")
    return _or_not_tested(rounded, rows["converged_peak_mm_per_N"])


def basis_error(accuracy: pd.DataFrame) -> float:
    """Estimated error of the amplitude in the basis of a table [%]; not a number if not known."""
    return float(accuracy.get("basis_amplitude_error_percent", pd.Series(dtype=float)).max())


def _or_not_tested(errors: pd.Series, response: pd.Series) -> pd.Series:
    """Errors of responses, with words where that of one is not known."""
    missing = response.notna() & errors.isna()
    return errors.astype(object).mask(missing, NOT_TESTED) if missing.any() else errors


def peak_in_words(
    row: pd.Series, unit: str = "N", *, is_complete: bool = True, lacks_basis_error: bool = False
) -> str:
    """A peak of ``peaks_of_reference`` in a sentence, with its error bar or the lack of one.

    ``unit`` is that of the excitation; ``is_complete`` where the branch crosses its window;
    ``lacks_basis_error`` where the sentence says of all peaks that their basis has no error bar.
    """
    force = f"at {row['', 'force_N']:g} {unit}"
    per_level = "mm/N" if unit == "N" else f"mm/({unit})"
    has_all = (ALL, "frequency_Hz") in row and not pd.isna(row[ALL, "response_mm_per_N"])
    of_peak = row[ALL if has_all else SOLVED]
    frequency, response = of_peak["frequency_Hz"], of_peak["response_mm_per_N"]
    if pd.isna(response):
        return f"none {force}: {'the window has none' if is_complete else 'the branch broke off'}"
    if not has_all:
        harmonics = in_words([of_peak["harmonics"]])
        solved = f"{force} with {harmonics}" if harmonics else force
        return (
            f"{frequency:.1f} Hz and {number(response, 3)} {per_level} {solved}, whose error is not"
            " tested"
        )
    bars = [of_peak[name] for name in ("frequency_±_percent", "response_±_percent")]
    if NOT_TESTED in bars:
        lack = "" if lacks_basis_error else ", whose error is not tested"
        return f"{frequency:.1f} Hz and {number(response, 3)} {per_level} {force}{lack}"
    # no line breaks within a bar
    of_frequency, of_response = (f"(±\N{NO-BREAK SPACE}{number(bar, 2)} %)" for bar in bars)
    amplitude = f"{number(response, 3)} {per_level} {of_response}"
    return f"{frequency:.1f} Hz {of_frequency} and {amplitude} {force}"


def table_of_peaks(name: str, case: Case, accuracy: pd.DataFrame, content: PageContent) -> Markup:
    """Table of the peaks of a case in its most trusted basis, with what their bars hold.

    Nothing of a case whose node-to-node joint is not solved in linear modes.
    """
    basis = headline_basis(case)
    peaks = peaks_of_reference(accuracy, case.resonances(basis)[0])
    if peaks.empty:
        return Markup()
    estimate = basis_error(accuracy)
    told = None if pd.isna(estimate) else number(estimate, 2)
    notes = _TEXT.bars(basis, told, ALL in peaks, estimate > LARGE_BASIS_ERROR)
    beyond = is_beyond(peaks)
    has_stress = REACHED[STRESS.name] in peaks
    limits = [_TEXT.limits(has_stress, beyond.any())] if _shares_of_limits(peaks) else []
    if harmonics := in_words(peaks[SOLVED, "harmonics"]):
        peaks = peaks.rename(columns={SOLVED: f"with {harmonics}"}, level=0)
    peaks = peaks.drop(columns="harmonics", level=1)
    title = f"Peaks of {name} in {basis}"
    return table_with_caption(peaks, title, [notes, *limits], marked=beyond.tolist())


def statement_of(rows: pd.DataFrame) -> str:
    """Peaks at the first and the last force with a complete branch; nothing without one."""
    complete = rows[rows["complete"]]
    if complete.empty:
        return ""
    peaks = peaks_of_coordinates(complete)
    sentences = peaks_in_words(peaks, complete["complete"])
    return _TEXT.peaks(sentences, ALL in peaks, is_untested(peaks))


class BeyondLimit(NamedTuple):
    """The force whose peak is farthest beyond a limit, what that means, and other such forces."""

    force: str
    problem: str
    others: str


def beyond_limits(peaks: pd.DataFrame) -> list[BeyondLimit]:
    """The limits of the model that peaks exceed."""
    beyond = []
    for limit, shares in _shares_of_limits(peaks).items():
        far = peaks["", "force_N"][shares > limit.tolerated]
        if problem := limit.told(shares.max()):
            farthest = far[shares.idxmax()]
            others = ", ".join(f"{force:g}" for force in far if force != farthest)
            beyond.append(BeyondLimit(f"{farthest:g}", problem, others))
    return beyond


def is_beyond(peaks: pd.DataFrame) -> pd.Series:
    """Whether each peak is beyond a limit of the model."""
    beyond = pd.Series(False, peaks.index)
    for limit, shares in _shares_of_limits(peaks).items():
        beyond |= shares > limit.tolerated
    return beyond


def _shares_of_limits(peaks: pd.DataFrame) -> dict[Limit, pd.Series]:
    """The share of each limit that is known which each peak reaches."""
    known = [limit for limit in LIMITS if REACHED[limit.name] in peaks]
    return {limit: peaks[REACHED[limit.name]] / 100 for limit in known}


def is_untested(peaks: pd.DataFrame) -> bool:
    """Whether all peaks with all harmonics are in a basis whose error is not known."""
    if ALL not in peaks:
        return False
    bars = peaks[ALL, "response_±_percent"].dropna()
    return bool(len(bars) and (bars == NOT_TESTED).all())


def peaks_in_words(peaks: pd.DataFrame, is_complete: pd.Series, unit: str = "N") -> str:
    """Some peaks: all of few, else the first, the last and that with the least response.

    ``is_complete`` tells of more rows by their labels whether branches cross their windows.
    """
    if peaks.empty:
        return ""
    response = peaks[ALL if ALL in peaks else SOLVED, "response_mm_per_N"]
    known = response.reset_index(drop=True).dropna()
    places = {0, len(peaks) - 1} | ({int(known.idxmin())} if len(known) else set())
    if len(peaks) <= _FEW:
        places = set(range(len(peaks)))
    lacks = is_untested(peaks)
    return "; ".join(
        peak_in_words(
            peaks.iloc[place],
            unit,
            is_complete=bool(is_complete.loc[peaks.index[place]]),
            lacks_basis_error=lacks,
        )
        for place in sorted(places)
    )
