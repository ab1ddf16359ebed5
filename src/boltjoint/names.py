"""The grammar of the names of joints, bases and coordinates, which are folder names too.

A name is a string that knows what it stands for: it is parsed once, where it enters. Wildcards of
the workflow, patterns of the JSON schemas and the words in figures and pages follow from here.
"""

import re
from typing import ClassVar, Literal, Self

#: more modes than a mesh of this kind resolves; the patterns hold the number
MOST_MODES = 100

#: names of cases and assemblies: one of a case among others makes the name of a file, which has
#: room for 255 characters
NAME = r"^[A-Za-z0-9_-]{1,64}$"
NAME_MEANING = "must be a file name without .yaml, of at most 64 letters, digits, _ and -"

#: pages of the report beside those of the cases
PAGES = ("overview", "accuracy", "structure")

_NUMBER = r"([1-9][0-9]?|100)"
# six digits: more pairs, and so more regions or elements, than any mesh has
_COUNT = r"([1-9][0-9]{0,5})"


class ParsedName(str):
    """A string of a grammar; other strings are refused with a ``ValueError``."""

    QUANTITY: ClassVar[str]
    PATTERN: ClassVar[str]
    MEANING: ClassVar[str]

    def __new__(cls, name: str) -> Self:
        """The name, parsed."""
        match = re.fullmatch(cls.PATTERN, name) if isinstance(name, str) else None
        if match is None:
            raise ValueError(f"{cls.QUANTITY} {name!r} {cls.MEANING}")
        parsed = super().__new__(cls, name)
        parsed._read(*match.groups())
        return parsed

    @classmethod
    def wildcard(cls) -> str:
        """The grammar as a regular expression within a longer one, without groups of its own."""
        return re.sub(r"\((?!\?)", "(?:", cls.PATTERN.strip("^$"))

    def _read(self, *parts: str | None) -> None:
        raise NotImplementedError


class JointName(ParsedName):
    """What a joint is made of.

    ``division``: pairs gathered in ``regions`` along the bar, or in ``clusters`` of similar motion;
    ``count`` of these, ``auto`` where a tolerance decides; ``reduction``: what stands for all
    elements of each, ``elements`` fitted to loops, to the describing function (``harmonic``), or
    one ``table``; how many ``elements``. All None for a node-to-node joint.

    >>> name = JointName("regions=6/elements=7")
    >>> name.division, name.count, name.reduction, name.elements, name.regions
    ('regions', 6, 'elements', 7, 'regions=6')
    >>> JointName("clusters=auto/table").count, JointName("node-to-node").division is None
    ('auto', True)
    """

    QUANTITY = "joint"
    PATTERN = (
        rf"^(?:node-to-node|(regions|clusters)=(?:{_COUNT}|(auto))"
        rf"(?:/(?:(elements|harmonic)={_COUNT}|(table)))?)$"
    )
    MEANING = (
        "must be node-to-node, regions=N or clusters=N, N being a number below 1000000 or auto, "
        "alone or with /elements=M, /harmonic=M or /table"
    )

    division: Literal["regions", "clusters"] | None
    count: int | Literal["auto"] | None
    reduction: Literal["elements", "harmonic", "table"] | None
    elements: int | None

    def _read(self, *parts: str | None) -> None:
        self.division, count, auto, reduction, elements, table = parts
        self.count = int(count) if count else auto
        self.reduction = reduction or table
        self.elements = int(elements) if elements else None

    @property
    def regions(self) -> "JointName":
        """The joint of the same regions with all their elements."""
        return JointName(f"{self.division}={self.count}")

    @property
    def file_name(self) -> str:
        """The name without folders, for files of tables and figures."""
        return self.replace("/", "_")

    @property
    def label(self) -> str:
        """The joint for legends and pages.

        >>> JointName("node-to-node").label, JointName("regions=6/elements=7").label
        ('node-to-node', '6 regions of 7 elements')
        >>> JointName("regions=1/elements=1").label, JointName("clusters=auto/table").label
        ('1 region of 1 element', 'clusters to tolerance, tabulated')
        """
        if self.division is None:
            return str(self)
        if self.count == "auto":
            label = f"{self.division} to tolerance"
        else:
            label = _counted(self.count, self.division.removesuffix("s"))
        if self.reduction == "table":
            return f"{label}, tabulated"
        if self.elements is not None:
            label += f" of {_counted(self.elements, 'element')}"
        return f"{label}, harmonic fit" if self.reduction == "harmonic" else label


class Basis(ParsedName):
    """A reduction basis: ``vectors`` free-interface modes, or contact-adapted vectors.

    >>> Basis("enriched-40").vectors, Basis("enriched-40").is_contact_adapted
    (40, True)
    """

    QUANTITY = "modes"
    PATTERN = rf"^(free|enriched)-{_NUMBER}$"
    MEANING = f"must be free-N or enriched-N, N being the number of modes, at most {MOST_MODES}"

    vectors: int
    is_contact_adapted: bool

    def _read(self, *parts: str | None) -> None:
        kind, number = parts
        self.vectors, self.is_contact_adapted = int(number), kind == "enriched"


class ComparedBasis(Basis):
    """A basis with a vector or more for each of the resonances by which bases are compared."""

    PATTERN = r"^(free|enriched)-([2-9]|[1-9][0-9]|100)$"
    MEANING = f"must be free-N or enriched-N, N being the number of modes, from 2 to {MOST_MODES}"


class Coordinates(ParsedName):
    """The unknowns of a response.

    ``kind``: all modes of the basis (``linear``); ``count`` real or complex response-dependent
    ones; or modal synthesis from a ``backbone``.

    >>> Coordinates("rdnm-2").kind, Coordinates("rdnm-2").count, Coordinates("linear").count
    ('real', 2, None)
    """

    QUANTITY = "coordinates"
    PATTERN = rf"^(?:(linear|backbone)|(complex-)?rdnm-{_NUMBER})$"
    MEANING = (
        "must be linear, backbone, rdnm-N or complex-rdnm-N, "
        f"N being the number of response-dependent modes, at most {MOST_MODES}"
    )

    kind: Literal["linear", "real", "complex", "backbone"]
    count: int | None

    def _read(self, *parts: str | None) -> None:
        kind, is_complex, count = parts
        self.kind = kind or ("complex" if is_complex else "real")
        self.count = int(count) if count else None

    @property
    def label(self) -> str:
        """The coordinates for pages.

        >>> Coordinates("linear").label, Coordinates("complex-rdnm-1").label
        ('linear modes', '1 complex response-dependent mode')
        """
        if self.count is None:
            return "linear modes" if self.kind == "linear" else self.kind
        return _counted(self.count, f"{self._complex}response-dependent mode")

    @property
    def short_label(self) -> str:
        """The coordinates for legends, which have room for little.

        >>> Coordinates("linear").short_label, Coordinates("rdnm-1").short_label
        ('linear modes', '1 RDNM')
        """
        return self.label if self.count is None else f"{self.count} {self._complex}RDNM"

    @property
    def _complex(self) -> str:
        return "complex " if self.kind == "complex" else ""


#: joint and coordinates that all others are compared with
REFERENCE = (JointName("node-to-node"), Coordinates("linear"))


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' if number > 1 else ''}"
