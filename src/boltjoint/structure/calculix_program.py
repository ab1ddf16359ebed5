"""The program CalculiX: runs it on an input deck, and reads the tables it prints."""

import logging
import os
import re
import subprocess
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

logger = logging.getLogger(__name__)

Array = NDArray[np.float64]

#: where Fortran leaves out the E, before an exponent of three digits
_LEFT_OUT = re.compile(r"(?<=\d)(?=[+-]\d{3})")


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


def run_if_possible(deck: str | Path, log: str | Path) -> None:
    """Run CalculiX as ``run``; where it stops before the end, what it printed is all there is.

    Raises
    ------
    RuntimeError
        If CalculiX is not installed.
    """
    try:
        run(deck, log)
    except RuntimeError as error:
        if not Path(log).exists() or not Path(log).stat().st_size:
            raise
        logger.warning("%s", error)
        Path(deck).with_suffix(".dat").touch()


def fields(*number: float) -> str:
    """Numbers of a line of a deck."""
    # CalculiX reads twenty characters of a number and ignores the rest silently
    return ", ".join(f"{value:.12e}" for value in number)


def paragraphs(path: str | Path) -> list[list[str]]:
    """Lines of a printed file between empty ones: a table is the paragraph after its title."""
    with Path(path).open(encoding="ascii") as lines:
        return [
            list(group) for filled, group in groupby(lines, lambda x: not x.isspace()) if filled
        ]


def tables_after(title: str, printed: list[list[str]]) -> list[Array]:
    """The tables after the paragraphs whose last line holds a title."""
    return [
        np.array([_LEFT_OUT.sub("E", line).split() for line in table], dtype=float)
        for head, table in pairwise(printed)
        if title in head[-1]
    ]


def required_tables(title: str, printed: list[list[str]], path: str | Path) -> list[Array]:
    """As ``tables_after``, of the paragraphs of a file.

    Raises
    ------
    ValueError
        If there are none.
    """
    tables = tables_after(title, printed)
    if not tables:
        raise ValueError(f"{path}: CalculiX printed no {title!r}")
    return tables
