"""Nonlinear vibration of bolted lap joints, from dimensions to frequency responses."""

from importlib import import_module
from importlib.metadata import version

__version__ = version("boltjoint")

#: what users of the library call, by the module that holds it; imported when first asked for, since
#: compiled modules take their time
_NAMES = {
    "Branch": "branch",
    "ConstantLoad": "friction.constant",
    "Joint": "joint",
    "StepControl": "solvers.equations",
    "VariableLoad": "friction.variable",
    "find_backbone": "backbone",
    "frequency_window": "response",
    "solve_branch": "response",
    "solve_response": "response",
}


def __getattr__(name: str) -> object:
    """A name of the library, from the module that holds it."""
    if name not in _NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"boltjoint.{_NAMES[name]}"), name)


def __dir__() -> list[str]:
    """The names above beside the module's own."""
    return sorted([*globals(), *_NAMES])
