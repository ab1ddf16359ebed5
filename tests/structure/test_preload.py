"""Preload and contact: laws, closed forms, equilibrium, and how a failed search shows."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from examples import assemble_assembly, block_on_ground, free_displacements, relative_displacements

from boltjoint.dataset import save
from boltjoint.structure import contact_equilibrium
from boltjoint.structure.contact_equilibrium import contact_force, solve_contact
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.preload import apply_preload


def test_derivative_of_the_contact_law():
    rng = np.random.default_rng(1)
    relative, stiffness = rng.uniform(-1, 1, (400, 3)) * [0.3, 0.3, 1], rng.uniform(0.5, 2, 400)
    force, derivative = contact_force(relative, stiffness, 0.4)
    sticking = abs(force[:, :2] - stiffness[:, None] * relative[:, :2]).max(axis=1) == 0
    states = [np.sum(relative[:, 2] < 0), np.sum(sticking & (force[:, 2] > 0))]
    assert min(*states, 400 - sum(states)) > 20
    step = 1e-6
    for axis, unit in enumerate(np.eye(3)):
        ahead, behind = (
            contact_force(relative + s * unit, stiffness, 0.4)[0] for s in (step, -step)
        )
        # central differences: step^2 from truncation, 1e-16 / step from rounding
        np.testing.assert_allclose(
            derivative[..., axis], (ahead - behind) / (2 * step), atol=2e-8 / 0.02
        )


def test_contact_law_obeys_coulomb_and_never_pulls():
    rng = np.random.default_rng(2)
    force, _ = contact_force(rng.uniform(-1, 1, (400, 3)), np.full(400, 3.0), 0.4)
    assert force[:, 2].min() >= 0
    assert np.all(np.linalg.norm(force[:, :2], axis=1) <= 0.4 * force[:, 2] * (1 + 1e-14))


def test_uniform_pressure_passes_through_a_block():
    K, C, stiffness, area, coordinate, _ = block_on_ground((4, 2, 3), 200e9, 1e14)
    pressure = 5e6
    force = np.zeros(K.shape[0])
    top = np.flatnonzero(np.isclose(coordinate[:, 2], 0.01))
    # nodes of top and base stand in the same order
    force[3 * top + 2] = -pressure * area
    found = solve_contact(K, C, stiffness, 0.0, force)
    assert found.converged
    np.testing.assert_allclose(found.force[:, 2] / area, pressure, rtol=1e-9)
    np.testing.assert_allclose(found.relative[:, 2], pressure / 1e14, rtol=1e-9)


def test_eccentric_load_lifts_one_end_of_a_stiff_block():
    # A rigid block on springs that only push, load P at distance e > L / 6 from the middle: the
    # contact length is 3 (L / 2 - e), the pressure triangular.
    P, e, L = 100.0, 0.012, 0.04
    K, C, stiffness, area, coordinate, base = block_on_ground((80, 1, 2), 1e12, 1e10)
    force = np.zeros(K.shape[0])
    node = np.flatnonzero(
        np.isclose(coordinate[:, 2], 0.01) & np.isclose(coordinate[:, 0], L / 2 + e)
    )
    force[3 * node + 2] = -P / len(node)
    found = solve_contact(K, C, stiffness, 0.3, force)
    x, load = coordinate[base, 0], found.force[:, 2]
    length = 3 * (L / 2 - e)
    exact = np.maximum(x - (L - length), 0) * 2 * P / (length**2 * 0.01)
    assert found.converged
    assert load.sum() == pytest.approx(P, rel=1e-9)
    assert np.sum(load * (x - L / 2)) == pytest.approx(P * e, rel=1e-9)
    # the edge of the contact falls between two of 80 nodes
    np.testing.assert_allclose(load / area, exact, atol=0.01 * exact.max())


def test_loads_add_up_to_the_bolts(assembly, preload):
    load = preload["normal_load"]
    assert float(load.sum()) == pytest.approx(8e3 * assembly.sizes["bolt"], rel=1e-8)
    friction = preload["friction_force"].to_numpy()
    along, across = abs(friction.sum(axis=0)) / abs(friction).sum()
    assert across < 1e-9
    # along the bar the shanks take the rest: head and nut differ, so they bend a little
    assert along < 0.01


def test_pairs_push_or_gape_never_both(preload):
    load, gap = preload["normal_load"].to_numpy(), preload["gap"].to_numpy()
    assert load.min() == 0 and gap.min() == 0
    np.testing.assert_array_equal(load > 0, gap == 0)
    friction = np.linalg.norm(preload["friction_force"], axis=1)
    assert np.all(friction <= 0.1 * load * (1 + 1e-12))
    assert 0.3 < np.mean(load > 0) < 1


def test_displacements_show_the_gaps_and_the_shortening(assembly, preload):
    u = preload["displacement"].to_numpy()
    a, b = assembly["pair_node"].to_numpy().T
    opening = u[b, 2] - u[a, 2]
    is_open = preload["gap"].to_numpy() > 0
    np.testing.assert_allclose(opening[is_open], preload["gap"].to_numpy()[is_open], rtol=1e-9)
    nut, head = assembly["section_node"].to_numpy().T
    shortening = preload["shank_shortening"].to_numpy()[assembly["section_bolt"].to_numpy()]
    np.testing.assert_allclose(u[nut] - u[head], np.outer(shortening, [0, 0, 1]), atol=1e-18)
    assert not u[assembly["coordinate"].sel(axis="x").to_numpy() < 1e-9].any()
    assert preload["shank_shortening"].min() > 0


def test_the_symmetric_half_has_the_equilibrium_of_the_whole(assembly):
    preload = apply_preload(assembly, 8e3, tolerance=1e-12)
    T = free_displacements(assembly, tightened=True)
    force = np.zeros(T.shape[1])
    force[-assembly.sizes["bolt"] :] = 8e3
    whole = solve_contact(
        (T.T @ assemble_assembly(assembly)[0] @ T).tocsc(),
        relative_displacements(assembly) @ T,
        assembly["contact_penalty"].item() * assembly["area"].to_numpy(),
        assembly["friction_coefficient"].item(),
        force,
        tolerance=1e-12,
    )
    np.testing.assert_allclose(preload["normal_load"], whole.force[:, 2], atol=1e-7)
    np.testing.assert_allclose(preload["friction_force"], whole.force[:, :2], atol=1e-7)
    shape = (T @ whole.unknown).reshape(-1, 3)
    np.testing.assert_allclose(preload["displacement"], shape, atol=1e-10 * abs(shape).max())


def test_pairs_have_their_surface_and_directions(coarse, structure, preload, modes):
    assert set(structure.contact.surface) == set(coarse.surface_names)
    for found in (preload, modes):
        assert set(found["surface"].to_numpy()) == set(structure.contact.surface)
        np.testing.assert_array_equal(found["frame"], structure.contact.frame)
        assert list(found["direction"].to_numpy()) == ["t1", "t2", "n"]


def test_search_is_short_and_reported(preload):
    residual = preload["residual"].to_numpy()
    assert len(residual) == preload["iterations"] + 1 <= 13
    assert residual[0] == 1 and residual[-1] <= 1e-10


def test_twice_the_preload_doubles_everything(assembly, preload):
    # nothing gapes before the bolts are tight, so the problem is homogeneous of degree one
    doubled = apply_preload(assembly, 16e3)
    for name, size in (("normal_load", 1e3), ("gap", 1e-6), ("shank_shortening", 1e-5)):
        np.testing.assert_allclose(doubled[name], 2 * preload[name], rtol=1e-6, atol=1e-7 * size)


def test_friction_hardly_moves_the_normal_loads(assembly, preload):
    frictionless = assembly.assign(friction_coefficient=0 * assembly["friction_coefficient"])
    without = apply_preload(frictionless, 8e3)
    assert not without["friction_force"].any()
    # the halves of the lap are alike and spread alike under the heads
    np.testing.assert_allclose(without["normal_load"], preload["normal_load"], atol=1.0)


@pytest.mark.parametrize("friction_coefficient", [1e-3, 0.01, 0.03])
def test_weak_friction_that_turns_round_converges(assembly, friction_coefficient):
    # full Newton steps go to and fro at 0.01
    mu = friction_coefficient + 0 * assembly["friction_coefficient"]
    found = apply_preload(assembly.assign(friction_coefficient=mu), 8e3)
    assert found["iterations"] <= 20
    load = found["normal_load"].to_numpy()
    friction = np.linalg.norm(found["friction_force"], axis=1)
    assert np.all(friction <= friction_coefficient * load * (1 + 1e-12))


def test_old_factors_give_the_solution_of_new_ones(assembly, preload, monkeypatch):
    monkeypatch.setattr(contact_equilibrium, "_MAXIMUM_LINEAR_ITERATIONS", 1)
    renewed = apply_preload(assembly, 8e3)
    # both leave 1e-10 of the preload unbalanced
    np.testing.assert_allclose(renewed["normal_load"], preload["normal_load"], atol=1e-5)


@pytest.mark.parametrize(
    ("change", "preload_N", "options"),
    [
        ({}, 8e3, {"maximum_iterations": 2}),
        # too stiff, and too soft, to be told from rounding
        ({"contact_penalty": 1e25}, 8e3, {}),
        ({"contact_penalty": 1e-300}, 8e3, {}),
        # neither shape nor force of a nearly incompressible material
        ({"poissons_ratio": 0.4999999999999}, 8e3, {}),
    ],
)
@pytest.mark.filterwarnings("ignore:.*encountered:RuntimeWarning")
def test_a_search_without_equilibrium_ends_with_what_to_do(tiny, change, preload_N, options):
    changed = tiny.assign({name: tiny[name].copy(data=value) for name, value in change.items()})
    with pytest.raises(RuntimeError, match="no equilibrium after") as caught:
        apply_preload(changed, preload_N, **options)
    (sentence,) = str(caught.value).splitlines()
    assert sentence.startswith(f"preload {preload_N:g} N: ")
    assert "contact.penalty_N_per_m3 of the assembly" in sentence


@pytest.mark.filterwarnings("ignore:.*encountered:RuntimeWarning")
def test_a_penalty_beyond_all_numbers_is_no_stiffness(assembly):
    penalty = assembly["contact_penalty"].copy(data=1e300)
    # which of both depends on how the processor rounds
    told = r"the stiffness matrix is singular|choose contact\.penalty_N_per_m3"
    with pytest.raises(RuntimeError, match=told):
        apply_preload(assembly.assign(contact_penalty=penalty), 8e3)


def test_a_preload_that_no_bolt_bears_is_told(tiny, caplog):
    # shanks of 8 mm, 200 GPa, 640 MPa: 50.27 mm2 strain by 0.32 % under 32.2 kN
    with caplog.at_level(logging.WARNING):
        apply_preload(tiny, 32e3)
        assert not caplog.records
        apply_preload(tiny, 40e3)
    (record,) = caplog.records
    assert "40000 N strains the shanks by 0.40%, more than the 0.32%" in record.getMessage()


def test_of_several_bolts_that_farthest_beyond_yield_is_told(tiny, caplog):
    structure = structure_of(tiny)
    first, second = structure.bolts
    weak, strong = replace(first, yield_strength=240e6), replace(second, yield_strength=940e6)
    # 300 of 240 MPa, and 950 of 940 MPa
    tension = [300e6 * weak.section, 950e6 * strong.section]
    with caplog.at_level(logging.WARNING):
        apply_preload(replace(structure, bolts=(weak, strong)), tension)
    (record,) = caplog.records
    assert "bolts of 240 MPa (yield_strength_MPa) yield" in record.getMessage()


@pytest.mark.parametrize("preload_N", [0.0, -5.0, np.nan, np.inf])
def test_refuses_a_preload_that_is_none(assembly, preload_N):
    with pytest.raises(ValueError, match=r"preload is .*: it must be"):
        apply_preload(assembly, preload_N)


def test_every_variable_has_units(preload, tmp_path):
    save(preload, tmp_path / "preload.nc")


def test_result_is_the_same_every_time(assembly, preload):
    assert preload.identical(apply_preload(assembly, 8e3))


def test_one_preload_for_each_bolt(assembly, preload):
    both = apply_preload(assembly, [8e3, 8e3])
    np.testing.assert_array_equal(both["normal_load"], preload["normal_load"])
    first, second = (apply_preload(assembly, each) for each in ([8e3, 2e3], [2e3, 8e3]))
    x = assembly["position"].to_numpy()[:, 0]
    side = np.sign(x - assembly["bolt_position"].to_numpy()[:, 0].mean())
    for found, loaded in ((first, -1), (second, 1)):
        load = found["normal_load"].to_numpy()
        # what is tightened is carried, each bolt by the contact around it
        assert load.sum() == pytest.approx(10e3, rel=0.05)
        assert load[side == loaded].sum() == pytest.approx(8e3, rel=0.05)


def test_a_bolt_without_preload_opens_the_contact_beside_it(assembly):
    found = apply_preload(assembly, [8e3, 0.0])
    away = assembly["position"][:, 0] - assembly["bolt_position"][1, 0].item()
    near = abs(away.to_numpy()) < 5e-3
    assert not found["normal_load"].to_numpy()[near].any()
    assert found["gap"].to_numpy()[near].min() > 0
    assert found.attrs["preload_N"] == [8e3, 0.0]
    # as tight together as alone
    doubled = apply_preload(assembly, [16e3, 0.0])
    np.testing.assert_allclose(doubled["normal_load"], 2 * found["normal_load"], atol=1e-4)


@pytest.mark.parametrize("preload", [[0.0, 0.0], [8e3], [8e3, -1.0], [8e3, np.nan]])
def test_refuses_preloads_that_bolts_do_not_have(assembly, preload):
    with pytest.raises(ValueError, match="preload"):
        apply_preload(assembly, preload)
