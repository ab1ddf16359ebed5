"""Peaks with many harmonics in a basis, against those in a larger one."""

from dataclasses import replace

import numpy as np
import pytest
from small_joint import make_joint

from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.error_bars import add_converged_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.harmonic_convergence import HarmonicConvergence, converge_peak
from boltjoint.study.tables.harmonic_peaks import tabulate_larger_basis

LOSS = 0.01
FORCES = [1.0, 20.0]


@pytest.fixture(scope="module")
def joints():
    """A joint in two of its modes, and in all three."""
    whole = make_joint()
    modes = ("natural_frequency", "excitation_mode", "response_mode")
    two = {name: getattr(whole, name)[:2] for name in modes}
    return replace(whole, tangential_mode=whole.tangential_mode[:, :2], **two), whole


def solved(joint, **options):
    response = solve_response(joint, FORCES, damping=LOSS)
    converged = converge_peaks(joint, response, HarmonicConvergence(**options))
    return add_converged_peaks(response, converged)


def test_errors_are_those_of_the_peaks_with_as_many_harmonics(joints):
    small, whole = joints
    response = solved(small)
    table = tabulate_larger_basis(response, whole, FORCES[:1]).set_index("harmonics")
    in_whole = solve_response(whole, FORCES, damping=LOSS)
    tried = HarmonicConvergence((3, 9, 17), 1e-12, 1e-12)
    sequence = converge_peak(whole, *motion_at_peak(in_whole, 1.0), 1.0, LOSS, tried)
    assert {1, 3, 9, 17} <= set(table.index)
    for peak in sequence.peaks:
        row = table.loc[peak.harmonics]
        assert row["force_N"] == 1.0
        assert row["peak_frequency_Hz"] == pytest.approx(peak.frequency, rel=1e-6)
        assert row["peak_mm_per_N"] == pytest.approx(1e3 * peak.amplitude, rel=1e-5)
        own = response.sel(harmonics=peak.harmonics, force=0)
        error = 100 * (own["harmonic_peak_amplitude"].item() / peak.amplitude - 1)
        assert row["peak_amplitude_error_percent"] == pytest.approx(error, abs=1e-3)
    # a mode that is missing makes a difference
    assert (table["peak_frequency_error_percent"] > 0.1).all()


def test_a_basis_agrees_with_itself(joints):
    whole = joints[1]
    table = tabulate_larger_basis(solved(whole), whole, FORCES)
    assert set(table["force_N"]) == set(FORCES)
    np.testing.assert_allclose(table.filter(like="error"), 0.0, atol=1e-4)


def test_forces_and_peaks_must_be_there(joints):
    small, whole = joints
    with pytest.raises(ValueError, match="must be among the levels"):
        tabulate_larger_basis(solved(small), whole, [2.0])
    plain = solve_response(small, FORCES, damping=LOSS)
    with pytest.raises(ValueError, match="no converged peaks"):
        tabulate_larger_basis(plain, whole, FORCES)
