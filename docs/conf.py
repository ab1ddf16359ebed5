"""How Sphinx makes the site of these pages, without a network: ``make site``."""

import os
import re
import sys
from functools import cached_property
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

import boltjoint

HERE = Path(__file__).parent
#: pages whose text lies outside of this folder, by the name of their page here
ELSEWHERE = {
    "changes": HERE.parent / "CHANGELOG.md",
    "contributing": HERE.parent / "CONTRIBUTING.md",
    "keys": HERE.parent / "config/README.md",
}
#: files that pages of the repository link to, by the page that stands for them
STANDS_FOR = {path: f"{name}.md" for name, path in ELSEWHERE.items()}
STANDS_FOR |= {HERE.parent / "README.md": "index.md", HERE.parent / "CITATION.cff": "cite.md"}

project = "boltjoint"
author = "The boltjoint developers"
version = release = boltjoint.__version__
extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_templates", "gallery"]
templates_path = ["_templates"]
highlight_language = "none"  # of blocks without a language
html_math_renderer = "mathml"
suppress_warnings = ["config.cache"]  # the order of examples is a function

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4

autodoc_typehints = "none"  # units and shapes are in the text
autosummary_generate = True
numpydoc_show_class_members = False
#: of every public class, what is computed from its parameters
autosummary_context = {
    "properties": {
        name: sorted(
            key
            for key, value in vars(found).items()
            if isinstance(value, (property, cached_property)) and not key.startswith("_")
        )
        for name in boltjoint._NAMES
        if isinstance(found := getattr(boltjoint, name), type)
    }
}

html_theme = "pydata_sphinx_theme"
html_title = "boltjoint"
html_copy_source = False
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "header_links_before_dropdown": 6,
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc", "sg_download_links"],
    "footer_start": ["copyright"],
    "footer_end": ["sphinx-version"],
}
html_sidebars = {"index": [], "tutorial": [], "cite": []}

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": r"/\d\d_",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "capture_repr": (),
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "plot_gallery": os.environ.get("BOLTJOINT_GALLERY", "run") == "run",
    "abort_on_example_error": True,
}
sys.path.insert(0, str(HERE / "gallery"))


def _mathml(translator: object, source: str, display: str, number: str = "") -> None:
    """Write an equation as MathML, which browsers draw themselves."""
    source, numbers = (
        re.subn(r"\\tag\{(.*?)\}", "", source)[0],
        re.findall(r"\\tag\{(.*?)\}", source),
    )
    translator.body.append(convert(source.strip(), display=display))
    for each in numbers:
        translator.body.append(f'<span class="eqno">({each})</span>')


def _inline(translator: object, node: nodes.math) -> None:
    _mathml(translator, node.astext(), "inline")
    raise nodes.SkipNode


def _block(translator: object, node: nodes.math_block) -> None:
    translator.body.append('<div class="math">')
    _mathml(translator, node.astext(), "block")
    translator.body.append("</div>\n")
    raise nodes.SkipNode


def _read(app: Sphinx, name: str, source: list[str]) -> None:
    """Take the text of a page that lies elsewhere, and let its links lead to pages of the site."""
    path = ELSEWHERE.get(name, HERE / f"{name}.md")
    if name in ELSEWHERE:
        source[0] = path.read_text(encoding="utf-8")
        app.env.note_dependency(path)

    def led(match: re.Match[str]) -> str:
        file, anchor = match.groups()
        target = Path(os.path.normpath(path.parent / file))
        if target in STANDS_FOR:
            target = HERE / STANDS_FOR[target]
        if not target.exists():
            return match[0]
        return f"]({os.path.relpath(target, (HERE / name).parent)}{anchor or ''})"

    if not name.startswith("examples/"):
        source[0] = re.sub(r"\]\(([\w./-]+)(#[\w-]+)?\)", led, source[0])


def setup(app: Sphinx) -> None:
    """Equations as MathML, and pages whose text lies elsewhere."""
    app.add_html_math_renderer(
        "mathml", inline_renderers=(_inline, None), block_renderers=(_block, None)
    )
    app.connect("source-read", _read)
