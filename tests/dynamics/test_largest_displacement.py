"""Where the linear model of a structure ends."""

import logging

import numpy as np
import pytest
import xarray as xr
from small_joint import make_joint

from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.largest_displacement import add_largest_displacement
from boltjoint.structure.extent import extent

FORCES = [0.01, 5.0]
LENGTH = 0.4


@pytest.fixture(scope="module")
def response():
    return solve_response(make_joint(), FORCES, damping=0.01)


def stored(farthest):
    return xr.Dataset(
        {"structure_length": LENGTH, "farthest_mode": (("farthest", "axis", "mode"), farthest)}
    )


def test_displacements_are_those_of_the_points_over_a_period(response):
    # points that move along ellipses, since their modes are not in phase
    modes = np.random.default_rng(0).normal(size=(4, 3, 3))
    found = add_largest_displacement(response, stored(modes))
    t = 2 * np.pi * np.arange(20_000) / 20_000
    for place, force in enumerate(FORCES):
        _, motion = motion_at_peak(response, force)
        sine, cosine = (modes @ q for q in motion.in_components(("sin", "cos")))
        moved = np.multiply.outer(np.sin(t), sine) + np.multiply.outer(np.cos(t), cosine)
        largest = np.linalg.norm(moved, axis=-1).max()
        share = float(found["peak_displacement_over_length"][place])
        assert share == pytest.approx(largest / LENGTH, rel=1e-7)


def test_the_amplitude_is_that_with_all_harmonics_where_it_is_known(response):
    along = np.zeros((1, 3, 3))
    along[0, 2] = make_joint().response_mode
    name = "peak_displacement_over_length"
    found = add_largest_displacement(response, stored(along))
    np.testing.assert_allclose(found[name], response["peak_amplitude"] / LENGTH, rtol=1e-12)
    converged = response.assign(peak_amplitude_converged=1.5 * response["peak_amplitude"])
    converged["peak_amplitude_converged"][1] = np.nan
    again = add_largest_displacement(converged, stored(along))
    np.testing.assert_allclose(again[name], [1.5, 1.0] * found[name], rtol=1e-12)


def test_beyond_a_tenth_of_the_length_a_warning_tells_the_force(response, caplog):
    along = np.zeros((1, 3, 3))
    along[0, 2] = make_joint().response_mode
    largest = float(response["peak_amplitude"].max())
    for length, warns in ((9 * largest, True), (11 * largest, False)):
        caplog.clear()
        with caplog.at_level(logging.WARNING):
            add_largest_displacement(response, stored(along).assign(structure_length=length))
        assert ("5 N: the structure moves by 11 % of its length" in caplog.text) == warns


def test_a_structure_without_nodes_has_no_limit(response):
    assert not extent(xr.Dataset(), xr.Dataset())
    assert add_largest_displacement(response, xr.Dataset()) is response


def test_the_extent_is_the_longest_one_and_the_nodes_move_most():
    coordinate = np.array([[0, 0, 0], [0.4, 0.01, 0], [0.2, 0, 0.05]])
    shape = np.zeros((3, 3, 2))
    shape[1, 2, 0], shape[2, 1, 0], shape[2, 1, 1] = 3.0, 1.0, 2.0
    assembly = xr.Dataset({"coordinate": (("node", "axis"), coordinate)})
    modes = xr.Dataset({"mode_shape": (("node", "axis", "mode"), shape)})
    found = extent(assembly, modes)
    assert found["structure_length"] == 0.4
    np.testing.assert_array_equal(found["farthest_mode"], shape[[1, 2]])
