"""Logs of the stages of the workflow: milestones, warnings and failures."""

import logging
import sys
from pathlib import Path
from types import TracebackType

logger = logging.getLogger(__name__)

_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"


def write_to(path: str | Path) -> None:
    """Send the library's log to a file, and its warnings to the terminal too, each once.

    There they name what the file is of, as many jobs write. An exception that nothing catches goes
    to the file with its traceback, and as one line to the terminal.
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    to_file = logging.FileHandler(path, mode="w")
    to_file.setFormatter(logging.Formatter(_FORMAT))
    to_terminal = logging.StreamHandler()
    to_terminal.setFormatter(_OneLine(Path(path).stem))
    to_terminal.setLevel(logging.WARNING)
    to_terminal.addFilter(_Once())
    logging.basicConfig(level=logging.INFO, handlers=[to_file, to_terminal], force=True)
    sys.excepthook = _log_failure


class _OneLine(logging.Formatter):
    """A record in one line with its subject, without the traceback of its exception."""

    def __init__(self, subject: str) -> None:
        super().__init__()
        self._subject = subject

    def format(self, record: logging.LogRecord) -> str:
        kind = "warning" if record.levelno < logging.ERROR else "error"
        return f"     {kind}: {self._subject}: {' '.join(record.getMessage().split())}"


class _Once(logging.Filter):
    """Lets each message pass once."""

    def __init__(self) -> None:
        super().__init__()
        self._told: set[str] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        message = record.getMessage()
        is_new = message not in self._told
        self._told.add(message)
        return is_new


def _log_failure(
    kind: type[BaseException], error: BaseException, traceback: TracebackType | None
) -> None:
    if issubclass(kind, Exception):
        logger.critical("%s: %s", kind.__name__, error, exc_info=(kind, error, traceback))
    else:
        # an interruption from the keyboard is no failure of the stage
        sys.__excepthook__(kind, error, traceback)
