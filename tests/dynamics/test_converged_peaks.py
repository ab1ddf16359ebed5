"""Peaks with as many harmonics as change nothing."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import connect_small, make_joint

from boltjoint.dynamics.converged_peaks import (
    HarmonicConvergence,
    add_converged_peaks,
    converge_peak,
    converge_peaks,
)
from boltjoint.dynamics.frequency_response import solve_response
from boltjoint.dynamics.periodic_motion import motion_at_peak
from boltjoint.dynamics.phase_resonance import find_peak
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reduced import tabulate_joint
from boltjoint.verification.time_integration import steady_state

LOSS = 0.01
FORCES = [0.01, 5.0, 20.0]


@pytest.fixture(params=["constant", "variable"], scope="module")
def either(request):
    """A joint of either law with its response."""
    joint = make_joint(law=request.param)
    return joint, solve_response(joint, FORCES, loss_factor=LOSS)


def test_more_harmonics_change_a_converged_peak_by_less_than_its_truncation_error(either):
    joint, response = either
    found = converge_peaks(joint, response)
    assert np.isfinite(found["peak_harmonics"]).all()
    for place, force in enumerate(FORCES):
        frequency, motion = motion_at_peak(response, force)
        highest, motion = find_peak(
            joint, frequency, force, LOSS, motion, harmonics=33, samples=1024
        )
        best = {"frequency": highest, "amplitude": abs(motion.amplitude(joint.response_mode))}
        peak = found.isel(force=place)
        for what, value in best.items():
            error = float(peak[f"peak_{what}_truncation_error"])
            assert error < 1e-2
            assert abs(value / float(peak[f"peak_{what}_converged"]) - 1) <= error
    # where more slips, one harmonic leaves more out
    error = abs(found["peak_amplitude_converged"] / response["peak_amplitude"] - 1)
    assert error[1] > 2 * error[0]


def test_the_error_bar_of_a_peak_holds_that_of_many_more_harmonics(either):
    joint, response = either
    found = add_converged_peaks(response, converge_peaks(joint, response))
    tight = HarmonicConvergence(
        harmonics=(3, 9, 33, 65), amplitude_tolerance=2e-4, frequency_tolerance=2e-5, samples=2048
    )
    exact = converge_peaks(joint, response, tight)
    for what in ("frequency", "amplitude"):
        own, best = response[f"peak_{what}"], exact[f"peak_{what}_converged"]
        assert np.isfinite(best).all()
        assert (abs(own / best - 1) <= found[f"peak_{what}_error"]).all()


def test_the_peaks_on_the_way_are_kept(either):
    joint, response = either
    found = converge_peaks(joint, response)
    for place in range(len(FORCES)):
        for what in ("frequency", "amplitude"):
            on_the_way = found[f"harmonic_peak_{what}"].isel(force=place).dropna("harmonics")
            assert on_the_way.sel(harmonics=1) == response[f"peak_{what}"][place]
            last = on_the_way.isel(harmonics=-1)
            assert last == found[f"peak_{what}_converged"][place]
            assert on_the_way["harmonics"][-1] == found["peak_harmonics"][place]
            # the last two changes, by how the sum of the harmonics beyond one falls with it
            h, value = on_the_way["harmonics"].to_numpy()[-3:], on_the_way.to_numpy()[-3:]
            left_out = 3 * max(abs(value[1:] / value[:-1] - 1) * h[:-1] / (h[1:] - h[:-1]))
            left_out += (2 * np.pi / max(256, 16 * h[-1])) ** 2 / 12 * (what == "amplitude")
            error = float(found[f"peak_{what}_truncation_error"][place])
            # the peak of a flat curve is less certain than its amplitude
            assert error == pytest.approx(left_out) if what == "amplitude" else error > left_out
    with pytest.raises(ValueError, match="joint"):
        converge_peaks(response, response)


def test_a_converged_peak_is_that_of_the_motion_in_time(either):
    joint, response = either
    found = converge_peaks(joint, response).isel(force=1)
    frequency, motion = motion_at_peak(response, FORCES[1])
    frequency, motion = find_peak(
        joint, frequency, FORCES[1], LOSS, motion, harmonics=33, samples=1024
    )
    # damping is viscous in time, so that harmonics beyond the first are damped otherwise
    in_time = steady_state(joint, frequency, FORCES[1], LOSS, start=motion.in_time(256))
    assert in_time.converged
    assert float(found["peak_amplitude_converged"]) == pytest.approx(
        abs(in_time.amplitude), rel=5e-3
    )


def test_what_is_sampled_already_has_the_same_converged_peaks(either):
    joint, response = either
    expected = converge_peaks(joint, response)
    several = replace(joint, law=AlternatingFrequencyTime(joint.law, 3, 256))
    of_three = solve_response(several, FORCES, loss_factor=LOSS)
    found = converge_peaks(several, of_three)
    for name in ("peak_frequency_converged", "peak_amplitude_converged"):
        np.testing.assert_allclose(found[name], expected[name], rtol=2e-3)


def test_what_does_not_converge_has_a_larger_truncation_error(either, caplog):
    joint, response = either
    few = HarmonicConvergence(harmonics=(3, 5), amplitude_tolerance=1e-9)
    found = converge_peaks(joint, response, few)
    assert (found["peak_harmonics"] == 5).all()
    assert (found["peak_amplitude_truncation_error"][1:] > 1e-9).all()
    assert caplog.text.count("5 harmonics do not suffice") >= 2
    # two peaks beside that of the response tell an error
    one = converge_peaks(joint, response, HarmonicConvergence(harmonics=(3,)))
    assert np.isnan(one["peak_harmonics"]).all()
    lost = response.assign(peak_frequency=np.nan * response["peak_frequency"])
    assert np.isnan(converge_peaks(joint, lost)["peak_amplitude_converged"]).all()


def test_a_tabulated_law_has_the_converged_peaks_of_its_elements():
    keys = {"tangential_stiffness": 5e6, "friction_coefficient": 0.1}
    nodes, preload = connect_small("constant", keys)
    regions = partition_regions(nodes, preload, 2)
    found, expected = (
        converge_peaks(joint, solve_response(joint, [5.0], loss_factor=LOSS))
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
