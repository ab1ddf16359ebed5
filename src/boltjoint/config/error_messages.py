"""Sentences on what is wrong with the content of a YAML file: misspelt keys, values, kinds."""

import difflib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError

from boltjoint.config.entries import Entry
from boltjoint.config.strict_yaml import as_text, as_word
from boltjoint.config.types import GRAMMARS, PATTERNS, KeyPath, Problems

#: problems with sentences, many times those that are shown; the rest is counted
MOST_EXPLAINED = 1000
_ANOTHER: tuple[KeyPath, str] = ((), "has another problem")


def explain(error: ValidationError, model: type[Entry], content: Mapping[str, Any]) -> Problems:
    """Key path, and value with sentence, for each problem that the validation of the content met.

    Those after the first ``MOST_EXPLAINED`` are only counted.

    Parameters
    ----------
    error
        What was raised when ``content`` was validated as ``model``.
    """
    for number, problem in enumerate(error.errors(include_url=False)):
        if number >= MOST_EXPLAINED:
            yield _ANOTHER
            continue
        location, context = problem["loc"], problem.get("ctx", {})
        path = key_path(model, location)
        match problem["type"]:
            case "rule" | "contradiction":
                for inner, sentence in context["problems"][:MOST_EXPLAINED]:
                    yield with_value(content, path + inner, sentence)
                yield from [_ANOTHER] * (len(context["problems"]) - MOST_EXPLAINED)
            case "extra_forbidden":
                yield path, f"is {_instead(model, location, path)}"
            case "missing":
                yield path, f"is missing{_meaning(model, location)}"
            case "union_tag_not_found":
                path += (context["discriminator"].strip("'"),)
                yield path, f"is missing{_meaning(model, path)}"
            case "union_tag_invalid":
                path += (context["discriminator"].strip("'"),)
                allowed = context["expected_tags"].replace("'", "").replace(", ", " or ")
                yield with_value(content, path, f"must be {allowed}")
            case "too_short" if len(problem["input"]) >= context["min_length"]:
                pass  # pydantic counts the valid items only; the invalid ones are reported
            case "string_pattern_mismatch":
                sentence = _unlike(context["pattern"], problem["input"])
                yield with_value(content, path, sentence)
            case "no_values":
                yield with_value(content, path, problem["msg"])
            case "tuple_type" if not owners(model, (*location, 0, "")):
                yield with_value(content, path, _must_be_list(problem["input"]))
            case "float_type" if (text := _with_decimal_point(problem["input"])) is not None:
                yield with_value(content, path, f"must be a number: with a point, as {text}")
            case kind:
                sentence = _SENTENCES.get(kind, problem["msg"]).format(**context)
                yield with_value(content, path, sentence.replace("'", ""))


_SENTENCES = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "finite_number": "must be a finite number",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "multiple_of": "must be a multiple of {multiple_of:g}",
    "string_type": "must be text",
    "literal_error": "must be {expected}",
    "string_too_short": "must have at least {min_length} character",
    "tuple_type": "must be a list of keys with values",
    "too_short": "must have at least {min_length} entry",
    "too_long": "must have at most {max_length} entries",
    "dict_type": "must hold keys with values",
    "model_type": "must hold keys with values",
    "model_attributes_type": "must hold keys with values",
}


def _unlike(pattern: str, text: str) -> str:
    """What is said of a text that is none of a grammar."""
    grammar = GRAMMARS.get(pattern)
    nearest = grammar and grammar.nearest(text)
    return f"is not known; did you mean {nearest}?" if nearest else PATTERNS[pattern]


def _must_be_list(value: object) -> str:
    """What is said of a value that is no list of values."""
    is_scalar = isinstance(value, str | int | float) and not isinstance(value, bool)
    example = as_word(value) if is_scalar and value != "" else "1, 2"
    return f"must be a list, as in [{example}]"


def _with_decimal_point(value: object) -> str | None:
    """A text that is a number with a decimal comma, with a point; None for all others."""
    if not isinstance(value, str) or not re.fullmatch(r"[-+]?[0-9]{1,40},[0-9]{1,40}", value):
        return None
    return value.replace(",", ".")


def _instead(model: type[Entry], location: KeyPath, path: KeyPath) -> str:
    """What a key that is not allowed is, and what may stand in its place."""
    key = str(path[-1])
    if elsewhere := [owner for owner in owners(model, path) if key in owner.model_fields]:
        tags = (f"{name}: {tag}" for owner in elsewhere for tag, name in _tags(owner).items())
        return f"a key only with {' or '.join(tags)}"
    keys = [name for owner in owners(model, location) for name in owner.model_fields]
    return f"not a known key{choice(key, keys)}"


def _tags(model: type[BaseModel]) -> dict[str, str]:
    """The values by which a union tells this member, with their keys."""
    literals = {
        name: get_args(field.annotation)
        for name, field in model.model_fields.items()
        if get_origin(field.annotation) is Literal
    }
    return {values[0]: name for name, values in literals.items() if len(values) == 1}


def _meaning(model: type[Entry], path: KeyPath) -> str:
    """The first sentence on a key."""
    for owner in owners(model, path):
        if field := owner.model_fields.get(str(path[-1])):
            sentence = " ".join((field.description or "").split()).partition(". ")[0]
            return f": {sentence.rstrip('.')}." if sentence else ""
    return ""


def choice(name: str, options: Collection[str]) -> str:
    """The option that was probably meant, and all there are."""
    close = difflib.get_close_matches(name, options, n=1)
    if close and len(options) == 1:
        return f"; did you mean {close[0]}?"
    meant = f"; did you mean {close[0]}?" if close else ";"
    return f"{meant} there are: {', '.join(options) or 'none'}"


def with_value(content: Any, path: KeyPath, sentence: str) -> tuple[KeyPath, str]:  # noqa: ANN401
    """A problem as key path and text; the value comes first if the content gives one there."""
    for part in path:
        try:
            content = content[part]
        except (LookupError, TypeError):
            return path, sentence
    return path, f"{as_text(content)} {sentence}"


_Schema = Mapping[str, Any]


def key_path(model: type[BaseModel], location: KeyPath) -> KeyPath:
    """The keys of a location, without the members of unions."""
    path: list[str | int] = []
    refs, root = _root(model)
    schema: _Schema | None = root
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
