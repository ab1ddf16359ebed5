"""Where a structure moves, slips and is stressed most."""

from dataclasses import replace

import numpy as np
import pytest
from element_meshes import box_of
from scipy import sparse

from boltjoint.structure.elements.kinds import KINDS
from boltjoint.structure.geometry import CellMaterial, CentreStresses, Geometry
from boltjoint.structure.modes import find_modes
from boltjoint.structure.modes_at_limits import modes_at_limits

E, NU = 206e9, 0.3


def geometry_of(name, turn=None, **box):
    """Cells of one kind in the order of VTK, whose displacements are the degrees of freedom."""
    node, block = box_of(name, **box)
    cell = block.connectivity[:, block.kind.vtk_order]
    of_cells = (np.full(len(cell), value) for value in (E, NU, 355e6))
    motion = sparse.eye_array(3 * len(node), format="csc")
    node = node if turn is None else node @ turn.T
    return Geometry(node, motion, cell, np.zeros(len(cell), int), CellMaterial(*of_cells))


@pytest.mark.parametrize("name", KINDS)
def test_a_bar_in_tension_has_the_stress_of_its_force_in_any_direction(name):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    geometry = geometry_of(name, turn, divisions=(2, 3, 2), size=(0.2, 0.3, 0.1), amount=0.2)
    strain = turn @ np.diag([1e-3, -NU * 1e-3, -NU * 1e-3]) @ turn.T
    stress = CentreStresses(geometry, np.arange(len(geometry.cell)))(geometry.node @ strain)
    np.testing.assert_allclose(np.linalg.norm(stress, axis=1), E * 1e-3, rtol=1e-9)


@pytest.mark.parametrize("name", KINDS)
def test_shear_has_root_three_times_its_stress(name):
    geometry = geometry_of(name, divisions=(1, 1, 1))
    displacement = np.zeros_like(geometry.node)
    displacement[:, 0] = 2e-3 * geometry.node[:, 2]
    stress = CentreStresses(geometry, np.arange(len(geometry.cell)))(displacement)
    expected = np.sqrt(3) * E / (2 * (1 + NU)) * 2e-3
    np.testing.assert_allclose(np.linalg.norm(stress, axis=1), expected, rtol=1e-9)


@pytest.mark.parametrize("name", ["C3D8", "C3D10", "C3D15", "C3D20"])
def test_bending_stresses_the_centre_of_a_cell_by_its_distance_from_the_middle(name):
    geometry = geometry_of(name, divisions=(4, 1, 4), size=(0.4, 0.02, 0.02))
    x, y, z = (geometry.node - [0, 0.01, 0.01]).T
    curvature = 0.05
    displacement = curvature * np.column_stack(
        [x * z, -NU * y * z, -(x**2) / 2 - NU * (z**2 - y**2) / 2]
    )
    stress = CentreStresses(geometry, np.arange(len(geometry.cell)))(displacement)
    corners = geometry.cell[:, : KINDS[name].corners]
    distance = abs(z[corners].mean(axis=1))
    np.testing.assert_allclose(
        np.linalg.norm(stress, axis=1), E * curvature * distance, rtol=1e-9, atol=1.0
    )


def test_cells_of_other_kinds_are_refused():
    geometry = geometry_of("C3D8", divisions=(1, 1, 1))
    odd = replace(geometry, cell=geometry.cell[:, :5])
    with pytest.raises(ValueError, match="a cell has 5 nodes: stresses of such cells"):
        CentreStresses(odd, np.array([0]))
    with pytest.raises(ValueError, match="the geometry has no material"):
        CentreStresses(replace(geometry, material=None), np.array([0]))


def test_stress_is_that_of_the_cell_which_a_mode_stresses_most(structure):
    modes = find_modes(structure, "free-3")
    geometry = structure.geometry
    every = CentreStresses(geometry, np.arange(len(geometry.cell)))
    shape = modes["mode_shape"].transpose("mode", "node", "axis").to_numpy()
    size = np.array([np.linalg.norm(every(mode), axis=1) for mode in shape])
    contact = np.unique(structure.contact.relative.tocoo().coords[1])
    near = geometry.displacement.tocsr()[:, contact]
    nodes = np.unique(near.tocoo().coords[0] // 3)
    far = ~np.isin(geometry.cell, nodes).any(axis=1)
    share = np.where(far, size / geometry.material.yield_strength, 0.0)
    found = (
        np.linalg.norm(modes["stress_mode"], axis=1) / modes["yield_strength"].to_numpy()[:, None]
    )
    np.testing.assert_allclose(found.max(axis=0), share.max(axis=1), rtol=1e-12)


def test_slip_at_a_hole_is_that_of_the_pairs_around_it(coarse, assembly, modes):
    bolt = assembly["bolt_position"].to_numpy()[:, None, :2]
    apart = np.linalg.norm(assembly["position"].to_numpy()[:, :2] - bolt, axis=2)
    radius = float(assembly["hole_diameter"]) / 2
    relative = modes["relative_mode"].transpose("pair", "axis", "mode").to_numpy()
    for place, distance in enumerate(apart):
        at_edge = relative[np.isclose(distance, radius, rtol=0.02)]
        assert len(at_edge) >= 8
        np.testing.assert_allclose(modes["hole_mode"][place], at_edge[:, :2].mean(axis=0))
    clearance = coarse.bolts.hole_diameter_mm - coarse.bolts.shank_diameter_mm
    np.testing.assert_allclose(modes["hole_clearance"], 1e-3 * clearance)


def test_strengths_are_those_of_steel_where_the_material_is_one_unless_given(coarse, structure):
    bolts, bars = coarse.bolts, coarse.material
    assert bars.youngs_modulus_GPa > 180
    assert bolts.yield_strengths(bars) == (355e6, 640e6)
    assert set(structure.geometry.material.yield_strength) == {355e6, 640e6}
    given = bars.model_copy(update={"yield_strength_MPa": 240.0})
    assert bolts.yield_strengths(given) == (240e6, 640e6)
    own = bolts.model_copy(update={"material": given})
    assert own.yield_strengths(bars) == (355e6, 240e6)
    aluminium = bars.model_copy(update={"youngs_modulus_GPa": 70.0})
    assert np.isnan(bolts.yield_strengths(aluminium)).all()


def test_what_is_not_known_limits_nothing(structure):
    q = np.eye(structure.dofs)[:, :2]
    bolts = tuple(replace(bolt, hole_clearance=None) for bolt in structure.bolts)
    bare = replace(structure, bolts=bolts, geometry=None)
    assert modes_at_limits(bare, q) == {}
    without = replace(structure, bolts=bolts, geometry=replace(structure.geometry, material=None))
    assert set(modes_at_limits(without, q)) == {"structure_length", "farthest_mode"}


def test_a_clearance_without_an_axis_or_a_size_is_refused(structure):
    bolt = structure.bolts[0]
    with pytest.raises(ValueError, match="bolt 1 has a hole_clearance, but no axis and position"):
        replace(bolt, axis=None)
    for wrong in (0.0, -1e-3, np.nan):
        with pytest.raises(ValueError, match="hole_clearance of bolt 1"):
            replace(bolt, hole_clearance=wrong)


def test_assemblies_from_before_have_fewer_limits(assembly):
    old = assembly.drop_vars(["part_yield_strength", "hole_clearance"])
    found = find_modes(old, "free-1")
    assert "farthest_mode" in found
    assert not {"stress_mode", "hole_mode"} & set(found)


def test_the_extent_is_the_longest_one_and_the_nodes_move_most(structure, modes):
    assert modes["structure_length"] == np.ptp(structure.geometry.node[:, 0])
    shape = modes["mode_shape"].transpose("node", "axis", "mode").to_numpy()
    farthest = np.linalg.norm(shape, axis=1).max(axis=0)
    kept = np.linalg.norm(modes["farthest_mode"], axis=1)
    np.testing.assert_array_equal(kept.max(axis=0), farthest)
