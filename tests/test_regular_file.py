"""Devices, pipes, folders, files that are too large, and links that lead out of a folder."""

import os

import pytest

from boltjoint.regular_file import UnsuitableFile, read_bytes


def test_a_file_is_read_up_to_its_largest_size(tmp_path):
    file = tmp_path / "file"
    file.write_bytes(b"12345")
    assert read_bytes(file, 5, tmp_path) == b"12345"
    with pytest.raises(UnsuitableFile, match="file: is larger than 4 bytes"):
        read_bytes(file, 4)


def test_a_file_without_content_on_the_disk_is_not_read(tmp_path):
    with (tmp_path / "sparse").open("wb") as file:
        file.truncate(10**12)
    with pytest.raises(UnsuitableFile, match="is larger than 1000000 bytes"):
        read_bytes(tmp_path / "sparse", 10**6)


def test_devices_pipes_and_folders_are_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/zero")
    for path in (tmp_path / "pipe", tmp_path / "link", "/dev/zero"):
        with pytest.raises(UnsuitableFile, match="is no regular file"):
            read_bytes(path, 10)
    with pytest.raises(IsADirectoryError, match="Is a directory"):
        read_bytes(tmp_path, 10)


def test_links_stay_in_the_folder(tmp_path):
    folder = tmp_path / "study"
    (folder / "inner").mkdir(parents=True)
    (folder / "file").write_bytes(b"inside")
    (tmp_path / "study beside").write_bytes(b"outside")
    for name, target in {
        "inner/kept": "../file",
        "out": "../study beside",
        "passwords": "/etc/passwd",
        "circle": "circle",
    }.items():
        (folder / name).symlink_to(target)
    # the folder itself may be a link
    (tmp_path / "other").symlink_to(folder)
    assert read_bytes(folder / "inner/kept", 10, tmp_path / "other") == b"inside"
    outside = (folder / "out", folder / "passwords", folder / "../study beside", "/etc/passwd")
    for path in outside:
        with pytest.raises(UnsuitableFile, match="lies outside the folder of the study"):
            read_bytes(path, 10, folder)
    with pytest.raises(OSError, match="symbolic links"):
        read_bytes(folder / "circle", 10, folder)
