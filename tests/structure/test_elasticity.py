"""The brick element: rigid motion, patch test, bending, mass, and what it refuses."""

import numpy as np
import pytest
from examples import brick_bar
from scipy.sparse.linalg import eigsh, spsolve
from scipy.spatial.transform import Rotation

from boltjoint.structure.elasticity import (
    assemble,
    elasticity_matrix,
    element_stiffness,
    smallest_jacobian,
)

STEEL = {"youngs_modulus": 200e9, "poissons_ratio": 0.3, "density": 7800.0}


def distorted_cube(n=3, amount=0.15):
    """A unit cube of n^3 bricks whose inner nodes are moved about."""
    coordinate, connectivity = brick_bar(1.0, 1.0, 1.0, (n, n, n))
    inside = np.all(abs(coordinate - [0.5, 0, 0]) < 0.5 - 1e-9, axis=1)
    rng = np.random.default_rng(1)
    coordinate[inside] += amount / n * rng.uniform(-1, 1, (inside.sum(), 3))
    return coordinate, connectivity, inside


@pytest.fixture
def distorted_element():
    coordinate, _ = brick_bar(1.0, 1.0, 1.0, (1, 1, 1))
    order = [0, 2, 3, 1, 4, 6, 7, 5]  # nodes of one x stand together; corners turn around
    corners = coordinate[order] + 0.2 * np.random.default_rng(2).uniform(-1, 1, (8, 3))
    return corners[None]


def test_element_has_six_rigid_modes_and_no_others(distorted_element):
    K = element_stiffness(distorted_element, elasticity_matrix(1.0, 0.3))[0]
    x = distorted_element[0]
    rigid = [np.tile(axis, 8) for axis in np.eye(3)]
    rigid += [np.cross(axis, x).ravel() for axis in np.eye(3)]
    eigenvalue = np.linalg.eigvalsh(K)
    # rounding of entries of order one
    np.testing.assert_allclose(K @ np.transpose(rigid), 0, atol=1e-14)
    assert np.sum(eigenvalue < 1e-12) == 6
    assert eigenvalue[6] > 1e-3


def test_an_element_takes_a_law_in_any_form_of_array(distorted_element):
    D = elasticity_matrix(1.0, 0.3)
    K = element_stiffness(distorted_element, D)
    for given in (D.tolist(), D[None], D[None].tolist()):
        np.testing.assert_array_equal(element_stiffness(distorted_element, given), K)


def test_element_stiffness_turns_with_the_element(distorted_element):
    D = elasticity_matrix(1.0, 0.3)
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    T = np.kron(np.eye(8), turn)
    K, K_turned = (
        element_stiffness(x, D)[0] for x in (distorted_element, distorted_element @ turn.T)
    )
    np.testing.assert_allclose(K_turned, T @ K @ T.T, atol=1e-14)


def test_patch_test_on_a_distorted_mesh():
    coordinate, connectivity, inside = distorted_cube()
    K, _ = assemble(coordinate, connectivity, 1.0, 0.3, 1.0)
    gradient = np.array([[1.0, 0.3, -0.2], [0.5, -0.7, 0.4], [0.1, 0.6, 0.9]])
    exact = coordinate @ gradient.T
    free = np.repeat(inside, 3)
    u = np.where(free, 0.0, exact.ravel())
    u[free] = spsolve(K[free][:, free], -(K @ u)[free])
    # constant strain is met to rounding, whatever the shape of the elements
    np.testing.assert_allclose(u.reshape(-1, 3), exact, atol=1e-13)


def tip_deflection(length, width, height, elements, poissons_ratio=0.3):
    """Over that of Timoshenko's cantilever (shear coefficient of Cowper)."""
    coordinate, connectivity = brick_bar(length, width, height, elements)
    E, nu = 200e9, poissons_ratio
    K, _ = assemble(coordinate, connectivity, E, nu, 7800.0)
    free = np.repeat(coordinate[:, 0] > 0, 3)
    tip = np.flatnonzero(np.isclose(coordinate[:, 0], length))
    force = np.zeros(len(free))
    force[3 * tip + 2] = 1.0 / len(tip)
    u = np.zeros(len(free))
    u[free] = spsolve(K[free][:, free], force[free])
    bending = length**3 / (3 * E * width * height**3 / 12)
    shear_area = 10 * (1 + nu) / (12 + 11 * nu) * width * height
    shear = length / (E / (2 * (1 + nu)) * shear_area)
    return u[3 * tip + 2].mean() / (bending + shear)


def test_two_materials_in_series():
    length, area, E, rho = 0.3, 4e-4, np.array([70e9, 206e9]), np.array([2700.0, 7850.0])
    coordinate, connectivity = brick_bar(length, 0.02, 0.02, (6, 2, 2))
    beyond = (coordinate[connectivity].mean(axis=1)[:, 0] > length / 3).astype(int)
    K, M = assemble(coordinate, connectivity, E[beyond], 0.0, rho[beyond])
    lengths = length * np.array([1 / 3, 2 / 3])
    assert M.sum() / 3 == pytest.approx((rho * area * lengths).sum(), rel=1e-13)

    free = np.repeat(coordinate[:, 0] > 0, 3)
    at_end = np.isclose(coordinate[:, 0], length)
    y, z = coordinate[at_end, 1:].T
    share = np.where(np.isclose(abs(y), 0.01), 0.5, 1) * np.where(np.isclose(abs(z), 0.01), 0.5, 1)
    force = np.zeros((len(coordinate), 3))
    force[at_end, 0] = 5e3 * share / share.sum()
    u = spsolve(K[free][:, free], force.ravel()[free])
    # without lateral contraction the stress is uniform
    exact = 5e3 * (lengths / (E * area)).sum()
    np.testing.assert_allclose(u.reshape(-1, 3)[at_end[coordinate[:, 0] > 0], 0], exact, rtol=1e-11)


def test_one_material_of_all_or_of_each_element_is_the_same_to_the_bit():
    coordinate, connectivity = brick_bar(0.3, 0.02, 0.02, (6, 2, 2))
    of_each = {name: np.full(len(connectivity), value) for name, value in STEEL.items()}
    for one, other in zip(
        assemble(coordinate, connectivity, **STEEL),
        assemble(coordinate, connectivity, **of_each),
        strict=True,
    ):
        np.testing.assert_array_equal(one.toarray(), other.toarray())


@pytest.mark.parametrize(
    ("poissons_ratio", "tolerance"),
    # the support also prevents the contraction of the cross-section, which beam theory does not
    # know: 0.4 % on a fine mesh
    [(0.0, 1e-3), (0.3, 8e-3)],
)
def test_tip_deflection_of_a_cantilever(poissons_ratio, tolerance):
    found = tip_deflection(0.4, 0.02, 0.02, (40, 2, 2), poissons_ratio)
    assert found == pytest.approx(1, abs=tolerance)


@pytest.mark.parametrize("thickness", [4e-3, 1e-3, 0.25e-3])
def test_one_layer_of_thin_elements_does_not_lock(thickness):
    # a plain trilinear brick reaches 0.3, 0.02 and 0.001 of the deflection; the error left is that
    # of a cubic deflection by 20 parabolas: 1 / (4 * 20^2)
    assert tip_deflection(0.2, 0.01, thickness, (20, 1, 1), 0.0) == pytest.approx(1, abs=1e-3)


def test_bending_converges_with_the_square_of_the_element_length():
    # nu = 0, so that the support makes no singular stresses
    error = [abs(1 - tip_deflection(0.2, 0.01, 0.001, (n, 1, 1), 0.0)) for n in (5, 10, 20)]
    order = np.log2(np.divide(error[:-1], error[1:]))
    np.testing.assert_allclose(order, 2, atol=0.05)


def test_first_frequencies_of_a_cantilever():
    length, width, height = 0.4, 0.02, 0.024
    coordinate, connectivity = brick_bar(length, width, height, (32, 2, 3))
    K, M = assemble(coordinate, connectivity, **STEEL)
    free = np.repeat(coordinate[:, 0] > 0, 3)
    squared = eigsh(
        K[free][:, free], k=2, M=M[free][:, free], sigma=0.0, v0=np.ones(free.sum()), which="LM"
    )[0]
    found = np.sqrt(np.sort(squared)) / (2 * np.pi)
    # Euler and Bernoulli, about each of the two axes
    E, rho = STEEL["youngs_modulus"], STEEL["density"]
    exact = 1.8751**2 / (2 * np.pi * length**2) * np.sqrt(E / rho / 12) * np.array([width, height])
    # shear and rotary inertia, which the theory leaves out, lower the first by 3 (h / L)^2 about
    np.testing.assert_allclose(found, exact, rtol=5e-3)


def test_mass_is_that_of_the_volume():
    coordinate, connectivity, _ = distorted_cube()
    _, M = assemble(coordinate, connectivity, **STEEL)
    translation = np.tile(np.eye(3), (len(coordinate), 1))
    np.testing.assert_allclose(translation.T @ M @ translation, 7800.0 * np.eye(3), rtol=1e-12)


def test_matrices_are_symmetric_to_the_last_bit():
    coordinate, connectivity, _ = distorted_cube()
    for matrix in assemble(coordinate, connectivity, **STEEL):
        assert abs(matrix - matrix.T).max() == 0


def test_numbering_of_elements_does_not_matter():
    coordinate, connectivity, _ = distorted_cube()
    turned = np.random.default_rng(3).permutation(connectivity)
    for a, b in zip(
        assemble(coordinate, connectivity, **STEEL),
        assemble(coordinate, turned, **STEEL),
        strict=True,
    ):
        assert abs(a - b).max() <= 1e-14 * abs(a).max()


def test_refuses_elements_turned_inside_out():
    coordinate, connectivity = brick_bar(1.0, 1.0, 1.0, (2, 1, 1))
    connectivity[1] = connectivity[1][[4, 5, 6, 7, 0, 1, 2, 3]]
    assert smallest_jacobian(coordinate, connectivity)[1] < 0
    with pytest.raises(ValueError, match="1 elements are turned inside out, the first one is 1"):
        assemble(coordinate, connectivity, **STEEL)


def test_a_corner_that_is_folded_over_is_seen_where_no_gauss_point_tells():
    coordinate, connectivity = brick_bar(1.0, 1.0, 1.0, (1, 1, 1))
    node = connectivity[0, 6]
    # a corner on the plane through its three neighbours is flat, beyond it is folded over
    towards_middle = coordinate.mean(axis=0) - coordinate[node]
    flat = 2 / 3 * towards_middle
    for share, jacobian in ((0.9, 1.0), (1.1, -1.0)):
        moved = coordinate.copy()
        moved[node] += share * flat
        assert np.sign(smallest_jacobian(moved, connectivity)) == jacobian
    with pytest.raises(ValueError, match="1 elements are turned inside out"):
        assemble(moved, connectivity, **STEEL)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"coordinate": np.zeros((8, 2))}, r"coordinate .* expected \(nodes, 3\)"),
        ({"coordinate": np.full((8, 3), np.nan)}, "coordinate must be finite"),
        ({"connectivity": np.zeros((1, 20), int)}, r"connectivity .* expected \(elements, 8\)"),
        ({"connectivity": np.arange(8.0)[None]}, "connectivity must be an array of whole numbers"),
        ({"connectivity": np.arange(1, 9)[None]}, "connectivity must be at least 0 and below 8"),
        ({"connectivity": np.zeros((0, 8), int)}, "connectivity is empty"),
        ({"poissons_ratio": 0.5}, r"poissons_ratio is 0\.5: it must be above -1 and below 0\.5"),
        ({"youngs_modulus": np.inf}, "youngs_modulus is inf: it must be a finite number"),
        ({"density": -1.0}, r"density is -1\.0: it must be positive"),
    ],
)
def test_refuses_wrong_input(change, message):
    coordinate, connectivity = brick_bar(1.0, 1.0, 1.0, (1, 1, 1))
    with pytest.raises(ValueError, match=message):
        assemble(**{"coordinate": coordinate, "connectivity": connectivity, **STEEL, **change})
