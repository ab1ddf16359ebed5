"""A study as its YAML files describe it."""

import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from boltjoint import names
from boltjoint.config.assembly import Assembly
from boltjoint.config.case import Case
from boltjoint.config.entries import Entry, KeyPath, choice, explained
from boltjoint.config.options import (
    ContactAdaptedBasis,
    Convergence,
    Fitting,
    Settings,
    Solver,
    Timing,
)
from boltjoint.config.strict_yaml import TextError, read_mapping, shown, typed
from boltjoint.config.types import (
    ASSEMBLY_FOLDER,
    CASE_FOLDER,
    COMMAND_LINE,
    CONFIG_FILE,
    ConfigError,
)


class Study(Entry):
    """All that is to be computed: the cases, the assemblies they need, the numerical options."""

    cases: dict[str, Case]
    """The cases that run, by name, in the order of config.yaml."""
    assemblies: dict[str, Assembly]
    """The assemblies that config.yaml names and those that its cases use, by name."""
    contact_adapted_basis: ContactAdaptedBasis
    solver: Solver
    fitting: Fitting
    timing: Timing
    convergence: Convergence

    def case(self, name: str) -> Case:
        """The case of this name; a ``KeyError`` names the cases there are."""
        if name not in self.cases:
            raise KeyError(f"{shown(name)} is not a case of this study{choice(name, self.cases)}")
        return self.cases[name]


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
    reader = _Reader(Path(folder))
    settings = reader.settings(changes or {})
    if reader.problems:
        raise ConfigError(reader.problems)

    # Files named beside a problem are read all the same, to report their problems with it.
    checked = reader.check(Settings, settings, settings.content)
    cases = {}
    named = [(settings, path, name) for path, name in _names(settings.content, "assemblies")]
    for path, name in _names(settings.content, "cases"):
        if name in names.PAGES:
            continue
        file, content = reader.find(CASE_FOLDER, name, settings, path)
        cases[name] = reader.check(Case, file, content)
        if content is not None and _is_name(content.get("assembly")):
            named.append((file, ("assembly",), content["assembly"]))
    assemblies: dict[str, Assembly | None] = {}
    for place, path, name in named:
        file, content = reader.find(ASSEMBLY_FOLDER, name, place, path)
        if name not in assemblies:
            assemblies[name] = reader.check(Assembly, file, content)
    for name, case in cases.items():
        file = f"{CASE_FOLDER}/{name}.yaml"
        if case is not None and (assembly := assemblies[case.assembly]) is not None:
            reader.check_regions(file, case, assembly)
        if case is not None and checked is not None:
            reader.check_options(file, case, checked)
            reader.check_bases(file, case, checked.contact_adapted_basis, assemblies[case.assembly])
        if case is not None and published is not None:
            reader.check_published(file, case, published)

    if all(cases.values()):
        reader.check_preloads(cases.values(), assemblies)
    if checked is not None:
        reader.check_convergence(settings, checked, cases.values(), assemblies)

    if reader.problems or checked is None:
        raise ConfigError(reader.problems)
    return Study(
        cases=cases,
        assemblies=assemblies,
        contact_adapted_basis=checked.contact_adapted_basis,
        solver=checked.solver,
        fitting=checked.fitting,
        timing=checked.timing,
        convergence=checked.convergence,
    )


def _updated(content: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The content with what is given in the changes; both may hold keys in keys."""
    updated = dict(content)
    for key, value in changes.items():
        if isinstance(value, Mapping):
            below = updated.get(key)
            value = _updated(below if isinstance(below, Mapping) else {}, value)
        updated[key] = value
    return updated


class _Settings:
    """The content of config.yaml after what a study file and the command line change of it."""

    def __init__(self) -> None:
        self.content: dict[str, Any] = {}
        self._layers: list[tuple[str, Mapping[str, Any]]] = []

    def update(self, place: str, changes: Mapping[str, Any]) -> None:
        """Replace the keys that a file or the command line holds."""
        self.content = _updated(self.content, changes)
        self._layers.append((place, changes))

    def place(self, path: KeyPath) -> str:
        """What gave the value under a key path, or else what that would stand in."""
        for length in range(len(path), 0, -1):
            for place, changes in reversed(self._layers):
                if _gives(changes, path[:length]):
                    return place
        return CONFIG_FILE


def _gives(content: Any, path: KeyPath) -> bool:  # noqa: ANN401 - YAML
    """Whether the value under a key path, or a list or word in which it would be, is given."""
    for part in path:
        if not isinstance(content, Mapping):
            return True
        if part not in content:
            return False
        content = content[part]
    return True


EntryT = TypeVar("EntryT", bound=Entry)


class _Reader:
    """Reads the files of one study and keeps every problem it meets."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[str] = []
        self._contents: dict[str, Mapping[str, Any] | None] = {}

    def settings(self, changes: Mapping[str, Any]) -> _Settings:
        """The keys of config.yaml, then of the study file, then of the command line."""
        settings = _Settings()
        if (content := self.read(CONFIG_FILE)) is not None:
            settings.update(CONFIG_FILE, content)
        if "study" in changes:
            file = changes["study"]
            if not isinstance(file, str) or "\0" in file:
                self._note(COMMAND_LINE, ("study",), shown(file), "must be the name of a file")
            elif (content := self.read(file)) is not None:
                settings.update(_as_word(file), content)
        try:
            given = {key: value for key, value in changes.items() if key != "study"}
            settings.update(COMMAND_LINE, typed(given))
        except ValueError as error:
            self.problems.append(f"{COMMAND_LINE}: {error}")
        return settings

    def read(self, file: str) -> Mapping[str, Any] | None:
        """The mapping that a file holds; None, with a problem noted, if it holds none."""
        if file not in self._contents:
            self._contents[file] = None
            place = _as_word(file)
            try:
                self._contents[file] = read_mapping(self.folder / file)
            except FileNotFoundError:
                self.problems.append(f"{place}: there is no such file in {self.folder.resolve()}")
            except OSError as error:
                self.problems.append(f"{place}: cannot be read: {error.strerror}")
            except TextError as error:
                self.problems.append(f"{place}{error.place}: {error.sentence}")
        return self._contents[file]

    def find(
        self, folder: str, name: str, place: str | _Settings, path: KeyPath
    ) -> tuple[str, Mapping[str, Any] | None]:
        """The file of this name in a folder and what it holds; ``place`` is where it is named."""
        file = f"{folder}/{name}.yaml"
        if (self.folder / file).exists():
            return file, self.read(file)
        present = sorted(path.stem for path in (self.folder / folder).glob("*.yaml"))
        self._note(place, path, shown(name), f"is not in {folder}{choice(name, present)}")
        return file, None

    def check(
        self, model: type[EntryT], file: str | _Settings, content: Mapping[str, Any] | None
    ) -> EntryT | None:
        """The content as a model; None, with the problems noted, if it is not one."""
        if content is None:
            return None
        try:
            return model.model_validate(content)
        except ValidationError as error:
            for path, value, sentence in explained(error, model, content, names.PATTERNS):
                self._note(file, path, value, sentence)
            return None

    def check_regions(self, file: str, case: Case, assembly: Assembly) -> None:
        """Note each joint with more regions, or elements in all, than there are contact pairs.

        Bands hold each pair with its mirror image, and so are at most as many as on one side.
        """
        pairs = assembly.contact_pairs, f"the contact pairs of {case.assembly}"
        of_one_side = assembly.pairs_of_one_side, _pairs_of_one_side(case.assembly)
        for block_index, block in enumerate(case.solve):
            for index, joint in enumerate(block.joints):
                parsed = names.parse_joint(joint)
                regions = 1 if parsed.count == "auto" else parsed.count or 0
                for count, what, (most, of_what) in (
                    (
                        regions,
                        parsed.division,
                        of_one_side if parsed.division == "regions" else pairs,
                    ),
                    (regions * (parsed.elements or 0), "elements in all", pairs),
                ):
                    if count > most:
                        self._note(
                            file,
                            ("solve", block_index, "joints", index),
                            shown(joint),
                            f"must have at most {most} {what}, {of_what}",
                        )
                        break

    def check_options(self, file: str, case: Case, settings: Settings) -> None:
        """Note what the numerical options of the study do not allow in a case."""
        for problem in dict.fromkeys(_conflicts_with_options(case, settings)):
            self._note(file, *problem)

    def check_preloads(
        self, cases: Collection[Case], assemblies: Mapping[str, Assembly | None]
    ) -> None:
        """Note each assembly that is to have an enriched basis but no contact to make it from."""
        used = {case.assembly for case in cases}
        enriched = [name for case in cases for name in case.bases if names.is_enriched(name)]
        for name, assembly in assemblies.items():
            if enriched and assembly and name not in used and assembly.preload_N is None:
                sentence = f"is missing: {enriched[0]} is made from the contact under preload"
                self._note(f"{ASSEMBLY_FOLDER}/{name}.yaml", ("preload_N",), None, sentence)

    def check_bases(
        self,
        file: str,
        case: Case,
        contact_adapted_basis: ContactAdaptedBasis,
        assembly: Assembly | None,
    ) -> None:
        """Note each enriched basis of more vectors than are found."""
        for family in case.bases:
            sentence = _too_large(family, contact_adapted_basis, {case.assembly: assembly})
            if sentence:
                key = next(
                    ("modes",) if block.modes is None else ("solve", index, "modes")
                    for index, block in enumerate(case.solve)
                    if family in (block.modes or case.modes)
                )
                self._note(file, key, shown(family), sentence)

    def check_convergence(
        self,
        settings: _Settings,
        checked: Settings,
        cases: Collection[Case | None],
        assemblies: Mapping[str, Assembly | None],
    ) -> None:
        """Note bases and numbers of regions that an assembly does not have."""
        for index, basis in enumerate(checked.convergence.bases):
            if sentence := _too_large(basis, checked.contact_adapted_basis, assemblies):
                self._note(settings, ("convergence", "bases", index), shown(basis), sentence)
        divided = dict.fromkeys(
            case.assembly for case in cases if case and any(map(names.is_enriched, case.bases))
        )
        for index, count in enumerate(checked.convergence.regions):
            for name in divided:
                assembly = assemblies[name]
                if assembly and count > (most := assembly.pairs_of_one_side):
                    sentence = f"must be at most {most}, {_pairs_of_one_side(name)}"
                    self._note(settings, ("convergence", "regions", index), shown(count), sentence)
                    break

    def check_published(self, file: str, case: Case, published: Collection[str]) -> None:
        """Note a case study that the source does not have."""
        if case.published is not None and case.published not in published:
            sentence = f"is no case study of the source{choice(case.published, published)}"
            self._note(file, ("published",), shown(case.published), sentence)

    def _note(self, file: str | _Settings, path: KeyPath, value: str | None, sentence: str) -> None:
        place = file if isinstance(file, str) else file.place(path)
        keys = "".join(
            f"[{part}]" if isinstance(part, int) else f".{_as_word(part)}" for part in path
        )
        what = sentence if value is None else f"{value} {sentence}"
        self.problems.append(f"{place}: {keys.removeprefix('.')}: {what}")


def _as_word(text: str) -> str:
    """A key or file name as it is, or in quotes and cut where it is no plain word."""
    return text if re.fullmatch(r"[\w./=+~-]{1,200}", text) else shown(text)


def _pairs_of_one_side(assembly: str) -> str:
    return f"the contact pairs of {assembly} on one side of the centre line and on it"


def _too_large(
    basis: str,
    contact_adapted_basis: ContactAdaptedBasis,
    assemblies: Mapping[str, Assembly | None],
) -> str | None:
    """What an enriched basis of more vectors than are found must be, for the first assembly."""
    if not names.is_enriched(basis):
        return None
    number = names.parse_modes(basis)
    if number > contact_adapted_basis.most:
        return (
            f"must have at most {contact_adapted_basis.most} vectors, "
            f"as contact_adapted_basis.most in {CONFIG_FILE}"
        )
    for name, assembly in assemblies.items():
        if assembly is None:
            continue
        # candidates: modes, and the shapes of a force along and across the contact on every pair
        candidates = contact_adapted_basis.free_modes + 2 * assembly.pairs_of_one_side
        if number > candidates:
            return (
                f"must have at most {candidates} vectors: contact_adapted_basis.free_modes, "
                f"and two for each of {_pairs_of_one_side(name)}"
            )
    return None


def _conflicts_with_options(case: Case, settings: Settings) -> Iterator[tuple[KeyPath, str, str]]:
    """Key path, value and sentence for what a case asks for and the study's options do not do."""
    most, harmonics = settings.contact_adapted_basis.resonances, settings.solver.harmonics
    for index, block in enumerate(case.blocks):
        enriched = [name for name in block.modes if names.is_enriched(name)]
        if enriched and block.resonance > most:
            sentence = f"must be at most {most}, contact_adapted_basis.resonances, in {enriched[0]}"
            yield ("solve", index, "resonance"), shown(block.resonance), sentence
        of_block = ("solve", index) if case.solve[index].coordinates else ()
        for place, name in enumerate(block.coordinates):
            if harmonics > 1 and names.parse_coordinates(name).kind in ("complex", "backbone"):
                sentence = f"must be linear or rdnm-N with solver.harmonics: {harmonics}"
                yield (*of_block, "coordinates", place), shown(name), sentence


def _names(content: Mapping[str, Any], key: str) -> Iterator[tuple[KeyPath, str]]:
    """The well-formed names in the list under a key, each with its key path."""
    listed = content.get(key)
    if isinstance(listed, list | tuple):
        yield from (((key, index), name) for index, name in enumerate(listed) if _is_name(name))


def _is_name(value: object) -> bool:
    return isinstance(value, str) and re.fullmatch(names.NAME, value) is not None
