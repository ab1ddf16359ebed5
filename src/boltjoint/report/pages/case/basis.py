"""What a case has in one modal basis: its joints, its tables and its place on the page."""

from dataclasses import dataclass

import pandas as pd

from boltjoint.config.case import Case
from boltjoint.report.pages.content import PageContent, StudyTable
from boltjoint.study.published import BASIS

#: columns beside those called ``published_...`` that hold or compare published values
_BESIDE_PUBLISHED = ("source_table", "k_ratio", "slip_force_ratio", "difference_points")


@dataclass(frozen=True)
class CaseBasis:
    """A case in one modal basis.

    Parameters
    ----------
    case
        As configured.
    name
        Of the basis, such as ``free-4``.
    content
        Figures and tables of the page.
    accuracy, times
        Tables of all responses in this basis, None where the study has none.
    """

    case: Case
    name: str
    content: PageContent
    accuracy: StudyTable | None
    times: StudyTable | None

    @classmethod
    def of(cls, case: Case, name: str, content: PageContent) -> "CaseBasis":
        """The case in the basis of this name; it takes two tables from the content."""
        accuracy, times = (content.table(kind, basis=name) for kind in ("accuracy", "times"))
        return cls(case, name, content, accuracy, times)

    @property
    def is_compared(self) -> bool:
        """Whether the case is compared with one of the source."""
        return self.content.published.case is not None

    @property
    def is_published(self) -> bool:
        """Whether it is the basis of the source."""
        return self.name == BASIS

    def coordinates_by_joint(self, resonance: int) -> dict[str, list[str]]:
        """The joints solved around a resonance, and the coordinates in which each is solved."""
        found: dict[str, list[str]] = {}
        for basis, joint, coordinates, at in self.case.responses:
            if (basis, at) == (self.name, resonance):
                found.setdefault(joint, []).append(coordinates)
        return found

    def without_published(self, frame: pd.DataFrame) -> pd.DataFrame:
        """A table without published values, unless this is the basis of the source."""
        if self.is_published:
            return frame
        published = [column for column in frame if column.startswith("published_")]
        return frame.drop(columns=[*published, *_BESIDE_PUBLISHED], errors="ignore")
