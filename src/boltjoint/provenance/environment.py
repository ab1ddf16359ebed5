"""The software and machine of a study: processor, system, Python and package versions."""

import os
import platform
import sys
from importlib.metadata import distributions
from pathlib import Path


def record() -> dict[str, object]:
    """The machine's processor, cores and system, Python, and the installed packages."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": sys.version.split()[0],
        "packages": {
            package.metadata["Name"]: package.version
            for package in sorted(distributions(), key=lambda package: str(package.name).lower())
            # one that is not quite installed has none
            if package.name is not None
        },
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
