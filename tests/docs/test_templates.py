"""Pages that are written from templates say what their templates say."""

import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def fixed_lines(template):
    """Lines of a template that every page of it has: without values, and outside of conditions."""
    depth = 0
    for line in template.splitlines():
        opened = len(re.findall(r"{%-? *(?:if|for|macro|set \w+ *%)", line))
        closed = len(re.findall(r"{%-? *end", line))
        if not (depth or opened or closed) and line.strip() and "{" not in line:
            yield line
        depth += opened - closed


@pytest.mark.parametrize("template", sorted(DOCS.glob("*.md.j2")), ids=lambda path: path.name)
def test_a_page_has_the_sentences_of_its_template(template):
    fixed = list(fixed_lines(template.read_text(encoding="utf-8")))
    page = set(template.with_suffix("").read_text(encoding="utf-8").splitlines())
    assert len(fixed) > 20
    # written anew it would lose what was changed in the page alone
    assert [line for line in fixed if line not in page] == []
