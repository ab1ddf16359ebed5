import os
import shutil
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from boltjoint import __version__, checksums, dataset
from boltjoint.dataset import DamagedFile, quantity
from boltjoint.study import layout


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


def test_files_have_the_attributes_of_the_conventions(tmp_path):
    dataset.save(some_dataset(), tmp_path / "response.nc")
    dataset.save(dataset.load(tmp_path / "response.nc"), tmp_path / "again.nc")
    for name in ("response.nc", "again.nc"):
        with netCDF4.Dataset(tmp_path / name) as file:
            assert file.Conventions.startswith("CF-1.")
            assert file.title == dataset.TITLES["response"]
            assert file.history == f"boltjoint {__version__}"
    dataset.save(some_dataset().assign_attrs(history="nccopy a b"), tmp_path / "other.nc")
    with netCDF4.Dataset(tmp_path / "other.nc") as file:
        assert file.history.splitlines() == ["nccopy a b", f"boltjoint {__version__}"]
        assert file.title


def test_every_file_of_a_study_has_a_title():
    files = {Path(path).stem for path in layout.PATHS.values() if path.endswith(".nc")}
    assert files - {"{chunk}"} == set(dataset.TITLES)


def test_the_coordinates_of_a_solution_have_a_name_that_xarray_leaves(tmp_path):
    path = tmp_path / "response.nc"
    dataset.save(some_dataset(), path)
    with xr.open_dataset(path) as plain:
        assert plain.attrs["solution_coordinates"] == "linear"
    read = dataset.load(path)
    assert read.attrs["coordinates"] == read.attrs["solution_coordinates"] == "linear"
    # of files without them as well
    some_dataset().to_netcdf(tmp_path / "old.nc")
    checksums.append(tmp_path / "old.nc")
    assert dataset.load(tmp_path / "old.nc").attrs == {"coordinates": "linear"}
    dataset.save(some_dataset().drop_attrs(deep=False), path)
    assert "solution_coordinates" not in dataset.load(path).attrs


class Params:
    """As Snakemake gives them to a script: items, and no mapping."""

    def items(self):
        return iter([("preload", 1e4), ("library", "1f")])


def test_parameters_are_those_of_a_job(tmp_path):
    dataset.save(some_dataset(), tmp_path / "a.nc", Params())
    assert dataset.load(tmp_path / "a.nc").attrs["parameters"] == "preload=10000.0"


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
    # and what is made of it has a checksum of its own
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


@pytest.fixture
def unopened(monkeypatch):
    """Libraries that must not open a file, since they may never return from a damaged one."""

    def opened(*_, **__):
        raise AssertionError

    monkeypatch.setattr(netCDF4, "Dataset", opened)
    monkeypatch.setattr(xr, "load_dataset", opened)


@pytest.mark.parametrize("length", [0, 1, 7, 100, 5000, -1])
def test_a_file_cut_short_is_named(kept, length, unopened):
    kept.write_bytes(kept.read_bytes()[:length])
    refused(kept, "cannot be read, without a checksum at its end")


NO_NETCDF = [b"force,1\n", b"\0" * 5000, b"\x89HDF\r\n\x1a\n" + b"\0" * 5000]


@pytest.mark.parametrize("content", NO_NETCDF)
def test_a_file_that_is_no_netcdf_is_named(kept, content):
    kept.write_bytes(content)
    refused(kept, "cannot be read, without a checksum at its end")
    checksums.append(kept)
    refused(kept, "cannot be read")


@pytest.mark.parametrize("size", [1, 64, 512, 4096])
def test_no_zeroed_block_is_opened(kept, size, unopened):
    content = kept.read_bytes()
    damaged = 0
    for begin in range(0, len(content), max(size, 256)):
        zeroed = content[:begin] + bytes(size) + content[begin + size :]
        if (zeroed := zeroed[: len(content)]) != content:
            kept.write_bytes(zeroed)
            refused(kept, "checksum")
            damaged += 1
    assert damaged >= len(content) // 8192


def test_other_programs_read_it_and_its_copy(kept, tmp_path):
    copy = shutil.copy(kept, tmp_path / "copy.nc")
    assert dataset.load(copy).identical(dataset.load(kept))
    with xr.open_dataset(copy, decode_coords=False) as read, netCDF4.Dataset(copy) as file:
        assert read.load().identical(dataset.load(kept))
        np.testing.assert_array_equal(file["force"], np.linspace(1, 2, 1000))


def test_a_file_of_another_program_is_given_a_checksum_by_saving_it(tmp_path):
    path = tmp_path / "other.nc"
    some_dataset().to_netcdf(path)
    refused(path, "or another program, and boltjoint.dataset.save adds one")
    dataset.save(xr.load_dataset(path), path)
    xr.testing.assert_equal(dataset.load(path), some_dataset())


@pytest.mark.parametrize("compressed", [False, True])
def test_a_file_that_declares_more_than_it_can_hold_is_not_loaded(
    tmp_path, compressed, monkeypatch
):
    path = tmp_path / "a.nc"
    with netCDF4.Dataset(path, "w") as file:
        # 80 GB that were never written
        file.createDimension("pair", 10**10)
        chunks = [1000] if compressed else None
        file.createVariable("force", "f8", "pair", zlib=compressed, chunksizes=chunks)
    checksums.append(path)
    assert path.stat().st_size < 20_000
    monkeypatch.setattr(xr, "load_dataset", pytest.fail)
    refused(path, "declares more values than [0-9]+ bytes can hold")


def test_compressed_values_are_read(tmp_path):
    path, values = tmp_path / "a.nc", quantity("pair", np.zeros(10**6), "N", "force")
    values.encoding = {"zlib": True}
    dataset.save(xr.Dataset({"force": values}), path)
    assert path.stat().st_size < 100_000
    assert not dataset.load(path)["force"].any()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (os.mkfifo, "is no regular file"),
        (lambda path: path.symlink_to("/dev/zero"), "is no regular file"),
        (lambda path: path.touch() or os.truncate(path, 2**40), "is larger than 68719476736 bytes"),
    ],
)
def test_devices_pipes_and_endless_files_are_named(kept, make, words, unopened):
    kept.unlink()
    make(kept)
    refused(kept, rf"cannot be read \({words}\)")


def test_a_folder_in_place_of_a_file_is_named(kept):
    kept.unlink()
    kept.mkdir()
    refused(kept, "cannot be read")


@pytest.mark.parametrize("bit", range(8))
def test_a_flipped_bit_is_found_wherever_it_is(kept, bit, unopened):
    content = kept.read_bytes()
    # a prime, to meet every part of the file, and the checksum itself
    for place in [*range(0, len(content), 97), *range(len(content) - 70, len(content))]:
        damaged = bytearray(content)
        damaged[place] ^= 1 << bit
        kept.write_bytes(damaged)
        refused(kept, "checksum")


@pytest.mark.parametrize(
    "change",
    [
        lambda file: file.setncattr("coordinates", "linean"),
        lambda file: file["force"].setncattr("units", "kN"),
        lambda file: file.renameVariable("force", "load"),
        lambda file: file.createVariable("load", "f8", ()),
    ],
)
def test_a_change_by_another_program_is_found(kept, change):
    with netCDF4.Dataset(kept, "a") as file:
        change(file)
    refused(kept, "checksum")


def test_a_missing_file_is_missing_not_damaged(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"a\.nc: there is no such file"):
        dataset.load(tmp_path / "a.nc")
