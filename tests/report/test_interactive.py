"""What pages hold of drawings that answer the pointer."""

import base64
import gzip
import json

import numpy as np
import pytest
from small_joint import connect_small, make_joint

from boltjoint import dataset
from boltjoint.config.case import Case
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion, motion_at_peak
from boltjoint.report.figures.curves import response_curves
from boltjoint.report.pages.document import compressed_json, pack
from boltjoint.report.pages.interactive.curves import curves_of_case
from boltjoint.report.pages.interactive.view import (
    Surface,
    hysteresis_loops,
    loop_of_joint,
    natural_modes,
    packed_contact,
    packed_displacement,
)
from boltjoint.structure.model_limits import LINEAR
from boltjoint.study import layout
from boltjoint.study.stage_inputs import Results


def unpacked(text, kind="<f4"):
    return np.frombuffer(base64.b64decode(text), kind)


def test_content_is_the_same_on_every_run():
    content = {"values": pack(np.arange(3.0)), "words": "µm"}
    packed = compressed_json(content)
    assert packed == compressed_json(content)
    assert json.loads(gzip.decompress(base64.b64decode(packed))) == content
    assert unpacked(content["values"]).tolist() == [0, 1, 2]


@pytest.mark.parametrize("law", ["constant", "variable", "iwan", "kelvin-voigt"])
def test_loops_have_the_first_harmonic_and_the_work_of_the_law(law):
    keys = {"tangential_stiffness": 5e6, "friction_coefficient": 0.1}
    layer = {"layer_stiffness": 2e6, "layer_damping": 800.0}
    is_layer, frequency = law == "kelvin-voigt", 70.0
    joint = connect_small(law, keys | layer)[0] if is_layer else make_joint(law=law)
    q = np.array([[3e-4, 1e-5, 1e-6], [-2e-4, 2e-5, 0.0]])
    motion = PeriodicMotion(("sin", "cos"), q)
    samples = 1024
    u, force = hysteresis_loops(joint, motion, samples, frequency)
    components = joint.law.components
    rows = motion.in_components(components)
    coefficients = joint.law.force(np.hstack([B @ rows.T for B in joint.rows]), frequency)
    phase = 2 * np.pi * np.arange(samples) / samples
    for name, shape in (("sin", np.sin(phase)), ("cos", np.cos(phase))):
        of_law = coefficients[:, components.index(name)]
        of_loop = 2 / samples * force @ shape
        # the sliders of an Iwan element are few, and samples of slip are half a step late
        largest = abs(coefficients).max()
        np.testing.assert_allclose(
            of_loop, of_law, atol=(5e-3 if law == "iwan" else 2e-3) * largest
        )
    work = np.sum(force * np.diff(u, axis=1, append=u[:, :1]), axis=1)
    assert (work > -1e-3 * work.max()).all() and work.max() > 0


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_loop_of_the_joint_has_the_work_of_all_elements(angle):
    joint = make_joint()
    # all modes in phase: every point moves as the output does
    shape = np.array([3e-4, 1e-5, 1e-6])
    motion = PeriodicMotion(("sin", "cos"), np.outer([np.cos(angle), np.sin(angle)], shape))
    u, friction = hysteresis_loops(joint, motion, 256)
    displacement, force = loop_of_joint(joint, motion, friction)
    assert abs(displacement).max() == pytest.approx(abs(joint.response_mode @ shape), rel=1e-3)
    work = np.sum(friction * np.diff(u, axis=1, append=u[:, :1]))
    assert work > 0
    of_loop = np.sum(force * np.diff(displacement, append=displacement[0]))
    assert of_loop == pytest.approx(work, rel=1e-10)


def test_natural_modes_lie_between_those_without_contact_and_sticking():
    joint = make_joint(law="variable")
    modes = natural_modes(joint, 3)
    between = joint.resonance_range()[:3]
    np.testing.assert_allclose(modes["without contact"].frequency, between[:, 0])
    np.testing.assert_allclose(modes["sticking"].frequency, between[:, 1])
    assert (modes["slipping"].frequency >= between[:, 0]).all()
    assert (modes["slipping"].frequency <= between[:, 1]).all()
    vector = modes["sticking"].vector
    np.testing.assert_allclose(vector.T @ vector, np.eye(3), atol=1e-12)
    assert "slipping" not in natural_modes(make_joint(), 3)


def test_a_model_ends_at_the_first_of_its_limits(reference):
    share, of_strength = np.array([0.02, 0.1, 0.4]), np.array([0.1, 2.0, np.nan])
    solved = reference.assign(
        peak_displacement_over_length=("force", share),
        peak_stress_over_strength=("force", of_strength),
        # slip is not proportional to the amplitude
        peak_slip_over_clearance=("force", np.full(3, 100.0)),
    )
    for curve, reached in zip(
        response_curves(solved), [0.02 / LINEAR, 2.0, 0.4 / LINEAR], strict=True
    ):
        assert curve.model_limit == pytest.approx(curve.amplitude[curve.peak] / reached)
    assert all(np.isnan(each.model_limit) for each in response_curves(reference))


def test_curves_of_a_case_are_those_of_its_files(tmp_path, monkeypatch, reference):
    monkeypatch.chdir(tmp_path)
    levels = reference["force_level"].to_numpy().tolist()
    case = Case.model_validate(
        {
            "assembly": "two_bolt",
            "preload_N": 1e4,
            "contact": {
                "law": "constant",
                "tangential_stiffness_N_per_m": 1e8,
                "friction_coefficient": 0.1,
            },
            "forces_N": levels,
            "modes": ["free-3"],
            "coordinates": ["linear"],
            "solve": [{"resonance": 1, "joints": ["node-to-node", "regions=3"]}],
        }
    )
    which = {"case": "mine", "basis": "free-3", "joint": "node-to-node"}
    path = layout.path("response", **which, coordinates="linear", resonance=1)
    dataset.save(reference, path)
    assert curves_of_case("mine", case, Results([])) is None
    content = curves_of_case("mine", case, Results([path]))
    json.dumps(content, allow_nan=False)
    (of_resonance,) = content["resonances"]
    (model,) = of_resonance["models"]
    assert content["levels"] == levels and model["reference"]
    for curve, level in zip(model["curves"], levels, strict=True):
        amplitude = reference["peak_amplitude"].to_numpy()[levels.index(level)]
        assert unpacked(curve["y"]).max() == pytest.approx(1e3 * amplitude / level, rel=1e-6)
        assert curve["peak"][1] == pytest.approx(1e3 * amplitude / level)
        assert curve["unstable"] == [] and curve["limit"] is None


def test_the_surface_of_a_mesh_has_each_outer_face_but_those_in_contact(assembly):
    surface = Surface.of(assembly)
    # two plates of 6 x 2 elements: 12 outside, 16 around each
    assert len(surface.face) == 2 * (12 + 16)
    content = surface.packed(assembly)
    nodes = unpacked(content["nodes"]).reshape(-1, 3)
    np.testing.assert_allclose(np.ptp(nodes, axis=0), [60, 20, 20], rtol=1e-6)
    assert [len(unpacked(each["faces"], "<u2")) // 4 for each in content["parts"]] == [28, 28]
    contact = packed_contact(assembly, surface)
    # every pair lies where its node does
    on = nodes[unpacked(contact["nodes"], "<u2")]
    np.testing.assert_allclose(on, unpacked(contact["places"]).reshape(-1, 3), atol=1e-5)
    corners = unpacked(contact["corners"], "<u2").reshape(-1, 4)
    cells = unpacked(contact["cells"], "<u2").reshape(-1, 4)
    places = unpacked(contact["places"]).reshape(-1, 3)[corners].mean(axis=1)[cells]
    u, v = places[:, 2] - places[:, 0], places[:, 3] - places[:, 1]
    area = np.abs(np.cross(u, v)[:, 2]) / 2
    of_pair = np.bincount(unpacked(contact["owners"], "<u2"), area)
    np.testing.assert_allclose(of_pair, 1e6 * assembly["area"], rtol=1e-5)


def test_displacements_keep_four_digits():
    displacement = np.random.default_rng(0).normal(size=(50, 3)) * 1e-4
    content = packed_displacement(displacement)
    back = unpacked(content["values"], "<i2").reshape(-1, 3) * content["unit"]
    np.testing.assert_allclose(back, displacement, atol=2e-5 * abs(displacement).max())
    assert not unpacked(packed_displacement(np.zeros((2, 3)))["values"], "<i2").any()


def test_loops_of_a_peak_are_those_of_a_response(variable, variable_response):
    force = float(variable_response["force_level"][-1])
    _, motion = motion_at_peak(variable_response, force)
    u, friction = hysteresis_loops(variable, motion, 64)
    states = variable_response["contact_state"].isel(force=-1).to_numpy()
    slips = np.ptp(friction, axis=1) < variable.law.tangential_stiffness * np.ptp(u, axis=1) * 0.99
    assert slips[states == 1].all()
