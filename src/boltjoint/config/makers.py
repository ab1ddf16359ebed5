"""Makers of structures by the ``type`` of an assembly.

A maker is a module; what takes long to import is imported by its functions. It has

- ``Description``, the class of its YAML files, a ``Described``;
- ``make(description, folder)``, which turns one into a ``Structure``, or into a mesh, a dataset
  that ``structure_of(mesh)`` turns into one; ``folder`` is that of the study; a mesh has
  ``position`` (pair, axis), ``area`` and ``frame`` (pair, direction, axis) of the contact points,
  and may have ``coordinate`` (node, axis), ``connectivity`` (element, corner) and ``part``;

- ``PAGE``, the name of the module that tells pages of its structures by ``MEANING``, a sentence,
  and ``facts_of(description)``, numbers and words of one by what they are called;

and may have

- ``DISPLAYS``, the name of the module that declares figures and tables of its structures, as those
  of ``report.displays`` do;
- ``CALCULIX``, the name of the module that ``make verify`` asks: ``write_decks`` and ``compare`` as
  of ``makers.deck.calculix``;
- ``size_of(description, folder)``, its ``MeshSize`` where files tell it;
- ``damping_ratios_of(description, folder)``, of its elastic modes where files tell them;
- ``check(description, folder)``, what its files are, by words, and lines on what to look at, for
  ``boltjoint check``;
- ``families_of(structure, q)``, ``Families`` of elastic modes q, shape (dofs, modes);
- ``loaded_nodes(mesh)``, numbers of the nodes where forces may act, by default all;
- ``load_on_surface(mesh, surface)``, nodal forces (nodes,) of one newton on a surface.
"""

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from boltjoint import checks
from boltjoint.other_packages import entries

if TYPE_CHECKING:
    from boltjoint.config.described import Described

#: of an assembly that names no other
DEFAULT = "half_lap"
_MODULES = {
    "half_lap": "boltjoint.structure.makers.half_lap",
    "matrices": "boltjoint.structure.makers.matrices",
    "deck": "boltjoint.structure.makers.deck",
    "plates": "boltjoint.structure.makers.plates",
    "flange": "boltjoint.structure.makers.flange",
}
#: entry points by which other packages have makers
GROUP = "boltjoint.makers"


def maker_names() -> tuple[str, ...]:
    """Names of all makers, those of this package first."""
    return (*_MODULES, *entries(GROUP))


def is_maker(name: object) -> bool:
    """Whether there is a maker of this name."""
    return isinstance(name, str) and (name in _MODULES or name in entries(GROUP))


def maker(name: str) -> ModuleType:
    """The maker of this name; a ``ValueError`` if there is none."""
    if name in _MODULES:
        return import_module(_MODULES[name])
    return entries(GROUP)[checks.choice("maker", name, maker_names())].load()


def page_of(name: str) -> ModuleType:
    """The module that tells pages of the structures of this maker."""
    return import_module(maker(name).PAGE)


def displays_of_makers() -> list[ModuleType]:
    """The modules that declare figures and tables of the structures of makers that have any."""
    names = (getattr(maker(name), "DISPLAYS", None) for name in maker_names())
    return [import_module(name) for name in names if name is not None]


def type_of(content: Mapping[str, Any]) -> object:
    """The ``type`` of the content of a YAML file of an assembly."""
    return content.get("type", DEFAULT)


def description_of(content: Mapping[str, Any]) -> "Described":
    """The description with the content of a YAML file that was checked before."""
    return maker(str(type_of(content))).Description.model_validate(content)
