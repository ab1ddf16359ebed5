"""Craig-Bampton models of three bolts against the full one, within the error that bases estimate.

Both are known by their matrices alone, and each has a contact-adapted basis of its own.
"""

import numpy as np
import pytest
from examples import COARSE, FEWEST, craig_bampton
from small_study import mesh_of
from test_structure_model import as_matrices

from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.response.converged_peaks import converge_peaks
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

FORCES, LOSS_FACTOR = [5.0, 20.0, 60.0], 2e-3
CONTACT = {
    "law": "constant",
    "tangential_stiffness_N_per_m": 1e8,
    "friction_coefficient": 0.1,
}
CONDITION = ContactCondition.of(CONTACT, LOSS_FACTOR)
THREE_BOLTS = {
    **COARSE,
    "bar": COARSE["bar"] | {"lap_mm": 110},
    "bolts": COARSE["bolts"] | {"positions_from_lap_start_mm": [25, 55, 85]},
    "mesh": COARSE["mesh"] | FEWEST,
}


@pytest.fixture(scope="module")
def three_bolts():
    return structure_of(mesh_of(THREE_BOLTS))


def solved(structure):
    """Estimated errors of the basis, loads, joint, responses and backbone of a structure."""
    preload = apply_preload(structure, 8e3, tolerance=1e-12)
    options = ContactAdaptedBasis(states=8, adaptations=1)
    modes = find_modes(
        structure, "enriched-auto", find_pod_modes(structure, preload, [CONDITION], options)
    )
    joint = CONDITION.connect(preload, modes)
    error = {what: modes.attrs[f"estimated_{what}_error"] for what in ("frequency", "amplitude")}
    responses = {
        coordinates: solve_response(joint, FORCES, method=coordinates, damping=LOSS_FACTOR)
        for coordinates in ("linear", "backbone")
    }
    return error, preload["normal_load"].to_numpy(), joint, responses


@pytest.fixture(scope="module")
def full(three_bolts):
    return solved(as_matrices(three_bolts))


@pytest.fixture(scope="module")
def reduced(three_bolts):
    return solved(as_matrices(three_bolts, craig_bampton(three_bolts, 30)))


@pytest.fixture(scope="module")
def allowed(full, reduced):
    """Relative errors of peaks that either basis estimates of itself, added."""
    total = {what: full[0][what] + reduced[0][what] for what in full[0]}
    # an estimate that allows for anything would be none
    assert total["frequency"] < 2e-3
    assert total["amplitude"] < 2e-2
    return total


def test_loads_are_those_of_the_full_model(full, reduced):
    np.testing.assert_allclose(reduced[1], full[1], rtol=0, atol=1e-8 * full[1].max())


@pytest.mark.parametrize("coordinates", ["linear", "backbone"])
def test_peaks_of_responses_and_of_the_backbone_are_within_the_estimate(
    full, reduced, allowed, coordinates
):
    own, expected = (each[3][coordinates] for each in (reduced, full))
    for what, error in allowed.items():
        np.testing.assert_allclose(own[f"peak_{what}"], expected[f"peak_{what}"], rtol=error)


def test_responses_off_the_peak_are_within_the_estimate(full, reduced, allowed):
    # a shift in frequency changes the flanks by it over the width of the peak
    error = allowed["amplitude"] + allowed["frequency"] / LOSS_FACTOR
    for force in FORCES:
        curves = []
        for *_, responses in (full, reduced):
            response = responses["linear"]
            mine = response["excitation_force"].to_numpy() == force
            curves.append(
                [response[name].to_numpy()[mine] for name in ("frequency", "response_amplitude")]
            )
        frequency = np.linspace(*np.percentile(curves[0][0], [2, 98]), 200)
        expected, own = (np.interp(frequency, *curve) for curve in curves)
        assert abs(own - expected).max() < error * curves[0][1].max()


def test_converged_peaks_are_within_both_estimates(full, reduced, allowed):
    for place in (1, 2):
        expected, own = (
            converge_peaks(joint, responses["linear"].isel(force=[place]))
            for _, _, joint, responses in (full, reduced)
        )
        for what, error in allowed.items():
            # harmonics that are left out have an error bar of their own
            bars = sum(each[f"peak_{what}_truncation_error"].item() for each in (expected, own))
            name = f"peak_{what}_converged"
            assert own[name].item() == pytest.approx(expected[name].item(), rel=error + bars)


def test_statics_alone_are_not_within_the_estimate(three_bolts, allowed):
    """So that the comparisons tell a good basis from a poor one."""
    frequency = [
        find_modes(each, "free-2")["natural_frequency"].to_numpy()
        for each in (
            as_matrices(three_bolts),
            *(as_matrices(three_bolts, craig_bampton(three_bolts, modes)) for modes in (30, 0)),
        )
    ]
    expected, good, statics = frequency
    np.testing.assert_allclose(good, expected, rtol=allowed["frequency"])
    assert statics[1] > (1 + allowed["frequency"]) * expected[1]
