"""Figures and tables of a page, each placed once."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import pandas as pd
from markupsafe import Markup

from boltjoint.report.pages.artefacts import ArtefactFile, figures_and_tables
from boltjoint.report.pages.document import Section
from boltjoint.report.pages.markup import (
    figure_with_caption,
    joined,
    source_reference,
    table_with_caption,
)
from boltjoint.study.published import Published
from boltjoint.study.tables import files as tables


@dataclass(frozen=True)
class StudyTable:
    """A table of the study: its artefact and its content."""

    artefact: ArtefactFile
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
        at, frame = anchor or self.artefact.anchor, self.frame if frame is None else frame
        return table_with_caption(frame, title, notes, at, self.artefact.address, groups)


class PageContent:
    """Figures and tables for a page, each of which is used up when it is placed.

    Parameters
    ----------
    files
        Figures, tables and the data that the page is made from.
    published
        The source, whose numbers of figures the captions give.
    """

    def __init__(self, files: Sequence[str], published: Published) -> None:
        self.published = published
        self.files = list(map(str, files))
        self._left = figures_and_tables(self.files)

    def files_named(self, ending: str) -> list[str]:
        """Files whose names have this ending."""
        return [path for path in self.files if path.endswith(ending)]

    def figures(self, kind: str, title: str, *notes: str, **values: object) -> Markup:
        """All figures of a kind that are left, as HTML; often one or none.

        Parameters
        ----------
        kind
            Such as ``response``.
        title, notes
            Caption. ``{subject}`` and ``{preload}`` in the title stand for those of the figure.
        values
            Values of further attributes: ``basis``, ``joint``, ``coordinates`` and so on.
        """
        found = self._take(kind, True, values)
        return joined(self._figure(each, title, notes) for each in found)

    def table(self, kind: str, **values: object) -> StudyTable | None:
        """The first table of a kind that is left, with these values."""
        found = self._take(kind, False, values, 1)
        return StudyTable(found[0], _read(found[0].path)) if found else None

    def remainder(self) -> list[Section]:
        """A section of the figures and tables that no other section has, if there are any."""
        left, self._left = self._left, []
        body = joined(
            self._figure(each, each.stem.replace("_", " "), ())
            if each.is_figure
            else StudyTable(each, _read(each.path)).html(each.stem.replace("_", " "))
            for each in left
        )
        return [Section("further", "Further figures and tables", body)] if body else []

    def _take(
        self, kind: str, is_figure: bool, values: dict[str, object], count: int | None = None
    ) -> list[ArtefactFile]:
        found = [
            each
            for each in self._left
            if (each.kind, each.is_figure) == (kind, is_figure)
            and all(getattr(each, name) == value for name, value in values.items())
        ][:count]
        self._left = [each for each in self._left if each not in found]
        return found

    def _figure(self, artefact: ArtefactFile, title: str, notes: Sequence[str]) -> Markup:
        preload = f"{artefact.preload_N or 0:.15g}"
        numbers = source_reference("Figure", artefact.in_source(self.published))
        return figure_with_caption(
            artefact.path,
            title.format(subject=artefact.subject, preload=preload),
            [*notes, numbers],
            artefact.address,
        )


def select(frame: pd.DataFrame, **values: object) -> pd.DataFrame:
    """Rows of a table that have these values."""
    keep = pd.Series(True, index=frame.index)
    for column, value in values.items():
        keep &= frame[column] == value
    return frame[keep]


def _read(path: str) -> pd.DataFrame:
    # 3.10 is not 3.1
    return tables.read(path, dtype={"source_table": str})
