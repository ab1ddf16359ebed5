"""Figures and tables of a page, each placed once, with their addresses and common statements."""

import posixpath
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import pandas as pd
from markupsafe import Markup

from boltjoint.harmonics import in_words
from boltjoint.names import REFERENCE
from boltjoint.number_format import number
from boltjoint.report.comparison import Comparison
from boltjoint.report.displays import DISPLAYS
from boltjoint.report.pages.document import (
    Section,
    figure_with_caption,
    joined,
    prose,
    table_with_caption,
)
from boltjoint.study import layout
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.stage_inputs import Results

#: any page of the report: all lie in one folder
_PAGE = layout.page("overview")


def stem_of(artefact: Artefact) -> str:
    """The name of the file without its ending."""
    return PurePosixPath(artefact.path).stem


def anchor_of(artefact: Artefact) -> str:
    """The target of links on its page, where a figure and a table may have one name."""
    return stem_of(artefact) if artefact.form == "figure" else f"{stem_of(artefact)}-table"


def page_of(artefact: Artefact) -> str:
    """The page that shows a figure or table: of a case, or one of ``names.PAGES``."""
    return DISPLAYS.of(artefact).page_of(artefact)


def address_of(artefact: Artefact) -> str:
    """The file, seen from a page."""
    return posixpath.relpath(artefact.path, posixpath.dirname(layout.page(page_of(artefact))))


def address_of_sweep(name: str) -> str:
    """The interactive page of a sweep, seen from a page."""
    return posixpath.relpath(layout.path("sweep_page", sweep=name), posixpath.dirname(_PAGE))


@dataclass(frozen=True)
class StudyTable:
    """A table of the study: its artefact and its content."""

    artefact: Artefact
    frame: pd.DataFrame

    def html(
        self,
        title: str = "",
        notes: Iterable[str] = (),
        groups: Sequence[str] = (),
        *,
        frame: pd.DataFrame | None = None,
        anchor: str | None = None,
    ) -> Markup:
        """The table with its caption, or what of it another frame holds; it links to the file.

        The title is that which is declared with the table, unless one is given; it names the basis,
        and on a page of several cases the case.
        """
        title = title or capitalize(DISPLAYS.of(self.artefact).title_of(self.artefact))
        title += self._where(title)
        anchor, frame = anchor or anchor_of(self.artefact), self.frame if frame is None else frame
        return table_with_caption(frame, title, notes, anchor, address_of(self.artefact), groups)

    def _where(self, title: str) -> str:
        """The basis and the case of the table, as far as a title does not name them."""
        artefact, where = self.artefact, ""
        if artefact.basis and artefact.basis not in title:
            where += f" in {artefact.basis}"
        is_of_several = DISPLAYS.of(artefact).page_of(artefact) != artefact.case
        if is_of_several and artefact.case and artefact.case not in title:
            where += f": {artefact.case}"
        return where


class PageContent:
    """Figures and tables for a page, each of which is used up when it is placed.

    Parameters
    ----------
    artefacts
        The figures and tables.
    results
        The tables and the data that the page is made from.
    comparison
        The source that the study is compared with.
    """

    def __init__(
        self, artefacts: Sequence[Artefact], results: Results, comparison: Comparison
    ) -> None:
        self.comparison = comparison
        self.results = results
        self._left = list(artefacts)

    def friction_elements(self, case: str, basis: str) -> int | None:
        """The number of friction elements of the node-to-node joint; None where it is unknown."""
        fields = {"case": case, "basis": basis, "joint": REFERENCE[0]}
        if not self.results.has("joint", **fields):
            return None
        return self.results.dataset("joint", **fields).sizes["element"]

    def resonance_range(self, case: str, basis: str, resonance: int) -> tuple[float, float] | None:
        """A resonance without contact and while nothing slips [Hz]; None where it is unknown."""
        fields = {"case": case, "basis": basis, "joint": REFERENCE[0]}
        if not self.results.has("joint", **fields):
            return None
        between = self.results.dataset("joint", **fields)["resonance_range"].to_numpy()
        return tuple(between[resonance - 1].tolist())

    def figures(self, kind: str, *notes: str, title: str = "", **values: object) -> Markup:
        """All figures of a kind that are left, as HTML; often one or none.

        Parameters
        ----------
        kind
            Such as ``response``.
        notes, title
            Caption, where it is not that which is declared with the figure.
        values
            Values of fields: ``basis``, ``joint``, ``coordinates`` and so on.
        """
        artefacts = self._take("figure", kind, values)
        return joined(self._figure(artefact, title, notes) for artefact in artefacts)

    def section(self, anchor: str, **values: object) -> Markup:
        """The figures and tables declared for a section that are left, with these values."""
        artefacts = [
            artefact
            for artefact in self._left
            if DISPLAYS.of(artefact).section == anchor
            and all(getattr(artefact, name) == value for name, value in values.items())
        ]
        self._left = [artefact for artefact in self._left if artefact not in artefacts]
        return self._as_declared(artefacts)

    def table(self, kind: str, **values: object) -> StudyTable | None:
        """The first table of a kind that is left, with these values."""
        artefacts = self._take("table", kind, values, 1)
        return self._table(artefacts[0]) if artefacts else None

    def remainder(self) -> list[Section]:
        """Sections of the figures and tables that no other section has, by where they belong."""
        anchors = dict.fromkeys(DISPLAYS.of(anchor).section for anchor in self._left)
        titles = {anchor: capitalize(anchor.replace("-", " ")) for anchor in anchors}
        titles |= {"further": "Further figures and tables"}
        return [Section(anchor, titles[anchor], self.section(anchor)) for anchor in anchors]

    def _as_declared(self, artefacts: Sequence[Artefact]) -> Markup:
        ordered = sorted(artefacts, key=lambda artefact: DISPLAYS.of(artefact).order)
        return joined(
            self._figure(artefact) if artefact.form == "figure" else self._declared_table(artefact)
            for artefact in ordered
        )

    def _declared_table(self, artefact: Artefact) -> Markup:
        return self._table(artefact).html(notes=[DISPLAYS.of(artefact).caption_of(artefact)])

    def _take(
        self, form: str, kind: str, values: dict[str, Any], count: int | None = None
    ) -> list[Artefact]:
        artefacts = [
            artefact
            for artefact in self._left
            if (artefact.form, artefact.kind) == (form, kind)
            and all(getattr(artefact, name) == value for name, value in values.items())
        ][:count]
        self._left = [artefact for artefact in self._left if artefact not in artefacts]
        return artefacts

    def _table(self, artefact: Artefact) -> StudyTable:
        return StudyTable(artefact, self.results.table(artefact.kind, **artefact.fields))

    def _figure(self, artefact: Artefact, title: str = "", notes: Sequence[str] = ()) -> Markup:
        display = DISPLAYS.of(artefact)
        notes = notes or [display.caption_of(artefact)]
        title = title or display.title_of(artefact)
        notes = [*notes, self.comparison.same_figures(artefact)]
        return figure_with_caption(artefact.path, title, notes, address_of(artefact))


def capitalize(words: str) -> str:
    """The same words, the first with a capital."""
    return words[:1].upper() + words[1:]


def select(frame: pd.DataFrame, **values: object) -> pd.DataFrame:
    """Rows of a table that have these values."""
    keep = pd.Series(True, index=frame.index)
    for column, value in values.items():
        keep &= frame[column] == value
    return frame[keep]


#: residual in time below which the error of the time integration is larger
RESOLUTION_IN_TIME = 1e-6

_ERROR = "peak_amplitude_error_percent"
_BASIS = "basis_amplitude_error_percent"
_LEFT_OUT = "amplitude_truncation_error_percent"


def reference_statement(content: PageContent, has_adapted: bool) -> Markup:
    """The reference of all errors, what is known of its own, and what few harmonics leave out.

    It takes the tables of peaks with more harmonics from the content: those of contact-adapted
    bases count, where there are any. ``has_adapted`` where the study has such a basis.
    """
    tables = []
    while table := content.table("harmonic_peaks"):
        tables.append(table)
    adapted = [
        table
        for table in tables
        if table.artefact.basis is not None and table.artefact.basis.is_contact_adapted
    ]
    peaks = pd.concat(
        [pd.DataFrame(columns=["force_N", "harmonics", _ERROR, _BASIS, _LEFT_OUT])]
        + [table.frame for table in (adapted if has_adapted else tables)]
    )
    fewest = with_fewest_harmonics(peaks)
    forces = sorted(fewest.dropna(subset=_ERROR)["force_N"].unique())
    return prose("statements").reference(
        has_adapted,
        *(_largest(peaks, column) for column in (_BASIS, _LEFT_OUT)),
        in_words(fewest["harmonics"]),
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


def format_residual_in_time(residual: float) -> str | None:
    """A residual in time as a cell of a table, no smaller than its resolution.

    >>> format_residual_in_time(3e-7), format_residual_in_time(2.5e-4)
    ('below 10⁻⁶', '0.00025')
    """
    if pd.isna(residual):
        return None
    return "below 10⁻⁶" if residual <= RESOLUTION_IN_TIME else number(residual, 2)
