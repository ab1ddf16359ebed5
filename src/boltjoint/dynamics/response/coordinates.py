"""The harmonic balance in coordinates by their name: linear modes, RDNM or complex RDNM.

All of them are equations for the ``solvers``; unknowns translate back into the linear modes.
"""

from typing import get_args

from boltjoint import checks
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.linear_modes import Jacobian, LinearModes
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.rdnm import BasisUpdate, LaggedRDNM, SelfConsistentRDNM
from boltjoint.names import Coordinates


def formulate_equations(
    name: str,
    balance: HarmonicBalance,
    resonance: int,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "implicit",
    quasi_static_correction: bool = True,
) -> LinearModes:
    """Equations of the balance in ``linear``, ``rdnm-N`` or ``complex-rdnm-N`` coordinates.

    Parameters
    ----------
    name
        Of the coordinates.
    balance
        The modal equations.
    resonance
        The resonance that is followed, from 1.
    jacobian
        As for ``LinearModes``.
    basis_update
        ``implicit``: the modes are those of the solution itself (``SelfConsistentRDNM`` and
        ``ComplexRDNM``). ``lagged``: they are updated once a solution (``LaggedRDNM`` and
        ``ComplexRDNM``); ``rdnm-N`` with forward differences, as in the thesis, always does so.
    quasi_static_correction
        Whether ``complex-rdnm-N`` adds the quasi-static response of the residual modes.

    Raises
    ------
    ValueError
        If there are no such equations, not as many modes, or an option is not known.
    """
    coordinates = Coordinates(name)
    kind, count = coordinates.kind, coordinates.count
    checks.instance("balance", balance, HarmonicBalance)
    target = balance.joint.place_of(resonance)
    check_options(jacobian, basis_update, quasi_static_correction)
    if kind == "linear":
        return LinearModes(balance, jacobian)
    if kind == "complex":
        return ComplexRDNM(balance, count, target, jacobian, basis_update, quasi_static_correction)
    if kind == "real" and basis_update == "implicit" and jacobian == "analytic":
        return SelfConsistentRDNM(balance, count, target)
    if kind == "real":
        return LaggedRDNM(balance, count, target, jacobian)
    raise ValueError(f"the harmonic balance is not formulated in {name}")


def check_options(
    jacobian: Jacobian, basis_update: BasisUpdate, quasi_static_correction: bool
) -> None:
    """Refuse unknown options of coordinates, also of those that are not used.

    Parameters
    ----------
    jacobian, basis_update, quasi_static_correction
        As for ``formulate_equations``.
    """
    checks.choice("jacobian", jacobian, get_args(Jacobian))
    checks.choice("basis_update", basis_update, get_args(BasisUpdate))
    checks.flag("quasi_static_correction", quasi_static_correction)
