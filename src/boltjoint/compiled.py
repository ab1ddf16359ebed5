"""Functions of compiled loops whose implementation is chosen by the type of their first argument.

A loop calls a function that does nothing; named tuples of arrays bring what it stands for. Which
one is meant is known when the loop is compiled, so that the call costs nothing.
"""

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import njit, types
from numba.extending import overload

#: compiles a function that other loops call: division by zero gives infinity, as in NumPy
loop = njit(error_model="numpy")

#: compiles one that Python calls, and keeps its machine code for later processes
kept_loop = njit(error_model="numpy", cache=True)


def implements(function: Callable, of: type) -> Callable[[Callable], Callable]:
    """Decorate the compiled function that stands for another one of a class of named tuples.

    Parameters
    ----------
    function
        Called in compiled loops.
    of
        The named tuple that is its first argument.
    """

    def register(kernel: Callable) -> Callable:
        @overload(function)
        def select(*args: Any) -> Callable | None:  # noqa: ANN401
            first = args[0]
            if not (isinstance(first, types.NamedTuple) and first.instance_class is of):
                return None

            def call(*args: Any) -> Any:  # noqa: ANN401
                return kernel(*args)

            return call

        return kernel

    return register


@cache
def source_version() -> str:
    """Hash of all files of the library with compiled functions.

    Numba keeps machine code as long as the file of a function does not change, whatever happens to
    those that it calls. A function that encloses this string is compiled again where it differs.
    """
    found = sha256()
    for file in sorted(Path(__file__).parent.rglob("*.py")):
        text = file.read_bytes()
        if b"njit" in text or b"boltjoint.compiled import" in text:
            found.update(text)
    return found.hexdigest()
