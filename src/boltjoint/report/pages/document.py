"""Pages of the report: self-contained HTML of several sections."""

import base64
import gzip
import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from boltjoint.report.pages.markup import TEMPLATES

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
