"""Friction along both tangents of the contact: contact-adapted bases, and planes of symmetry."""

from dataclasses import replace

import numpy as np
import pytest
from examples import block_with_two_interfaces
from scipy.linalg import eigh
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh, spsolve

from boltjoint import solve_branch
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.registry import LAWS
from boltjoint.joint.node_to_node import connect_pairs
from boltjoint.structure.adapted_basis.candidates import SpringContact, find_candidates
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.model import Row, Structure
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

LOSS_FACTOR = 0.01
OPTIONS = ContactAdaptedBasis(
    free_modes=4, states=12, adaptations=3, balanced_vectors=8, trial_step=1
)
CONTACT = {"tangential_stiffness_N_per_m": 3e8, "friction_coefficient": 0.3}


@pytest.fixture(scope="module")
def lap(tiny):
    """A lap whose symmetry is not used, and its preload."""
    structure = replace(structure_of(tiny), symmetry=None, maker="")
    return structure, apply_preload(structure, 8e3)


@pytest.fixture(scope="module")
def block():
    """A body between two interfaces, one of them tilted, and its preload.

    A mass that shears both interfaces along both tangents makes its first mode, at a seventh of the
    next one.
    """
    K, M, contact, bolt = block_with_two_interfaces()
    shear = np.zeros(len(K))
    shear[[0, 1, 3, 4]] = [0.5, 0.5, 0.5, -0.5]
    rows = {"inputs": {"shaker": shear}, "outputs": {"sensor": shear}}
    heavy = M + 200 * np.outer(shear, shear)
    structure = Structure.from_matrices(K, heavy, contact, bolts={"one": bolt}, **rows)
    return structure, apply_preload(structure, 5e3, tolerance=1e-13)


def test_candidates_hold_the_response_to_forces_along_both_tangents(lap):
    structure, preload = lap
    both, first = (find_candidates(*lap, 6, second_tangents=each) for each in (True, False))
    assert first.lateral is None
    C = structure.contact.relative[:, structure.moving]
    K = structure.stiffness[structure.moving][:, structure.moving].tocsc()
    # unit forces on one point, along t1, t2 and n
    point = int(preload["normal_load"].to_numpy().argmax())
    expected = C @ spsolve(K, C[[3 * point, 3 * point + 1, 3 * point + 2]].T.tocsc()).toarray()
    for candidates, directions in ((both, (0, 2, 1)), (first, (0, 2))):
        pairs = len(candidates.weight)
        rows = candidates.rows.reshape(len(directions), pairs, -1)
        for i, d in enumerate(directions):
            found = rows @ rows[i, point]
            for j, other in enumerate(directions):
                scale = abs(expected).max()
                np.testing.assert_allclose(found[j], expected[other::3, d], atol=1e-8 * scale)


def test_springs_along_both_tangents_have_the_resonances_of_the_whole(lap):
    structure, preload = lap
    stiffness = 3e7 * (preload["normal_load"].to_numpy() > 0)
    C = structure.contact.relative[:, structure.moving]
    K, M = (
        each[structure.moving][:, structure.moving]
        for each in (structure.stiffness, structure.mass)
    )
    springs = diags_array(np.outer(stiffness, [1.0, 1.0, 0.0]).ravel())
    stuck = (K + C.T @ springs @ C).tocsc()
    start = np.ones(stuck.shape[0])
    expected = np.sort(eigsh(stuck, 4, M.tocsc(), sigma=0.0, v0=start)[0])
    candidates = find_candidates(structure, preload, 12, second_tangents=True)
    none = np.zeros_like(stiffness)
    contact = SpringContact(candidates, stiffness, none, stiffness)
    squared, _ = contact.modes(4, np.ones(len(candidates.mass)))
    # of modes beyond the twelfth the inertia is missing
    np.testing.assert_allclose(squared, expected, rtol=1e-4)
    assert np.all(squared >= expected * (1 - 1e-9))
    # candidates of first tangents alone cannot follow the springs along the second ones
    first = find_candidates(structure, preload, 12)
    V = first.vector @ first.coordinate
    too_stiff = eigh(V.T @ (stuck @ V), first.mass, eigvals_only=True)[:4]
    assert np.max(too_stiff / expected) > 1.01


@pytest.mark.parametrize("law", ["uncoupled-constant", "coupled-constant"])
def test_peaks_in_the_basis_are_those_of_all_modes_within_its_estimate(block, law):
    structure, preload = block
    condition, along_one = (
        ContactCondition.of({"law": each, **CONTACT}, LOSS_FACTOR) for each in (law, "constant")
    )
    found = find_pod_modes(structure, preload, [condition], OPTIONS)
    basis = find_modes(structure, "enriched-auto", found)
    assert basis.sizes["mode"] < structure.dofs
    # of its second tangents a basis for friction along one direction knows nothing
    found = find_pod_modes(structure, preload, [along_one], OPTIONS)
    one = find_modes(structure, f"enriched-{basis.sizes['mode']}", found)
    joints = [
        condition.connect(preload, modes)
        for modes in (find_modes(structure, f"all-{structure.dofs}"), basis, one)
    ]
    if not condition.contact.declaration.has_closed_form:
        joints = [
            replace(each, law=AlternatingFrequencyTime(each.law, samples=64)) for each in joints
        ]
    for force in (10.0, 60.0):
        branches = [solve_branch(each, force, damping=LOSS_FACTOR) for each in joints]
        assert all(each.complete for each in branches)
        for name in ("frequency", "amplitude"):
            whole, both, first = (getattr(each, f"peak_{name}") for each in branches)
            estimate = basis.attrs[f"estimated_{name}_error"]
            assert estimate < 1e-2
            # the estimate is of the first order
            assert abs(both / whole - 1) < 1.5 * estimate
            assert abs(first / whole - 1) > 0.05


@pytest.fixture(scope="module")
def halves_and_whole(tiny):
    """A lap that is driven across its plane of symmetry as well as in it, and its preload.

    Twice: its symmetry used, and forgotten.
    """
    structure = structure_of(tiny)
    geometry = structure.geometry
    corner = int(np.argmax(geometry.node.sum(axis=1)))
    row = Row(geometry.displacement[[3 * corner + 1, 3 * corner + 2]].sum(axis=0))
    used = replace(structure, inputs={"shaker": row}, outputs={"sensor": row})
    assert used.symmetry is not None
    return [(each, apply_preload(each, 8e3)) for each in (used, used.without_symmetry())]


def sampled(joint, samples=64):
    """The joint with its friction followed at samples, where it has no closed form."""
    if joint.law.closed_form is not None:
        return joint
    return replace(joint, law=AlternatingFrequencyTime(joint.law, samples=samples))


def peaks_under(joint):
    """Peaks [Hz, m] at forces that let little and much of the contact slip, shape (2, 2)."""
    branches = [solve_branch(sampled(joint), force, damping=5e-3) for force in (1.0, 20.0)]
    assert all(each.complete for each in branches)
    return np.array([[each.peak_frequency, each.peak_amplitude] for each in branches])


@pytest.mark.parametrize("load", ["constant", "variable"])
@pytest.mark.parametrize("friction", ["uncoupled", "coupled"])
def test_peaks_with_both_tangents_are_the_same_with_and_without_the_symmetry(
    halves_and_whole, friction, load
):
    keys = {"tangential_stiffness": 2e7, "friction_coefficient": 0.1}
    if load == "variable":
        keys["normal_stiffness"] = 2e7
    found, along_one = [], []
    for structure, preload in halves_and_whole:
        modes = find_modes(structure, "all-8")
        # of both halves of the motion, and all of them driven
        assert {"bending", "lateral"} <= set(modes["candidate_family"].to_numpy())
        assert np.all(abs(modes["excitation_mode"]) > 0.1)
        found.append(peaks_under(connect_pairs(modes, preload, LAWS[f"{friction}-{load}"], **keys)))
        along_one.append(peaks_under(connect_pairs(modes, preload, LAWS[load], **keys)))
    # loads are those of one solution to 1e-10 of the preload
    np.testing.assert_allclose(found[1], found[0], rtol=1e-9)
    np.testing.assert_allclose(along_one[1], along_one[0], rtol=1e-9)
    assert np.max(abs(found[0] / along_one[0] - 1)) > 0.01


def test_a_basis_for_both_tangents_is_the_same_with_and_without_the_symmetry(halves_and_whole):
    contact = {"law": "uncoupled-constant", **CONTACT, "tangential_stiffness_N_per_m": 2e7}
    condition = ContactCondition.of(contact, 5e-3)
    options = OPTIONS.model_copy(update={"free_modes": 8, "states": 8, "adaptations": 2})
    found, estimates = [], []
    for structure, preload in halves_and_whole:
        pod_modes = find_pod_modes(structure, preload, [condition], options)
        basis = find_modes(structure, "enriched-12", pod_modes)
        estimates.append([basis.attrs[f"estimated_{n}_error"] for n in ("frequency", "amplitude")])
        found.append(peaks_under(condition.connect(preload, basis)))
    # of mirror images rounding tells which slips first
    assert np.all(abs(found[1] / found[0] - 1) < 0.01 * np.array(estimates[0]))
    np.testing.assert_allclose(estimates[1], estimates[0], rtol=0.02)
