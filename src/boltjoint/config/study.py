"""Study: the cases, assemblies and numerical options that its YAML files describe."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache, cached_property, partial
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, InstanceOf, SerializeAsAny

from boltjoint import checks, names
from boltjoint.config.case import Case
from boltjoint.config.conflicts import (
    conflicts_of_case,
    conflicts_of_convergence,
    conflicts_of_places,
    conflicts_of_preload,
    conflicts_of_preload_with_gap,
    conflicts_of_surfaces,
    conflicts_of_sweep,
    conflicts_when_solved,
    missing_preloads,
    other_preloads,
)
from boltjoint.config.conflicts_of_measured import conflicts_of_measured, count_points
from boltjoint.config.described import Described
from boltjoint.config.entries import choice, with_value
from boltjoint.config.files import FileHashes, StudyFiles
from boltjoint.config.gap_map import GapMap
from boltjoint.config.makers import description_of, is_maker, maker, maker_names, type_of
from boltjoint.config.named_tables import check_table, read_gap_maps
from boltjoint.config.settings import Settings
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.sweep import Sweep, Table
from boltjoint.config.swept_designs import SweptDesigns
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
    CONFIG_FILE,
    SWEEP_FOLDER,
    KeyPath,
    Problems,
)
from boltjoint.config.varied_case import (
    BaseOfVariants,
    SolvedCase,
    Variant,
    solved_alone,
    with_all_ratios,
)
from boltjoint.config.varied_keys import Quantity, keys_that_vary


def _as_description(value: object) -> object:
    """A description, or that of the content of its file."""
    return description_of(value) if isinstance(value, Mapping) else value


_Description = Annotated[SerializeAsAny[InstanceOf[Described]], BeforeValidator(_as_description)]


class Study(Settings):
    """All that is computed: the settings, with cases and assemblies in place of their names."""

    cases: dict[str, Case]
    """The cases that run, by name, in the order of config.yaml."""
    base_cases: dict[str, Case]
    """The cases of sweeps that do not run themselves, by name."""
    assemblies: dict[str, _Description]
    """The assemblies that config.yaml names and those that its cases use, by name."""
    sweeps: dict[str, Sweep]
    """The sweeps that run, by name, in the order of config.yaml."""
    swept: dict[str, InstanceOf[SweptDesigns]] = Field({}, exclude=True)
    """Designs of each sweep: they follow from the rest and from the tables of designs."""
    hashes: InstanceOf[FileHashes] | dict[str, str] = Field({}, exclude=True)
    """Hash of the content of each file that sweeps, assemblies and cases name."""
    measured_points: dict[str, int] = Field({}, exclude=True)
    """Number of measured points of each case that has some, where files were checked."""

    @property
    def designs(self) -> dict[str, int]:
        """Number of designs of each sweep."""
        return {name: designs.number for name, designs in self.swept.items()}

    @property
    def variants(self) -> dict[str, tuple[Variant, ...]]:
        """Variants of the base case of each sweep, possible ones or not."""
        return {name: designs.variants for name, designs in self.swept.items()}

    @cached_property
    def _variants_of_file(self) -> dict[tuple[str, str], list[Variant]]:
        """The variants of sweeps by a folder and the name of a file in it."""
        variants_of_file: dict[tuple[str, str], list[Variant]] = {}
        for variant in chain.from_iterable(self.variants.values()):
            names = (CASE_FOLDER, variant.case_name), (ASSEMBLY_FOLDER, variant.assembly_name)
            for file in names:
                variants_of_file.setdefault(file, []).append(variant)
        return variants_of_file

    def variants_of(self, folder: str, name: str) -> Iterator[Variant]:
        """The possible variants of sweeps whose case or assembly has this name.

        Parameters
        ----------
        folder
            ``CASE_FOLDER`` or ``ASSEMBLY_FOLDER``.
        name
            Name of the case or the assembly.
        """
        variants = self._variants_of_file.get((folder, name), ())
        return (variant for variant in variants if not variant.reason)

    def case(self, name: str) -> Case:
        """The case of this name; a ``KeyError`` names the cases there are."""
        cases = self.cases | self.base_cases
        if name in cases:
            return cases[name]
        for variant in self.variants_of(CASE_FOLDER, name):
            return variant.case
        raise KeyError(f"{as_text(name)} is not a case of this study{choice(name, cases)}")

    def assembly(self, name: str) -> Described:
        """The assembly of this name, be it a file of the study or a variant in a sweep."""
        if name in self.assemblies:
            return self.assemblies[name]
        return next(self.variants_of(ASSEMBLY_FOLDER, name)).assembly

    def possible_variants(self, *sweeps: str) -> list[Variant]:
        """The variants of some sweeps, or of all, that can be solved."""
        names = sweeps or self.swept
        return [variant for name in names for variant in self.swept[name].possible_variants]

    def base_of_sweep(self, name: str, *, checking: bool = False) -> dict[str, Any]:
        """The base case as a sweep solves it, or as its check does."""
        first = self.swept[name].variants[0]
        sweep = self.sweeps[name].checking if checking else self.sweeps[name]
        case = self.case(sweep.case)
        bolts = self.assembly(case.assembly).bolt_count
        return with_all_ratios(solved_alone(case, sweep), first.values, bolts)

    def quantities(self, name: str) -> dict[str, Quantity]:
        """What the keys that a sweep varies are called; of a table, all that may vary."""
        sweep, case = self.sweeps[name], self.case(self.sweeps[name].case)
        quantities = keys_that_vary(case, self.assembly(case.assembly), sweep.joint)
        return {key: quantities[key] for key in sweep.vary or quantities}

    def contact_conditions(self, assembly: str) -> list[dict[str, Any]]:
        """Contact and damping that the bases of an assembly are made for, each once.

        Those of the cases that use it, or of all cases where none does.
        """
        every = [*self.cases.values(), *self.base_cases.values()]
        varied = (variant.case for variant in self.variants_of(ASSEMBLY_FOLDER, assembly))
        own = [*(case for case in every if case.assembly == assembly), *varied]
        conditions: list[dict[str, Any]] = []
        for case in own or every:
            condition = {"contact": case.contact.model_dump(), "damping": case.structural_damping}
            if condition not in conditions:
                conditions.append(condition)
        return conditions

    def stuck_stiffness(self, assembly: str) -> dict[str, float]:
        """Stiffness of pairs that stick where bases are compared: the largest of its cases.

        As for ``contact_conditions``; ``stiffness`` of a pair [N/m] and ``stiffness_per_area``
        [N/m3] as for ``patterns.resonances``.
        """
        stiffness: dict[str, float] = {}
        for condition in self.contact_conditions(assembly):
            for name, key in (("stiffness", "N_per_m"), ("stiffness_per_area", "N_per_m3")):
                for contact in (condition["contact"], *condition["contact"].get("surfaces", ())):
                    value = contact.get(f"tangential_stiffness_{key}")
                    if value is not None:
                        stiffness[name] = max(value, stiffness.get(name, value))
        return stiffness


def load_study(
    folder: str | Path,
    changes: Mapping[str, Any] | None = None,
    published: Collection[str] | None = None,
    *,
    before: bool = False,
) -> Study:
    """Read and check the configuration of a study.

    Parameters
    ----------
    folder
        The folder that holds ``config/``.
    changes
        Keys that replace those of ``config.yaml``, as the command line gives them: values may still
        be words. Under ``study`` it may name a file, from the folder on, whose keys replace those
        of ``config.yaml`` before. Of keys that hold keys, only those are replaced that are given.
    published
        Case studies of the source that a case may be compared with; any name will do without.
    before
        Whether it was checked before, as by the process that starts a job: tables, maps and
        variants of sweeps are then read and checked when they are asked for.

    Raises
    ------
    ConfigError
        With one line for each problem of each file that the study uses.
    ValueError
        If an argument is of another kind.
    """
    files = StudyFiles(checks.path("folder", folder))
    checks.instance("changes", {} if changes is None else changes, Mapping)
    checks.instance("published", () if published is None else published, Collection)
    checks.flag("before", before)
    layers = files.settings(changes or {})
    files.refuse_problems()

    # Files named beside a problem are read all the same, to report their problems with it.
    settings = files.check(Settings, layers, layers.content)
    sweeps, cases, contents = {}, {}, {}
    wanted = [(layers, path, name) for path, name in _names(layers.content, "cases")]
    runs = {name for *_, name in wanted}
    for path, name in _names(layers.content, "sweeps"):
        file, content = f"{SWEEP_FOLDER}/{name}.yaml", files.find(SWEEP_FOLDER, name, layers, path)
        sweeps[name], contents[file] = files.check(Sweep, file, content), content
        if content is not None and _is_name(content.get("case")):
            wanted.append((file, ("case",), content["case"]))
    named = [(layers, path, name) for path, name in _names(layers.content, "assemblies")]
    for place, path, name in wanted:
        if name in names.PAGES or name in cases:
            continue
        file, content = _case_file(name), files.find(CASE_FOLDER, name, place, path)
        cases[name], contents[name] = files.check(Case, file, content), content
        if content is not None and _is_name(content.get("assembly")):
            named.append((file, ("assembly",), content["assembly"]))
    assemblies: dict[str, Described | None] = {}
    for place, path, name in named:
        content = files.find(ASSEMBLY_FOLDER, name, place, path)
        if name not in assemblies:
            assemblies[name] = _described(name, content, files, before=before)

    gap_maps = cache(partial(read_gap_maps, assemblies, files))
    for name, assembly in assemblies.items():
        if assembly is not None and not before:
            with files.checking(_assembly_file(name)):
                problems = assembly.conflicts_of_gap(gap_maps())
                content = assembly.model_dump()
                sentences = (with_value(content, *problem) for problem in problems)
                files.note(_assembly_file(name), sentences)

    for name, case in cases.items():
        if case is not None:
            with files.checking(_case_file(name)):
                assembly = assemblies[case.assembly]
                problems = [
                    *conflicts_of_case(case, assembly, settings, published),
                    *conflicts_of_measured(case, assembly, settings, None if before else files),
                ]
                if name not in runs:
                    # only that is solved which its sweeps ask for
                    problems = [
                        *conflicts_of_preload(case, assembly),
                        *conflicts_of_surfaces(case, assembly),
                        *conflicts_of_places(case, assembly),
                    ]
                sentences = (
                    with_value(contents[name], *problem) for problem in dict.fromkeys(problems)
                )
                files.note(_case_file(name), sentences)
    with files.checking(CONFIG_FILE):
        if all(cases.values()):
            if not files.problems:
                compared = settings.convergence.bases
                for name, key, sentence in other_preloads(cases, assemblies, compared):
                    files.note(_case_file(name), [with_value(contents[name], (key,), sentence)])
            for name, sentence in missing_preloads(cases.values(), assemblies):
                files.note(_assembly_file(name), [(("preload_N",), sentence)])
    swept: dict[str, SweptDesigns] = {}
    for name, sweep in sweeps.items():
        if sweep is not None and (case := cases.get(sweep.case)) is not None:
            file, assembly = f"{SWEEP_FOLDER}/{name}.yaml", assemblies[case.assembly]
            with files.checking(file):
                if assembly is None or settings is None:
                    continue
                allowed = keys_that_vary(case, assembly, sweep.joint)
                conflicts = partial(_conflicts_of_variant, settings=settings, gap_maps=gap_maps)
                base = BaseOfVariants(sweep, case, assembly, conflicts)
                of_table = isinstance(sweep.design, Table)
                read = cache(partial(files.table, sweep.design.file)) if of_table else None
                swept[name] = designs = SweptDesigns(base, allowed, read)
                if before:
                    continue
                problems = list(conflicts_of_sweep(sweep, case, assembly, settings, allowed))
                if of_table:
                    check_table(designs, files)
                if not files.problems:
                    keys = designs.keys
                    problems += conflicts_of_preload_with_gap(sweep, case, assembly, keys)
                if not problems and not files.problems:
                    problems += designs.conflicts()
                files.note(file, (with_value(contents[file], *problem) for problem in problems))
    with files.checking(CONFIG_FILE):
        if settings is not None:
            problems = conflicts_of_convergence(settings, cases.values(), assemblies)
            files.note(layers, (with_value(layers.content, *problem) for problem in problems))

    files.refuse_problems()
    content = {
        "cases": {name: case for name, case in cases.items() if name in runs},
        "base_cases": {name: case for name, case in cases.items() if name not in runs},
        "assemblies": assemblies,
        "sweeps": sweeps,
        "swept": swept,
        "hashes": files.hashes,
        "measured_points": {
            name: count_points(case.measured, files)
            for name, case in cases.items()
            if name in runs and case.measured is not None and not before
        },
    }
    return Study.model_validate({**dict(settings), **content})


def _case_file(name: str) -> str:
    return f"{CASE_FOLDER}/{name}.yaml"


def _assembly_file(name: str) -> str:
    return f"{ASSEMBLY_FOLDER}/{name}.yaml"


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
    is_file_name = isinstance(value, str) and re.fullmatch(names.NAME, value) is not None
    return is_file_name and not names.repeats_pattern(value)


def _conflicts_of_variant(
    solved: SolvedCase,
    assembly: Described,
    settings: Settings,
    gap_maps: Callable[[], Mapping[str, GapMap]],
) -> Problems:
    """What an assembly, the settings and the maps of gaps do not allow in a variant of a sweep."""
    yield from conflicts_when_solved(solved, assembly, settings)
    if assembly.gap_file is not None:
        for path, sentence in assembly.conflicts_of_gap(gap_maps()):
            yield ("assembly", *path), sentence
