"""Commands that pages quote: subcommands, options, targets and files of each exist."""

import ast
import re
import shlex
import shutil
import subprocess
import tomllib

import pytest
from page_blocks import ROOT, blocks, commands, quoted_words
from snakemake.cli import get_argument_parser

from boltjoint.command.main import _parser
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.friction.declarations import GROUP
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Contents

MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = set(re.findall(r"^([\w./-]+):(?!=)", MAKEFILE, re.MULTILINE))
VARIABLES = set(re.findall(r"\$\((\w+)\)", MAKEFILE))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
RULES = {
    name
    for path in [ROOT / "workflow/Snakefile", *ROOT.glob("workflow/rules/*.smk")]
    for name in re.findall(r"^rule (\w+):", path.read_text(encoding="utf-8"), re.MULTILINE)
}
#: names that stand for what the reader has, of folders, cases and files
OWN = {"mine"}
#: programs of others, of which only the name is in question
OTHERS = {"module", "cd", ".", "git", "pre-commit", "sp-repo-review", "snakedeploy", "cp", "sed"}
#: languages of fenced blocks: each has tests, or holds no example
LANGUAGES = {"sh", "text", "yaml", "python", "toml"}


def check_boltjoint(words):
    if words in (["new"], ["fit"]):
        # its name alone
        words = [*words, "mine", "CASE"][: 2 if words == ["new"] else 3]
    options, further = _parser().parse_known_args(words)
    assert words == [] or words[0] in options.command.__name__
    if further:
        assert words[0] == "run"
        get_argument_parser().parse_args(further)


def check_make(words):
    for word in words:
        name, equals, value = word.partition("=")
        if not equals:
            assert word in TARGETS, f"no target {word}"
            continue
        assert name in VARIABLES, f"no variable {name}"
        if name == "STUDY":
            load_study(ROOT, {"study": value})
        elif name == "PROFILE":
            assert (ROOT / value / "config.yaml").exists()


def check_snakemake(words):
    options = get_argument_parser().parse_args(words)
    for profile in (*(options.profile or ()), options.workflow_profile):
        assert profile is None or (ROOT / profile / "config.yaml").exists()
    for rule in options.set_resources or ():
        assert rule in RULES, f"no rule {rule}"
    changes = dict(each.split("=", 1) for each in options.config or ())
    if any(name in str(value) for name in OWN for value in changes.values()):
        return
    if changes.keys() == {"key"}:
        # any key
        return
    files = Contents(load_study(ROOT, changes), DISPLAYS).files()
    for target in options.targets or ():
        assert target in RULES or target in files, f"no target {target}"


def check_python(words):
    if words[:2] == ["-m", "pytest"]:
        (expression,) = words[words.index("-m", 2) + 1 :][:1]
        names = {n.id for n in ast.walk(ast.parse(expression)) if isinstance(n, ast.Name)}
        marks = PROJECT["tool"]["pytest"]["ini_options"]["markers"]
        assert names <= {mark.split(":")[0] for mark in marks}
        return
    check_script(words)


def check_script(words):
    script, *arguments = words
    text = (ROOT / script).read_text(encoding="utf-8")
    for argument in arguments:
        if argument.startswith("--"):
            assert f'"{argument}"' in text, f"{script} has no option {argument}"
        elif script == "docs/write.py":
            assert (ROOT / f"docs/{argument}.md.j2").exists()


def check_pip(words):
    assert words[0] == "install"
    for word in words[1:]:
        extras = re.fullmatch(r"(?:\.|boltjoint)(?:\[(\w+)\])?", word)
        if extras and extras[1]:
            assert extras[1] in PROJECT["project"]["optional-dependencies"]
        else:
            assert extras or word in ("-e", "<this repository>")


def check_ci(words):
    text = (ROOT / words[0]).read_text(encoding="utf-8")
    patterns = re.findall(r"^ *([\w |-]+)\) ", text, re.MULTILINE)
    known = {word.strip() for pattern in patterns for word in pattern.split("|")}
    for word in words[1:]:
        # a tag is any
        assert word in known or re.fullmatch(r"v[\d.]+", word)


CHECKS = {
    "boltjoint": check_boltjoint,
    "make": check_make,
    "snakemake": check_snakemake,
    "python": check_python,
    "pip": check_pip,
}


def check(command):
    """Refuse a command whose program, options, targets or files there are not."""
    # words in angle brackets are placeholders
    words = shlex.split(re.sub(r"<([^>]*)>", r"'<\1>'", command))
    program = words[0].removeprefix(".venv/bin/")
    if program.startswith(".ci/"):
        check_ci(words)
    elif program.startswith("benchmarks/"):
        check_script([program, *words[1:]])
    elif program in CHECKS:
        CHECKS[program](words[1:])
    else:
        assert program in OTHERS, f"no check of {program}"


@pytest.mark.parametrize("block", blocks("sh"), ids=lambda block: block.place)
def test_commands_of_blocks_can_be_given(block, capsys):
    for command in commands(block.text):
        try:
            check(command)
        except (SystemExit, ConfigError) as error:
            pytest.fail(f"{command}: {capsys.readouterr().err or error}")


def is_command(text):
    program = text.split()[0].removeprefix(".venv/bin/")
    is_script = program.startswith(("benchmarks/", ".ci/")) and " " in text
    return is_script or (program in {*CHECKS, *OTHERS} and " " in text)


@pytest.mark.parametrize(
    "text", sorted({each.text for each in quoted_words() if is_command(each.text)})
)
def test_commands_of_sentences_can_be_given(text, capsys):
    try:
        check(text)
    except (SystemExit, ConfigError) as error:
        pytest.fail(f"{text}: {capsys.readouterr().err or error}")


@pytest.mark.parametrize(
    "command",
    [
        "boltjoint compute mine",
        "boltjoint export mine --format xls",
        "boltjoint check mine -n",
        "boltjoint run mine --no-such-option",
        "make everything",
        "make reproduce STUDY=config/none.yaml",
        "make reproduce SIZE=2",
        "snakemake -j2 results/none.nc",
        "snakemake --profile profiles/none",
        "snakemake --config study=config/sweeps.yaml -- results/sweeps/none/sweep.nc",
        "python benchmarks/none.py",
        "benchmarks/error_bars.py small --none 1",
        "python docs/write.py none",
        'python -m pytest -m "not none"',
        "pip install boltjoint[none]",
        ".ci/slurm none",
        "rm -rf results",
    ],
)
def test_what_cannot_be_given_is_found(command):
    with pytest.raises((AssertionError, SystemExit, ConfigError, OSError)):
        check(command)


def test_every_block_tells_its_language():
    told = {each.place: each.language for each in blocks()}
    assert not {
        place: language
        for place, language in told.items()
        if language not in LANGUAGES and not language.startswith("{")
    }


def test_entry_points_are_of_groups_that_are_read():
    (block,) = blocks("toml")
    assert set(tomllib.loads(block.text)["project"]["entry-points"]) == {GROUP}


def test_a_case_is_copied_and_changed_as_told(tmp_path):
    (block,) = (each for each in blocks("sh") if each.text.startswith("cp config/cases"))
    shutil.copytree(ROOT / "config", tmp_path / "config")
    subprocess.run(block.text, shell=True, check=True, cwd=tmp_path)
    study = load_study(tmp_path, {"cases": ["three_bolt_constant", "tighter"]})
    changed, before = (study.case(name) for name in ("tighter", "three_bolt_constant"))
    assert (changed.preload_N, before.preload_N) == (20_000, 10_000)
    assert changed.assembly == before.assembly


#: folders of the repository
FOLDERS = "config|docs|benchmarks|tests|resources|src|profiles|workflow|recipe|.ci|.github"
#: files that a page has its reader write
OF_READERS = {
    "config/assemblies/joint.yaml",
    "config/assemblies/mine.yaml",
    "config/assemblies/measured.csv",
    "config/cases/mine.yaml",
    "config/cases/tighter.yaml",
    "config/sweeps/mine.yaml",
    "config/designs.csv",
}


#: a path is seen from the root, or from the library
SEEN_FROM = (ROOT, ROOT / "src/boltjoint")


def test_files_that_pages_name_exist():
    path = re.compile(rf"(?:{re.escape(FOLDERS).replace(chr(92) + '|', '|')})/[\w./*=-]+")
    named = {
        each.text: each.place
        for each in quoted_words()
        if path.fullmatch(each.text) and each.text not in OF_READERS
    }
    assert len(named) > 40
    missing = {
        place: name
        for name, place in named.items()
        if not any(any(folder.glob(name.rstrip("/"))) for folder in SEEN_FROM)
    }
    assert not missing


def test_the_page_of_commands_has_all_of_them():
    page = (ROOT / "docs/commands.md").read_text(encoding="utf-8")
    (subcommands,) = (
        action.choices for action in _parser()._actions if isinstance(action.choices, dict)
    )
    assert set(re.findall(r"^\| `boltjoint (\w+)", page, re.MULTILINE)) == set(subcommands)
    (formats,) = (
        action.choices for action in subcommands["export"]._actions if action.dest == "format"
    )
    assert set(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)) == set(formats)
