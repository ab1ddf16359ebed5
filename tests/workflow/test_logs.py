"""What a stage of the workflow leaves in its log and on the terminal."""

import subprocess
import sys

import pytest

BEGIN = """import logging, sys
from boltjoint import dataset
from boltjoint.provenance import logs
logs.write_to(sys.argv[1])
"""


@pytest.fixture
def run(tmp_path):
    """Run a stage of these statements: the file of its log, its terminal, and how it ended."""

    def run(statements):
        script, log = tmp_path / "stage.py", tmp_path / "logs" / "stage.log"
        script.write_text(BEGIN + statements, encoding="utf-8")
        ran = subprocess.run(
            [sys.executable, script, log], capture_output=True, text=True, check=False
        )
        assert ran.stdout == ""
        return log.read_text(encoding="utf-8"), ran.stderr, ran.returncode

    return run


def test_a_failure_leaves_its_traceback_in_the_log_and_one_line_on_the_terminal(run):
    log, terminal, code = run(
        "def load(path):\n    open(path, 'w').write('x')\n    dataset.load(path)\n"
        "load(sys.argv[1] + '.nc')\n"
    )
    assert code == 1
    (line,) = terminal.splitlines()
    assert "stage.log.nc: cannot be read" in line
    assert line.endswith(": delete it and run again")
    assert "Traceback" in log and "in load" in log
    assert line.startswith("     error: stage: ")
    assert any(each.endswith(line.partition("stage: ")[2]) for each in log.splitlines())


def test_a_message_of_several_lines_is_one_on_the_terminal(run):
    log, terminal, _ = run("raise ValueError('two\\n  lines')\n")
    (line,) = terminal.splitlines()
    assert line.endswith("ValueError: two lines")
    assert "ValueError: two\n  lines" in log


def test_warnings_come_to_the_terminal_and_milestones_do_not(run):
    log, terminal, code = run(
        "one = logging.getLogger('boltjoint.one')\none.info('begun')\n"
        "one.warning('odd')\none.warning('odd')\n"
    )
    assert code == 0
    assert terminal.splitlines() == ["     warning: stage: odd"]
    assert [each.split()[2:] for each in log.splitlines()] == [
        ["INFO", "boltjoint.one:", "begun"],
        *2 * [["WARNING", "boltjoint.one:", "odd"]],
    ]


def test_an_interruption_is_no_failure(run):
    log, terminal, code = run("raise KeyboardInterrupt\n")
    assert code != 0
    assert log == ""
    assert terminal.rstrip().endswith("KeyboardInterrupt")
