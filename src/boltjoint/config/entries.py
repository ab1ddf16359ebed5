"""Mappings of a YAML file as checked objects, and what is wrong with them in words."""

import difflib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self, TypeVar, get_args, get_origin

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import no_info_after_validator_function

from boltjoint.config.strict_yaml import shown

KeyPath = tuple[str | int, ...]


def _integral(value: object) -> object:
    """5e3 is a whole number too."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value


#: makes numbers such as 5e3 whole ones; it comes last, or pydantic leaves limits out of the schema
INTEGRAL = BeforeValidator(_integral)
# strict: true and false are not numbers
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
Count = Annotated[int, Field(strict=True, ge=1), INTEGRAL]


@dataclass(frozen=True, eq=False)  # hashed as an object: a union must tell annotations apart
class Check:
    """A rule for a single value that pydantic has no word for, though JSON schemas have.

    Parameters
    ----------
    problems
        Key path within the value and sentence for each problem of a value.
    schema
        What the rule is in a JSON schema.
    """

    problems: Callable[[Any], Iterator[tuple[KeyPath, str]]]
    schema: Mapping[str, Any]

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """The value, if there are no problems."""
        return no_info_after_validator_function(self._checked, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """The schema of the value with the rule."""
        return {**handler(schema), **self.schema}

    def _checked(self, value: Any) -> Any:  # noqa: ANN401 - any value
        if problems := list(self.problems(value)):
            raise PydanticCustomError("check", "{problems}", {"problems": problems})
        return value


def _repeated(values: Sequence[object]) -> Iterator[tuple[KeyPath, str]]:
    before = set()
    for index, value in enumerate(values):
        if value in before:
            yield (index,), "must not appear twice"
        before.add(value)


#: the entries of a list are each there once
DISTINCT = Check(_repeated, {"uniqueItems": True})
ItemT = TypeVar("ItemT")
Several = Annotated[tuple[ItemT, ...], Field(min_length=1), DISTINCT]
Distinct = Annotated[tuple[ItemT, ...], DISTINCT]


class Conflict(ValueError):
    """Values that are each allowed but do not go together: a key path and a sentence for each."""

    def __init__(self, problems: Sequence[tuple[KeyPath, str]]) -> None:
        super().__init__("; ".join(sentence for _, sentence in problems))
        self.problems = tuple(problems)


class Entry(BaseModel):
    """A mapping of a YAML file: no unknown keys, no change once read."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    @model_validator(mode="after")
    def _values_go_together(self) -> Self:
        if problems := list(self.conflicts()):
            raise Conflict(problems)
        return self

    def conflicts(self) -> Iterator[tuple[KeyPath, str]]:
        """Key path and sentence for each value that contradicts another one."""
        yield from ()


def explained(
    error: ValidationError,
    model: type[Entry],
    content: Mapping[str, Any],
    patterns: Mapping[str, str],
) -> Iterator[tuple[KeyPath, str | None, str]]:
    """Key path, offending value and sentence for each problem that the validation met.

    Parameters
    ----------
    error
        What was raised when ``content`` was validated as ``model``.
    patterns
        What each regular expression used in the model asks for, in words.
    """
    for problem in error.errors(include_url=False):
        location = problem["loc"]
        path = _without_tags(location, content)
        context = problem.get("ctx", {})
        match problem["type"]:
            case "value_error" if isinstance(context["error"], Conflict):
                for inner, sentence in context["error"].problems:
                    yield path + inner, _shown_at(content, path + inner), sentence
            case "check":
                for inner, sentence in context["problems"]:
                    yield path + inner, _shown_at(content, path + inner), sentence
            case "extra_forbidden":
                elsewhere = [o for o in _owners(model, path) if path[-1] in o.model_fields]
                if elsewhere:
                    tags = " or ".join(map(_tag, elsewhere))
                    yield path, None, f"is a key only with {tags}"
                    continue
                keys = [key for owner in _owners(model, location) for key in owner.model_fields]
                yield path, None, f"is not a known key{choice(str(path[-1]), keys)}"
            case "missing":
                yield path, None, f"is missing{_meaning(model, location)}"
            case "union_tag_not_found":
                path += (_unquoted(context["discriminator"]),)
                yield path, None, f"is missing{_meaning(model, path)}"
            case "union_tag_invalid":
                tag = _unquoted(context["discriminator"])
                allowed = " or ".join(_unquoted(context["expected_tags"]).split(", "))
                yield (*path, tag), shown(problem["input"][tag]), f"must be {allowed}"
            case "too_short" if len(problem["input"]) >= context["min_length"]:
                pass  # pydantic counts the valid items only; the invalid ones are reported
            case "string_pattern_mismatch":
                yield path, shown(problem["input"]), patterns[context["pattern"]]
            case _:
                yield path, shown(problem["input"]), _must(problem["type"], context)


def _must(kind: str, context: Mapping[str, Any]) -> str:
    """What is allowed where a single value is not."""
    match kind:
        case "float_type":
            return "must be a number"
        case "int_type":
            return "must be a whole number"
        case "bool_type":
            return "must be true or false"
        case "finite_number":
            return "must be a finite number"
        case "greater_than":
            return f"must be greater than {context['gt']:g}"
        case "greater_than_equal":
            return f"must be at least {context['ge']:g}"
        case "less_than":
            return f"must be less than {context['lt']:g}"
        case "less_than_equal":
            return f"must be at most {context['le']:g}"
        case "multiple_of":
            return f"must be a multiple of {context['multiple_of']:g}"
        case "string_type":
            return "must be text"
        case "literal_error":
            return f"must be {_unquoted(context['expected'])}"
        case "tuple_type":
            return "must be a list, as in [1, 2]"
        case "too_short":
            return f"must have at least {context['min_length']} entry"
        case "too_long":
            return f"must have at most {context['max_length']} entries"
        case "model_type" | "model_attributes_type" | "dict_type":
            return "must hold keys with values"
        case _:
            return f"is not suitable ({kind})"


def _without_tags(location: KeyPath, content: Mapping[str, Any]) -> KeyPath:
    """The key path that pydantic means: it also names the member chosen from a union."""
    path: list[str | int] = []
    value: Any = content
    for part in location[:-1]:
        if isinstance(value, Mapping) and part not in value:
            continue
        path.append(part)
        value = value[part]
    return (*path, *location[-1:])


def _owners(model: type[Entry], location: KeyPath) -> list[type[Entry]]:
    """The models that can hold the last key of a location, in which a union's member is a tag."""
    owners = [model]
    for key in location[:-1]:
        if isinstance(key, str):
            tagged = [owner for owner in owners if _has_tag(owner, key)]
            owners = tagged or [
                inner
                for owner in owners
                if key in owner.model_fields
                for inner in _models_in(owner.model_fields[key].annotation)
            ]
    return owners


def _tag(model: type[Entry]) -> str:
    """The entry by which a union tells this member: its key and value."""
    tags = (
        f"{name}: {get_args(field.annotation)[0]}"
        for name, field in model.model_fields.items()
        if get_origin(field.annotation) is Literal
    )
    return next(tags)


def _has_tag(model: type[Entry], tag: str) -> bool:
    return any(
        get_origin(field.annotation) is Literal and tag in get_args(field.annotation)
        for field in model.model_fields.values()
    )


def _models_in(annotation: object) -> Iterator[type[Entry]]:
    if isinstance(annotation, type) and issubclass(annotation, Entry):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)


def _meaning(model: type[Entry], path: KeyPath) -> str:
    fields = [owner.model_fields.get(str(path[-1])) for owner in _owners(model, path)]
    meanings = [field.description for field in fields if field is not None and field.description]
    return f": {' '.join(meanings[0].split())}" if meanings else ""


def choice(name: str, options: Sequence[str] | Mapping[str, object]) -> str:
    """The option that was probably meant, and all there are."""
    close = difflib.get_close_matches(name, options, n=1)
    meant = f"; did you mean {close[0]}?" if close else ""
    return f"{meant or ';'} there are: {', '.join(options) or 'none'}"


def _unquoted(choice: str) -> str:
    return choice.replace("'", "")


def _shown_at(content: Any, path: KeyPath) -> str | None:  # noqa: ANN401 - YAML
    """The value under a key path as text; None where the file leaves it to its default."""
    for part in path:
        if isinstance(content, Mapping) and part not in content:
            return None
        content = content[part]
    return shown(content)
