"""Figures and tables with their captions, links and prose, as HTML."""

import re
import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup, escape

from boltjoint import checksums
from boltjoint.study.tables.html import html_table, number, template_environment

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
) -> Markup:
    """A table with its caption above it.

    Parameters
    ----------
    frame, groups, verbatim
        As for ``html_table``.
    title, notes
        First line of the caption and its further paragraphs; empty ones are left out.
    anchor
        The target of links to it.
    file
        The file of the whole table, seen from the page.
    """
    content = html_table(frame, groups, verbatim)
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
    return Markup(re.sub(r"(?<=\d) (?=(?:%|N|Hz|mm)\b|%)", "\N{NO-BREAK SPACE}", escape(text)))


TEMPLATES.filters |= {"unbroken": _unbroken, "number": number}
