"""YAML 1.2 as plain data: keys with values, lists, strings, numbers, true, false and null.

Everything else of YAML is refused with line and column: tags, which name types to construct,
anchors and aliases, whose expansion has no bound, and a second document. A merge key ``<<`` is a
key like any other. PyYAML parses the text; values have the types of the core schema.

References
----------
YAML Ain't Markup Language (YAML) version 1.2, revision 1.2.2 (2021), section 10.3: core schema.
"""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NoReturn

import yaml

from boltjoint.regular_file import UnsuitableFile, read_bytes

#: bytes of a file, many times those of a large study; PyYAML takes seconds for so many
LARGEST_FILE = 200_000
#: levels of lists and mappings in each other, several times those of a study
DEEPEST = 20

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
        nested deeper than ``DEEPEST``, has a number that is not finite, or a tag, anchor, alias or
        second document.
    """
    if found := _NO_TEXT.search(text):
        before = text[: found.start()]
        raise TextError(f"{as_text(found[0])} is no character of a text", *_line_and_column(before))
    try:
        content = _document(yaml.parse(text, Loader=yaml.SafeLoader))
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


def resolve_types(value: Any) -> Any:  # noqa: ANN401 - YAML
    """Strings as YAML types them without quotes, also inside lists and mappings.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    if isinstance(value, Mapping):
        return {key: resolve_types(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [resolve_types(inner) for inner in value]
    return _resolve_type(value) if isinstance(value, str) else value


def as_text(value: object) -> str:
    """A value as it would stand in a file, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False, default=str)
    if not text.isprintable():
        text = json.dumps(value, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _document(events: Iterator[yaml.Event]) -> Any:  # noqa: ANN401 - YAML
    """The content of the only document; None if there is none."""
    documents: list[Any] = []
    for event in events:
        if isinstance(event, yaml.DocumentStartEvent):
            if documents:
                _refuse(event.start_mark, "begins a second document; a file holds one")
            documents.append(_content(next(events), events))
    return documents[0] if documents else None


def _content(event: yaml.Event, events: Iterator[yaml.Event], depth: int = 0) -> Any:  # noqa: ANN401
    """The value that begins with an event; its last event has then been read."""
    place = event.start_mark
    if event.anchor is not None:
        _refuse(place, "anchors (&) and aliases (*) are not allowed: write the value again")
    if event.tag is not None:
        _refuse(place, f"the tag {as_text(event.tag)} is not allowed: tags (!) mean nothing here")
    if isinstance(event, yaml.ScalarEvent):
        if found := _NO_TEXT.search(event.value):
            _refuse(place, f"{as_text(found[0])} is no character of a text")
        try:
            return _resolve_type(event.value) if event.style is None else event.value
        except ValueError as error:
            _refuse(place, str(error))
    if depth == DEEPEST:
        _refuse(place, f"is nested deeper than {DEEPEST} levels")
    if isinstance(event, yaml.SequenceStartEvent):
        inner = []
        while not isinstance(event := next(events), yaml.SequenceEndEvent):
            inner.append(_content(event, events, depth + 1))
        return inner
    mapping: dict[str, Any] = {}
    lines: dict[str, int] = {}
    while not isinstance(event := next(events), yaml.MappingEndEvent):
        key, place = _content(event, events, depth + 1), event.start_mark
        if not isinstance(key, str):
            _refuse(place, f"the key {as_text(key)} must be text")
        if key in lines:
            _refuse(place, f"the key {as_text(key)} stands twice, first in line {lines[key]}")
        lines[key] = place.line + 1
        mapping[key] = _content(next(events), events, depth + 1)
    return mapping


def _resolve_type(text: str) -> str | float | bool | None:
    if text in _CONSTANTS:
        return _CONSTANTS[text]
    try:
        if _WHOLE.fullmatch(text):
            number = int(text)
        elif _WHOLE_OF_BASE.fullmatch(text):
            number = int(text, base=0)
        elif DECIMAL.fullmatch(text):
            number = float(text)
        elif _NOT_FINITE.fullmatch(text):
            raise OverflowError
        else:
            return text
        # Python converts whole numbers of any size, but of a limited number of digits
        if abs(float(number)) == float("inf"):
            raise OverflowError
    except (OverflowError, ValueError):
        raise ValueError(f"{as_text(text)} must be a finite number") from None
    return number


def _line_and_column(before: str) -> tuple[int, int]:
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def _refuse(mark: yaml.Mark, sentence: str) -> NoReturn:
    words = " ".join(sentence.split())
    if not words.isprintable():
        words = words.encode("unicode_escape").decode()
    words = words if len(words) <= 160 else f"{words[:157]}..."
    raise TextError(words, mark.line + 1, mark.column + 1)
