"""Study: the cases, assemblies and numerical options that its YAML files describe."""

from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, InstanceOf, SerializeAsAny

from boltjoint import checks
from boltjoint.config.case import Case
from boltjoint.config.described import Described
from boltjoint.config.error_messages import choice
from boltjoint.config.files import FileHashes, StudyFiles
from boltjoint.config.makers import description_of
from boltjoint.config.numerical_options import NumericalOptions
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.study_content import StudyContent
from boltjoint.config.sweep import Sweep
from boltjoint.config.swept_designs import SweptDesigns
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
)
from boltjoint.config.varied_case import (
    Variant,
    solved_alone,
    with_all_ratios,
)
from boltjoint.config.varied_keys import Quantity, keys_that_vary


def _as_description(value: object) -> object:
    """A description, or that of the content of its file."""
    return description_of(value) if isinstance(value, Mapping) else value


_Description = Annotated[SerializeAsAny[InstanceOf[Described]], BeforeValidator(_as_description)]


class Study(NumericalOptions):
    """All that is computed: cases, assemblies and sweeps themselves, with the options."""

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
    measured_points: dict[str, tuple[int, int]] = Field({}, exclude=True)
    """Numbers of measured points that are fitted and predicted, of each case that has some, where
    files were checked."""

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

    content = StudyContent(files, layers, before=before)
    content.check_gaps()
    content.check_cases(published)
    content.check_preloads()
    swept = content.swept()
    content.check_convergence()
    files.refuse_problems()
    cases = content.cases.items()
    of_names = {
        "cases": {name: case for name, case in cases if name in content.runs},
        "base_cases": {name: case for name, case in cases if name not in content.runs},
        "assemblies": content.assemblies,
        "sweeps": content.sweeps,
        "swept": swept,
        "hashes": files.hashes,
        "measured_points": content.measured_points(),
    }
    return Study.model_validate({**dict(content.settings or ()), **of_names})
