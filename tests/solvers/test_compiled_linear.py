"""Linear systems of compiled loops, in place and by LAPACK."""

import numpy as np
import pytest
from numba.extending import get_cython_function_address

from boltjoint.solvers.compiled_linear import LARGEST_ELIMINATED, make_work, solve_in_place

LAPACK = get_cython_function_address("scipy.linalg.cython_lapack", "dgesv")


@pytest.fixture(params=[4, LARGEST_ELIMINATED, LARGEST_ELIMINATED + 1, 90])
def work(request):
    """Arrays of a larger system, with a random matrix of this order in them."""
    work, generator = make_work(100), np.random.default_rng(request.param)
    n = request.param
    work.matrix[:n, :n] = generator.normal(size=(n, n))
    work.right[:n] = generator.normal(size=n)
    return work, n


def test_a_system_is_solved_and_its_determinant_has_the_sign(work):
    work, n = work
    for sign in (1, -1):
        work.matrix[0, :n] *= sign
        matrix, right = work.matrix[:n, :n].copy(), work.right[:n].copy()
        solve_in_place(LAPACK, work, n)
        np.testing.assert_allclose(matrix @ work.right[:n], right, atol=1e-10)
        assert work.sign[0] == np.linalg.slogdet(matrix)[0]
        work.matrix[:n, :n] = matrix


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_what_cannot_be_solved_has_no_sign(work, value):
    work, n = work
    work.matrix[:n, n // 2] = value
    solve_in_place(LAPACK, work, n)
    assert work.sign[0] == 0.0
