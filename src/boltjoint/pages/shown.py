"""Which figures and tables does a study have, and where do they belong?"""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from boltjoint import layout
from boltjoint.names import parse_coordinates, parse_joint
from boltjoint.pages.markup import Section, drawing, source, table
from boltjoint.published import Published

#: figures and tables of assemblies
_OF_STRUCTURE = ("mesh", "modes", "contact", "deformation", "natural_frequencies")

_NAME = re.compile(
    r"(?P<kind>natural_frequencies|[a-z]+)"
    r"(?:_(?P<subject>(?!free-\d).+?))?"
    r"(?:_(?P<modes>free-\d+))?"
    r"(?:_(?P<joint>node-to-node|regions=\d+(?:_elements=\d+)?))?"
    r"(?:_(?P<coordinates>linear|rdnm-\d+))?"
    r"(?:_resonance=(?P<resonance>\d+))?"
    r"(?:_preload=(?P<newton>[0-9.e+-]+))?"
)

LAWS = {"constant": "constant normal load", "variable": "variable normal load"}


@dataclass(frozen=True)
class Shown:
    """What a figure or table shows, as its file is named.

    Parameters
    ----------
    path
        The file.
    kind
        Such as ``response`` or ``accuracy``.
    subject
        An assembly or a case; None for all assemblies.
    modes, joint, coordinates, resonance, newton
        Where the name has them: basis, joint, kind of coordinates, resonance and preload [N].
    """

    path: str
    kind: str
    subject: str | None
    modes: str | None
    joint: str | None
    coordinates: str | None
    resonance: int | None
    newton: float | None

    @classmethod
    def of(cls, path: str | Path) -> "Shown":
        """What the file of this name shows; a ``ValueError`` if it is not one of a study's."""
        found = _NAME.fullmatch(Path(path).stem)
        if found is None:
            raise ValueError(f"{path} is not named like a figure or table of a study")
        part = found.groupdict()
        return cls(
            path=str(path),
            kind=part["kind"],
            subject=part["subject"],
            modes=part["modes"],
            joint=layout.unflat(part["joint"]) if part["joint"] else None,
            coordinates=part["coordinates"],
            resonance=int(part["resonance"]) if part["resonance"] else None,
            newton=float(part["newton"]) if part["newton"] else None,
        )

    @property
    def stem(self) -> str:
        """The file's name without its ending: the anchor on its page."""
        return Path(self.path).stem

    @property
    def is_figure(self) -> bool:
        """Whether it is a figure, not a table."""
        return self.path.endswith(".svg")

    def page(self, cases: Collection[str]) -> str:
        """The name of the page that shows it: of one of the cases, ``structure`` or ``overview``.

        The structure has what is about assemblies, the overview what is about all cases.
        """
        if self.kind not in _OF_STRUCTURE and (self.subject is None or self.subject in cases):
            return self.subject or "overview"
        return "structure"

    @property
    def from_page(self) -> str:
        """The file as a page links to it."""
        return f"../{'figures' if self.is_figure else 'tables'}/{Path(self.path).name}"

    def in_source(self, published: Published) -> list[str]:
        """Numbers of the figures by which the source shows the same."""
        of_assembly = {"assembly": self.subject}
        under_preload = {**of_assembly, "preload_N": f"{self.newton or 0:.15g}"}
        of_joint = {"joint": self.joint}
        solved = {**of_joint, "coordinates": self.coordinates, "resonance": self.resonance}
        which = {
            "mesh": of_assembly,
            "modes": of_assembly,
            "contact": under_preload,
            "deformation": under_preload,
            "regions": of_joint,
            "loops": of_joint,
            "response": solved,
            "states": solved,
        }
        if self.kind not in which:
            return []
        return list(published.figures_of(self.kind, **which[self.kind])["figure"])


def figures_and_tables(files: Sequence[str]) -> list[Shown]:
    """Those of a study's files that are figures (SVG) or tables (CSV), in their order."""
    pattern = re.compile(r"(^|.*/)(figures/[^/]+\.svg|tables/[^/]+\.csv)")
    return [Shown.of(path) for path in files if pattern.fullmatch(str(path))]


def shown_on(page: str, files: Sequence[str], cases: Collection[str]) -> list[str]:
    """Figures and tables, among a study's files, that a page shows.

    Parameters
    ----------
    page
        ``overview``, ``structure``, or the name of a case.
    files
        Such as ``layout.targets`` lists them.
    cases
        Names of the study's cases.
    """
    return [each.path for each in figures_and_tables(files) if each.page(cases) == page]


class Shelf:
    """Figures and tables for a page, each taken when it finds its place.

    Parameters
    ----------
    files
        Figures, tables and whatever data the page is made from.
    published
        The source, by which figures are numbered.
    """

    def __init__(self, files: Sequence[str], published: Published) -> None:
        self.published = published
        self.files = list(map(str, files))
        self._left = figures_and_tables(self.files)

    def data(self, ending: str) -> list[str]:
        """Files whose names end so."""
        return [path for path in self.files if path.endswith(ending)]

    def draw(self, kind: str, title: str, *notes: str, **which: object) -> str:
        """All figures of a kind that are still on the shelf, as HTML; often one or none.

        Parameters
        ----------
        kind
            Such as ``response``.
        title, notes
            Caption; notes are HTML. ``{subject}`` and ``{newton}`` stand for those of the figure.
        which
            What else must be the same: ``modes``, ``joint``, ``coordinates`` and so on.
        """
        return "".join(self._drawn(each, title, notes) for each in self._take(kind, True, which))

    def table(self, kind: str, **which: object) -> tuple[Shown, pd.DataFrame] | None:
        """A table that is still on the shelf, and its content."""
        found = self._take(kind, False, which)
        return (found[0], _read(found[0].path)) if found else None

    def rest(self) -> list[Section]:
        """A section of what has found no place, so that nothing is out of reach."""
        left, self._left = self._left, []
        body = ""
        for each in left:
            title = each.stem.replace("_", " ")
            if each.is_figure:
                body += self._drawn(each, title, ())
            else:
                body += table(_read(each.path), title, (), each.stem, each.from_page)
        return [Section("further", "Further figures and tables", body)] if body else []

    def _take(self, kind: str, figure: bool, which: dict[str, object]) -> list[Shown]:
        found = [
            each
            for each in self._left
            if each.kind == kind
            and each.is_figure == figure
            and all(getattr(each, name) == value for name, value in which.items())
        ]
        self._left = [each for each in self._left if each not in found]
        return found

    def _drawn(self, shown: Shown, title: str, notes: Sequence[str]) -> str:
        filled = title.format(subject=shown.subject, newton=f"{shown.newton or 0:.15g}")
        numbers = source("Figure", shown.in_source(self.published))
        return drawing(shown.path, filled, [*notes, numbers], shown.from_page)


def joint_in_words(joint: str) -> str:
    """A joint's name for people.

    >>> joint_in_words("node-to-node"), joint_in_words("regions=6/elements=7")
    ('node-to-node joint', '6 regions of 7 elements')
    """
    regions, elements = parse_joint(joint)
    if regions is None:
        return "node-to-node joint"
    return f"{regions} regions" + (f" of {elements} elements" if elements else "")


def coordinates_in_words(coordinates: str) -> str:
    """What a response was solved in, for people.

    >>> coordinates_in_words("linear"), coordinates_in_words("rdnm-1")
    ('linear modes', '1 response-dependent mode')
    """
    modes = parse_coordinates(coordinates)
    if modes is None:
        return "linear modes"
    return f"{modes} response-dependent mode{'s' if modes > 1 else ''}"


def capitalized(words: str) -> str:
    """The same words with a capital at their start."""
    return words[:1].upper() + words[1:]


def those(frame: pd.DataFrame, **which: object) -> pd.DataFrame:
    """Rows of a table that have these values."""
    keep = pd.Series(True, index=frame.index)
    for column, value in which.items():
        keep &= frame[column] == value
    return frame[keep]


def menu(cases: Sequence[str]) -> dict[str, str]:
    """What the pages of a report are called, by their files, in their order."""
    return {
        "overview.html": "Overview",
        "structure.html": "Structure",
        **{f"{name}.html": name for name in cases},
    }


def _read(path: str) -> pd.DataFrame:
    # 3.10 is not 3.1
    return pd.read_csv(path, dtype={"source_table": str})
