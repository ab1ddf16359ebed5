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


def source_hash(script: str | Path, package: str | Path = PACKAGE) -> str:
    """A hash of the content of a script and of every file of a package that it uses.

    It depends on the names of the modules in the package, not on where the package lies, nor on
    dates.

    Parameters
    ----------
    script, package
        As for ``library_sources``.

    Returns
    -------
    str
        Sixteen hexadecimal digits.

    Raises
    ------
    ValueError
        As from ``library_sources``.
    """
    digest = blake2b(Path(script).read_bytes(), digest_size=8)
    for source in map(Path, library_sources(script, package)):
        content = source.read_bytes()
        # with the length of each, no content can be moved from one module to the next unseen
        digest.update(f"\n{source.relative_to(Path(package).resolve())} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()


def library_sources(script: str | Path, package: str | Path = PACKAGE) -> list[str]:
    """The files of a package that a script imports, directly or through other files of it.

    Files that are not Python, such as templates, count with the package in whose folder they lie.
    The text is parsed and nothing runs. Imports inside functions count, those for type checkers
    (``if TYPE_CHECKING:``) do not; an import by a computed name (``importlib.import_module``) is
    not seen.

    Parameters
    ----------
    script
        A Python file.
    package
        The folder of the package, by default that of boltjoint.

    Returns
    -------
    list of str
        Absolute paths, sorted, with the ``__init__.py`` and data files of every package on the way.

    Raises
    ------
    ValueError
        If an imported module of the package does not exist.
    """
    package = Path(package).resolve()
    files: set[Path] = set()
    waiting = [Path(script).resolve()]
    while waiting:
        file = waiting.pop()
        if file.name == "__init__.py" and file.is_relative_to(package):
            files.update(_data_files(file.parent))
        for module in _imported_modules(file.read_text(encoding="utf-8"), file, package):
            for source in _files_of(module, package, imported_in=file):
                if source not in files:
                    files.add(source)
                    waiting.append(source)
    return sorted(str(path) for path in files)


@cache  # most scripts lead to the same modules
def _imported_modules(text: str, file: Path, package: Path) -> tuple[str, ...]:
    """Dotted names of the package's modules that a file of this text imports."""
    names: list[str] = []
    for node in _statements(ast.parse(text, filename=str(file))):
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = _absolute_name(node, file, package)
            modules = [base]
            for alias in node.names:
                # `from a import b` names a module only if there is one; b may be a function
                if _file_of(f"{base}.{alias.name}", package) is not None:
                    modules.append(f"{base}.{alias.name}")
        else:
            continue
        names += (name for name in modules if name.split(".")[0] == package.name)
    return tuple(names)


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All statements of a syntax tree, in others too, but those that only type checkers read."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.expr):
            continue  # no statement is within an expression, and most nodes are
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            continue
        yield node
        yield from _statements(node)


def _absolute_name(node: ast.ImportFrom, file: Path, package: Path) -> str:
    """The module of ``from module import ...``, with the leading dots resolved."""
    if node.level == 0:
        return node.module or ""
    if not file.is_relative_to(package):
        return ""  # relative to a script: not the package's
    # one dot is the folder of the file, each further one the folder above
    folder = file.parents[node.level - 1].relative_to(package.parent)
    return ".".join([*folder.parts, *filter(None, [node.module])])


def _files_of(module: str, package: Path, imported_in: Path) -> Iterator[Path]:
    """The file of a module and the ``__init__.py`` that Python runs before it."""
    parts = module.split(".")
    for length in range(1, len(parts) + 1):
        source = _file_of(".".join(parts[:length]), package)
        if source is None:
            raise ValueError(f"{imported_in}: imports {module}, which is not in {package}")
        yield source


def _data_files(folder: Path) -> Iterator[Path]:
    """Files in the folder of a package that are not Python, without those of packages inside it."""
    for path in folder.iterdir():
        if path.name.startswith((".", "__pycache__")):
            continue
        if path.is_dir():
            if not (path / "__init__.py").exists():
                yield from _data_files(path)
        elif path.suffix != ".py":
            yield path


def _file_of(module: str, package: Path) -> Path | None:
    stem = package.parent.joinpath(*module.split("."))
    for source in (stem / "__init__.py", stem.with_name(f"{stem.name}.py")):
        if source.is_file():
            return source
    return None
