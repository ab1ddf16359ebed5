"""Reading YAML strictly: unknown or repeated keys and unsuitable values are errors, in words."""

import difflib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, Self, get_args, get_origin

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

KeyPath = tuple[str | int, ...]


# The numbers of YAML 1.2. PyYAML follows 1.1, to which 1e8 is a word, and Snakemake reads
# config.yaml with PyYAML: so words that spell a number are numbers here.
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")


def _spelled_number(value: object) -> object:
    if isinstance(value, str) and _FLOAT.fullmatch(value):
        return float(value)
    return value


def _spelled_whole_number(value: object) -> object:
    value = _spelled_number(value)
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return value


# strict: true and false are not numbers
Number = Annotated[float, BeforeValidator(_spelled_number), Field(strict=True, allow_inf_nan=False)]
WholeNumber = Annotated[int, BeforeValidator(_spelled_whole_number), Field(strict=True)]
Positive = Annotated[Number, Field(gt=0)]
Count = Annotated[WholeNumber, Field(ge=1)]


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


def repeated(key: str, values: Sequence[object]) -> Iterator[tuple[KeyPath, str]]:
    """A conflict for each value of a list that stands there a second time."""
    for index, value in enumerate(values):
        if value in values[:index]:
            yield (key, index), "must not appear twice"


class _Loader(yaml.SafeLoader):
    """YAML 1.2 core types; a key that stands twice in a mapping is an error."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - the name PyYAML looks for

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        first: dict[Any, int] = {}
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            line = key_node.start_mark.line + 1
            if not isinstance(key, str):
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {shown(key)} must be a word", key_node.start_mark
                )
            if key in first:
                raise yaml.constructor.ConstructorError(
                    None,
                    None,
                    f"the key {shown(key)} stands twice, first in line {first[key]}",
                    key_node.start_mark,
                )
            first[key] = line
        return super().construct_mapping(node, deep=deep)


for _tag, _pattern, _first in (
    ("null", r"^(?:~|null|Null|NULL|)$", ["~", "n", "N", ""]),
    ("bool", r"^(?:true|True|TRUE|false|False|FALSE)$", list("tTfF")),
    ("int", r"^[-+]?(?:0|[1-9][0-9]*)$", list("-+0123456789")),
    (
        "float",
        rf"^(?:{_FLOAT.pattern}|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$",
        list("-+.0123456789"),
    ),
):
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(_pattern), _first)


def parse_mapping(text: str) -> dict[str, Any]:
    """The keys and values that a YAML text holds; a ``ValueError`` says what is wrong and where."""
    try:
        content = yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise ValueError(f"{where}{error.problem}") from error
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error
    if not isinstance(content, dict):
        raise ValueError("must hold keys with values, as in `description: ...`")
    return content


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
    return f": {meanings[0]}" if meanings else ""


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


def shown(value: object) -> str:
    """A value as it would stand in a file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."
