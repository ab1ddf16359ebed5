"""Pages of the report as self-contained HTML: figures, tables, sections, and packed numbers."""

import base64
import gzip
import json
import logging
import re
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup, escape
from numpy.typing import NDArray

from boltjoint import checksums
from boltjoint.number_format import number
from boltjoint.study.tables.html import html_table, template_environment

#: a drawing is at most this many pixels wide for each of its points: 9 pt become 13 px
_PIXELS_PER_POINT = 1.42
#: a table of more rows scrolls inside a box
_TALL_TABLE = 26

_HERE = Path(__file__).parent
TEMPLATES = template_environment(_HERE, _HERE / "templates")


def prose(name: str) -> Any:  # noqa: ANN401
    """The macros of a template, each of which returns HTML."""
    return TEMPLATES.get_template(f"{name}.html.j2").module


def joined(parts: Iterable[str]) -> Markup:
    """Pieces of HTML one after another."""
    return Markup("").join(parts)


def link(address: str, words: str) -> Markup:
    """A link to an address, seen from the page."""
    return prose("captions").link(address, words)


def figure_with_caption(path: str | Path, title: str, notes: Iterable[str], file: str) -> Markup:
    """An SVG file as a figure, with its caption beside it.

    Parameters
    ----------
    path
        The SVG file; the figure's anchor is its name without the ending.
    title, notes
        First line of the caption and its further paragraphs; empty ones are left out.
    file
        The file, seen from the page.
    """
    path = Path(path)
    # names of parts must differ from those in all other drawings of the page
    prefix = f"{zlib.crc32(path.stem.encode()):08x}-"
    drawing = inline_svg(checksums.read_text(path), prefix, title)
    return prose("captions").figure(drawing, path.stem, title, list(notes), file)


def table_with_caption(
    frame: pd.DataFrame,
    title: str,
    notes: Iterable[str] = (),
    anchor: str | None = None,
    file: str | None = None,
    groups: Sequence[str] = (),
    verbatim: bool = False,
    marked: Sequence[bool] = (),
) -> Markup:
    """A table with its caption above it.

    Parameters
    ----------
    frame, groups, verbatim, marked
        As for ``html_table``.
    title, notes
        First line of the caption and its further paragraphs; empty ones are left out.
    anchor
        The target of links to it.
    file
        The file of the whole table, seen from the page.
    """
    content = html_table(frame, groups, verbatim, marked)
    tall = len(frame) > _TALL_TABLE
    return prose("captions").table(content, tall, anchor, title, list(notes), file)


def inline_svg(text: str, prefix: str, title: str) -> Markup:
    """An SVG file as a part of a page, as wide as there is room for.

    Parameters
    ----------
    text
        The file.
    prefix
        Put before the names of its parts; names that nothing refers to are dropped.
    title
        Its description for screen readers.
    """
    drawing = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", text, flags=re.S)
    drawing = drawing[drawing.index("<svg") :]
    used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', drawing))
    drawing = re.sub(
        r' id="([^"]+)"', lambda m: f' id="{prefix}{m[1]}"' if m[1] in used else "", drawing
    )
    drawing = re.sub(r'(url\(#|href="#)', rf"\g<1>{prefix}", drawing)
    # a hundredth of a point is less than any screen or printer resolves
    drawing = re.sub(r' d="[^"]*"', lambda m: re.sub(r"(\.\d\d)\d+", r"\1", m[0]), drawing)
    drawing = re.sub(r"\s+", " ", drawing).replace("> <", "><")
    head, rest = drawing.split(">", 1)
    width = re.search(r' width="([\d.]+)', head)
    head = re.sub(r' (?:width|height)="[^"]*"', "", head)
    widest = f' style="max-width: {float(width[1]) * _PIXELS_PER_POINT:.0f}px"' if width else ""
    return Markup(f'{head} role="img" aria-label="{escape(title)}"{widest}>{rest}')


def _unbroken(text: str) -> Markup:
    """The text with spaces before units that do not break."""
    return Markup(
        re.sub(r"(?<=\d) (?=(?:kN|N|Hz|mm|m/s²)(?!\w)|%)", "\N{NO-BREAK SPACE}", escape(text))
    )


TEMPLATES.filters |= {"unbroken": _unbroken, "number": number}


_log = logging.getLogger(__name__)

_NO_SCRIPTS = Markup()
#: drawings that answer the pointer, which a page within another has no room for
_INTERACTIVE = re.compile("<!--interactive-->.*?<!--/interactive-->", re.S)

#: Chromium shows no address longer than this many characters in a frame
_LONGEST_ADDRESS = 2 * 1024 * 1024


@dataclass(frozen=True)
class Section:
    """A part of a page under a heading.

    Parameters
    ----------
    anchor
        The target of links to it.
    title
        Its heading, which the page's contents list.
    body
        HTML.
    level
        2, or 3 for a part of the section before it.
    is_folded
        Whether only its heading is seen until it is opened.
    """

    anchor: str
    title: str
    body: str
    level: int = 2
    is_folded: bool = False


def render_page(
    title: str,
    eyebrow: str,
    lead: str,
    sections: Sequence[Section],
    cases: Sequence[str],
    here: str,
    scripts: Markup = _NO_SCRIPTS,
) -> str:
    """A whole page.

    Parameters
    ----------
    title, eyebrow, lead
        Heading, the line above it and the sentences below it; ``lead`` is HTML.
    sections
        Its parts, in order.
    cases
        Names of the study's cases, to whose pages it links.
    here
        The file of this page.
    scripts
        What makes its drawings answer the pointer.
    """
    pages = {
        "overview.html": "Overview",
        "accuracy.html": "Accuracy",
        "structure.html": "Structure",
        **{f"{name}.html": name for name in cases},
    }
    content = {"title": title, "eyebrow": eyebrow, "lead": lead, "sections": sections}
    content |= {"scripts": scripts}
    template = TEMPLATES.get_template("page.html.j2")
    return template.render(pages=pages, here=here, **content) + "\n"


def save_page(page: str, path: str | Path, path_of_compressed: str | Path) -> None:
    """Write a page, and the same page compressed to be embedded."""
    for where, content in ((path, page), (path_of_compressed, compressed_page(page))):
        Path(where).parent.mkdir(parents=True, exist_ok=True)
        Path(where).write_text(content, encoding="utf-8")


def compressed_page(page: str) -> str:
    """The same page in a fraction of its size, which the browser decompresses when it opens it.

    It is embedded where no other file is at hand. Links to other files are left out, since a page
    inside another has no folder that they could start from, and drawings that answer the pointer.
    """
    page = _INTERACTIVE.sub("", page)
    alone = re.sub(r'<nav class="pages">.*?</nav>|<a class="file".*?</a>', "", page, flags=re.S)
    alone = re.sub(r'<a href="[^#"][^"]*">(.*?)</a>', r"\1", alone)
    data = base64.b64encode(gzip.compress(alone.encode(), mtime=0)).decode()
    heading = re.search("<title>(.*?)</title>", page)
    title = Markup(heading[1] if heading else "")
    whole = TEMPLATES.get_template("compressed.html.j2").render(title=title, data=data) + "\n"
    if len(base64.b64encode(whole.encode())) > _LONGEST_ADDRESS - 200:
        _log.warning("the page %s is too long for a frame: Chromium will show it empty", title)
    return whole


def pack(values: NDArray[np.generic], kind: str = "<f4") -> str:
    """Numbers as text: to seven digits, unless another kind is given.

    >>> pack(np.array([1.0, 2.0]))
    'AACAPwAAAEA='
    """
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()


def compress(text: str) -> str:
    """A text as base64 of its gzip, which browsers expand, the same on every run."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def compressed_json(content: object) -> str:
    """What JSON can hold, compressed."""
    return compress(json.dumps(content, separators=(",", ":"), allow_nan=False))


@cache
def compressed_plotly() -> str:
    """The library that draws, whole: a page needs no network."""
    # it takes a tenth of a second to import
    from plotly.offline import get_plotlyjs

    return compress(get_plotlyjs())
