"""Mappings of a YAML file as checked objects."""

from typing import Any, ClassVar, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from boltjoint.config.types import Problems, refuse, unforeseen


class Entry(BaseModel):
    """A mapping of a YAML file: no unknown keys, no change once read."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    @model_validator(mode="after")
    def _values_go_together(self) -> Self:
        try:
            problems = list(self.conflicts())
        except Exception as error:  # of any value that no rule thought of
            problems = [((), unforeseen("checked", error))]
        refuse("contradiction", problems)
        return self

    def conflicts(self) -> Problems:
        """Key path and sentence for each value that contradicts another one."""
        yield from ()


class EntryWithLaterKeys(Entry):
    """An entry with keys that came later and need not be given.

    What is made from its content does not depend on those that are not given, so that results from
    before stay.
    """

    LATER_KEYS: ClassVar[frozenset[str]]

    @model_serializer(mode="wrap")
    def _without_keys_not_given(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        left_out = {key for key in self.LATER_KEYS if getattr(self, key) is None}
        return {key: value for key, value in dump(self).items() if key not in left_out}
