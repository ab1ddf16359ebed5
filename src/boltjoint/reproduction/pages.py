"""What pages ask of the source: apart, since jobs of figures and tables need no pages."""

from collections.abc import Mapping, Sequence

import pandas as pd
from markupsafe import Markup

from boltjoint.config.study import Study
from boltjoint.report.pages.document import Section
from boltjoint.reproduction import index, solution_times
from boltjoint.reproduction.comparison import ThesisComparison
from boltjoint.reproduction.published import BASIS
from boltjoint.study.artefact_list import Artefact


class PagesBesideThesis(ThesisComparison):
    """Pages of a study that is compared with the thesis."""

    def times(self, basis: str, joint: str, table: pd.DataFrame) -> Markup:
        """Times of a joint beside those that the source prints, in its arrangement."""
        return solution_times.beside_published(joint, table) if basis == BASIS else Markup()

    def time_saved(self, times: Mapping[tuple[str, str], pd.DataFrame]) -> Markup:
        """The time that reduced models save, here and in the source, by case and basis."""
        return solution_times.time_saved(
            {case: table for (case, basis), table in times.items() if basis == BASIS}
        )

    def sections(self, study: Study, artefacts: Sequence[Artefact]) -> list[Section]:
        """Indices of the source's tables and figures."""
        return index.sections(study, artefacts, self.published)
