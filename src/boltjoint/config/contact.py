"""Contact of a case: the friction law and its quantities, as the laws declare them."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cache, reduce
from operator import or_
from types import GenericAlias
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    TypeAdapter,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    create_model,
    model_serializer,
)

from boltjoint.config.entries import Entry
from boltjoint.config.error_messages import choice
from boltjoint.config.types import Name, Number, Problems
from boltjoint.friction.declarations import (
    DECLARATIONS,
    OWN_DECLARATIONS,
    ContactKey,
    LawDeclaration,
    combined,
)

#: laws of this package that a case can give its contact pairs
_OF_PAIRS = [law for law in OWN_DECLARATIONS.values() if law.keys is not None]

*_BEFORE, _LAST = [item.label for item in _OF_PAIRS]
_LAW = f"The friction law: {', '.join(_BEFORE)} or {_LAST}."

_SURFACES = (
    "Surfaces whose contact differs from that of all: of an assembly that has several, by their "
    "names."
)


class SurfaceEntry(Entry):
    """Contact of one surface, with keys of its law.

    What it gives replaces the values of all there, whether these are of each pair or per area.
    """

    name: Name
    """Name of the surface in the assembly."""

    law: str | None = None
    """The friction law there, where it is another one; what it needs of all surfaces, it keeps."""

    #: quantities that pairs of any law have, each once
    KEYS: ClassVar[tuple[ContactKey, ...]]

    @property
    def quantities(self) -> tuple[ContactKey, ...]:
        """What it gives, each in its form."""
        return _quantities(self, self.KEYS)

    @property
    def options(self) -> dict[str, float | str]:
        """Its own law and the quantities as ``connect_pairs`` takes them."""
        own = {} if self.law is None else {"law": self.law}
        return {**own, **_options(self, self.quantities)}

    def conflicts(self) -> Problems:
        yield from _given_twice(self, self.KEYS)
        if not self.quantities and self.law is None:
            yield ("name",), "has no values that differ from those of all surfaces: give one"

    @model_serializer(mode="wrap")
    def _only_what_is_given(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in dump(self).items() if value is not None}


class ContactEntry(Entry):
    """Contact of one friction law."""

    law: str
    """The friction law."""

    if TYPE_CHECKING:  # a field of each law, after its own
        surfaces: tuple[SurfaceEntry, ...]

    @property
    def declaration(self) -> LawDeclaration:
        """What is known of the law, or of those of all surfaces."""
        return combined([self._of_all, *(self._law_on(item) for item in self.surfaces)])

    @property
    def _of_all(self) -> LawDeclaration:
        """The law of surfaces that name none."""
        return DECLARATIONS[self.law]

    def _law_on(self, surface: SurfaceEntry) -> LawDeclaration:
        """The law of a surface."""
        return DECLARATIONS[surface.law or self.law]

    @property
    def quantities(self) -> tuple[ContactKey, ...]:
        """What the case gives beside the law, each in its form: of each pair or per area."""
        return _quantities(self, self._of_all.case_keys)

    @property
    def options(self) -> dict[str, Any]:
        """The law's name, and the quantities as ``connect_pairs`` takes them."""
        options = {"law": self.law, **_options(self, self.quantities)}
        if self.surfaces:
            options["surfaces"] = {item.name: item.options for item in self.surfaces}
        return options

    def conflicts(self) -> Problems:
        for item in self._of_all.case_keys:
            lacks = all(getattr(self, form.key) is None for form in item.forms)
            if lacks and item.per_area is not None:
                yield (item.key,), f"is missing: give {item.per_area.key}, or this of each pair"
        yield from _given_twice(self, self._of_all.case_keys)
        names = [item.name for item in self.surfaces]
        for index, surface in enumerate(self.surfaces):
            if surface.name in names[:index]:
                yield ("surfaces", index, "name"), "must not appear twice"
            for key, sentence in self._conflicts_on(surface):
                yield ("surfaces", index, key), sentence

    def _conflicts_on(self, surface: SurfaceEntry) -> Iterator[tuple[str, str]]:
        """Keys of a surface that do not fit its law."""
        law = self._law_on(surface)
        if surface.law == self.law:
            yield "law", "is that of all surfaces: leave it out"
        own = [form.key for item in law.case_keys for form in item.forms]
        for item in surface.quantities:
            if item.key not in own:
                yield item.key, f"must not be given with law: {law.name}{choice(item.key, own)}"
        of_all = {item.name for item in self._of_all.case_keys}
        for item in law.case_keys:
            if item.name not in of_all and not _quantities(surface, [item]):
                yield item.key, f"is missing, which law: {law.name} needs"

    def conflicts_of_surfaces(self, assembly: str, names: Collection[str]) -> Problems:
        """Surfaces that an assembly, whose surfaces have these names, does not have."""
        for index, item in enumerate(self.surfaces):
            if item.name not in names:
                sentence = f"is no surface of {assembly}{choice(item.name, tuple(names))}"
                yield ("contact", "surfaces", index, "name"), sentence

    @model_serializer(mode="wrap")
    def _only_what_is_given(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A quantity has one form: the other is no part of the case, nor are no surfaces."""
        return {key: value for key, value in dump(self).items() if value not in (None, ())}


def _quantities(entry: Entry, keys: Collection[ContactKey]) -> tuple[ContactKey, ...]:
    """What an entry gives of these keys, each in its form."""
    forms = (form for item in keys for form in item.forms)
    return tuple(item for item in forms if getattr(entry, item.key) is not None)


def _options(entry: Entry, quantities: Collection[ContactKey]) -> dict[str, float]:
    return {item.name: getattr(entry, item.key) for item in quantities}


def _given_twice(entry: Entry, keys: Collection[ContactKey]) -> Problems:
    """Quantities that an entry gives of each pair and per area."""
    for item in keys:
        forms = _quantities(entry, [item])
        if len(forms) > 1:
            yield (forms[1].key,), f"must not stand beside {forms[0].key}"


#: of classes without source, where pydantic would search all frames for it
_NO_DOCSTRINGS: dict[str, Any] = {"use_attribute_docstrings": False}


def _surface_entry(laws: Sequence[LawDeclaration]) -> type[SurfaceEntry]:
    """The entry of a surface that may have any of some laws, with the keys of all of them."""
    keys = tuple({key.name: key for law in laws for key in law.case_keys}.values())
    description = SurfaceEntry.model_fields["law"].description
    fields: dict[str, Any] = {
        "KEYS": (ClassVar[tuple[ContactKey, ...]], keys),
        "law": (
            Literal[tuple(law.name for law in laws)] | None,
            Field(None, description=description),
        ),
    }
    for key in keys:
        for form in key.forms:
            fields[form.key] = _number(form) | None, Field(None, description=form.meaning)
    return create_model(
        "ContactOfSurface",
        __base__=SurfaceEntry,
        __doc__=SurfaceEntry.__doc__,
        __module__=__name__,
        __cls_kwargs__=_NO_DOCSTRINGS,
        **fields,
    )


def _entry(law: LawDeclaration, surface: type[SurfaceEntry]) -> type[ContactEntry]:
    """The entry of a law, with that of surfaces."""
    fields: dict[str, Any] = {"law": (Literal[law.name], Field(description=_LAW))}
    for item in law.case_keys:
        for form, other in zip(item.forms, reversed(item.forms), strict=True):
            value, meaning = _number(form), form.meaning
            if form is other:
                fields[form.key] = value, Field(description=meaning)
            else:
                meaning = f"{meaning} Or give ``{other.key}``."
                fields[form.key] = value | None, Field(None, description=meaning)
    surfaces = GenericAlias(tuple, (surface, ...))
    fields["surfaces"] = surfaces, Field((), description=_SURFACES)
    either = [
        {"oneOf": [_has(form.key) for form in item.forms]}
        for item in law.case_keys
        if item.per_area
    ]
    return create_model(
        f"{''.join(part.capitalize() for part in law.name.split('-'))}Contact",
        __base__=ContactEntry,
        __doc__=law.meaning,
        __module__=__name__,
        __cls_kwargs__=_NO_DOCSTRINGS
        | {"json_schema_extra": {"allOf": either} if either else None},
        **fields,
    )


def _number(form: ContactKey) -> Any:  # noqa: ANN401
    """The type of a number within the limits of a quantity."""
    limits: dict[str, Any] = dict(form.limits)
    return Annotated[Number, Field(**limits)]


def _has(key: str) -> dict[str, Any]:
    """JSON schema of a mapping in which a key has a number."""
    return {"required": [key], "properties": {key: {"type": "number"}}}


ContactOfSurface = _surface_entry(_OF_PAIRS)


def _of_laws(laws: Sequence[LawDeclaration], surface: type[SurfaceEntry]) -> Any:  # noqa: ANN401
    """The union of the entries of some laws, with that of surfaces."""
    entries = [_entry(law, surface) for law in laws]
    return Annotated[reduce(or_, entries), Field(discriminator="law")]


@cache
def _with_laws_of_other_packages(names: tuple[str, ...]) -> TypeAdapter:
    """The union of the entries of all laws of this package and some of others."""
    laws = [*_OF_PAIRS, *(DECLARATIONS[name] for name in names)]
    return TypeAdapter(_of_laws(laws, _surface_entry(laws)))


def _validated(content: object, own: ValidatorFunctionWrapHandler) -> ContactEntry:
    """The entry of a law of this package, or, where content names one of another, of that."""
    others = [name for name in _laws_in(content) if name not in OWN_DECLARATIONS]
    if not others or any(name not in DECLARATIONS for name in others):
        return own(content)
    return _with_laws_of_other_packages(tuple(dict.fromkeys(others))).validate_python(content)


def _laws_in(content: object) -> Iterator[str]:
    """Names of laws in the content of a contact, whatever else it holds."""
    if not isinstance(content, Mapping):
        return
    surfaces = content.get("surfaces", ())
    surfaces = surfaces if isinstance(surfaces, Sequence) else ()
    for part in (content, *surfaces):
        if isinstance(part, Mapping) and isinstance(part.get("law"), str):
            yield part["law"]


if TYPE_CHECKING:
    Contact = ContactEntry
else:
    Contact = Annotated[_of_laws(_OF_PAIRS, ContactOfSurface), WrapValidator(_validated)]
