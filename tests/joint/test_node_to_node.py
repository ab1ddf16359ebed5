"""Node-to-node joints from modes and preload."""

import numpy as np
import pytest
import xarray as xr

from boltjoint.friction.contact_states import SEPARATION, STICK_SLIP_SEPARATION
from boltjoint.friction.registry import LAWS
from boltjoint.friction.variable import VariableLoad
from boltjoint.joint.node_to_node import connect_nodes, connect_pairs


def modes_and_preload():
    position = np.column_stack([np.linspace(0, 0.1, 5), np.zeros(5), np.zeros(5)])
    random = np.random.default_rng(0)
    modes = xr.Dataset(
        {
            "natural_frequency": ("mode", [70.0, 360.0]),
            "relative_mode": (("pair", "axis", "mode"), random.normal(size=(5, 3, 2))),
            "response_mode": ("mode", [1.0, -1.0]),
            "excitation_mode": ("mode", [1.1, -0.9]),
            "position": (("pair", "axis"), position),
        },
        coords={"axis": ["x", "y", "z"]},
    )
    preload = xr.Dataset(
        {
            "normal_load": ("pair", [10.0, 0.0, 30.0, 0.0, 20.0]),
            "gap": ("pair", [0.0, 2e-7, 0.0, 5e-8, 0.0]),
            "position": (("pair", "axis"), position),
        },
        coords={"axis": ["x", "y", "z"]},
    )
    return modes, preload


def test_only_loaded_pairs_get_an_element():
    modes, preload = modes_and_preload()
    joint = connect_nodes(modes, preload, 1e8, 0.1)
    np.testing.assert_allclose(joint.law.slip_force, [1.0, 3.0, 2.0])
    np.testing.assert_array_equal(joint.law.tangential_stiffness, 1e8)
    along_bar = modes["relative_mode"].sel(axis="x").to_numpy()
    np.testing.assert_array_equal(joint.tangential_mode, along_bar[[0, 2, 4]])
    np.testing.assert_array_equal(joint.element_position, modes["position"].to_numpy()[[0, 2, 4]])


def test_all_pairs_get_an_element_if_they_may_close():
    modes, preload = modes_and_preload()
    joint = connect_nodes(modes, preload, 1e8, 0.1, 3e8)
    law = joint.law
    assert isinstance(law, VariableLoad)
    np.testing.assert_array_equal(law.point_of_element, np.arange(5))
    np.testing.assert_array_equal(law.tangential_stiffness, 1e8)
    np.testing.assert_array_equal(law.normal_stiffness, 3e8)
    np.testing.assert_array_equal(law.friction_coefficient, 0.1)
    # -k_v gap where open: 3e8 N/m over 0.2 and 0.05 um
    np.testing.assert_allclose(law.normal_load, [10, -60, 30, -15, 20], rtol=1e-14)
    relative = modes["relative_mode"]
    np.testing.assert_array_equal(joint.tangential_mode, relative.sel(axis="x"))
    np.testing.assert_array_equal(joint.normal_mode, relative.sel(axis="z"))
    for position in (joint.position, joint.element_position):
        np.testing.assert_array_equal(position, modes["position"])


def test_a_pair_closes_where_the_lower_bar_moves_up_by_more_than_the_gap():
    modes, preload = modes_and_preload()
    # side A is the lower bar: its displacement along z less that of B
    modes["relative_mode"][:] = 0.0
    modes["relative_mode"].loc[{"axis": "z", "mode": 0}] = 1.0
    joint = connect_nodes(modes, preload, 1e8, 0.1, 3e8)
    open_by = preload["gap"].to_numpy()[1]

    def state_of_pair_1(rise):
        bias_of_modes = np.array([[rise, 0.0], [0.0, 0.0], [0.0, 0.0]])
        motion = np.hstack([B @ bias_of_modes.T for B in joint.rows])
        motion[:, 4] = 1e-3 * open_by
        return joint.law.contact_state(motion)[1]

    assert state_of_pair_1(0.99 * open_by) == SEPARATION
    assert state_of_pair_1(open_by) == STICK_SLIP_SEPARATION
    assert state_of_pair_1(-2 * open_by) == SEPARATION
    assert state_of_pair_1(1.01 * open_by) not in (SEPARATION, STICK_SLIP_SEPARATION)


AREA = np.array([1e-6, 2e-6, 3e-6, 4e-6, 5e-6])
PER_AREA = {
    "constant": {"tangential_stiffness_per_area": 7e13},
    "variable": {"tangential_stiffness_per_area": 7e13, "normal_stiffness_per_area": 3e13},
    "iwan": {"tangential_stiffness_per_area": 7e13, "chi": -0.5, "beta": 0.2},
}


@pytest.mark.parametrize("law", PER_AREA)
def test_a_stiffness_per_area_is_multiplied_by_the_area_of_each_pair(law):
    modes, preload = modes_and_preload()
    preload["area"] = ("pair", AREA)
    joint = connect_pairs(modes, preload, LAWS[law], friction_coefficient=0.1, **PER_AREA[law])
    pairs = np.arange(5) if law == "variable" else [0, 2, 4]
    np.testing.assert_allclose(joint.law.tangential_stiffness, 7e13 * AREA[pairs], rtol=1e-15)
    if law == "variable":
        np.testing.assert_allclose(joint.law.normal_stiffness, 3e13 * AREA, rtol=1e-15)
        # -k_v gap where open
        np.testing.assert_allclose(joint.law.normal_load, [10, -12, 30, -6, 20], rtol=1e-14)
    of_each = {
        name.removesuffix("_per_area"): value * AREA if name.endswith("_per_area") else value
        for name, value in PER_AREA[law].items()
    }
    same = connect_pairs(modes, preload, LAWS[law], friction_coefficient=0.1, **of_each)
    for name in same.law.quantities:
        np.testing.assert_array_equal(getattr(same.law, name), getattr(joint.law, name))


TWO_SURFACES = np.array(["flange", "flange", "lap", "lap", "lap"], dtype=object)
OF_ALL = {
    "constant": {"tangential_stiffness": 1e8, "friction_coefficient": 0.1},
    "variable": {
        "tangential_stiffness": 1e8,
        "friction_coefficient": 0.1,
        "normal_stiffness_per_area": 3e13,
    },
    "iwan": {
        "tangential_stiffness": 1e8,
        "friction_coefficient": 0.1,
        "chi": -0.5,
        "beta": 0.2,
    },
}
OF_FLANGE = {
    "constant": {"tangential_stiffness_per_area": 7e13, "friction_coefficient": 0.4},
    "variable": {
        "tangential_stiffness_per_area": 7e13,
        "friction_coefficient": 0.4,
        "normal_stiffness": 2e8,
    },
    "iwan": {"friction_coefficient": 0.4, "chi": -0.2, "beta": 0.0},
}


@pytest.mark.parametrize("law", OF_ALL)
def test_a_surface_has_its_own_values_and_else_those_of_all(law):
    modes, preload = modes_and_preload()
    preload["area"], preload["surface"] = ("pair", AREA), ("pair", TWO_SURFACES)
    found = connect_pairs(
        modes, preload, LAWS[law], surfaces={"flange": OF_FLANGE[law]}, **OF_ALL[law]
    )
    # the elements of the same contact with the values of all, and with those of the flange
    own = {name.removesuffix("_per_area") for name in OF_FLANGE[law]}
    rest = {k: v for k, v in OF_ALL[law].items() if k.removesuffix("_per_area") not in own}
    of_all, of_flange = (
        connect_pairs(modes, preload, LAWS[law], **keys).law
        for keys in (OF_ALL[law], rest | OF_FLANGE[law])
    )
    on_flange = found.surface_places.name == "flange"
    assert on_flange.sum() == (2 if law == "variable" else 1)
    for name in found.law.quantities:
        expected = np.where(on_flange, getattr(of_flange, name), getattr(of_all, name))
        np.testing.assert_array_equal(getattr(found.law, name), expected, err_msg=name)
    assert not np.array_equal(found.law.slip_force, of_all.slip_force)


@pytest.mark.parametrize(
    ("surfaces", "sentence"),
    [
        ({"flang": {"friction_coefficient": 0.2}}, "surface 'flang' is not known; allowed: flange"),
        (
            {"lap": {"chi": -0.5}},
            "key of surface lap 'chi' is not known; allowed: tangential_stiff",
        ),
        ({"lap": {"friction_coefficient": -0.2}}, "friction_coefficient"),
        ({"lap": 0.2}, "surface lap is of type float"),
        (
            {"lap": {"tangential_stiffness": 1e8, "tangential_stiffness_per_area": 1e13}},
            "tangential_stiffness is given for each pair and per area",
        ),
    ],
)
def test_values_of_surfaces_that_do_not_fit_are_refused(surfaces, sentence):
    modes, preload = modes_and_preload()
    preload["area"], preload["surface"] = ("pair", AREA), ("pair", TWO_SURFACES)
    with pytest.raises(ValueError, match=sentence):
        connect_pairs(modes, preload, LAWS["constant"], surfaces=surfaces, **OF_ALL["constant"])


def divided(modes, preload, parts):
    """The contact with every pair divided into parts of its load and area, as in a finer mesh."""
    pair = np.repeat(np.arange(5), parts)
    modes, preload = modes.isel(pair=pair), preload.isel(pair=pair)
    for name in ("normal_load", "area"):
        preload[name] = preload[name] / parts
    return modes, preload


@pytest.mark.parametrize("form", ["tangential_stiffness", "tangential_stiffness_per_area"])
def test_only_a_stiffness_per_area_is_the_same_where_pairs_are_divided(form):
    modes, preload = modes_and_preload()
    preload["area"] = ("pair", AREA)
    one, four = (
        connect_pairs(*each, LAWS["constant"], friction_coefficient=0.1, **{form: 7e7})
        for each in ((modes, preload), divided(modes, preload, 4))
    )
    ratio = 1 if form.endswith("per_area") else 4
    np.testing.assert_allclose(four.stuck_stiffness(), ratio * one.stuck_stiffness(), rtol=1e-13)
    slips_at = [each.law.slip_force / each.law.tangential_stiffness for each in (one, four)]
    np.testing.assert_allclose(slips_at[1], np.repeat(slips_at[0], 4) / ratio, rtol=1e-13)


def test_a_stiffness_has_one_form_and_a_value_for_each_pair():
    modes, preload = modes_and_preload()
    preload["area"] = ("pair", AREA)
    with pytest.raises(ValueError, match="tangential_stiffness is given for each pair and per"):
        connect_pairs(
            modes,
            preload,
            LAWS["constant"],
            friction_coefficient=0.1,
            tangential_stiffness=1e8,
            tangential_stiffness_per_area=7e13,
        )
    with pytest.raises(ValueError, match="tangential_stiffness"):
        connect_nodes(modes, preload, np.full(4, 1e8), 0.1)
    with pytest.raises(ValueError, match="tangential_stiffness"):
        connect_nodes(modes, preload, np.array([1e8, 1e8, 0.0, 1e8, 1e8]), 0.1)
    with pytest.raises(ValueError, match="area"):
        connect_pairs(
            modes,
            preload.drop_vars("area"),
            LAWS["constant"],
            friction_coefficient=0.1,
            tangential_stiffness_per_area=7e13,
        )


def test_axes_of_files_may_be_in_any_order():
    modes, preload = modes_and_preload()
    joint = connect_nodes(modes, preload, 1e8, 0.1, 3e8)
    turned = connect_nodes(
        modes.transpose("mode", "axis", "pair"), preload.transpose("axis", "pair"), 1e8, 0.1, 3e8
    )
    for name in ("tangential_mode", "normal_mode", "position"):
        np.testing.assert_array_equal(getattr(turned, name), getattr(joint, name))


def test_modes_and_preload_of_different_meshes_are_refused():
    modes, preload = modes_and_preload()
    with pytest.raises(ValueError, match="different contact pairs"):
        connect_nodes(modes, preload.isel(pair=slice(1, None)), 1e8, 0.1)


@pytest.mark.parametrize("normal_stiffness", [None, 3e8])
def test_a_joint_without_load_is_refused(normal_stiffness):
    modes, preload = modes_and_preload()
    preload["normal_load"][:] = 0.0
    with pytest.raises(ValueError, match="no contact pair carries load"):
        connect_nodes(modes, preload, 1e8, 0.1, normal_stiffness)
