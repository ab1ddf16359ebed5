"""Reference of all keys in config/README.md and JSON schemas, made from the sections themselves."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from boltjoint.config.case import Case
from boltjoint.config.deck import Deck
from boltjoint.config.entries import Entry
from boltjoint.config.flange import Flange
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.matrices import Matrices
from boltjoint.config.numerical_options import Settings
from boltjoint.config.plates import Plates
from boltjoint.config.sweep import Sweep
from boltjoint.config.types import CONFIG_FILE, PATTERNS, SCHEMA_FOLDER
from boltjoint.config.units import unit_of

Schema = dict[str, Any]

#: by the name of its file of YAML
SCHEMAS: dict[str, type[Entry]] = {
    "config": Settings,
    "assembly": LapJoint,
    "matrices": Matrices,
    "deck": Deck,
    "plates": Plates,
    "flange": Flange,
    "case": Case,
    "sweep": Sweep,
}

README = str(Path(CONFIG_FILE).with_name("README.md"))
#: what stands before and after the generated part of the README
BEGIN, END = "<!-- keys: made by `make reference` -->\n", "<!-- end of keys -->\n"
_FILES = {
    "config": "config.yaml",
    "assembly": "assemblies/*.yaml",
    "matrices": "assemblies/*.yaml, type: matrices",
    "deck": "assemblies/*.yaml, type: deck",
    "plates": "assemblies/*.yaml, type: plates",
    "flange": "assemblies/*.yaml, type: flange",
    "case": "cases/*.yaml",
    "sweep": "sweeps/*.yaml",
}
_KINDS = {
    "boolean": "`true`, `false`",
    "integer": "whole number",
    "number": "number",
    "string": "text",
}
_LIMITS = {
    "exclusiveMinimum": ">",
    "minimum": "≥",
    "exclusiveMaximum": "<",
    "maximum": "≤",
    "multipleOf": "multiple of",
}


def reference() -> str:
    """Tables of the keys of all files: meaning, unit, default and allowed values."""
    lines: list[str] = []
    for name, model in SCHEMAS.items():
        schema = model.model_json_schema()
        tables = _table(schema, schema["$defs"], set())
        lines += [f"## {_FILES[name]}\n", *_text(schema), *tables, ""]
    return "\n".join(lines)


def write_reference(folder: str | Path) -> None:
    """Write the tables into README.md of a study's folder, and the JSON schemas beside it."""
    write_schemas(Path(folder) / SCHEMA_FOLDER)
    path = Path(folder) / README
    before, rest = path.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END)[1]
    path.write_text(f"{before}{BEGIN}{reference()}{END}{after}", encoding="utf-8")


def _text(schema: Schema) -> list[str]:
    """Paragraphs on a mapping, in Markdown."""
    return [f"{_line(part)}\n" for part in schema["description"].split("\n\n")]


def _line(text: str) -> str:
    return " ".join(text.replace("``", "`").split())


def _table(schema: Schema, models: dict[str, Schema], told: set[str]) -> Iterator[str]:
    """Table of the keys of a mapping, and then of those that its keys hold, each ``told`` once."""
    yield "| key | meaning | unit | default | allowed |"
    yield "|---|---|---|---|---|"
    inner: dict[str, list[str]] = {}
    for key, field in schema["properties"].items():
        below = re.findall(r"#/\$defs/(\w+)'", str(field))
        for name in dict.fromkeys(below):
            inner.setdefault(name, []).append(f"**{key}**")
        meaning = field.get("description") or _text(models[below[0]])[0]
        default = "required" if key in schema.get("required", ()) else _default(field)
        cells = f"`{key}`", _line(meaning), _unit(key, field), default, _allowed(field)
        yield f"| {' | '.join(cells)} |"
    for name, keys in inner.items():
        constants = (
            f" with `{key}: {field['const']}`"
            for key, field in models[name]["properties"].items()
            if "const" in field
        )
        title = "".join([", ".join(keys), *constants, ": ", "\n".join(_text(models[name]))])
        if title not in told:
            told.add(title)
            yield f"\n{title}"
            yield from _table(models[name], models, told)


def _unit(key: str, field: Schema) -> str:
    """Unit that a key has or ends in, or 1 for other numbers."""
    if named := re.search("'x-unit': '([^']+)'", str(field)):
        return named[1]
    number = re.search("'type': '(number|integer)'", str(field))
    unit = unit_of(key).written
    return unit if number or unit != "1" else ""


def _default(field: Schema) -> str:
    value = field.get("default")
    if isinstance(value, dict) and value:
        return "see below"
    return "none" if value is None or value in ("", [], {}) else f"`{_value(value)}`"


def _value(value: object) -> str:
    """A value as YAML: 1e8, true, [0.3, 0.6]."""
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:g}")
    return str(value)


def _allowed(field: Schema) -> str:
    """What a JSON schema says of a value, in words."""
    once = ", each once" if field.get("uniqueItems") else ""
    match field:
        case {"anyOf": [inner, *_]}:
            return _allowed(inner)
        case {"prefixItems": [item, *others]}:
            return f"list of {len(others) + 1}: {_allowed(item)}{once}"
        case {"items": item}:
            return f"list: {_allowed(item)}{once}"
        case {"oneOf": kinds}:
            return " or ".join(dict.fromkeys(map(_allowed, kinds)))
        case {"additionalProperties": {"oneOf": [{"type": "number"}, {"type": "string"}]}}:
            return "names of columns, each with a number or a word"
        case {"additionalProperties": {"oneOf": _}}:
            return "keys of the case, each with a list or as below"
        case {"additionalProperties": {"$ref": _}}:
            return "parameters, each as below"
        case {"additionalProperties": {"type": kind, "minimum": least}}:
            return f"names of bolts, each with a {_KINDS[kind]} ≥ {least:g}"
        case {"additionalProperties": {"type": "number", "x-unit": _}}:
            return "keys of the case, each with a number"
        case {"patternProperties": _}:
            return "names of sensors, each with a number"
        case {"additionalProperties": {"type": kind}}:
            return f"names of columns, each with a {_KINDS[kind]}"
        case {"enum": values}:
            return ", ".join(f"`{value}`" for value in values)
        case {"const": value}:
            return f"`{value}`"
        case {"pattern": pattern}:
            of_pages = field.get("not", {}).get("anyOf", [{}])[0].get("enum", ())
            refused = "".join(f", not `{name}`" for name in of_pages)
            return PATTERNS[pattern].removeprefix("must be ") + refused
        case {"type": kind}:
            limits = (f" {sign} {field[key]:g}" for key, sign in _LIMITS.items() if key in field)
            return _KINDS[kind] + ",".join(limits)
        case _:
            return "keys below"


def schema_text(model: type[Entry]) -> str:
    """The JSON schema of a YAML file, as the text that is kept in config/schemas."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **model.model_json_schema(),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def write_schemas(folder: str | Path) -> None:
    """Write the JSON schemas of the YAML files into a folder."""
    for name, model in SCHEMAS.items():
        path = Path(folder) / f"{name}.schema.json"
        path.write_text(schema_text(model), encoding="utf-8")


if __name__ == "__main__":
    write_reference(Path.cwd())
