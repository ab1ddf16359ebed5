"""Code dependencies of a script: the files of the library it imports, and a hash of their content.

A workflow that sees only the script would keep results that a change in the library has made stale.
With this hash among the parameters of its rule, a result is made anew whenever the content of the
script or of a module it imports has changed, whatever their dates.
"""

import ast
from collections.abc import Iterator
from functools import cache
from hashlib import blake2b
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


class Sources:
    """The files of a package as they are now, each read once, for any number of scripts.

    Parameters
    ----------
    package
        The folder of the package, by default that of boltjoint.
    """

    def __init__(self, package: str | Path = PACKAGE) -> None:
        self._package = Path(package).resolve()
        self._files = _files_by_module(self._package)
        self._content: dict[str, bytes] = {}
        self._uses: dict[str, set[str]] = {}

    def used_by(self, script: str | Path) -> list[str]:
        """The files of the package that a script imports, directly or through other files of it.

        Files that are not Python, such as templates, count with the package in whose folder they
        lie. The text is parsed and nothing runs. Imports inside functions count, those for type
        checkers (``if TYPE_CHECKING:``) do not; an import by a computed name
        (``importlib.import_module``) is not seen.

        Parameters
        ----------
        script
            A Python file.

        Returns
        -------
        list of str
            Absolute paths, sorted, with the ``__init__.py`` and data files of every package on the
            way.

        Raises
        ------
        ValueError
            If an imported module of the package does not exist.
        """
        used: set[str] = set()
        waiting = {str(Path(script).resolve())}
        while waiting:
            files = self._used_by_file(waiting.pop())
            waiting |= {file for file in files - used if file.endswith(".py")}
            used |= files
        return sorted(used)

    def hash_of(self, script: str | Path) -> str:
        """A hash of the content of a script and of every file of the package that it uses.

        It depends on the names of the modules in the package, not on where the package lies, nor on
        dates.

        Parameters
        ----------
        script
            As for ``used_by``.

        Returns
        -------
        str
            Sixteen hexadecimal digits.

        Raises
        ------
        ValueError
            As from ``used_by``.
        """
        digest = blake2b(Path(script).read_bytes(), digest_size=8)
        start = len(f"{self._package}/")
        for source in self.used_by(script):
            content = self._content_of(source)
            # with the length of each, no content can be moved from one module to the next unseen
            digest.update(f"\n{source[start:]} {len(content)}\n".encode())
            digest.update(content)
        return digest.hexdigest()

    def _content_of(self, file: str) -> bytes:
        if file not in self._content:
            self._content[file] = Path(file).read_bytes()
        return self._content[file]

    def _used_by_file(self, file: str) -> set[str]:
        """The files of the modules that a file imports, and data files that lie beside it."""
        if file not in self._uses:
            path = Path(file)
            files = {used for name in self._imported(path) for used in self._files_of(name, path)}
            if path.name == "__init__.py" and path.is_relative_to(self._package):
                files |= {str(used) for used in _data_files(path.parent)}
            self._uses[file] = files
        return self._uses[file]

    def _imported(self, file: Path) -> Iterator[str]:
        """Dotted names of the package's modules that a file imports."""
        for base, names, level in _imports(self._content_of(str(file)).decode("utf-8"), str(file)):
            module = self._absolute_name(base, level, file)
            if module.split(".")[0] == self._package.name:
                yield module
                # `from a import b` names a module only if there is one; b may be a function
                yield from (full for name in names if (full := f"{module}.{name}") in self._files)

    def _absolute_name(self, module: str, level: int, file: Path) -> str:
        """The module of ``from module import ...``, with the leading dots resolved."""
        if level == 0:
            return module
        if not file.is_relative_to(self._package):
            return ""  # relative to a script: not the package's
        # one dot is the folder of the file, each further one the folder above
        folder = file.parents[level - 1].relative_to(self._package.parent)
        return ".".join([*folder.parts, *filter(None, [module])])

    def _files_of(self, module: str, imported_in: Path) -> Iterator[str]:
        """The file of a module and the ``__init__.py`` that Python runs before it."""
        parts = module.split(".")
        for length in range(1, len(parts) + 1):
            source = self._files.get(".".join(parts[:length]))
            if source is None:
                raise ValueError(
                    f"{imported_in}: imports {module}, which is not in {self._package}"
                )
            yield source


def _files_by_module(package: Path) -> dict[str, str]:
    """The Python files of a package, by their dotted names."""
    files: dict[str, str] = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        if path.name == "__init__.py":
            # a folder comes before a file of the same name
            files[".".join(parts[:-1])] = str(path)
        else:
            files.setdefault(".".join(parts), str(path))
    return files


@cache  # by the text, whatever file of this name held before
def _imports(text: str, file: str) -> tuple[tuple[str, tuple[str, ...], int], ...]:
    """Imports of a text: module, names taken from it, and leading dots."""
    imports: list[tuple[str, tuple[str, ...], int]] = []
    for node in _statements(ast.parse(text, filename=file)):
        if isinstance(node, ast.Import):
            imports += ((alias.name, (), 0) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = tuple(alias.name for alias in node.names)
            imports.append((node.module or "", names, node.level))
    return tuple(imports)


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All statements of a syntax tree, in others too, but those that only type checkers read."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.expr):
            continue  # no statement is within an expression, and most nodes are
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            continue
        yield node
        yield from _statements(node)


def _data_files(folder: Path) -> Iterator[Path]:
    """Files in the folder of a package that are not Python, without those of packages inside it."""
    for path in folder.iterdir():
        if path.name.startswith((".", "__pycache__")):
            continue
        if path.is_dir():
            if not (path / "__init__.py").exists():
                yield from _data_files(path)
        # of the library for type checkers there is nothing that runs
        elif path.suffix not in (".py", ".pyi", ".typed"):
            yield path
