"""Methods that factorise the stiffness of an assembly, and the packages that they need."""

from importlib.util import find_spec
from typing import Literal

from boltjoint.config.types import Problems

#: the first chooses by size and symmetry: of symmetric half laps always the second
Factorisation = Literal["auto", "superlu", "nested-dissection", "pardiso"]

#: packages of the extra ``fast``, by the method
PACKAGES = {"nested-dissection": "pymetis", "pardiso": "pypardiso"}


def conflicts_of_factorisation(method: Factorisation) -> Problems:
    """A method whose package is not installed."""
    package = PACKAGES.get(method)
    if package is not None and find_spec(package) is None:
        yield ("factorisation",), f"{method} needs {package}: pip install boltjoint[fast]"
