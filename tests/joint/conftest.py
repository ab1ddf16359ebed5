"""Joints that the tests of this package share."""

import pytest
from small_joint import make_joint


@pytest.fixture(params=["constant", "variable"])
def either(request):
    """A joint of each law."""
    return make_joint(law=request.param)
