"""The JSON schemas allow and refuse what the loader does, by thousands of changed files."""

import collections
import json

import jsonschema
import pytest
from mutations import ROOT, mutations, whole_files
from pydantic import ValidationError

from boltjoint.config.schema import SCHEMAS

#: of the files of ``mutations``
SCHEMA_OF = {"config": "config", "assembly": "assembly", "constant": "case", "variable": "case"}


def schema_of(name):
    return json.loads((ROOT / f"config/schemas/{name}.schema.json").read_text(encoding="utf-8"))


def verdict(model, content):
    """What the loader says: allowed, refused for a key alone, or for keys that contradict."""
    try:
        model.model_validate(content)
    except ValidationError as error:
        # which a schema cannot say
        kinds = {problem["type"] for problem in error.errors(include_url=False)}
        return "contradiction" if kinds == {"value_error"} else "refused"
    return "allowed"


@pytest.fixture(scope="module")
def verdicts():
    """Of each changed file: its name, key path and content, what loader and schema say."""
    found = []
    for name, content in whole_files().items():
        model = SCHEMAS[SCHEMA_OF[name]]
        validator = jsonschema.Draft202012Validator(schema_of(SCHEMA_OF[name]))
        assert verdict(model, content) == "allowed"
        assert validator.is_valid(content)
        for changed, path in mutations(content):
            found.append(
                ((name, path, changed), verdict(model, changed), validator.is_valid(changed))
            )
    return found


def test_a_schema_refuses_what_the_loader_refuses_for_a_key_alone(verdicts):
    assert [where for where, loader, valid in verdicts if loader == "refused" and valid] == []


def test_the_loader_refuses_what_a_schema_refuses(verdicts):
    assert [where for where, loader, valid in verdicts if loader == "allowed" and not valid] == []


def test_the_changed_files_are_thousands_of_all_kinds(verdicts):
    counts = collections.Counter(loader for _, loader, _ in verdicts)
    assert counts["refused"] > 10000
    assert counts["allowed"] > 1000
    assert counts["contradiction"] > 500


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_has_only_words_of_json_schema(name):
    """Others, as gt and ge, are passed over by whatever reads it."""
    schema = schema_of(name)
    jsonschema.Draft202012Validator.check_schema(schema)
    remarks = {"$schema", "$defs", "title", "description", "default", "discriminator"}
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
