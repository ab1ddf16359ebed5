import netCDF4
import numpy as np
import pytest
import xarray as xr

from boltjoint import __version__, dataset
from boltjoint.dataset import DamagedFile, quantity


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


def test_the_hash_of_the_code_is_no_parameter(tmp_path):
    for name, code in (("a.nc", "1f"), ("b.nc", "2e")):
        dataset.save(some_dataset(), tmp_path / name, {"library": code, "preload": 1e4})
    assert dataset.load(tmp_path / "a.nc").attrs["parameters"] == "preload=10000.0"
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_content_of_every_type_is_read_as_it_was_written(tmp_path):
    written = some_dataset().assign(
        closed=quantity("pair", np.array([True, False, True]), "1", "closed"),
        none=quantity(("pair", "none"), np.zeros((3, 0)), "1", "nothing"),
        undefined=quantity("pair", np.array([1.0, np.nan, np.inf]), "m", "not all are numbers"),
        label=("pair", ["", "a", "µ"]),
    )
    written.attrs |= {"counts": [1, 2], "names": ["a", "b"], "flag": np.int8(1)}
    dataset.save(written, tmp_path / "a.nc")
    read = dataset.load(tmp_path / "a.nc")
    xr.testing.assert_equal(read, written)
    # and what is made of it has the checksum of its own content, not that of its source
    dataset.save(read.assign_attrs(more=1), tmp_path / "b.nc")
    assert dataset.load(tmp_path / "b.nc").attrs["more"] == 1


@pytest.fixture
def kept(tmp_path):
    path = tmp_path / "folder" / "kept.nc"
    values = quantity("pair", np.linspace(1, 2, 1000), "N", "force")
    dataset.save(some_dataset().drop_dims("pair").assign(force=values), path)
    return path


def refused(path, words):
    with pytest.raises(DamagedFile, match=words) as caught:
        dataset.load(path)
    sentence = str(caught.value)
    assert sentence.startswith(f"{path}: ")
    assert sentence.endswith(": delete it and run again")
    assert "\n" not in sentence


@pytest.mark.parametrize("length", [0, 1, 7, 100, 5000, -1])
def test_a_file_cut_short_is_named(kept, length):
    kept.write_bytes(kept.read_bytes()[:length])
    refused(kept, "cannot be read")


@pytest.mark.parametrize(
    "content", [b"force,1\n", b"\0" * 5000, b"\x89HDF\r\n\x1a\n" + b"\0" * 5000]
)
def test_a_file_that_is_no_netcdf_is_named(kept, content):
    kept.write_bytes(content)
    refused(kept, "cannot be read")


def test_a_folder_in_place_of_a_file_is_named(kept):
    kept.unlink()
    kept.mkdir()
    refused(kept, "cannot be read")


@pytest.mark.parametrize("bit", range(8))
@pytest.mark.parametrize("value", [0, 499, 999])
def test_a_flipped_bit_of_a_value_is_found(kept, value, bit):
    content = bytearray(kept.read_bytes())
    begin = content.index(np.linspace(1, 2, 1000).tobytes())
    content[begin + 8 * value + 3] ^= 1 << bit
    kept.write_bytes(content)
    refused(kept, "is damaged, its content does not have its checksum")


def test_no_flipped_byte_changes_what_is_read(kept):
    content = kept.read_bytes()
    whole = dataset.load(kept)
    found = 0
    # a prime, to meet every part of the file
    for place in range(0, len(content), 97):
        damaged = bytearray(content)
        damaged[place] ^= 0xFF
        kept.write_bytes(damaged)
        try:
            # bytes that hold nothing may be anything
            assert dataset.load(kept).identical(whole), place
        except DamagedFile:
            found += 1
    # the values are 8000 bytes of the file
    assert found > 8000 / 97


@pytest.mark.parametrize(
    "change",
    [
        lambda file: file.setncattr("coordinates", "linean"),
        lambda file: file.setncattr("further", "x"),
        lambda file: file.delncattr("coordinates"),
        lambda file: file["force"].setncattr("units", "kN"),
        lambda file: file.renameVariable("force", "load"),
        lambda file: file.renameDimension("pair", "pairs"),
        lambda file: file.createDimension("further", 2),
        lambda file: file.createVariable("load", "f8", ()),
        lambda file: file.setncattr("checksum", "0" * 32),
    ],
)
def test_a_change_of_anything_but_the_values_is_found(kept, change):
    with netCDF4.Dataset(kept, "a") as file:
        change(file)
    refused(kept, "is damaged")


def test_a_result_of_an_older_version_is_refused(kept):
    with netCDF4.Dataset(kept, "a") as file:
        file.delncattr("checksum")
    refused(kept, "was written by an older version, without a checksum")


def test_a_missing_file_is_missing_not_damaged(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"a\.nc: there is no such file"):
        dataset.load(tmp_path / "a.nc")
