"""Imports of the library point only downwards and never in a circle, and its files are short."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src/boltjoint"
#: highest first; a room imports from itself and from those after it
ROOMS = (
    *(
        "__main__",
        "command",
        "reproduction",
        "report",
        "study",
        "calibration",
        "measurement",
        "verification",
        "dynamics",
        "structure",
        "joint",
        "config",
    ),
    *(
        "friction",
        "damping",
        "solvers",
        "provenance",
        "harmonics",
        "names",
        "dataset",
        "csv_files",
        "number_format",
        "options",
        "other_packages",
    ),
    *("checksums", "regular_file", "compiled", "checks", "__init__"),
)
#: what a maker has for the report, which reads it by the name that the maker tells
OF_REPORT = re.compile(r"structure/makers/\w+/(displays|figures)\.py")
#: by the file, the syntax tree
TREES = {
    file.relative_to(PACKAGE).as_posix(): ast.parse(file.read_text(encoding="utf-8"))
    for file in sorted(PACKAGE.rglob("*.py"))
}


def imported(tree):
    """The files of the package that a module imports anywhere, for types too, and the lines."""
    for node in ast.iter_child_nodes(tree):
        yield from imported(node)
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "boltjoint":
            for alias in node.names:
                parts = [*node.module.split("."), alias.name][1:]
                stems = ["/".join(parts), "/".join(parts[:-1]), "/".join([*parts[:-1], "__init__"])]
                yield next(f"{s}.py" for s in stems if f"{s}.py" in TREES), node.lineno


def room_of(file):
    """The package that a file is of."""
    return "report" if OF_REPORT.fullmatch(file) else file.split("/")[0].removesuffix(".py")


@pytest.mark.parametrize("file", TREES)
def test_imports_point_downwards(file):
    room = room_of(file)
    for below, line in imported(TREES[file]):
        assert ROOMS.index(room_of(below)) >= ROOMS.index(room), f"line {line}: {below}"


#: of dynamics, highest first
ROOMS_OF_DYNAMICS = ("reduction", "response", "backbone", "balance", "__init__")


@pytest.mark.parametrize("file", [file for file in TREES if file.startswith("dynamics/")])
def test_imports_within_dynamics_point_downwards(file):
    room = file.split("/")[1].removesuffix(".py")
    for below, line in imported(TREES[file]):
        first, *others = below.split("/")
        if first == "dynamics":
            other = others[0].removesuffix(".py")
            places = ROOMS_OF_DYNAMICS.index(other), ROOMS_OF_DYNAMICS.index(room)
            assert places[0] >= places[1], f"line {line}: {below}"


def test_imports_never_form_a_circle():
    TopologicalSorter(
        {file: {below for below, _ in imported(TREES[file])} for file in TREES}
    ).prepare()


@pytest.mark.parametrize("file", TREES)
def test_files_and_classes_are_short_and_open_with_a_statement(file):
    assert len((PACKAGE / file).read_text(encoding="utf-8").splitlines()) <= 400
    for node in ast.walk(TREES[file]):
        if isinstance(node, ast.ClassDef):
            assert node.end_lineno - node.lineno < 250, node.name
    assert "?" not in (ast.get_docstring(TREES[file]) or "").split("\n")[0]


#: words of the half lap alone
OF_HALF_LAP = re.compile(r"half_lap|FIRST_BOLT|bar_A|BAR_A|\bclamp|\by = 0(?![.\d])")
#: its maker and its description, and what names them
ROOM_OF_HALF_LAP = (
    *("src/boltjoint/structure/makers/half_lap/", "src/boltjoint/config/makers.py"),
    "src/boltjoint/config/lap_joint.py",
)
TESTS_OF_HALF_LAP = (
    *("tests/structure/half_lap/", "tests/report/test_figures_half_lap", "tests/test_rooms.py"),
)
TEXTS = (".py", ".j2", ".smk", ".rst", ".yaml", ".js", ".css", "")


@pytest.mark.parametrize("tree", ["src", "workflow", "tests", "Snakefile", "profiles"])
def test_words_of_the_half_lap_stand_in_its_room(tree):
    root = PACKAGE.parents[1]
    files = [root / tree] if (root / tree).is_file() else sorted((root / tree).rglob("*"))
    names = {
        name: path
        for path in files
        if path.suffix in TEXTS and path.is_file() and "__pycache__" not in path.parts
        if not (name := path.relative_to(root).as_posix()).endswith(".egg-info")
    }
    assert names
    rooms = ROOM_OF_HALF_LAP + TESTS_OF_HALF_LAP
    elsewhere = {
        name: words
        for name, path in names.items()
        if not name.startswith(rooms)
        if (words := OF_HALF_LAP.findall(f"{name}\n{path.read_text(encoding='utf-8')}"))
    }
    assert elsewhere == {}


def test_each_exception_to_that_is_needed():
    root = PACKAGE.parents[1]
    for room in ROOM_OF_HALF_LAP + TESTS_OF_HALF_LAP:
        files = [
            path
            for path in (root / room).parent.rglob("*")
            if path.suffix in TEXTS and path.is_file() and "__pycache__" not in path.parts
            if path.relative_to(root).as_posix().startswith(room)
        ]
        assert any(OF_HALF_LAP.search(path.read_text(encoding="utf-8")) for path in files), room


#: words of the thesis that a study may be compared with, beside the names of its methods
OF_THESIS = re.compile(
    r"publish|\b[Tt]hesis\b|in_source|in the source|source's|source_table|printed_by"
)
#: what asks of it, and where it is known which case of a study has a counterpart
DOORS_TO_THESIS = (
    "report/comparison.py",
    *(f"study/{name}.py" for name in ("display", "response_list", "stage_inputs")),
)


def test_words_of_the_thesis_stand_in_its_room():
    files = [path for room in ("report", "study") for path in (PACKAGE / room).rglob("*.*")]
    elsewhere = {
        name: words
        for path in files
        if path.suffix in (".py", ".j2")
        if (name := path.relative_to(PACKAGE).as_posix()) not in DOORS_TO_THESIS
        if (words := OF_THESIS.findall(path.read_text(encoding="utf-8")))
    }
    assert elsewhere == {}


def test_machine_code_is_kept_in_one_way():
    # where it cannot be, numba's own cache is an error
    for file, tree in TREES.items():
        asked = [node.arg for node in ast.walk(tree) if isinstance(node, ast.keyword)]
        assert "cache" not in asked, file


def test_modules_named_in_texts_exist():
    defined = {
        file: {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        for file, tree in TREES.items()
    }
    functions = {name for names in defined.values() for name in names if "_" in name}
    known = {f"/{file}".removesuffix(".py").replace("/", ".") for file in TREES}
    known |= {
        f"/{file}".removesuffix(".py").replace("/", ".") + f".{name}"
        for file, names in defined.items()
        for name in names
    }
    for file in TREES:
        text = (PACKAGE / file).read_text(encoding="utf-8")
        for name in re.findall(r"``((?:[a-z_]+\.)+[a-z_]+)``", text):
            if name.rpartition(".")[2] in functions:
                assert any(each.endswith(f".{name}") for each in known), f"{file}: {name}"
