"""Which figures and tables does a study have, and where do they belong?"""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from boltjoint.names import NAME, JointName, is_enriched
from boltjoint.report.pages.markup import Section, drawing, number, source, table
from boltjoint.study.published import BASIS, Published
from boltjoint.study.tables import files as tables

_FAMILY = r"_(?P<modes>(?:free|enriched)-\d+)"
_REGIONS = r"(?:regions|clusters)=(?:\d+|auto)"
_FEW = rf"_(?P<joint>{_REGIONS}_(?:elements|harmonic)=\d+)"
_JOINT = rf"_(?P<joint>node-to-node|{_REGIONS}(?:_(?:elements|harmonic)=\d+|_table)?)"
_RESONANCE = r"_resonance=(?P<resonance>\d+)"
_SOLVED = rf"{_JOINT}_(?P<coordinates>linear|backbone|(?:complex-)?rdnm-\d+){_RESONANCE}"
_PRELOAD = r"_preload=(?P<newton>[0-9.e+-]+)"

#: what follows the name of an assembly, by kind of figure or table
_OF_ASSEMBLIES = {
    "mesh": "",
    "modes": _FAMILY,
    "contact": _PRELOAD,
    "deformation": _PRELOAD,
    "patterns": "",
}
#: what follows the name of a case; a table and a figure may be of one kind
_OF_CASES = {
    "accuracy": _FAMILY,
    "backbone": _FAMILY + _RESONANCE,
    "bases": "",
    "divisions": _FAMILY,
    "fits": _FAMILY,
    "harmonic_peaks": _FAMILY,
    "harmonics": _FAMILY,
    "models": "",
    "states": rf"{_FAMILY}(?:{_SOLVED})?",
    "times": rf"{_FAMILY}(?:{_RESONANCE})?",
    "regions": rf"{_FAMILY}_(?P<joint>{_REGIONS})",
    "elements": _FAMILY + _FEW,
    "loops": _FAMILY + _FEW,
    "response": _FAMILY + _SOLVED,
}
#: how far models, bases and regions are from converged, whatever they are of
_OF_ACCURACY = ("bases", "divisions", "models", "patterns")
#: what follows the kind where all assemblies stand together
_OF_ALL_ASSEMBLIES = {"natural_frequencies": _FAMILY, "contact": ""}

# An assembly or a case may be called like anything else in a name, such as free-8 or a_linear. So
# what a kind ends in is read from the end; none of it can be left out, and names have no "=".
_NAMES = [
    *(rf"(?P<kind>{kind}){ending}" for kind, ending in _OF_ALL_ASSEMBLIES.items()),
    *(
        rf"(?P<kind>{kind})_(?P<subject>{NAME.strip('^$')}){ending}"
        for kind, ending in (_OF_ASSEMBLIES | _OF_CASES).items()
    ),
]

_NONE = pd.DataFrame(columns=["harmonics"])

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
        """What the file of this name shows; the whole name is the kind where it is another."""
        stem = Path(path).stem
        matches = (re.fullmatch(name, stem) for name in _NAMES)
        found = next((match for match in matches if match), None)
        part = found.groupdict() if found else {"kind": stem}
        joint, resonance, newton = map(part.get, ("joint", "resonance", "newton"))
        return cls(
            path=str(path),
            kind=part["kind"],
            subject=part.get("subject"),
            modes=part.get("modes"),
            joint=JointName(joint.replace("_", "/")) if joint else None,
            coordinates=part.get("coordinates"),
            resonance=int(resonance) if resonance else None,
            newton=float(newton) if newton else None,
        )

    @property
    def stem(self) -> str:
        """The file's name without its ending."""
        return Path(self.path).stem

    @property
    def anchor(self) -> str:
        """By which links find it on its page, where a figure and a table may have one name."""
        return self.stem if self.is_figure else f"{self.stem}-table"

    @property
    def is_figure(self) -> bool:
        """Whether it is a figure, not a table."""
        return self.path.endswith(".svg")

    def page(self, cases: Collection[str]) -> str:
        """The name of the page that shows it: of one of the cases, or one of ``names.PAGES``.

        The structure has what is about assemblies, the overview what is about all cases, accuracy
        how far models are from converged.
        """
        if self.kind in _OF_ACCURACY:
            return "accuracy"
        if self.kind in _OF_ASSEMBLIES or self.kind in _OF_ALL_ASSEMBLIES:
            return "structure"
        return self.subject if self.subject in cases else "overview"

    @property
    def from_page(self) -> str:
        """The file as a page links to it."""
        return f"../{'figures' if self.is_figure else 'tables'}/{Path(self.path).name}"

    def in_source(self, published: Published) -> list[str]:
        """Numbers of the figures by which the source shows the same, in its one basis."""
        if self.modes not in (None, BASIS):
            return []
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
        One of ``names.PAGES``, or the name of a case.
    files
        Such as ``study.contents`` lists them.
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
        found = self._find(kind, True, which)
        self._left = [each for each in self._left if each not in found]
        return "".join(self._drawn(each, title, notes) for each in found)

    def table(self, kind: str, **which: object) -> tuple[Shown, pd.DataFrame] | None:
        """The first such table that is still on the shelf, and its content."""
        found = self._find(kind, False, which)
        if not found:
            return None
        self._left.remove(found[0])
        return found[0], _read(found[0].path)

    def rest(self) -> list[Section]:
        """A section of what has found no place, so that nothing is out of reach."""
        left, self._left = self._left, []
        body = ""
        for each in left:
            title = each.stem.replace("_", " ")
            if each.is_figure:
                body += self._drawn(each, title, ())
            else:
                body += table(_read(each.path), title, (), each.anchor, each.from_page)
        return [Section("further", "Further figures and tables", body)] if body else []

    def _find(self, kind: str, figure: bool, which: dict[str, object]) -> list[Shown]:
        return [
            each
            for each in self._left
            if each.kind == kind
            and each.is_figure == figure
            and all(getattr(each, name) == value for name, value in which.items())
        ]

    def _drawn(self, shown: Shown, title: str, notes: Sequence[str]) -> str:
        filled = title.format(subject=shown.subject, newton=f"{shown.newton or 0:.15g}")
        numbers = source("Figure", shown.in_source(self.published))
        return drawing(shown.path, filled, [*notes, numbers], shown.from_page)


def one_harmonic(shelf: Shelf) -> str:
    """What the reference of all errors is, and by how much its few harmonics err, as HTML.

    By the tables of peaks with more harmonics that are on the shelf: those of bases that hold the
    contact, where there are any.
    """
    found = []
    while of_basis := shelf.table("harmonic_peaks"):
        found.append(of_basis)
    found = [each for each in found if is_enriched(each[0].modes)] or found
    frames = [frame for _, frame in found if len(frame)]
    few = pd.concat([one[one["harmonics"] == one["harmonics"].min()] for one in frames] or [_NONE])
    by_how_much = (
        "By how much that errs was not computed: give a case <i>verification_forces_N</i>."
        if few.empty
        else "No peak was found with more harmonics."
    )
    if off := errors_in_words(few):
        forces = ", ".join(f"{force:g}" for force in sorted(few.dropna()["force_N"].unique()))
        by_how_much = (
            f"Its peaks are off by up to {off} against the most harmonics with which they were "
            f"found, at {forces} N; the pages of the cases have each."
        )
    return (
        "<p><strong>The reference of all errors is converged in the basis, with "
        f"{harmonics_in_words(few)}.</strong> {by_how_much}</p>"
    )


def errors_in_words(few: pd.DataFrame) -> str:
    """The largest errors of peaks in amplitude and frequency; empty where there are none."""
    solved = few.dropna()
    return " and ".join(
        f"{number(solved[f'peak_{what}_error_percent'].abs().max(), 2)} % in {what}"
        for what in ("amplitude", "frequency")
        if len(solved)
    )


def harmonics_in_words(few: pd.DataFrame) -> str:
    """With how many harmonics the rows of a table were solved."""
    numbers = few["harmonics"].unique()
    return "one harmonic" if list(numbers) in ([], [1]) else f"harmonics up to {max(numbers)}"


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
        "accuracy.html": "Accuracy",
        "structure.html": "Structure",
        **{f"{name}.html": name for name in cases},
    }


def _read(path: str) -> pd.DataFrame:
    # 3.10 is not 3.1
    return tables.read(path, dtype={"source_table": str})
