"""Types of the values that several sections share."""

from collections.abc import Iterator, Sequence
from typing import Annotated

from pydantic import Field

from boltjoint import names
from boltjoint.config.entries import INTEGRAL, Check, KeyPath
from boltjoint.names import MOST_MODES

CONFIG_FILE = "config/config.yaml"


COMMAND_LINE = "command line"


CASE_FOLDER = "config/cases"


ASSEMBLY_FOLDER = "config/assemblies"


SCHEMA_FOLDER = "config/schemas"


class ConfigError(ValueError):
    """The configuration cannot be used; one line of text for each problem of each file."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = tuple(problems)


def _page(name: str) -> Iterator[tuple[KeyPath, str]]:
    if name in names.PAGES:
        yield (), "must be another name: the report has a page called so"


Name = Annotated[str, Field(pattern=names.NAME)]


CaseName = Annotated[Name, Check(_page, {"not": {"enum": list(names.PAGES)}})]


ModesName = Annotated[str, Field(pattern=names.MODES)]


ComparedModesName = Annotated[str, Field(pattern=names.COMPARED_MODES)]


CoordinatesName = Annotated[str, Field(pattern=names.COORDINATES)]


JointName = Annotated[str, Field(pattern=names.JOINT)]


ModesCount = Annotated[int, Field(strict=True, ge=1, le=MOST_MODES), INTEGRAL]


# left out of model_dump(), so that a result made from the dump does not go stale with the text
Description = Annotated[str, Field(exclude=True)]
