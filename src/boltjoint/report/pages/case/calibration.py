"""What a case says of the joint that is fitted to its measurement."""

import posixpath

from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_joint
from boltjoint.report.displays.calibration import SECTION
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.markup import prose
from boltjoint.study import layout
from boltjoint.study.results import Results

_TEXT = prose("case")


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
    return _TEXT.calibration(posixpath.relpath(file, here), file) + content.section(SECTION)
