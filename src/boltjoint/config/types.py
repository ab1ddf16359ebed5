"""Types of the values that several sections share, and where the files of a study lie."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field
from pydantic_core import PydanticCustomError

from boltjoint import names
from boltjoint.names import Basis, ComparedBasis, Coordinates, JointName

CONFIG_FILE = "config/config.yaml"
COMMAND_LINE = "command line"
CASE_FOLDER = "config/cases"
ASSEMBLY_FOLDER = "config/assemblies"
SWEEP_FOLDER = "config/sweeps"
SCHEMA_FOLDER = "config/schemas"

#: files of matrices of another program, which lie where tables do
MATRIX_FILE = rf"{names.DATA_FILE.removesuffix('$')}\.(npz|mat|mtx|unv|uff)$"
MATRIX_FILE_MEANING = (
    "must be a file .npz, .mat, .mtx, .unv or .uff in the folder that holds config/, as "
    "config/joint.npz, without { } : \\ and names that begin with a point"
)
#: decks of other programs
DECK_FILE = rf"{names.DATA_FILE.removesuffix('$')}\.inp$"
DECK_FILE_MEANING = (
    "must be a file .inp in the folder that holds config/, as config/joint.inp, without { } : \\ "
    "and names that begin with a point"
)
#: name of a surface, a set or a constraint in a deck
DECK_NAME = r"^[^,*=\x00-\x1f\x7f-\x9f]{1,80}$"
DECK_NAME_MEANING = "must be a name in a deck, of at most 80 characters, without , * ="
#: kind of elements in a deck
ELEMENT_KIND = r"^C3D[0-9]{1,2}[A-Z]{0,3}$"
ELEMENT_KIND_MEANING = "must be a kind of solid elements in capitals, as C3D8R"
#: name of a variable, as of MATLAB and of Python
VARIABLE = r"^[A-Za-z][A-Za-z0-9_]{0,62}$"
VARIABLE_MEANING = "must be a name of a letter and at most 62 letters, digits and _"

KeyPath = tuple[str | int, ...]
Problems = Iterator[tuple[KeyPath, str]]
"""Key path within a value and what is wrong there, as a sentence without a subject."""


#: characters of a line beyond which it is cut, and lines that are shown
_LONGEST_LINE, _MOST_LINES = 2000, 50


class ConfigError(ValueError):
    """The configuration cannot be used: one line of text for each problem of each file.

    All are in ``problems``; the text has the first.
    """

    def __init__(self, problems: Iterable[str]) -> None:
        self.problems = tuple(map(_one_line, problems))
        lines = list(self.problems[:_MOST_LINES])
        if more := len(self.problems) - len(lines):
            lines.append(f"and {more} more problems")
        super().__init__("\n".join(lines))


def _one_line(text: str) -> str:
    """The text with escapes in place of what is no visible character, cut where it is long."""
    text = text if len(text) <= _LONGEST_LINE else f"{text[:_LONGEST_LINE]}..."
    if text.isprintable():
        return text
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in text
    )


@contextmanager
def refusing_exceptions(place: str, what: str) -> Iterator[None]:
    """Make a ``ConfigError`` of any exception: of values that no rule thought of.

    Parameters
    ----------
    place
        File, and key path if known, where the values stand.
    what
        What is done with the values: ``checked``, ``estimated``.
    """
    try:
        yield
    except ConfigError:
        raise
    except Exception as error:
        raise ConfigError([f"{place}: {unforeseen(what, error)}"]) from error


def unforeseen(what: str, error: Exception) -> str:
    """What is said of values with which something ends in an exception."""
    return f"cannot be {what}: ends in {type(error).__name__}: {str(error)[:200]}"


def refuse(kind: str, problems: Iterable[tuple[KeyPath, str]]) -> None:
    """Make the problems of a value known to pydantic, if there are any.

    Parameters
    ----------
    kind
        ``rule`` for what a JSON schema can say, ``contradiction`` for what it cannot.
    """
    if refused := list(dict.fromkeys(problems)):
        sentences = "; ".join(sentence for _, sentence in refused)
        raise PydanticCustomError(
            kind, "{sentences}", {"sentences": sentences, "problems": refused}
        )


def _integral(value: object) -> object:
    """5e3 is a whole number too."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _distinct(values: Sequence[object]) -> Sequence[object]:
    first = {value: index for index, value in reversed(list(enumerate(values)))}
    again = (index for index, value in enumerate(values) if first[value] < index)
    refuse("rule", (((index,), "must not appear twice") for index in again))
    return values


def _no_page(name: str) -> str:
    if name in names.PAGES:
        refuse("rule", iter([((), "must be another name: the report has a page called so")]))
    return name


def _no_repetition(name: str) -> str:
    if names.repeats_pattern(name):
        refuse("rule", iter([((), names.REPETITION_MEANING)]))
    return name


#: makes numbers such as 5e3 whole ones; it comes last, or pydantic leaves limits out of the schema
INTEGRAL = BeforeValidator(_integral)
# strict: true and false are not numbers
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
_OF_KEY = Field(json_schema_extra={"x-unit": "that of the key"})
NumberOfKey = Annotated[Number, _OF_KEY]
PositiveOfKey = Annotated[Positive, _OF_KEY]
Fraction = Annotated[Number, Field(gt=0, lt=1)]
Count = Annotated[int, Field(strict=True, ge=1), INTEGRAL]
ModesCount = Annotated[int, Field(strict=True, ge=1, le=names.MOST_MODES), INTEGRAL]

ItemT = TypeVar("ItemT")
Distinct = Annotated[
    ItemT, Field(json_schema_extra={"uniqueItems": True}), AfterValidator(_distinct)
]
Several = Distinct[Annotated[tuple[ItemT, ...], Field(min_length=1)]]

_OF_PAGE, _REPETITION = {"enum": list(names.PAGES)}, {"pattern": names.REPETITION}
Name = Annotated[
    str,
    Field(pattern=names.NAME, json_schema_extra={"not": _REPETITION}),
    AfterValidator(_no_repetition),
]
CaseName = Annotated[
    Name,
    Field(json_schema_extra={"not": {"anyOf": [_OF_PAGE, _REPETITION]}}),
    AfterValidator(_no_page),
]
DataFile = Annotated[str, Field(pattern=names.DATA_FILE)]
MatrixFile = Annotated[str, Field(pattern=MATRIX_FILE)]
DeckFile = Annotated[str, Field(pattern=DECK_FILE)]
DeckName = Annotated[str, Field(pattern=DECK_NAME)]
ElementKindName = Annotated[str, Field(pattern=ELEMENT_KIND)]
VariableName = Annotated[str, Field(pattern=VARIABLE)]
if TYPE_CHECKING:
    # what the validators make of a name
    Joint = JointName
    ModalBasis = Basis
    ComparedModalBasis = ComparedBasis
    Unknowns = Coordinates
else:
    Joint = Annotated[str, Field(pattern=JointName.PATTERN), AfterValidator(JointName)]
    ModalBasis = Annotated[str, Field(pattern=Basis.PATTERN), AfterValidator(Basis)]
    ComparedModalBasis = Annotated[
        str, Field(pattern=ComparedBasis.PATTERN), AfterValidator(ComparedBasis)
    ]
    Unknowns = Annotated[str, Field(pattern=Coordinates.PATTERN), AfterValidator(Coordinates)]
#: the names of a grammar, by its pattern
GRAMMARS = {parsed.PATTERN: parsed for parsed in (JointName, Basis, ComparedBasis, Coordinates)}
#: what each pattern asks for
PATTERNS = {
    names.NAME: names.NAME_MEANING,
    names.DATA_FILE: names.DATA_FILE_MEANING,
    MATRIX_FILE: MATRIX_FILE_MEANING,
    VARIABLE: VARIABLE_MEANING,
    DECK_FILE: DECK_FILE_MEANING,
    DECK_NAME: DECK_NAME_MEANING,
    ELEMENT_KIND: ELEMENT_KIND_MEANING,
    **{pattern: grammar.MEANING for pattern, grammar in GRAMMARS.items()},
}

# left out of model_dump(), so that a result made from the dump does not go stale with the text
Description = Annotated[str, Field(exclude=True)]


#: the first chooses by size and symmetry: of symmetric half laps always the second
Factorisation = Literal["auto", "superlu", "nested-dissection", "pardiso"]

#: packages of the extra ``fast``, by the method
PACKAGES_OF_FACTORISATION = {"nested-dissection": "pymetis", "pardiso": "pypardiso"}


def conflicts_of_factorisation(method: Factorisation) -> Problems:
    """A method whose package is not installed."""
    package = PACKAGES_OF_FACTORISATION.get(method)
    if package is not None and find_spec(package) is None:
        yield ("factorisation",), f"{method} needs {package}: pip install boltjoint[fast]"
