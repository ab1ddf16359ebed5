"""Figures and tables of a study, each a function with its declaration; ``DISPLAYS`` has them all.

Every module of this package is read, after them those that makers name, of figures and tables of
their own structures (``config.makers``), and those that other packages name by entry points of the
group ``boltjoint.displays``. Each declares by the decorators of ``study.display``, and
imports what draws and computes within its functions: every job that draws or tabulates reads all.
"""

from importlib import import_module
from pkgutil import iter_modules

from boltjoint.config.makers import displays_of_makers
from boltjoint.other_packages import entries
from boltjoint.study.display import Display, Displays

#: entry points by which other packages name modules of displays
GROUP = "boltjoint.displays"

_NAMES = sorted(module.name for module in iter_modules(__path__))
_OWN = [import_module(f"{__name__}.{name}") for name in _NAMES]
_OF_OTHERS = [point.load() for _, point in sorted(entries(GROUP).items())]

#: in the order of the names of the modules and, within each, of the functions
DISPLAYS = Displays(
    display
    for module in (*_OWN, *displays_of_makers(), *_OF_OTHERS)
    for display in vars(module).values()
    if isinstance(display, Display)
)
