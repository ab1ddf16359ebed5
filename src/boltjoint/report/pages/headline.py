"""The answer of a case, which its pages and the terminal give first: peaks with error bars."""

import posixpath
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_joint
from boltjoint.config.study import Study
from boltjoint.harmonics import highest_harmonic, in_words
from boltjoint.names import REFERENCE
from boltjoint.report.comparison import Comparison
from boltjoint.report.displays.backbones import SECTION_OF_CALIBRATION
from boltjoint.report.pages.content import PageContent, select
from boltjoint.report.pages.document import prose, table_with_caption
from boltjoint.structure.limits import LIMITS, STRESS, Limit
from boltjoint.study import layout
from boltjoint.study.response_list import headline_basis
from boltjoint.study.results import Results
from boltjoint.study.tables.html import number

#: peaks that a sentence tells all of
_FEW = 4

#: share of the way from sticking to no contact by which slip shows in the natural frequency
SHOWS = 0.01


@dataclass(frozen=True)
class NonlinearMode:
    """Landmarks of a backbone.

    Parameters
    ----------
    slip_level
        Excitation level from which slip shows: the natural frequency has left that of the sticking
        joint by ``SHOWS`` of the way to that without contact; None where it never does, or already
        at the first state.
    largest_damping
        The largest damping ratio.
    amplitude
        Amplitude of the output point at that damping [m].
    level
        Excitation level whose peak has that amplitude.
    harmonics
        Harmonics of its motions.
    """

    slip_level: float | None
    largest_damping: float
    amplitude: float
    level: float
    harmonics: int

    @classmethod
    def of(cls, backbone: xr.Dataset, between: tuple[float, float]) -> "NonlinearMode | None":
        """The landmarks of ``backbone.nc``; None where it has no states.

        Parameters
        ----------
        backbone
            ``backbone.nc``.
        between
            Resonance without contact and while nothing slips [Hz].
        """
        frequency = backbone["natural_frequency"].to_numpy()
        level = backbone["peak_force"].to_numpy()
        damping = backbone["damping_ratio"].to_numpy()
        if not frequency.size:
            return None
        gone = np.abs(frequency - between[1]) / abs(between[1] - between[0])
        slips = np.flatnonzero(gone > SHOWS)
        slip_level = None
        if slips.size and slips[0] > 0:
            ends = slice(slips[0] - 1, slips[0] + 1)
            slip_level = float(np.exp(np.interp(SHOWS, gone[ends], np.log(level[ends]))))
        most = int(np.argmax(damping))
        amplitude = float(backbone["response_amplitude"][most])
        harmonics = highest_harmonic(backbone)
        return cls(slip_level, float(damping[most]), amplitude, float(level[most]), harmonics)


def nonlinear_mode(
    results: Results, case: str, basis: str, resonance: int, between: tuple[float, float] | None
) -> NonlinearMode | None:
    """The landmarks of the node-to-node joint of a case; None where its backbone is not known."""
    fields = {"case": case, "basis": basis, "joint": REFERENCE[0], "resonance": resonance}
    if between is None or not results.has("backbone", **fields):
        return None
    return NonlinearMode.of(results.dataset("backbone", **fields), between)


_TEXT_OF_CASE = prose("case")


def calibration_answer(name: str, case: Case, results: Results) -> str:
    """The answer of a calibration in sentences; empty of a case without one."""
    if case.measured is None or not results.has("calibration", **calibrated_joint(name, case)):
        return ""
    return str(results.dataset("calibration", **calibrated_joint(name, case)).attrs["answer"])


def calibration_section(name: str, case: Case, content: PageContent) -> Markup:
    """Figure and tables of a calibration; empty of a case without one."""
    if case.measured is None:
        return Markup()
    file = layout.path("fitted_case", **calibrated_joint(name, case))
    here = posixpath.dirname(layout.page(name))
    return _TEXT_OF_CASE.calibration(posixpath.relpath(file, here), file) + content.section(
        SECTION_OF_CALIBRATION
    )


_TEXT = prose("headline")

#: headings above the columns of the peaks
ALL, SOLVED = "peak with all harmonics", "as solved"

#: columns of the shares of limits that are reached at the peak
REACHED = {
    limit.name: ("reached at the peak", f"{limit.name.replace('_over_', '_of_')}_percent")
    for limit in LIMITS
}

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


def summary(name: str, case: Case, accuracy: pd.DataFrame, content: PageContent) -> Markup:
    """Sentence on a case: where it resonates, and its peaks at the ends of its forces.

    Parameters
    ----------
    name, case
        The case.
    accuracy
        The table of its accuracy in ``headline_basis``.
    content
        Content of a page that has its node-to-node joint, and the backbone where there is one.
    """
    basis = headline_basis(case)
    resonance = case.resonances(basis)[0]
    peaks = peaks_of_reference(accuracy, resonance)
    between = content.resonance_range(name, basis, resonance)
    unit = "m/s²" if case.is_base_excited else "N"
    sentences = _peaks_in_words(peaks, accuracy["complete"], unit)
    told = sentences, _is_untested(peaks), ALL in peaks, _beyond_limits(peaks)
    mode = nonlinear_mode(content.results, name, basis, resonance, between)
    of_mode = in_words([mode.harmonics]) if mode else ""
    return _TEXT.summary(resonance, between, *told, unit, mode, of_mode)


def headline(name: str, case: Case, accuracy: pd.DataFrame, content: PageContent) -> Markup:
    """Table of the peaks of a case in its most trusted basis, with what their bars hold.

    Nothing of a case whose node-to-node joint is not solved in linear modes.
    """
    basis = headline_basis(case)
    peaks = peaks_of_reference(accuracy, case.resonances(basis)[0])
    if peaks.empty:
        return Markup()
    estimate = accuracy.get("basis_amplitude_error_percent", pd.Series(dtype=float)).max()
    notes = _TEXT.bars(basis, None if pd.isna(estimate) else number(estimate, 2), ALL in peaks)
    beyond = _is_beyond(peaks)
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
    sentences = _peaks_in_words(peaks, complete["complete"])
    return _TEXT.peaks(sentences, ALL in peaks, _is_untested(peaks))


def _beyond_limits(peaks: pd.DataFrame) -> list[tuple[str, str]]:
    """Forces whose peaks are beyond a limit of the model, and what that means."""
    beyond = []
    for limit, shares in _shares_of_limits(peaks).items():
        far = peaks["", "force_N"][shares > limit.tolerated]
        if problem := limit.told(shares.max()):
            beyond.append((", ".join(f"{force:g}" for force in far), problem))
    return beyond


def _is_beyond(peaks: pd.DataFrame) -> pd.Series:
    """Whether each peak is beyond a limit of the model."""
    beyond = pd.Series(False, peaks.index)
    for limit, shares in _shares_of_limits(peaks).items():
        beyond |= shares > limit.tolerated
    return beyond


def _shares_of_limits(peaks: pd.DataFrame) -> dict[Limit, pd.Series]:
    """The share of each limit that is known which each peak reaches."""
    known = [limit for limit in LIMITS if REACHED[limit.name] in peaks]
    return {limit: peaks[REACHED[limit.name]] / 100 for limit in known}


def _is_untested(peaks: pd.DataFrame) -> bool:
    """Whether all peaks with all harmonics are in a basis whose error is not known."""
    if ALL not in peaks:
        return False
    bars = peaks[ALL, "response_±_percent"].dropna()
    return bool(len(bars) and (bars == NOT_TESTED).all())


def _peaks_in_words(peaks: pd.DataFrame, is_complete: pd.Series, unit: str = "N") -> str:
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
    lacks = _is_untested(peaks)
    return "; ".join(
        peak_in_words(
            peaks.iloc[place],
            unit,
            is_complete=bool(is_complete.loc[peaks.index[place]]),
            lacks_basis_error=lacks,
        )
        for place in sorted(places)
    )


def answers(study: Study) -> str:
    """A line for each case whose peaks are known, and the page to open.

    Parameters
    ----------
    study
        Whose files are sought in the working directory.
    """
    lines = []
    for name, case in study.cases.items():
        if fitted := _fitted(name, case):
            lines.append(f"{name}: {fitted}")
        of_basis = {"case": name, "basis": headline_basis(case)}
        joint = layout.path("joint", **of_basis, joint=REFERENCE[0])
        table = layout.shown("table", "accuracy", **of_basis)
        if not (Path(table).exists() and Path(joint).exists()):
            continue
        backbone = layout.path(
            "backbone",
            **of_basis,
            joint=REFERENCE[0],
            resonance=case.resonances(of_basis["basis"])[0],
        )
        results = Results([joint, table, *filter(lambda path: Path(path).exists(), [backbone])])
        accuracy = results.table("accuracy", **of_basis)
        if len(accuracy):
            content = PageContent([], results, Comparison())
            said = " ".join(summary(name, case, accuracy, content).striptags().split())
            lines.append(f"{name} ({of_basis['basis']}): {said}")
    if Path(layout.OVERVIEW).exists():
        lines.append(f"Open {layout.OVERVIEW}")
    return "\n".join(lines)


def _fitted(name: str, case: Case) -> str:
    """The answer of the calibration of a case, where it has been made."""
    if case.measured is None:
        return ""
    fields = calibrated_joint(name, case)
    path = layout.path("calibration", **fields)
    return calibration_answer(name, case, Results([path])) if Path(path).exists() else ""
