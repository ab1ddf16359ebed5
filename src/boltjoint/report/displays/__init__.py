"""Figures and tables of a study, each a function with its declaration; ``DISPLAYS`` has them all.

Every module of this package is read. It declares by the decorators of ``study.display``, and
imports what draws and computes within its functions: each job of the workflow reads them all.
"""

from importlib import import_module
from pkgutil import iter_modules

from boltjoint.study.display import Display, Displays

#: in the order of the names of the modules and, within each, of the functions
DISPLAYS = Displays(
    found
    for module in sorted(each.name for each in iter_modules(__path__))
    for found in vars(import_module(f"{__name__}.{module}")).values()
    if isinstance(found, Display)
)
