"""Files that a stage of the workflow reads, and those that are damaged."""

import json
import os
from pathlib import Path

import pandas as pd
import pytest

from boltjoint import checksums, csv_files
from boltjoint.checksums import DamagedFile
from boltjoint.study import layout
from boltjoint.study.stage_inputs import Results

ENVIRONMENT = layout.path("environment")
TIMING = {"case": "a", "basis": "free-4", "joint": "regions=2/elements=2"}
FIT_TIMING = layout.path("fit_timing", **TIMING)


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    checksums.write_text(ENVIRONMENT, json.dumps({"system": "a"}))
    csv_files.write(pd.DataFrame({"cpu_s": [0.1]}), FIT_TIMING)


def read():
    results = Results([ENVIRONMENT, FIT_TIMING])
    return results.record("environment"), results.data("fit_timing", **TIMING)["cpu_s"].to_list()


def test_they_are_read_as_they_were_written():
    assert read() == ({"system": "a"}, [0.1])


@pytest.mark.parametrize("file", [ENVIRONMENT, FIT_TIMING])
def test_a_damaged_text_is_named(file):
    content = Path(file).read_bytes()
    for damaged in (content[:-3], content.replace(b"s", b"t"), bytes(len(content)), b""):
        Path(file).write_bytes(damaged)
        with pytest.raises(DamagedFile, match=f"^{file}: is damaged, its content does not have"):
            read()
    Path(file).unlink()
    os.mkfifo(file)
    with pytest.raises(DamagedFile, match=rf"^{file}: cannot be read \(is no regular file\)"):
        read()


def test_a_record_that_is_none_is_named_without_its_checksum_too():
    Path(layout.beside(ENVIRONMENT)).unlink()
    for text in ('{"system": "a"', "[1]", ""):
        Path(ENVIRONMENT).write_text(text, encoding="utf-8")
        with pytest.raises(DamagedFile, match=f"^{ENVIRONMENT}: cannot be read") as caught:
            read()
        assert "\n" not in str(caught.value)
