"""What a case has in one modal basis: its joints, its tables and its place on the page."""

from dataclasses import dataclass

from boltjoint.config.case import Case
from boltjoint.report.pages.content import PageContent, StudyTable


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

    def coordinates_by_joint(self, resonance: int) -> dict[str, list[str]]:
        """The joints solved around a resonance, and the coordinates in which each is solved."""
        coordinates_of: dict[str, list[str]] = {}
        for basis, joint, coordinates, at in self.case.responses:
            if (basis, at) == (self.name, resonance):
                coordinates_of.setdefault(joint, []).append(coordinates)
        return coordinates_of
