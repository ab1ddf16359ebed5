"""The answer of a case in sentences, which its pages and the terminal give first.

The peaks it tells are those of ``report.pages.peaks``, which has their table.
"""

import posixpath
import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_joint
from boltjoint.config.study import Study
from boltjoint.harmonics import highest_harmonic, in_words
from boltjoint.names import REFERENCE
from boltjoint.number_format import number
from boltjoint.report.comparison import Comparison
from boltjoint.report.displays.backbones import SECTION_OF_CALIBRATION
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.document import prose
from boltjoint.report.pages.peaks import (
    ALL,
    LARGE_BASIS_ERROR,
    NOT_TESTED,
    SOLVED,
    basis_error,
    beyond_limits,
    is_beyond,
    is_untested,
    peaks_in_words,
    peaks_of_reference,
)
from boltjoint.study import layout
from boltjoint.study.response_list import headline_basis
from boltjoint.study.stage_inputs import Results

_TEXT, _TEXT_OF_CASE = prose("answer"), prose("case")

#: between two sentences
SENTENCE_END = re.compile(r"(?<=\.) (?=[A-Z])")

#: column of the lowest force whose peak is beyond a limit of the model
BEYOND_FROM = "limits", "beyond_from"

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


def calibration_answer(name: str, case: Case, results: Results) -> str:
    """The answers of a calibration and its prediction; empty of a case without one."""
    if case.measured is None:
        return ""
    fields = calibrated_joint(name, case)
    kinds = ("calibration", "prediction") if case.measured.predicted else ("calibration",)
    return " ".join(
        str(results.dataset(kind, **fields).attrs["answer"])
        for kind in kinds
        if results.has(kind, **fields)
    )


def calibration_section(name: str, case: Case, content: PageContent) -> Markup:
    """Figure and tables of a calibration; empty of a case without one."""
    if case.measured is None:
        return Markup()
    file = layout.path("fitted_case", **calibrated_joint(name, case))
    here = posixpath.dirname(layout.page(name))
    return _TEXT_OF_CASE.calibration(posixpath.relpath(file, here), file) + content.section(
        SECTION_OF_CALIBRATION
    )


class _Headline(NamedTuple):
    """The first resonance of a case in ``headline_basis``, and the unit of its excitation."""

    resonance: int
    between: tuple[float, float] | None
    mode: NonlinearMode | None
    unit: str


def _headline(name: str, case: Case, content: PageContent) -> _Headline:
    basis = headline_basis(case)
    resonance = case.resonances(basis)[0]
    between = content.resonance_range(name, basis, resonance)
    mode = nonlinear_mode(content.results, name, basis, resonance, between)
    return _Headline(resonance, between, mode, "m/s²" if case.is_base_excited else "N")


def summary(name: str, case: Case, accuracy: pd.DataFrame, content: PageContent) -> Markup:
    """Sentences on a case: where it resonates, when it slips, its damping, and its peaks.

    Parameters
    ----------
    name, case
        The case.
    accuracy
        The table of its accuracy in ``headline_basis``.
    content
        Content of a page that has its node-to-node joint, and backbone and calibration where there
        are any.
    """
    resonance, between, mode, unit = _headline(name, case, content)
    peaks = peaks_of_reference(accuracy, resonance)
    sentences = peaks_in_words(peaks, accuracy["complete"], unit)
    told = sentences, is_untested(peaks), ALL in peaks, beyond_limits(peaks)
    of_mode = in_words([mode.harmonics]) if mode else ""
    of_basis = basis_error(accuracy) > LARGE_BASIS_ERROR
    is_fitted = case.measured is not None and content.results.has(
        "calibration", **calibrated_joint(name, case)
    )
    return _TEXT.summary(resonance, between, *told, unit, mode, of_mode, of_basis, is_fitted)


def answer_in_columns(
    name: str, case: Case, accuracy: pd.DataFrame, content: PageContent
) -> dict[tuple[str, str], object]:
    """What ``summary`` tells of a case, and its peaks at two forces, as a row of a table.

    The forces are the lowest and the highest at which the peak is within the limits of the model.
    """
    resonance, between, mode, unit = _headline(name, case, content)

    def level(value: float | None, digits: int = 2) -> object:
        return None if value is None else f"{number(value, digits)} {unit}"

    row: dict[tuple[str, str], object] = {
        ("resonance", "sticking_Hz"): between[1] if between else None,
        ("resonance", "no_contact_Hz"): between[0] if between else None,
        ("friction", "slip_from"): level(mode.slip_level if mode else None, 1),
        ("friction", "largest_damping_percent"): 100 * mode.largest_damping if mode else None,
        ("friction", "near"): level(mode.level if mode else None),
    }
    peaks = peaks_of_reference(accuracy, resonance)
    beyond = is_beyond(peaks)
    within, forces = peaks[~beyond], peaks["", "force_N"][beyond]
    under = ALL if ALL in peaks else SOLVED
    for span, place in (("lowest", 0), ("highest", -1)):
        if len(within) <= abs(place):
            break
        heading, at = f"peak at the {span} force within the limits", within.iloc[place]
        row[heading, "force"] = f"{at['', 'force_N']:g} {unit}"
        for what, of_what in (("frequency", "Hz"), ("response", "mm_per_N")):
            row[heading, f"{what}_{of_what}"] = at[under, f"{what}_{of_what}"]
            bar = f"{what}_±_percent"
            unknown = None if pd.isna(at[under, f"{what}_{of_what}"]) else NOT_TESTED
            row[heading, bar] = at[under, bar] if under == ALL else unknown
    row[BEYOND_FROM] = f"{forces.min():g} {unit}" if len(forces) else None
    return row


def answers(study: Study, folder: str = "") -> str:
    """What is known of each case, a sentence a line, and the page to open.

    Parameters
    ----------
    study
        Whose files are sought in the working directory.
    folder
        The working directory, as a user who stands elsewhere names it.
    """
    lines = []
    for name, case in study.cases.items():
        of_fit = _files_of_fit(name, case)
        if fitted := calibration_answer(name, case, Results(of_fit)):
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
        backbones = [path for path in [backbone] if Path(path).exists()]
        results = Results([joint, table, *backbones, *of_fit])
        accuracy = results.table("accuracy", **of_basis)
        if len(accuracy):
            content = PageContent([], results, Comparison())
            said = " ".join(summary(name, case, accuracy, content).striptags().split())
            sentences = "\n".join(SENTENCE_END.split(said))
            lines.append(f"{name} ({of_basis['basis']}): {sentences}")
    if Path(layout.OVERVIEW).exists():
        lines.append(f"Open {Path(folder, layout.OVERVIEW)}")
    return "\n".join(lines)


def _files_of_fit(name: str, case: Case) -> list[str]:
    """Calibration and prediction of a case that have been made."""
    if case.measured is None:
        return []
    fields = calibrated_joint(name, case)
    paths = [layout.path(kind, **fields) for kind in ("calibration", "prediction")]
    return [path for path in paths if Path(path).exists()]
