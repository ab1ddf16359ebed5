"""Factors of stiffness matrices, and the rigid-body motions of a structure that nothing holds."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import eigh, qr
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu
from threadpoolctl import ThreadpoolController

from boltjoint import checks
from boltjoint.config.types import PACKAGES_OF_FACTORISATION

Array = NDArray[np.float64]

#: advice where a structure is not held
_HELD = (
    "a part of the assembly is not held, or its stiffnesses are too far apart: check that its "
    "elements are not much longer than wide, and that its material is nearer to steel"
)

#: share of the highest squared frequency below which others are lost in rounding
ROUNDING_OF_FREQUENCIES = 1e-13

#: leaves the choice of the method to size and symmetry
AUTO = "auto"

#: unknowns from which an ordering by nested dissection takes less time; below, results of SuperLU
#: alone stay the same on all machines
_LARGE = 30_000

#: difference of entries across the diagonal, over the largest, that is rounding
_SYMMETRIC = 1e-12


class Factors(Protocol):
    """Factors of a matrix A."""

    def solve(self, right_side: Array) -> Array:
        """``x`` of ``A x = b``, shape of b: (unknowns,) or (unknowns, columns)."""
        ...


def factorise(matrix: sparse.csc_array, method: str = "superlu") -> Factors:
    """Factors of a sparse matrix that is symmetric, or nearly so, and needs no pivoting.

    Parameters
    ----------
    matrix
        Sparse and square.
    method
        ``superlu``: LU factors in an ordering of minimum degree; ``nested-dissection``: the same in
        one of METIS, with less fill; ``pardiso``: those of Intel's library, of one triangle where
        the matrix is symmetric, in half the memory, not to the bit alike on all machines.

    Raises
    ------
    ValueError
        If the matrix is not sparse and square, or the package of the method is not installed.
    RuntimeError
        If the matrix is singular.
    """
    if not (sparse.issparse(matrix) and matrix.ndim == 2 and matrix.shape[0] == matrix.shape[1]):
        raise ValueError("matrix must be sparse and square")
    checks.choice("method", method, METHODS)
    return METHODS[method](matrix.tocsc())


def chosen_method(method: str, unknowns: int, *, is_symmetric: bool) -> str:
    """Method of the factors of a structure: the one that it names or, of ``auto``, by its size.

    ``nested-dissection`` of large structures without a plane of symmetry, whose factors are those
    of the whole, where its package is installed; else ``superlu``.

    Parameters
    ----------
    method
        As of ``factorise``, or ``auto``.
    unknowns
        Degrees of freedom of the structure.
    is_symmetric
        Whether it has a plane of symmetry.
    """
    if method != AUTO:
        return method
    package = find_spec(PACKAGES_OF_FACTORISATION["nested-dissection"])
    is_large = unknowns >= _LARGE and not is_symmetric
    return "nested-dissection" if is_large and package is not None else "superlu"


def _superlu(matrix: sparse.csc_array, ordering: str = "MMD_AT_PLUS_A") -> SuperLU:
    # Pivots on the diagonal keep the fill of a symmetric ordering (SuperLU users' guide, 2.2).
    # Joining no columns into larger supernodes (relax) saves these matrices a tenth of the fill.
    try:
        return splu(
            matrix,
            permc_spec=ordering,
            diag_pivot_thresh=0.0,
            relax=1,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise RuntimeError(f"the stiffness matrix is singular: {_HELD}") from error


class _NestedDissection:
    """LU factors of SuperLU in an ordering by nested dissection.

    References
    ----------
    G. Karypis, V. Kumar: A fast and high quality multilevel scheme for partitioning irregular
    graphs. SIAM Journal on Scientific Computing 20 (1998) 359-392.
    """

    def __init__(self, matrix: sparse.csc_array) -> None:
        try:
            import pymetis
        except ImportError:
            raise ValueError(_missing("nested-dissection", "pymetis")) from None
        entries = np.ones(matrix.nnz, dtype=np.int8)
        pattern = sparse.csc_array((entries, matrix.indices, matrix.indptr), shape=matrix.shape)
        # tangents of slip may lack an entry across the diagonal
        pattern = (pattern + pattern.T).tocsc()
        size = matrix.shape[0]
        column = np.repeat(np.arange(size), np.diff(pattern.indptr))
        across = pattern.indices != column
        start = np.concatenate([[0], np.cumsum(np.bincount(column[across], minlength=size))])
        graph = pymetis.CSRAdjacency(start, pattern.indices[across])
        self._order = np.asarray(pymetis.nested_dissection(graph)[0])
        self._factors = _superlu(matrix[self._order][:, self._order].tocsc(), "NATURAL")

    def solve(self, right_side: Array) -> Array:
        """As of ``Factors``."""
        solution = np.empty_like(right_side, dtype=float)
        solution[self._order] = self._factors.solve(
            np.asarray(right_side, dtype=float)[self._order]
        )
        return solution


class _Pardiso:
    """Factors of PARDISO: ``L D L^T`` of symmetric matrices, LU of others.

    References
    ----------
    O. Schenk, K. Gaertner: Solving unsymmetric sparse systems of linear equations with PARDISO.
    Future Generation Computer Systems 20 (2004) 475-487.
    """

    def __init__(self, matrix: sparse.csc_array) -> None:
        try:
            import pypardiso
        except ImportError:
            raise ValueError(_missing("pardiso", "pypardiso")) from None
        # one thread: sums in another order would change the last digits, and jobs run side by side
        ThreadpoolController().select(internal_api="mkl").limit(limits=1)
        asymmetry = abs(matrix - matrix.T).max()
        is_symmetric = asymmetry <= _SYMMETRIC * abs(matrix.data).max(initial=0.0)
        self._solver = pypardiso.PyPardisoSolver(mtype=-2 if is_symmetric else 11)
        rows = sparse.triu(matrix, format="csr") if is_symmetric else matrix.tocsr()
        self._matrix = sparse.csr_matrix(rows)
        self._matrix.sort_indices()
        try:
            self._solver.factorize(self._matrix)
        except (ValueError, pypardiso.pardiso_wrapper.PyPardisoError) as error:
            raise RuntimeError(f"the stiffness matrix is singular: {_HELD}") from error

    def solve(self, right_side: Array) -> Array:
        """As of ``Factors``."""
        return self._solver.solve(self._matrix, np.asfortranarray(right_side, dtype=float))

    def __del__(self) -> None:
        """Free what is not memory of Python."""
        if solver := getattr(self, "_solver", None):
            solver.free_memory(everything=True)


def _missing(method: str, package: str) -> str:
    return f"{method} needs {package}: pip install boltjoint[fast]"


#: by name; the first is that of half laps, whose results are the same to the bit on all machines
METHODS: dict[str, Callable[[sparse.csc_array], Factors]] = {
    "superlu": _superlu,
    "nested-dissection": _NestedDissection,
    "pardiso": _Pardiso,
}


def check_held(squared: Array, stiffness: sparse.csc_array, mass: sparse.csc_array) -> None:
    """Refuse natural frequencies that a structure which is held cannot have.

    Parameters
    ----------
    squared
        Squares of the natural circular frequencies of elastic modes [s^-2], shape (modes,).
    stiffness, mass
        K and M.

    Raises
    ------
    RuntimeError
        If one of them is no number, or zero within rounding, as of a rigid-body mode.
    """
    lost = ~(squared > ROUNDING_OF_FREQUENCIES * highest_frequency(stiffness, mass))
    if lost.any():
        raise RuntimeError(
            f"{np.count_nonzero(lost)} of {len(squared)} natural frequencies are zero within "
            f"rounding, or no numbers: {_HELD}"
        )


def highest_frequency(stiffness: sparse.csc_array, mass: sparse.csc_array) -> float:
    """An estimate from below of the largest squared frequency, whose rounding all of them have."""
    inertia = mass.diagonal()
    return float((stiffness.diagonal()[inertia > 0] / inertia[inertia > 0]).max())


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
    masters = np.sort(qr(q.T, mode="r", pivoting=True)[1][:motions])
    others = np.delete(np.arange(len(q)), masters)
    rows = stiffness[others]
    motion = np.zeros_like(q)
    motion[masters] = np.eye(motions)
    factors = factorise(rows[:, others].tocsc(), factorisation)
    motion[others] = -factors.solve(rows[:, masters].toarray())
    return motion
