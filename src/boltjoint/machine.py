"""Memory of the machine that this runs on."""

import os
from pathlib import Path


def machine_memory() -> float:
    """Memory of this machine, or what its control group (cgroup v2) may have of it [byte]."""
    memory = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    limit = Path("/sys/fs/cgroup/memory.max")
    if limit.is_file() and (text := limit.read_text().strip()) != "max":
        memory = min(memory, float(text))
    return memory
