"""Imports of the library point only downwards."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src/boltjoint"
#: highest first; a room imports from itself and from those after it
ROOMS = ["report", "study", "verification", "dynamics", "structure", "joint", "config"] + [
    "friction",
    "solvers",
    "workflow",
    "names",
    "dataset",
    "checks",
    "__init__",
]


@pytest.mark.parametrize("file", sorted(PACKAGE.rglob("*.py")), ids=str)
def test_imports_point_downwards(file):
    room = file.relative_to(PACKAGE).parts[0].removesuffix(".py")
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "boltjoint":
            names = [f"{node.module}.{alias.name}".split(".")[1] for alias in node.names]
            for name in names:
                below = name if name in ROOMS else "__init__"
                assert ROOMS.index(below) >= ROOMS.index(room), f"line {node.lineno}: {name}"
