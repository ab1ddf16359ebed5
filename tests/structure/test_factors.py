"""Factors of stiffness matrices by every method that is installed."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from element_meshes import box_of
from matrix_files import described
from scipy import sparse
from threadpoolctl import ThreadpoolController

from boltjoint.config import types
from boltjoint.config.types import Factorisation, conflicts_of_factorisation
from boltjoint.structure import factors
from boltjoint.structure.elements.assembly import assemble
from boltjoint.structure.factors import AUTO, METHODS, chosen_method, factorise
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.structure.structure_file import structure_from_dataset, structure_to_dataset


@pytest.fixture(params=METHODS)
def method(request):
    package = types.PACKAGES_OF_FACTORISATION.get(request.param)
    if package is not None and find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    return request.param


@pytest.fixture(scope="module")
def stiffness():
    """K of a box on springs."""
    node, block = box_of("C3D8I", (8, 4, 3), amount=0.1)
    K, M = assemble(node, [block])
    return (K + 1e7 * M).tocsc()


def test_equations_are_solved(method, stiffness):
    b = np.random.default_rng(0).standard_normal((stiffness.shape[0], 3))
    found = factorise(stiffness, method)
    for right_side in (b, b[:, 0], np.asfortranarray(b)):
        before = right_side.copy()
        x = found.solve(right_side)
        assert x.shape == right_side.shape
        np.testing.assert_allclose(stiffness @ x, right_side, atol=1e-9)
        np.testing.assert_array_equal(right_side, before)


def test_a_tangent_of_slip_is_not_symmetric(method, stiffness):
    # normal load on one unknown makes friction on another one
    slip = sparse.coo_array(([3e11], ([100], [500])), shape=stiffness.shape)
    tangent = (stiffness + slip).tocsc()
    b = np.random.default_rng(0).standard_normal(stiffness.shape[0])
    np.testing.assert_allclose(tangent @ factorise(tangent, method).solve(b), b, atol=1e-9)


def test_factors_are_the_same_each_time(method, stiffness):
    b = np.ones(stiffness.shape[0])
    one, other = (factorise(stiffness, method).solve(b) for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_pardiso_takes_one_thread(stiffness):
    pytest.importorskip("pypardiso")
    factorise(stiffness, "pardiso")
    libraries = ThreadpoolController().select(internal_api="mkl").info()
    assert [each["num_threads"] for each in libraries] == [1]


def test_nested_dissection_has_less_fill():
    pytest.importorskip("pymetis")
    node, block = box_of("C3D8", (12, 12, 12))
    K, M = assemble(node, [block])
    matrix = (K + 1e7 * M).tocsc()
    assert factorise(matrix, "nested-dissection")._factors.nnz < 0.9 * factorise(matrix).nnz


@pytest.mark.parametrize("name", ["superlu", "nested-dissection"])
def test_a_singular_matrix_is_told(name):
    if name != "superlu":
        pytest.importorskip("pymetis")
    with pytest.raises(RuntimeError, match="the stiffness matrix is singular"):
        factorise(sparse.csc_array(np.diag([1.0, 0.0, 2.0])), name)


def test_wrong_methods_and_matrices_are_refused():
    with pytest.raises(
        ValueError, match="method 'cholesky' is not known; allowed: superlu, nested"
    ):
        factorise(sparse.eye_array(3), "cholesky")
    with pytest.raises(ValueError, match="matrix must be sparse and square"):
        factorise(np.eye(3))


def test_methods_of_files_are_those_of_the_library():
    assert (AUTO, *METHODS) == Factorisation.__args__


def test_a_method_without_its_package_is_refused_in_files_and_in_calls(structure, monkeypatch):
    monkeypatch.setattr(types, "find_spec", lambda package: None)
    for name, package in types.PACKAGES_OF_FACTORISATION.items():
        message = f"{name} needs {package}: pip install boltjoint"
        assert next(conflicts_of_factorisation(name)) == (("factorisation",), f"{message}[fast]")
        with pytest.raises(ValueError, match=message):
            described(structure, factorisation=name)
        monkeypatch.setitem(__import__("sys").modules, package, None)
        with pytest.raises(ValueError, match=message):
            factorise(sparse.eye_array(3), name)
    for name in ("auto", "superlu"):
        assert not list(conflicts_of_factorisation(name))


def test_all_stages_take_the_method_of_the_structure(structure, method, monkeypatch):
    other = replace(structure, factorisation=method)
    other = structure_from_dataset(structure_to_dataset(other))
    assert other.factorisation == method
    used = set()
    for name, each in METHODS.items():
        counted = lambda matrix, name=name, each=each: used.add(name) or each(matrix)  # noqa: E731
        monkeypatch.setitem(factors.METHODS, name, counted)
    preload, modes = apply_preload(other, 8e3), find_modes(other, "free-3")
    assert used == {method}
    expected, of_superlu = apply_preload(structure, 8e3), find_modes(structure, "free-3")
    largest = expected["normal_load"].max().item()
    # GMRES ends a correction where factors of another rounding let it
    np.testing.assert_allclose(preload["normal_load"], expected["normal_load"], atol=1e-8 * largest)
    name = "natural_frequency"
    np.testing.assert_allclose(modes[name], of_superlu[name], rtol=1e-9)


def test_files_of_the_default_name_no_method(structure):
    stored = structure_to_dataset(structure)
    assert stored.attrs == {"maker": structure.maker}
    assert structure_from_dataset(stored).factorisation == AUTO


def test_the_method_is_chosen_by_size_and_symmetry(structure, monkeypatch):
    packages = {"pymetis"}
    monkeypatch.setattr(factors, "find_spec", lambda name: name if name in packages else None)
    assert structure.factor_method == structure.without_symmetry().factor_method == "superlu"
    monkeypatch.setattr(factors, "_LARGE", structure.dofs)
    assert structure.factor_method == "superlu"
    assert structure.without_symmetry().factor_method == "nested-dissection"
    packages.clear()
    assert structure.without_symmetry().factor_method == "superlu"
    for name in METHODS:
        assert chosen_method(name, structure.dofs, is_symmetric=False) == name
