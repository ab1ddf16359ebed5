import pytest
from small_joint import make_joint

from boltjoint.joint import Joint


@pytest.fixture
def joint() -> Joint:
    return make_joint()
