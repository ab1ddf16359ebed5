"""Rigid-body motions of a structure that nothing holds."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh, qr
from scipy.sparse.linalg import LinearOperator, eigsh

from boltjoint.structure.factors import ROUNDING_OF_FREQUENCIES, factorise, highest_frequency

Array = NDArray[np.float64]

#: share of the highest squared frequency by which a singular stiffness is shifted to be factorized
_SHIFT = 1e-10
#: modes that are looked at: one more than those of a body, and one that tells the others apart
_MODES = 8
#: degrees of freedom up to which all modes are found
_FEW = 200


def rigid_motions(
    stiffness: sparse.csc_array, mass: sparse.csc_array, factorisation: str = "superlu"
) -> Array:
    """Motions without strain energy, shape (dofs, motions).

    They are found among the lowest modes, and then to rounding: with as many degrees of freedom
    given as there are motions, the others follow by statics.

    Parameters
    ----------
    stiffness, mass
        K and M, symmetric.
    factorisation
        Method of the factors, as of ``factorise``.
    """
    highest = highest_frequency(stiffness, mass)
    limit = ROUNDING_OF_FREQUENCIES * highest
    if stiffness.shape[0] <= _FEW:
        shifted = (stiffness + _SHIFT * highest * mass).toarray()
        # massless degrees of freedom have no frequency: the largest of these ratios are the lowest
        ratio, q = eigh(mass.toarray(), shifted)
        ratio, q = ratio[::-1][:_MODES], q[:, ::-1][:, :_MODES]
        has_mass = ratio > np.finfo(float).eps * len(shifted) * ratio[0]
        ratio, q = ratio[has_mass], q[:, has_mass]
        squared = 1 / ratio - _SHIFT * highest
    else:
        factors = factorise((stiffness + _SHIFT * highest * mass).tocsc(), factorisation)
        inverse = LinearOperator(stiffness.shape, factors.solve, dtype=float)
        start = np.random.default_rng(0).standard_normal(stiffness.shape[0])
        squared, q = eigsh(
            stiffness, k=_MODES, M=mass, sigma=-_SHIFT * highest, OPinv=inverse, v0=start
        )
    q = q[:, squared <= limit]
    motions = q.shape[1]
    if not motions:
        return np.zeros((stiffness.shape[0], 0))
    # those that depend on each other least
    given = np.sort(qr(q.T, mode="r", pivoting=True)[1][:motions])
    others = np.delete(np.arange(len(q)), given)
    rows = stiffness[others]
    found = np.zeros_like(q)
    found[given] = np.eye(motions)
    factors = factorise(rows[:, others].tocsc(), factorisation)
    found[others] = -factors.solve(rows[:, given].toarray())
    return found
