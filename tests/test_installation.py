"""The library where nothing of it is installed or can be written, as on a cluster."""

import ast
import os
import shutil
import stat
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest
import yaml

import boltjoint

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src/boltjoint"

#: to root, permissions of files mean nothing otherwise
WITHOUT_PRIVILEGES = [
    *("setpriv", "--bounding-set=-dac_override,-dac_read_search"),
    "--inh-caps=-dac_override,-dac_read_search",
]

USE = """
import boltjoint
names = [getattr(boltjoint, name) for name in sorted(boltjoint._NAMES)]
elements = boltjoint.ConstantLoad([0], [2.0], [1.0])
print(boltjoint.__file__)
print(boltjoint.__version__)
print(elements.force([[0.25, 0.0]])[0, 0])
print(elements.force([[0.5, 0.0]])[0, 0])
"""


def test_type_checkers_know_every_public_name():
    told = {
        name.name: statement.module
        for statement in ast.parse((PACKAGE / "__init__.pyi").read_text()).body
        if isinstance(statement, ast.ImportFrom)
        for name in statement.names
    }
    assert told == {name: f"boltjoint.{module}" for name, module in boltjoint._NAMES.items()}
    assert boltjoint.__all__ == [*boltjoint._NAMES]
    assert (PACKAGE / "py.typed").exists()


@pytest.fixture
def environment(tmp_path):
    """The library and its dependencies in folders that are read-only, and no home."""
    (tmp_path / "dependencies").mkdir()
    for path in Path(sysconfig.get_path("purelib")).iterdir():
        if "boltjoint" not in path.name:
            (tmp_path / "dependencies" / path.name).symlink_to(path)
    copy = tmp_path / "library/boltjoint"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    folders = [tmp_path, *(path for path in copy.parent.rglob("*") if path.is_dir())]
    for folder in [*folders, copy.parent]:
        folder.chmod(stat.S_IREAD | stat.S_IEXEC)
    places = (str(copy.parent), str(tmp_path / "dependencies"))
    kept = {name: os.environ[name] for name in ("PATH", "OMP_NUM_THREADS") if name in os.environ}
    yield kept | {"PYTHONPATH": os.pathsep.join(places), "HOME": str(tmp_path / "home")}
    for folder in [tmp_path, copy.parent, *folders]:
        folder.chmod(stat.S_IRWXU)


@pytest.mark.skipif(
    os.geteuid() == 0 and shutil.which("setpriv") is None, reason="root has no setpriv"
)
def test_all_public_names_work_where_nothing_is_installed_or_can_be_written(environment):
    command = WITHOUT_PRIVILEGES if os.geteuid() == 0 else []
    ran = subprocess.run(
        [*command, sys.executable, "-S", "-c", USE],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    file, version, stuck, slipping = ran.stdout.split()
    assert file.startswith(environment["PYTHONPATH"].split(os.pathsep)[0])
    assert version == "0+unknown"
    assert float(stuck) == 0.5
    assert 0.5 < float(slipping) <= 4 / 3.14159
    assert ran.stderr.count("every process compiles anew") == 1, ran.stderr
    assert len(ran.stderr.splitlines()) == 1


def test_floors_of_dependencies_are_those_of_the_workflow():
    # make oldest takes them from lines of this form
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    floors = dict(each.lower().split(">=") for each in project["dependencies"])
    environment = yaml.safe_load((ROOT / "workflow/envs/boltjoint.yaml").read_text())
    wanted = dict(each.split(" >=") for each in environment["dependencies"] if each != "pip")
    assert wanted.pop("python") == project["requires-python"].removeprefix(">=")
    # it makes the environments, and is asked for by the workflow itself
    snakefile = (ROOT / "workflow/Snakefile").read_text()
    assert f'min_version("{floors.pop("snakemake")}")' in snakefile
    assert wanted == floors
