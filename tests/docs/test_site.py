"""The site is built without a warning, needs no network, and all its links lead somewhere.

``BOLTJOINT_SITE`` names the folder of a site that ``make site`` has built, which is read instead.
"""

import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import boltjoint

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: what the pages of the site are made of
SOURCES = (
    "docs",
    "config",
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "CITATION.cff",
    "tests/workflow/maker_of_cubes",
)


class Page(HTMLParser):
    """Anchors, links, and what a browser loads to show a page."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors |= {given[key] for key in ("id", "name") if given.get(key)}
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        elif tag in ("script", "img", "iframe", "source") and given.get("src"):
            self.loaded.append(given["src"])
        elif tag == "link" and given.get("href") and given.get("rel") != "canonical":
            self.loaded.append(given["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The built site; its examples are not executed, which tests of their own do."""
    if "BOLTJOINT_SITE" in os.environ:
        return ROOT / os.environ["BOLTJOINT_SITE"]
    pytest.importorskip("sphinx")
    copy = tmp_path_factory.mktemp("site")
    ignored = shutil.ignore_patterns("examples", "reference", "__pycache__")
    for name in SOURCES:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=ignored)
        else:
            shutil.copy(ROOT / name, copy / name)
    built = subprocess.run(
        [
            *(sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet"),
            *(copy / "docs", copy / "site"),
        ],
        env=os.environ | {"BOLTJOINT_GALLERY": "skip"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    assert "WARNING" not in built.stderr
    return copy / "site"


@pytest.fixture(scope="module")
def pages(site):
    return {
        path: Page(path)
        for path in sorted(site.rglob("*.html"))
        if "_static" not in path.parts  # templates of the theme
    }


def test_every_page_of_the_repository_is_a_page_of_the_site(site):
    names = {path.stem for path in DOCS.glob("*.md")}
    assert {"index", "tutorial", "theory", "keys", "glossary"} <= names
    assert all((site / f"{name}.html").exists() for name in names)
    assert all(
        (site / f"examples/{path.stem}.html").exists() for path in DOCS.glob("gallery/[0-9]*.py")
    )


def test_links_and_anchors_lead_somewhere(site, pages):
    dead = []
    for path, page in pages.items():
        for link in [*page.links, *page.loaded]:
            parts = urlsplit(link)
            if parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            anchor = unquote(parts.fragment)
            is_there = target.is_file() and (
                not anchor or target.suffix != ".html" or anchor in pages[target].anchors
            )
            if not is_there:
                dead.append((path.relative_to(site).as_posix(), link))
    assert dead == []


def test_pages_load_nothing_from_a_network(site, pages):
    assert [link for page in pages.values() for link in page.loaded if urlsplit(link).netloc] == []
    styles = {path: path.read_text(encoding="utf-8") for path in site.rglob("*.css")}
    remote = re.compile(r"(?:@import|url\()\s*[\"']?(?:https?:)?//")
    assert [path.name for path, text in styles.items() if remote.search(text)] == []


def test_equations_are_typeset(site):
    html = (site / "theory.html").read_text(encoding="utf-8")
    assert html.count("<math") > 20
    assert "merror" not in html
    # a command that was not understood would stand there as text
    texts = re.findall(r"<m(?:i|o|text)[^>]*>(.*?)</m", html)
    assert [text for text in texts if "\\" in text] == []


def test_every_public_name_is_documented(site):
    listed = re.findall(r"^   (\w+)$", (DOCS / "reference.md").read_text(), re.MULTILINE)
    assert sorted(listed) == sorted(boltjoint._NAMES)
    for name in listed:
        html = (site / f"reference/boltjoint.{name}.html").read_text(encoding="utf-8")
        assert f'id="boltjoint.{name}"' in html


def test_every_key_is_documented(site):
    html = (site / "keys.html").read_text(encoding="utf-8")
    keys = re.findall(r"^\| `([\w.]+)`", (ROOT / "config/README.md").read_text(), re.MULTILINE)
    assert len(keys) > 100
    assert [key for key in keys if f"{key}" not in html] == []
