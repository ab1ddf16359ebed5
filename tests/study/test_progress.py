"""What a run tells in the terminal, of records as Snakemake logs them."""

import io
import logging

import pytest
from snakemake_interface_logger_plugins.common import LogEvent

from boltjoint.study import memory_and_time_of_study as needs
from boltjoint.study.progress import Progress


@pytest.fixture
def terminal():
    """A logger with the handler that Snakemake writes to the terminal by, and what it wrote."""
    logger, stream = logging.Logger("snakemake"), io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.name = "DefaultStreamHandler"
    logger.addHandler(handler)
    return logger, stream


def attach(logger, is_dry=False):
    progress = Progress(lambda: "Open overview.html", needs.seconds_of_runtime, is_dry)
    progress.attach(logger)
    return progress


def begin(logger, number, rule, runtime=10, **wildcards):
    extra = {"event": LogEvent.JOB_INFO, "jobid": number, "rule_name": rule}
    extra |= {"wildcards": wildcards, "resources": {"runtime": runtime}, "log": []}
    logger.info(None, extra=extra)


def end(logger, number, done, total):
    extra = {"event": LogEvent.JOB_FINISHED, "job_id": number}
    logger.info(f"Finished jobid: {number} (Rule: some)", extra=extra)
    logger.info(None, extra={"event": LogEvent.PROGRESS, "done": done, "total": total})


def test_each_job_that_has_ended_is_a_line_in_words(terminal):
    logger, stream = terminal
    progress = attach(logger)
    progress.start([10, 10], 2)
    logger.info("Building DAG of jobs...")
    logger.info("Estimate: 2 frequency responses")
    logger.info("Job stats:\njob count", extra={"event": LogEvent.RUN_INFO, "stats": {}})
    logger.info("Execute 1 jobs...", extra={"event": LogEvent.JOB_STARTED, "jobs": [1]})
    begin(logger, 1, "apply_preload", assembly="beam", preload_N="5000")
    end(logger, 1, 1, 2)
    logger.warning("a preload strains the shanks")
    begin(logger, 2, "draw_responses_mine_enriched-24")
    end(logger, 2, 2, 2)
    logger.info("Elapsed time: 0:00:12")
    assert stream.getvalue().splitlines() == [
        "Estimate: 2 frequency responses",
        "   1 of 2 done: preload (beam, 5000)",
        "a preload strains the shanks",
        "   2 of 2 done: figures of responses mine enriched-24",
    ]


@pytest.mark.parametrize(
    ("cores", "left"),
    [
        # half of the work took 5 minutes: on a cluster the rest does; on one core it was to take 10
        (None, 5),
        (1, 7),
    ],
)
def test_long_jobs_are_told_when_they_begin_and_the_time_that_is_left(
    terminal, monkeypatch, cores, left
):
    logger, stream = terminal
    progress = attach(logger)
    now = 0.0
    monkeypatch.setattr("time.monotonic", lambda: now)
    # of ten, ten and no minutes: a runtime has ten minutes beside three times as much
    progress.start([40, 40, 10], cores)
    begin(logger, 1, "solve_responses_mine_free-4", runtime=40)
    begin(logger, 2, "build_assembly", assembly="beam")
    end(logger, 2, 1, 3)
    assert stream.getvalue().splitlines() == [
        "     begins: responses of mine free-4, up to about 10 minutes",
        "   1 of 3 done: mesh (beam)",
    ]
    now = 300.0
    end(logger, 1, 2, 3)
    told = f"   2 of 3 done: responses of mine free-4, about {left} minutes left"
    assert stream.getvalue().splitlines()[-1] == told


def test_a_failed_job_has_its_reason_and_its_log_last(terminal, tmp_path):
    logger, stream = terminal
    progress = attach(logger)
    log = tmp_path / "modes.log"
    log.write_text(
        "2026-11-28 INFO boltjoint.modes: begins\n"
        "2026-11-28 CRITICAL boltjoint.logs: DamagedFile: a.nc is damaged\nTraceback:\n  File a\n"
    )
    begin(logger, 3, "find_modes", assembly="beam")
    extra = {"event": LogEvent.JOB_ERROR, "jobid": 3, "rule_name": "find_modes", "log": [log]}
    for _ in range(2):  # Snakemake tells it again at the end
        logger.error("Error in rule find_modes", extra=extra)
    assert stream.getvalue().splitlines() == ["     failed: modes (beam)"]
    reason = "failed: modes (beam): DamagedFile: a.nc is damaged"
    assert progress.failures().splitlines() == [reason, f"  log: {log}"]
    # one that is tried again and ends has not failed
    end(logger, 3, 1, 1)
    assert progress.failures() == ""


KILLED = """RuleException:
CalledProcessError in file "a.smk", line 47:
Command 'set -euo pipefail;  python a.py' died with <Signals.SIGKILL: 9>."""


def test_a_job_that_says_nothing_has_the_end_of_its_command_as_reason(terminal, tmp_path):
    logger, stream = terminal
    progress = attach(logger)
    log = tmp_path / "modes.log"
    log.write_text("2026-11-28 INFO boltjoint.modes: solved 3 of 8\n")
    logger.error(KILLED, extra={"event": LogEvent.ERROR})
    extra = {"event": LogEvent.JOB_ERROR, "jobid": 3, "rule_name": "find_modes", "log": [log]}
    logger.error("Error in rule find_modes", extra=extra)
    assert stream.getvalue().splitlines() == ["     failed: modes"]
    assert "died with <Signals.SIGKILL: 9>." in progress.failures().splitlines()[0]


def test_what_fails_before_its_command_is_told(terminal):
    logger, stream = terminal
    attach(logger)
    told = 'RuleException:\nOSError in file "a.smk", line 47:\n[Errno 28] No space left on device'
    logger.error(told, extra={"event": LogEvent.ERROR})
    assert "No space left on device" in stream.getvalue()


@pytest.mark.parametrize("is_dry", [False, True])
def test_a_configuration_that_is_refused_has_no_frame_of_the_snakefile(terminal, is_dry):
    logger, stream = terminal
    attach(logger, is_dry)
    logger.error(
        'WorkflowError in file "/a/study.smk", line 78:\nThe configuration cannot be used:\n'
        'mine.yaml: k: is not a known key\n  File "/a/Snakefile", line 7, in <module>\n'
        '  File "/a/study.smk", line 78, in <module>'
    )
    assert stream.getvalue().splitlines() == [
        "The configuration cannot be used:",
        "mine.yaml: k: is not a known key",
    ]


def test_a_study_that_is_up_to_date_gives_its_answer(terminal, capsys):
    logger, _ = terminal
    attach(logger)
    logger.info("Nothing to be done (all requested files are present and up to date).")
    said = capsys.readouterr()
    assert said.err.startswith("Nothing to be done")
    assert said.out == "Open overview.html\n"


def test_a_dry_run_lists_its_jobs_as_snakemake_does(terminal):
    logger, stream = terminal
    attach(logger, is_dry=True)
    logger.info("Job stats:\njob count", extra={"event": LogEvent.RUN_INFO, "stats": {}})
    assert stream.getvalue() == "Job stats:\njob count\n"


def test_a_dry_run_of_the_command_lists_its_jobs_in_words(terminal):
    logger, stream = terminal
    progress = Progress(lambda: "", needs.seconds_of_runtime, is_dry=True, has_words=True)
    progress.attach(logger)
    logger.info("Building DAG of jobs...")
    logger.info("Job stats:\njob count", extra={"event": LogEvent.RUN_INFO, "stats": {}})
    begin(logger, 1, "apply_preload", assembly="beam", preload_N="5000")
    begin(logger, 2, "all")
    logger.info("Reasons:\n    (check individual jobs above for details)")
    logger.info("This was a dry-run (flag -n). The order of jobs is another.")
    logger.warning("a preload strains the shanks")
    assert stream.getvalue().splitlines() == [
        "would compute: preload (beam, 5000)",
        "a preload strains the shanks",
    ]
