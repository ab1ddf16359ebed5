"""The friction laws by their names in files: an own one is declared in ``declarations`` too.

A law of another package is a module with its ``DECLARATION``, a ``LawDeclaration``, and a function
``law()`` that imports and returns its class, an ``ElementLaw``; an entry point of the group
``boltjoint.laws`` names the module by the name of the law.
"""

from types import ModuleType

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.coupled import CoupledConstantLoad, CoupledVariableLoad
from boltjoint.friction.declarations import GROUP
from boltjoint.friction.element_law import ElementLaw
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.kelvin_voigt import KelvinVoigtLayer
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.friction.uncoupled import UncoupledConstantLoad, UncoupledVariableLoad
from boltjoint.friction.variable import VariableLoad
from boltjoint.other_packages import WithOtherPackages

_OWN: dict[str, type[ElementLaw]] = {
    law.declaration.name: law
    for law in (
        ConstantLoad,
        VariableLoad,
        FourParameterIwan,
        KelvinVoigtLayer,
        TabulatedLoad,
        UncoupledConstantLoad,
        UncoupledVariableLoad,
        CoupledConstantLoad,
        CoupledVariableLoad,
    )
}


def _of_module(module: ModuleType) -> type[ElementLaw]:
    """The law of a module of another package."""
    return module.law()


#: classes by name, those of other packages once they are asked for
LAWS = WithOtherPackages(_OWN, GROUP, _of_module)
