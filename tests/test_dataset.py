import numpy as np
import pytest
import xarray as xr

from boltjoint import __version__, dataset
from boltjoint.dataset import quantity


def some_dataset():
    return xr.Dataset(
        {"force": quantity("pair", np.arange(3.0), "N", "force")},
        coords={"pair": quantity("pair", np.arange(3), "1", "number of the pair")},
        attrs={"coordinates": "linear"},
    )


def test_a_variable_without_units_is_refused(tmp_path):
    bare = some_dataset().assign(load=("pair", np.ones(3)))
    with pytest.raises(ValueError, match="no units on load"):
        dataset.save(bare, tmp_path / "a.nc")
    assert not (tmp_path / "a.nc").exists()


def test_labels_need_no_units(tmp_path):
    dataset.save(some_dataset().assign_coords(axis=["x", "y"]), tmp_path / "a.nc")
    assert list(dataset.load(tmp_path / "a.nc")["axis"].to_numpy()) == ["x", "y"]


def test_content_and_provenance_survive(tmp_path):
    dataset.save(some_dataset(), tmp_path / "folder" / "a.nc", {"preload": 1e4})
    again = dataset.load(tmp_path / "folder" / "a.nc")
    assert again["force"].attrs == {"units": "N", "long_name": "force"}
    assert again.attrs["boltjoint_version"] == __version__
    assert again.attrs["parameters"] == "preload=10000.0"
    assert again.attrs["coordinates"] == "linear"


def test_same_content_same_bytes(tmp_path):
    for name in ("a.nc", "b.nc"):
        dataset.save(some_dataset(), tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
