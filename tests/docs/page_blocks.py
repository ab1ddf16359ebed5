"""Fenced blocks and quoted words of the pages, with their places."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
#: all pages that a reader of the repository or of the site opens
PAGES = sorted(
    {
        *ROOT.glob("*.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("config/*.md"),
        *ROOT.glob("profiles/*.md"),
        *ROOT.glob("resources/*/*.md"),
    }
)
_BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


class Quoted(NamedTuple):
    """A block or words of a page: where they stand, of which language, and what they say."""

    place: str
    language: str
    text: str


def blocks(*languages: str) -> list[Quoted]:
    """The fenced blocks of all pages in some languages, or all."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in _BLOCK.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            place = f"{page.relative_to(ROOT)}:{line}"
            found.append(Quoted(place, match[1].strip(), match[2]))
    return [each for each in found if each.language in languages or not languages]


def quoted_words() -> list[Quoted]:
    """Words between backticks, outside of blocks."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        # the same lines, without the blocks
        text = _BLOCK.sub(lambda match: "\n" * match[0].count("\n"), text)
        for match in re.finditer(r"(?<!`)`([^`\n]+)`(?!`)", text):
            line = text.count("\n", 0, match.start()) + 1
            found.append(Quoted(f"{page.relative_to(ROOT)}:{line}", "", match[1]))
    return found


def commands(shell: str) -> list[str]:
    """The commands of a block of shell, one by one, without comments."""
    joined = re.sub(r"\\\n\s*", " ", shell)
    lines = [re.sub(r"(^|\s)#.*", "", line).strip() for line in joined.splitlines()]
    return [part.strip() for line in lines for part in line.split("&&") if part.strip()]
