"""Wrong arguments of what builds and reduces structures: each is refused by its name."""

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from examples import brick_bar
from hostile_arguments import assert_refused
from scipy import sparse

from boltjoint.structure import contact_equilibrium, elasticity, patterns
from boltjoint.structure import preload as bolt_preload
from boltjoint.structure.adapted_basis.pod import basis_of_pod_modes
from boltjoint.structure.extrusion.blocks import extrude
from boltjoint.structure.extrusion.bolt_plan import bolt_plan
from boltjoint.structure.extrusion.cell import BoltRadii, CellDivisions
from boltjoint.structure.extrusion.plan import Plan, glue, rectangle_plan, tributary_area
from boltjoint.structure.makers.half_lap import structure
from boltjoint.structure.makers.half_lap.calculix import write_modes_deck, write_preload_deck
from boltjoint.structure.makers.half_lap.families import classify, symmetric_share
from boltjoint.structure.makers.half_lap.plan import lap_plan
from boltjoint.structure.makers.half_lap.structure import structure_of
from boltjoint.structure.modes import find_modes

NAN = np.nan
COORDINATE, CONNECTIVITY = brick_bar(1.0, 1.0, 1.0, (1, 1, 1))
STEEL = {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "density": 7800.0}
INVERTED = COORDINATE[CONNECTIVITY[:, [4, 5, 6, 7, 0, 1, 2, 3]]]
HOOKE = elasticity.elasticity_matrix(2e11, 0.3)
PLAN = rectangle_plan([0.0, 1.0], [0.0, 1.0])
RADII, DIVISIONS = BoltRadii(4e-3, 4.5e-3, 6.5e-3), CellDivisions(4, 5, 1, 1, 2)
BASIS = xr.Dataset(
    {
        "position": (("pair", "axis"), np.zeros((1, 3))),
        "natural_frequency": ("mode", [50.0]),
        "relative_mode": (("axis", "pair", "mode"), np.ones((3, 1, 1))),
    },
    {"axis": ["x", "y", "z"]},
)


def assembled(**changes):
    return elasticity.assemble(
        **{"coordinate": COORDINATE, "connectivity": CONNECTIVITY, **STEEL, **changes}
    )


def spoiled(dataset, name, value):
    """A copy in which the first entry of a variable is another one."""
    changed = dataset.copy(deep=True)
    changed[name].values.flat[0] = value
    return changed


def inside_out(assembly):
    """An assembly whose first element is turned inside out."""
    changed = assembly.copy(deep=True)
    changed["connectivity"][0] = changed["connectivity"].to_numpy()[0, [4, 5, 6, 7, 0, 1, 2, 3]]
    return changed


def lap(**changes):
    options = {
        "axes": [0.02],
        "length": 0.06,
        "width": 0.02,
        "cell_length": 0.022,
        "radii": RADII,
        "divisions": DIVISIONS,
        "columns_between": 1,
        "columns_at_ends": 1,
    }
    return lap_plan(**options | changes)


def contact(**changes):
    options = {
        "K": sparse.eye_array(3, format="csc"),
        "C": sparse.eye_array(3, format="csr"),
        "stiffness": [1.0],
        "friction_coefficient": 0.1,
        "force": [0.0, 0.0, 1.0],
    }
    return contact_equilibrium.solve_contact(**options | changes)


ATTACKS = {
    "coordinate": [
        lambda a: assembled(coordinate=COORDINATE[:, :2]),
        lambda a: assembled(coordinate=np.where(COORDINATE > 0, NAN, COORDINATE)),
        lambda a: elasticity.smallest_jacobian(np.where(COORDINATE > 0, np.inf, 0.0), CONNECTIVITY),
        lambda a: symmetric_share(np.zeros((2, 2)), [1.0, 1.0], np.zeros((2, 3, 1))),
        lambda a: structure.free_displacements(a.drop_vars("coordinate"), tightened=True),
        lambda a: find_modes(spoiled(a, "coordinate", NAN), "free-1"),
        lambda a: bolt_preload.apply_preload(spoiled(a, "coordinate", NAN), 8e3),
    ],
    "connectivity": [
        lambda a: assembled(connectivity=CONNECTIVITY + 1),
        lambda a: assembled(connectivity=CONNECTIVITY - 1),
        lambda a: assembled(connectivity=CONNECTIVITY.astype(float)),
        lambda a: assembled(connectivity=CONNECTIVITY[:, [4, 5, 6, 7, 0, 1, 2, 3]]),
        lambda a: assembled(connectivity=CONNECTIVITY[0]),
        lambda a: structure.assemble_assembly(spoiled(a, "connectivity", a.sizes["node"])),
        lambda a: structure.mesh_of(inside_out(a)),
        lambda a: write_preload_deck(inside_out(a), 1.0, "unwritten.inp"),
    ],
    "youngs_modulus": [
        lambda a: assembled(youngs_modulus=0.0),
        lambda a: find_modes(spoiled(a, "youngs_modulus", NAN), "free-1"),
    ],
    "poissons_ratio": [lambda a: assembled(poissons_ratio=0.5)],
    "density": [
        lambda a: assembled(density=NAN),
        lambda a: elasticity.element_mass(COORDINATE[CONNECTIVITY], -1.0),
    ],
    "corners": [
        lambda a: elasticity.element_stiffness(COORDINATE, HOOKE),
        lambda a: elasticity.element_stiffness(INVERTED, HOOKE),
        lambda a: elasticity.element_mass(INVERTED, 1.0),
        lambda a: elasticity.element_mass(NAN * COORDINATE[CONNECTIVITY], 1.0),
    ],
    "D": [lambda a: elasticity.element_stiffness(COORDINATE[CONNECTIVITY], HOOKE[:3])],
    "point": [
        lambda a: Plan(np.full((4, 2), NAN), [[0, 1, 2, 3]]),
        lambda a: Plan([0.0], [[0] * 4]),
    ],
    "quad": [lambda a: replace(PLAN, quad=[[0, 1, 2, 4]]), lambda a: replace(PLAN, quad=[[0, 1]])],
    "plan": [lambda a: extrude(None, [0.0, 1.0]), lambda a: tributary_area("nope")],
    "levels": [
        lambda a: extrude(PLAN, [1.0, 0.0]),
        lambda a: extrude(PLAN, [0.0]),
        lambda a: extrude(PLAN, [0.0, NAN]),
    ],
    "x": [lambda a: rectangle_plan([0.0, 0.0], [0.0, 1.0]), lambda a: PLAN.moved(NAN)],
    "y": [lambda a: rectangle_plan([0.0, 1.0], "nope")],
    "hole": [lambda a: BoltRadii(4e-3, 3e-3, 6e-3), lambda a: BoltRadii(4e-3, NAN, 6e-3)],
    "across": [lambda a: CellDivisions(0, 5, 1, 1, 2), lambda a: CellDivisions(4.0, 5, 1, 1, 2)],
    "axes": [lambda a: lap(axes=[NAN])],
    "length": [lambda a: lap(length=-0.06)],
    "columns_between": [lambda a: lap(columns_between=0)],
    "kept": [lambda a: glue(PLAN.point, [4], [0])],
    "given_up": [lambda a: glue(PLAN.point, [0], [-1])],
    "clamped_node": [lambda a: find_modes(spoiled(a, "clamped_node", -1), "free-1")],
    "section_node": [
        lambda a: structure.free_displacements(
            spoiled(a, "section_node", a.sizes["node"]), tightened=False
        )
    ],
    "pair_node": [lambda a: structure.relative_displacements(spoiled(a, "pair_node", -1))],
    "assembly": [
        lambda a: find_modes(None, "free-1"),
        lambda a: bolt_preload.apply_preload({}, 8e3),
        lambda a: structure.assemble_assembly("nope"),
    ],
    "preload": [
        lambda a: bolt_preload.apply_preload(a, 0.0),
        lambda a: bolt_preload.apply_preload(a, "nope"),
        lambda a: write_preload_deck(a, -1.0, "unwritten.inp"),
        lambda a: patterns.stuck_patterns(a, None),
    ],
    "area": [lambda a: bolt_preload.apply_preload(spoiled(a, "area", NAN), 8e3)],
    "tolerance": [lambda a: contact(tolerance=0.0)],
    "maximum_iterations": [lambda a: contact(maximum_iterations=1.5)],
    "K": [
        lambda a: contact(K=sparse.eye_array(4, format="csc")),
        lambda a: contact(K=sparse.eye_array(3, format="csc") * NAN),
    ],
    "C": [lambda a: contact(C=sparse.eye_array(4, format="csr"))],
    "stiffness": [
        lambda a: contact(stiffness=[-1.0]),
        lambda a: contact_equilibrium.contact_force(np.zeros((1, 3)), [1.0, 1.0], 0.1),
        lambda a: patterns.resonances(a, None, -1.0),
    ],
    "friction_coefficient": [
        lambda a: contact(friction_coefficient=-0.1),
        lambda a: contact_equilibrium.contact_force(np.zeros((1, 3)), [1.0], NAN),
    ],
    "force": [lambda a: contact(force=np.zeros(3)), lambda a: contact(force=[0.0, NAN, 1.0])],
    "relative": [lambda a: contact_equilibrium.contact_force(np.zeros(3), [1.0], 0.1)],
    "family": [lambda a: find_modes(a, "nope"), lambda a: find_modes(a, 4)],
    "energy_share": [lambda a: classify([[NAN, 0.0, 1.0]], [1.0], 1.0, 1.0)],
    "symmetric_share": [lambda a: classify([[0.0, 0.0, 1.0]], [2.0], 1.0, 1.0)],
    "width": [lambda a: classify([[0.0, 0.0, 1.0]], [1.0], 0.0, 1.0)],
    "height": [lambda a: classify([[0.0, 0.0, 1.0]], [1.0], 1.0, NAN)],
    "mass": [lambda a: symmetric_share(np.zeros((2, 3)), [1.0], np.zeros((2, 3, 1)))],
    "shape": [lambda a: symmetric_share(np.zeros((2, 3)), [1.0, 1.0], np.zeros((2, 3)))],
    "radii": [
        lambda a: patterns.stuck_patterns(a, a, ()),
        lambda a: patterns.stuck_patterns(a, a, (NAN,)),
    ],
    "patterns": [
        lambda a: patterns.resonances(a, None, 1e8, {"one": [True]}),
        lambda a: patterns.resonances(a, None, 1e8, {"all": np.ones(a.sizes["pair"])}),
        lambda a: patterns.resonances_in(BASIS, None),
    ],
    "number": [
        lambda a: patterns.resonances(a, None, 1e8, number=0),
        lambda a: write_modes_deck(a, 0, "unwritten.inp"),
        lambda a: basis_of_pod_modes(structure_of(a), BASIS, 0),
    ],
}


DESCRIBED = [
    pytest.param(name, call, id=f"{name}-{i}")
    for name, calls in ATTACKS.items()
    for i, call in enumerate(calls)
]


@pytest.mark.parametrize(("name", "call"), DESCRIBED)
def test_a_wrong_argument_is_refused_by_its_name(assembly, name, call):
    with pytest.raises(ValueError, match=rf"(?<!\w){re.escape(name)}(?!\w)"):
        call(assembly)


#: valid calls, and how many are tried of each with another argument
CALLS = {
    "extrude": (extrude, {"plan": PLAN, "levels": [0.0, 1.0]}, 60),
    "BoltRadii": (BoltRadii, {"shank": 4e-3, "hole": 4.5e-3, "head": 6.5e-3}, 60),
    "rectangle_plan": (rectangle_plan, {"x": np.array([0.0, 1.0]), "y": np.array([0.0, 1.0])}, 40),
}


@pytest.mark.parametrize("name", CALLS)
def test_hostile_arguments_are_refused_by_a_value_error(name):
    function, valid, number = CALLS[name]
    assert_refused(function, valid, name, number)


def test_lists_make_the_same_model():
    listed = assembled(coordinate=COORDINATE.tolist(), connectivity=CONNECTIVITY.tolist())
    for found, expected in zip(listed, assembled(), strict=True):
        assert abs(found - expected).max() == 0
    np.testing.assert_array_equal(extrude(PLAN, [0, 1])[0], extrude(PLAN, [0.0, 1.0])[0])


def test_a_bolt_and_a_lap_are_made_of_the_arguments_that_are_attacked():
    assert bolt_plan(RADII, DIVISIONS).head.quad.size
    assert lap().plan.quad.size
    assert contact().converged
