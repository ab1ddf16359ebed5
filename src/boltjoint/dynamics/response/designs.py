"""Frequency responses of many designs, on several threads."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from os import cpu_count

from boltjoint import checks
from boltjoint.dynamics.response.branch import Branch
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.joint.model import Joint


def solve_branches(
    joints: Sequence[Joint],
    forces: Sequence[float],
    *,
    threads: int | None = None,
    **options: object,
) -> list[Branch]:
    """Frequency responses of many joints, each at its own force level.

    Threads solve at the same time what runs in compiled loops: responses in linear modes, of laws
    with a kernel.

    Parameters
    ----------
    joints, forces
        As for ``solve_branch``, as many of each.
    threads
        All processors by default. Linear algebra should have one thread then
        (``OMP_NUM_THREADS=1``).
    options
        Keywords of ``solve_branch``, alike for all.

    Raises
    ------
    ValueError
        If there are not as many joints as forces, or as for ``solve_branch``.
    """
    forces = checks.levels("forces", forces)
    checks.sequence("joints", joints, Joint)
    if len(joints) != len(forces):
        raise ValueError(f"there are {len(joints)} joints, but {len(forces)} forces")
    threads = checks.whole("threads", cpu_count() if threads is None else threads, at_least=1)
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(partial(solve_branch, **options), joints, forces))
