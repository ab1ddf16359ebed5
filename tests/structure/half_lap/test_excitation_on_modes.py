"""Excitation and sensors of a case, placed on the mesh of its assembly."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from boltjoint.config.excitation import Excitation, Sensor
from boltjoint.damping import RayleighDamping
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.structure.excitation import place_excitation
from boltjoint.structure.makers.half_lap.structure import assemble_assembly, load_on_surface

TIP = {"y_mm": 0, "z_mm": 10, "direction": "z"}


def excited(**given):
    return TypeAdapter(Excitation).validate_python(given)


def forces(*points):
    return excited(kind="forces", points=points)


def sensor(name, **given):
    return Sensor(name=name, **TIP | given)


@pytest.fixture(scope="module")
def tip(coarse):
    return TIP | {"x_mm": coarse.bar.length_mm}


def test_a_case_that_says_nothing_keeps_the_default_point(assembly, modes, tip):
    placed = place_excitation(assembly, modes)
    for name in ("excitation_mode", "response_mode"):
        np.testing.assert_array_equal(placed[name], modes[name])
    assert placed["sensor"].to_numpy().tolist() == ["output"]
    assert "excitation_mode_cos" not in placed
    same = place_excitation(assembly, modes, forces(tip), [Sensor(name="tip", **tip)])
    for name in ("excitation_mode", "response_mode"):
        np.testing.assert_array_equal(same[name], modes[name])


def test_forces_add_by_amplitude_and_phase(assembly, modes, tip):
    at = [tip, tip | {"x_mm": tip["x_mm"] / 2}]
    alone = [place_excitation(assembly, modes, forces(each))["excitation_mode"] for each in at]
    both = forces(at[0], at[1] | {"relative_amplitude": 0.5, "phase_deg": 90})
    placed = place_excitation(assembly, modes, both)
    np.testing.assert_allclose(placed["excitation_mode"], alone[0], rtol=1e-12)
    np.testing.assert_allclose(placed["excitation_mode_cos"], 0.5 * alone[1], rtol=1e-12)
    opposed = place_excitation(assembly, modes, forces(at[0], at[1] | {"phase_deg": 180}))
    assert "excitation_mode_cos" not in opposed
    np.testing.assert_allclose(opposed["excitation_mode"], alone[0] - alone[1], rtol=1e-12)


def test_sensors_are_nodes_of_the_bars_and_the_first_is_the_output_point(assembly, modes, tip):
    given = [Sensor(name="lap", **tip | {"x_mm": 90.0}), Sensor(name="tip", **tip)]
    placed = place_excitation(assembly, modes, None, given)
    assert placed["sensor"].to_numpy().tolist() == ["lap", "tip"]
    np.testing.assert_array_equal(placed["response_mode"], placed["sensor_mode"].sel(sensor="lap"))
    np.testing.assert_array_equal(placed["sensor_mode"].sel(sensor="tip"), modes["response_mode"])
    shape = modes["mode_shape"].sel(axis="z").to_numpy()
    distance = np.linalg.norm(assembly["coordinate"].to_numpy() - [0.09, 0.0, 0.01], axis=1)
    nearest = np.flatnonzero(distance < distance.min() + 1e-9)
    assert any(np.array_equal(placed["response_mode"], shape[node]) for node in nearest)


@pytest.mark.parametrize("surface", ["top", "bottom", "free-end", "left", "right"])
def test_an_even_load_does_the_work_of_its_mean(assembly, coarse, surface):
    """Consistent forces are exact for linear fields: their work is that at the centroid."""
    force = load_on_surface(assembly, surface)
    assert force.sum() == pytest.approx(1, rel=1e-12)
    assert force.min() >= 0
    coordinate = assembly["coordinate"].to_numpy()[force > 0]
    bar = coarse.bar
    ends = {
        "top": (2, bar.height_mm / 2),
        "bottom": (2, -bar.height_mm / 2),
        "free-end": (0, bar.length_mm),
        "left": (1, bar.width_mm / 2),
        "right": (1, -bar.width_mm / 2),
    }
    axis, level = ends[surface]
    np.testing.assert_allclose(1e3 * coordinate[:, axis], level, rtol=1e-9)
    centre = 1e3 * force[force > 0] @ coordinate
    if surface == "free-end":
        np.testing.assert_allclose(centre, [bar.length_mm, 0, 0], atol=1e-9)
    elif surface in ("left", "right"):
        # no hole cuts the sides: the centroid of the rectangle from the clamp to the free end
        np.testing.assert_allclose(centre, [bar.length_mm / 2, level, 0], atol=1e-9)
    else:
        assert abs(centre[1]) < 1e-9  # symmetric about the width


def test_a_surface_load_is_not_where_heads_and_nuts_are(assembly, modes):
    placed = place_excitation(
        assembly, modes, excited(kind="distributed", surface="top", direction="z")
    )
    assert "excitation_mode_cos" not in placed
    tip = abs(modes["excitation_mode"].to_numpy())
    # the mean of the first mode over its length is less than its tip
    assert 0.2 * tip[0] < abs(placed["excitation_mode"].to_numpy()[0]) < 0.6 * tip[0]


def test_base_excitation_is_the_inertia_of_a_rigid_motion(assembly, modes):
    placed = place_excitation(assembly, modes, excited(kind="base", direction="z"))
    _, M = assemble_assembly(assembly)
    rigid = np.zeros((assembly.sizes["node"], 3))
    rigid[:, 2] = 1.0
    shape = modes["mode_shape"].transpose("node", "axis", "mode").to_numpy()
    expected = -(M @ rigid.ravel()) @ shape.reshape(-1, shape.shape[-1])
    np.testing.assert_allclose(placed["excitation_mode"], expected, rtol=1e-9)
    assert placed["excitation_mode"].attrs["units"] == "kg^1/2"
    # effective modal masses: the first bending mode of a cantilever has 61 % of all
    mass = rigid.ravel() @ M @ rigid.ravel()
    assert 0.5 < expected[0] ** 2 / mass < 0.75
    assert np.sum(expected**2) < mass


def test_a_joint_has_the_excitation_and_sensors_of_its_case(assembly, modes, preload, tip):
    given = excited(kind="base", direction="z"), [Sensor(name="tip", **tip)]
    joint = connect_nodes(place_excitation(assembly, modes, *given), preload, 1e8, 0.1)
    assert joint.excitation_unit == "m/s2"
    assert list(joint.sensors.by_name) == ["tip"]
    response = solve_response(joint, [0.1, 10.0], damping=RayleighDamping(2.0, 1e-6))
    assert response["complete"].all()
    assert response["force_level"].attrs["units"] == "m/s2"
    assert abs(response["energy_error"]).max() < 1e-6
    phased = forces(tip, tip | {"x_mm": tip["x_mm"] / 2, "phase_deg": 45})
    joint = connect_nodes(place_excitation(assembly, modes, phased), preload, 1e8, 0.1)
    assert joint.excitation_mode_cos is not None and joint.excitation_unit == "N"


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ({"direction": "y"}, "the excitation has no part in the modes"),
        ({"x_mm": 0.0}, "the excitation has no part in the modes"),
    ],
)
def test_forces_on_what_does_not_move_are_refused(assembly, modes, tip, given, problem):
    with pytest.raises(ValueError, match=problem):
        place_excitation(assembly, modes, forces(tip | given))
    with pytest.raises(ValueError, match="sensor still has no part in the modes"):
        place_excitation(assembly, modes, None, [Sensor(name="still", **tip | given)])


def test_a_base_that_moves_across_excites_nothing(assembly, modes):
    with pytest.raises(ValueError, match="acceleration of the supports has no part in the modes"):
        place_excitation(assembly, modes, excited(kind="base", direction="y"))
