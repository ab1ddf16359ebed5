"""Assemblies that are built once for all tests."""

import os
import shutil

import examples
import pytest

from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload


@pytest.fixture(scope="session")
def coarse():
    return examples.coarse_assembly()


@pytest.fixture(scope="session")
def assembly(coarse):
    return examples.build_assembly(coarse)


@pytest.fixture(scope="session")
def structure(assembly):
    return structure_of(assembly)


@pytest.fixture(scope="session")
def tiny():
    """As few elements as two bolts can have."""
    return examples.build_assembly(examples.coarse_assembly(**examples.FEWEST))


@pytest.fixture(scope="session")
def modes(assembly):
    return find_modes(assembly, "free-3")


@pytest.fixture(scope="session")
def preload(assembly):
    return apply_preload(assembly, 8e3)


@pytest.fixture(scope="session", params=["three_bolt", "four_bolt"])
def of_study(request):
    config = examples.study_assembly(request.param)
    return config, examples.build_assembly(config)


@pytest.fixture
def installed():
    """CalculiX, or the test is skipped."""
    if shutil.which("ccx") is None:
        if os.environ.get("BOLTJOINT_CALCULIX") == "required":
            pytest.fail("CalculiX (ccx) is not installed, and BOLTJOINT_CALCULIX requires it")
        pytest.skip("CalculiX (ccx) is not installed")
