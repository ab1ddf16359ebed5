"""The command ``boltjoint``: a new study, its check, run and fits, its report and its data."""

import argparse
import os
import re
import subprocess
import sys
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from boltjoint import __version__, checks
from boltjoint.names import NAME
from boltjoint.study.layout import OVERVIEW
from boltjoint.study.progress import STUDY_AS_NAMED

if TYPE_CHECKING:
    from boltjoint.config.study import Study


def files_of_fit(folder: str | Path, case: str, study: str | None = None) -> list[str]:
    """The calibration of a case, the fitted case, and their figure and tables.

    Parameters
    ----------
    folder
        The folder that holds ``config/``.
    case
        Name of the case.
    study
        A file whose keys replace those of ``config.yaml``, seen from the folder.

    Raises
    ------
    ConfigError
        If the configuration cannot be used.
    ValueError
        If there is no such case, or it has no measurement.
    """
    from boltjoint.config.study import load_study
    from boltjoint.report.displays import DISPLAYS
    from boltjoint.report.displays.backbones import SECTION_OF_CALIBRATION
    from boltjoint.study.artefact_list import Contents

    loaded = load_study(checks.path("folder", folder), _changes(study))
    checks.choice("case", case, tuple(loaded.cases))
    if loaded.cases[case].measured is None:
        raise ValueError(f"config/cases/{case}.yaml has no key measured: there is nothing to fit")
    contents = Contents(loaded, DISPLAYS)
    shown = [
        path
        for display in DISPLAYS.on_page(contents, case)
        if DISPLAYS.of(display).section == SECTION_OF_CALIBRATION
        for path in display.paths
    ]
    return [*contents.files("calibration", "fitted_case", "prediction", case=case), *shown]


def _changes(study: str | None) -> dict[str, str]:
    """The keys by which another study is named; none for that of ``config.yaml``."""
    return {} if study is None else {"study": study}


#: of the workflow, in a checkout and in an installation
_WORKFLOW = "workflow/Snakefile"
_TEMPLATES = Path(__file__).parent / "templates"
#: files of a new study, by their templates
_FILES = {
    "config.yaml": "config/config.yaml",
    "assembly.yaml": "config/assemblies/{name}.yaml",
    "case.yaml": "config/cases/{name}.yaml",
    "sweep.yaml": "config/sweeps/{name}.yaml",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command with arguments, those of the process by default; the exit status."""
    parser = _parser()
    options, further = parser.parse_known_args(arguments)
    if further and options.command is not _run:
        parser.error(f"unrecognized arguments: {' '.join(further)}")
    options.further = further
    return options.command(options)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="boltjoint",
        description="Nonlinear vibration of bolted joints, from dimensions in YAML to a report.",
    )
    parser.add_argument("--version", action="version", version=f"boltjoint {__version__}")

    def print_help(_: argparse.Namespace) -> int:
        parser.print_help()
        return 0

    parser.set_defaults(command=print_help, folder=Path())
    commands = parser.add_subparsers(metavar="COMMAND")

    def add(name: str, command: Callable, words: str) -> argparse.ArgumentParser:
        command_parser = commands.add_parser(name, help=words, description=words)
        command_parser.set_defaults(command=command)
        command_parser.add_argument(
            "folder", nargs="?" if name != "new" else None, default=".", type=Path
        )
        return command_parser

    add("new", _new, "write a commented assembly, case and sweep into a folder")
    check = add("check", _check, "read the configuration of a study and say what a run would need")
    run = add("run", _run, "compute what is not up to date; further options are Snakemake's")
    run.add_argument("-j", "--cores", type=int, default=os.cpu_count() or 1)
    fit = add("fit", _fit, "fit the joint of a case to its measurement")
    fit.add_argument("case", help="name of a case with a key measured")
    fit.add_argument("-j", "--cores", type=int, default=os.cpu_count() or 1)
    words = "a file of the folder whose keys replace those of config/config.yaml"
    for command in (check, run, fit):
        command.add_argument("--study", metavar="FILE", help=words)
    add("open", _open, "open the report of a study in a browser")
    export = add("export", _export, "write responses, peaks and backbones for other programs")
    export.add_argument("--format", choices=("csv", "mat", "uff", "pvd"), default="csv")
    export.add_argument("--to", type=Path, default=None, help="by default FOLDER/results/export")
    return parser


def _new(options: argparse.Namespace) -> int:
    name = options.folder.resolve().name
    if not re.fullmatch(NAME, name):
        return _refuse(f"{name} is no name of a study: letters, digits, _ and - only")
    files = {
        options.folder / to.format(name=name): _TEMPLATES / source for source, to in _FILES.items()
    }
    if there := [str(file) for file in files if file.exists()]:
        return _refuse(f"{there[0]} is there already: nothing was written")
    for file, template in files.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        text = template.read_text(encoding="utf-8").replace("NAME", name)
        file.write_text(text, encoding="utf-8")
        print(f"wrote {file}")
    print(f"edit them, then: boltjoint run {options.folder}")
    return 0


def _check(options: argparse.Namespace) -> int:
    from boltjoint.config.study import load_study
    from boltjoint.config.types import ConfigError
    from boltjoint.study import implausible_values, memory_and_time_of_study

    if refused := _refuse_without_study(options.folder):
        return refused
    os.chdir(options.folder)
    try:
        study = load_study(Path.cwd(), _changes(options.study))
        needed = memory_and_time_of_study.estimate(study)
    except ConfigError as error:
        return _refuse(str(error))
    memory = memory_and_time_of_study.machine_memory()
    shortage = memory_and_time_of_study.shortage(needed, memory)
    try:
        models = [] if shortage else list(_models(study))
    except ValueError as error:
        return _refuse(str(error))
    for line in (
        *models,
        *implausible_values.implausible(study),
        *memory_and_time_of_study.overstrained(study),
    ):
        print(line)
    if shortage:
        return _refuse(shortage)
    print(memory_and_time_of_study.summary(needed, memory, os.cpu_count()))
    return 0


def _models(study: "Study") -> Iterator[str]:
    """What the files of assemblies are, where their maker looks at them."""
    from boltjoint.config.makers import maker

    used = {case.assembly for case in study.cases.values()} | set(study.assemblies)
    for name in sorted(used):
        described = study.assembly(name)
        if check := getattr(maker(described.type), "check", None):
            facts, doubts = check(described, Path.cwd())
            yield from (f"{name}: {words}: {fact}" for words, fact in facts.items())
            yield from (f"{name}: {line}" for line in doubts)


def _run(options: argparse.Namespace) -> int:
    if refused := _refuse_without_study(options.folder):
        return refused
    snakefile = workflow_file()
    profile = snakefile.parents[1] / "profiles/default"
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(snakefile)]
    command += ["--workflow-profile", str(profile)]
    command += ["--directory", str(options.folder), "--cores", str(options.cores)]
    command += _with_study(options.further, options.study)
    running = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env={**os.environ, STUDY_AS_NAMED: str(options.folder)},
    )
    try:
        for line in without_usage(running.stderr or ()):
            print(line, file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        # Snakemake has got it too, and ends its jobs
        pass
    return running.wait()


def _with_study(further: list[str], study: str | None) -> list[str]:
    """Options of Snakemake with another study, beside other keys that they have."""
    if study is None:
        return further
    place = further.index("--config") + 1 if "--config" in further else len(further)
    flag = [] if "--config" in further else ["--config"]
    return [*further[:place], *flag, f"study={study}", *further[place:]]


def _fit(given: argparse.Namespace) -> int:
    if refused := _refuse_without_study(given.folder):
        return refused
    try:
        given.further = files_of_fit(given.folder, given.case, given.study)
    except ValueError as error:
        return _refuse(str(error))
    return _run(given)


def _open(options: argparse.Namespace) -> int:
    page = (options.folder / OVERVIEW).resolve()
    if not page.exists():
        return _refuse(f"{page} is not there: boltjoint run {options.folder}")
    print(page)
    return 0 if webbrowser.open(page.as_uri()) else _refuse("no browser was found")


def _export(options: argparse.Namespace) -> int:
    from boltjoint.study.export import export_responses

    if refused := _refuse_without_study(options.folder):
        return refused
    to = options.folder / "results/export" if options.to is None else options.to
    try:
        written = export_responses(options.folder, to, options.format)
    except ValueError as error:
        return _refuse(str(error))
    for file in written:
        print(f"wrote {file}")
    if _is_edited_since_run(options.folder):
        line = "config was edited since the last run: these are results of before"
        print(f"boltjoint: {line}", file=sys.stderr)
    print("curves have the harmonics they were solved with, one as a rule; peaks have all too")
    return 0


def without_usage(lines: Iterable[str]) -> Iterator[str]:
    """Lines of Snakemake without all of its options, before the one that it does not know."""
    is_usage = False
    for line in map(str.rstrip, lines):
        is_usage = line.startswith("usage: ") or (is_usage and ": error: " not in line)
        if not (is_usage or line.startswith("Using workflow specific profile")):
            yield line


def workflow_file() -> Path:
    """The Snakefile of the workflow: of the checkout, or beside the installed package.

    Raises
    ------
    FileNotFoundError
        If there is none, as in an installation of the library alone.
    """
    checkout = Path(__file__).parents[3] / _WORKFLOW
    if checkout.exists():
        return checkout
    for installed in metadata.distributions(name="boltjoint"):
        for file in installed.files or ():
            if file.as_posix().endswith(f"share/boltjoint/{_WORKFLOW}"):
                return Path(file.locate()).resolve()
    raise FileNotFoundError("the workflow of boltjoint is not installed")


def _is_edited_since_run(folder: Path) -> bool:
    """Whether a file of the configuration is newer than all responses."""
    edited, solved = (
        max((file.stat().st_mtime for file in folder.glob(pattern)), default=0.0)
        for pattern in ("config/**/*.yaml", "results/cases/**/response.nc")
    )
    return edited > solved


def _refuse_without_study(folder: Path) -> int:
    """The exit status where a folder has no study, which is said; else 0."""
    if (folder / "config/config.yaml").exists():
        return 0
    return _refuse(f"{folder} has no config/config.yaml: boltjoint new FOLDER writes one")


def _refuse(line: str) -> int:
    print(f"boltjoint: {line}", file=sys.stderr)
    return 1
