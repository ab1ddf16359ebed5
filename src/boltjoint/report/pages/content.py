"""Figures and tables of a page, each placed once."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import pandas as pd
from markupsafe import Markup

from boltjoint.names import REFERENCE
from boltjoint.report.pages.document import Section
from boltjoint.report.pages.markup import (
    figure_with_caption,
    joined,
    source_reference,
    table_with_caption,
)
from boltjoint.report.pages.references import address_of, anchor_of, figures_in_source, stem_of
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.published import Published
from boltjoint.study.results import Results


@dataclass(frozen=True)
class StudyTable:
    """A table of the study: its artefact and its content."""

    artefact: Artefact
    frame: pd.DataFrame

    def html(
        self,
        title: str,
        notes: Iterable[str] = (),
        groups: Sequence[str] = (),
        *,
        frame: pd.DataFrame | None = None,
        anchor: str | None = None,
    ) -> Markup:
        """The table with its caption, or what of it another frame holds; it links to the file."""
        anchor, frame = anchor or anchor_of(self.artefact), self.frame if frame is None else frame
        return table_with_caption(frame, title, notes, anchor, address_of(self.artefact), groups)


class PageContent:
    """Figures and tables for a page, each of which is used up when it is placed.

    Parameters
    ----------
    artefacts
        The figures and tables.
    results
        The tables and the data that the page is made from.
    published
        The source, whose numbers of figures the captions give.
    """

    def __init__(
        self, artefacts: Sequence[Artefact], results: Results, published: Published
    ) -> None:
        self.published = published
        self.results = results
        self._left = list(artefacts)

    def friction_elements(self, case: str, basis: str) -> int | None:
        """The number of friction elements of the node-to-node joint; None where it is unknown."""
        which = {"case": case, "basis": basis, "joint": REFERENCE[0]}
        if not self.results.has("joint", **which):
            return None
        return self.results.dataset("joint", **which).sizes["element"]

    def figures(self, kind: str, title: str, *notes: str, **values: object) -> Markup:
        """All figures of a kind that are left, as HTML; often one or none.

        Parameters
        ----------
        kind
            Such as ``response``.
        title, notes
            Caption. Fields of the figure stand in the title as ``{assembly}``.
        values
            Values of further fields: ``basis``, ``joint``, ``coordinates`` and so on.
        """
        found = self._take("figure", kind, values)
        return joined(self._figure(each, title, notes) for each in found)

    def table(self, kind: str, **values: object) -> StudyTable | None:
        """The first table of a kind that is left, with these values."""
        found = self._take("table", kind, values, 1)
        return self._table(found[0]) if found else None

    def remainder(self) -> list[Section]:
        """A section of the figures and tables that no other section has, if there are any."""
        left, self._left = self._left, []
        body = joined(
            self._figure(each, stem_of(each).replace("_", " "), ())
            if each.form == "figure"
            else self._table(each).html(stem_of(each).replace("_", " "))
            for each in left
        )
        return [Section("further", "Further figures and tables", body)] if body else []

    def _take(
        self, form: str, kind: str, values: dict[str, object], count: int | None = None
    ) -> list[Artefact]:
        found = [
            each
            for each in self._left
            if (each.form, each.kind) == (form, kind)
            and all(getattr(each, name) == value for name, value in values.items())
        ][:count]
        self._left = [each for each in self._left if each not in found]
        return found

    def _table(self, artefact: Artefact) -> StudyTable:
        return StudyTable(artefact, self.results.table(artefact.kind, **artefact.which))

    def _figure(self, artefact: Artefact, title: str, notes: Sequence[str]) -> Markup:
        numbers = source_reference("Figure", figures_in_source(artefact, self.published))
        title = title.format(**artefact.which)
        return figure_with_caption(artefact.path, title, [*notes, numbers], address_of(artefact))


def select(frame: pd.DataFrame, **values: object) -> pd.DataFrame:
    """Rows of a table that have these values."""
    keep = pd.Series(True, index=frame.index)
    for column, value in values.items():
        keep &= frame[column] == value
    return frame[keep]
