"""What a run tells in the terminal: jobs in words, the time left, why one failed, the answer."""

import logging
import math
import re
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

#: rules in words, by how their names begin; what follows names the case or the assembly
_WORDS = {
    "build_assembly": "mesh",
    "apply_preload": "preload",
    "find_modes": "modes",
    "find_pod_modes": "contact-adapted vectors",
    "find_patterns": "bases against the finite elements",
    "connect_nodes": "joint node to node",
    "partition_regions": "joint of regions",
    "weigh_pairs": "joint of weighted pairs",
    "weigh_pairs_of": "joint of weighted pairs of",
    "reduce_joint": "fewer elements",
    "find_peaks": "peaks of the reference",
    "solve_responses": "responses",
    "check_responses": "checks of responses",
    "time_by_differences": "times with forward differences",
    "calibrate_joint": "fit to the measurement",
    "predict_measured": "prediction of what was held aside",
    "list_designs": "designs",
    "solve_designs": "responses of designs",
    "check_sweep": "checks of designs",
    "tabulate": "tables",
    "draw": "figures",
    "write_page_of": "page of",
    "write_overview": "overview",
}

#: processor time of a job that hardly computes [s]
_SHORT = 3.0
#: jobs above this time are told when they begin [s]
_LONG = 90.0
#: share of the work from which the time that is left is told
_ENOUGH = 0.1
#: share of the work that would have to be done for its time to count as much as the estimated one
_TRUST = 0.3

#: what Snakemake says of itself, and of the command in which a job failed
_OF_SNAKEMAKE = re.compile(
    r"$|Select jobs|Execute \d+ jobs|Assuming unrestricted|Building DAG|Using |Provided "
    r"|Rules claiming|Conda env|Loading script|Elapsed time|Complete log"
    r"|Reasons:|\d+ jobs have |Rules with provenance|Some jobs were triggered|This was a dry-run"
    r"|Exiting because a job|Removing output files of failed job|Shutting down|WorkflowError:\nAt "
)
#: that a command failed, and how it ended
_STATUS = re.compile(r"^RuleException:\s+CalledProcessError.*\b((?:returned|died) .*)", re.DOTALL)
#: events of Snakemake that tell a user nothing
_UNTOLD = ("run_info", "workflow_started", "resources_info", "job_started")
#: the rule that computes nothing
_ALL = "all"
#: where in a Snakefile a configuration was refused
_FRAMES = re.compile(r'^WorkflowError in file ".*", line \d+:\n|\n *File ".*", line \d+, in .*')

_UP_TO_DATE = "Nothing to be done"

#: variable of the environment by which the command asks for ``has_words``, and tells the folder of
#: the study as its user names it
STUDY_AS_NAMED = "BOLTJOINT_STUDY_AS_NAMED"


class _Job(NamedTuple):
    words: str
    seconds: float
    log: tuple[str, ...] = ()
    reason: str = ""


class Progress(logging.Formatter):
    """Filter and formatter of what Snakemake writes to the terminal; its log file keeps all.

    Parameters
    ----------
    answer
        Gives the answer of the study, where nothing is left to do.
    seconds
        Gives the processor time of a job [s] by its ``runtime`` [min].
    is_dry
        Whether jobs are listed only, as Snakemake does.
    has_words
        Whether they are listed in words instead, a line each.
    """

    def __init__(
        self,
        answer: Callable[[], str],
        seconds: Callable[[float], float],
        is_dry: bool = False,
        has_words: bool = False,
    ) -> None:
        super().__init__()
        self._usual = logging.Formatter()
        self._answer, self._seconds, self._is_dry = answer, seconds, is_dry
        self._has_words = has_words
        self._jobs: dict[int, _Job] = {}
        self._failed: dict[int, _Job] = {}
        self._ended: _Job | None = None
        self._status = ""
        self._planned, self._done, self._begin = 0.0, 0.0, time.monotonic()
        self._cores: int | None = None

    def attach(self, logger: logging.Logger) -> None:
        """Take over the handler by which a logger writes to the terminal, if it has one."""
        for handler in logger.handlers:
            if handler.name == "DefaultStreamHandler":
                self._usual = handler.formatter or self._usual
                # jobs are noted of which nothing is told, as --quiet asks
                handler.filters.insert(0, self)
                handler.setFormatter(self)

    def start(self, runtimes: Iterable[float], cores: int | None) -> None:
        """Note the jobs of a run by their ``runtime`` [min]; ``cores`` are None on a cluster."""
        self._planned, self._begin = sum(map(self._time_of, runtimes)), time.monotonic()
        self._cores = cores

    def failures(self) -> str:
        """A line for each job that failed, with the reason and the log."""
        lines = []
        for job in self._failed.values():
            reason = next(filter(None, map(_critical_line, job.log)), "") or job.reason
            lines.append(f"failed: {job.words}{reason and ': ' + reason}")
            lines += [f"  log: {path}" for path in job.log]
        return "\n".join(lines)

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record of Snakemake is told."""
        event, told = _event(record), vars(record)
        if self._is_dry and self._has_words and event in ("job_info", "run_info"):
            return event == "job_info" and told["rule_name"] != _ALL
        if self._is_dry and not self._has_words:
            return True
        if event == "job_info":
            job = self._note(record)
            # a blank line would stand before it
            return job.seconds > _LONG
        if event == "job_finished":
            number = told.get("job_id", -1)
            self._ended = self._jobs.get(number)
            self._failed.pop(number, None)  # it was tried again
            self._done += self._ended.seconds if self._ended else _SHORT
            return False
        if event == "job_error":
            number, is_new = told["jobid"], told["jobid"] not in self._failed
            words = told.get("rule_msg") or told.get("msg") or ""
            reason = self._status or " ".join(str(words).split())
            self._failed[number] = self._note(record)._replace(reason=reason)
            self._status = ""
            return is_new
        if event in _UNTOLD:
            return False
        if event not in ("", "error"):
            return True
        line = str(record.msg or "")
        if status := _STATUS.search(line):
            # the job's own words come from its log
            self._status = status[1]
            return False
        if line.startswith(_UP_TO_DATE):
            # the answer comes last, where it is after a run
            print(line, file=sys.stderr, flush=True)
            print(self._answer())
            return False
        return not _OF_SNAKEMAKE.match(line)

    def format(self, record: logging.LogRecord) -> str:
        """The line or lines of a record."""
        event, told = _event(record), vars(record)
        if self._is_dry and self._has_words and event == "job_info":
            return f"would compute: {self._note(record).words}"
        if not self._is_dry:
            if event == "job_info":
                job = self._jobs[told["jobid"]]
                return f"     begins: {job.words}, up to {duration(job.seconds)}"
            if event == "job_error":
                line = f"     failed: {self._failed[told['jobid']].words}"
                if getattr(self._usual, "show_failed_logs", False):
                    line += f"\n{self._usual.format(record)}"
                return line
            if event == "progress":
                words = self._ended.words if self._ended else ""
                return f"{told['done']:>4} of {told['total']} done: {words}{self._left()}"
        return _FRAMES.sub("", self._usual.format(record))

    def _note(self, record: logging.LogRecord) -> _Job:
        """A job that begins or fails, in words."""
        told: dict[str, Any] = vars(record)
        resources = told.get("resources") or {}
        known = self._jobs.get(told["jobid"])
        job = _Job(
            known.words if known else words_of(told["rule_name"], told.get("wildcards") or {}),
            known.seconds if known else self._time_of(_runtime(resources)),
            tuple(map(str, told.get("log") or ())),
        )
        self._jobs[told["jobid"]] = job
        return job

    def _time_of(self, runtime: float) -> float:
        return _SHORT + self._seconds(runtime)

    def _left(self) -> str:
        """How long the jobs that are left take; nothing of few or short ones.

        As long over their estimated time as those before, which count the more the more there are.
        """
        if self._done < _ENOUGH * self._planned:
            return ""
        taken, planned = time.monotonic() - self._begin, self._planned / (self._cores or math.inf)
        share, trust = self._done / self._planned, _TRUST if planned else 0.0
        left = (taken + trust * planned) / (share + trust) * (1 - share)
        return f", {duration(left)} left" if left > _LONG else ""


def words_of(rule: str, wildcards: Mapping[str, object]) -> str:
    """A job in words: what it makes, and of what.

    Parameters
    ----------
    rule
        Name of its rule, in which a case or an assembly may follow.
    wildcards
        Values by name.

    >>> words_of("solve_responses_mine_enriched-40", {})
    'responses of mine enriched-40'
    >>> words_of("apply_preload", {"assembly": "beam", "preload_N": "5000"})
    'preload (beam, 5000)'
    >>> words_of("write_page_of_case", {"case": "mine"})
    'page of case (mine)'
    >>> words_of("weigh_pairs_of_sweep", {"sweep": "loosened"})
    'joint of weighted pairs of sweep (loosened)'
    """
    name = max((name for name in _WORDS if rule.startswith(name)), key=len, default="")
    subject = rule.removeprefix(name).strip("_").replace("_", " ")
    words = _WORDS.get(name, "")
    if subject and name and not words.endswith(" of"):
        subject = f"of {subject}"
    values = ", ".join(map(str, wildcards.values()))
    return " ".join(filter(None, (words, subject, f"({values})" if values else "")))


def _runtime(resources: object) -> float:
    """The ``runtime`` among resources of Snakemake [min]; 0 where there is none."""
    items = resources.items() if hasattr(resources, "items") else ()
    runtime = dict(items).get("runtime", 0)
    return float(runtime) if isinstance(runtime, int | float) else 0.0


def _event(record: logging.LogRecord) -> str:
    """What a record of Snakemake is of; empty of a plain line."""
    return str(getattr(record, "event", "") or "")


def duration(seconds: float) -> str:
    """A time in words.

    >>> duration(20), duration(70), duration(600), duration(9000)
    ('less than a minute', 'about a minute', 'about 10 minutes', 'about 2 hours')
    """
    minutes = seconds / 60
    if minutes < 1:
        return "less than a minute"
    if minutes < 1.5:
        return "about a minute"
    return f"about {minutes:.0f} minutes" if minutes < 100 else f"about {minutes / 60:.0f} hours"


def _critical_line(path: str) -> str:
    """What a log says of the failure of its job (``provenance.logs``); empty of none."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            told = [line.partition(" CRITICAL ")[2].strip() for line in file]
    except OSError:
        return ""
    # without the name of the logger
    return next((line.partition(": ")[2] for line in reversed(told) if line), "")
