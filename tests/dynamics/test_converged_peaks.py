"""Peaks with as many harmonics as change nothing."""

from dataclasses import replace
from functools import partial

import error_bars
import numpy as np
import pytest
from small_joint import connect_small, make_joint

from boltjoint.dynamics.balance.balance_equations import PhaseEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response import (
    frequency_response,
    left_out_harmonics,
    phase_resonance,
)
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import ConvergedPeak, add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence, converge_peak
from boltjoint.dynamics.response.left_out_harmonics import (
    LeftOutHarmonics,
    change_by_left_out_harmonics,
    with_more_harmonics,
)
from boltjoint.dynamics.response.phase_resonance import PeakSearch, PhaseResonance, find_peak
from boltjoint.dynamics.response.response_file import to_dataset
from boltjoint.dynamics.response.stability import StabilityOptions
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import tabulate_joint
from boltjoint.solvers.newton import NewtonKrylov
from boltjoint.solvers.step_control import StepControl
from boltjoint.verification.time_integration import steady_state

LOSS = 0.01
FORCES = [0.01, 5.0, 20.0]


@pytest.fixture(params=["constant", "variable"], scope="module")
def either(request):
    """A joint of either law with its response."""
    joint = make_joint(law=request.param)
    return joint, solve_response(joint, FORCES, damping=LOSS)


@pytest.fixture(scope="module")
def converged(either):
    """The converged peaks of that response: do not change them."""
    return converge_peaks(*either)


@pytest.fixture(scope="module")
def with_many(either):
    """Each of its peaks with 33 harmonics."""
    joint, response = either
    return [
        find_peak(joint, frequency, force, LOSS, motion, harmonics=33, samples=1024)
        for force in FORCES
        for frequency, motion in [motion_at_peak(response, force)]
    ]


def with_three_harmonics(joint, response, **options):
    """Motions with three harmonics near the peak at 5 N, and its frequency with one."""
    frequency, motion = motion_at_peak(response, 5.0)
    law = AlternatingFrequencyTime(joint.law, 3, 256)
    balance = HarmonicBalance(replace(joint, law=law), LOSS, 5.0)
    return PhaseResonance(balance, frequency, motion, **options), frequency


def test_more_harmonics_change_a_converged_peak_by_less_than_its_truncation_error(
    either, converged, with_many
):
    joint, response = either
    found = converged
    assert np.isfinite(found["peak_harmonics"]).all()
    for place, (highest, motion, *_) in enumerate(with_many):
        best = {"frequency": highest, "amplitude": abs(motion.amplitude(joint.response_mode))}
        peak = found.isel(force=place)
        for what, value in best.items():
            error = float(peak[f"peak_{what}_truncation_error"])
            assert error < 1e-2
            assert abs(value / float(peak[f"peak_{what}_converged"]) - 1) <= error
    # where more slips, one harmonic leaves more out
    error = abs(found["peak_amplitude_converged"] / response["peak_amplitude"] - 1)
    assert error[1] > 2 * error[0]


def test_a_motion_at_the_phase_of_few_harmonics_stands_for_a_peak(either, with_many):
    joint, response = either
    options = HarmonicConvergence(amplitude_tolerance=1e-9)
    for force, best in zip(FORCES, with_many, strict=True):
        near = joint, *motion_at_peak(response, force), force, LOSS, options
        sequence = converge_peak(*near, at_one_phase=True)
        *_, peak = sequence.peaks
        assert peak.harmonics == 33
        frequency, amplitude = ConvergedPeak(sequence).extrapolated.truncation_error
        # where the amplitude is rough over the phase, the frequency is off by more than is told
        assert frequency < 2e-3 and amplitude < 1e-3
        np.testing.assert_allclose(peak.frequency, best.frequency, rtol=2e-4)
        expected = abs(best.motion.amplitude(joint.response_mode))
        np.testing.assert_allclose(peak.amplitude, expected, rtol=1e-4)


def test_a_peak_that_is_not_solved_has_no_sampling_error(either):
    resonance, _ = with_three_harmonics(*either)
    solved = resonance.with_sampling_error(resonance.peak())
    assert np.all(np.array(solved.sampling_error) > 0)
    # as one whose motion is interpolated
    elsewhere = resonance.peak()._replace(phase=solved.phase + 1e-3)
    assert np.isnan(resonance.with_sampling_error(elsewhere).sampling_error).all()


def test_left_out_harmonics_change_a_peak_as_those_with_more_do(either):
    joint, _ = either
    resonance, frequency = with_three_harmonics(*either)
    few = resonance.peak()
    many = find_peak(joint, frequency, 5.0, LOSS, few.motion, harmonics=9, samples=512)
    thrice = LeftOutHarmonics(times=3, smallest_fall=1e-9, tolerance=1e-7)
    change = change_by_left_out_harmonics(resonance, few, thrice)
    amplitudes = [abs(peak.motion.amplitude(joint.response_mode)) for peak in (few, many)]
    expected = abs(amplitudes[1] / amplitudes[0] - 1)
    assert expected > 1e-4
    # the amplitude changes with the phase in second order
    assert change.amplitude == pytest.approx(expected, rel=0.01)
    # a motion so far away that the bar would be as large as the peak is another one
    for safety, is_near in ((0.9 / change.amplitude, True), (1.1 / change.amplitude, False)):
        at = resonance, few, replace(thrice, safety=safety)
        assert np.isfinite(change_by_left_out_harmonics(*at)).all() == is_near


def test_left_out_harmonics_move_a_peak_in_the_phase_as_their_amplitudes_vary_with_it(either):
    joint, _ = either
    exact = PeakSearch(width=1e-4, tolerance=1e-9)
    resonance, frequency = with_three_harmonics(*either, search=exact)
    few = resonance.peak()
    at = joint, frequency, 5.0, LOSS, few.motion
    many = find_peak(*at, harmonics=6, samples=512, search=exact)
    change = change_by_left_out_harmonics(resonance, few, LeftOutHarmonics(times=2, tolerance=1e-7))
    # by 2e-4 and 2e-3 rad
    turn = abs(many.phase - few.phase)
    assert change.slope / few.sharpness == pytest.approx(turn, rel=0.1, abs=5e-5)
    moved = few.frequency_by_phase * turn
    assert abs(many.frequency / few.frequency - 1) < change.frequency + moved


def test_left_out_harmonics_are_added_a_few_at_a_time_where_all_do_not_converge():
    joint, force, loss_factor = error_bars.small_joint("variable", 2, seed=3)
    response = solve_response(joint, [force], damping=loss_factor)
    at_peak = motion_at_peak(response, force)
    law = AlternatingFrequencyTime(joint.contact.element_law, 9)
    balance = HarmonicBalance(replace(joint, law=law), loss_factor, force)
    resonance = PhaseResonance(balance, *at_peak)
    few = resonance.peak()
    at = resonance, few
    enough = LeftOutHarmonics(times=2, tolerance=1e-9)
    expected = change_by_left_out_harmonics(*at, enough)
    assert expected.amplitude > 1e-6
    more = replace(law, harmonics=18, samples=512)
    equations, y, phase = PhaseEquations.near(
        replace(balance, joint=replace(joint, law=more)), few.motion, few.frequency
    )
    control = StepControl(tolerance=enough.tolerance, maximum_iterations=4)
    assert not NewtonKrylov(equations, control).solve(y, phase).converged
    found = change_by_left_out_harmonics(*at, replace(enough, iterations=4))
    assert found[:2] == pytest.approx(expected[:2], rel=1e-4)
    # at another phase it is not far
    assert expected.slope > 0
    assert found.slope == pytest.approx(expected.slope, rel=1e-3)


def test_a_peak_is_sought_with_more_harmonics_a_few_at_a_time_where_all_do_not_converge():
    joint, force, loss_factor = error_bars.small_joint("variable", 42, seed=161803)
    response = solve_response(joint, [force], damping=loss_factor)
    found = converge_peaks(joint, response)
    assert found["peak_harmonics"] >= 9
    # contact that opens leaves much to further harmonics
    assert abs(response["peak_amplitude"] / found["peak_amplitude_converged"] - 1) > 0.05


@pytest.mark.usefixtures("stability_of_one_harmonic")
def test_a_peak_that_is_not_found_at_once_is_found_from_beside(monkeypatch):
    joint, force, loss_factor = error_bars.small_joint("variable", 28, seed=3)
    frequency, motion = motion_at_peak(solve_response(joint, [force], damping=loss_factor), force)
    at = joint, frequency, force, loss_factor, motion
    few, many = (find_peak(*at, harmonics=9, samples=samples) for samples in (256, 2048))
    assert few.frequency == pytest.approx(many.frequency, rel=3e-4)
    monkeypatch.setattr(phase_resonance, "_BESIDE", 0.0)
    assert find_peak(*at, harmonics=9) is None


def test_left_out_harmonics_are_sought_with_other_samples_too(either, monkeypatch):
    joint, response = either
    asked = []

    def lost(balance, *args, **kwargs):
        asked.append(balance.joint.law)
        fails = len(asked) % 2 == 1
        return None if fails else with_more_harmonics(balance, *args, **kwargs)

    monkeypatch.setattr(left_out_harmonics, "with_more_harmonics", lost)
    found = converge_peaks(joint, response.isel(force=[-1]))
    assert np.isfinite(found["peak_amplitude_truncation_error"]).all()
    first, second = asked[:2]
    assert second.harmonics == first.harmonics
    assert second.samples == 1.5 * first.samples


def test_a_peak_without_the_motion_of_left_out_harmonics_has_no_error_bar(either, caplog):
    joint, response = either
    hopeless = LeftOutHarmonics(iterations=1, tolerance=1e-12)
    found = converge_peaks(joint, response.isel(force=[-1]), left_out=hopeless)
    assert np.isfinite(found["peak_amplitude_converged"]).all()
    for what in ("frequency", "amplitude"):
        assert np.isnan(found[f"peak_{what}_truncation_error"]).all()
    assert "the peak has no error bar" in caplog.text


def test_peaks_are_found_without_their_truncation_errors_too(either, converged, caplog):
    peaks = converge_peaks(*either, left_out=None)
    for name in ("peak_frequency_converged", "peak_amplitude_converged", "harmonic_peak_frequency"):
        np.testing.assert_array_equal(peaks[name], converged[name])
    for what in ("frequency", "amplitude"):
        assert np.isnan(peaks[f"peak_{what}_truncation_error"]).all()
    assert not caplog.text


def test_the_error_bar_of_a_peak_holds_that_of_many_more_harmonics(either, converged):
    joint, response = either
    found = add_converged_peaks(response, converged)
    tight = HarmonicConvergence(
        harmonics=(3, 9, 33, 65), amplitude_tolerance=2e-4, frequency_tolerance=2e-5, samples=1024
    )
    exact = converge_peaks(joint, response, tight)
    for what in ("frequency", "amplitude"):
        own, best = response[f"peak_{what}"], exact[f"peak_{what}_converged"]
        assert np.isfinite(best).all()
        assert (abs(own / best - 1) <= found[f"peak_{what}_error"]).all()


def test_bars_hold_what_is_estimated_of_basis_and_weights(either, converged):
    _, response = either
    alone = add_converged_peaks(response, converged)
    of_model = {
        f"{of}_{what}_error": error
        for of, errors in {"basis": (1e-3, 0.02), "weights": (np.nan, 0.01)}.items()
        for what, error in zip(("frequency", "amplitude"), errors, strict=True)
    }
    of_inertia = {f"peak_{what}_inertia_error": 0.03 for what in ("frequency", "amplitude")}
    whole = add_converged_peaks(response, converged.assign(of_model).assign(of_inertia))
    for what, ratio in (("frequency", 1.001 * 1.03), ("amplitude", 1.02 * 1.01 * 1.03)):
        left_out = converged[f"peak_{what}_truncation_error"]
        name = f"peak_{what}_converged_error"
        np.testing.assert_allclose(1 + alone[name], 1 + left_out, rtol=1e-14)
        np.testing.assert_allclose(1 + whole[name], (1 + left_out) * ratio, rtol=1e-14)
        own = f"peak_{what}_error"
        np.testing.assert_allclose(1 + whole[own], (1 + alone[own]) * ratio, rtol=1e-12)


def test_the_peaks_on_the_way_are_kept(either, converged):
    _, response = either
    found = converged
    for place in range(len(FORCES)):
        for what in ("frequency", "amplitude"):
            on_the_way = found[f"harmonic_peak_{what}"].isel(force=place).dropna("harmonics")
            assert on_the_way.sel(harmonics=1) == response[f"peak_{what}"][place]
            last = on_the_way.isel(harmonics=-1)
            assert last == found[f"peak_{what}_converged"][place]
            assert on_the_way["harmonics"][-1] == found["peak_harmonics"][place]
    with pytest.raises(ValueError, match="joint"):
        converge_peaks(response, response)


def test_a_converged_peak_is_that_of_the_motion_in_time(either, converged, with_many):
    joint, _ = either
    found = converged.isel(force=1)
    frequency, motion, *_ = with_many[1]
    # damping is viscous in time, so that harmonics beyond the first are damped otherwise
    in_time = steady_state(joint, frequency, FORCES[1], LOSS, start=motion.in_time(256))
    assert in_time.converged
    assert float(found["peak_amplitude_converged"]) == pytest.approx(
        abs(in_time.amplitude), rel=5e-3
    )


def test_what_is_sampled_already_has_the_same_converged_peaks(either, converged):
    joint, _ = either
    several = replace(joint, law=AlternatingFrequencyTime(joint.law, 3, 64))
    of_three = solve_response(several, FORCES[1:], damping=LOSS)
    found = converge_peaks(several, of_three)
    for name in ("peak_frequency_converged", "peak_amplitude_converged"):
        np.testing.assert_allclose(found[name], converged[name][1:], rtol=2e-3)


def test_what_does_not_converge_has_a_larger_truncation_error(either, caplog):
    joint, response = either
    few = HarmonicConvergence(harmonics=(3, 5), amplitude_tolerance=1e-9)
    found = converge_peaks(joint, response, few)
    assert (found["peak_harmonics"] == 5).all()
    assert (found["peak_amplitude_truncation_error"][1:] > 1e-9).all()
    assert caplog.text.count("with 5 harmonics, the most with which it is found") >= 2
    # one peak beside that of the response has an error bar too, which holds peaks with more
    one, best = (
        converge_peaks(joint, response, HarmonicConvergence(harmonics=harmonics))
        for harmonics in ((3,), (3, 9, 33))
    )
    assert (one["peak_harmonics"] == 3).all()
    change = abs(one["peak_amplitude_converged"] / best["peak_amplitude_converged"] - 1)
    assert (change <= one["peak_amplitude_truncation_error"]).all()
    lost = response.assign(peak_frequency=np.nan * response["peak_frequency"])
    assert np.isnan(converge_peaks(joint, lost)["peak_amplitude_converged"]).all()


def test_a_tabulated_law_has_the_converged_peaks_of_its_elements():
    keys = {"tangential_stiffness": 5e6, "friction_coefficient": 0.1}
    nodes, preload = connect_small("constant", keys)
    regions = partition_regions(nodes, preload, 2)
    found, expected = (
        converge_peaks(joint, solve_response(joint, [5.0], damping=LOSS))
        for joint in (tabulate_joint(regions), regions)
    )
    assert np.isfinite(expected["peak_harmonics"]).all()
    for name in ("peak_frequency_converged", "peak_amplitude_converged"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-4)


def test_a_peak_that_is_not_found_is_left_out(either):
    joint, response = either
    frequency, motion = motion_at_peak(response, 0.01)
    found = converge_peak(joint, 0.8 * frequency, motion, 0.01, LOSS)
    assert [peak.harmonics for peak in found.peaks] == [1]
    assert not found.converged


@pytest.fixture
def stability_of_one_harmonic(monkeypatch):
    """Stability at folds of the motion of one harmonic: of more it takes longer than the rest."""
    brief = partial(to_dataset, stability=StabilityOptions(harmonics=1))
    monkeypatch.setattr(frequency_response, "to_dataset", brief)


@pytest.mark.usefixtures("stability_of_one_harmonic")
def test_a_peak_with_rough_amplitudes_is_that_with_more_samples():
    """Where slopes change their sign too early, by 2.8e-3 in frequency."""
    joint, force, loss_factor = error_bars.small_joint("variable", 28, seed=3)
    frequency, motion = motion_at_peak(solve_response(joint, [force], damping=loss_factor), force)
    coarse, fine = (
        find_peak(joint, frequency, force, loss_factor, motion, harmonics=17, samples=samples)
        for samples in (272, 2176)
    )
    assert coarse.frequency == pytest.approx(fine.frequency, rel=3e-4)
    amplitudes = [abs(peak.motion.amplitude(joint.response_mode)) for peak in (coarse, fine)]
    assert amplitudes[0] == pytest.approx(amplitudes[1], rel=2e-3)


@pytest.mark.usefixtures("stability_of_one_harmonic")
def test_an_error_bar_sees_a_mode_of_the_contact_beyond_twice_the_harmonics():
    joint, force, loss_factor = error_bars.small_joint("variable", 5, seed=271828)
    _, amplitude = error_bars.check("", "", joint, [force], loss_factor)
    assert amplitude["what"] == "amplitude"
    assert 5e-4 < amplitude["error"] <= amplitude["bar"] < 10 * amplitude["error"]
    response = solve_response(joint, [force], damping=loss_factor)
    twice = converge_peaks(joint, response, left_out=LeftOutHarmonics(times=2))
    assert twice["peak_amplitude_truncation_error"][0] < 0.2 * amplitude["error"]


@pytest.mark.usefixtures("stability_of_one_harmonic")
def test_changes_that_hardly_vary_with_the_phase_move_a_peak_less(monkeypatch):
    joint, force, loss_factor = error_bars.small_joint("coupled-constant", 18, seed=161803)
    rows = error_bars.check("", "", joint, [force], loss_factor)
    bars, errors = ([row[name] for row in rows] for name in ("bar", "error"))
    # as where motions at other phases are not found
    monkeypatch.setattr(PhaseResonance, "slope_of_change", lambda *_: np.nan)
    response = solve_response(joint, [force], damping=loss_factor)
    varying = converge_peaks(joint, response).isel(force=0)
    assert errors[0] < bars[0] < 0.3 * varying["peak_frequency_truncation_error"]
    assert errors[1] < bars[1] == varying["peak_amplitude_truncation_error"]


@pytest.mark.usefixtures("stability_of_one_harmonic")
@pytest.mark.parametrize("law", ["constant", "variable", "coupled-constant"])
def test_error_bars_of_random_joints_hold_three_times_the_harmonics(law):
    joints = error_bars.small_joints([law], 3, seed=3)
    rows = [row for joint in joints for row in error_bars.check(*joint)]
    peaks = [row for row in rows if row["harmonics"]]
    assert len(peaks) >= 3
    for row in peaks:
        assert row["error"] <= row["bar"], row
        assert row["error_of_one"] <= row["bar_of_one"], row


@pytest.mark.parametrize(
    "wrong",
    [
        {"harmonics": (5, 3)},
        {"amplitude_tolerance": 0},
        {"frequency_tolerance": -1},
        {"samples": 2},
    ],
)
def test_options_with_which_nothing_converges_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        HarmonicConvergence(**wrong)
