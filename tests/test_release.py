"""What a release needs is in order: versions and dependencies are the same in all files."""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
#: whose tag is checked, and what the owner fills in before
FILES = (
    *("pyproject.toml", "CITATION.cff", "CHANGELOG.md", "recipe/recipe.yaml"),
    *("workflow/envs/boltjoint.post-deploy.sh", ".ci/check-release"),
)


@pytest.fixture
def checkout(tmp_path):
    """The files that a release is checked by."""
    for name in FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def check_release(folder, tag):
    command = [folder / ".ci/check-release", tag]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_release_waits_for_what_the_owner_fills_in(checkout):
    tag = f"v{PROJECT['version']}"
    waiting = check_release(checkout, tag)
    assert waiting.returncode == 1
    assert waiting.stdout.count("FOR THE OWNER") >= 4
    for name in FILES[:4]:
        path = checkout / name
        path.write_text(path.read_text().replace("FOR THE OWNER", "was"))
    assert check_release(checkout, tag).returncode == 0, "versions differ"


def test_another_tag_is_refused(checkout):
    refused = check_release(checkout, "v0.9.9")
    assert refused.returncode == 1
    assert "pyproject.toml does not have" in refused.stderr


def test_the_recipe_has_the_dependencies_of_the_project():
    text = (ROOT / "recipe/recipe.yaml").read_text()
    recipe = yaml.safe_load(text)
    floors = [each.lower().replace(">=", " >=") for each in PROJECT["dependencies"]]
    python, *others = recipe["requirements"]["run"]
    assert python == "python >=${{ python_min }}"
    assert others == floors
    (entry,) = recipe["build"]["python"]["entry_points"]
    assert entry == f"boltjoint = {PROJECT['scripts']['boltjoint']}"


def test_versions_of_hooks_are_those_that_make_installs():
    pinned = dict(re.findall(r"^([\w-]+)==([\d.]+)", (ROOT / "requirements.txt").read_text(), re.M))
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"]
    revisions = {each["repo"].rpartition("/")[2]: each["rev"].removeprefix("v") for each in hooks}
    assert revisions["ruff-pre-commit"] == pinned["ruff"]
    assert revisions["snakefmt"] == pinned["snakefmt"]


def test_workflows_of_the_server_call_what_is_here():
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.M))
    texts = {path.name: path.read_text() for path in (ROOT / ".github/workflows").glob("*.yml")}
    assert set(texts) == {"tests.yml", "docs.yml", "release.yml"}
    for text in texts.values():
        assert set(re.findall(r"make (\w+)", text)) <= targets
        assert all((ROOT / name).exists() for name in re.findall(r"\.ci/[\w-]+", text))
    release = yaml.safe_load(texts["release.yml"])["jobs"]
    # trusted publishing: a token of the run, no password
    assert release["publish"]["permissions"] == {"id-token": "write"}
    assert "password" not in texts["release.yml"]
    matrix = yaml.safe_load(texts["tests.yml"])["jobs"]["tests"]["strategy"]["matrix"]["python"]
    assert matrix[0] == PROJECT["requires-python"].removeprefix(">=")
    named = [each.rpartition(" ")[2] for each in PROJECT["classifiers"] if ":: 3." in each]
    assert set(named) <= set(matrix)


def test_the_citation_names_what_is_cited():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert cited["version"] == PROJECT["version"]
    assert cited["license"] == PROJECT["license"]
    assert cited["authors"]
    assert cited["references"][0]["type"] == "thesis"
