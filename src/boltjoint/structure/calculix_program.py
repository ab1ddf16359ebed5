"""The program CalculiX: runs it on an input deck."""

import os
import subprocess
from pathlib import Path


def run(deck: str | Path, log: str | Path) -> None:
    """Run CalculiX on a deck; its printed output is beside the deck, ending in ``.dat``.

    Parameters
    ----------
    deck
        A file ending in ``.inp``.
    log
        File for the progress messages of CalculiX.

    Raises
    ------
    RuntimeError
        If CalculiX is not installed, or stops before the end.
    """
    deck, log = Path(deck), Path(log)
    log.parent.mkdir(parents=True, exist_ok=True)
    # one thread: sums in another order would change the last digits from machine to machine
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    command = ["ccx", "-i", deck.stem]
    try:
        with log.open("w") as messages:
            done = subprocess.run(
                command, cwd=deck.parent, env=environment, stdout=messages, stderr=subprocess.STDOUT
            )
    except FileNotFoundError:
        raise RuntimeError("there is no program ccx: install CalculiX") from None
    if done.returncode:
        raise RuntimeError(f"CalculiX could not solve {deck}, see {log}")
