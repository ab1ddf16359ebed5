"""What tables, figures and pages ask of a source that a study is compared with."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from markupsafe import Markup

if TYPE_CHECKING:
    import pandas as pd

    from boltjoint.config.study import Study
    from boltjoint.report.pages.document import Section
    from boltjoint.study.artefact_list import Artefact

_NOTHING = Markup()


@dataclass(frozen=True)
class Beside:
    """Columns and words of a source beside those of a table of a page.

    Parameters
    ----------
    columns
        Columns by their title.
    notes
        Paragraphs of the caption.
    statement
        Paragraphs below the table.
    """

    columns: Mapping[str, Sequence[str] | Mapping[str, str]] = field(default_factory=dict)
    notes: Sequence[str] = ()
    statement: Markup = _NOTHING


@dataclass(frozen=True)
class BesideElements:
    """The table of fitted elements as a page has it, with notes and the target of links to it."""

    frame: "pd.DataFrame"
    notes: Sequence[str] = ()
    anchor: str | None = None


class Comparison:
    """A study that is compared with no source; one that is overrides what it has to say."""

    @property
    def is_empty(self) -> bool:
        """Whether there is no source."""
        return True

    @property
    def has_case(self) -> bool:
        """Whether the source has the case at hand."""
        return False

    @property
    def reductions_of_time(self) -> tuple[str, str] | None:
        """Name and column, in the table of times, of the source's own reductions of time."""
        return None

    def words(self, place: str) -> Markup:
        """What is said of the source at a place of a page."""
        return Markup()

    def same_figures(self, artefact: "Artefact") -> Markup:
        """The paragraph of a caption that names the same figures of the source."""
        return Markup()

    def region_of_loops(self, joint: str) -> int:
        """The region of which hysteresis loops are drawn."""
        return 1

    def beside(self, artefact: "Artefact", table: "pd.DataFrame") -> "pd.DataFrame":
        """A table of the study with columns of the source."""
        return table

    def on_page(self, basis: str, table: "pd.DataFrame") -> "pd.DataFrame":
        """A table of results in a basis, with columns of the source where it has that basis."""
        return table

    def configuration(self, quantities: Iterable[tuple[str, str, str | None]]) -> Beside:
        """The column of the source beside quantities, their values here and their keys."""
        return Beside()

    def dimensions(self, assemblies: Iterable[str]) -> Beside:
        """The column of the source beside the dimensions of assemblies."""
        return Beside()

    def note(self, kind: str, table: "pd.DataFrame") -> str:
        """A paragraph of the caption of a table of this kind."""
        return ""

    def elements(
        self, artefact: "Artefact", table: "pd.DataFrame", preload: float
    ) -> BesideElements:
        """Fitted elements of a joint under a preload [N]."""
        return BesideElements(table)

    def times(self, basis: str, joint: str, table: "pd.DataFrame") -> Markup:
        """Solution times of a joint in a basis as the source arranges them."""
        return Markup()

    def time_saved(self, times: Mapping[tuple[str, str], "pd.DataFrame"]) -> Markup:
        """The time that reduced models save, here and in the source, by case and basis."""
        return Markup()

    def sections(self, study: "Study", artefacts: "Sequence[Artefact]") -> "list[Section]":
        """Sections of the overview about the source, with links to the figures and tables."""
        return []
