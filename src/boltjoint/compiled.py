"""Loops compiled by numba, and calls of functions that are compiled apart.

What a loop calls by its name is compiled into it, again for each loop and each type of its
arguments. A function that is called at its address is compiled once; a loop that calls such
functions is compiled once for all of them.
"""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

from llvmlite import ir
from numba import njit, typeof, types
from numba.core.caching import FunctionCache
from numba.extending import intrinsic

logger = logging.getLogger(__name__)

#: compiles a function that other loops call: division by zero gives infinity, as in NumPy; called
#: from Python it lets other threads run
loop = njit(error_model="numpy", nogil=True)

#: compiles a function that sums in any order, by the processor's vectors
summing_loop = njit(error_model="numpy", nogil=True, fastmath={"reassoc", "contract"})


@cache
def _source_version() -> str:
    """Hash of all files of the library with compiled functions."""
    version = sha256()
    for file in sorted(Path(__file__).parent.rglob("*.py")):
        text = file.read_bytes()
        if b"njit" in text or b"boltjoint.compiled import" in text:
            version.update(text)
    return version.hexdigest()


class _Cache(FunctionCache):
    """Machine code of a function for this version of all that it may call.

    Numba keeps it as long as the function's own file does not change, whatever happens to others.
    """

    def _index_key(self, *arguments: Any) -> tuple:  # noqa: ANN401
        return *super()._index_key(*arguments), _source_version()

    def load_overload(self, *arguments: Any) -> Any:  # noqa: ANN401
        """The machine code for types of arguments; None where there is none."""
        try:
            return super().load_overload(*arguments)
        except (ImportError, AttributeError, EOFError, UnpicklingError):
            # of a version of the library whose modules or types have gone since
            with self._guard_against_spurious_io_errors():
                self.flush()
            return None

    @contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        """While machine code is read or kept: what cannot be is compiled anew."""
        try:
            yield
        except OSError:
            _report_missing_cache()


@cache
def _report_missing_cache() -> None:
    """Warn that every process compiles anew, once."""
    logger.warning(
        "no folder can be written where numba would keep machine code: every process compiles "
        "anew; NUMBA_CACHE_DIR may name one"
    )


def kept_loop(function: Callable) -> Callable:
    """Compile a function, and keep its machine code for later processes.

    Where neither the folder of its file nor that of the user's caches can be written, it is not
    kept.
    """
    compiled = loop(function)
    try:
        # what ``cache=True`` does, with a cache of another class
        compiled._cache = _Cache(function)
    except RuntimeError:
        _report_missing_cache()
    return compiled


def address_of(function: Any, *arguments: object) -> int:  # noqa: ANN401
    """Where ``call`` finds a compiled function for arguments of the types of these examples."""
    signature = types.void(*map(typeof, arguments))
    function.compile(signature)
    result = function.get_compile_result(signature)
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


@intrinsic
def call(_: object, address: types.Type, *arguments: types.Type) -> tuple[Any, Callable]:
    """In a compiled loop, call the function at an address.

    The arguments must be of the types for which ``address_of`` gave the address. The function
    returns nothing and must not raise errors, which would be lost.
    """

    def generate(target: Any, builder: Any, _: object, values: Sequence) -> Any:  # noqa: ANN401
        convention = target.call_conv
        kind = convention.get_function_type(types.void, arguments)
        pointer = builder.inttoptr(values[0], kind.as_pointer())
        # to propagate an error would cost as much as the smallest of these functions
        each = [builder.extract_value(values[1], place) for place in range(len(arguments))]
        convention.call_function(builder, pointer, types.void, arguments, each)
        return target.get_dummy_value()

    return types.void(address, types.StarArgTuple(arguments)), generate


@intrinsic
def call_c(_: object, address: types.Type, *arguments: types.Type) -> tuple[Any, Callable]:
    """In a compiled loop, call a function of C or Fortran at an address, with arrays alone.

    It is given where the numbers of each array begin, and returns nothing.
    """

    def generate(target: Any, builder: Any, _: object, values: Sequence) -> Any:  # noqa: ANN401
        memory = ir.IntType(8).as_pointer()
        pointers = []
        for place, kind in enumerate(arguments):
            value = builder.extract_value(values[1], place)
            array = target.make_array(kind)(target, builder, value)
            pointers.append(builder.bitcast(array.data, memory))
        kind = ir.FunctionType(ir.VoidType(), [memory] * len(pointers))
        builder.call(builder.inttoptr(values[0], kind.as_pointer()), pointers)
        return target.get_dummy_value()

    return types.void(address, types.StarArgTuple(arguments)), generate
