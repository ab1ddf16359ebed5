"""YAML files of a study, settings in layers, and the problems found in them, one line each."""

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from boltjoint.config.entries import Entry, choice, explained
from boltjoint.config.strict_yaml import TextError, read_mapping, shown, typed
from boltjoint.config.types import COMMAND_LINE, CONFIG_FILE, ConfigError, KeyPath

EntryT = TypeVar("EntryT", bound=Entry)


class Layers:
    """Keys of several origins, of which the later replace the earlier."""

    def __init__(self) -> None:
        self.content: dict[str, Any] = {}
        self._layers: list[tuple[str, Mapping[str, Any]]] = []

    def add(self, place: str, changes: Mapping[str, Any]) -> None:
        """Replace the keys that a file or the command line gives."""
        self.content = _merged(self.content, changes)
        self._layers.append((place, changes))

    def origin(self, path: KeyPath) -> str:
        """Origin of the value under a key path, or else of what that would be a part of."""
        for length in range(len(path), 0, -1):
            for place, changes in reversed(self._layers):
                if _gives(changes, path[:length]):
                    return place
        return CONFIG_FILE


def _merged(content: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(content)
    for key, value in changes.items():
        if isinstance(value, Mapping):
            below = merged.get(key)
            value = _merged(below if isinstance(below, Mapping) else {}, value)
        merged[key] = value
    return merged


def _gives(content: Any, path: KeyPath) -> bool:  # noqa: ANN401 - YAML
    """Whether the value under a key path, or a list or word in which it would be, is given."""
    for part in path:
        if not isinstance(content, Mapping):
            return True
        if part not in content:
            return False
        content = content[part]
    return True


class StudyFiles:
    """The files of one study, and every problem found in them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.problems: list[str] = []
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
                problem = f"{shown(file)} must be the name of a file"
                self.note(COMMAND_LINE, [(("study",), problem)])
            elif (content := self.read(file)) is not None:
                layers.add(_plain(file), content)
        try:
            given = {key: value for key, value in changes.items() if key != "study"}
            layers.add(COMMAND_LINE, typed(given))
        except ValueError as error:
            self.problems.append(f"{COMMAND_LINE}: {error}")
        return layers

    def read(self, file: str) -> Mapping[str, Any] | None:
        """The mapping that a file holds; None, with a problem noted, if it holds none."""
        if file not in self._contents:
            self._contents[file] = None
            place = _plain(file)
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
        self, folder: str, name: str, place: str | Layers, path: KeyPath
    ) -> Mapping[str, Any] | None:
        """The mapping in the file of this name, which is given at a key path of a place."""
        if (self.folder / folder / f"{name}.yaml").exists():
            return self.read(f"{folder}/{name}.yaml")
        present = sorted(path.stem for path in (self.folder / folder).glob("*.yaml"))
        problem = f"{shown(name)} is not in {folder}{choice(name, present)}"
        self.note(place, [(path, problem)])
        return None

    def check(
        self, model: type[EntryT], place: str | Layers, content: Mapping[str, Any] | None
    ) -> EntryT | None:
        """The content as a model; None, with the problems noted, if it is not one."""
        if content is None:
            return None
        try:
            return model.model_validate(content)
        except ValidationError as error:
            self.note(place, explained(error, model, content))
            return None

    def note(self, place: str | Layers, problems: Iterable[tuple[KeyPath, str]]) -> None:
        """Keep problems of a file, or of settings, as lines."""
        for path, problem in problems:
            file = place if isinstance(place, str) else place.origin(path)
            self.problems.append(f"{file}: {''.join(_keys(path)).removeprefix('.')}: {problem}")


def _keys(path: KeyPath) -> Iterator[str]:
    for part in path:
        yield f"[{part}]" if isinstance(part, int) else f".{_plain(part)}"


def _plain(text: str) -> str:
    """A key or file name as it is, or in quotes and cut where it is no plain word."""
    return text if re.fullmatch(r"[\w./=+~-]{1,200}", text) else shown(text)
