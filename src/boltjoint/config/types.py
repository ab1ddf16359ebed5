"""Types of the values that several sections share, and where the files of a study lie."""

from collections.abc import Iterator, Sequence
from typing import Annotated, TypeVar

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

KeyPath = tuple[str | int, ...]
Problems = Iterator[tuple[KeyPath, str]]
"""Key path within a value and what is wrong there, as a sentence without a subject."""


class ConfigError(ValueError):
    """The configuration cannot be used; one line of text for each problem of each file."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


def refuse(kind: str, problems: Problems) -> None:
    """Make the problems of a value known to pydantic, if there are any.

    Parameters
    ----------
    kind
        ``rule`` for what a JSON schema can say, ``contradiction`` for what it cannot.
    """
    if found := list(dict.fromkeys(problems)):
        sentences = "; ".join(sentence for _, sentence in found)
        raise PydanticCustomError(kind, "{sentences}", {"sentences": sentences, "problems": found})


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


#: makes numbers such as 5e3 whole ones; it comes last, or pydantic leaves limits out of the schema
INTEGRAL = BeforeValidator(_integral)
# strict: true and false are not numbers
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Fraction = Annotated[Number, Field(gt=0, lt=1)]
Count = Annotated[int, Field(strict=True, ge=1), INTEGRAL]
ModesCount = Annotated[int, Field(strict=True, ge=1, le=names.MOST_MODES), INTEGRAL]

ItemT = TypeVar("ItemT")
Distinct = Annotated[
    ItemT, Field(json_schema_extra={"uniqueItems": True}), AfterValidator(_distinct)
]
Several = Distinct[Annotated[tuple[ItemT, ...], Field(min_length=1)]]

Name = Annotated[str, Field(pattern=names.NAME)]
CaseName = Annotated[
    Name,
    Field(json_schema_extra={"not": {"enum": list(names.PAGES)}}),
    AfterValidator(_no_page),
]
DataFile = Annotated[str, Field(pattern=names.DATA_FILE)]
Joint = Annotated[str, Field(pattern=JointName.PATTERN), AfterValidator(JointName)]
ModalBasis = Annotated[str, Field(pattern=Basis.PATTERN), AfterValidator(Basis)]
ComparedModalBasis = Annotated[
    str, Field(pattern=ComparedBasis.PATTERN), AfterValidator(ComparedBasis)
]
Unknowns = Annotated[str, Field(pattern=Coordinates.PATTERN), AfterValidator(Coordinates)]
#: what each pattern asks for
PATTERNS = {
    names.NAME: names.NAME_MEANING,
    names.DATA_FILE: names.DATA_FILE_MEANING,
    **{each.PATTERN: each.MEANING for each in (JointName, Basis, ComparedBasis, Coordinates)},
}

# left out of model_dump(), so that a result made from the dump does not go stale with the text
Description = Annotated[str, Field(exclude=True)]
