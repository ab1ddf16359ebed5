"""Study: the cases, assemblies and numerical options that its YAML files describe."""

import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from boltjoint import names
from boltjoint.config.assembly import Assembly
from boltjoint.config.case import Case
from boltjoint.config.contact_adapted_basis import ContactAdaptedBasis
from boltjoint.config.entries import choice, with_value
from boltjoint.config.files import StudyFiles
from boltjoint.config.settings import Settings
from boltjoint.config.strict_yaml import as_text
from boltjoint.config.types import ASSEMBLY_FOLDER, CASE_FOLDER, CONFIG_FILE, KeyPath, Problems
from boltjoint.names import Basis


class Study(Settings):
    """All that is computed: the settings, with cases and assemblies in place of their names."""

    cases: dict[str, Case]
    """The cases that run, by name, in the order of config.yaml."""
    assemblies: dict[str, Assembly]
    """The assemblies that config.yaml names and those that its cases use, by name."""

    def case(self, name: str) -> Case:
        """The case of this name; a ``KeyError`` names the cases there are."""
        if name not in self.cases:
            raise KeyError(f"{as_text(name)} is not a case of this study{choice(name, self.cases)}")
        return self.cases[name]

    def contact_conditions(self, assembly: str) -> list[dict[str, Any]]:
        """Contact and damping that the bases of an assembly are made for, each once.

        Those of the cases that use it, or of all cases where none does.
        """
        own = [case for case in self.cases.values() if case.assembly == assembly]
        found: list[dict[str, Any]] = []
        for case in own or self.cases.values():
            condition = {"contact": case.contact.model_dump(), "damping": case.structural_damping}
            if condition not in found:
                found.append(condition)
        return found

    def stuck_stiffness(self, assembly: str) -> float:
        """Stiffness of pairs that stick [N/m] where bases are compared: the largest of its cases.

        As for ``contact_conditions``.
        """
        conditions = self.contact_conditions(assembly)
        return max(each["contact"]["tangential_stiffness_N_per_m"] for each in conditions)


def load_study(
    folder: str | Path,
    changes: Mapping[str, Any] | None = None,
    published: Collection[str] | None = None,
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

    Raises
    ------
    ConfigError
        With one line for each problem of each file that the study uses.
    """
    files = StudyFiles(Path(folder))
    layers = files.settings(changes or {})
    files.refuse_problems()

    # Files named beside a problem are read all the same, to report their problems with it.
    settings = files.check(Settings, layers, layers.content)
    cases, contents = {}, {}
    named = [(layers, path, name) for path, name in _names(layers.content, "assemblies")]
    for path, name in _names(layers.content, "cases"):
        if name in names.PAGES:
            continue
        file, content = _case_file(name), files.find(CASE_FOLDER, name, layers, path)
        cases[name], contents[name] = files.check(Case, file, content), content
        if content is not None and _is_name(content.get("assembly")):
            named.append((file, ("assembly",), content["assembly"]))
    assemblies: dict[str, Assembly | None] = {}
    for place, path, name in named:
        content = files.find(ASSEMBLY_FOLDER, name, place, path)
        if name not in assemblies:
            assemblies[name] = files.check(Assembly, _assembly_file(name), content)

    for name, case in cases.items():
        if case is not None:
            problems = _conflicts(case, assemblies[case.assembly], settings, published)
            found = (with_value(contents[name], *problem) for problem in dict.fromkeys(problems))
            files.note(_case_file(name), found)
    if all(cases.values()):
        for name, sentence in _missing_preloads(cases.values(), assemblies):
            files.note(_assembly_file(name), [(("preload_N",), sentence)])
    if settings is not None:
        problems = _conflicts_of_convergence(settings, cases.values(), assemblies)
        files.note(layers, (with_value(layers.content, *problem) for problem in problems))

    files.refuse_problems()
    return Study.model_validate({**dict(settings), "cases": cases, "assemblies": assemblies})


def _case_file(name: str) -> str:
    return f"{CASE_FOLDER}/{name}.yaml"


def _assembly_file(name: str) -> str:
    return f"{ASSEMBLY_FOLDER}/{name}.yaml"


def _names(content: Mapping[str, Any], key: str) -> Iterator[tuple[KeyPath, str]]:
    """The well-formed names in the list under a key, each with its key path."""
    listed = content.get(key)
    if isinstance(listed, list | tuple):
        yield from (((key, index), name) for index, name in enumerate(listed) if _is_name(name))


def _is_name(value: object) -> bool:
    return isinstance(value, str) and re.fullmatch(names.NAME, value) is not None


def _conflicts(
    case: Case,
    assembly: Assembly | None,
    settings: Settings | None,
    published: Collection[str] | None,
) -> Problems:
    """What the assembly, the settings and the source do not allow in a case."""
    if assembly is not None:
        yield from _conflicts_of_joints(case, assembly)
        for path, point in case.points.items():
            yield from ((path + inner, line) for inner, line in assembly.conflicts_of_point(point))
    if settings is not None:
        yield from _conflicts_of_options(case, settings)
        yield from _conflicts_of_bases(case, assembly, settings.contact_adapted_basis)
    if published is not None and case.published is not None and case.published not in published:
        yield (
            ("published",),
            f"is no case study of the source{choice(case.published, published)}",
        )


def _conflicts_of_joints(case: Case, assembly: Assembly) -> Problems:
    """Joints with more regions, elements in all or weighted pairs than there are contact pairs.

    Bands hold each pair with its mirror image, and so are at most as many as on one side.
    """
    pairs = assembly.contact_pairs, f"the contact pairs of {case.assembly}"
    of_one_side = assembly.pairs_of_one_side, _pairs_of_one_side(case.assembly)
    for block_index, block in enumerate(case.solve):
        for index, joint in enumerate(block.joints):
            regions = 1 if joint.count == "auto" else joint.count or 0
            of_regions = of_one_side if joint.division == "regions" else pairs
            for count, what, (most, of_what) in (
                (regions, joint.division, of_regions),
                (regions * (joint.elements or 0), "elements in all", pairs),
                (0 if joint.pairs == "auto" else joint.pairs or 0, "weighted pairs", pairs),
            ):
                if count > most:
                    path = ("solve", block_index, "joints", index)
                    yield path, f"must have at most {most} {what}, {of_what}"
                    break


def _conflicts_of_options(case: Case, settings: Settings) -> Problems:
    """Resonances and coordinates that the numerical options do not allow."""
    most, harmonics = settings.contact_adapted_basis.resonances, settings.solver.harmonics
    for index, block in enumerate(case.blocks):
        enriched = [basis for basis in block.modes if basis.is_contact_adapted]
        if enriched and block.resonance > most:
            sentence = f"must be at most {most}, contact_adapted_basis.resonances, in {enriched[0]}"
            yield ("solve", index, "resonance"), sentence
        for place, name in enumerate(block.coordinates):
            if harmonics > 1 and name.kind in ("complex", "backbone"):
                path = (*case.place_of("coordinates", index), place)
                yield path, f"must be linear or rdnm-N with solver.harmonics: {harmonics}"


def _conflicts_of_bases(
    case: Case, assembly: Assembly | None, options: ContactAdaptedBasis
) -> Problems:
    """Enriched bases of more vectors than are found."""
    for index, block in enumerate(case.blocks):
        for place, basis in enumerate(block.modes):
            if sentence := _too_large(basis, options, {case.assembly: assembly}):
                yield (*case.place_of("modes", index), place), sentence


def _missing_preloads(
    cases: Collection[Case], assemblies: Mapping[str, Assembly | None]
) -> Iterator[tuple[str, str]]:
    """Assemblies that are to have an enriched basis but no contact to make it from."""
    used = {case.assembly for case in cases}
    enriched = [basis for case in cases for basis in case.bases if basis.is_contact_adapted]
    for name, assembly in assemblies.items():
        if enriched and assembly and name not in used and assembly.preload_N is None:
            yield name, f"is missing: {enriched[0]} is made from the contact under preload"


def _conflicts_of_convergence(
    settings: Settings,
    cases: Collection[Case | None],
    assemblies: Mapping[str, Assembly | None],
) -> Problems:
    """Bases and numbers of regions that an assembly does not have."""
    for index, basis in enumerate(settings.convergence.bases):
        if sentence := _too_large(basis, settings.contact_adapted_basis, assemblies):
            yield ("convergence", "bases", index), sentence
    divided = {
        case.assembly
        for case in cases
        if case and any(basis.is_contact_adapted for basis in case.bases)
    }
    for index, count in enumerate(settings.convergence.regions):
        for name, assembly in assemblies.items():
            if name in divided and assembly and count > (most := assembly.pairs_of_one_side):
                sentence = f"must be at most {most}, {_pairs_of_one_side(name)}"
                yield ("convergence", "regions", index), sentence
                break


def _too_large(
    basis: Basis, options: ContactAdaptedBasis, assemblies: Mapping[str, Assembly | None]
) -> str | None:
    """What an enriched basis of more vectors than are found must be, for the first assembly."""
    if not basis.is_contact_adapted or basis.vectors == "auto":
        return None
    number, most = basis.vectors, options.maximum_vectors
    if number > most:
        return (
            f"must have at most {most} vectors, as contact_adapted_basis.maximum_vectors in "
            f"{CONFIG_FILE}"
        )
    for name, assembly in assemblies.items():
        # candidates: modes, and the shapes of a force along and across the contact on every pair
        if assembly and number > (
            candidates := options.free_modes + 2 * assembly.pairs_of_one_side
        ):
            return (
                f"must have at most {candidates} vectors: contact_adapted_basis.free_modes, "
                f"and two for each of {_pairs_of_one_side(name)}"
            )
    return None


def _pairs_of_one_side(assembly: str) -> str:
    return f"the contact pairs of {assembly} on one side of the centre line and on it"
