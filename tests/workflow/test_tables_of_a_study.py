"""What a table of designs and the map of a gap make anew, and files that no run waits for."""

import os
import shutil

import pytest
from planned import among, planned
from small_study import ASSEMBLY, SETTINGS, SWEEP, run, snakemake, write

TABLE, MAP = "config/sweeps/designs.csv", "config/assemblies/measured.csv"
DESIGNS = "loss_factor\n0.004\n0.005\n"
SWEPT = {key: value for key, value in SWEEP.items() if key != "vary"}
FLAT = "x_mm,y_mm,gap_um\n" + "".join(f"{x},{y},0\n" for x in (-40, 40) for y in (-10, 10))
MADE = ["results/assemblies/two_bolt/assembly.nc", "results/sweeps/listed/designs.nc"]


@pytest.fixture(scope="module")
def listed(project, tmp_path_factory):
    """A study with a map and a table of designs; the files that are made from them are there."""
    folder = tmp_path_factory.mktemp("listed") / "study"
    shutil.copytree(project, folder, ignore=shutil.ignore_patterns("results", ".snakemake"))
    write(folder / "config/config.yaml", SETTINGS | {"sweeps": ["listed"]})
    write(folder / "config/assemblies/two_bolt.yaml", ASSEMBLY | {"contact": {"gap_um": MAP}})
    design = {"kind": "table", "file": TABLE}
    write(folder / "config/sweeps/listed.yaml", SWEPT | {"case": "small", "design": design})
    (folder / TABLE).write_text(DESIGNS, encoding="utf-8")
    (folder / MAP).write_text(FLAT, encoding="utf-8")
    run(folder, *MADE)
    assert planned(folder, *MADE) == []
    return folder


@pytest.mark.parametrize(
    ("file", "more", "made"), [(TABLE, "0.006\n", MADE[1]), (MAP, "0,0,0\n", MADE[0])]
)
def test_the_content_of_a_table_counts_and_not_its_date(listed, file, more, made):
    path = listed / file
    kept, text = path.stat(), path.read_text(encoding="utf-8")
    path.write_text(text + more, encoding="utf-8")
    os.utime(path, ns=(kept.st_atime_ns, kept.st_mtime_ns))
    of_assembly = among(planned(listed, *MADE), "*/structure.nc")
    assert among(planned(listed, *MADE), "*.nc") == sorted([made, *of_assembly])
    assert bool(of_assembly) == (made == MADE[0])
    path.write_text(text, encoding="utf-8")
    assert planned(listed, *MADE) == []


@pytest.mark.parametrize("file", [TABLE, MAP, "config/cases/small.yaml"])
def test_a_dry_run_waits_for_no_pipe(listed, file):
    path = listed / file
    text = path.read_text(encoding="utf-8")
    path.unlink()
    os.mkfifo(path)
    try:
        ran = snakemake(listed, "--dry-run")
    finally:
        path.unlink()
        path.write_text(text, encoding="utf-8")
    assert ran.returncode != 0
    assert "is no regular file" in ran.stdout + ran.stderr
    assert "Traceback" not in ran.stdout + ran.stderr
