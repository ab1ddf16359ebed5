"""A sweep on a cluster with Slurm, whose node fails and is drained meanwhile.

BOLTJOINT_SLURM=required makes the absence of a cluster a failure; ``.ci/slurm start`` makes one.
"""

import os
import shutil
import subprocess
import time

import pytest
from small_study import COMMAND, SWEEP, environment, run, write

from boltjoint.config.study import load_study
from boltjoint.study.artefact_list import Contents

RESULT = "results/sweeps/grid/sweep.nc"
#: without accounting the queue alone tells of jobs; a job takes some ten seconds, mostly to start
PROFILE = ["--profile", "profiles/slurm", "--slurm-status-command", "squeue"]
OPTIONS = [*PROFILE, "--slurm-init-seconds-before-status-checks", "10"]
#: by far more than any state of a job takes [s]
PATIENCE = 180
#: the plugin asks for the states of jobs up to three minutes apart, and anew after a retry [s]
PATIENCE_AT_END = 4 * 180


def answer(*command):
    """What a command of Slurm prints; nothing if there is no Slurm."""
    try:
        ran = subprocess.run(command, capture_output=True, text=True, check=True, timeout=30)
    except (OSError, subprocess.SubprocessError):
        return ""
    return ran.stdout.strip()


@pytest.fixture(scope="session")
def node():
    """The only node of the cluster, which serves before and after."""
    nodes = answer("sinfo", "--Node", "--noheader", "--format=%N %t").splitlines()
    if len(nodes) != 1 or not nodes[0].endswith(" idle"):
        stop = pytest.fail if os.environ.get("BOLTJOINT_SLURM") == "required" else pytest.skip
        stop(f"no idle cluster with Slurm on this machine alone: {nodes}")
    name = nodes[0].split()[0]
    yield name
    answer("scontrol", "update", f"nodename={name}", "state=resume")


def set_state(node, state):
    answer("scontrol", "update", f"nodename={node}", f"state={state}", "reason=test")


def wait_for(condition, running):
    """Until a condition holds, while a run goes on."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert running.poll() is None, "the run has ended before"
        assert time.monotonic() < end
        time.sleep(0.2)


def tasks(*states):
    """Tasks of job arrays in some states."""
    listed = answer("squeue", "--array", "--noheader", "--format=%i", "--states", ",".join(states))
    return [each for each in listed.split() if "_" in each]


def test_a_node_that_fails_or_is_drained_costs_a_sweep_nothing(node, copied, finished, tmp_path):
    folder = copied
    # the joint is there: of the cluster the study needs its designs alone
    shutil.rmtree(folder / "results/sweeps")
    write(folder / "config/sweeps/grid.yaml", SWEEP | {"designs_per_job": 1})
    chunks = Contents(load_study(folder)).files("chunk", form="data", sweep="grid")
    assert len(chunks) == 6

    def done():
        return [path for path in chunks if (folder / path).exists()]

    log = tmp_path / "run.log"
    with (
        log.open("w") as said,
        subprocess.Popen(
            [*COMMAND[:3], *OPTIONS, RESULT],
            cwd=folder,
            env=environment(folder),
            stdout=said,
            stderr=said,
        ) as running,
    ):
        try:
            wait_for(lambda: tasks("running"), running)
            # what has begun ends, and nothing more begins
            set_state(node, "drain")
            wait_for(lambda: not tasks("running", "completing"), running)
            assert len(tasks("pending")) == len(chunks) - len(done()) > 0
            set_state(node, "resume")
            wait_for(lambda: tasks("running"), running)
            # what has begun is lost, and begins anew; drained, the node does not serve by itself as
            # soon as it answers
            set_state(node, "drain")
            set_state(node, "down")
            wait_for(lambda: not tasks("running", "completing"), running)
            assert len(tasks("pending")) == len(chunks) - len(done()) > 0
            set_state(node, "resume")
            assert running.wait(timeout=PATIENCE_AT_END) == 0
        finally:
            running.terminate()
            print(log.read_text())
    assert "Submitted array job" in log.read_text()
    # in one chunk or six, on a cluster or not
    assert (folder / RESULT).read_bytes() == (finished / RESULT).read_bytes()
    assert "Nothing to be done" in run(folder, *OPTIONS, "--dry-run", RESULT)
