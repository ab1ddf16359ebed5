"""The files that a run of the workflow would make."""

import re
from fnmatch import fnmatch

from small_study import run


def planned(folder, *options):
    """The results that a run would make, found by a dry run."""
    said = run(folder, "--dry-run", *options)
    outputs = re.findall(r"^    output: (.+)$", said, flags=re.MULTILINE)
    return [path for output in outputs for path in output.split(", ")]


def among(paths, *patterns):
    """Those that match a pattern, in which * stands for folders too, sorted."""
    return sorted(
        path for path in paths if any(fnmatch(path, f"results/{each}") for each in patterns)
    )
