"""The workflow as a module of another Snakefile, from a folder that has no file of it."""

import os
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


@pytest.fixture
def server(tmp_path, monkeypatch):
    """The folder of a server, which git takes for one, with this workflow as the version v1."""
    repository = tmp_path / "server/owner/boltjoint"
    for name in ("workflow", "resources", "config", "profiles"):
        shutil.copytree(ROOT / name, repository / name)
    shutil.copy(ROOT / "LICENSE", repository)
    author = "-c user.name=a -c user.email=a@b.c"
    for command in ("init --quiet", "add .", f"{author} commit --quiet -m a", "tag v1"):
        subprocess.run(["git", *command.split()], cwd=repository, check=True)
    for name, value in {
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "GIT_CONFIG_COUNT": "1",
        "GIT_CONFIG_KEY_0": f"url.file://{tmp_path}/server/.insteadOf",
        "GIT_CONFIG_VALUE_0": "https://github.com/",
    }.items():
        monkeypatch.setenv(name, value)
    return tmp_path / "server"


def test_the_workflow_may_lie_on_a_server(study, tmp_path, server):
    use(study, 'github("owner/boltjoint", path="workflow/Snakefile", tag="v1")')
    run(study, TABLE)
    assert len(list((tmp_path / "cache").rglob("natural_frequencies.csv"))) == 1
    shutil.rmtree(server)
    # it is kept: nothing is asked of the server, and nothing made again
    assert "Nothing to be done" in run(study, TABLE)


@pytest.mark.usefixtures("server")
def test_a_deployed_workflow_runs(study, tmp_path):
    program = shutil.which("snakedeploy", path=f"{ROOT}/.venv/deploy/bin:{os.environ['PATH']}")
    if program is None and os.environ.get("BOLTJOINT_DEPLOY") != "required":
        pytest.skip("snakedeploy is not installed")
    deployed = tmp_path / "deployed"
    source = "https://github.com/owner/boltjoint"
    command = [program, "deploy-workflow", source, deployed, "--tag", "v1"]
    subprocess.run(command, check=True, capture_output=True)
    # the module definition is that of the tests above
    written = (deployed / "workflow/Snakefile").read_text()
    assert 'github("owner/boltjoint", path="workflow/Snakefile", tag="v1")' in written
    assert (deployed / "config/cases/three_bolt_constant.yaml").exists()
    assert (deployed / "profiles/slurm/config.yaml").exists()
    # the small study in place of the shipped one, which takes longer
    shutil.rmtree(deployed / "config")
    shutil.copytree(study / "config", deployed / "config")
    run(deployed, TABLE)
    assert (deployed / TABLE).exists()
