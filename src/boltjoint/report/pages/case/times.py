"""Solution times of a case, and those of the source beside them."""

import pandas as pd
from markupsafe import Markup

from boltjoint.names import REFERENCE, coordinates_in_words, joint_in_words
from boltjoint.report.pages.case.basis import CaseBasis
from boltjoint.report.pages.case.responses import side_by_side
from boltjoint.report.pages.content import select
from boltjoint.report.pages.markup import joined, prose, source_reference, table_with_caption

_TEXT = prose("case")


def published_times(basis: CaseBasis, joint: str) -> Markup:
    """Times of a joint beside those that the source prints, in the source's arrangement."""
    if not basis.is_published or basis.times is None or "source_table" not in basis.times.frame:
        return Markup()
    of_joint = select(basis.times.frame, joint=joint).dropna(subset="source_table")
    body = Markup()
    for printed, of_table in of_joint.groupby("source_table", sort=False):
        parts = {
            coordinates_in_words(coordinates): _beside_published(
                rows.set_index("force_N"), (joint, coordinates) == REFERENCE
            )
            for coordinates, rows in of_table.groupby("coordinates", sort=False)
        }
        body += table_with_caption(
            side_by_side(parts),
            f"Solution times: {joint_in_words(joint)}",
            [_TEXT.published_times(), source_reference("Table", [str(printed)])],
            anchor=f"table-{printed}-{basis.name}",
        )
    return body


def _beside_published(times: pd.DataFrame, is_reference: bool) -> pd.DataFrame:
    columns = {}
    if times["published_s"].notna().any():
        columns |= {"here_s": times["cpu_forward_difference_s"], "source_s": times["published_s"]}
    if not is_reference:
        columns |= {
            "reduction_here_percent": times["reduction_forward_difference_percent"],
            "reduction_in_source_percent": times["published_reduction_percent"],
        }
    return pd.DataFrame(columns)


def solution_times(basis: CaseBasis) -> Markup:
    """Times of all responses, as figures and as a table."""
    if basis.times is None:
        return Markup()
    figures = joined(
        basis.content.figures(
            "times",
            f"Solution times around resonance {resonance}",
            _TEXT.times_figure(),
            basis=basis.name,
            resonance=resonance,
        )
        for resonance in basis.case.resonances(basis.name)
    )
    groups, frame = ["joint", "coordinates", "resonance"], basis.times.frame
    table = basis.times.html("Every response", groups=groups, frame=basis.without_published(frame))
    return _TEXT.times() + figures + table
