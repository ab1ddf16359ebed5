"""Where a stage of the workflow says what it does."""

import logging
from pathlib import Path


def write_to(path: str | Path) -> None:
    """Send the library's log to a file, and its warnings to the terminal too."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    to_file = logging.FileHandler(path, mode="w")
    to_terminal = logging.StreamHandler()
    to_terminal.setLevel(logging.WARNING)
    logging.basicConfig(
        level=logging.INFO,
        format="%(asctime)s %(levelname)s %(name)s: %(message)s",
        handlers=[to_file, to_terminal],
        force=True,
    )
