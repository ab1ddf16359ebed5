"""What the joints of a study do, in a few lines for the terminal at the end of a run."""

from pathlib import Path

from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_joint
from boltjoint.config.study import Study
from boltjoint.names import REFERENCE
from boltjoint.report.comparison import Comparison
from boltjoint.report.pages.case.calibration import calibration_answer
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.headline import summary
from boltjoint.study import layout
from boltjoint.study.response_list import headline_basis
from boltjoint.study.results import Results


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
    which = calibrated_joint(name, case)
    path = layout.path("calibration", **which)
    return calibration_answer(name, case, Results([path])) if Path(path).exists() else ""
