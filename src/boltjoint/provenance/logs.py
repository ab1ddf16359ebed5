"""Logs of the stages of the workflow: milestones, warnings and failures."""

import copy
import logging
import sys
from pathlib import Path
from types import TracebackType

logger = logging.getLogger(__name__)

_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"


def write_to(path: str | Path) -> None:
    """Send the library's log to a file, and its warnings to the terminal too.

    An exception that nothing catches goes to the file with its traceback, and as one line to the
    terminal.
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    to_file = logging.FileHandler(path, mode="w")
    to_file.setFormatter(logging.Formatter(_FORMAT))
    to_terminal = logging.StreamHandler()
    to_terminal.setFormatter(_OneLine(_FORMAT))
    to_terminal.setLevel(logging.WARNING)
    logging.basicConfig(level=logging.INFO, handlers=[to_file, to_terminal], force=True)
    sys.excepthook = _log_failure


class _OneLine(logging.Formatter):
    """A record in one line, without the traceback of its exception."""

    def format(self, record: logging.LogRecord) -> str:
        # the record is shared with the handler of the file, which keeps the traceback on it
        bare = copy.copy(record)
        bare.exc_info = bare.exc_text = bare.stack_info = None
        return " ".join(super().format(bare).split())


def _log_failure(
    kind: type[BaseException], error: BaseException, traceback: TracebackType | None
) -> None:
    if issubclass(kind, Exception):
        logger.critical("%s: %s", kind.__name__, error, exc_info=(kind, error, traceback))
    else:
        # an interruption from the keyboard is no failure of the stage
        sys.__excepthook__(kind, error, traceback)
