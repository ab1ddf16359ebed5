"""The friction laws by their names in files."""

from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.coupled import CoupledConstantLoad, CoupledVariableLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.law import ElementLaw
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.friction.uncoupled import UncoupledConstantLoad, UncoupledVariableLoad
from boltjoint.friction.variable import VariableLoad

LAWS: dict[str, type[ElementLaw]] = {
    law.declaration.name: law
    for law in (
        ConstantLoad,
        VariableLoad,
        FourParameterIwan,
        TabulatedLoad,
        UncoupledConstantLoad,
        UncoupledVariableLoad,
        CoupledConstantLoad,
        CoupledVariableLoad,
    )
}
