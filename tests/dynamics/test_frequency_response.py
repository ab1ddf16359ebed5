from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from small_joint import make_joint

from boltjoint import dataset
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.response.frequency_response import method_of, solve_branch, solve_response
from boltjoint.dynamics.response.methods import ResponseDependentModes
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.bands import bands_of_equal_load
from boltjoint.joint.derived import merge_points
from boltjoint.solvers.newton import newton
from boltjoint.solvers.step_control import StepControl
from boltjoint.study.timing import Timed

LOSS = 0.01


def linear_response(joint, frequency, stiffness, force):
    """Complex response of the linear structure with extra modal stiffness, one by one."""
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2) + 0j
    out = []
    for f in frequency:
        dynamic = L * (1 + 1j * LOSS) + stiffness - (2 * np.pi * f) ** 2 * np.eye(len(L))
        out.append(joint.response_mode @ np.linalg.solve(dynamic, joint.excitation_mode * force))
    return np.array(out)


def test_window_spans_from_free_to_stuck(joint):
    low, high = frequency_window(joint)
    L = np.diag((2 * np.pi * joint.natural_frequency) ** 2)
    stuck = np.sqrt(np.linalg.eigvalsh(L + joint.stuck_stiffness())) / (2 * np.pi)
    assert (low, high) == pytest.approx((0.85 * 70.0, 1.05 * stuck[0]))
    assert frequency_window(joint, resonance=2) == pytest.approx((0.85 * 360.0, 1.05 * stuck[1]))


def test_window_of_several_joints_spans_all_of_theirs(joint):
    stiffer = replace(joint, law=replace(joint.law, tangential_stiffness=np.full(60, 1e8)))
    low, high = frequency_window(joint, stiffer)
    assert low == frequency_window(joint)[0]
    assert high == frequency_window(stiffer)[1] > frequency_window(joint)[1]


def test_a_window_that_cannot_hold_the_resonance_is_refused(joint):
    assert frequency_window(joint, given=(60.0, 71.0)) == (60.0, 71.0)
    for given in [(20.0, 69.0), (200.0, 250.0)]:
        with pytest.raises(ValueError, match="contains no resonance 1: it lies between 70 Hz"):
            frequency_window(joint, given=given)


def test_a_resonance_that_the_force_does_not_excite_is_refused(joint):
    stiffness = np.diag((2 * np.pi * joint.natural_frequency) ** 2) + joint.stuck_stiffness()
    stuck = np.linalg.eigh(stiffness)[1]
    # at a node of the second stuck mode
    blind = replace(joint, excitation_mode=stuck[:, 0] + stuck[:, 2])
    for solve in (
        lambda: solve_branch(blind, 1.0, damping=LOSS, resonance=2),
        lambda: solve_response(blind, [1.0], damping=LOSS, resonance=2),
    ):
        with pytest.raises(ValueError, match=r"this force does not excite .* in resonance 2"):
            solve()
    assert solve_branch(blind, 1.0, damping=LOSS).complete


def test_rounding_beside_the_output_point_is_no_excitation(joint):
    # as where the force acts across a symmetric structure
    noise = 1e-10 * np.array([1.0, -0.3, 0.2])
    with pytest.raises(ValueError, match="this force does not excite the selected modes"):
        solve_branch(replace(joint, excitation_mode=noise), 1.0, damping=LOSS)


def test_a_weak_excitation_is_one(joint):
    weak = replace(joint, excitation_mode=1e-6 * joint.excitation_mode)
    branch, same = (
        solve_branch(each, force, damping=LOSS) for each, force in ((weak, 1e6), (joint, 1.0))
    )
    # the same force on the modes, but for rounding
    np.testing.assert_allclose(branch.amplitude[branch.peak], same.amplitude[same.peak], rtol=1e-9)


def test_of_two_modes_of_one_frequency_the_force_excites_one_combination(joint):
    # two modes without contact: any combination of them is a mode, and one is excited
    pair = replace(
        joint,
        natural_frequency=np.array([70.0, 70.0, 950.0]),
        tangential_mode=joint.tangential_mode * [0.0, 0.0, 1.0],
        excitation_mode=np.array([1.0, 0.0, 1.0]),
    )
    for resonance in (1, 2):
        pair.check_excitation(resonance)


@pytest.mark.parametrize("resonance", [0, 4])
def test_window_needs_a_mode(joint, resonance):
    with pytest.raises(
        ValueError, match=f"resonance is {resonance}: it must be at least 1 and at most 3"
    ):
        frequency_window(joint, resonance=resonance)


@pytest.mark.parametrize("coordinates", ["linear", "rdnm-3"])
def test_while_all_sticks_the_response_is_linear(joint, coordinates):
    branch = solve_branch(joint, 1e-4, method=coordinates, damping=LOSS)
    assert branch.complete
    expected = np.abs(linear_response(joint, branch.frequency, joint.stuck_stiffness(), 1e-4))
    # residuals below 1e-9 of the force, amplified at most by the resonance
    np.testing.assert_allclose(branch.amplitude, expected, rtol=1e-6)


def test_without_friction_the_response_is_that_of_the_free_structure(joint):
    slippery = replace(joint, law=replace(joint.law, slip_force=joint.law.slip_force * 1e-9))
    branch = solve_branch(slippery, 10.0, damping=LOSS)
    assert branch.complete
    expected = np.abs(linear_response(joint, branch.frequency, 0.0, 10.0))
    np.testing.assert_allclose(branch.amplitude, expected, rtol=1e-5)


def test_energy_balances(joint):
    """Work of the excitation in a period equals friction plus structural loss."""
    force = 20.0
    branch = solve_branch(joint, force, damping=LOSS)
    x = branch.modal_coordinate[branch.peak]
    sine, cosine = np.split(x, 2)
    balance = HarmonicBalance(joint, LOSS, force)
    motion = balance.motion(x)
    amplitude = np.hypot(*motion.T)
    k, slip = joint.law.tangential_stiffness, joint.law.slip_force
    friction = 4 * np.maximum(amplitude - slip / k, 0) @ slip
    structural = np.pi * LOSS * np.diag(balance.stiffness) @ (sine**2 + cosine**2)
    work = -np.pi * force * joint.excitation_mode @ cosine
    assert work == pytest.approx(friction + structural, rel=1e-8)


def test_peak_is_located_not_sampled(joint):
    coarse = solve_branch(joint, 5.0, damping=LOSS, control=StepControl(largest_step=0.3))
    fine = solve_branch(joint, 5.0, damping=LOSS, control=StepControl(largest_step=0.015))
    assert coarse.located[coarse.peak]
    assert coarse.frequency.size < fine.frequency.size / 5
    assert coarse.frequency[coarse.peak] == pytest.approx(fine.frequency[fine.peak], rel=1e-6)
    assert coarse.amplitude[coarse.peak] == pytest.approx(fine.amplitude[fine.peak], rel=1e-9)


def test_analytic_and_forward_difference_jacobian_give_the_same_branch(joint):
    one, other = (
        solve_branch(joint, 5.0, method=method_of("linear", jacobian=jacobian), damping=LOSS)
        for jacobian in ("analytic", "forward-difference")
    )
    assert other.complete
    assert one.frequency[one.peak] == pytest.approx(other.frequency[other.peak], rel=1e-6)
    assert one.amplitude[one.peak] == pytest.approx(other.amplitude[other.peak], rel=1e-6)


def test_all_response_dependent_modes_together_are_the_linear_ones(joint):
    full = solve_branch(joint, 5.0, damping=LOSS)
    same = solve_branch(joint, 5.0, method="rdnm-3", damping=LOSS)
    assert same.amplitude[same.peak] == pytest.approx(full.amplitude[full.peak], rel=1e-8)


def test_one_response_dependent_mode_is_close_while_little_slips(joint):
    full, one = (
        solve_branch(joint, 0.05, method=coordinates, damping=LOSS)
        for coordinates in ("linear", "rdnm-1")
    )
    assert one.complete
    assert one.frequency[one.peak] == pytest.approx(full.frequency[full.peak], rel=2e-3)
    assert one.amplitude[one.peak] == pytest.approx(full.amplitude[full.peak], rel=2e-2)


@pytest.mark.parametrize(
    ("coordinates", "basis_update", "tolerance"),
    [
        # the modes are those of the maximum itself, which is located within 1e-6 of a step
        ("rdnm-1", "implicit", (1e-8, 1e-8)),
        # corrected in all linear modes
        ("complex-rdnm-1", "implicit", (1e-8, 1e-8)),
        # updated at the maximum until that changes the motion by 1e-6, from steps whose lag varies
        ("complex-rdnm-1", "lagged", (1e-7, 1e-6)),
        # updated between solutions, within an arc of 1e-3, over which the mode lags behind
        ("rdnm-1", "lagged", (1e-4, 1e-3)),
    ],
)
@pytest.mark.parametrize("force", [1.0, 5.0])
def test_peak_of_a_response_dependent_mode_does_not_depend_on_the_step(
    joint, coordinates, basis_update, tolerance, force
):
    coarse, fine = (
        solve_branch(
            joint,
            force,
            method=method_of(coordinates, basis_update=basis_update),
            damping=LOSS,
            resonance=Resonance(1, (90.0, 180.0)),
            control=StepControl(largest_step=step),
        )
        for step in (0.16, 0.04)
    )
    assert coarse.complete
    assert fine.complete
    assert coarse.frequency.size < 0.3 * fine.frequency.size
    by_frequency, by_amplitude = tolerance
    assert coarse.frequency[coarse.peak] == pytest.approx(
        fine.frequency[fine.peak], rel=by_frequency
    )
    assert coarse.amplitude[coarse.peak] == pytest.approx(
        fine.amplitude[fine.peak], rel=by_amplitude
    )


def test_lagged_modes_are_less_accurate(joint):
    within, after = (
        solve_branch(joint, 5.0, ResponseDependentModes(1, True, is_lagged), damping=LOSS)
        for is_lagged in (False, True)
    )
    equations = BalanceEquations(HarmonicBalance(joint, LOSS, 5.0))
    left = [
        np.median(
            [
                np.linalg.norm(equations.evaluate(q, 2 * np.pi * f)[0])
                for q, f in zip(branch.modal_coordinate, branch.frequency, strict=True)
            ]
        )
        for branch in (within, after)
    ]
    assert within.complete
    assert after.complete
    # corrected to the tolerance, and predicted but for the ends and the peak
    assert left[0] < 1e-8 * equations.residual_scale < 1e-2 * left[1]
    assert within.in_all_modes.sum() < 0.1 * within.frequency.size
    assert not after.in_all_modes.any()


def test_without_the_quasi_static_correction_one_mode_responds(joint):
    options = {"damping": LOSS, "resonance": Resonance(1, (90.0, 180.0))}
    without = ResponseDependentModes(1, is_complex=True, quasi_static_correction=False)
    branch = solve_branch(joint, 1e-6, without, **options)
    balance = HarmonicBalance(joint, LOSS, 1e-6)
    sine, cosine = branch.modal_coordinate[branch.peak].reshape(2, -1)
    motion = sine + 1j * cosine
    # all sticks: the real mode of the stuck joint, of any phase
    stuck = np.linalg.eigh(balance.stiffness + joint.stuck_stiffness())[1][:, 0]
    share = abs(stuck @ motion) / np.linalg.norm(motion)
    # but for what structural damping adds to it
    assert share == pytest.approx(1, abs=1e-6)
    other = solve_branch(joint, 1e-6, "complex-rdnm-1", **options)
    ratio = other.amplitude[other.peak] / branch.amplitude[branch.peak]
    assert abs(ratio - 1) > 1e-6


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_a_complex_mode_shows_the_peak_that_a_real_one_misses(law):
    joint, control = make_joint(law=law), StepControl(largest_step=0.16)
    full, real, one = (
        solve_branch(joint, 5.0, method=coordinates, damping=LOSS, control=control)
        for coordinates in ("linear", "rdnm-1", "complex-rdnm-1")
    )
    exact = full.frequency[full.peak], full.amplitude[full.peak]
    # with what the other modes do under the force it predicts the whole motion
    assert one.frequency[one.peak] == pytest.approx(exact[0], rel=1e-8)
    assert one.amplitude[one.peak] == pytest.approx(exact[1], rel=1e-8)
    assert one.in_all_modes.mean() < 0.2
    assert abs(real.frequency[real.peak] / exact[0] - 1) > 2e-3
    assert abs(real.amplitude[real.peak] / exact[1] - 1) > 1e-3


@pytest.mark.parametrize(("coordinates", "corrections"), [("linear", 3), ("rdnm-2", 12)])
def test_load_stepping_starts_where_the_stuck_solution_is_too_far(coordinates, corrections):
    joint, force, start = make_joint(law="variable"), 500.0, 90.0
    balance, w = HarmonicBalance(joint, LOSS, force), 2 * np.pi * start
    control = StepControl(largest_step=0.14, maximum_iterations=corrections)
    stuck = balance.stuck_solution(w)
    equations = method_of(coordinates).formulate(balance, 1)
    assert not newton(equations, stuck, w, control)[0].converged
    # above the start; and from below, to where the path above must begin
    raised, other = (
        solve_branch(
            joint,
            force,
            method=coordinates,
            damping=LOSS,
            resonance=Resonance(1, window),
            control=control,
        )
        for window in ((start, 95.0), (70.0, start))
    )
    assert raised.complete
    assert raised.converged.all()
    assert other.complete
    np.testing.assert_allclose(
        raised.modal_coordinate[0],
        other.modal_coordinate[-1],
        atol=1e-7 * np.abs(other.modal_coordinate[-1]).max(),
    )


@pytest.mark.parametrize(
    "coordinates",
    [
        "linear",
        "rdnm-1",
        "rdnm-2",
        "complex-rdnm-1",
        ResponseDependentModes(1, is_complex=True, is_lagged=True),
    ],
)
def test_file_holds_the_energy_error(coordinates):
    response = solve_response(
        make_joint(law="variable"),
        [5.0],
        method=coordinates,
        damping=LOSS,
        resonance=Resonance(1, (80.0, 110.0)),
        control=StepControl(largest_step=0.2),
    )
    error = np.abs(response["energy_error"])
    assert error.sizes == {"solution": response.sizes["solution"]}
    # input and dissipation balance in any space that holds the motion, to residuals of 1e-9 of a
    # force that stands up to a hundred times above its share in phase with the velocity
    if not getattr(coordinates, "is_lagged", False):
        assert error.max() < 1e-6
    # complex modes and what they leave out hold the motion only as far as they have been updated
    else:
        assert 1e-6 < error.max() < 1e-2


@pytest.mark.parametrize("coordinates", ["linear", "rdnm-1"])
def test_a_branch_may_start_from_a_solution_that_is_known(joint, coordinates):
    whole = solve_branch(joint, 5.0, method=coordinates, damping=LOSS)
    first, last = whole.peak - 12, whole.peak + 12
    near = solve_branch(
        joint,
        5.0,
        method=coordinates,
        damping=LOSS,
        resonance=Resonance(1, (whole.frequency[first], whole.frequency[last])),
        start=whole.modal_coordinate[first],
    )
    assert near.complete
    np.testing.assert_allclose(near.amplitude[0], whole.amplitude[first], rtol=1e-4)
    # the peak is located within 1e-6 of a step, or an arc of 1e-3 over which a mode may lag behind
    assert near.frequency[near.peak] == pytest.approx(whole.frequency[whole.peak], rel=1e-4)
    # steps are as long as in the whole window
    assert abs(near.frequency.size - (last - first)) <= 6


def test_a_synthesised_response_has_no_start(joint):
    with pytest.raises(ValueError, match="synthesised from the backbone has no start"):
        solve_branch(joint, 1.0, method="backbone", damping=LOSS, start=np.zeros(6))


def test_without_a_resonance_in_the_window_there_is_no_peak(joint):
    response = solve_response(joint, [1e-4], damping=LOSS, resonance=Resonance(1, (10.0, 40.0)))
    assert response["complete"].all()
    assert response["peak_frequency"].isnull().all()
    assert response["peak_amplitude"].isnull().all()
    assert (response["contact_state"] == -1).all()


def test_a_start_without_solution_has_no_peak(joint):
    # too few corrections where the contact slips, and solutions while the force is raised
    control = StepControl(maximum_iterations=1, maximum_solutions=3)
    response = solve_response(joint, [2e4], damping=LOSS, control=control)
    assert not response["converged"].any()
    assert response["peak_amplitude"].isnull().all()
    assert response["reason"].item() == "no solution found at the start of the window"


def test_a_region_of_one_element_is_the_pair(joint):
    regions = merge_points(joint, np.arange(joint.points))
    one, other = (solve_branch(j, 5.0, damping=LOSS) for j in (joint, regions))
    np.testing.assert_array_equal(one.amplitude, other.amplitude)


def test_order_of_pairs_does_not_matter(joint):
    turned = replace(
        joint,
        tangential_mode=joint.tangential_mode[::-1].copy(),
        position=joint.position[::-1].copy(),
        element_position=joint.element_position[::-1].copy(),
        law=replace(joint.law, slip_force=joint.law.slip_force[::-1].copy()),
    )
    one, other = (solve_branch(j, 5.0, damping=LOSS) for j in (joint, turned))
    assert one.amplitude[one.peak] == pytest.approx(other.amplitude[other.peak], rel=1e-9)


def test_second_resonance(joint):
    branch = solve_branch(joint, 1e-4, method="rdnm-1", damping=LOSS, resonance=2)
    full = solve_branch(joint, 1e-4, damping=LOSS, resonance=2)
    assert branch.complete
    # the other modes are left out off resonance
    assert branch.frequency[branch.peak] == pytest.approx(full.frequency[full.peak], rel=1e-4)
    assert branch.amplitude[branch.peak] == pytest.approx(full.amplitude[full.peak], rel=5e-2)


def test_file_holds_every_force_level(joint, tmp_path):
    forces = [0.01, 5.0, 20.0]
    regions = bands_of_equal_load(joint.position[:, :2], joint.law.slip_force, 3)
    response = solve_response(merge_points(joint, regions), forces, damping=LOSS)
    dataset.save(response, tmp_path / "response.nc")
    again = dataset.load(tmp_path / "response.nc")
    np.testing.assert_array_equal(again["force_level"], forces)
    np.testing.assert_array_equal(np.unique(again["excitation_force"]), forces)
    assert again["modal_coordinate"].dims == ("solution", "mode", "component")
    assert list(again["component"].to_numpy()) == ["bias", "sin", "cos"]
    assert not again["modal_coordinate"].sel(component="bias").any()
    assert again["complete"].all()
    assert again["contact_state"].sizes == {"force": 3, "element": 60}
    assert again.attrs["loss_factor"] == LOSS
    assert again.attrs["coordinates"] == "linear"
    amplitude = np.abs(
        again["modal_coordinate"].sel(component="sin").to_numpy() @ joint.response_mode
        + 1j * again["modal_coordinate"].sel(component="cos").to_numpy() @ joint.response_mode
    )
    np.testing.assert_allclose(again["response_amplitude"], amplitude, rtol=1e-12)


def test_further_harmonics_follow_the_first(joint):
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law, 3, samples=64))
    response = solve_response(sampled, [20.0], damping=LOSS)
    assert response["complete"].all()
    assert list(response["component"].to_numpy()) == ["bias", "sin", "cos", "sin3", "cos3"]
    output = response["modal_coordinate"].transpose(..., "mode").to_numpy() @ joint.response_mode
    np.testing.assert_allclose(
        response["response_amplitude"], np.hypot(output[:, 1], output[:, 2]), rtol=1e-12
    )
    assert output[:, 3:].any()


def test_states_at_the_peak_go_from_stick_to_slip(joint):
    response = solve_response(joint, [1e-5, 200.0], damping=LOSS)
    assert not response["contact_state"].isel(force=0).any()
    assert (response["contact_state"].isel(force=1) == 1).all()


def test_a_branch_that_breaks_off_is_a_result_with_a_flag(joint):
    control = StepControl(maximum_solutions=5)
    response = solve_response(joint, [5.0, 20.0], damping=LOSS, control=control)
    assert not response["complete"].any()
    assert set(response["reason"].to_numpy()) == {"the branch has more solutions than allowed"}
    assert response.sizes["solution"] == 10


def test_unknown_coordinates_are_refused(joint):
    with pytest.raises(ValueError, match="'cartesian' must be linear, backbone, rdnm-N or complex"):
        solve_branch(joint, 1.0, method="cartesian", damping=LOSS)
    with pytest.raises(ValueError, match="4 response-dependent modes of 3 linear ones"):
        solve_branch(joint, 1.0, method="rdnm-4", damping=LOSS)


def test_forward_differences_come_close_to_the_jacobian(joint):
    balance = HarmonicBalance(joint, LOSS, 5.0)
    for name in ("linear", "rdnm-2", "complex-rdnm-2"):
        analytic, differences = (
            method_of(name, jacobian=jacobian, basis_update="lagged").formulate(balance, 1)
            for jacobian in ("analytic", "forward-difference")
        )
        x = 1e-5 * np.random.default_rng(3).normal(size=6)
        x = x if name == "linear" else analytic.from_fixed(x)
        exact, near = (each.evaluate(x, 500.0)[1]() for each in (analytic, differences))
        np.testing.assert_allclose(near, exact, atol=1e-5 * np.abs(exact).max())


@pytest.mark.parametrize("jacobian", ["analytic", "forward-difference"])
@pytest.mark.parametrize("name", ["linear", "rdnm-1", "backbone"])
def test_a_timed_method_solves_what_it_times(joint, name, jacobian):
    forces = [1.0, 5.0]
    method = Timed.of(method_of(name, jacobian=jacobian))
    found = solve_response(joint, forces, method, damping=LOSS)
    untimed = solve_response(joint, forces, method.method, damping=LOSS)
    xr.testing.assert_identical(found, untimed)
    times = method.times
    assert list(times) == [
        *("force_N", "repeat", "wall_s", "cpu_s", "solutions", "iterations"),
        *("jacobian", "complete"),
    ]
    assert times["force_N"].tolist() == forces
    assert (times["jacobian"] == jacobian).all()
    assert (times["cpu_s"] > 0).all()
    assert times["iterations"].sum() == found["iterations"].sum()


def test_what_was_done_before_counts_in_equal_parts(joint):
    method = Timed.of(method_of("linear"), (6.0, 2.0))
    solve_response(joint, [1.0, 5.0], method, damping=LOSS)
    alone = Timed.of(method_of("linear"))
    solve_response(joint, [1.0, 5.0], alone, damping=LOSS)
    for name, part in (("wall_s", 3.0), ("cpu_s", 1.0)):
        assert np.all((method.times[name] - alone.times[name]).between(part - 0.5, part + 0.5))
