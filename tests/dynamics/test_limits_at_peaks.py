"""How much of the limits of its model a structure reaches at peaks."""

import logging

import numpy as np
import pytest
import xarray as xr
from small_joint import make_joint

from boltjoint.dynamics.balance.periodic_motion import motion_at_peak
from boltjoint.dynamics.response.frequency_response import solve_response
from boltjoint.dynamics.response.limits_at_peaks import LimitsReached, add_limits
from boltjoint.structure.model_limits import DISPLACEMENT, SLIP, STRESS

FORCES = [0.01, 5.0]


@pytest.fixture(scope="module")
def response():
    return solve_response(make_joint(), FORCES, damping=0.01)


def stored(limit, modes, largest):
    """Modes at places, (place, component, mode), and the limit of each or of all."""
    dims = ("place",) if np.ndim(largest) else ()
    return xr.Dataset(
        {limit.limit: (dims, largest), limit.modes: (("place", "component", "mode"), modes)}
    )


def along_output():
    modes = np.zeros((1, 3, 3))
    modes[0, 2] = make_joint().response_mode
    return modes


@pytest.mark.parametrize(
    ("limit", "components", "largest"),
    [(DISPLACEMENT, 3, 0.4), (SLIP, 2, np.arange(1.0, 5.0)), (STRESS, 6, np.arange(4.0, 0.0, -1))],
)
def test_shares_are_those_of_the_places_over_a_period(response, limit, components, largest):
    # places that move along ellipses, since their modes are not in phase
    modes = np.random.default_rng(0).normal(size=(4, components, 3))
    found = add_limits(response, stored(limit, modes, largest))
    t = 2 * np.pi * np.arange(20_000) / 20_000
    for place, force in enumerate(FORCES):
        _, motion = motion_at_peak(response, force)
        sine, cosine = (modes @ q for q in motion.in_components(("sin", "cos")))
        moved = np.multiply.outer(np.sin(t), sine) + np.multiply.outer(np.cos(t), cosine)
        reached = (np.linalg.norm(moved, axis=-1).max(axis=0) / largest).max()
        assert float(found[f"peak_{limit.name}"][place]) == pytest.approx(reached, rel=1e-7)


def test_the_amplitude_is_that_with_all_harmonics_where_it_is_known(response):
    name, joint = "peak_displacement_over_length", stored(DISPLACEMENT, along_output(), 0.4)
    found = add_limits(response, joint)
    np.testing.assert_allclose(found[name], response["peak_amplitude"] / 0.4, rtol=1e-12)
    converged = response.assign(peak_amplitude_converged=1.5 * response["peak_amplitude"])
    converged["peak_amplitude_converged"][1] = np.nan
    again = add_limits(converged, joint)
    np.testing.assert_allclose(again[name], [1.5, 1.0] * found[name], rtol=1e-12)


@pytest.mark.parametrize(
    ("limit", "told"),
    [
        (DISPLACEMENT, "5 N: the structure moves by 11 % of its length"),
        (SLIP, "5 N: bodies slip at a bolt by 111 % of the clearance of its hole"),
        (STRESS, "5 N: the nominal stress reaches 111 % of the yield strength"),
    ],
)
def test_beyond_a_limit_one_warning_tells_the_largest_and_its_force(response, caplog, limit, told):
    largest = float(response["peak_amplitude"].max()) / limit.tolerated
    for factor, warns in ((0.9, True), (1.1, False)):
        caplog.clear()
        with caplog.at_level(logging.WARNING):
            reached = LimitsReached()
            for further in (1.0, 2.0):
                known = stored(limit, along_output(), [further * factor * largest])
                reached.add(add_limits(response, known))
            reached.warn()
        assert (told in caplog.text) == warns
        assert len(caplog.records) == warns


def test_a_joint_that_knows_no_limit_leaves_a_response_as_it_is(response):
    assert add_limits(response, xr.Dataset()) is response
