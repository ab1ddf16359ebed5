"""The equations of a joint in the coordinates that are asked for by name."""

from typing import get_args

from boltjoint import checks
from boltjoint.dynamics.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.linear_modes import Jacobian, LinearModes
from boltjoint.dynamics.rdnm import BasisUpdate, LaggedRDNM, SelfConsistentRDNM
from boltjoint.names import Coordinates


def pose(
    name: str,
    balance: HarmonicBalance,
    resonance: int,
    jacobian: Jacobian = "analytic",
    basis_update: BasisUpdate = "within",
    quasi_static_correction: bool = True,
) -> LinearModes:
    """Pose the balance in coordinates by their name: ``linear``, ``rdnm-N``, ``complex-rdnm-N``.

    Parameters
    ----------
    name
        The coordinates.
    balance
        The modal equations.
    resonance
        The resonance that is followed, from 1.
    jacobian
        As for ``LinearModes``.
    basis_update
        Whether the modes of ``rdnm-N`` are those of the solution itself (``within``), or stay those
        of the last one (``after``). Forward differences, as the source takes them, know the latter
        only. As for ``ComplexRDNM`` for ``complex-rdnm-N``.
    quasi_static_correction
        Of the modes left out, as for ``ComplexRDNM``.

    Raises
    ------
    ValueError
        If the balance cannot be posed in such coordinates, there are not as many modes, or an
        option is not known.
    """
    coordinates = Coordinates(name)
    kind, count = coordinates.kind, coordinates.count
    checks.instance("balance", balance, HarmonicBalance)
    target = balance.joint.check_resonance(resonance) - 1
    check_options(jacobian, basis_update, quasi_static_correction)
    if kind == "linear":
        return LinearModes(balance, jacobian)
    if kind == "complex":
        return ComplexRDNM(balance, count, target, jacobian, basis_update, quasi_static_correction)
    if kind == "real" and basis_update == "within" and jacobian == "analytic":
        return SelfConsistentRDNM(balance, count, target)
    if kind == "real":
        return LaggedRDNM(balance, count, target, jacobian)
    raise ValueError(f"the balance is not posed in {name}")


def check_options(
    jacobian: Jacobian, basis_update: BasisUpdate, quasi_static_correction: bool
) -> None:
    """Refuse options of coordinates that are not known, whichever coordinates have a use for them.

    Parameters
    ----------
    jacobian, basis_update, quasi_static_correction
        As for ``pose``.
    """
    checks.choice("jacobian", jacobian, get_args(Jacobian))
    checks.choice("basis_update", basis_update, get_args(BasisUpdate))
    checks.flag("quasi_static_correction", quasi_static_correction)
