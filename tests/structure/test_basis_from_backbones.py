"""Adaptive bases: adjoint corrections, estimated errors and the number of vectors."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from examples import assemble_assembly, relative_displacements, symmetric_part

from boltjoint import solve_branch
from boltjoint.config.contact import ContactOfSurface
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.config.study import load_study
from boltjoint.dynamics.reduction.basis_from_backbones import _trace, find_pod_modes
from boltjoint.dynamics.reduction.candidate_backbone import CandidateBackbone
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.structure.adapted_basis.candidates import find_candidates
from boltjoint.structure.adapted_basis.pod import EnergyCoordinates, estimated_errors
from boltjoint.structure.adapted_basis.snapshots import uniform_modes
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.study.convergence import peaks_near

OPTIONS = ContactAdaptedBasis(states=12, adaptations=2, trial_step=24)
COULOMB = {"tangential_stiffness_N_per_m": 3e7, "friction_coefficient": 0.3}
CONDITIONS = {
    "constant": ContactCondition.of({"law": "constant", **COULOMB}, 1e-3),
    "variable": ContactCondition.of(
        {"law": "variable", "normal_stiffness_N_per_m": 3e7, **COULOMB}, 1e-3
    ),
}


@pytest.fixture(scope="module")
def candidates(assembly, preload):
    return find_candidates(structure_of(assembly), preload, 12)


@pytest.fixture(scope="module")
def pod_modes(assembly, preload):
    return find_pod_modes(assembly, preload, list(CONDITIONS.values()), OPTIONS)


@pytest.mark.parametrize("law", CONDITIONS)
def test_dual_weighted_residual_is_the_error_of_the_peak(candidates, preload, law):
    connect = partial(CONDITIONS[law].connect, preload)
    small = EnergyCoordinates(candidates, uniform_modes(candidates, 3e7, 8), 3e7).basis
    traced = _trace(CandidateBackbone(candidates, small, connect, 1e-3), OPTIONS)
    whole = CandidateBackbone(candidates, np.eye(len(candidates.mass)), connect, 1e-3)
    found, expected = [], []
    for state, sensitivity in zip(traced.states[::2], traced.sensitivities[::2], strict=True):
        exact = whole.solve_near(whole.transfer(traced.mode)(state), state.log_amplitude)
        # to first order, an error is known where no pair changes its state by it
        if not np.array_equal(*(contact_states(each) for each in (state, exact))):
            continue
        change = state.eigenvalue - exact.eigenvalue
        expected.append(sensitivity.gradient @ [change.real, change.imag])
        found.append(traced.mode.correct(state, sensitivity).errors)
    assert len(found) >= 3
    # corrections by static responses to the mean tangent instead of the Jacobian
    scale = np.max(np.abs(expected), axis=0)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0.3, atol=0.01)


def contact_states(state):
    balance = state.equations.balance
    return balance.joint.law.contact_state(balance.motion(state.amplitude * state.unknown[:-2]))


def test_estimated_errors_are_those_of_the_peaks_of_responses(assembly, preload, pod_modes):
    number = pod_modes["trial_vectors"].to_numpy()[0]
    few, many = (
        find_modes(assembly, f"enriched-{n}", pod_modes)
        for n in (number, pod_modes.sizes["pod_mode"])
    )
    forces = (3.0, 30.0)
    for law, condition in CONDITIONS.items():
        found, expected = (
            peaks_near(condition.connect(preload, modes), forces, condition.damping)
            for modes in (few, many)
        )
        for what, column in (("frequency", "peak_frequency_Hz"), ("amplitude", "peak_mm_per_N")):
            error = abs(found[column] / expected[column] - 1).max()
            # the largest of all forces, of which these are three
            assert error < 2 * few.attrs[f"estimated_{what}_error"], law


def test_automatic_basis_has_the_fewest_vectors_within_the_tolerances(assembly, pod_modes):
    basis = find_modes(assembly, "enriched-auto", pod_modes)
    number = pod_modes.attrs["automatic_vectors"]
    assert basis.sizes["mode"] == basis.attrs["vectors"] == number
    assert basis.attrs["estimated_frequency_error"] <= OPTIONS.frequency_tolerance
    assert basis.attrs["estimated_amplitude_error"] <= OPTIONS.amplitude_tolerance
    before = pod_modes.isel(trial=pod_modes["trial_vectors"].to_numpy() < number)
    beyond = (before["frequency_error"] > OPTIONS.frequency_tolerance) | (
        before["amplitude_error"] > OPTIONS.amplitude_tolerance
    )
    assert before.sizes["trial"] and beyond.all()
    same = find_modes(assembly, f"enriched-{number}", pod_modes)
    np.testing.assert_array_equal(basis["mode_shape"], same["mode_shape"])


def test_a_basis_needs_a_contact_that_it_is_made_for(assembly, preload):
    with pytest.raises(ValueError, match="conditions are empty"):
        find_pod_modes(assembly, preload, [], OPTIONS)


@pytest.mark.filterwarnings("ignore:.*encountered:RuntimeWarning")
def test_a_basis_lost_in_rounding_is_refused(assembly, preload):
    contact = {"law": "constant", "friction_coefficient": 0.1}
    extreme = ContactCondition.of({**contact, "tangential_stiffness_N_per_m": 1e300}, 1e-3)
    with pytest.raises(RuntimeError, match="lost in rounding"):
        find_pod_modes(assembly, preload, [extreme], OPTIONS)


def test_bases_are_made_for_the_contact_and_damping_of_the_cases_of_an_assembly():
    study = load_study(Path(__file__).parents[2])
    found = study.contact_conditions("three_bolt")
    contacts = [each["contact"] for each in found]
    # constant load at two preloads is one condition, variable load has two stiffnesses
    assert [each["law"] for each in contacts] == ["constant", "variable", "variable"]
    assert [each["tangential_stiffness_N_per_m"] for each in contacts] == [1e8, 1e8, 5e7]
    conditions = [ContactCondition.of(**each) for each in found]
    assert len(set(conditions)) == 3
    assert study.stuck_stiffness("three_bolt") == {"stiffness": 1e8}


def test_a_stiffness_per_area_is_that_of_each_pair_in_the_basis_too(tiny):
    preload = apply_preload(tiny, 8e3)
    per_area = {"law": "constant", "tangential_stiffness_N_per_m3": 7e13}
    condition = ContactCondition.of({**per_area, "friction_coefficient": 0.1}, 1e-3)
    area, loaded = (preload[name].to_numpy() for name in ("area", "normal_load"))
    lap = np.full(area.shape, "lap")
    np.testing.assert_array_equal(condition.tangential_stiffness(area, lap), 7e13 * area)
    own = {"name": "lap", "tangential_stiffness_N_per_m": 2e8}
    of_lap = condition.contact.model_copy(update={"surfaces": (ContactOfSurface(**own),)})
    stiff = ContactCondition(of_lap, condition.damping)
    np.testing.assert_array_equal(stiff.tangential_stiffness(area, lap), 2e8)
    joint = condition.connect(preload, find_modes(tiny, "free-4"))
    np.testing.assert_array_equal(joint.law.tangential_stiffness, 7e13 * area[loaded > 0])
    few = ContactAdaptedBasis(states=4, adaptations=1, maximum_vectors=16, trial_step=16)
    found = find_pod_modes(tiny, preload, [condition], few)
    # the norm of the basis is that of these springs
    mode = symmetric_part(tiny)[1] @ found["pod_mode_motion"].to_numpy()
    K, _ = assemble_assembly(tiny)
    moved = (relative_displacements(tiny) @ mode).reshape(area.size, 3, -1)[:, [0, 2]]
    spring = 7e13 * area * (loaded > 0)
    energy = mode.T @ (K @ mode) + np.einsum("p,pdi,pdj->ij", spring, moved, moved)
    # stiffnesses are lost in rounding by the ratio of the largest to that of the bar
    np.testing.assert_allclose(energy, np.eye(len(energy)), atol=1e-6)


def test_a_condition_has_the_law_of_its_case(assembly, preload):
    contact = {**COULOMB, "law": "iwan", "chi": -0.5, "beta": 1.0}
    modes = find_modes(assembly, "free-4")
    made = ContactCondition.of(contact, 1e-3).connect(preload, modes)
    assert made.law.declaration.name == "iwan"
    np.testing.assert_array_equal(made.law.chi, -0.5)
    found = find_pod_modes(assembly, preload, [ContactCondition.of(contact, 1e-3)], OPTIONS)
    # an element of this law slips at any amplitude: the backbone must reach where all of it slips
    assert found["amplitude_error"][0] > 1e-6


def test_a_basis_of_two_surfaces_has_the_errors_that_it_estimates(structure):
    x = structure.contact.position[:, 0]
    names = np.where(x < x.mean(), "left", "right")
    two = replace(structure, contact=replace(structure.contact, surface=names))
    preload = apply_preload(two, 8e3)
    right = {
        "name": "right",
        "friction_coefficient": 0.3,
        "tangential_stiffness_N_per_m3": 2e13,
    }
    contact = {
        "law": "constant",
        "tangential_stiffness_N_per_m": 1e8,
        "friction_coefficient": 0.1,
        "surfaces": [right],
    }
    condition = ContactCondition.of(contact, 2e-3)
    pod_modes = find_pod_modes(two, preload, [condition], ContactAdaptedBasis(maximum_vectors=50))
    few, many = (find_modes(two, f"enriched-{n}", pod_modes) for n in ("auto", 50))
    peaks = []
    for modes in (few, many):
        branch = solve_branch(condition.connect(preload, modes), 50.0, damping=2e-3)
        peaks.append((branch.frequency[branch.peak], branch.amplitude[branch.peak]))
    errors = abs(np.divide(*peaks) - 1)
    for error, what in zip(errors, ("frequency", "amplitude"), strict=True):
        assert error < few.attrs[f"estimated_{what}_error"]


def test_more_vectors_err_at_most_as_fewer_that_were_tried():
    tried = xr.Dataset(
        {
            "trial_vectors": ("trial", [8, 16]),
            "frequency_error": ("trial", [4e-3, 1e-3]),
            "amplitude_error": ("trial", [0.2, 0.03]),
        }
    )
    exact = {"estimated_frequency_error": 1e-3, "estimated_amplitude_error": 0.03}
    assert estimated_errors(tried, 16) == exact
    assert estimated_errors(tried, 20) == exact
    assert estimated_errors(tried, 12)["estimated_amplitude_error"] == 0.2
    assert estimated_errors(tried, 4) == {}
