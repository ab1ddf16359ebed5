"""Stability of periodic solutions against closed forms, the branch and shooting in time."""

from dataclasses import fields, replace

import numpy as np
import pytest
from folding_joint import DAMPING, WINDOW, make_folding_joint
from harmonic_names import parse_component
from periodic_orbits import find_orbit
from small_joint import make_joint

from boltjoint import dataset
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response import stability
from boltjoint.dynamics.response.branch import BranchError, OutputPoint
from boltjoint.dynamics.response.folds import FoldedBranch, find_folds
from boltjoint.dynamics.response.frequency_response import solve_branch, solve_response
from boltjoint.dynamics.response.response_file import to_dataset
from boltjoint.dynamics.response.stability import (
    StabilityOptions,
    find_stability,
    floquet_exponents,
    largest_multiplier,
)
from boltjoint.dynamics.response.windows import Resonance
from boltjoint.friction.aft import AlternatingFrequencyTime

#: normal load [N] and force [N] with which the contact opens (softening) or closes a gap
FOLDED = [(60.0, 5.0), (60.0, 10.0), (-20.0, 1.0)]


def folded(load, force, modes=2):
    """A branch that folds, with its joint, its balance and its folds."""
    joint = make_folding_joint(load, modes)
    branch = solve_branch(joint, force, damping=DAMPING, resonance=Resonance(1, WINDOW))
    folds = find_folds(branch.frequency)
    assert folds.turning_points == 2
    return joint, branch, HarmonicBalance(joint, DAMPING, force), folds


def exact_exponents(joint):
    """Exponents of the modes with viscous damping while the contact sticks."""
    modes = joint.natural_frequency.size
    w = 2 * np.pi * joint.natural_frequency
    stiffness = np.diag(w**2) + joint.stuck_stiffness()
    damping = np.diag(2 * DAMPING.damping_ratios[0] * w)
    return np.linalg.eigvals(np.block([[np.zeros((modes, modes)), np.eye(modes)],
                                       [-stiffness, -damping]]))  # fmt: skip


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_exponents_of_what_sticks_are_those_of_its_modes(law):
    joint = make_joint(law=law)
    balance = HarmonicBalance(joint, DAMPING, 1e-4)
    exact, w = exact_exponents(joint), 2 * np.pi * 130.0
    found = floquet_exponents(balance, balance.stuck_solution(w), w)
    # of the mean there are the exponents, of a harmonic those beside them by its frequency
    shifts = [0.0] if law == "variable" else []
    expected = np.concatenate([exact + 1j * shift * w for shift in (*shifts, -1.0, 1.0)])
    distance = abs(found[:, None] - expected)
    assert distance.min(axis=0).max() < 1e-9 * abs(exact).max()
    assert distance.min(axis=1).max() < 1e-9 * abs(exact).max()


def test_multiplier_of_a_linear_oscillator_is_its_decay_in_a_period():
    joint = make_folding_joint(1e6, modes=1)
    balance = HarmonicBalance(joint, DAMPING, 1.0)
    decay = 2 * np.pi * 50.0 * DAMPING.damping_ratios[0]
    # the last frequency is so far below the resonance that no exponent is near zero
    for frequency in (120.0, 140.0, 160.0, 20.0):
        w = 2 * np.pi * frequency
        found = largest_multiplier(balance, balance.stuck_solution(w), w)
        assert found == pytest.approx(np.exp(-decay / frequency), rel=1e-9)


@pytest.mark.parametrize("modes", [1, 2])
@pytest.mark.parametrize(("load", "force"), FOLDED)
def test_solutions_between_two_folds_are_unstable(load, force, modes):
    _, branch, balance, folds = folded(load, force, modes)
    everywhere = StabilityOptions(further_solutions=branch.frequency.size, harmonics=1)
    found = find_stability(balance, branch.frequency, branch.modal_coordinate, folds, everywhere)
    first, last = folds.at
    unstable = np.flatnonzero(found.stable == 0)
    # the turn itself lies between two solutions
    assert first <= unstable[0] <= first + 1
    assert last - 1 <= unstable[-1] <= last
    assert np.all(np.diff(unstable) == 1)
    assert np.all((found.largest_multiplier < 1) == (found.stable == 1))
    # a multiplier passes 1 there
    for turn in folds.at:
        around = found.largest_multiplier[turn - 1 : turn + 2]
        assert around.min() < 1 < around.max() or abs(around - 1).min() < 0.01


@pytest.mark.parametrize("modes", [1, 2])
@pytest.mark.parametrize(("load", "force"), FOLDED)
def test_marks_at_folds_are_those_of_the_motion_in_time(load, force, modes):
    joint, branch, of_one, folds = folded(load, force, modes)
    solutions = of_one, branch.frequency, branch.modal_coordinate, folds
    found = find_stability(*solutions)
    alone = find_stability(*solutions, StabilityOptions(harmonics=1))
    marked = found.stable >= 0
    assert (found.harmonics[marked] == 15).all()
    assert (found.harmonics[~marked] == 0).all()
    # one harmonic misplaces the turning points: that is where its marks are wrong
    differ = np.flatnonzero(marked & (alone.stable >= 0) & (found.stable != alone.stable))
    assert differ.size
    finer = FoldedBranch(*solutions, 15, 1024)
    picks = *differ[:: max(1, differ.size // 2)], int(folds.at.sum()) // 2
    for i in picks:
        frequency = branch.frequency[i]
        start = sampled(joint, finer.balance.components, finer.motion_of(i))
        exact = find_orbit(joint, frequency, force, DAMPING, start)
        assert exact.converged
        assert abs(exact.motion[0] - start[0]).max() < 0.02 * abs(start).max()
        largest = abs(exact.multipliers[0])
        assert (largest < 1) == (found.stable[i] == 1)
        # while an element only touches its limit of slip, that of stable ones has two values
        if largest > 1:
            assert found.largest_multiplier[i] == pytest.approx(largest, abs=5e-3)


def test_motions_with_more_harmonics_turn_elsewhere():
    _, branch, of_one, folds = folded(60.0, 5.0)
    found = find_stability(of_one, branch.frequency, branch.modal_coordinate, folds)
    low, high = found.frequency_range
    law = AlternatingFrequencyTime(of_one.joint.law, 15)
    of_many = solve_branch(
        replace(of_one.joint, law=law), 5.0, damping=DAMPING, resonance=Resonance(1, WINDOW)
    )
    expected = find_folds(of_many.frequency).frequency_range
    # both branches stop at solutions next to their turning points, of steps that are not the same
    assert (low, high) == pytest.approx(expected, rel=2e-3)
    assert abs(low - folds.frequency_range[0]) > 0.01 * low


def test_a_motion_belongs_to_the_solution_on_its_sheet():
    _, branch, of_one, folds = folded(60.0, 5.0)
    frequency, x = branch.frequency, branch.modal_coordinate
    finer = FoldedBranch(of_one, frequency, x, folds, 15, 256)
    # at a frequency between the turning points of both
    middle = (finer.frequency_range[0] + folds.frequency_range[1]) / 2
    first, last = folds.at
    sheets = (0, first), (first, last + 1), (last, frequency.size)
    places = [begin + int(np.argmin(abs(frequency[begin:end] - middle))) for begin, end in sheets]
    amplitudes = OutputPoint(finer.balance).amplitudes
    of_many = amplitudes(np.array([finer.motion_of(place) for place in places]))
    assert np.all(np.diff(branch.amplitude[places]) > 0)
    assert np.all(np.diff(of_many) > 0)
    # the same though a middle motion is nearer to an upper solution
    moved = x.copy()
    moved[places[2]] = x[places[1]]
    finer = FoldedBranch(of_one, frequency, moved, folds, 15, 256)
    assert amplitudes(finer.motion_of(places[2])[None])[0] == pytest.approx(of_many[2], rel=1e-6)


def test_responses_with_enough_harmonics_are_their_own_motion():
    of_one = folded(60.0, 5.0)[2]
    law = AlternatingFrequencyTime(of_one.joint.law, 5)
    balance = replace(of_one, joint=replace(of_one.joint, law=law))
    path = solve_branch(balance.joint, 5.0, damping=DAMPING, resonance=Resonance(1, WINDOW))
    folds = find_folds(path.frequency)
    solutions = balance, path.frequency, path.modal_coordinate, folds
    found = find_stability(*solutions, StabilityOptions(harmonics=5))
    marked = np.flatnonzero(found.stable >= 0)
    i = marked[marked.size // 2]
    w = 2 * np.pi * path.frequency[i]
    exact = largest_multiplier(balance, path.modal_coordinate[i], w)
    assert found.largest_multiplier[i] == exact
    assert (found.harmonics[marked] == 5).all()
    assert found.frequency_range == folds.frequency_range


def test_without_a_motion_stability_is_of_one_harmonic(monkeypatch):
    _, branch, of_one, folds = folded(60.0, 5.0)
    monkeypatch.setattr(FoldedBranch, "motion_of", lambda *_: None)
    solutions = of_one, branch.frequency, branch.modal_coordinate, folds
    found = find_stability(*solutions)
    marked = found.stable >= 0
    assert (found.harmonics[marked] == 1).all()
    i = int(folds.at.sum()) // 2
    w = 2 * np.pi * branch.frequency[i]
    assert found.largest_multiplier[i] == largest_multiplier(of_one, branch.modal_coordinate[i], w)


def test_few_exponents_are_the_nearest_of_all():
    joint, branch, _, folds = folded(60.0, 5.0)
    i = int(folds.at.sum()) // 2
    frequency, x = branch.frequency[i], branch.modal_coordinate[i]
    w = 2 * np.pi * frequency
    of_many, q = with_harmonics(joint, x, 5.0, w, 31)
    assert q.size > stability._FEW_UNKNOWNS
    by_iteration = largest_multiplier(of_many, q, w)
    exponents = floquet_exponents(of_many, q, w)
    kept = exponents[abs(exponents) <= 0.5 * w]
    assert by_iteration == pytest.approx(np.exp(2 * np.pi / w * kept.real.max()), rel=1e-9)


def test_stability_is_found_only_near_folds():
    _, branch, balance, folds = folded(60.0, 5.0)
    solutions = balance, branch.frequency, branch.modal_coordinate
    few = find_stability(*solutions, folds, StabilityOptions(further_solutions=3))
    low, high = folds.frequency_range
    inside = np.flatnonzero((branch.frequency >= low) & (branch.frequency <= high))
    sought = np.flatnonzero(few.stable >= 0)
    np.testing.assert_array_equal(sought, np.arange(inside[0] - 3, inside[-1] + 4))
    np.testing.assert_array_equal(np.isnan(few.largest_multiplier), few.stable == -1)
    none = find_stability(*solutions, find_folds(np.sort(branch.frequency)))
    assert (none.stable == -1).all()
    assert np.isnan(none.largest_multiplier).all()


def test_no_motion_is_sought_of_solutions_that_do_not_balance_all_modes(monkeypatch):
    joint, branch, balance, folds = folded(60.0, 5.0)
    solutions = balance, branch.frequency, branch.modal_coordinate, folds
    holds = np.arange(branch.frequency.size) < folds.at[1]
    every, some = find_stability(*solutions), find_stability(*solutions, holds=holds)
    assert (some.stable[~holds] == -1).all()
    np.testing.assert_array_equal(some.stable[holds], every.stable[holds])
    assert some.frequency_range == every.frequency_range
    monkeypatch.setattr(FoldedBranch, "__init__", None)
    # the estimated errors of all are beyond the limit
    wrong = [BranchError(np.full(holds.size, 0.06), 0.06, 0.06)]
    response = to_dataset(joint, [branch], DAMPING, wrong)
    assert (response["stable"] == -1).all()
    assert np.isnan(response["folded_from_converged"]).all()
    assert np.isfinite(response["folded_from"]).all()


def sampled(joint, components, x, samples=2000):
    """A period of the modal coordinates."""
    phase = 2 * np.pi * np.arange(samples) / samples
    motion = np.zeros((samples, joint.natural_frequency.size))
    for name, amplitude in zip(components, x.reshape(len(components), -1), strict=True):
        part, harmonic = parse_component(name)
        wave = np.sin if part == "sin" else np.cos
        motion += np.outer(wave(harmonic * phase), amplitude)
    return motion


def with_harmonics(joint, x, force, w, harmonics):
    """Balance of several harmonics, and its solution near one of one harmonic."""
    law = AlternatingFrequencyTime(joint.law, harmonics, samples=512)
    balance = HarmonicBalance(replace(joint, law=law), DAMPING, force)
    q = np.zeros((len(balance.components), joint.natural_frequency.size))
    of_one = x.reshape(len(joint.law.components), -1)
    for name, amplitude in zip(joint.law.components, of_one, strict=True):
        q[balance.components.index(name)] = amplitude
    q = q.ravel()
    for _ in range(30):
        residual, jacobian = balance.residual_and_jacobian(q, w)
        q = q - np.linalg.solve(jacobian(), residual)
        if np.linalg.norm(residual) < 1e-10 * force:
            break
    assert np.linalg.norm(residual) < 1e-10 * force
    return balance, q


@pytest.mark.parametrize(("load", "force"), FOLDED)
def test_multipliers_are_those_of_the_period_in_time(load, force):
    joint, branch, of_one, folds = folded(load, force)
    middle, above = int(folds.at.sum()) // 2, folds.at[1] + 20
    for i in (middle, above):
        frequency, x = branch.frequency[i], branch.modal_coordinate[i]
        w = 2 * np.pi * frequency
        of_many, q = with_harmonics(joint, x, force, w, 15)
        start = sampled(joint, of_many.components, q)
        exact = find_orbit(joint, frequency, force, DAMPING, start)
        assert exact.converged
        largest = abs(exact.multipliers[0])
        # 15 harmonics leave 0.1 % of what one leaves 3 %, as do 2000 steps
        many = largest_multiplier(of_many, q, w)
        assert many == pytest.approx(largest, abs=3e-3)
        if i == middle:
            assert largest > 1.1
            assert largest_multiplier(of_one, x, w) == pytest.approx(largest, abs=0.03)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_the_delay_of_sliders_is_part_of_the_multipliers(law, monkeypatch):
    many, force = make_joint(4, law=law), 8.0
    # one mode, so that all multipliers are those of its slow changes
    joint = replace(
        many,
        natural_frequency=many.natural_frequency[:1],
        excitation_mode=many.excitation_mode[:1],
        response_mode=many.response_mode[:1],
        tangential_mode=many.tangential_mode[:, :1],
        normal_mode=None if many.normal_mode is None else many.normal_mode[:, :1],
    )
    branch = solve_branch(joint, force, damping=DAMPING)
    frequency, x = branch.frequency[branch.peak], branch.modal_coordinate[branch.peak]
    w = 2 * np.pi * frequency
    balance, q = with_harmonics(joint, x, force, w, 9)
    start = sampled(joint, balance.components, q)
    exact = find_orbit(joint, frequency, force, DAMPING, start)
    assert exact.converged
    decay = np.log(abs(exact.multipliers[0]))
    with_delay = np.log(largest_multiplier(balance, q, w))
    monkeypatch.setattr(AlternatingFrequencyTime, "modal_slider_delay", lambda *_: 0.0)
    without = np.log(largest_multiplier(balance, q, w))
    # what is left is of second order in the decay of half a period
    assert with_delay == pytest.approx(decay, rel=0.02)
    assert abs(without - decay) > 0.1 * abs(decay)


def test_a_result_names_its_folds(tmp_path):
    joint = make_folding_joint()
    options, around = StabilityOptions(further_solutions=1), Resonance(1, WINDOW)
    branches = [
        solve_branch(joint, force, damping=DAMPING, resonance=around) for force in (5.0, 10.0, 60.0)
    ]
    found = to_dataset(joint, branches, DAMPING, stability=options)
    dataset.save(found, tmp_path / "response.nc")
    stored = dataset.load(tmp_path / "response.nc")
    np.testing.assert_array_equal(stored["turning_points"], [2, 2, 0])
    np.testing.assert_array_equal(stored["fold_force"], [5.0, 5.0, 10.0, 10.0])
    ends = np.sort(stored["fold_frequency"].to_numpy().reshape(2, 2), axis=1)
    np.testing.assert_array_equal(ends[:, 0], stored["folded_from"][:2])
    np.testing.assert_array_equal(ends[:, 1], stored["folded_to"][:2])
    for force, frequency, amplitude in zip(
        *(stored[f"fold_{name}"].to_numpy() for name in ("force", "frequency", "amplitude")),
        strict=True,
    ):
        mine = (stored["excitation_force"] == force) & (stored["frequency"] == frequency)
        assert amplitude in stored["response_amplitude"][mine.to_numpy()]
    unfolded = (stored["excitation_force"] == 60.0).to_numpy()
    assert (stored["stable"][unfolded] == -1).all()
    assert (stored["stable"] == 0).any()
    assert stored.attrs["stability"] == options.stored()
    assert (stored["isolated_branch"] == -1).all()


def test_a_result_without_folds_has_none(tmp_path):
    found = solve_response(make_joint(), [1.0], damping=0.01)
    dataset.save(found, tmp_path / "response.nc")
    stored = dataset.load(tmp_path / "response.nc")
    assert stored.sizes["fold"] == 0
    assert (stored["stable"] == -1).all()
    assert stored["largest_multiplier"].isnull().all()


@pytest.mark.parametrize("name", [field.name for field in fields(StabilityOptions)])
def test_options_out_of_range_are_refused(name):
    with pytest.raises(ValueError, match=name):
        StabilityOptions(**{name: -1})


def test_a_branch_without_solutions_has_none():
    balance = HarmonicBalance(make_folding_joint(), DAMPING, 1.0)
    nothing = np.zeros(0)
    found = find_stability(balance, nothing, np.zeros((0, 6)), find_folds(nothing))
    assert found.stable.size == found.largest_multiplier.size == 0


def test_what_is_no_solution_has_no_stability():
    _, branch, balance, folds = folded(60.0, 5.0)
    x = branch.modal_coordinate.copy()
    broken = int(folds.at.sum()) // 2
    x[broken] = np.inf
    found = find_stability(balance, branch.frequency, x, folds)
    assert found.stable[broken] == -1
    assert (found.stable[[broken - 1, broken + 1]] == 0).all()
