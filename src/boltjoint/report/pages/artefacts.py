"""Figures and tables of a study: what each holds, and on which page it is."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from boltjoint.names import NAME, JointName
from boltjoint.study.published import BASIS, Published

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
#: errors of models, bases and regions against converged responses
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


@dataclass(frozen=True)
class ArtefactFile:
    """A figure or a table and what it holds, as its file is named.

    Parameters
    ----------
    path
        The file.
    kind
        Such as ``response`` or ``accuracy``.
    subject
        An assembly or a case; None for all assemblies.
    basis, joint, coordinates, resonance, preload_N
        Where the name has them.
    """

    path: str
    kind: str
    subject: str | None
    basis: str | None
    joint: str | None
    coordinates: str | None
    resonance: int | None
    preload_N: float | None  # noqa: N815

    @classmethod
    def of(cls, path: str | Path) -> "ArtefactFile":
        """The artefact in a file; the kind is the whole name where that follows no pattern."""
        stem = Path(path).stem
        matches = (re.fullmatch(name, stem) for name in _NAMES)
        found = next((match for match in matches if match), None)
        part = found.groupdict() if found else {"kind": stem}
        joint, resonance, newton = map(part.get, ("joint", "resonance", "newton"))
        return cls(
            path=str(path),
            kind=part["kind"],
            subject=part.get("subject"),
            basis=part.get("modes"),
            joint=JointName(joint.replace("_", "/")) if joint else None,
            coordinates=part.get("coordinates"),
            resonance=int(resonance) if resonance else None,
            preload_N=float(newton) if newton else None,
        )

    @property
    def stem(self) -> str:
        """The file's name without its ending."""
        return Path(self.path).stem

    @property
    def anchor(self) -> str:
        """The target of links on its page, where a figure and a table may have one name."""
        return self.stem if self.is_figure else f"{self.stem}-table"

    @property
    def is_figure(self) -> bool:
        """Whether it is a figure, not a table."""
        return self.path.endswith(".svg")

    def page(self, cases: Collection[str]) -> str:
        """The name of its page: that of a case, or one of ``names.PAGES``.

        Artefacts of assemblies are on the page of the structure, errors of models on that of the
        accuracy, and those of all cases together on the overview.
        """
        if self.kind in _OF_ACCURACY:
            return "accuracy"
        if self.kind in _OF_ASSEMBLIES or self.kind in _OF_ALL_ASSEMBLIES:
            return "structure"
        return self.subject if self.subject in cases else "overview"

    @property
    def address(self) -> str:
        """The file, seen from a page."""
        return f"../{'figures' if self.is_figure else 'tables'}/{Path(self.path).name}"

    def in_source(self, published: Published) -> list[str]:
        """Numbers of the source's figures that show the same, in its one basis."""
        if self.basis not in (None, BASIS):
            return []
        of_assembly = {"assembly": self.subject}
        under_preload = {**of_assembly, "preload_N": f"{self.preload_N or 0:.15g}"}
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


def figures_and_tables(files: Sequence[str]) -> list[ArtefactFile]:
    """The figures (SVG) and tables (CSV) among a study's files, in their order."""
    pattern = re.compile(r"(^|.*/)(figures/[^/]+\.svg|tables/[^/]+\.csv)")
    return [ArtefactFile.of(path) for path in files if pattern.fullmatch(str(path))]
