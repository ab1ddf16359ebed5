import fcntl
import os
import shutil

import pytest
from small_joint import make_joint
from small_study import CASES, ROOT, run, write_config

from boltjoint.joint.model import Joint


def pytest_collection_modifyitems(items):
    """Mark what runs the workflow, and begin with it: another process has the other tests."""
    for item in items:
        if {"project", "finished"} & set(item.fixturenames):
            item.add_marker("workflow")
    items.sort(
        key=lambda item: (
            "finished" not in item.fixturenames,
            item.get_closest_marker("workflow") is None,
        )
    )


@pytest.fixture
def joint() -> Joint:
    return make_joint()


@pytest.fixture(scope="session")
def project(tmp_path_factory):
    """The workflow with the configuration of the first case of the small study."""
    folder = tmp_path_factory.mktemp("project")
    copy_workflow(folder)
    write_config(folder, {"small": CASES["small"]})
    return folder


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """The small study after its run, which all processes of the tests share: do not change it."""
    shared = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        shared = shared.parent
    folder, done = shared / "finished", shared / "finished.done"
    with open(shared / "finished.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            copy_workflow(folder)
            write_config(folder)
            run(folder)
            done.touch()
    return folder


@pytest.fixture
def copied(finished, tmp_path):
    """A copy of the small study after its run."""
    return shutil.copytree(finished, tmp_path / "study")


def copy_workflow(folder):
    for name in ("workflow", "profiles"):
        shutil.copytree(ROOT / name, folder / name, dirs_exist_ok=True)
