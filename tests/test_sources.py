"""Library files behind a script, found without running anything."""

from pathlib import Path

import pytest

import boltjoint
from boltjoint.sources import library_sources

PACKAGE = Path(boltjoint.__file__).resolve().parent


@pytest.fixture
def tree(tmp_path):
    """A package ``lib`` of a few modules, and a function that lists what a script imports."""
    files = {
        "__init__.py": "raise RuntimeError('must not run')",
        "alone.py": "import numpy\n",
        "chain.py": "from lib.rooms import mesh\n",
        "cycle_a.py": "import lib.cycle_b\n",
        "cycle_b.py": "import lib.cycle_a\n",
        "functions.py": "def f(): ...\n",
        "inner.py": "def f():\n    from lib import alone\n",
        "rooms/__init__.py": "",
        "rooms/mesh.py": "from . import element\n",
        "rooms/element.py": "from ..functions import f\n",
        "rooms/deep/__init__.py": "from .last import f\n",
        "rooms/deep/last.py": "f = 1\n",
    }
    package = tmp_path / "lib"
    for name, text in files.items():
        path = package / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def imported(text):
        script = tmp_path / "script.py"
        script.write_text(text, encoding="utf-8")
        found = library_sources(script, package)
        assert found == sorted(found)
        return [Path(path).relative_to(package.resolve()).as_posix() for path in found]

    return imported


ROOMS = ["__init__.py", "functions.py", "rooms/__init__.py", "rooms/element.py", "rooms/mesh.py"]


@pytest.mark.parametrize(
    ("text", "files"),
    [
        ("import numpy\nfrom os import path\n", []),
        ("import lib\n", ["__init__.py"]),
        ("import lib.alone\n", ["__init__.py", "alone.py"]),
        ("import lib.alone as a, lib.functions\n", ["__init__.py", "alone.py", "functions.py"]),
        ("from lib import alone\n", ["__init__.py", "alone.py"]),
        ("from lib import alone as other, name\n", ["__init__.py", "alone.py"]),
        ("from lib.functions import f\n", ["__init__.py", "functions.py"]),
        ("from lib.functions import *\n", ["__init__.py", "functions.py"]),
        ("from lib.rooms import mesh\n", ROOMS),
        ("import lib.rooms.mesh\n", ROOMS),
        ("import lib.rooms\n", ["__init__.py", "rooms/__init__.py"]),
        (
            "import lib.rooms.deep\n",
            ["__init__.py", "rooms/__init__.py", "rooms/deep/__init__.py", "rooms/deep/last.py"],
        ),
        ("import lib.chain\n", sorted([*ROOMS, "chain.py"])),
        ("import lib.cycle_a\n", ["__init__.py", "cycle_a.py", "cycle_b.py"]),
        ("def g():\n    import lib.alone\n", ["__init__.py", "alone.py"]),
        ("import lib.inner\n", ["__init__.py", "alone.py", "inner.py"]),
        ("if True:\n    from lib import alone\n", ["__init__.py", "alone.py"]),
        ("import library\nfrom libs.alone import x\n", []),
        ("from . import alone\n", []),
        ("'import lib.alone'  # import lib.alone\n", []),
    ],
)
def test_files_that_a_script_imports(tree, text, files):
    assert tree(text) == files


@pytest.mark.parametrize("text", ["import lib.nothing\n", "from lib.rooms.nothing import f\n"])
def test_module_that_does_not_exist_is_named(tree, text):
    with pytest.raises(ValueError, match=r"script\.py: imports lib\.\S*nothing, which is not in"):
        tree(text)


def test_boltjoint_is_the_package_by_default(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("from boltjoint.config import load_study\n", encoding="utf-8")
    modules = (
        "__init__",
        "checks",
        "config",
        "entries",
        "names",
        "solvers/__init__",
        "solvers/equations",
    )
    assert library_sources(script) == [str(PACKAGE / f"{name}.py") for name in modules]


def test_imports_for_type_checkers_do_not_count(tmp_path):
    package = tmp_path / "package"
    package.mkdir()
    for name in ("__init__", "used", "typed"):
        (package / f"{name}.py").write_text("")
    script = tmp_path / "script.py"
    script.write_text(
        "from typing import TYPE_CHECKING\n"
        "if TYPE_CHECKING:\n    from package import typed\n"
        "from package import used\n"
    )
    found = [Path(source).stem for source in library_sources(script, package)]
    assert found == ["__init__", "used"]
