"""Tables as HTML: for pages of the report, and each on a page beside its CSV file."""

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from boltjoint import checks, csv_files
from boltjoint.number_format import number

#: numbers of a column that differ by more than this ratio get decimals each by itself
_WIDE_RATIO = 300
#: columns above which a table is set smaller
_MANY_COLUMNS = 9
#: characters above which the text of a cell is broken into lines
_LONG_TEXT = 40

#: dot of a key path
_WITHIN_PATH = re.compile(r"(?<=[a-z])\.(?=[a-z])")

#: the last words of a column's name that are its unit, and how the unit is printed
_UNITS = {
    "N_per_mm3": "N/mm³",
    "kN_per_mm": "kN/mm",
    "mm_per_N": "mm/N",
    "dB": "dB",
    "percent": "%",
    "points": "percentage points",
    "relative": "relative",
    "Hz": "Hz",
    "MPa": "MPa",
    "mm2": "mm²",
    "um": "µm",
    "mm": "mm",
    "N_per_m": "N/m",
    "m": "m",
    "N2": "N²",
    "N": "N",
    "J": "J",
    "s": "s",
}


def template_environment(*folders: Path) -> Environment:
    """Templates of some folders and of this one; text is escaped unless it is ``Markup``."""
    here = Path(__file__).parent
    return Environment(
        loader=FileSystemLoader([*folders, here, here / "templates"]),
        autoescape=True,
        trim_blocks=True,
        undefined=StrictUndefined,
    )


_TEMPLATES = template_environment()


def table_page(frame: pd.DataFrame, title: str) -> str:
    """The page of a single table under its title."""
    page = _TEMPLATES.get_template("table_page.html.j2")
    return page.render(title=title, table=html_table(frame)) + "\n"


def html_table(
    frame: pd.DataFrame,
    groups: Sequence[str] = (),
    verbatim: bool = False,
    marked: Sequence[bool] = (),
) -> Markup:
    """A table as HTML, all numbers of a column with the same decimals.

    Parameters
    ----------
    frame
        Columns named ``quantity_unit``, or pairs of a heading above several columns and such a
        name. Cells are text, which is escaped unless it is ``Markup``, numbers or truth values.
    groups
        Leading columns whose repeated entries are printed once.
    verbatim
        Whether headings are printed as they are, such as names of assemblies.
    marked
        Of each row, whether it stands out; by default of none.
    """
    pairs = [column if isinstance(column, tuple) else ("", column) for column in frame]
    spans, names = [span for span, _ in pairs], [name for _, name in pairs]
    columns = [column for _, column in frame.items()]
    # a line stands left of the first column of each span
    first = [
        any(spans) and (index == 0 or span != spans[index - 1]) for index, span in enumerate(spans)
    ]
    styles = [_style(column, new) for column, new in zip(columns, first, strict=True)]
    headings = [_breakable(name if verbatim else heading(name)) for name in names]
    table = _TEMPLATES.get_template("table.html.j2").render(
        is_wide=len(names) > _MANY_COLUMNS,
        spans=_spans(spans, first),
        headings=zip(headings, styles, strict=True),
        rows=(
            ((new * "new " + stands_out * "marked").strip(), zip(cells, styles, strict=True))
            for (new, cells), stands_out in zip(
                _rows(_printed(columns, names), len(groups)),
                marked or [False] * len(frame),
                strict=True,
            )
        ),
    )
    return Markup(table)


def _breakable(text: str) -> Markup:
    """Text whose key paths may go on in another line."""
    return Markup(_WITHIN_PATH.sub(".<wbr>", escape(text)))


def heading(column: str) -> str:
    """The heading of a column: its name in words, its unit in brackets.

    >>> heading("largest_load_N"), heading("k_kN_per_mm"), heading("reason")
    ('largest load (N)', 'k (kN/mm)', 'reason')
    """
    for ending, unit in _UNITS.items():
        if column.endswith(f"_{ending}"):
            words = column.removesuffix(f"_{ending}").replace("_", " ")
            return f"{words} ({unit})"
    return column.replace("_", " ")


def _spans(spans: Sequence[str], first: Sequence[bool]) -> list[tuple[str, int]]:
    """The headings above several columns, and above how many each stands."""
    starts = [index for index, new in enumerate(first) if new]
    ends = [*starts[1:], len(spans)]
    return [(spans[begin], end - begin) for begin, end in zip(starts, ends, strict=False)]


def _printed(columns: Sequence[pd.Series], names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """The cells of every row; columns of one name under several spans are printed alike."""
    alike: dict[str, list[pd.Series]] = {}
    for name, column in zip(names, columns, strict=True):
        alike.setdefault(name, []).append(column)
    decimals = {name: _decimals(name, same) for name, same in alike.items()}
    printed = (
        [_cell(value, decimals[name]) for value in column]
        for column, name in zip(columns, names, strict=True)
    )
    return zip(*printed, strict=True)


def _rows(
    printed: Iterator[tuple[str, ...]], groups: int
) -> Iterator[tuple[bool, tuple[str, ...]]]:
    """Whether each row starts a group, and its cells without those that repeat the row above."""
    above: tuple[str, ...] = ()
    for cells in printed:
        same = 0
        while above and same < groups and cells[same] == above[same]:
            same += 1
        yield 0 < groups and same < groups, ("",) * same + cells[same:]
        above = cells


def _style(column: pd.Series, first: bool) -> str:
    if pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column):
        style = "number"
    else:
        texts = [re.sub("<.*?>", "", text) for text in column if isinstance(text, str)]
        style = "text prose" if any(len(text) > _LONG_TEXT for text in texts) else "text"
    return f"{style} first" if first else style


def _decimals(name: str, columns: Sequence[pd.Series]) -> int | None:
    """How many decimals suit all numbers of a column, or None where each number has its own."""
    if "±" in name:
        return None  # of two digits, each by itself
    finite = [
        abs(value)
        for column in columns
        for value in column
        if isinstance(value, float) and math.isfinite(value) and value != 0
    ]
    if name.endswith(("percent", "points", "dB")):
        # percentages below a tenth need a digit more, unless they are next to nothing
        return 3 if finite and 0.005 <= min(finite) < 0.1 else 2
    if not finite or all(float(f"{value:.3g}") == value for value in finite):
        return None  # chosen, not computed: 0.001, 1, 50
    if all(value.is_integer() and value < 1e15 for value in finite):
        return 0
    if max(finite) / min(finite) > _WIDE_RATIO:
        return None
    # four digits of the largest, or three of the smallest
    most, least = (math.floor(math.log10(extreme(finite))) for extreme in (max, min))
    return max(0, 3 - most, 2 - least)


def _cell(value: object, decimals: int | None) -> str:
    if isinstance(value, str):
        return value
    if pd.api.types.is_bool(value):
        return "yes" if value else "no"
    if value is None or pd.isna(value):
        return "–"
    if not isinstance(value, float):
        return str(value).replace("-", "−")
    if decimals is not None and decimals <= 6:
        text = f"{value:.{decimals}f}"
        return text.removeprefix("-") if float(text) == 0 else text.replace("-", "−")
    return number(value)


def write(table: pd.DataFrame, csv: str | Path, page: str | Path, title: str) -> None:
    """Write a table as CSV (``csv_files.write_rounded``) and as an HTML page under its title."""
    checks.instance("title", title, str)
    page = checks.path("page", page)
    csv_files.write_rounded(table, csv)
    page.write_text(table_page(table, title), encoding="utf-8")
