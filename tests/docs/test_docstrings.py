"""Docstrings of the public names satisfy numpydoc, but for what is named here."""

import doctest
import inspect
from importlib import import_module
from pathlib import Path

import pytest

import boltjoint

PACKAGE = Path(boltjoint.__file__).parent
#: modules whose docstrings have examples
WITH_EXAMPLES = [
    ".".join(("boltjoint", *path.relative_to(PACKAGE).with_suffix("").parts))
    for path in sorted(PACKAGE.rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]

NOT_ASKED = {
    "EX01": "examples are those of the gallery",
    "SA01": "packages are shown with their neighbours in the reference",
    "ES01": "a summary may say all",
    "PR04": "types are annotations",
    "PR08": "a description may begin with the symbol of an equation",
    "SS05": "a plural is taken for a verb",
}
#: of methods and properties, whose line may say what they take and return
NOT_ASKED_OF_METHODS = {"PR01", "RT01"}


def complaints(name, not_asked):
    validate = pytest.importorskip("numpydoc.validate").validate
    return [each for each in validate(name)["errors"] if each[0] not in not_asked]


@pytest.mark.parametrize("name", boltjoint._NAMES)
def test_a_public_name_is_documented(name):
    found = getattr(boltjoint, name)
    # where it is defined, which no lazy import hides
    assert complaints(f"{found.__module__}.{found.__qualname__}", NOT_ASKED) == []
    for key, value in vars(found).items() if isinstance(found, type) else ():
        if not key.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
            assert inspect.getdoc(value), key
            of_method = f"{found.__module__}.{found.__qualname__}.{key}"
            assert complaints(of_method, {*NOT_ASKED, *NOT_ASKED_OF_METHODS}) == []


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_in_docstrings_hold(module):
    ran = doctest.testmod(import_module(module))
    assert ran.attempted and not ran.failed


def test_each_exception_is_needed():
    asked = set()
    for name in boltjoint._NAMES:
        found = getattr(boltjoint, name)
        names = [f"{found.__module__}.{found.__qualname__}"]
        if isinstance(found, type):
            names += [
                f"{names[0]}.{key}"
                for key, value in vars(found).items()
                if inspect.isfunction(value) and not key.startswith("_")
            ]
        asked |= {code for each in names for code, _ in complaints(each, ())}
    assert asked == {*NOT_ASKED, *NOT_ASKED_OF_METHODS}
