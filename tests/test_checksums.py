"""Checksums beside texts."""

import os
import shutil
import subprocess

import pytest

from boltjoint import checksums
from boltjoint.checksums import DamagedFile

TEXT = "force_N,peak_Hz\n1,90.5\n10,70.25\n"


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "folder" / "timing.csv"
    checksums.write_text(path, TEXT)
    return path


def refused(path, words):
    with pytest.raises(DamagedFile) as caught:
        checksums.read_text(path)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(f"{path}: {words}")
    assert line.endswith(": delete it and run again")


def test_a_text_is_what_was_written(path):
    assert path.read_text(encoding="utf-8") == checksums.read_text(path) == TEXT


def test_a_copy_without_its_checksum_and_a_text_of_another_program_are_read(path, tmp_path):
    assert checksums.read_text(shutil.copy(path, tmp_path)) == TEXT


def test_no_changed_byte_is_read(path):
    content = path.read_bytes()
    for place in range(len(content)):
        path.write_bytes(content[:place] + b"7" + content[place + 1 :])
        if path.read_bytes() != content:
            refused(path, "is damaged, its content does not have its checksum")
    for shorter in (content[:-1], content[: len(content) // 2], b""):
        path.write_bytes(shorter)
        refused(path, "is damaged")


@pytest.mark.skipif(not shutil.which("b2sum"), reason="of coreutils")
def test_b2sum_checks_it(path):
    command = ["b2sum", "--check", "timing.csv.b2"]
    assert subprocess.run(command, cwd=path.parent, check=True, capture_output=True)
    path.write_text(TEXT.replace("9", "8"), encoding="utf-8")
    assert subprocess.run(command, cwd=path.parent, check=False, capture_output=True).returncode


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (os.mkfifo, "cannot be read (is no regular file)"),
        (lambda path: path.symlink_to("/dev/zero"), "cannot be read (is no regular file)"),
        (lambda path: path.touch() or os.truncate(path, 2**40), "cannot be read (is larger than"),
        (lambda path: path.mkdir(), "cannot be read (Is a directory)"),
    ],
)
def test_devices_pipes_and_endless_files_are_named(path, make, words):
    path.unlink()
    make(path)
    refused(path, words)
    # and no less in place of the checksum
    beside = path.with_name("timing.csv.b2")
    beside.unlink()
    path.rename(beside)
    path.write_text(TEXT, encoding="utf-8")
    refused(path, words)


def test_bytes_that_are_no_text_are_named(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"a\n\xff\n")
    refused(tmp_path / "a.csv", "cannot be read (it is not text in UTF-8)")
