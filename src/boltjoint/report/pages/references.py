"""Figures and tables as pages refer to them: names, anchors, addresses."""

import posixpath
from pathlib import PurePosixPath

from boltjoint.report.displays import DISPLAYS
from boltjoint.study import layout
from boltjoint.study.artefact_list import Artefact

#: any page of the report: all lie in one folder
_PAGE = layout.page("overview")


def stem_of(artefact: Artefact) -> str:
    """The name of the file without its ending."""
    return PurePosixPath(artefact.path).stem


def anchor_of(artefact: Artefact) -> str:
    """The target of links on its page, where a figure and a table may have one name."""
    return stem_of(artefact) if artefact.form == "figure" else f"{stem_of(artefact)}-table"


def page_of(artefact: Artefact) -> str:
    """The page that shows a figure or table: of a case, or one of ``names.PAGES``."""
    return DISPLAYS.of(artefact).page_of(artefact)


def address_of(artefact: Artefact) -> str:
    """The file, seen from a page."""
    return posixpath.relpath(artefact.path, posixpath.dirname(layout.page(page_of(artefact))))


def address_of_sweep(name: str) -> str:
    """The interactive page of a sweep, seen from a page."""
    return posixpath.relpath(layout.path("sweep_page", sweep=name), posixpath.dirname(_PAGE))
