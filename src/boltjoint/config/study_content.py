"""Content of a study: its files are read one by one, then checked together."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache, cached_property, partial
from typing import Any

from boltjoint import names
from boltjoint.config.case import Case
from boltjoint.config.conflicts import (
    conflicts_of_case,
    conflicts_of_convergence,
    conflicts_of_places,
    conflicts_of_preload,
    conflicts_of_surfaces,
    conflicts_when_solved,
    missing_preloads,
    other_preloads,
    tightened,
)
from boltjoint.config.conflicts_of_measured import conflicts_of_measured, count_points
from boltjoint.config.csv_table import TableError
from boltjoint.config.damping import modal_damping
from boltjoint.config.described import Described
from boltjoint.config.error_messages import with_value
from boltjoint.config.files import Layers, StudyFiles
from boltjoint.config.gap_map import GapMap, read_gap_map
from boltjoint.config.makers import is_maker, maker, maker_names, type_of
from boltjoint.config.numerical_options import Settings
from boltjoint.config.sampling import Table
from boltjoint.config.strict_yaml import as_text, as_word
from boltjoint.config.sweep import Sweep
from boltjoint.config.swept_designs import (
    SweptDesigns,
    conflicts_of_preload_with_gap,
    conflicts_of_sweep,
)
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
    CONFIG_FILE,
    SWEEP_FOLDER,
    KeyPath,
    Problems,
)
from boltjoint.config.varied_case import BaseOfVariants, SolvedCase
from boltjoint.config.varied_keys import keys_that_vary
from boltjoint.regular_file import UnsuitableFile


class StudyContent:
    """Settings, sweeps, cases and assemblies of a study, of which each may be impossible.

    Parameters
    ----------
    files
        The files, which note the problems.
    layers
        ``config.yaml`` with what replaces its keys.
    before
        Whether all was checked before: what takes long is then left out.

    Attributes
    ----------
    settings, sweeps, cases, assemblies
        By name; None where a file is impossible.
    runs
        Names of the cases that run.
    """

    def __init__(self, files: StudyFiles, layers: Layers, *, before: bool) -> None:
        self.files, self.layers, self.before = files, layers, before
        self.settings = files.check(Settings, layers, layers.content)
        self.sweeps: dict[str, Sweep | None] = {}
        self.cases: dict[str, Case | None] = {}
        self.assemblies: dict[str, Described | None] = {}
        #: by the name of a case, or the file of a sweep
        self._contents: dict[str, Any] = {}
        # files named beside a problem are read all the same, to report their problems with it
        self._read_assemblies(self._read_cases(self._read_sweeps()))

    def _read_sweeps(self) -> list[tuple[Any, KeyPath, str]]:
        """Read the sweeps; cases that are wanted, with the files and the keys that name them."""
        files, layers = self.files, self.layers
        wanted: list[tuple[Any, KeyPath, str]] = [
            (layers, path, name) for path, name in _names(layers.content, "cases")
        ]
        self.runs = {name for *_, name in wanted}
        for path, name in _names(layers.content, "sweeps"):
            file = f"{SWEEP_FOLDER}/{name}.yaml"
            content = files.find(SWEEP_FOLDER, name, layers, path)
            self.sweeps[name] = files.check(Sweep, file, content)
            self._contents[file] = content
            if content is not None and _is_name(content.get("case")):
                wanted.append((file, ("case",), content["case"]))
        return wanted

    def _read_cases(self, wanted: Iterable[tuple[Any, KeyPath, str]]) -> list:
        """Read the cases; assemblies that are named, with the files and the keys."""
        files, layers = self.files, self.layers
        named: list[tuple[Any, KeyPath, str]] = [
            (layers, path, name) for path, name in _names(layers.content, "assemblies")
        ]
        for place, path, name in wanted:
            if name in names.PAGES or name in self.cases:
                continue
            file, content = _case_file(name), files.find(CASE_FOLDER, name, place, path)
            self.cases[name] = files.check(Case, file, content)
            self._contents[name] = content
            if content is not None and _is_name(content.get("assembly")):
                named.append((file, ("assembly",), content["assembly"]))
        return named

    def _read_assemblies(self, named: Iterable[tuple[Any, KeyPath, str]]) -> None:
        for place, path, name in named:
            content = self.files.find(ASSEMBLY_FOLDER, name, place, path)
            if name not in self.assemblies:
                self.assemblies[name] = _described(name, content, self.files, before=self.before)
        for name, case in self.cases.items():
            assembly = None if case is None else self.assemblies.get(case.assembly)
            if case is not None and assembly is not None:
                with self.files.checking(_case_file(name)):
                    self.cases[name] = self._completed(name, case, assembly)
            elif case is not None and not case.tells_preload:
                self.cases[name] = None

    def _completed(self, name: str, case: Case, assembly: Described) -> Case | None:
        """The case with what its assembly gives, and ratios in place of preloads by name."""
        if case.tells_preload:
            return _damped(case, assembly)
        file, content = _case_file(name), self._contents[name]
        told, problems = tightened(content, case, assembly)
        self.files.note(file, (with_value(content, *problem) for problem in problems))
        read = None if problems else self.files.check(Case, file, told)
        return None if read is None else _damped(read, assembly)

    @cached_property
    def gap_maps(self) -> dict[str, GapMap]:
        """The maps of gaps by their files; those that cannot be read are noted."""
        maps = {}
        for name, assembly in self.assemblies.items():
            file = None if assembly is None else assembly.gap_file
            if file is None:
                continue
            try:
                maps[file] = read_gap_map(self.files.table(file), file)
                continue
            except TableError as error:
                sentence = str(error)
            except UnsuitableFile as error:
                sentence = _must_be_table(file, error.sentence)
            except OSError as error:
                sentence = _must_be_table(file, f"cannot be read ({error.strerror})")
            self.files.note(_assembly_file(name), [(("contact", "gap_um"), sentence)])
        return maps

    def check_gaps(self) -> None:
        """Note what is wrong with the gaps of assemblies."""
        for name, assembly in self.assemblies.items():
            if assembly is not None and not self.before:
                with self.files.checking(_assembly_file(name)):
                    problems = assembly.conflicts_of_gap(self.gap_maps)
                    content = assembly.model_dump()
                    sentences = (with_value(content, *problem) for problem in problems)
                    self.files.note(_assembly_file(name), sentences)

    def check_cases(self, published: Collection[str] | None) -> None:
        """Note what assemblies, settings and the case studies of a source do not allow."""
        for name, case in self.cases.items():
            if case is None:
                continue
            with self.files.checking(_case_file(name)):
                assembly, files = self.assemblies[case.assembly], self.files
                problems = [
                    *conflicts_of_case(case, assembly, self.settings, published),
                    *conflicts_of_measured(
                        case, assembly, self.settings, None if self.before else files
                    ),
                ]
                if name not in self.runs:
                    # only that is solved which its sweeps ask for
                    problems = [
                        *conflicts_of_preload(case, assembly),
                        *conflicts_of_surfaces(case, assembly),
                        *conflicts_of_places(case, assembly),
                    ]
                content = self._contents[name]
                sentences = (with_value(content, *problem) for problem in dict.fromkeys(problems))
                files.note(_case_file(name), sentences)

    def check_preloads(self) -> None:
        """Note cases that are tightened otherwise than the bases of their assemblies assume."""
        files = self.files
        with files.checking(CONFIG_FILE):
            cases = {name: case for name, case in self.cases.items() if case is not None}
            assemblies = {name: one for name, one in self.assemblies.items() if one is not None}
            if len(cases) == len(self.cases):
                if not files.problems and self.settings is not None:
                    compared = self.settings.convergence.bases
                    others = other_preloads(cases, assemblies, compared)
                    for name, key, sentence in others:
                        problem = with_value(self._contents[name], (key,), sentence)
                        files.note(_case_file(name), [problem])
                for name, sentence in missing_preloads(cases.values(), assemblies):
                    files.note(_assembly_file(name), [(("preload_N",), sentence)])

    def swept(self) -> dict[str, SweptDesigns]:
        """Designs of the sweeps; what is wrong with them is noted."""
        swept: dict[str, SweptDesigns] = {}
        for name, sweep in self.sweeps.items():
            if sweep is None or (case := self.cases.get(sweep.case)) is None:
                continue
            file, assembly = f"{SWEEP_FOLDER}/{name}.yaml", self.assemblies[case.assembly]
            with self.files.checking(file):
                if assembly is None or self.settings is None:
                    continue
                allowed = keys_that_vary(case, assembly, sweep.joint)
                base = BaseOfVariants(sweep, case, assembly, self._conflicts_of_variant)
                design = sweep.design
                read = None
                if isinstance(design, Table):
                    read = cache(partial(self.files.table, design.file))
                swept[name] = designs = SweptDesigns(base, allowed, read)
                if self.before:
                    continue
                problems = list(conflicts_of_sweep(sweep, case, assembly, self.settings, allowed))
                if read is not None:
                    problems += self._check_table(designs, sweep)
                if not self.files.problems:
                    keys = designs.keys
                    problems += conflicts_of_preload_with_gap(sweep, case, assembly, keys)
                if not problems and not self.files.problems:
                    problems += designs.conflicts()
                content = self._contents[file]
                self.files.note(file, (with_value(content, *problem) for problem in problems))
        return swept

    def _conflicts_of_variant(self, solved: SolvedCase, assembly: Described) -> Problems:
        """What an assembly, the settings and the maps of gaps do not allow in a variant."""
        if self.settings is not None:
            yield from conflicts_when_solved(solved, assembly, self.settings)
        if assembly.gap_file is not None:
            for path, sentence in assembly.conflicts_of_gap(self.gap_maps):
                yield ("assembly", *path), sentence

    def _check_table(self, designs: SweptDesigns, sweep: Sweep) -> list[tuple[KeyPath, str]]:
        """What of the sweep speaks against so many designs; what is wrong in their table is noted.

        Its rows are counted before they are read.
        """
        file = designs.file
        try:
            if too_many := list(sweep.conflicts_of_number(designs.number)):
                return too_many
            _ = designs.columns
        except OSError as error:
            self.files.problems.append(f"{as_word(file)}: cannot be read: {error.strerror}")
        except UnsuitableFile as error:
            self.files.problems.append(f"{as_word(file)}: {error.sentence}")
        except TableError as error:
            self.files.problems.append(str(error))
        return []

    def check_convergence(self) -> None:
        """Note bases and numbers of regions that an assembly does not have."""
        files, layers = self.files, self.layers
        with files.checking(CONFIG_FILE):
            if self.settings is not None:
                cases = self.cases.values()
                problems = conflicts_of_convergence(self.settings, cases, self.assemblies)
                files.note(layers, (with_value(layers.content, *problem) for problem in problems))

    def measured_points(self) -> dict[str, tuple[int, int]]:
        """Numbers of measured points of each case that runs and has some, if not known before."""
        return {
            name: count_points(case.measured, self.files)
            for name, case in self.cases.items()
            if name in self.runs
            and case is not None
            and case.measured is not None
            and not self.before
        }


def _damped(case: Case, assembly: Described) -> Case:
    """The case with the damping ratios of its assembly, where it has no damping of its own."""
    ratios = assembly.damping_ratios
    if not ratios or case.damping is not None or case.loss_factor is not None:
        return case
    return case.model_copy(update={"damping": modal_damping(ratios)})


def _case_file(name: str) -> str:
    return f"{CASE_FOLDER}/{name}.yaml"


def _assembly_file(name: str) -> str:
    return f"{ASSEMBLY_FOLDER}/{name}.yaml"


def _must_be_table(file: str, problem: str) -> str:
    return f"{as_text(file)} {problem}: must be a CSV file, seen from the folder of config/"


def _described(
    name: str, content: Mapping[str, Any] | None, files: StudyFiles, *, before: bool
) -> Described | None:
    """The description of an assembly; None, with the problems noted, if it is none."""
    if content is None:
        return None
    kind = type_of(content)
    if not is_maker(kind):
        problem = with_value(content, ("type",), f"must be {' or '.join(maker_names())}")
        files.note(_assembly_file(name), [problem])
        return None
    with files.checking(_assembly_file(name)):
        described = files.check(maker(str(kind)).Description, _assembly_file(name), content)
        if described is None:
            return None
        described = described.in_folder(files.folder)
        if problems := [] if before else list(described.conflicts_of_files()):
            files.note(_assembly_file(name), problems)
            return None
        return described
    return None


def _names(content: Mapping[str, Any], key: str) -> Iterator[tuple[KeyPath, str]]:
    """The well-formed names in the list under a key, each with its key path."""
    listed = content.get(key)
    if isinstance(listed, list | tuple):
        yield from (((key, index), name) for index, name in enumerate(listed) if _is_name(name))


def _is_name(value: object) -> bool:
    if not isinstance(value, str) or re.fullmatch(names.NAME, value) is None:
        return False
    return not names.repeats_pattern(value)
