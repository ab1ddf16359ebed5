"""Regular files of limited size: no device, no pipe, and no more bytes than a limit.

Reading them ends. A pipe may keep its reader waiting for ever, and a device may have no end.
"""

import errno
import os
from pathlib import Path
from stat import S_ISDIR, S_ISREG

from boltjoint import checks


class UnsuitableFile(ValueError):
    """Why a file is not read: ``sentence`` is without a subject."""

    def __init__(self, path: str | Path, sentence: str) -> None:
        super().__init__(f"{path}: {sentence}")
        self.sentence = sentence


def read_bytes(path: str | Path, largest: int, folder: str | Path | None = None) -> bytes:
    """The content of a regular file.

    Parameters
    ----------
    path
        The file; links are followed.
    largest
        Its largest size [byte].
    folder
        The folder in which it must lie once links are followed; by default it may lie anywhere.

    Raises
    ------
    OSError
        If the file cannot be read, or is a folder.
    UnsuitableFile
        If it lies elsewhere, is a device, pipe or socket, or is larger than that.
    ValueError
        If an argument is of another kind.
    """
    require_regular(path, largest, folder)
    with open(path, "rb") as file:
        # it may have grown since
        content = file.read(largest + 1)
    _require_size(path, len(content), largest)
    return content


def require_regular(path: str | Path, largest: int, folder: str | Path | None = None) -> None:
    """Refuse what ``read_bytes`` refuses, without opening the file."""
    # a whole number would be a file that is open already
    path = checks.path("path", path)
    checks.whole("largest", largest, at_least=0)
    if folder is not None:
        above = os.path.realpath(checks.path("folder", folder))
        if os.path.commonpath([above, os.path.realpath(path)]) != above:
            raise UnsuitableFile(path, "lies outside the folder of the study")
    status = os.stat(path)
    if S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not S_ISREG(status.st_mode):
        raise UnsuitableFile(path, "is no regular file")
    _require_size(path, status.st_size, largest)


def _require_size(path: str | Path, size: int, largest: int) -> None:
    if size > largest:
        raise UnsuitableFile(path, f"is larger than {largest} bytes")
