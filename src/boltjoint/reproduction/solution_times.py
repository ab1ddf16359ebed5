"""Solution times, and the time that reduced models save, as the source arranges them."""

from collections.abc import Mapping

import pandas as pd
from markupsafe import Markup

from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.report.pages.case.joints import side_by_side
from boltjoint.report.pages.markup import link, table_with_caption
from boltjoint.reproduction.published import BASIS
from boltjoint.reproduction.words import numbers_in_source, thesis


def beside_published(joint: str, times: pd.DataFrame) -> Markup:
    """Times of a joint beside those that the source prints, a table for each of its tables.

    Parameters
    ----------
    joint
        Name of the joint.
    times
        Times of every response in the basis of the source, with published ones.
    """
    if "source_table" not in times:
        return Markup()
    of_joint = times[times["joint"] == joint].dropna(subset="source_table")
    body = Markup()
    for printed, of_table in of_joint.groupby("source_table", sort=False):
        parts = {
            Coordinates(coordinates).label: _here_and_there(
                rows.set_index("force_N"), is_reference=(joint, coordinates) == REFERENCE
            )
            for coordinates, rows in of_table.groupby("coordinates", sort=False)
        }
        body += table_with_caption(
            side_by_side(parts),
            f"Solution times: {JointName(joint).label} (table {printed})",
            [thesis().times(), numbers_in_source("Table", [str(printed)])],
            anchor=f"table-{printed}-{BASIS}",
        )
    return body


def _here_and_there(times: pd.DataFrame, *, is_reference: bool) -> pd.DataFrame:
    columns: dict[str, pd.Series] = {}
    if times["published_s"].notna().any():
        columns |= {"here_s": times["cpu_forward_difference_s"], "source_s": times["published_s"]}
    if not is_reference:
        columns |= {
            "reduction_here_percent": times["reduction_forward_difference_percent"],
            "reduction_in_source_percent": times["published_reduction_percent"],
        }
    return pd.DataFrame(columns)


def time_saved(times: Mapping[str, pd.DataFrame]) -> Markup:
    """Medians of the time saved, here and in the source; empty where nothing is published.

    Parameters
    ----------
    times
        Times of every response in the basis of the source by the case.
    """
    medians = pd.concat([pd.DataFrame(), *(_medians(*of_case) for of_case in times.items())])
    if medians.empty:
        return Markup()
    title = "Time saved, here and in the source"
    return table_with_caption(medians, title, [thesis().time_saved()], groups=["case"])


def _medians(case: str, times: pd.DataFrame) -> pd.DataFrame:
    keys = ["source_table", "joint", "coordinates"]
    here, source = "reduction_forward_difference_percent", "published_reduction_percent"
    printed = times.dropna(subset=[source, "source_table"]) if source in times else times.iloc[:0]
    is_reference = (printed["joint"] == REFERENCE[0]) & (printed["coordinates"] == REFERENCE[1])
    printed = printed[~is_reference]
    if printed.empty:
        return pd.DataFrame()
    medians = printed.groupby(keys, sort=False)[[here, source]].median().reset_index()
    medians.insert(0, "case", [link(f"{case}.html", case)] * len(medians))
    return medians.rename(columns={here: "here_percent", source: "source_percent"})
