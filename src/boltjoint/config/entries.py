"""Mappings of a YAML file as checked objects, and sentences on what is wrong with them."""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from boltjoint.config.renamed import MOVED_KEYS, REMOVED_KEYS, RENAMED_KEYS, RENAMED_VALUES
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.types import PATTERNS, KeyPath, Problems, refuse


class Entry(BaseModel):
    """A mapping of a YAML file: no unknown keys, no change once read."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    @model_validator(mode="after")
    def _values_go_together(self) -> Self:
        refuse("contradiction", self.conflicts())
        return self

    def conflicts(self) -> Problems:
        """Key path and sentence for each value that contradicts another one."""
        yield from ()


def explain(error: ValidationError, model: type[Entry], content: Mapping[str, Any]) -> Problems:
    """Key path, and value with sentence, for each problem that the validation of the content met.

    Parameters
    ----------
    error
        What was raised when ``content`` was validated as ``model``.
    """
    for problem in error.errors(include_url=False):
        location, context = problem["loc"], problem.get("ctx", {})
        path = _without_tags(location, content)
        match problem["type"]:
            case "rule" | "contradiction":
                above = _without_tags((*location, ""), content)[:-1]
                for inner, sentence in context["problems"]:
                    yield with_value(content, above + inner, sentence)
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
                yield with_value(content, path, PATTERNS[context["pattern"]])
            case "no_values":
                yield with_value(content, path, problem["msg"])
            case "literal_error" if new := _new_value(path, problem["input"]):
                yield with_value(content, path, f"is now called {new}")
            case kind:
                sentence = _SENTENCES.get(kind, f"is not suitable ({kind})").format(**context)
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
    "tuple_type": "must be a list, as in [1, 2]",
    "too_short": "must have at least {min_length} entry",
    "too_long": "must have at most {max_length} entries",
    "model_type": "must hold keys with values",
    "model_attributes_type": "must hold keys with values",
}


def _dotted(path: KeyPath) -> str:
    return ".".join(part for part in path if isinstance(part, str))


def _new_value(path: KeyPath, value: object) -> str | None:
    return RENAMED_VALUES.get(_dotted(path), {}).get(value) if isinstance(value, str) else None


def _instead(model: type[Entry], location: KeyPath, path: KeyPath) -> str:
    """What a key that is not allowed is, and what may stand in its place."""
    if new := RENAMED_KEYS.get(_dotted(path)):
        return f"now called {new}"
    if moved := MOVED_KEYS.get(_dotted(path)):
        return f"now {moved}"
    if reason := REMOVED_KEYS.get(_dotted(path)):
        return reason
    key = str(path[-1])
    if elsewhere := [owner for owner in _owners(model, path) if key in owner.model_fields]:
        tags = (f"{name}: {tag}" for owner in elsewhere for tag, name in _tags(owner).items())
        return f"a key only with {' or '.join(tags)}"
    keys = [name for owner in _owners(model, location) for name in owner.model_fields]
    return f"not a known key{choice(key, keys)}"


def _without_tags(location: KeyPath, content: Mapping[str, Any]) -> KeyPath:
    """The key path that pydantic means: it also names the member chosen from a union."""
    path: list[str | int] = []
    value: Any = content
    for part in location[:-1]:
        is_key = isinstance(value, Mapping) and part in value
        if not is_key and (isinstance(value, Mapping) or isinstance(part, str)):
            continue
        path.append(part)
        value = value[part]
    of_scalar = not isinstance(value, Mapping | Sequence) or isinstance(value, str)
    # the member of a union that is a number is named after it
    return tuple(path) if of_scalar and location[-1] else (*path, *location[-1:])


def _owners(model: type[Entry], location: KeyPath) -> list[type[Entry]]:
    """The models that can hold the last key of a location, in which a union's member is a tag."""
    owners, any_key = [model], False
    for key in (part for part in location[:-1] if isinstance(part, str)):
        if any_key:
            any_key = False
            continue
        kinds = [each.model_fields[key].annotation for each in owners if key in each.model_fields]
        inner = [held for kind in kinds for held in _models_in(kind)]
        # a tag that no member names is that of the only one with keys
        owners = inner or [owner for owner in owners if key in _tags(owner)] or owners
        any_key = any(get_origin(kind) is dict for kind in kinds)
    return owners


def _tags(model: type[Entry]) -> dict[str, str]:
    """The values by which a union tells this member, with their keys."""
    literals = {
        name: get_args(field.annotation)
        for name, field in model.model_fields.items()
        if get_origin(field.annotation) is Literal
    }
    return {values[0]: name for name, values in literals.items() if len(values) == 1}


def _models_in(annotation: object) -> Iterator[type[Entry]]:
    if isinstance(annotation, type) and issubclass(annotation, Entry):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)


def _meaning(model: type[Entry], path: KeyPath) -> str:
    """The first sentence on a key."""
    for owner in _owners(model, path):
        if field := owner.model_fields.get(str(path[-1])):
            sentence = " ".join((field.description or "").split()).partition(". ")[0]
            return f": {sentence.rstrip('.')}." if sentence else ""
    return ""


def choice(name: str, options: Sequence[str] | Mapping[str, object]) -> str:
    """The option that was probably meant, and all there are."""
    close = difflib.get_close_matches(name, options, n=1)
    meant = f"; did you mean {close[0]}?" if close else ""
    return f"{meant or ';'} there are: {', '.join(options) or 'none'}"


def with_value(content: Any, path: KeyPath, sentence: str) -> tuple[KeyPath, str]:  # noqa: ANN401
    """A problem as key path and text; the value comes first if the content gives one there."""
    for part in path:
        if isinstance(content, Mapping) and part not in content:
            return path, sentence
        content = content[part]
    return path, f"{as_text(content)} {sentence}"
