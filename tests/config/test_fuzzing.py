"""Random changes of files of every kind: a run says what is wrong in lines, soon, and never fails.

``BOLTJOINT_FUZZ=3000`` tries as many changes of all kinds together, ``BOLTJOINT_FUZZ_SEED=word``
others than those of before.
"""

import collections
import os
import time
import warnings

import pytest
from fuzzing import KINDS, TEXTS, mutation, write_study

from boltjoint.config.assembly import Assembly
from boltjoint.config.distributions import Lognormal
from boltjoint.config.excitation import PointForces
from boltjoint.config.gap_map import GapMap
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.report.displays import DISPLAYS
from boltjoint.study import estimate
from boltjoint.study.artefact_list import Contents

NUMBER = int(os.environ.get("BOLTJOINT_FUZZ", "480"))
SEED = os.environ.get("BOLTJOINT_FUZZ_SEED", "1")
MEMORY = 16 * 2**30
#: processor time of a check [s]: a few hundredths, but for files of the largest size
LONGEST = 3.0
#: words of exceptions, and of pydantic's own sentences
NO_SENTENCES = ("cannot be checked", "cannot be estimated", "cannot be planned", "Input should")


@pytest.fixture
def study(tmp_path):
    write_study(tmp_path)
    return tmp_path


def problems_of(folder):
    """What a run says before any job, as its rules ask for it; none if it would begin."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = load_study(folder, {}, ["three_bolt_constant"])
            needed = estimate.estimate(found)
        except ConfigError as error:
            return list(error.problems)
        if shortage := estimate.shortage(needed, MEMORY):
            return [shortage]
        assert estimate.summary(needed, MEMORY, 2).isprintable()
        assert all(line.isprintable() for line in estimate.overstrained(found))
        estimate.Resources(found).of_any("designs")
        assert Contents(found, DISPLAYS).files()
    return []


def test_the_study_that_is_changed_is_right(study):
    assert problems_of(study) == []


@pytest.mark.parametrize("kind", KINDS)
def test_any_change_is_allowed_or_refused_in_lines(study, kind):
    outcomes = collections.Counter()
    for number in range(NUMBER // len(KINDS)):
        file, text = mutation(f"{SEED} {number}", kind)
        (study / file).write_bytes(text.encode("utf-8", "surrogatepass"))
        start = time.process_time()
        problems = problems_of(study)
        taken = time.process_time() - start
        which = f"change {number} of a {kind}, seed {SEED}: {file}"
        assert taken < LONGEST, which
        for line in problems:
            assert line.isprintable() and len(line) < 700, (which, line)
            assert not any(words in line for words in NO_SENTENCES), (which, line)
        (study / file).write_text(TEXTS[kind][file], encoding="utf-8")
        outcomes[bool(problems)] += 1
    assert min(outcomes[True], outcomes[False]) > 0, outcomes


def failing(*arguments, **options):
    raise ZeroDivisionError("float division by zero")


@pytest.mark.parametrize(
    ("where", "line"),
    [
        ((PointForces, "conflicts"), 'config/cases/small.yaml: excitation: {"kind": "forces", '),
        ((Assembly, "conflicts"), "config/assemblies/two_bolt.yaml: {"),
        ((Assembly, "conflicts_of_point"), "config/cases/small.yaml: "),
        ((GapMap, "conflicts"), "config/assemblies/mapped.yaml: "),
        ((Lognormal, "quantile"), "config/sweeps/samples.yaml: "),
    ],
)
def test_an_exception_while_checking_is_a_line_with_its_file(study, monkeypatch, where, line):
    monkeypatch.setattr(*where, failing)
    first, *_ = problems_of(study)
    assert first.startswith(line)
    assert first.endswith("cannot be checked: ends in ZeroDivisionError: float division by zero")


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("mesh_size", "config/assemblies/two_bolt.yaml: cannot be estimated"),
        ("_memory_of_balance", "config/cases/small.yaml: cannot be estimated"),
        ("_elements", "config/sweeps/grid.yaml: cannot be estimated"),
        ("Contents", "config/config.yaml: cannot be planned"),
    ],
)
def test_an_exception_while_estimating_is_a_line_with_its_file(study, monkeypatch, name, line):
    monkeypatch.setattr(estimate, name, failing)
    reason = "ends in ZeroDivisionError: float division by zero"
    assert problems_of(study) == [f"{line}: {reason}"]
