"""Which modal basis of a case is trusted most: its answer is given first."""

from collections.abc import Sequence

from boltjoint.config.case import Case
from boltjoint.names import Basis


def by_trust(bases: Sequence[Basis]) -> list[Basis]:
    """Contact-adapted bases first, the largest before all; then the others."""
    return sorted(bases, key=lambda basis: (basis.is_contact_adapted, basis.most), reverse=True)


def headline_basis(case: Case) -> Basis:
    """The basis of a case whose peaks stand first."""
    return by_trust(case.bases)[0]
