"""The software and machine of a study: processor, memory, system, Python and package versions."""

import os
import platform
import sys
from email.parser import HeaderParser
from importlib.metadata import Distribution, distributions
from pathlib import Path


def machine_memory() -> float:
    """Memory of this machine, or what its control group (cgroup v2) may have of it [byte]."""
    memory = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    limit = Path("/sys/fs/cgroup/memory.max")
    if limit.is_file() and (text := limit.read_text().strip()) != "max":
        memory = min(memory, float(text))
    return memory


def record() -> dict[str, object]:
    """The machine's processor, cores and system, Python, and the installed packages."""
    packages = filter(None, map(_name_and_version, distributions()))
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": sys.version.split()[0],
        "packages": dict(sorted(packages, key=lambda package: package[0].lower())),
    }


def _name_and_version(package: Distribution) -> tuple[str, str] | None:
    """As ``metadata`` has them, without its parsing of the whole description for each of them."""
    text = next(filter(None, map(package.read_text, ("METADATA", "PKG-INFO", ""))), None)
    if text is None:
        return None
    headers = HeaderParser().parsestr(text.partition("\n\n")[0])
    # one that is not quite installed has none
    return None if headers["Name"] is None else (headers["Name"], headers["Version"])


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
