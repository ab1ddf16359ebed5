"""Figures and tables of a joint: its regions, and the fit of its elements."""

import pandas as pd
from markupsafe import Markup

from boltjoint.names import joint_in_words, parse_joint
from boltjoint.report.pages.case.basis import CaseBasis
from boltjoint.report.pages.case.responses import capitalize
from boltjoint.report.pages.content import StudyTable
from boltjoint.report.pages.markup import prose, source_reference

_TEXT = prose("case")


def joint_figures(basis: CaseBasis, joint: str) -> Markup:
    """How a joint is made: the place of its regions, and the fit of its elements."""
    parsed = parse_joint(joint)
    content = basis.content
    body = Markup()
    if parsed.division is not None:
        values = {"basis": basis.name, "joint": parsed.regions}
        words = capitalize(joint_in_words(parsed.regions))
        body += content.figures("regions", f"{words} on the contact", _TEXT.map(), **values)
        if table := content.table("regions", **values):
            body += table.html(words)
    if parsed.elements is not None:
        values = {"basis": basis.name, "joint": joint}
        region = content.published.region_of_loops(joint)
        body += content.figures(
            "loops",
            f"Hysteresis loops of region {region}",
            _TEXT.loops(parsed.elements, parsed.reduction == "elements"),
            **values,
        )
        if table := content.table("elements", **values):
            body += _elements(table, basis.without_published(table.frame))
    return body


def _elements(table: StudyTable, frame: pd.DataFrame) -> Markup:
    notes = ["In the order in which they start to slip."]
    anchor = None
    if "source_table" in frame:
        printed = frame["source_table"].iloc[0].split(" and ")
        sums = (frame[name].sum() for name in ("slip_force_N", "published_slip_force_N"))
        notes += [_TEXT.sums_of_slip_forces(*sums), source_reference("Table", printed)]
        anchor = f"table-{'-'.join(printed)}-{table.artefact.basis}"
        frame = frame.drop(columns="source_table")
    return table.html("Fitted elements", notes, ["region"], frame=frame, anchor=anchor)
