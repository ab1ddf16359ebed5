"""Checksums of result files, compared before anything else reads these files.

A netCDF file has its checksum at the end, after what HDF5 reads, so that a copy of the file keeps
it. A text has it in a file beside it, of the same name and ``.b2``, as ``b2sum --check`` reads it:
tables remain plain CSV for every program. Libraries that read damaged files may never return; the
checksum is compared before.
"""

import re
from hashlib import blake2b
from pathlib import Path

from boltjoint import checks
from boltjoint.regular_file import UnsuitableFile, read_bytes, require_regular

#: bytes of a result, more than the memory of most machines
LARGEST_RESULT = 2**36
#: bytes of a text among the results, with room for tables of many designs
LARGEST_TEXT = 10**9
#: suffix of the file with the checksum of a text
BESIDE = ".b2"

_LABEL = b"\nBLAKE2b of all before this line: "
_DIGITS = 32
_LENGTH = len(_LABEL) + _DIGITS + 1
_BLOCK = 2**20


class DamagedFile(ValueError):
    """A result that cannot be used, with its file and what to do."""

    def __init__(self, path: str | Path, what: object) -> None:
        super().__init__(f"{path}: {what}: delete it and run again")


def append(path: str | Path) -> None:
    """Write the checksum of a file at its end."""
    path = checks.path("path", path)
    checksum = _checksum(path, path.stat().st_size)
    with open(path, "ab") as file:
        file.write(_LABEL + checksum.encode() + b"\n")


def verify_appended(path: str | Path) -> int:
    """Compare a file with the checksum at its end.

    Returns
    -------
    int
        Size of the file without its checksum [byte].

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    DamagedFile
        If it is no regular file, cannot be read, has no checksum at its end, or another one.
    """
    path = _require_present(path)
    try:
        require_regular(path, LARGEST_RESULT)
        size = max(path.stat().st_size - _LENGTH, 0)
        with open(path, "rb") as file:
            file.seek(size)
            line = file.read(_LENGTH)
        has_checksum = re.fullmatch(re.escape(_LABEL) + rb"[0-9a-f]{%d}\n" % _DIGITS, line)
        is_whole = has_checksum and line == _LABEL + _checksum(path, size).encode() + b"\n"
    except (OSError, UnsuitableFile) as error:
        raise _unreadable(path, error) from error
    if not has_checksum:
        what = "cannot be read, without a checksum at its end (it was cut short, or written by an "
        what += "older version or another program, and boltjoint.dataset.save adds one)"
        raise DamagedFile(path, what)
    if not is_whole:
        raise DamagedFile(path, "is damaged, its content does not have its checksum")
    return size


def write_text(path: str | Path, text: str) -> None:
    """Write a text in UTF-8, and its checksum beside it."""
    path = checks.path("path", path)
    checks.instance("text", text, str)
    content = text.encode()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    beside = f"{blake2b(content, digest_size=_DIGITS // 2).hexdigest()}  {path.name}\n"
    path.with_name(path.name + BESIDE).write_text(beside, encoding="utf-8")


def read_text(path: str | Path) -> str:
    """Read a text that ``write_text`` wrote.

    A text of another program, without a checksum beside it, is read as it is.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    DamagedFile
        If it is no regular file, cannot be read, does not have the checksum beside it, or is not
        UTF-8.
    """
    path = _require_present(path)
    beside = path.with_name(path.name + BESIDE)
    try:
        content = read_bytes(path, LARGEST_TEXT)
        recorded = read_bytes(beside, _BLOCK) if beside.exists() else None
    except (OSError, UnsuitableFile) as error:
        raise _unreadable(path, error) from error
    checksum = blake2b(content, digest_size=_DIGITS // 2).hexdigest().encode()
    if recorded is not None and recorded[:_DIGITS] != checksum:
        raise DamagedFile(path, f"is damaged, its content does not have its checksum ({beside})")
    try:
        return content.decode()
    except UnicodeDecodeError as error:
        raise DamagedFile(path, "cannot be read (it is not text in UTF-8)") from error


def _require_present(path: str | Path) -> Path:
    path = checks.path("path", path)
    if not path.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    return path


def _unreadable(path: str | Path, error: OSError | UnsuitableFile) -> DamagedFile:
    reason = error.sentence if isinstance(error, UnsuitableFile) else error.strerror or error
    return DamagedFile(path, f"cannot be read ({reason})")


def _checksum(path: str | Path, size: int) -> str:
    """Checksum of the first bytes of a file."""
    digest, left = blake2b(digest_size=_DIGITS // 2), size
    with open(path, "rb") as file:
        while left and (block := file.read(min(_BLOCK, left))):
            digest.update(block)
            left -= len(block)
    return digest.hexdigest()
