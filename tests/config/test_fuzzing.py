"""Random changes of files of every kind: a run says what is wrong in lines, soon, and never fails.

``BOLTJOINT_FUZZ=3000`` tries as many changes of all kinds together, ``BOLTJOINT_FUZZ_SEED=word``
others than those of before.
"""

import collections
import gc
import json
import os
import time
import warnings

import pytest
from fuzzing import BOLTS, FORCE, KINDS, TEXTS, content_of, mutation, write_study

from boltjoint.config.distributions import Lognormal
from boltjoint.config.excitation import PointForces
from boltjoint.config.gap_map import GapMap
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.strict_yaml import LARGEST_FILE
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.report.displays import DISPLAYS
from boltjoint.study import memory_and_time_of_jobs
from boltjoint.study import memory_and_time_of_study as needs
from boltjoint.study.artefact_list import Contents
from boltjoint.study.implausible_values import implausible

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
            needed = needs.estimate(found)
        except ConfigError as error:
            return list(error.problems)
        if shortage := needs.shortage(needed, MEMORY):
            return [shortage]
        assert needs.summary(needed, MEMORY, 2).isprintable()
        told = [*needs.overstrained(found), *implausible(found)]
        assert all(line.isprintable() for line in told)
        needs.Resources(found).of_any("designs")
        assert Contents(found, DISPLAYS).files()
    return []


def timed_problems_of(folder):
    """The problems of a study, and the processor time [s] of finding them.

    Left to itself, the collector would go through all objects of the tests before in that time.
    """
    gc.freeze()
    try:
        start = time.process_time()
        problems = problems_of(folder)
        return problems, time.process_time() - start
    finally:
        gc.unfreeze()


def test_the_study_that_is_changed_is_right(study):
    assert problems_of(study) == []


@pytest.mark.parametrize("kind", KINDS)
def test_any_change_is_allowed_or_refused_in_lines(study, kind):
    outcomes = collections.Counter()
    for number in range(NUMBER // len(KINDS)):
        file, text = mutation(f"{SEED} {number}", kind)
        (study / file).write_bytes(text.encode("utf-8", "surrogatepass"))
        problems, taken = timed_problems_of(study)
        which = f"change {number} of a {kind}, seed {SEED}: {file}"
        assert taken < LONGEST, which
        for line in problems:
            assert line.isprintable() and len(line) < 700, (which, line)
            assert not any(words in line for words in NO_SENTENCES), (which, line)
        (study / file).write_text(TEXTS[kind][file], encoding="utf-8")
        outcomes[bool(problems)] += 1
    assert min(outcomes[True], outcomes[False]) > 0, outcomes


def numbered(word, count):
    return [f"{word}{number}" for number in range(1, count + 1)]


def block(**keys):
    return {"resonance": 1, "joints": ["node-to-node"]} | keys


#: of almost the largest size, or that ask for as much as they can in few words
LARGE = {
    "cases": ("config/config.yaml", {"cases": numbered("c", 20_000)}),
    "keys": ("config/config.yaml", dict.fromkeys(numbered("k", 15_000), 1)),
    "levels": ("config/cases/small.yaml", {"forces_N": [*range(1, 15_000), 0.01]}),
    "levels to verify": (
        "config/cases/small.yaml",
        {"verification_forces_N": [0.5 + number for number in range(20_000)]},
    ),
    "sensors": (
        "config/cases/small.yaml",
        {"sensors": [{**FORCE, "name": name} for name in numbered("s", 2_500)]},
    ),
    "blocks": (
        "config/cases/small.yaml",
        {"solve": [block(joints=[name]) for name in numbered("clusters=", 138)] * 25},
    ),
    "responses": (
        "config/cases/small.yaml",
        {
            "solve": [
                block(
                    joints=numbered("clusters=", 138),
                    modes=numbered("free-", 300),
                    coordinates=["linear", *numbered("rdnm-", 300)],
                )
            ]
        },
    ),
    "many responses": (
        "config/cases/small.yaml",
        {
            "coordinates": ["linear"],
            "solve": [block(joints=numbered("clusters=", 138), modes=numbered("free-", 50))],
        },
    ),
    "bolts": (
        "config/assemblies/two_bolt.yaml",
        {"bolts": BOLTS | {"positions_from_lap_start_mm": list(range(1, 30_000))}},
    ),
    "varied keys": (
        "config/sweeps/grid.yaml",
        {"vary": {key: [1] for key in numbered("key", 9_000)}},
    ),
    "values": (
        "config/sweeps/grid.yaml",
        {"vary": {"loss_factor": [0.001 + 1e-7 * number for number in range(8_000)]}},
    ),
}


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """All that checks import, which takes a second once and tells nothing of a file."""
    folder = tmp_path_factory.mktemp("study")
    write_study(folder)
    assert problems_of(folder) == []


@pytest.mark.parametrize("what", LARGE)
def test_a_file_that_asks_for_much_is_checked_as_soon(study, imported, what):
    file, changes = LARGE[what]
    text = json.dumps(content_of(file) | changes)
    assert len(text) < LARGEST_FILE
    (study / file).write_text(text, encoding="utf-8")
    problems, taken = timed_problems_of(study)
    assert taken < LONGEST
    assert len(str(ConfigError(problems)).splitlines()) <= 51


def test_of_many_problems_all_are_counted_and_the_first_told(study):
    file, changes = LARGE["bolts"]
    (study / file).write_text(json.dumps(content_of(file) | changes), encoding="utf-8")
    problems = problems_of(study)
    untold = [problem for problem in problems if problem.endswith("has another problem")]
    assert len(problems) > 59_000
    assert 0 < len(problems) - len(untold) < 2000
    assert not set(problems[:1000]) & set(untold)


def test_of_many_problems_the_first_are_shown():
    error = ConfigError(numbered("problem ", 70))
    assert error.problems == tuple(numbered("problem ", 70))
    assert str(error).splitlines() == [*numbered("problem ", 50), "and 20 more problems"]
    assert str(ConfigError(["a\nb" + 3000 * "c"])) == f"a\\nb{1997 * 'c'}..."


def failing(*arguments, **options):
    raise ZeroDivisionError("float division by zero")


@pytest.mark.parametrize(
    ("where", "line"),
    [
        ((PointForces, "conflicts"), 'config/cases/small.yaml: excitation: {"kind": "forces", '),
        ((LapJoint, "conflicts"), "config/assemblies/two_bolt.yaml: {"),
        ((LapJoint, "conflicts_of_point"), "config/cases/small.yaml: "),
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
        ("of_assembly", "config/assemblies/two_bolt.yaml: cannot be estimated"),
        ("_memory_of_balance", "config/cases/small.yaml: cannot be estimated"),
        ("_of_calibration", "config/cases/measured.yaml: cannot be estimated"),
        ("_of_sweep", "config/sweeps/grid.yaml: cannot be estimated"),
        ("Contents", "config/config.yaml: cannot be planned"),
    ],
)
def test_an_exception_while_estimating_is_a_line_with_its_file(study, monkeypatch, name, line):
    module = needs if name == "Contents" else memory_and_time_of_jobs
    monkeypatch.setattr(module, name, failing)
    reason = "ends in ZeroDivisionError: float division by zero"
    assert problems_of(study) == [f"{line}: {reason}"]
