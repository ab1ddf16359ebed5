import shutil

import pytest
from mutations import ROOT


@pytest.fixture
def study(tmp_path):
    """A copy of the shipped study."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    return tmp_path
