"""Comparison of the results of two runs of a study, to the bit.

Every variable of every netCDF file and every cell of every CSV file counts, times excepted; of
attributes, those that differ are listed::

    python benchmarks/compare_results.py OLD/results NEW/results --renamed principal.nc=pod_modes.nc
"""

import argparse
import csv
import sys
from collections.abc import Iterator
from pathlib import Path

import netCDF4
import numpy as np

#: parts of the names of columns that hold times, or what is computed from times
TIMES = ("wall_s", "cpu_", "time", "reduction", "repeat", "difference_points")


def differences(old: Path, new: Path, renamed: dict[str, str]) -> Iterator[str]:
    """A line for each variable or column that is not the same in two files."""
    compare = compare_netcdf if old.suffix == ".nc" else compare_csv
    yield from compare(old, new, renamed)


def compare_netcdf(old: Path, new: Path, renamed: dict[str, str]) -> Iterator[str]:
    """Variables that differ in value, type or shape."""
    with netCDF4.Dataset(old) as first, netCDF4.Dataset(new) as second:
        for file in (first, second):
            file.set_auto_maskandscale(False)
        for name in first.variables:
            other = renamed.get(name, name)
            if other not in second.variables:
                yield f"{name} is missing"
                continue
            one, two = np.asarray(first[name][...]), np.asarray(second[other][...])
            values = (one.tolist(), two.tolist()) if one.dtype == object else (one, two)
            if one.dtype != two.dtype or one.shape != two.shape:
                yield f"{name} has another type or shape"
            elif (one.dtype == object and values[0] != values[1]) or (
                one.dtype != object and one.tobytes() != two.tobytes()
            ):
                yield f"{name} differs"


def attributes(old: Path, new: Path) -> set[str]:
    """Names of the attributes of two netCDF files that differ."""
    with netCDF4.Dataset(old) as first, netCDF4.Dataset(new) as second:
        names = {*first.ncattrs(), *second.ncattrs()}
        return {
            name
            for name in names
            if str(first.__dict__.get(name)) != str(second.__dict__.get(name))
        }


def compare_csv(old: Path, new: Path, renamed: dict[str, str]) -> Iterator[str]:
    """Columns that differ, times excepted; of repeated timings each kind of row counts once."""
    first, second = (read(path) for path in (old, new))
    for column in first[0] if first else ():
        if any(part in column for part in TIMES):
            continue
        other = renamed.get(column, column)
        one, two = (
            [row.get(name) for row in rows] for rows, name in ((first, column), (second, other))
        )
        if old.name == "timing.csv":
            one, two = sorted(set(one)), sorted(set(two))
        if one != two:
            yield f"{column} differs"


def read(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def main() -> int:
    """Compare two folders; the number of differences is printed last."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--renamed", nargs="*", default=[], metavar="OLD=NEW")
    given = parser.parse_args()
    renamed = dict(pair.split("=", 1) for pair in given.renamed)
    count, found, changed = 0, 0, set()
    for old in sorted(given.old.rglob("*")):
        if old.suffix not in (".nc", ".csv"):
            continue
        name = old.relative_to(given.old)
        new = given.new / name.with_name(renamed.get(name.name, name.name))
        lines = list(differences(old, new, renamed)) if new.exists() else ["is missing"]
        for line in lines:
            print(f"{name}: {line}")
        count, found = count + 1, found + len(lines)
        if old.suffix == ".nc" and new.exists():
            changed |= attributes(old, new)
    print(f"{count} files, {found} differences; attributes that differ: {sorted(changed)}")
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
