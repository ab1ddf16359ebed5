"""Benchmarks run by hand or by ``make benchmark`` alone: what they import is sought here."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

FILES = sorted((Path(__file__).parents[1] / "benchmarks").glob("*.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_all_that_a_benchmark_takes_from_the_library_is_there(file):
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] == "boltjoint":
            for name in (alias.name for alias in node.names):
                if not hasattr(import_module(node.module), name):
                    import_module(f"{node.module}.{name}")
