"""Library files behind a script, found without running anything."""

import os
import shutil
from pathlib import Path

import pytest

import boltjoint
from boltjoint.provenance.code_dependencies import Sources

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
        "pages/__init__.py": "",
        "pages/style.css": "import lib.alone",
        "pages/text.py": "",
        "pages/templates/page.html.j2": "",
        "pages/__pycache__/text.nbi": "",
        "pages/.hidden": "",
    }
    package = tmp_path / "lib"
    for name, text in files.items():
        path = package / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def imported(text):
        script = tmp_path / "script.py"
        script.write_text(text, encoding="utf-8")
        found = Sources(package).used_by(script)
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
        (
            "import lib.pages.text\n",
            ["__init__.py"]
            + [f"pages/{name}" for name in ("__init__.py", "style.css")]
            + [f"pages/{name}" for name in ("templates/page.html.j2", "text.py")],
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
    script.write_text("from boltjoint.config.strict_yaml import parse_mapping\n", encoding="utf-8")
    modules = (
        "__init__",
        "checks",
        "config/__init__",
        "config/strict_yaml",
        "config/types",
        "names",
        "regular_file",
    )
    assert Sources().used_by(script) == [str(PACKAGE / f"{name}.py") for name in modules]


@pytest.mark.parametrize(
    ("name", "used"),
    [("tabulate", "study/tables/html.py"), ("draw_figures", "report/figures/style.py")],
)
def test_words_of_pages_leave_figures_and_tables_alone(name, used):
    script = PACKAGE.parents[1] / f"workflow/scripts/{name}.py"
    files = [Path(file).relative_to(PACKAGE).as_posix() for file in Sources().used_by(script)]
    assert used in files
    assert not [file for file in files if file.startswith("report/pages/templates")]


@pytest.mark.parametrize(
    "name",
    ["find_modes", "reduce_joint", "solve_responses", "solve_designs", "calibrate_joint"],
)
def test_nothing_is_solved_again_for_the_sake_of_a_page(name):
    script = PACKAGE.parents[1] / f"workflow/scripts/{name}.py"
    assert not [file for file in Sources().used_by(script) if not file.endswith(".py")]


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
    found = [Path(source).stem for source in Sources(package).used_by(script)]
    assert found == ["__init__", "used"]


@pytest.fixture
def script(tmp_path):
    """A script that uses one of two modules of a package, in a folder of its own."""
    package = tmp_path / "package"
    package.mkdir()
    for name, text in (("__init__", ""), ("used", "a = 1\n"), ("other", "b = 1\n")):
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    path = tmp_path / "script.py"
    path.write_text("from package import used\n", encoding="utf-8")
    return path


def hash_of(script):
    return Sources(script.parent / "package").hash_of(script)


def test_the_hash_follows_the_content_of_what_is_used(script):
    used, other = (script.parent / f"package/{name}.py" for name in ("used", "other"))
    before = hash_of(script)
    assert len(before) == 16
    other.write_text("b = 2\n", encoding="utf-8")
    assert hash_of(script) == before
    for path in (used, script):
        kept = path.read_text(encoding="utf-8")
        path.write_text(kept + "# edited\n", encoding="utf-8")
        assert hash_of(script) != before
        path.write_text(kept, encoding="utf-8")
        assert hash_of(script) == before


def test_the_hash_follows_templates(script):
    template = script.parent / "package/templates/page.html.j2"
    template.parent.mkdir()
    template.write_text("first", encoding="utf-8")
    before = hash_of(script)
    template.write_text("second", encoding="utf-8")
    assert hash_of(script) != before


def test_the_hash_knows_no_dates_and_no_place(script, tmp_path):
    before = hash_of(script)
    for path in (script, *(script.parent / "package").iterdir()):
        os.utime(path, (0, 0))
    assert hash_of(script) == before
    shutil.copytree(script.parent / "package", tmp_path / "elsewhere/package")
    shutil.copy(script, tmp_path / "elsewhere")
    assert hash_of(tmp_path / "elsewhere/script.py") == before


def test_content_that_moves_from_one_module_to_another_is_seen(script):
    other = script.parent / "package/other.py"
    used = script.parent / "package/used.py"
    script.write_text("from package import other, used\n", encoding="utf-8")
    before = hash_of(script)
    used.write_text("", encoding="utf-8")
    other.write_text("b = 1\na = 1\n", encoding="utf-8")
    assert hash_of(script) != before
