"""Contact-adapted bases: symmetry, candidates, snapshots and convergence with their number."""

import numpy as np
import pytest
from scipy.linalg import eigh

from boltjoint.config.contact_adapted_basis import ContactAdaptedBasis
from boltjoint.dataset import save
from boltjoint.structure.basis.candidates import SpringContact, find_candidates
from boltjoint.structure.basis.pod import find_pod_modes, proper_orthogonal_modes
from boltjoint.structure.basis.snapshots import (
    _describing_function,
    _energy_norm,
    _NormalLoad,
    _SlippingMode,
    slipping_snapshots,
    stuck_snapshots,
)
from boltjoint.structure.constraints import assemble_assembly, factorise, relative_displacements
from boltjoint.structure.modes import find_modes
from boltjoint.structure.patterns import resonances, resonances_in
from boltjoint.structure.symmetry import symmetric_half

SMALL = ContactAdaptedBasis(slip_levels=5)


@pytest.fixture(scope="module")
def half(assembly):
    return symmetric_half(assembly)


@pytest.fixture(scope="module")
def candidates(assembly, preload, half):
    return find_candidates(assembly, preload, half, SMALL.free_modes)


@pytest.fixture(scope="module")
def pod_modes(assembly, preload):
    return find_pod_modes(assembly, preload, SMALL)


@pytest.fixture(scope="module")
def enriched(assembly, pod_modes):
    return find_modes(assembly, "enriched-24", pod_modes)


def test_symmetric_unknowns_have_the_symmetric_modes_of_the_whole(assembly, half):
    whole = find_modes(assembly, "free-3")
    symmetric = whole["symmetric_share"].to_numpy() > 0.5
    expected = whole["candidate_frequency"].to_numpy()[symmetric]
    squared, _ = half.modes(factorise(half.stiffness), half.stiffness, len(expected))
    np.testing.assert_allclose(np.sqrt(squared) / (2 * np.pi), expected, rtol=1e-8)


def test_a_mesh_without_symmetry_is_refused(assembly, preload):
    moved = assembly.copy(deep=True)
    moved["coordinate"][5, 1] += 1e-5
    with pytest.raises(ValueError, match="not symmetric about y = 0"):
        find_pod_modes(moved, preload, SMALL)


def test_candidates_have_unit_stiffness_and_their_mass(candidates, half):
    shape = candidates.vector @ candidates.coordinate
    # the static shapes of neighbouring pairs are alike: rounding grows by their condition
    np.testing.assert_allclose(shape.T @ half.stiffness @ shape, np.eye(shape.shape[1]), atol=1e-8)
    mass = shape.T @ half.mass @ shape
    np.testing.assert_allclose(candidates.mass, mass, atol=1e-8 * mass.max())


def test_candidates_hold_the_response_to_contact_forces_exactly(candidates, assembly, half):
    C = relative_displacements(assembly) @ half.displacement
    force = np.random.default_rng(1).standard_normal((2, len(candidates.weight)))
    upper = np.flatnonzero(assembly["position"][:, 1] > -1e-9)
    by_pair = np.zeros((assembly.sizes["pair"], 3))
    by_pair[upper, 0], by_pair[upper, 2] = force
    exact = C @ factorise(half.stiffness).solve(C.T @ by_pair.ravel())
    found = candidates.rows.T @ force.ravel()
    moved = candidates.rows @ found
    expected = exact.reshape(-1, 3)[upper][:, [0, 2]].T.ravel()
    np.testing.assert_allclose(moved, expected, atol=1e-9 * abs(expected).max())


def test_springs_by_woodbury_are_those_of_the_dense_matrix(candidates):
    rng = np.random.default_rng(2)
    n = len(candidates.weight)
    tangential, normal = rng.uniform(1e7, 1e8, n), np.where(rng.random(n) < 0.5, 0.0, 1e8)
    stiffness = np.concatenate([tangential, normal]) * np.tile(candidates.weight, 2)
    dense = np.eye(len(candidates.mass)) + candidates.rows.T @ (
        stiffness[:, None] * candidates.rows
    )
    force = rng.standard_normal(len(dense))
    contact = SpringContact(candidates, tangential, normal)
    np.testing.assert_allclose(
        contact.displacement(force), np.linalg.solve(dense, force), atol=1e-8
    )
    squared, mode = contact.modes(3, force)
    expected = eigh(dense, candidates.mass, eigvals_only=True, subset_by_index=[0, 2])
    np.testing.assert_allclose(squared, expected, rtol=1e-8)
    np.testing.assert_allclose(mode.T @ dense @ mode, np.eye(3), atol=1e-8)


def test_pod_modes_are_of_unit_energy_with_the_contact_stuck(assembly, preload, pod_modes):
    K, _ = assemble_assembly(assembly)
    vector = pod_modes["pod_mode_shape"].to_numpy().reshape(K.shape[0], -1)
    moved = relative_displacements(assembly) @ vector
    spring = 1e8 * np.outer(preload["normal_load"] > 0, [1, 0, 1]).ravel()
    energy = vector.T @ (K @ vector) + moved.T @ (spring[:, None] * moved)
    # the rarest have some 1e-12 of the energy of the first, so rounding turns them by 1e-4
    np.testing.assert_allclose(energy, np.eye(len(energy)), atol=1e-3)
    np.testing.assert_allclose(energy[:24, :24], np.eye(24), atol=1e-7)
    share = pod_modes["energy_share"].to_numpy()
    assert np.all(np.diff(share) < 0)
    assert 0.999 < share.sum() <= 1 + 1e-12


def test_fewer_pod_modes_are_the_first_of_more(assembly, preload, pod_modes):
    few = find_pod_modes(assembly, preload, ContactAdaptedBasis(slip_levels=5, maximum_vectors=6))
    assert few.sizes["pod_mode"] == 6
    assert pod_modes.sizes["pod_mode"] == 80
    first = pod_modes["pod_mode_shape"][..., :6]
    # of another number of products, each rounded
    np.testing.assert_allclose(few["pod_mode_shape"], first, atol=1e-12 * abs(first).max())
    modes = [find_modes(assembly, "enriched-6", found) for found in (few, pod_modes)]
    np.testing.assert_allclose(*(found["natural_frequency"] for found in modes), rtol=1e-9)


def test_a_basis_holds_its_pod_modes(assembly, pod_modes, enriched):
    _, M = assemble_assembly(assembly)
    shape = enriched["mode_shape"].to_numpy().reshape(M.shape[0], -1)
    vector = pod_modes["pod_mode_shape"].to_numpy()[..., :24].reshape(M.shape[0], -1)
    held = shape @ (shape.T @ (M @ vector))
    np.testing.assert_allclose(held, vector, atol=1e-10 * abs(vector).max())


def test_basis_is_orthonormal_in_mass_and_diagonal_in_stiffness(assembly, enriched):
    K, M = assemble_assembly(assembly)
    shape = enriched["mode_shape"].to_numpy().reshape(K.shape[0], -1)
    squared = (2 * np.pi * enriched["natural_frequency"].to_numpy()) ** 2
    assert np.all(np.diff(squared) > 0)
    np.testing.assert_allclose(shape.T @ M @ shape, np.eye(24), atol=1e-10)
    np.testing.assert_allclose(shape.T @ K @ shape, np.diag(squared), atol=1e-9 * squared.max())


def test_basis_is_exactly_symmetric(assembly, enriched):
    coordinate = assembly["position"].to_numpy()
    relative = enriched["relative_mode"].transpose("pair", "axis", "mode").to_numpy()
    distance = np.linalg.norm(coordinate[:, None] - coordinate * [1, -1, 1], axis=-1)
    image = np.argmin(distance, axis=1)
    np.testing.assert_array_equal(relative[image], relative * np.array([1, -1, 1])[:, None])


def test_basis_has_the_variables_of_modes(assembly, enriched, modes, tmp_path):
    candidate = {"candidate_frequency", "candidate_family", "energy_share", "symmetric_share"}
    assert set(enriched) == set(modes) - candidate
    for name in ("excitation", "response"):
        node = assembly[f"{name}_node"].item()
        np.testing.assert_array_equal(
            enriched[f"{name}_mode"], enriched["mode_shape"].sel(axis="z")[node]
        )
    save(enriched, tmp_path / "modes.nc")


def test_errors_fall_with_the_number_of_vectors(assembly, preload, pod_modes):
    all_stuck = {"all": preload["normal_load"].to_numpy() > 0}
    reference = resonances(assembly, preload, 1e8, all_stuck)

    errors = []
    for number in (4, 8, 16, 32):
        basis = find_modes(assembly, f"enriched-{number}", pod_modes)
        errors.append(resonances_in(basis, reference)["error"].max().item())
    # a basis can only be too stiff, but for rounding
    assert min(errors) > -1e-8
    assert np.all(np.diff(errors) < 0)
    # what the study asks of its bases at 40 vectors
    assert errors[-1] < 1e-3


def test_the_size_of_the_preload_does_not_matter(assembly, preload, enriched):
    twice = preload.assign(normal_load=2 * preload["normal_load"], gap=2 * preload["gap"])
    found = find_modes(assembly, "enriched-24", find_pod_modes(assembly, twice, SMALL))
    np.testing.assert_allclose(found["natural_frequency"], enriched["natural_frequency"], rtol=1e-6)


def test_snapshots_weigh_as_modes_of_the_first_resonance_do_or_less(candidates):
    stuck = list(stuck_snapshots(candidates, SMALL))
    # none stuck; by pressure and by distance, in five levels three parts of the lap, in two levels
    # two bolts and two sides, two sets of springs
    assert len(stuck) == 1 + 2 * (5 * 3 + 2 * (2 + 2)) * 2
    slipping = list(slipping_snapshots(candidates, SMALL))
    assert len(slipping) == 2 * 2 * (5 + 20)
    for snapshot in stuck:
        np.testing.assert_allclose(_energy_norm(candidates, snapshot, 1e8), [1.0, 0.2])
    for i, snapshots in enumerate(slipping):
        assert np.isfinite(snapshots).all()
        expected = [1.0, 0.2][i // 25 % 2]
        assert _energy_norm(candidates, snapshots[:, 0], 1e8) == pytest.approx(expected)
    constant, variable = slipping[:50], slipping[50:]
    assert all(not snapshots[:, [1, 3, 4]].any() for snapshots in constant)
    assert all(snapshots.any(axis=0).all() for snapshots in variable[5:25])


def _loss(candidates, slipping, mode, bias):
    """Friction over a period, over pi and the squared amplitude, summed over the phase."""
    k, mu, amplitude = 1e8, SMALL.friction_coefficient, slipping._amplitude
    u, v = abs(candidates.tangential @ mode), abs(candidates.normal @ mode)
    load = slipping._load + slipping._normal_stiffness * (candidates.normal @ bias)
    phase = 2 * np.pi * (np.arange(4000) + 0.5) / 4000
    swing = slipping._normal_stiffness * amplitude * v
    pressed = np.maximum(load[:, None] + swing[:, None] * np.sin(phase), 0.0)
    slip = mu * np.mean(pressed * abs(np.cos(phase)), axis=1) * np.pi / 2
    lost = 4 * slip * np.maximum(u - slip / (k * amplitude), 0.0) / amplitude
    return candidates.weight @ lost / np.pi


@pytest.mark.parametrize("variable", [False, True])
def test_gradients_of_the_loss_are_its_differences(candidates, variable):
    slipping = _SlippingMode(candidates, SMALL, 0, variable)
    slipping.slip(0.5)
    for _ in range(4):
        slipping.grow()
    mode, bias = slipping._mode, slipping._bias
    found = slipping._sensitivity()
    along = np.random.default_rng(4).standard_normal(len(mode)) * abs(mode).max()
    step = 1e-8

    def change(by_mode, by_bias):
        above, below = (
            _loss(candidates, slipping, mode + sign * by_mode, bias + sign * by_bias)
            for sign in (step, -step)
        )
        return (above - below) / (2 * step)

    def force(shape, tangential, normal):
        """What a static shape answers, under springs."""
        springs = np.concatenate([tangential, normal]) * np.tile(candidates.weight, 2)
        return shape + candidates.rows.T @ (springs * (candidates.rows @ shape))

    assert found.loss == pytest.approx(_loss(candidates, slipping, mode, bias), rel=1e-5)
    v = candidates.normal @ mode
    load, kn = slipping._normal_load(v), slipping._normal_stiffness
    stuck = slipping._in_phase
    # the bias follows the mode by its own balance of forces
    swing = kn * slipping._amplitude * load.by_amplitude * np.sign(v) * (candidates.normal @ along)
    follows = -SpringContact(candidates, stuck, kn * load.closed).displacement(
        candidates.normal.T @ (candidates.weight * swing)
    )
    gradient = force(found.loss_by_mode, stuck, kn * load.secant)
    assert gradient @ along == pytest.approx(change(along, follows), rel=1e-3)
    gradient = force(found.loss_by_bias, stuck, kn * load.closed)
    by_bias = change(0.0, slipping._amplitude * along)
    assert gradient @ along == pytest.approx(by_bias, rel=1e-3, abs=1e-12)


def test_snapshots_are_in_a_basis_of_their_rank(candidates):
    snapshots = np.random.default_rng(3).standard_normal((len(candidates.mass), 6))
    basis, energy = proper_orthogonal_modes(candidates, snapshots[:, [0, 1, 2, 3, 4, 5, 0]], 9, 1e8)
    assert basis.shape[1] == 6
    assert energy.sum() == pytest.approx(1, rel=1e-12)
    share = np.linalg.lstsq(basis, snapshots, rcond=None)[0]
    np.testing.assert_allclose(basis @ share, snapshots, atol=1e-8)


def test_one_bolt_alone_or_one_side_of_each_may_stick(assembly, preload, pod_modes):
    offset = (
        assembly["position"].to_numpy()[:, None, :2] - assembly["bolt_position"].to_numpy()[:, :2]
    )
    nearest = np.argmin(np.linalg.norm(offset, axis=-1), axis=1)
    loaded = preload["normal_load"].to_numpy() > 0
    beside = offset[np.arange(len(offset)), nearest, 0]
    parts = {"first bolt": nearest == 0, "second bolt": nearest == 1, "one side": beside > 0}
    patterns = {name: part & loaded for name, part in parts.items()}
    reference = resonances(assembly, preload, 1e8, patterns)
    error = resonances_in(find_modes(assembly, "enriched-40", pod_modes), reference)["error"]
    # what the study asks of its bases at 40 vectors
    assert error.sel(resonance=0).max() < 0.003
    assert error.sel(resonance=1).max() < 0.01


def test_describing_function_is_the_first_harmonic_of_the_loop():
    k, slip, amplitude = 3.0, 1.0, np.array([0.2, 0.5, 2.0])
    in_phase = _describing_function(k, np.full(3, slip), amplitude)
    phase = 2 * np.pi * np.arange(20000) / 20000
    force, harmonic = np.zeros(3), []
    for angle in np.tile(phase, 2):
        step = amplitude * np.cos(angle) * (2 * np.pi / 20000)
        force = np.clip(force + k * step, -slip, slip)
        harmonic.append(force)
    steady = np.array(harmonic[20000:])
    sine = 2 * np.mean(steady * np.sin(phase)[:, None], axis=0)
    # the loop is sampled with first order in the step of 3e-4
    np.testing.assert_allclose(in_phase, sine / amplitude, atol=2e-3 * k)


@pytest.mark.parametrize("load", [-3.0, -1.0, 0.0, 0.5, 4.0])
def test_normal_load_over_a_period(load):
    phase = 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    force = np.maximum(load + 2.0 * np.sin(phase), 0.0)
    found = _NormalLoad(np.array([load]), np.array([2.0]))
    # sampled with second order in the step, for the kink where the pair opens
    np.testing.assert_allclose(found.mean, force.mean(), atol=1e-5)
    np.testing.assert_allclose(found.secant, 2 * np.mean(force * np.sin(phase)) / 2.0, atol=1e-5)
    weighted = np.mean(force * abs(np.cos(phase))) * np.pi / 2
    np.testing.assert_allclose(found.sliding, weighted, atol=1e-5)
    step = 1e-6
    for derivative, by in (
        (("closed", "sliding_by_load"), (step, 0.0)),
        (("by_amplitude", "sliding_by_amplitude"), (0.0, step)),
    ):
        above, below = (
            _NormalLoad(np.array([load + sign * by[0]]), np.array([2.0 + sign * by[1]]))
            for sign in (1, -1)
        )
        for name, of in zip(derivative, ("mean", "sliding"), strict=True):
            slope = (getattr(above, of) - getattr(below, of)) / (2 * step)
            np.testing.assert_allclose(getattr(found, name), slope, atol=1e-5)


@pytest.mark.parametrize("load", [-1.0, 2.0])
def test_a_pair_at_rest_keeps_its_state(load):
    found = _NormalLoad(np.array([load]), np.zeros(1))
    pressed = (max(load, 0.0), float(load > 0), max(load, 0.0))
    assert (found.mean[0], found.secant[0], found.sliding[0]) == pressed


def test_needs_a_preload_that_fits(assembly, preload):
    with pytest.raises(ValueError, match="different contact pairs"):
        find_pod_modes(assembly, preload.assign(position=preload["position"] + 1e-3), SMALL)
    with pytest.raises(ValueError, match="no contact pair carries load"):
        find_pod_modes(assembly, preload.assign(normal_load=0 * preload["normal_load"]), SMALL)


def test_needs_pod_modes_that_fit(assembly, pod_modes):
    with pytest.raises(ValueError, match="enriched-8 needs POD modes"):
        find_modes(assembly, "enriched-8")
    with pytest.raises(ValueError, match="enriched-81: there are 80 POD modes"):
        find_modes(assembly, "enriched-81", pod_modes)
    for other in (
        pod_modes.assign(position=pod_modes["position"] + 1e-3),
        pod_modes.isel(node=slice(1, None)),
    ):
        with pytest.raises(ValueError, match="found on a different mesh"):
            find_modes(assembly, "enriched-8", other)


def test_needs_an_assembly_that_is_held(assembly, preload, pod_modes):
    loose = assembly.isel(clamped=slice(0, 0))
    with pytest.raises(RuntimeError, match="natural frequencies are zero within rounding"):
        find_pod_modes(loose, preload, SMALL)


@pytest.mark.filterwarnings("ignore:.*encountered:RuntimeWarning")
@pytest.mark.parametrize(
    "extreme",
    [
        {"contact_stiffness_N_per_m": 1e300},
        {"contact_stiffness_N_per_m": 1e-300},
        {"friction_coefficient": 1e300},
    ],
)
def test_snapshots_lost_in_rounding_are_refused(assembly, preload, extreme):
    with pytest.raises(
        RuntimeError, match="choose the values of contact_adapted_basis nearer to their"
    ):
        find_pod_modes(
            assembly, preload, ContactAdaptedBasis(slip_levels=1, resonances=1, **extreme)
        )


def test_result_is_the_same_every_time(assembly, preload, pod_modes, enriched, tmp_path):
    again = find_pod_modes(assembly, preload, SMALL)
    assert pod_modes.identical(again)
    assert enriched.identical(find_modes(assembly, "enriched-24", again))
    save(pod_modes, tmp_path / "contact_adapted_basis.nc")
