"""Mean length of the sentences of each page, in words: ``python docs/sentences.py``.

Code, tables, headings, equations and addresses of links are left out. An item of a list and a
paragraph end a sentence, whether they end with a full stop or not.
"""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: pages that lead by the hand, and the most words a sentence may have there on average
HAND = (
    "README.md",
    "CONTRIBUTING.md",
    *(f"docs/{name}.md" for name in ("index", "tutorial", "how_to", "studies", "structures")),
    *(f"docs/{name}.md" for name in ("library", "measurement", "cluster")),
)
LIMITS = {**dict.fromkeys(HAND, 20.0), "": 25.0}
#: a full stop after these ends no sentence
_SHORT = r"(?:eq|Fig|al|ed|e\.g|i\.e|vs|no|cf)"


def pages() -> list[str]:
    """All pages of the site that are prose, by their path in the repository."""
    found = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "docs").glob("*.md"))]
    return ["README.md", "CONTRIBUTING.md", "config/README.md", *found]


def limit(page: str) -> float:
    """The most words that a sentence of a page may have on average."""
    return LIMITS.get(page, LIMITS[""])


def sentences(text: str) -> list[list[str]]:
    """The words of each sentence of a page."""
    text = re.sub(r"^(```|:::+|---)[^\n]*\n.*?^\1[^\n]*$", "\n", text, flags=re.M | re.S)
    text = re.sub(r"\$\$.*?\$\$", "\n\n", text, flags=re.S)
    text = re.sub(r"<!--.*?-->", "\n\n", text, flags=re.S)
    text = re.sub(r"^(#.*|\|.*| {4,}\S.*)$", "\n", text, flags=re.M)
    text = re.sub(r"^\s*(?:[-*]|\d+\.)\s+", "\n\n", text, flags=re.M)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    # a name in code type or a formula is a word
    text = re.sub(r"`+[^`]*`+|\$[^$]*\$", "code", text)
    text = re.sub(rf"\b({_SHORT})\.", r"\1", text)
    found = []
    for paragraph in re.split(r"\n\s*\n", text):
        for sentence in re.split(r"(?<=[.!?])[\"')*_]*\s+", paragraph.strip()):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            if words:
                found.append(words)
    return found


def mean_length(page: str) -> float:
    """Mean number of words of the sentences of a page."""
    lengths = [len(words) for words in sentences((ROOT / page).read_text(encoding="utf-8"))]
    return sum(lengths) / max(len(lengths), 1)


if __name__ == "__main__":
    for name in pages():
        mean = mean_length(name)
        mark = "" if mean <= limit(name) else "  above the limit"
        print(f"{mean:5.1f} of {limit(name):.0f}  {name}{mark}")
