"""Responses with as many harmonics as their peaks need."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.response.converged_peaks import (
    find_converged_peaks,
    solve_converged_response,
)
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence
from boltjoint.friction.aft import AlternatingFrequencyTime

FORCES = [0.01, 5.0]
#: few enough that the response of the variable law takes seconds
FEW = HarmonicConvergence(
    harmonics=(3, 5, 7, 9), amplitude_tolerance=2e-4, frequency_tolerance=3e-4, samples=256
)


@pytest.fixture(params=["constant", "variable"], scope="module")
def either(request):
    """A joint of either law with its response."""
    joint = make_joint(law=request.param)
    return joint, solve_converged_response(joint, FORCES, harmonics=FEW, damping=0.01)


def test_each_force_has_the_harmonics_of_its_converged_peak(either):
    joint, response = either
    expected = response["peak_harmonics"].fillna(9).to_numpy()
    assert len(set(expected)) > 1
    np.testing.assert_array_equal(response["response_harmonics"], expected)
    for force, number in zip(FORCES, expected.astype(int), strict=True):
        law = AlternatingFrequencyTime(joint.law, **FEW.sampling(number))
        alone = solve_response(replace(joint, law=law), [force], damping=0.01)
        found = response.isel(solution=response["excitation_force"] == force)
        np.testing.assert_array_equal(found["response_amplitude"], alone["response_amplitude"])
        own = list(alone["component"].to_numpy())
        motion = found["modal_coordinate"]
        np.testing.assert_array_equal(motion.sel(component=own), alone["modal_coordinate"])
        further = [name for name in response["component"].to_numpy() if name not in own]
        assert not motion.sel(component=further).any()


def test_its_peaks_are_the_converged_ones(either):
    _, response = either
    for what, tolerance in (("amplitude", 1e-4), ("frequency", 1e-3)):
        own, best = response[f"peak_{what}"], response[f"peak_{what}_converged"]
        np.testing.assert_allclose(own, best, rtol=tolerance)
        assert (response[f"peak_{what}_error"] < 0.05).all()
    assert response["complete"].all()
    assert (response["excitation_force"].to_numpy() == np.sort(response["excitation_force"])).all()


def test_response_dependent_modes_have_them_too(either):
    joint, expected = either
    how = {"harmonics": FEW, "damping": 0.01}
    found = solve_converged_response(joint, FORCES[1:2], "rdnm-2", **how)
    peaks = find_converged_peaks(joint, FORCES[1:2], **how)
    given = solve_converged_response(joint, FORCES[1:2], "rdnm-2", **how, peaks=peaks)
    np.testing.assert_array_equal(found["peak_amplitude"], given["peak_amplitude"])
    assert found["response_harmonics"] == expected["response_harmonics"][1]
    np.testing.assert_allclose(found["peak_amplitude"], expected["peak_amplitude"][1], rtol=0.05)


def test_what_cannot_have_them_is_refused():
    joint = make_joint()
    for coordinates in ("complex-rdnm-1", "backbone"):
        with pytest.raises(ValueError, match="linear or rdnm-N"):
            solve_converged_response(joint, [1.0], method=coordinates, damping=0.01)
