"""YAML files of a study, settings in layers, and the problems found in them, one line each."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from hashlib import blake2b, file_digest
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from boltjoint.config.csv_table import read_file
from boltjoint.config.entries import Entry
from boltjoint.config.error_messages import MOST_EXPLAINED, choice, explain
from boltjoint.config.strict_yaml import (
    TextError,
    as_keys,
    as_text,
    as_word,
    read_mapping,
    resolve_types,
)
from boltjoint.config.types import (
    COMMAND_LINE,
    CONFIG_FILE,
    ConfigError,
    KeyPath,
    refusing_exceptions,
)
from boltjoint.provenance.environment import machine_memory
from boltjoint.regular_file import require_regular

EntryT = TypeVar("EntryT", bound=Entry)


class Layers:
    """Keys of several origins, of which the later replace the earlier."""

    def __init__(self) -> None:
        self.content: dict[str, Any] = {}
        self._origins: dict[KeyPath, str] = {}

    def add(self, origin: str, changes: Mapping[str, Any]) -> None:
        """Replace the keys that a file or the command line gives."""
        self.content = _merge(self.content, changes)
        self._origins |= dict.fromkeys(_paths(changes), origin)

    def origin(self, path: KeyPath) -> str:
        """Origin of the value under a key path, or else of what that would be a part of."""
        paths = (path[:length] for length in range(len(path), 0, -1))
        return next(
            (self._origins[candidate] for candidate in paths if candidate in self._origins),
            CONFIG_FILE,
        )


def _merge(content: Any, changes: Any) -> Any:  # noqa: ANN401 - YAML
    if not isinstance(changes, Mapping):
        return changes
    below = content if isinstance(content, Mapping) else {}
    return {**below, **{key: _merge(below.get(key), value) for key, value in changes.items()}}


def _paths(content: Any, path: KeyPath = ()) -> Iterator[KeyPath]:  # noqa: ANN401 - YAML
    yield path
    if isinstance(content, Mapping):
        for key, value in content.items():
            yield from _paths(value, (*path, key))


class FileHashes(dict[str, str]):
    """Hashes of the files that a study names: of one that is not there it is found first."""

    def __init__(self, find: Callable[[str], str]) -> None:
        super().__init__()
        self._find = find

    def __missing__(self, file: str) -> str:
        self[file] = self._find(file)
        return self[file]


class StudyFiles:
    """The files of one study, every problem found in them, and hashes of those it names."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[str] = []
        self.hashes = FileHashes(self._hash_of)
        #: names of the files of a folder, listed once
        self._present: dict[str, dict[str, None]] = {}
        self._contents: dict[str, Mapping[str, Any] | None] = {}

    def refuse_problems(self) -> None:
        """Raise all problems found so far, if there are any."""
        if self.problems:
            raise ConfigError(self.problems)

    def settings(self, changes: Mapping[str, Any]) -> Layers:
        """The keys of config.yaml, then of the study file, then of the command line."""
        layers = Layers()
        if (content := self.read(CONFIG_FILE)) is not None:
            layers.add(CONFIG_FILE, content)
        if "study" in changes:
            file = changes["study"]
            if not isinstance(file, str) or "\0" in file:
                problem = f"{as_text(file)} must be the name of a file"
                self.note(COMMAND_LINE, [(("study",), problem)])
            elif (content := self.read(file, anywhere=True)) is not None:
                layers.add(as_word(file), content)
        settings = {key: value for key, value in changes.items() if key != "study"}
        content, problems = resolve_types(settings)
        self.note(COMMAND_LINE, problems)
        layers.add(COMMAND_LINE, content)
        return layers

    def read(self, file: str, anywhere: bool = False) -> Mapping[str, Any] | None:
        """The mapping that a file holds; None, with a problem noted, if it holds none.

        The file must lie in the folder of the study, or may lie ``anywhere``.
        """
        if file not in self._contents:
            self._contents[file] = None
            place = as_word(file)
            try:
                self._contents[file] = read_mapping(
                    self.folder / file, None if anywhere else self.folder
                )
            except FileNotFoundError:
                self.problems.append(f"{place}: there is no such file in {self.folder.resolve()}")
            except OSError as error:
                self.problems.append(f"{place}: cannot be read: {error.strerror}")
            except TextError as error:
                self.problems.append(f"{place}{error.place}: {error.sentence}")
        return self._contents[file]

    def table(self, file: str) -> str:
        """The text of a CSV file in the folder of the study; its hash is kept in ``hashes``.

        Raises
        ------
        OSError, UnsuitableFile
            As from ``csv_table.read_file``.
        """
        text = read_file(self.folder / file, self.folder)
        self.hashes[file] = blake2b(text.encode(), digest_size=8).hexdigest()
        return text

    def _hash_of(self, file: str) -> str:
        """Hash of the content of a file in the folder of the study."""
        if file.endswith(".csv"):
            self.table(file)
            return self.hashes[file]
        path = self.folder / file
        require_regular(path, int(machine_memory()), self.folder)
        with open(path, "rb") as content:
            return file_digest(content, partial(blake2b, digest_size=8)).hexdigest()

    def find(
        self, folder: str, name: str, place: str | Layers, path: KeyPath
    ) -> Mapping[str, Any] | None:
        """The mapping in the file of this name, which is given at a key path of a place."""
        if folder not in self._present:
            files = (self.folder / folder).glob("*.yaml")
            self._present[folder] = dict.fromkeys(sorted(path.stem for path in files))
        if name in self._present[folder]:
            return self.read(f"{folder}/{name}.yaml")
        problem = f"{as_text(name)} is not in {folder}"
        if len(self.problems) < MOST_EXPLAINED:
            problem += choice(name, self._present[folder])
        self.note(place, [(path, problem)])
        return None

    def check(
        self, model: type[EntryT], place: str | Layers, content: Mapping[str, Any] | None
    ) -> EntryT | None:
        """The content as a model; None, with the problems noted, if it is not one."""
        if content is None:
            return None
        with self.checking(place if isinstance(place, str) else CONFIG_FILE):
            try:
                return model.model_validate(content)
            except ValidationError as error:
                self.note(place, explain(error, model, content))
        return None

    @contextmanager
    def checking(self, file: str) -> Iterator[None]:
        """Note it as a problem of a file if a check of its values ends in any exception."""
        try:
            with refusing_exceptions(file, "checked"):
                yield
        except ConfigError as error:
            self.problems += error.problems

    def note(self, place: str | Layers, problems: Iterable[tuple[KeyPath, str]]) -> None:
        """Keep problems of a file, or of settings, as lines."""
        for path, problem in problems:
            file = place if isinstance(place, str) else place.origin(path)
            keys = f"{as_keys(path)}: " if path else ""
            self.problems.append(f"{file}: {keys}{problem}")
