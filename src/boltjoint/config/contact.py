"""Contact of a case: the friction law and its quantities, as the laws declare them."""

from functools import reduce
from operator import or_
from typing import Annotated, Any, Literal

from pydantic import Field, create_model

from boltjoint.config.entries import Entry
from boltjoint.config.types import Number
from boltjoint.friction.declarations import DECLARATIONS, LawDeclaration

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
    def options(self) -> dict[str, Any]:
        """The law's name, and the arguments of its ``from_contact``."""
        keys = {each.name: getattr(self, each.key) for each in self.declaration.keys}
        return {"law": self.law, **keys}


def _entry(law: LawDeclaration) -> type[ContactEntry]:
    """The entry of a law."""
    fields = {
        each.key: (Annotated[Number, Field(**each.limits)], Field(description=each.meaning))
        for each in law.keys
    }
    return create_model(
        f"{''.join(part.capitalize() for part in law.name.split('-'))}Contact",
        __base__=ContactEntry,
        __doc__=law.meaning,
        __module__=__name__,
        law=(Literal[law.name], Field(description=_LAW)),
        **fields,
    )


Contact = Annotated[reduce(or_, map(_entry, _OF_PAIRS)), Field(discriminator="law")]
