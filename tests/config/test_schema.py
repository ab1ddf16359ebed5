"""The JSON schemas are those of the sections, and allow and refuse what the loader does."""

import collections
import json
import re

import jsonschema
import pytest
from mutations import ROOT, samples, whole_files

from boltjoint.config.reference import SCHEMAS, schema_text
from boltjoint.config.strict_yaml import parse_mapping

#: of the files of ``whole_files``
SCHEMA_OF = {
    "config": "config",
    "assembly": "assembly",
    "washers": "assembly",
    "constant": "case",
    "variable": "case",
}


def schema_of(name):
    return json.loads((ROOT / f"config/schemas/{name}.schema.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def verdicts():
    """Of changed files: name, key path and content, what the loader and what the schema says."""
    found = []
    for name, content in whole_files().items():
        validator = jsonschema.Draft202012Validator(schema_of(SCHEMA_OF[name]))
        assert validator.is_valid(content)
        for path, changed, verdict in samples(content, SCHEMAS[SCHEMA_OF[name]]):
            found.append(((name, path, changed), verdict, validator.is_valid(changed)))
    return found


def test_a_schema_refuses_what_the_loader_refuses_for_a_key_alone(verdicts):
    assert [where for where, loader, valid in verdicts if loader == "refused" and valid] == []


def test_the_loader_refuses_what_a_schema_refuses(verdicts):
    assert [where for where, loader, valid in verdicts if loader == "allowed" and not valid] == []


def test_the_changed_files_are_of_all_kinds(verdicts):
    counts = collections.Counter(loader for _, loader, _ in verdicts)
    assert counts["refused"] > 1000
    assert counts["allowed"] > 150
    assert counts["contradiction"] > 50


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_has_only_words_of_json_schema(name):
    """Others, as gt and ge, are passed over by whatever reads it."""
    schema = schema_of(name)
    jsonschema.Draft202012Validator.check_schema(schema)
    remarks = {"$schema", "$defs", "title", "description", "default", "discriminator", "x-unit"}
    assert words_of(schema) <= set(jsonschema.Draft202012Validator.VALIDATORS) | remarks


def words_of(schema):
    words = set(schema)
    for word, value in schema.items():
        if word in ("properties", "$defs"):
            inner = value.values()
        elif word in ("anyOf", "oneOf", "prefixItems"):
            inner = value
        else:
            inner = [value] if word in ("items", "not") else []
        words = words.union(*map(words_of, inner))
    return words


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_is_that_of_the_section(name):
    kept = (ROOT / "config/schemas" / f"{name}.schema.json").read_text(encoding="utf-8")
    assert kept == schema_text(SCHEMAS[name]), "run: make reference"


def test_yaml_files_name_a_schema_that_accepts_them():
    files = [ROOT / "config/config.yaml", *(ROOT / "config").glob("*/*.yaml")]
    assert len(files) >= 5
    for file in files:
        text = file.read_text(encoding="utf-8")
        named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", text)
        assert named, f"{file} names no schema in its first line"
        schema = json.loads((file.parent / named[1]).read_text(encoding="utf-8"))
        jsonschema.validate(parse_mapping(text), schema)
