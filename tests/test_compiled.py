"""Machine code that is kept for later processes."""

import importlib.util
import pickle

import numba
import pytest

from boltjoint.compiled import kept_loop

SOURCE = """
def twice(x):
    return 2 * x
"""


@pytest.fixture
def twice(tmp_path):
    """A compiled function of a file of its own, made anew at each call."""
    (tmp_path / "some_loops.py").write_text(SOURCE, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("some_loops", tmp_path / "some_loops.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return lambda: kept_loop(module.twice)


def test_machine_code_is_kept(twice, tmp_path):
    assert twice()(1.5) == 3.0
    again = twice()
    assert again(1.5) == 3.0
    assert sum(again.stats.cache_hits.values()) == 1
    assert len(list(tmp_path.rglob("*.nbi"))) == 1


#: an index whose types are of a module that has gone, one that was cut, and one that is none
STALE = {
    "gone": b"\x80\x04cboltjoint.module_that_has_gone\nElements\n.",
    "cut": b"\x80\x04\x95\x10",
    "none": b"no pickle",
}


@pytest.mark.parametrize("stale", STALE)
def test_machine_code_of_other_versions_is_compiled_anew(twice, tmp_path, stale):
    assert twice()(1.5) == 3.0
    (index,) = tmp_path.rglob("*.nbi")
    index.write_bytes(pickle.dumps(numba.__version__, protocol=-1) + STALE[stale])
    again = twice()
    assert again(1.5) == 3.0
    assert not again.stats.cache_hits
    later = twice()
    assert later(1.5) == 3.0
    assert sum(later.stats.cache_hits.values()) == 1
