"""How is a page of the report set? Self-contained HTML, its style, figures and tables inside it."""

import base64
import gzip
import html
import logging
import math
import re
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from boltjoint.study.tables.files import heading

_log = logging.getLogger(__name__)

#: a drawing is shown at most this many pixels wide for each of its points: 9 pt become 13 px
_PIXELS_PER_POINT = 1.42
#: a table of more rows scrolls inside a box
_TALL = 26

#: residual in time below which solutions hold as well as the march can tell
IN_TIME = 1e-6
#: numbers of a column that differ by more than this ratio get their own decimals
_WIDE = 300
#: Chromium shows no address longer than this many characters in a frame
_LONGEST_ADDRESS = 2 * 1024 * 1024

_STYLE = """
:root { --ink: #1d2733; --soft: #5a6876; --line: #dbe2e9; --wash: #f4f7fa; --accent: #17508a; }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; scroll-padding-top: 4rem; }
body { margin: 0; color: var(--ink); background: #fff;
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial,
    sans-serif; }
a { color: var(--accent); text-underline-offset: .15em; text-decoration-thickness: 1px; }
p { margin: 0 0 .8rem; }
.pages { position: sticky; top: 0; z-index: 5; display: flex; flex-wrap: wrap; gap: .2rem 1.5rem;
  padding: .6rem 1.4rem; background: #fff; border-bottom: 1px solid var(--line);
  font-size: .875rem; }
.pages a { color: var(--soft); text-decoration: none; }
.pages a:hover { color: var(--accent); }
.pages a[aria-current] { color: var(--ink); font-weight: 600; }
.sheet { display: grid; grid-template-columns: 11.5rem minmax(0, 1fr); gap: 0 2.2rem;
  max-width: 90rem; margin: 0 auto; padding: 0 1.4rem 5rem; }
header { grid-column: 1 / -1; padding: 2.2rem 0 1.4rem; }
header p { max-width: 50rem; }
.eyebrow { margin: 0 0 .2rem; color: var(--soft); font-size: .875rem; }
h1 { margin: 0 0 .7rem; font-size: 2rem; line-height: 1.2; letter-spacing: -.01em;
  overflow-wrap: anywhere; }
h2 { margin: 3rem 0 .8rem; padding-top: .9rem; border-top: 1px solid var(--line);
  font-size: 1.4rem; line-height: 1.3; }
h3 { margin: 2.2rem 0 .7rem; font-size: 1.1rem; line-height: 1.3; }
section:first-child > h2 { margin-top: 0; }
section > p, section > ul { max-width: 50rem; }
.contents { position: sticky; top: 4rem; align-self: start; max-height: calc(100vh - 5rem);
  overflow-y: auto; font-size: .875rem; line-height: 1.4; }
.contents ul { margin: 0; padding: 0; list-style: none; }
.contents li { margin: 0 0 .45rem; }
.contents li.sub { margin-left: .8rem; }
.contents a { color: var(--soft); text-decoration: none; }
.contents a:hover { color: var(--accent); text-decoration: underline; }
figure { margin: 0 0 2.4rem; }
figure.drawing { display: grid; grid-template-columns: minmax(0, 1fr) 16rem; gap: .6rem 1.6rem;
  align-items: start; }
.drawing svg { display: block; width: 100%; height: auto; }
figcaption { font-size: .875rem; line-height: 1.45; color: var(--soft); }
figcaption strong { display: block; color: var(--ink); font-size: .95rem; }
figcaption p { margin: .35rem 0 0; }
figcaption .source { color: var(--accent); font-weight: 600; }
.tabular figcaption { max-width: 50rem; margin-bottom: .6rem; }
.file { font-size: .8rem; }
.scroll { width: fit-content; max-width: 100%; overflow: auto; border: 1px solid var(--line);
  border-radius: 4px; }
.scroll.tall { max-height: 36rem; }
table { border-collapse: separate; border-spacing: 0; font-size: .82rem; line-height: 1.4;
  font-variant-numeric: tabular-nums; }
thead { position: sticky; top: 0; z-index: 1; }
th { padding: .4rem .48rem; background: var(--wash); text-align: right; vertical-align: bottom;
  font-weight: 600; max-width: 6.5rem; }
th.text { max-width: none; }
thead tr:last-child th { border-bottom: 1px solid #9fb0c0; }
th.span { max-width: none; text-align: center; white-space: nowrap;
  border-bottom: 1px solid var(--line); }
th.first:not(:first-child), td.first:not(:first-child) { border-left: 1px solid var(--line); }
td { padding: .2rem .48rem; text-align: right; white-space: nowrap; }
th.text, td.text { text-align: left; }
td.prose { white-space: normal; min-width: 12rem; max-width: 34rem; }
tbody tr:hover td { background: var(--wash); }
tbody tr.new td { border-top: 1px solid var(--line); }
tbody tr:first-child td { border-top: 0; }
@media (max-width: 1180px) {
  .sheet { display: block; }
  .contents { position: static; max-height: none; padding: .8rem 1rem; background: var(--wash);
    border-radius: 4px; }
  .contents ul { columns: 3 14rem; }
  section:first-child > h2 { margin-top: 2rem; }
}
@media (max-width: 820px) {
  figure.drawing { grid-template-columns: minmax(0, 1fr); }
}
@media print {
  body { font-size: 10pt; }
  .pages, .contents, .file { display: none; }
  .sheet { display: block; padding: 0; }
  figure.drawing { display: block; break-inside: avoid; }
  .scroll, .scroll.tall { max-height: none; overflow: visible; border: 0; }
  thead { position: static; }
  table { font-size: 7pt; }
  th, td { padding: .1rem .3rem; white-space: normal; }
  h2, h3 { break-after: avoid; }
}
"""

# Unpacks the page that follows, in place of this one; the browser has everything it needs.
_UNPACK = """
const bytes = Uint8Array.from(atob(document.getElementById("packed").textContent),
  (letter) => letter.charCodeAt(0));
const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
new Response(stream).text().then((page) => {
  document.open();
  document.write(page);
  document.close();
});
"""


class Html(str):
    """Text of a cell that is HTML already; any other text is escaped."""


def link(address: str, words: str) -> Html:
    """A link to an address, seen from the page."""
    return Html(f'<a href="{html.escape(address)}">{html.escape(words)}</a>')


@dataclass(frozen=True)
class Section:
    """A part of a page under a heading.

    Parameters
    ----------
    anchor
        By which links find it.
    title
        Its heading, which the page's contents list.
    body
        HTML.
    level
        2, or 3 for a part of the section before it.
    """

    anchor: str
    title: str
    body: str
    level: int = 2


def page(
    title: str,
    eyebrow: str,
    lead: str,
    sections: Sequence[Section],
    pages: Mapping[str, str],
    here: str,
) -> str:
    """A whole page.

    Parameters
    ----------
    title, eyebrow, lead
        Heading, the line above it and the sentences below it; ``lead`` is HTML.
    sections
        What the page holds, in order.
    pages
        What each page of the report is called, by its file.
    here
        The file of this one.
    """
    links = "".join(
        f'<a href="{file}"{" aria-current=page" if file == here else ""}>{html.escape(name)}</a>'
        for file, name in pages.items()
    )
    contents = "".join(
        f"<li{' class=sub' if each.level > 2 else ''}>"
        f'<a href="#{each.anchor}">{html.escape(each.title)}</a></li>'
        for each in sections
    )
    parts = "\n".join(
        f'<section id="{each.anchor}"><h{each.level}>{html.escape(each.title)}</h{each.level}>\n'
        f"{each.body}</section>"
        for each in sections
    )
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f'<nav class="pages">{links}</nav>\n<div class="sheet">\n'
        f'<header><p class="eyebrow">{html.escape(eyebrow)}</p><h1>{html.escape(title)}</h1>'
        f'{lead}</header>\n<nav class="contents"><ul>{contents}</ul></nav>\n'
        f"<main>\n{parts}\n</main>\n</div>\n</body>\n</html>\n"
    )


def save(text: str, path: str | Path, path_of_packed: str | Path) -> None:
    """Write a page, and the same page packed to be embedded."""
    for where, content in ((Path(path), text), (Path(path_of_packed), packed(text))):
        where.parent.mkdir(parents=True, exist_ok=True)
        where.write_text(content, encoding="utf-8")


def packed(page: str) -> str:
    """The same page in a fraction of its size, to be embedded where no other file is at hand.

    It unpacks itself when it is opened. Links to other files are left out, since a page inside
    another has no folder that they could start from.
    """
    alone = re.sub(r'<nav class="pages">.*?</nav>|<a class="file".*?</a>', "", page, flags=re.S)
    alone = re.sub(r'<a href="[^#"][^"]*">(.*?)</a>', r"\1", alone)
    data = base64.b64encode(gzip.compress(alone.encode(), mtime=0)).decode()
    found = re.search("<title>(.*?)</title>", page)
    title = found[1] if found else ""
    whole = (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>'
        f'<body><script type="text/plain" id="packed">{data}</script>'
        f"<script>{_UNPACK}</script></body></html>\n"
    )
    if len(base64.b64encode(whole.encode())) > _LONGEST_ADDRESS - 200:
        _log.warning("the page %r is too long for a frame: Chromium will show it empty", title)
    return whole


def drawing(path: str | Path, title: str, notes: Iterable[str], file: str) -> str:
    """An SVG file as a figure, with its caption beside it.

    Parameters
    ----------
    path
        The SVG file; the figure's anchor is its name without the ending.
    title
        First line of the caption.
    notes
        Further paragraphs of the caption, HTML; empty ones are left out.
    file
        The file, seen from the page.
    """
    path = Path(path)
    # what the drawing calls its parts must differ from what all others on the page do
    prefix = f"{zlib.crc32(path.stem.encode()):08x}-"
    drawn = inline_svg(path.read_text(encoding="utf-8"), prefix, title)
    return (
        f'<figure class="drawing" id="{path.stem}">\n{drawn}\n<figcaption>'
        f"<strong>{html.escape(title)}</strong>{_paragraphs(notes)}"
        f'<p><a class="file" href="{file}">SVG</a></p></figcaption></figure>\n'
    )


def table(
    frame: pd.DataFrame,
    title: str,
    notes: Iterable[str] = (),
    anchor: str | None = None,
    file: str | None = None,
    groups: Sequence[str] = (),
    verbatim: bool = False,
) -> str:
    """A table with its caption above it.

    Parameters
    ----------
    frame
        Columns named ``quantity_unit`` as in the study's tables, or pairs of what spans several
        columns and such a name.
    title, notes
        First line of the caption and its further paragraphs; the latter are HTML.
    anchor
        By which links find it.
    file
        The file of the whole table, seen from the page.
    groups
        Leading columns whose repeated entries are printed once.
    verbatim
        Whether headings are printed as they are, such as names of assemblies.
    """
    rows = "\n".join(_rows(frame, groups))
    tall = " tall" if len(frame) > _TALL else ""
    more = "" if file is None else f'<p><a class="file" href="{file}">CSV</a></p>'
    where = "" if anchor is None else f' id="{anchor}"'
    return (
        f'<figure class="tabular"{where}>\n<figcaption><strong>{html.escape(title)}</strong>'
        f'{_paragraphs(notes)}{more}</figcaption>\n<div class="scroll{tall}"><table>\n'
        f"<thead>{_head(frame, verbatim)}</thead>\n<tbody>\n{rows}\n</tbody>"
        "</table></div></figure>\n"
    )


def source(what: str, numbers: Sequence[str]) -> str:
    """The line of a caption that names what the source calls the same; empty for nothing.

    >>> source("Figure", ["3.3", "3.4", "3.44"])
    '<span class="source">Figures 3.3, 3.4 and 3.44</span> of the source'
    >>> source("Figure", ["3.46", "3.47", "3.48", "3.49"])
    '<span class="source">Figures 3.46 to 3.49</span> of the source'
    """
    if not numbers:
        return ""
    runs: list[list[str]] = []
    for one in numbers:
        follows = runs and int(one.split(".")[1]) == int(runs[-1][-1].split(".")[1]) + 1
        if follows:
            runs[-1].append(one)
        else:
            runs.append([one])
    parts = [part for run in runs for part in (run if len(run) < 3 else [f"{run[0]} to {run[-1]}"])]
    *most, last = parts
    listed = f"{', '.join(most)} and {last}" if most else last
    plural = "s" if len(numbers) > 1 else ""
    return f'<span class="source">{what}{plural} {listed}</span> of the source'


def inline_svg(text: str, prefix: str, title: str) -> str:
    """An SVG file as a part of a page, as wide as there is room for.

    Parameters
    ----------
    text
        The file.
    prefix
        Put before the names of its parts; names that nothing refers to are dropped.
    title
        Read to those who do not see it.
    """
    drawn = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", text, flags=re.S)
    drawn = drawn[drawn.index("<svg") :]
    used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', drawn))
    drawn = re.sub(
        r' id="([^"]+)"', lambda m: f' id="{prefix}{m[1]}"' if m[1] in used else "", drawn
    )
    drawn = re.sub(r'(url\(#|href="#)', rf"\g<1>{prefix}", drawn)
    # a hundredth of a point is less than any screen or printer resolves
    drawn = re.sub(r' d="[^"]*"', lambda m: re.sub(r"(\.\d\d)\d+", r"\1", m[0]), drawn)
    drawn = re.sub(r"\s+", " ", drawn).replace("> <", "><")
    head, rest = drawn.split(">", 1)
    width = re.search(r' width="([\d.]+)', head)
    head = re.sub(r' (?:width|height)="[^"]*"', "", head)
    widest = f' style="max-width: {float(width[1]) * _PIXELS_PER_POINT:.0f}px"' if width else ""
    return f'{head} role="img" aria-label="{html.escape(title)}"{widest}>{rest}'


def _paragraphs(notes: Iterable[str]) -> str:
    written = "".join(f"<p>{note}</p>" for note in notes if note)
    return re.sub(r"(?<=\d) (?=(?:%|N|Hz|mm)\b|%)", "\N{NO-BREAK SPACE}", written)


def _head(frame: pd.DataFrame, verbatim: bool) -> str:
    named = [column if isinstance(column, tuple) else ("", column) for column in frame]
    first = _starts(frame)
    spans = ""
    if any(span for span, _ in named):
        starts = [index for index, new in enumerate(first) if new]
        for begin, end in zip(starts, [*starts[1:], len(named)], strict=True):
            span = html.escape(named[begin][0])
            spans += f'<th class="span first" colspan="{end - begin}">{span}</th>'
        spans = f"<tr>{spans}</tr>"
    cells = "".join(
        f'<th class="{_looks(column, new)}">{html.escape(name if verbatim else heading(name))}</th>'
        for (_, name), column, new in zip(named, _columns(frame), first, strict=True)
    )
    return f"{spans}<tr>{cells}</tr>"


def _rows(frame: pd.DataFrame, groups: Sequence[str]) -> Iterable[str]:
    first = _starts(frame)
    looks = [_looks(column, new) for column, new in zip(_columns(frame), first, strict=True)]
    names = [name[1] if isinstance(name, tuple) else name for name in frame]
    columns = _columns(frame)
    # columns of one name under several spans are printed alike
    decimals = {
        name: _decimals(name, [c for c, other in zip(columns, names, strict=True) if other == name])
        for name in names
    }
    printed = [
        [_cell(value, decimals[name]) for value in column]
        for column, name in zip(columns, names, strict=True)
    ]
    before: list[str] = []
    for row in zip(*printed, strict=True):
        same = 0
        while before and same < len(groups) and row[same] == before[same]:
            same += 1
        cells = "".join(
            f'<td class="{look}">{"" if index < same else cell}</td>'
            for index, (cell, look) in enumerate(zip(row, looks, strict=True))
        )
        yield f"<tr{' class=new' if groups and same < len(groups) else ''}>{cells}</tr>"
        before = list(row)


def _columns(frame: pd.DataFrame) -> list[pd.Series]:
    return [column for _, column in frame.items()]


def _starts(frame: pd.DataFrame) -> list[bool]:
    """Whether each column begins what spans it and its neighbours."""
    spans = [column[0] if isinstance(column, tuple) else None for column in frame]
    return [
        span is not None and (index == 0 or span != spans[index - 1])
        for index, span in enumerate(spans)
    ]


def _looks(column: pd.Series, first: bool) -> str:
    if pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column):
        look = "number"
    else:
        long = column.map(lambda value: isinstance(value, str) and len(_plain(value)) > 40).any()
        look = "text prose" if long else "text"
    return f"{look} first" if first else look


def _plain(cell: str) -> str:
    return re.sub("<.*?>", "", cell)


def _decimals(name: str, columns: Sequence[pd.Series]) -> int | None:
    """How many decimals suit all numbers of a column, or None where each number has its own."""
    if name.endswith(("percent", "points", "dB")):
        return 2
    known = [
        abs(value)
        for column in columns
        for value in column
        if isinstance(value, float) and math.isfinite(value) and value != 0
    ]
    if not known or all(float(f"{value:.3g}") == value for value in known):
        return None  # chosen, not computed: 0.001, 1, 50
    if all(value.is_integer() and value < 1e15 for value in known):
        return 0
    if max(known) / min(known) > _WIDE:
        return None
    # four digits of the largest, or three of the smallest
    most, least = (math.floor(math.log10(chosen(known))) for chosen in (max, min))
    return max(0, 3 - most, 2 - least)


def _cell(value: object, decimals: int | None) -> str:
    if isinstance(value, str):
        return value if isinstance(value, Html) else html.escape(value)
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


def in_time(residual: float) -> str | None:
    """A residual in time as a cell: what lies below the tolerance of the march says no more.

    >>> in_time(3e-7), in_time(2.5e-4)
    ('below 10⁻⁶', '0.00025')
    """
    if pd.isna(residual):
        return None
    return "below 10⁻⁶" if residual <= IN_TIME else number(residual, 2)


def number(value: float, digits: int = 4) -> str:
    """A number in text, with so many digits that count.

    >>> number(0.001), number(37976.0), number(7.3e-15), number(-11.1288)
    ('0.001', '37976', '7.3 × 10⁻¹⁵', '−11.13')
    """
    if value == 0 or 1e-4 <= abs(value) < 1e7:
        before = 1 + math.floor(math.log10(abs(value))) if value else 1
        text = f"{value:.{max(0, digits - before)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        base, power = f"{value:.{min(digits, 3) - 1}e}".split("e")
        base = base.rstrip("0").rstrip(".")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{base} × 10{raised}"
    return text.replace("-", "−")
