"""Contact of a case: the friction law and its quantities, as the laws declare them."""

from functools import reduce
from operator import or_
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, create_model, model_serializer

from boltjoint.config.entries import Entry
from boltjoint.config.types import Number, Problems
from boltjoint.friction.declarations import DECLARATIONS, ContactKey, LawDeclaration

#: laws that a case can give its contact pairs
_OF_PAIRS = [each for each in DECLARATIONS.values() if each.keys is not None]

*_BEFORE, _LAST = [each.label for each in _OF_PAIRS]
_LAW = f"The friction law: {', '.join(_BEFORE)} or {_LAST}."


class ContactEntry(Entry):
    """Contact of one friction law."""

    law: str
    """The friction law."""

    @property
    def declaration(self) -> LawDeclaration:
        """What is known of the law."""
        return DECLARATIONS[self.law]

    @property
    def quantities(self) -> tuple[ContactKey, ...]:
        """What the case gives beside the law, each in its form: of each pair or per area."""
        forms = (form for each in self.declaration.keys for form in each.forms)
        return tuple(each for each in forms if getattr(self, each.key) is not None)

    @property
    def options(self) -> dict[str, Any]:
        """The law's name, and the quantities as ``connect_pairs`` takes them."""
        return {"law": self.law, **{each.name: getattr(self, each.key) for each in self.quantities}}

    def conflicts(self) -> Problems:
        for each in self.declaration.keys:
            given = [form for form in each.forms if getattr(self, form.key) is not None]
            if not given:
                yield (each.key,), f"is missing: or give {each.per_area.key}"
            elif len(given) > 1:
                yield (given[1].key,), f"must not stand beside {given[0].key}"

    @model_serializer(mode="wrap")
    def _only_what_is_given(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A quantity has one form: the other is no part of the case."""
        return {key: value for key, value in dump(self).items() if value is not None}


def _entry(law: LawDeclaration) -> type[ContactEntry]:
    """The entry of a law."""
    fields = {}
    for each in law.keys:
        for form, other in zip(each.forms, reversed(each.forms), strict=True):
            value, meaning = Annotated[Number, Field(**form.limits)], form.meaning
            if form is other:
                fields[form.key] = value, Field(description=meaning)
            else:
                meaning = f"{meaning} Or give ``{other.key}``."
                fields[form.key] = value | None, Field(None, description=meaning)
    either = [
        {"oneOf": [_has(form.key) for form in each.forms]} for each in law.keys if each.per_area
    ]
    return create_model(
        f"{''.join(part.capitalize() for part in law.name.split('-'))}Contact",
        __base__=ContactEntry,
        __doc__=law.meaning,
        __module__=__name__,
        __cls_kwargs__={"json_schema_extra": {"allOf": either} if either else None},
        law=(Literal[law.name], Field(description=_LAW)),
        **fields,
    )


def _has(key: str) -> dict[str, Any]:
    """JSON schema of a mapping in which a key has a number."""
    return {"required": [key], "properties": {key: {"type": "number"}}}


Contact = Annotated[reduce(or_, map(_entry, _OF_PAIRS)), Field(discriminator="law")]
