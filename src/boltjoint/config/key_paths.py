"""Where in a file pydantic met a problem: key paths of its locations, and the models there.

A location also names the member that was chosen of a union, between the keys; the core schema of a
model tells both apart.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from boltjoint.config.types import KeyPath

_Schema = Mapping[str, Any]


def key_path(model: type[BaseModel], location: KeyPath) -> KeyPath:
    """The keys of a location, without the members of unions."""
    path: list[str | int] = []
    refs, schema = _root(model)
    for part in location:
        schema = schema and _unwrapped(schema, refs)
        if schema and schema["type"] == "tagged-union":
            schema = schema["choices"].get(part)
        else:
            path.append(part)
            schema = next(_within(schema, part, refs), None) if schema else None
    return tuple(path)


def owners(model: type[BaseModel], location: KeyPath) -> list[type[BaseModel]]:
    """The models that can hold the last key of a location, or of a key path.

    Of a key path, which names no members, those of all members.
    """
    refs, schema = _root(model)
    schemas = [schema]
    for part in location[:-1]:
        schemas = [inner for member in schemas for inner in _within(member, part, refs)]
    return [member["cls"] for member in _members(schemas, refs) if member["type"] == "model"]


def _root(model: type[BaseModel]) -> tuple[Mapping[str, _Schema], _Schema]:
    """The definitions that a model's core schema refers to, and that schema."""
    schema = model.__pydantic_core_schema__
    return {definition["ref"]: definition for definition in schema.get("definitions", ())}, schema


def _unwrapped(schema: _Schema, refs: Mapping[str, _Schema]) -> _Schema:
    """The schema of a value within those of defaults, validators and references."""
    while schema["type"] == "definition-ref" or ("schema" in schema and schema["type"] != "model"):
        schema = refs[schema["schema_ref"]] if "schema_ref" in schema else schema["schema"]
    return schema


def _members(schemas: Iterable[_Schema], refs: Mapping[str, _Schema]) -> Iterator[_Schema]:
    """The schemas with the members in place of unions."""
    for outer in schemas:
        schema = _unwrapped(outer, refs)
        if schema["type"] == "tagged-union":
            yield from _members(schema["choices"].values(), refs)
        else:
            yield schema


def _within(schema: _Schema, part: str | int, refs: Mapping[str, _Schema]) -> Iterator[_Schema]:
    """The schemas of the value under a key or index, or of a member of a union."""
    schema = _unwrapped(schema, refs)
    match schema["type"]:
        case "tagged-union" if part in schema["choices"]:
            yield schema["choices"][part]
        case "tagged-union":
            for member in _members([schema], refs):
                yield from _within(member, part, refs)
        case "model":
            fields = _unwrapped(schema["schema"], refs)["fields"]
            if part in fields:
                yield fields[part]["schema"]
        case "dict":
            yield schema["values_schema"]
        case "tuple" if isinstance(part, int):
            items = schema["items_schema"]
            yield items[min(part, len(items) - 1)]
