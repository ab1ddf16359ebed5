"""The workflow as a module of another Snakefile, from a folder that has no file of it."""

import shutil
import subprocess

import pytest
from small_study import CASE, ROOT, run, snakemake, write_config

from boltjoint import dataset

#: as snakedeploy writes it
USE = """
configfile: "config/config.yaml"

module boltjoint:
    snakefile:
        {snakefile}
    config:
        config

use rule * from boltjoint
"""
RESPONSE = "results/cases/small/free-2/regions=2/linear/resonance=1/response.nc"
#: has published values, which lie in the folder of the workflow
TABLE = "results/tables/natural_frequencies_free-2.csv"


@pytest.fixture
def study(tmp_path):
    """A folder with the configuration of a study alone."""
    folder = tmp_path / "study"
    write_config(folder, {"small": CASE | {"published": "three_bolt_constant"}})
    return folder


def use(folder, snakefile):
    (folder / "workflow").mkdir()
    (folder / "workflow/Snakefile").write_text(USE.format(snakefile=snakefile))


@pytest.mark.parametrize("snakefile", ["Snakefile", "workflow/Snakefile"])
def test_a_study_runs_with_the_workflow_as_its_module(study, snakefile):
    use(study, f'"{ROOT}/{snakefile}"')
    run(study, RESPONSE, TABLE)
    assert dataset.load(study / RESPONSE)["complete"].all()
    assert (study / TABLE).exists()
    assert {path.name for path in study.iterdir()} == {
        ".snakemake",
        "config",
        "results",
        "workflow",
    }
    assert "Nothing to be done" in run(study, RESPONSE, TABLE)


def test_a_prefix_of_results_is_refused(study):
    use(study, f'"{ROOT}/workflow/Snakefile"\n    prefix:\n        "joint"')
    ran = snakemake(study, "--dry-run")
    said = ran.stdout + ran.stderr
    assert ran.returncode != 0
    assert "prefix and replace_prefix are not for this module" in said
    assert "Traceback" not in said


def test_the_workflow_may_lie_on_a_server(study, tmp_path, monkeypatch):
    repository = tmp_path / "server/owner/boltjoint"
    for name in ("workflow", "resources"):
        shutil.copytree(ROOT / name, repository / name)
    author = "-c user.name=a -c user.email=a@b.c"
    for command in ("init --quiet", "add .", f"{author} commit --quiet -m a", "tag v1"):
        subprocess.run(["git", *command.split()], cwd=repository, check=True)
    for name, value in {
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        # git takes this folder for the server
        "GIT_CONFIG_COUNT": "1",
        "GIT_CONFIG_KEY_0": f"url.file://{tmp_path}/server/.insteadOf",
        "GIT_CONFIG_VALUE_0": "https://github.com/",
    }.items():
        monkeypatch.setenv(name, value)
    use(study, 'github("owner/boltjoint", path="workflow/Snakefile", tag="v1")')
    run(study, TABLE)
    assert len(list((tmp_path / "cache").rglob("natural_frequencies.csv"))) == 1
    shutil.rmtree(tmp_path / "server")
    # it is kept: nothing is asked of the server, and nothing made again
    assert "Nothing to be done" in run(study, TABLE)
