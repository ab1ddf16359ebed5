"""The grammar of the names of joints, bases and coordinates, which are folder names too.

A name is a string that knows what it stands for: it is parsed once, where it enters. Wildcards of
the workflow, patterns of the JSON schemas and the words in figures and pages follow from here.
"""

import difflib
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import ClassVar, Literal, Self

#: more modes or vectors than tolerances ask for; the patterns hold the number
MOST_MODES = 300

#: vectors that a basis whose number a tolerance decides has at least
FEWEST_AUTOMATIC = 8

#: names of cases and assemblies: one of a case among others makes the name of a file, which has
#: room for 255 characters
NAME = r"^[A-Za-z0-9_-]{1,64}$"
NAME_MEANING = "must be a file name without .yaml, of at most 64 letters, digits, _ and -"

#: tables and maps that a study names: in its folder, and as Snakemake takes them, without wildcards
#: and addresses of other machines
_FOLDER_OR_FILE = r"[^\x00-\x20\x7f./\\:{}][^\x00-\x1f\x7f/\\:{}]*"
DATA_FILE = f"^{_FOLDER_OR_FILE}(/{_FOLDER_OR_FILE})*$"
DATA_FILE_MEANING = (
    "must be a file in the folder that holds config/, as config/designs.csv, without { } : \\ and "
    "names that begin with a point"
)

#: a pattern at the end of a name that Snakemake takes for a rule whose output is its own input
REPETITION = r"(.+)\1{19}$"
REPETITION_MEANING = "must not end in a pattern that stands 20 times or more: Snakemake refuses it"

#: bolts of the same preload, one after the other, from which on they are counted
_LONG_RUN = 10

#: pages of the report beside those of the cases
PAGES = ("overview", "accuracy", "structure")

_NUMBER = r"([1-9][0-9]?|[12][0-9]{2}|300)"
# six digits: more pairs, and so more regions or elements, than any mesh has
_COUNT = r"([1-9][0-9]{0,5})"


#: words within a name
_WORD = r"[A-Za-z]+(?:-[A-Za-z]+)*"


#: what a reduction may need of a friction law
CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS = "constant normal load", "Coulomb friction elements"


@dataclass(frozen=True)
class Reduction:
    """What stands for all elements of a region; how it is made is in ``joint.reductions``.

    Parameters
    ----------
    name
        After the regions: ``/name=M`` for M elements, or ``/name``.
    label
        What follows the label of the regions; ``{elements}`` is their number.
    has_count
        Whether the name holds a number of elements.
    is_fitted
        Whether its elements are fitted, with loops and errors in ``joint.nc``.
    is_published
        Whether it is that of the source.
    needs
        What it needs of the friction law of the regions.
    options
        By the keys under ``fitting`` that concern it, the arguments that they are.
    """

    name: str
    label: str
    has_count: bool = False
    is_fitted: bool = True
    is_published: bool = False
    needs: tuple[str, ...] = (COULOMB_ELEMENTS,)
    options: Mapping[str, str] = field(default_factory=dict)


#: by name
REDUCTIONS = {
    reduction.name: reduction
    for reduction in (
        Reduction(
            "elements",
            " of {elements}",
            has_count=True,
            is_published=True,
            options={"initial_guesses": "starts", "load_fractions": "load_fractions"},
        ),
        Reduction("harmonic", " of {elements}, harmonic fit", has_count=True),
        Reduction(
            "table",
            ", tabulated",
            is_fitted=False,
            needs=(COULOMB_ELEMENTS, CONSTANT_NORMAL_LOAD),
        ),
        Reduction(
            "iwan",
            " of one Iwan element",
            needs=(COULOMB_ELEMENTS, CONSTANT_NORMAL_LOAD),
            options={"load_fractions": "load_fractions"},
        ),
    )
}
_COUNTED, _PLAIN = (
    [reduction.name for reduction in REDUCTIONS.values() if reduction.has_count == counted]
    for counted in (True, False)
)
_FORMS = [f"/{name}=M" for name in _COUNTED] + [f"/{name}" for name in _PLAIN]


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

    @classmethod
    def nearest(cls, text: str) -> Self | None:
        """The name with words of the grammar in place of misspelt ones; None if that is none.

        >>> JointName.nearest("Cluster=12/element=3"), JointName.nearest("12 clusters")
        ('clusters=12/elements=3', None)
        """
        words = re.findall(_WORD, cls.PATTERN)
        changed = re.sub(_WORD, lambda match: _nearest(match[0].lower(), words), text[:80])
        return cls(changed) if re.fullmatch(cls.PATTERN, changed) else None

    def _read(self, *parts: str | None) -> None:
        raise NotImplementedError


class JointName(ParsedName):
    """What a joint is made of.

    ``division``: pairs gathered in ``regions`` along the bar, or in ``clusters`` of similar motion;
    ``count`` of these, ``auto`` where a tolerance decides; ``reduction``: the name of what stands
    for all elements of each (``REDUCTIONS``); how many ``elements``, where the name holds their
    number. ``pairs``: how many weighted pairs stand for all, or ``auto``, in a hyper-reduced joint.
    All None for a node-to-node joint.

    >>> name = JointName("regions=6/elements=7")
    >>> name.division, name.count, name.reduction, name.elements, name.regions
    ('regions', 6, 'elements', 7, 'regions=6')
    >>> JointName("clusters=auto/table").count, JointName("node-to-node").division is None
    ('auto', True)
    >>> JointName("hyper=50").pairs, JointName("hyper=auto").pairs
    (50, 'auto')
    """

    QUANTITY = "joint"
    PATTERN = (
        rf"^(?:node-to-node|hyper=(?:{_COUNT}|(auto))|(regions|clusters)=(?:{_COUNT}|(auto))"
        rf"(?:/(?:({'|'.join(_COUNTED)})={_COUNT}|({'|'.join(_PLAIN)})))?)$"
    )
    MEANING = (
        "must be node-to-node, hyper=N, regions=N or clusters=N, N being a number below 1000000 or "
        f"auto, the last two alone or with {', '.join(_FORMS[:-1])} or {_FORMS[-1]}"
    )

    division: str | None
    # a name is counted in another sense than a string
    count: int | Literal["auto"] | None  # type: ignore[assignment]
    reduction: str | None
    elements: int | None
    pairs: int | Literal["auto"] | None

    def _read(self, *parts: str | None) -> None:
        pairs, auto_pairs, self.division, count, auto, counted, elements, plain = parts
        self.pairs = int(pairs) if pairs else "auto" if auto_pairs else None
        self.count = int(count) if count else "auto" if auto else None
        self.reduction = counted or plain
        self.elements = int(elements) if elements else None

    @property
    def regions(self) -> "JointName":
        """The joint of the same regions with all their elements."""
        return JointName(f"{self.division}={self.count}")

    @property
    def is_fitted(self) -> bool:
        """Whether it has elements that are fitted to those of its regions."""
        return self.reduction is not None and REDUCTIONS[self.reduction].is_fitted

    def missing(self, capabilities: Collection[str]) -> list[str]:
        """What its reduction needs of the friction law that is not among its capabilities."""
        needs = REDUCTIONS[self.reduction].needs if self.reduction else ()
        return [need for need in needs if need not in capabilities]

    @property
    def is_published(self) -> bool:
        """Whether it is a joint of the source: node to node, bands, or its reduction of them."""
        reduced = self.reduction is not None and not REDUCTIONS[self.reduction].is_published
        return self.division != "clusters" and self.pairs is None and not reduced

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
        if self.pairs is not None:
            few = "weighted pairs to tolerance"
            return few if self.pairs == "auto" else _counted(self.pairs, "weighted pair")
        if self.division is None or self.count is None:
            return str(self)
        if self.count == "auto":
            label = f"{self.division} to tolerance"
        else:
            label = _counted(self.count, self.division.removesuffix("s"))
        if self.reduction is None:
            return label
        return label + REDUCTIONS[self.reduction].label.format(
            elements=_counted(self.elements or 1, "element")
        )


class Basis(ParsedName):
    """A reduction basis: ``vectors`` free-interface modes, or contact-adapted vectors.

    Free-interface modes are those that bend the bar (``free``) or those of all families (``all``).

    ``vectors`` is ``auto`` where a tolerance decides; there are then from ``fewest`` to ``most``.

    >>> Basis("enriched-40").vectors, Basis("enriched-40").is_contact_adapted
    (40, True)
    >>> Basis("enriched-auto").vectors, Basis("enriched-auto").fewest, Basis("free-4").fewest
    ('auto', 8, 4)
    >>> Basis("all-12").is_contact_adapted, Basis("all-12").has_all_families
    (False, True)
    """

    QUANTITY = "modes"
    PATTERN = rf"^(?:(free|all|enriched)-{_NUMBER}|enriched-(auto))$"
    MEANING = (
        "must be free-N, all-N, enriched-N or enriched-auto, N being the number of modes, "
        f"at most {MOST_MODES}"
    )

    vectors: int | Literal["auto"]
    fewest: int
    most: int
    is_contact_adapted: bool
    has_all_families: bool

    def _read(self, *parts: str | None) -> None:
        kind, number, *_ = parts
        self.is_contact_adapted = kind not in ("free", "all")
        self.has_all_families = kind == "all"
        self.vectors = int(number) if number else "auto"
        self.fewest, self.most = (
            (int(number), int(number)) if number else (FEWEST_AUTOMATIC, MOST_MODES)
        )


class ComparedBasis(Basis):
    """A basis with a vector or more for each of the resonances by which bases are compared."""

    PATTERN = r"^(free|enriched)-([2-9]|[1-9][0-9]|[12][0-9]{2}|300)$"
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

    kind: str
    # of modes, where a string counts its parts
    count: int | None  # type: ignore[assignment]

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


class Preload(ParsedName):
    """Tension of the bolts [N]: a number for all of them, or one for each with commas between.

    ``10000x12`` stands for twelve bolts of 10000 N that follow each other, and so on from ten on.

    >>> Preload("10000").of_bolts, Preload.of(10000.0, (1.0, 0.5, 1.0))
    (10000.0, '10000,5000,10000')
    >>> Preload.of(37976.0, (1.0, 1.0)), Preload("10000,0").of_bolts
    ('37976', (10000.0, 0.0))
    >>> Preload.of(10000.0, (0.5, *12 * [1.0])), len(Preload("5000,10000x12").of_bolts)
    ('5000,10000x12', 13)
    """

    QUANTITY = "preload"
    PATTERN = r"^([0-9.e+-]+(?:x[0-9]{2,4})?(?:,[0-9.e+-]+(?:x[0-9]{2,4})?)*)$"
    MEANING = "must be a number, or one for each bolt with commas between"

    of_bolts: float | tuple[float, ...]

    def _read(self, *parts: str | None) -> None:
        values: tuple[float, ...] = ()
        for run in str(parts[0]).split(","):
            value, _, count = run.partition("x")
            values += int(count or 1) * (float(value),)
        self.of_bolts = values if len(values) > 1 else values[0]

    @classmethod
    def of(cls, preload: float, ratios: Sequence[float] | None = None) -> Self:
        """That of bolts with a preload [N] times the ratio of each, of all if there are none."""
        factors = ratios or (1.0,)
        if all(ratio == factors[0] for ratio in factors):
            factors = factors[:1]
        runs: list[str] = []
        for value, run in groupby(f"{preload * factor:.15g}" for factor in factors):
            count = len(list(run))
            runs += [f"{value}x{count}"] if count >= _LONG_RUN else count * [value]
        return cls(",".join(runs))


#: joint and coordinates that all others are compared with
REFERENCE = (JointName("node-to-node"), Coordinates("linear"))


def _nearest(word: str, words: Sequence[str]) -> str:
    """The most similar of some words, or the word itself where none is."""
    return next(iter(difflib.get_close_matches(word, words, n=1)), word)


def repeats_pattern(name: str) -> bool:
    """Whether a name ends in a pattern as ``REPETITION``."""
    return re.search(REPETITION, name) is not None


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' if number > 1 else ''}"
