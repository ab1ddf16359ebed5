import os
import shutil
import signal
import subprocess
import time

import pytest
from small_joint import make_joint
from small_study import ASSEMBLY, CASE, COMMAND, ROOT, SETTINGS, environment, snakemake, write

from boltjoint.joint.model import Joint


@pytest.fixture
def joint() -> Joint:
    return make_joint()


@pytest.fixture(scope="session")
def project(tmp_path_factory):
    """A copy of the project, so that a test may edit the library."""
    folder = tmp_path_factory.mktemp("project")
    for name in ("workflow", "profiles", "resources", "src"):
        shutil.copytree(ROOT / name, folder / name)  # with what is compiled
    shutil.copy(ROOT / "Snakefile", folder)
    write(folder / "config/assemblies/two_bolt.yaml", ASSEMBLY)
    write(folder / "config/cases/small.yaml", CASE)
    write(folder / "config/config.yaml", SETTINGS)
    return folder


@pytest.fixture(scope="session")
def finished(project):
    """The small study, killed as by a power cut after its first result, and run to its end."""
    first = project / "results/assemblies/two_bolt/assembly.nc"
    with subprocess.Popen(
        COMMAND,
        cwd=project,
        env=environment(project),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as running:
        while not first.exists():
            assert running.poll() is None, "the run ended before its first result"
            time.sleep(0.1)
        os.killpg(running.pid, signal.SIGKILL)
    assert not (project / "results/tables").exists()
    assert "cannot be locked" in snakemake(project).stderr
    assert snakemake(project, "--unlock").returncode == 0
    ran = snakemake(project)
    assert ran.returncode == 0, ran.stderr
    return project
