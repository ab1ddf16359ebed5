"""What do the names of joints, bases and coordinates stand for? They are also folder names."""

import re
from typing import Literal, NamedTuple

#: more modes than a mesh of this kind resolves; the patterns hold the number
MOST_MODES = 100

# one name of a case among others makes the name of a file, which has room for 255 characters
NAME = r"^[A-Za-z0-9_-]{1,64}$"
MODES = r"^(?:free|enriched)-([1-9][0-9]?|100)$"
#: with a vector or more for each of the resonances by which bases are compared
COMPARED_MODES = r"^(?:free|enriched)-([2-9]|[1-9][0-9]|100)$"
COORDINATES = r"^(?:linear|backbone|(complex-)?rdnm-([1-9][0-9]?|100))$"
# six digits: more pairs, and so more regions or elements, than any mesh has
JOINT = (
    r"^(?:node-to-node|(regions|clusters)=([1-9][0-9]{0,5}|auto)"
    r"(?:/(?:(elements|harmonic)=([1-9][0-9]{0,5})|(table)))?)$"
)
#: pages of the report beside those of the cases
PAGES = ("overview", "accuracy", "structure")

#: the patterns, in words
PATTERNS = {
    NAME: "must be a file name without .yaml, of at most 64 letters, digits, _ and -",
    MODES: f"must be free-N or enriched-N, N being the number of modes, at most {MOST_MODES}",
    COMPARED_MODES: (
        f"must be free-N or enriched-N, N being the number of modes, from 2 to {MOST_MODES}"
    ),
    COORDINATES: (
        "must be linear, backbone, rdnm-N or complex-rdnm-N, "
        f"N being the number of response-dependent modes, at most {MOST_MODES}"
    ),
    JOINT: (
        "must be node-to-node, regions=N or clusters=N, N being a number below 1000000 or auto, "
        "alone or with /elements=M, /harmonic=M or /table"
    ),
}


#: joint and coordinates that all others are compared with
REFERENCE = ("node-to-node", "linear")


class JointName(NamedTuple):
    """What a joint is made of, all None for node-to-node.

    ``division``: pairs gathered in bands along the bar, or where they move alike; ``count`` of
    these, ``auto`` where a tolerance decides; ``reduction``: what stands for all elements of each,
    ``elements`` as the source fits them, those of a ``harmonic`` fit, or one ``table``; how many
    ``elements``.
    """

    division: Literal["regions", "clusters"] | None = None
    count: int | Literal["auto"] | None = None
    reduction: Literal["elements", "harmonic", "table"] | None = None
    elements: int | None = None

    @property
    def regions(self) -> str:
        """The joint of the same regions with all their elements."""
        return f"{self.division}={self.count}"


def parse_joint(name: str) -> JointName:
    """What the name of a joint stands for.

    >>> parse_joint("node-to-node").division is None
    True
    >>> tuple(parse_joint("regions=6/elements=7")), tuple(parse_joint("clusters=auto/table"))
    (('regions', 6, 'elements', 7), ('clusters', 'auto', 'table', None))
    """
    division, count, reduction, elements, table = _matched("joint", JOINT, name)
    return JointName(
        division,
        int(count) if count and count.isdigit() else count,
        reduction or table,
        None if elements is None else int(elements),
    )


def parse_modes(name: str) -> int:
    """The number of modes that the name of a basis stands for: 4 for ``free-4``."""
    (number,) = _matched("modes", MODES, name)
    return int(number)


def is_enriched(modes: str) -> bool:
    """Whether a basis holds shapes of the joint in contact beside the modes without contact."""
    return modes.startswith("enriched-")


class Coordinates(NamedTuple):
    """What a response is solved in.

    ``kind``: all modes of the basis (``linear``); ``count`` real or complex response-dependent
    ones; or rebuilt from one mode at given amplitudes (``backbone``).
    """

    kind: Literal["linear", "real", "complex", "backbone"]
    count: int | None = None


def parse_coordinates(name: str) -> Coordinates:
    """What the name of coordinates stands for.

    >>> parse_coordinates("rdnm-2"), parse_coordinates("complex-rdnm-1").kind
    (Coordinates(kind='real', count=2), 'complex')
    >>> parse_coordinates("linear")
    Coordinates(kind='linear', count=None)
    """
    is_complex, count = _matched("coordinates", COORDINATES, name)
    if count is None:
        return Coordinates("backbone" if name == "backbone" else "linear")
    return Coordinates("complex" if is_complex else "real", int(count))


def joint_in_words(name: str) -> str:
    """A joint's name for people.

    >>> joint_in_words("node-to-node"), joint_in_words("regions=6/elements=7")
    ('node-to-node', '6 regions of 7 elements')
    >>> joint_in_words("regions=1/elements=1"), joint_in_words("clusters=auto/table")
    ('1 region of 1 element', 'clusters to tolerance, tabulated')
    """
    parsed = parse_joint(name)
    if parsed.division is None:
        return "node-to-node"
    if parsed.count == "auto":
        words = f"{parsed.division} to tolerance"
    else:
        words = _counted(parsed.count, parsed.division.removesuffix("s"))
    if parsed.reduction is None:
        return words
    if parsed.reduction == "table":
        return f"{words}, tabulated"
    elements = f"{words} of {_counted(parsed.elements, 'element')}"
    return f"{elements}, harmonic fit" if parsed.reduction == "harmonic" else elements


def coordinates_in_words(name: str, short: bool = False) -> str:
    """What a response is solved in, for people; short in a legend, which has no room for more.

    >>> coordinates_in_words("linear"), coordinates_in_words("complex-rdnm-1")
    ('linear modes', '1 complex response-dependent mode')
    >>> coordinates_in_words("linear", short=True), coordinates_in_words("rdnm-1", short=True)
    ('linear modes', '1 RDNM')
    """
    kind, count = parse_coordinates(name)
    if count is None:
        return "linear modes" if kind == "linear" else kind
    complexly = "complex " if kind == "complex" else ""
    if short:
        return f"{count} {complexly}RDNM"
    return _counted(count, f"{complexly}response-dependent mode")


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' if number > 1 else ''}"


def _matched(what: str, pattern: str, name: str) -> tuple[str | None, ...]:
    match = re.fullmatch(pattern, name) if isinstance(name, str) else None
    if match is None:
        raise ValueError(f"{what} {name!r} {PATTERNS[pattern]}")
    return match.groups()
