from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import differential_evolution
from scipy.special import softmax
from small_joint import FRICTION, make_joint, make_preload

from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.fit_describing_function import DescribingFunctionMisfit
from boltjoint.joint.fit_loops import LoopMisfit
from boltjoint.joint.fitting import fit_elements
from boltjoint.joint.masing import amplitude_of_load, loading_curve, loop_error, unloading_branch
from boltjoint.joint.minimax_curve import minimax_loading_curve
from boltjoint.joint.model import merge_points
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import fit_reduced_joint
from boltjoint.verification.residual_in_time import forces_in_time


def many_elements(count=200):
    random = np.random.default_rng(4)
    return np.full(count, 1e8), random.gamma(0.8, 3.0, count) + 1e-3


def regions_of(joint, count):
    return partition_regions(joint, make_preload(joint), count)


def test_unloading_branch_has_the_harmonics_of_the_law():
    k, s = many_elements()
    amplitude = 5e-8
    phase = np.linspace(0, np.pi, 20001)
    force = unloading_branch(amplitude, amplitude * np.cos(phase), k, s)
    in_phase = 2 / np.pi * np.trapezoid(force * np.cos(phase), phase)
    quadrature = -2 / np.pi * np.trapezoid(force * np.sin(phase), phase)
    law = ConstantLoad(np.zeros(k.size, dtype=np.int64), k, s)
    # u = A cos: the sine coefficient is minus the part in phase with velocity
    expected = law.force(np.array([[0.0, amplitude]]))[0]
    np.testing.assert_allclose([-quadrature, in_phase], expected, rtol=1e-7)


def test_unloading_branch_closes_the_loop():
    k, s = many_elements()
    up, down = unloading_branch(1e-7, np.array([1e-7, -1e-7]), k, s)
    assert up == pytest.approx(-down)
    assert up == pytest.approx(loading_curve(np.array(1e-7), k, s))


def test_amplitude_of_load_inverts_the_loading_curve():
    k, s = many_elements()
    for fraction in (0.1, 0.5, 0.99):
        amplitude = amplitude_of_load(fraction, k, s)
        assert loading_curve(np.array(amplitude), k, s) == pytest.approx(fraction * s.sum())


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_totals_hold_and_parameters_are_positive(method):
    k, s = many_elements()
    fit = fit_elements(k, s, 4, method=method)
    assert fit.tangential_stiffness.sum() == pytest.approx(k.sum(), rel=1e-12)
    assert fit.slip_force.sum() == pytest.approx(s.sum(), rel=1e-12)
    assert np.all(fit.tangential_stiffness > 0)
    assert np.all(fit.slip_force > 0)


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_few_elements_are_found_again(method):
    k, s = np.array([1e8, 2e8, 3e8]), np.array([5.0, 30.0, 150.0])
    fit = fit_elements(np.repeat(k / 50, 50), np.repeat(s / 50, 50), 3, method=method)
    np.testing.assert_allclose(fit.tangential_stiffness, k, rtol=1e-5)
    np.testing.assert_allclose(fit.slip_force, s, rtol=1e-5)
    assert fit.cost < 1e-8 * s.sum() ** 2


def test_more_elements_fit_better():
    k, s = many_elements()
    costs = [fit_elements(k, s, count).cost for count in (1, 2, 4, 7)]
    assert np.all(np.diff(costs) < 0)


def test_more_starts_are_never_worse():
    k, s = many_elements()
    assert fit_elements(k, s, 7, starts=16).cost <= fit_elements(k, s, 7, starts=1).cost


def test_cost_is_the_squared_difference_of_both_halves_of_all_loops():
    k, s = many_elements()
    fit = fit_elements(k, s, 4)
    phase = np.linspace(0, np.pi, 64)
    half = 0.0
    for amplitude in fit.amplitude:
        u = amplitude * np.cos(phase)
        difference = unloading_branch(amplitude, u, k, s) - unloading_branch(
            amplitude, u, fit.tangential_stiffness, fit.slip_force
        )
        half += difference @ difference
    assert fit.cost == pytest.approx(2 * half, rel=1e-9)


def test_jacobian_equals_differences():
    k, s = many_elements()
    loops = LoopMisfit(k, s, np.array([1e-8, 5e-8, 2e-7]))
    unknown = np.array([0.1, -0.4, 0.3, 0.0, 0.5, -0.2, 0.1, 0.7])
    for j in range(unknown.size):
        step = np.zeros(unknown.size)
        step[j] = 1e-6
        difference = (loops.residual(unknown + step) - loops.residual(unknown - step)) / 2e-6
        np.testing.assert_allclose(loops.jacobian(unknown)[:, j], difference, atol=1e-8)


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_fit_does_not_depend_on_units(method):
    k, s = many_elements()
    fit, scaled = (fit_elements(k * by, s / by, 4, method=method) for by in (1, 1e-3))
    np.testing.assert_allclose(scaled.slip_force, fit.slip_force * 1e3, rtol=1e-4)
    np.testing.assert_allclose(
        scaled.tangential_stiffness, fit.tangential_stiffness * 1e-3, rtol=1e-4
    )


def test_more_elements_than_the_region_has_are_refused():
    with pytest.raises(ValueError, match="cannot fit 4 elements to the 3 of a region"):
        fit_elements(np.ones(3), np.ones(3), 4)


def test_unknown_method_is_refused():
    with pytest.raises(ValueError, match="'magic' is not known; allowed: loops, describing-fun"):
        fit_elements(np.ones(3), np.ones(3), 2, method="magic")


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_reduced_joint_keeps_points_and_the_totals_of_what_carries_load(law):
    regions = regions_of(make_joint(law=law), 3)
    reduced, fit = fit_reduced_joint(regions, 2)
    for one, other in zip(reduced.rows, regions.rows, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(reduced.law.point_of_element, [0, 0, 1, 1, 2, 2])
    np.testing.assert_array_equal(reduced.element_position, regions.position[[0, 0, 1, 1, 2, 2]])
    closed = regions.law.slip_force > 0
    names = {"slip_force", *regions.law.quantities} - {"friction_coefficient"}
    for name in names:
        np.testing.assert_allclose(
            np.bincount(reduced.law.point_of_element, getattr(reduced.law, name)),
            np.bincount(regions.law.point_of_element, getattr(regions.law, name) * closed),
        )
    assert fit["loop_force_of_fit"].dims == ("point", "loop", "sample")
    assert fit.sizes["loop"] == 3


def test_elements_without_load_take_no_part_in_a_fit():
    regions = regions_of(make_joint(law="variable"), 3)
    law = regions.law
    reduced, dataset = fit_reduced_joint(regions, 4)
    for region in range(3):
        mine = (law.point_of_element == region) & (law.normal_load > 0)
        assert np.any((law.point_of_element == region) & ~mine)
        fit = fit_elements(law.tangential_stiffness[mine], law.slip_force[mine], 4)
        fitted = reduced.law.point_of_element == region
        np.testing.assert_array_equal(
            reduced.law.tangential_stiffness[fitted], fit.tangential_stiffness
        )
        np.testing.assert_allclose(reduced.law.slip_force[fitted], fit.slip_force, rtol=1e-14)
        assert dataset["fit_cost"][region] == fit.cost
    assert np.all(reduced.law.normal_load > 0)


def test_fitted_elements_keep_the_ratios_of_stiffness_and_of_friction():
    joint = make_joint(law="variable")
    equal = replace(joint.law, normal_stiffness=joint.law.tangential_stiffness)
    reduced, _ = fit_reduced_joint(regions_of(replace(joint, law=equal), 3), 4)
    law = reduced.law
    np.testing.assert_allclose(law.normal_stiffness, law.tangential_stiffness, rtol=1e-14)
    np.testing.assert_allclose(law.friction_coefficient, FRICTION, rtol=1e-14)
    np.testing.assert_allclose(law.normal_load, law.slip_force / FRICTION, rtol=1e-14)
    # that of the joint is 2
    law = fit_reduced_joint(regions_of(joint, 3), 4)[0].law
    np.testing.assert_allclose(law.normal_stiffness, 2 * law.tangential_stiffness, rtol=1e-14)


def test_a_region_of_fewer_elements_than_are_asked_for_is_named():
    few = merge_points(make_joint(), np.repeat([0, 1], [57, 3]))
    fit_reduced_joint(few, 3)
    with pytest.raises(ValueError, match="cannot fit 4 elements to region 2, which has 3 under lo"):
        fit_reduced_joint(few, 4)


def test_open_elements_do_not_make_a_region_large_enough():
    joint = make_joint(law="variable")
    load = joint.law.normal_load.copy()
    load[2:20] = -1.0
    opened = replace(joint, law=replace(joint.law, normal_load=load))
    regions = merge_points(opened, np.repeat([0, 1], [20, 40]))
    with pytest.raises(ValueError, match="to region 1, which has 2 under load: ask for fewer"):
        fit_reduced_joint(regions, 3)


def test_harmonics_of_a_fit_hold_between_the_fitted_amplitudes():
    k, s = many_elements()
    fit = fit_elements(k, s, 7)
    amplitude = float(np.sqrt(fit.amplitude[0] * fit.amplitude[1]))

    def marched(stiffness, slip):
        together = np.zeros(slip.size, dtype=np.int64)
        return forces_in_time(together, stiffness, slip, np.array([[amplitude, 0.0]]), 2000)[0]

    true = marched(k, s)
    few = marched(fit.tangential_stiffness, fit.slip_force)
    # seven corners in place of two hundred: a per cent of the force
    assert np.linalg.norm(few - true) < 0.01 * np.linalg.norm(true)


def curve_error(fitted_k, fitted_s, k, s):
    """Differences of the loading curves over that of the region, at all corners of both."""
    u = np.sort(np.concatenate([fitted_s / fitted_k, s / k]))
    force = loading_curve(u, k, s)
    return u, (loading_curve(u, fitted_k, fitted_s) - force) / force


@pytest.mark.parametrize("count", [2, 3])
def test_no_loading_curve_is_nearer(count):
    k, s = many_elements(15)
    *nearest, ratio = minimax_loading_curve(k, s, count)

    def error(logs):
        a, b = np.split(logs, 2)
        return np.abs(curve_error(k.sum() * softmax(a), s.sum() * softmax(b), k, s)[1]).max()

    # the first of each kind is left at zero: shares have one degree of freedom less
    free = np.delete(np.arange(2 * count), [0, count])

    def error_of_free(x):
        logs = np.zeros(2 * count)
        logs[free] = x
        return error(logs)

    found = differential_evolution(
        error_of_free, [(-6, 6)] * free.size, seed=1, tol=1e-10, maxiter=400, popsize=20
    )
    assert ratio == pytest.approx(error(np.log(np.concatenate(nearest))), rel=1e-9)
    # the search among all curves comes as close as it can, and not below
    assert ratio * (1 - 1e-9) <= found.fun <= 1.01 * ratio


def test_minimax_loading_curve_errs_as_much_above_as_below_in_turn():
    k, s = many_elements()
    fitted_k, fitted_s, ratio = minimax_loading_curve(k, s, 5)
    u, error = curve_error(fitted_k, fitted_s, k, s)
    corners = fitted_s / fitted_k
    np.testing.assert_allclose(error[np.isin(u, corners)], ratio, rtol=1e-9)
    for low, high in pairwise(corners):
        assert error[(u > low) & (u < high)].min() == pytest.approx(-ratio, rel=1e-9)


@pytest.mark.parametrize("sharpness", [8.0, np.inf])
def test_minimax_loading_curves_keep_the_totals_and_come_nearer_with_more_elements(sharpness):
    k, s = many_elements()
    ratios = []
    for count in (1, 2, 4, 7, 12):
        fitted_k, fitted_s, ratio = minimax_loading_curve(k, s, count, sharpness)
        assert fitted_k.size == count
        assert np.all(fitted_k > 0)
        assert fitted_k.sum() == pytest.approx(k.sum(), rel=1e-9)
        assert fitted_s.sum() == pytest.approx(s.sum(), rel=1e-9)
        ratios.append(ratio)
    # the error of chords falls with the square of their number
    assert np.all(np.diff(ratios) < 0)
    assert ratios[-1] < 2 * ratios[1] * (2 / 12) ** 2


def test_minimax_loading_curve_is_the_curve_with_as_many_corners_as_it_has():
    k, s = np.array([1e8, 2e8, 3e8]), np.array([5.0, 30.0, 150.0])
    fitted_k, fitted_s, ratio = minimax_loading_curve(np.repeat(k / 9, 9), np.repeat(s / 9, 9), 5)
    assert ratio == 0
    np.testing.assert_allclose(fitted_k, [1e8, 2e8, 1e8, 1e8, 1e8], rtol=1e-9)
    np.testing.assert_allclose(fitted_s, [5, 30, 50, 50, 50], rtol=1e-9)


def test_minimax_loading_curve_does_not_depend_on_units():
    k, s = many_elements()
    *one, ratio = minimax_loading_curve(k, s, 4)
    *other, same = minimax_loading_curve(1e-3 * k, 1e3 * s, 4)
    assert same == pytest.approx(ratio, rel=1e-10)
    # the corners follow from a bisection to 1e-12
    np.testing.assert_allclose(other[0], 1e-3 * one[0], rtol=1e-8)
    np.testing.assert_allclose(other[1], 1e3 * one[1], rtol=1e-8)


def test_jacobian_of_harmonics_equals_differences():
    k, s = many_elements()
    harmonics = DescribingFunctionMisfit(k, s, 0.1)
    unknown = np.array([0.1, -0.4, 0.3, 0.0, 0.5, -0.2, 0.1, 0.7])
    for j in range(unknown.size):
        step = np.zeros(unknown.size)
        step[j] = 1e-6
        difference = (
            harmonics.residual(unknown + step) - harmonics.residual(unknown - step)
        ) / 2e-6
        jacobian = harmonics.jacobian(unknown)[:, j]
        # the derivative of the loss jumps where an element begins to slip
        np.testing.assert_allclose(jacobian, difference, atol=1e-6 * np.abs(jacobian).max())


def test_harmonics_compared_are_those_of_the_law():
    k, s = many_elements()
    harmonics = DescribingFunctionMisfit(k, s, 0.1)
    law = ConstantLoad(np.arange(k.size), k, s)
    for i in (0, 60, 119):
        amplitude = harmonics.amplitude[i]
        force = law.force(np.tile([amplitude, 0.0], (k.size, 1))).sum(axis=0)
        found = harmonics._target[[i, i + harmonics.amplitude.size]] * amplitude
        np.testing.assert_allclose(found, force, rtol=1e-10, atol=1e-12 * s.sum())


def test_loop_error_is_found_on_the_loops():
    k, s = many_elements()
    fit = fit_elements(k, s, 4)
    few = fit.tangential_stiffness, fit.slip_force
    error = loop_error(k, s, *few)
    onset = s / k
    phase = np.pi * (np.arange(64) + 0.5) / 64
    largest, squares = 0.0, []
    for amplitude in np.geomspace(onset.min(), onset.max(), 120):
        for u in (amplitude * np.cos(phase), amplitude * np.linspace(-1, 1, 1000)):
            many, fitted = (unloading_branch(amplitude, u, *one) for one in ((k, s), few))
            difference = (fitted - many) / s.sum()
            largest = max(largest, np.abs(difference).max())
            if u.size == phase.size:
                squares.append(difference**2)
    assert error.rms == pytest.approx(np.sqrt(np.mean(squares)), rel=1e-9)
    # the largest of the loops that were tried is that of some other amplitude at best
    assert 0.95 * error.largest < largest <= error.largest * (1 + 1e-9)


def test_loops_of_the_same_elements_do_not_differ():
    k, s = many_elements()
    error = loop_error(k, s, 2 * k[::2], s[::2] + s[1::2])
    assert error.largest > error.rms > 0
    same = loop_error(k, s, k[::-1], s[::-1])
    assert same.largest < 1e-13


@pytest.mark.parametrize("count", [4, 7])
def test_describing_functions_fit_loops_of_all_amplitudes_better_than_three_loops_do(count):
    k, s = many_elements()
    errors = []
    for method in ("loops", "describing-function"):
        fit = fit_elements(k, s, count, method=method)
        errors.append(loop_error(k, s, fit.tangential_stiffness, fit.slip_force))
    assert errors[1].largest < errors[0].largest
    assert errors[1].rms < errors[0].rms


@pytest.mark.parametrize("method", ["loops", "describing-function"])
def test_dataset_of_a_fit_has_its_loop_errors(method):
    regions = regions_of(make_joint(), 3)
    reduced, dataset = fit_reduced_joint(regions, 4, method=method)
    for point in range(3):
        of = [law.point_of_element == point for law in (regions.law, reduced.law)]
        elements = [
            values[mine]
            for law, mine in zip((regions.law, reduced.law), of, strict=True)
            for values in (law.tangential_stiffness, law.slip_force)
        ]
        error = loop_error(*elements)
        assert dataset["largest_loop_error"][point] == error.largest
        assert dataset["rms_loop_error"][point] == error.rms
        fit = fit_elements(*elements[:2], 4, method=method)
        np.testing.assert_array_equal(elements[2], fit.tangential_stiffness)
