"""YAML 1.2 as plain data: keys with values, lists, strings, numbers, true, false and null.

Everything else of YAML is refused with line and column: tags, which name types to construct,
anchors and aliases, whose expansion has no bound, and a second document. A merge key ``<<`` is a
key like any other. PyYAML parses the text; values have the types of the core schema.

References
----------
YAML Ain't Markup Language (YAML) version 1.2, revision 1.2.2 (2021), section 10.3: core schema.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

import yaml

from boltjoint import checks
from boltjoint.config.types import KeyPath
from boltjoint.regular_file import UnsuitableFile, read_bytes

# libyaml's parser, which wheels of PyYAML have: ten times as fast, with fewer words on errors
_FAST = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
#: bytes of a file, many times those of a large study; PyYAML takes seconds for so many
LARGEST_FILE = 200_000
#: levels of lists and mappings in each other, several times those of a study
DEEPEST = 20
#: magnitudes of numbers, many times those of any joint in any unit: powers, products and quotients
#: of some ten of them stay within floating point
SMALLEST, LARGEST = 1e-30, 1e30
LIMITS = f"0 or a number of a magnitude from {SMALLEST:g} to {LARGEST:g}"

# core schema; PyYAML itself reads scalars as YAML 1.1
_CONSTANTS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_WHOLE = re.compile(r"[-+]?[0-9]+")
_WHOLE_OF_BASE = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
#: the numbers of all files of a study
DECIMAL = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
# controls, line breaks of YAML 1.1, and what is no character; escapes in quotes can spell them too
_NO_TEXT = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")


class TextError(ValueError):
    """A text cannot be read: a sentence, and line and column where there is a place to name."""

    def __init__(self, sentence: str, line: int | None = None, column: int | None = None) -> None:
        self.place = "" if line is None else f":{line}:{column}"
        self.sentence = sentence
        super().__init__(f"{self.place}: {sentence}".removeprefix(":").lstrip())


def read_mapping(path: Path, folder: Path | None = None) -> dict[str, Any]:
    """The keys and values that a file holds.

    Parameters
    ----------
    path, folder
        The file, and the folder in which it must lie (``regular_file.read_bytes``).

    Raises
    ------
    TextError
        If the file is unsuitable (``regular_file``, with ``LARGEST_FILE``), or is not UTF-8, or see
        ``parse_mapping``.
    OSError
        If the file cannot be read.
    """
    try:
        content = read_bytes(path, LARGEST_FILE, folder)
    except UnsuitableFile as error:
        raise TextError(error.sentence) from None
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8")
        raise TextError("is not text in UTF-8", *_line_and_column(before)) from None
    return parse_mapping(text)


def parse_mapping(text: str) -> dict[str, Any]:
    """The keys and values that a text holds.

    Raises
    ------
    TextError
        With line and column, if the text is not YAML, has a key twice or one that is no text, is
        nested deeper than ``DEEPEST``, has a number beyond ``SMALLEST`` and ``LARGEST``, or
        a tag, anchor, alias or second document.
    """
    checks.instance("text", text, str)
    if no_text := _NO_TEXT.search(text):
        before = text[: no_text.start()]
        raise TextError(
            f"{as_text(no_text[0])} is no character of a text", *_line_and_column(before)
        )
    try:
        content = _parsed(text)
    except yaml.MarkedYAMLError as error:
        _refuse(error.problem_mark, error.problem)
    except TextError:
        raise
    except (ValueError, OverflowError):
        # escaped characters beyond Unicode, and versions of thousands of digits
        raise TextError("is not YAML that can be read", 1, 1) from None
    if not isinstance(content, dict):
        raise TextError("must hold keys with values, as in `description: ...`", 1, 1)
    return content


def resolve_types(content: Any) -> tuple[Any, list[tuple[KeyPath, str]]]:  # noqa: ANN401 - YAML
    """Strings as YAML types them without quotes, also inside lists and mappings.

    Beside it the key path of each number beyond the limits of numbers, with a sentence.
    """
    problems: list[tuple[KeyPath, str]] = []

    def resolved(value: Any, path: KeyPath) -> Any:  # noqa: ANN401 - YAML
        if isinstance(value, Mapping):
            return {key: resolved(inner, (*path, key)) for key, inner in value.items()}
        if isinstance(value, list):
            return [resolved(inner, (*path, index)) for index, inner in enumerate(value)]
        try:
            return _resolve_type(value) if isinstance(value, str) else _within_limits(value, value)
        except ValueError as error:
            problems.append((path, str(error)))

    return resolved(content, ()), problems


def as_text(value: object) -> str:
    """A value as it would stand in a file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    if not text.isprintable():
        text = json.dumps(value, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."


def as_word(value: object) -> str:
    """A plain word or number as it is, other values as ``as_text``."""
    text = str(value)
    return text if re.fullmatch(r"[\w./=+~\[\]-]{1,200}", text) else as_text(value)


def as_keys(path: KeyPath) -> str:
    """A key path as it stands in lines, ``solve[0].joints[1]``."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{as_word(part)}" for part in path)
    return "".join(parts).removeprefix(".")


def _parsed(text: str) -> Any:  # noqa: ANN401 - YAML
    try:
        return _document(yaml.parse(text, Loader=_FAST))
    except yaml.YAMLError:
        return _document(yaml.parse(text, Loader=yaml.SafeLoader))


def _document(events: Iterator[yaml.Event]) -> Any:  # noqa: ANN401 - YAML
    """The content of the only document; None if there is none."""
    documents: list[Any] = []
    for event in events:
        if isinstance(event, yaml.DocumentStartEvent):
            if documents:
                _refuse(event.start_mark, "begins a second document; a file holds one")
            documents.append(_content(next(events), events))
    return documents[0] if documents else None


def _content(event: yaml.Event, events: Iterator[yaml.Event], path: KeyPath = ()) -> Any:  # noqa: ANN401
    """The value at a key path, which begins with an event; its last event has then been read."""
    place = event.start_mark
    if event.anchor is not None:
        _refuse(place, "anchors (&) and aliases (*) are not allowed: write the value again")
    if event.tag is not None:
        _refuse(place, f"the tag {as_text(event.tag)} is not allowed: tags (!) mean nothing here")
    if isinstance(event, yaml.ScalarEvent):
        if no_text := _NO_TEXT.search(event.value):
            _refuse(place, f"{as_text(no_text[0])} is no character of a text")
        try:
            return event.value if event.style else _resolve_type(event.value)
        except ValueError as error:
            _refuse(place, f"{as_keys(path)}: {error}" if path else str(error))
    if len(path) == DEEPEST:
        _refuse(place, f"is nested deeper than {DEEPEST} levels")
    if isinstance(event, yaml.SequenceStartEvent):
        inner: list[Any] = []
        while not isinstance(event := next(events), yaml.SequenceEndEvent):
            inner.append(_content(event, events, (*path, len(inner))))
        return inner
    mapping: dict[str, Any] = {}
    lines: dict[str, int] = {}
    last = ""
    while not isinstance(event := next(events), yaml.MappingEndEvent):
        key, place = _content(event, events, (*path, "?")), event.start_mark
        before, written = last, getattr(event, "value", "")
        if not isinstance(key, str):
            _refuse(place, f"the key {as_text(key)} must be text{_of_decimal(before, written)}")
        if key in lines:
            _refuse(place, f"the key {as_text(key)} stands twice, first in line {lines[key]}")
        lines[key] = place.line + 1
        event = next(events)
        last = getattr(event, "value", "")
        mapping[key] = _content(event, events, (*path, key))
    return mapping


def _of_decimal(before: str, after: str) -> str:
    """What is said of digits before and after a comma between two keys in braces."""
    if re.fullmatch(r"[-+]?[0-9]{1,20}", before) and re.fullmatch(r"[0-9]{1,20}", after):
        return f": a number with decimals has a point, as in {before}.{after}"
    return ""


def _resolve_type(text: str) -> str | float | bool | None:
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    if _WHOLE.fullmatch(text):
        # Python converts whole numbers of a limited number of digits
        return _within_limits(int(text) if len(text) < 400 else math.inf, text)
    if _WHOLE_OF_BASE.fullmatch(text):
        return _within_limits(int(text, base=0), text)
    if DECIMAL.fullmatch(text):
        number = float(text)
        is_rounded = not number and re.search(r"[1-9]", re.split("[eE]", text)[0])
        return _within_limits(SMALLEST / 2 if is_rounded else number, text)
    if _NOT_FINITE.fullmatch(text):
        raise ValueError(f"{as_text(text)} must be a finite number")
    return text


def _within_limits(value: Any, text: object) -> Any:  # noqa: ANN401 - YAML
    """A value, refused if it is a number beyond the limits; ``text`` is as it was written."""
    if isinstance(value, int | float) and value and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"{as_text(text)} must be {LIMITS}")
    return value


def _line_and_column(before: str) -> tuple[int, int]:
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def _refuse(mark: yaml.Mark, sentence: str) -> NoReturn:
    words = " ".join(sentence.split())
    if not words.isprintable():
        words = words.encode("unicode_escape").decode()
    words = words if len(words) <= 160 else f"{words[:157]}..."
    raise TextError(words, mark.line + 1, mark.column + 1)
