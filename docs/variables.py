"""Write the page of the variables of result files: ``python docs/variables.py STUDY ...``.

Of each kind of netCDF file it has all variables of all finished studies whose folders are named,
with dimensions, unit and meaning as the files tell them.
"""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from string import Formatter

from boltjoint import dataset
from boltjoint.study import layout

HERE = Path(__file__).parent
PAGE = HERE / "variables.md"

_HEAD = """# Variables of result files

Every variable of the netCDF files under `results/`, with its meaning as the files themselves tell
it. Units are SI; 1 is a pure number. Some variables are there only where there is something to
store, as those of a law of friction. Results of a sweep on a grid have the varied keys in place of
the dimension `design`.

Made from finished studies by `python docs/variables.py STUDY ...`.
"""

#: labels of an axis that are listed, at most
_FEW = 8

#: a variable of a file: name, dimensions, unit and meaning
Row = tuple[str, str, str, str]


def kinds() -> Iterator[tuple[str, str]]:
    """Names of netCDF files of ``layout.PATHS``, and patterns of their paths."""
    for path in layout.PATHS.values():
        if path.endswith(".nc"):
            fields = {field for _, field, _, _ in Formatter().parse(path) if field}
            yield Path(path).name, path.format(**dict.fromkeys(fields, "*"))


def rows_of(file: Path) -> Iterator[Row]:
    """The variables of a file."""
    for name, variable in dataset.load(file).variables.items():
        meaning, values = variable.attrs.get("long_name", ""), variable.to_numpy()
        if not meaning and values.dtype.kind in "OU":
            is_axis = variable.dims == (name,)
            meaning = f"labels: {', '.join(map(str, values[:_FEW]))}" if is_axis else "text"
        dimensions = ", ".join(map(str, variable.dims)) or "–"
        yield str(name), dimensions, variable.attrs.get("units", ""), meaning


def merged(rows: Iterable[Row]) -> list[Row]:
    """All rows, of those that differ in labels or in the dimensions of a sweep one."""
    alike: dict[tuple[str, str, str], Row] = {}
    for row in rows:
        name, dimensions, unit, meaning = row
        kind = name, unit, meaning.partition(": ")[0] if meaning.startswith("labels") else meaning
        one = alike.setdefault(kind, row)
        if meaning != one[3]:
            alike[kind] = name, dimensions, unit, "labels"
        elif dimensions.startswith("design"):
            alike[kind] = row
    return sorted(alike.values())


def page(studies: Iterable[Path]) -> str:
    """A table of each kind of file."""
    studies, parts = list(studies), [_HEAD]
    for title, pattern in kinds():
        # a joint with several elements in each region lies one folder deeper
        patterns = pattern, pattern.replace("results/cases/*/*/*", "results/cases/*/*/*/*")
        files = [file for study in studies for one in patterns for file in study.glob(one)]
        parts.append(f"\n## {title}\n\n| variable | dimensions | unit | meaning |\n")
        parts.append("|---|---|---|---|\n")
        for name, *rest in merged(row for file in sorted(files) for row in rows_of(file)):
            parts.append(f"| `{name}` | {' | '.join(rest)} |\n")
    return "".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(map(Path, sys.argv[1:])), encoding="utf-8")
