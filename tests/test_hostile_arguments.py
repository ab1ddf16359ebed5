"""Whatever a public function is given, it computes or raises a ``ValueError``."""

from dataclasses import fields
from functools import partial

import numpy as np
import pandas as pd
import pytest
from hostile_arguments import assert_refused
from small_joint import make_joint, make_preload, make_two_pairs

import boltjoint
from boltjoint import dataset
from boltjoint.calibration.fit import CalibrationOptions
from boltjoint.calibration.parameters import Prior
from boltjoint.damping import LossFactor
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response import branch, folds, response_file
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint import bands, clusters, derived, fit_jenkins, hysteresis, io, model, partition
from boltjoint.joint.clusters import cluster_by_motion
from boltjoint.measurement.identification import scatter_between
from boltjoint.measurement.signals import Signals
from boltjoint.measurement.stepped_sine import identify_constant_response
from boltjoint.measurement.window_choice import RegressionOptions
from boltjoint.solvers.step_control import LaggedControl
from boltjoint.structure import contact_equilibrium, elasticity
from boltjoint.structure.elements import assembly, kinds, matrices
from boltjoint.structure.nonmatching_faces.weighted_points import weighted_points
from boltjoint.study import convergence
from boltjoint.verification.multi_harmonic import solve_periodic

JOINT, VARIABLE = make_joint(), make_joint(law="variable")
STORED = io.joint_to_dataset(JOINT)
WINDOW = (60.0, 200.0)
SOLVED = {"force": 1.0, "damping": 0.01, "resonance": boltjoint.Resonance(1, WINDOW)}
SOLVED |= {"method": boltjoint.LinearModes(), "control": boltjoint.StepControl()}
FORCES = {name: value for name, value in SOLVED.items() if name != "force"} | {"forces": [1.0]}
FORCES_ALONE = {name: FORCES[name] for name in ("forces", "damping", "resonance")}
RESPONSE = boltjoint.solve_response(JOINT, **FORCES)
IWAN = FourParameterIwan([0], [1.0], [1.0], [-0.5], [0.0])
K, SLIP = np.array([1e6, 2e6, 4e6]), np.array([1.0, 2.0, 3.0])
CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
SOLIDS = {
    "connectivity": np.arange(8)[None],
    "material": matrices.IsotropicMaterial(1.0, 0.3, np.ones(1)),
    "label": np.array([7]),
}
MODES, PRELOAD = make_two_pairs()

TIME = np.arange(1000) / 500
DECAY = Signals(TIME, (np.cos(250 * TIME) * np.exp(-TIME))[:, None], "velocity")
MODE = boltjoint.identify_ring_down(DECAY, (20.0, 60.0))
STIFFNESS = 40.0**2 - np.linspace(30.0, 50.0, 9) ** 2 + 20j

CURVE = boltjoint.MeasuredBackbone([1e-6, 1e-5], [90.0, 85.0], 1.0, [0.01, 0.02], 0.001)
SINE = boltjoint.MeasuredResponse(
    [30.0, 40.0], [1e-6, 2e-6], 1.0, 0.1, [-0.1, -0.3], 0.1, name="sine"
)


def values_of(found):
    return {field.name: getattr(found, field.name) for field in fields(found)}


def elements_of(law):
    return {name: getattr(law, name) for name in ("point_of_element", *law.quantities)}


#: valid calls: the function, and its arguments by name
CALLS = {
    "Branch": (boltjoint.Branch, values_of(boltjoint.solve_branch(JOINT, **SOLVED))),
    "ConstantLoad": (boltjoint.ConstantLoad, elements_of(JOINT.law)),
    "VariableLoad": (boltjoint.VariableLoad, elements_of(VARIABLE.law)),
    "FourParameterIwan": (FourParameterIwan, elements_of(IWAN)),
    "AlternatingFrequencyTime": (
        AlternatingFrequencyTime,
        {"elements": JOINT.law, "harmonics": 2, "samples": 16},
    ),
    "Joint": (boltjoint.Joint, values_of(JOINT)),
    "StepControl": (boltjoint.StepControl, values_of(boltjoint.StepControl())),
    "LaggedControl": (LaggedControl, values_of(LaggedControl())),
    "FitOptions": (hysteresis.FitOptions, values_of(hysteresis.FitOptions())),
    "connect_nodes": (
        boltjoint.connect_nodes,
        {
            "modes": MODES,
            "preload": PRELOAD,
            "tangential_stiffness": 1e8,
            "friction_coefficient": 0.1,
            "normal_stiffness": None,
        },
    ),
    "backbone_at": (
        boltjoint.backbone_at,
        {"joint": JOINT, "amplitudes": [1e-6, 1e-5], "damping": 0.01, "resonance": 1},
    ),
    "find_backbone": (
        boltjoint.find_backbone,
        {"joint": JOINT, "forces": [0.1], "damping": 0.01, "window": WINDOW},
    ),
    "fit_reduced_joint": (
        boltjoint.fit_reduced_joint,
        {
            "joint": boltjoint.partition_regions(JOINT, make_preload(JOINT), 2),
            "count": 1,
            "starts": 1,
            "options": hysteresis.FitOptions(),
        },
    ),
    "frequency_window": (
        lambda joint, **options: boltjoint.frequency_window(joint, **options),
        {"joint": JOINT, "resonance": 1, "given": WINDOW},
    ),
    "load_joint": (boltjoint.load_joint, {"path": "joint.nc", "sampling": {"samples": 16}}),
    "rescale_contact": (
        boltjoint.rescale_contact,
        {
            "joint": JOINT,
            "law": "constant",
            "before": {"tangential_stiffness": 1e6, "friction_coefficient": 0.1},
            "after": {"tangential_stiffness": 2e6, "friction_coefficient": 0.2},
            "preload_ratio": 1.5,
        },
    ),
    "partition_regions": (
        boltjoint.partition_regions,
        {
            "joint": JOINT,
            "preload": make_preload(JOINT),
            "count": 3,
            "division": "clusters",
            "motion": "load-weighted",
            "resonances": 1,
            "options": clusters.SlipStateOptions(),
        },
    ),
    "solve_branch": (boltjoint.solve_branch, {"joint": JOINT} | SOLVED),
    "Resonance": (boltjoint.Resonance, {"number": 1, "window": WINDOW}),
    "LinearModes": (boltjoint.LinearModes, values_of(boltjoint.LinearModes())),
    "ModalSynthesis": (
        boltjoint.ModalSynthesis,
        {"backbone": STORED, "jacobian": "analytic", "has_fallback": False},
    ),
    "ResponseDependentModes": (
        boltjoint.ResponseDependentModes,
        values_of(boltjoint.ResponseDependentModes(1)),
    ),
    "read_signals": (boltjoint.read_signals, {"path": "signals.csv", "quantity": "velocity"}),
    "identify_ring_down": (
        boltjoint.identify_ring_down,
        {
            "signals": DECAY,
            "band": (20.0, 60.0),
            "sensor": "sensor 1",
            "method": "analytic signal",
            "options": RegressionOptions(),
        },
    ),
    "simulate_ring_down": (
        boltjoint.simulate_ring_down,
        {
            "joint": JOINT,
            "damping": 0.01,
            "impulse": 1.0,
            "duration": 0.01,
            "sampling_rate": 1000.0,
            "quantity": "velocity",
            "resonance": 1,
            "steps": 100,
        },
    ),
    "Parameter": (
        boltjoint.Parameter,
        {
            "name": "chi",
            "low": -0.9,
            "high": -0.1,
            "logarithmic": False,
            "start": -0.5,
            "prior": Prior(-0.5, 0.1),
        },
    ),
    "MeasuredBackbone": (boltjoint.MeasuredBackbone, values_of(CURVE)),
    "MeasuredResponse": (boltjoint.MeasuredResponse, values_of(SINE)),
    "fit": (
        boltjoint.fit,
        {
            "model": JOINT,
            "measured": [CURVE],
            "parameters": [boltjoint.Parameter("slip_force", 100.0, 1000.0)],
            "damping": 0.01,
            "loss": "linear",
            "options": CalibrationOptions(starts=1, maximum_evaluations=2),
        },
    ),
    "Signals": (Signals, values_of(DECAY)),
    "identify_constant_response": (
        identify_constant_response,
        {
            "frequency": np.linspace(30.0, 50.0, 9),
            "response": np.ones(9),
            "force": abs(STIFFNESS),
            "phase": -np.angle(STIFFNESS),
            "quantity": "displacement",
        },
    ),
    "scatter_between": (scatter_between, {"modes": [MODE, MODE]}),
    "solve_response": (boltjoint.solve_response, {"joint": JOINT} | FORCES),
    "by_force": (
        boltjoint.by_force,
        # without folds, of which there are none
        {"response": RESPONSE.drop_dims("fold"), "joint": JOINT},
    ),
    "weigh_pairs": (
        boltjoint.weigh_pairs,
        {"joint": JOINT, "forces": [1.0], "damping": 0.01, "count": 3, "windows": {1: None}},
    ),
    "load": (dataset.load, {"path": "joint.nc"}),
    "save": (dataset.save, {"dataset": STORED, "path": "other.nc", "parameters": {"count": 3}}),
    "joint_from_dataset": (io.joint_from_dataset, {"stored": STORED}),
    "joint_to_dataset": (io.joint_to_dataset, {"joint": JOINT, "reduced_from": STORED}),
    "merge_points": (
        derived.merge_points,
        {"joint": JOINT, "region": np.arange(60) // 20, "weight": np.ones(60)},
    ),
    "keep_elements": (model.keep_elements, {"joint": JOINT, "weight": np.ones(60)}),
    "region_error": (partition.region_error, {"joint": JOINT, "regions": JOINT, "resonances": 1}),
    "cluster_by_motion": (cluster_by_motion, {"joint": JOINT, "count": 2}),
    "bands_of_equal_load": (
        bands.bands_of_equal_load,
        {"position": JOINT.position[:, :2], "load": np.ones(60), "count": 3},
    ),
    "fit_elements": (fit_jenkins.fit_elements, {"stiffness": K, "slip_force": SLIP, "count": 1}),
    "loop_error": (
        hysteresis.loop_error,
        {"stiffness": K, "slip_force": SLIP, "fitted_stiffness": K, "fitted_slip_force": SLIP},
    ),
    "HarmonicBalance": (
        HarmonicBalance,
        {"joint": JOINT, "damping": LossFactor(0.01), "excitation_force": 1.0, "basis": np.eye(3)},
    ),
    "EPMCEquations": (EPMCEquations, {"joint": JOINT, "damping": 0.01, "resonance": 1}),
    "PeriodicMotion": (
        PeriodicMotion,
        {"components": ("sin", "cos"), "modal_coordinate": np.zeros((2, 3))},
    ),
    "to_dataset": (
        response_file.to_dataset,
        {
            "joint": JOINT,
            "branches": [boltjoint.solve_branch(JOINT, **SOLVED)],
            "damping": 0.01,
            "errors": None,
            "limits": branch.ErrorLimits(),
        },
    ),
    "find_folds": (folds.find_folds, {"frequency": np.array([1.0, 2.0]), "complete": True}),
    "solve_periodic": (
        solve_periodic,
        {"joint": JOINT, "frequency": 70.0, "force": 1.0, "damping": 0.01, "harmonics": 3},
    ),
    "contact_force": (
        contact_equilibrium.contact_force,
        {"relative": np.zeros((1, 3)), "stiffness": np.ones(1), "friction_coefficient": 0.1},
    ),
    "assemble": (
        elasticity.assemble,
        {
            "coordinate": CUBE,
            "connectivity": np.arange(8)[None],
            "youngs_modulus": 2e11,
            "poissons_ratio": 0.3,
            "density": 7800.0,
        },
    ),
    "element_matrices": (
        partial(matrices.element_matrices, kinds.KINDS["C3D8I"]),
        {
            "coordinate": CUBE[None],
            "material": matrices.IsotropicMaterial(1.0, 0.3, 1.0),
            "options": matrices.ElementOptions(),
        },
    ),
    "ElementBlock": (partial(assembly.ElementBlock, kinds.KINDS["C3D8R"]), SOLIDS),
    "assemble solids": (
        partial(assembly.assemble, blocks=[assembly.ElementBlock(kinds.KINDS["C3D8"], **SOLIDS)]),
        {"coordinate": CUBE, "options": matrices.ElementOptions()},
    ),
    "weighted_points": (
        weighted_points,
        {
            "coordinate": np.concatenate([CUBE, CUBE + np.array([0.0, 0.0, 1.0])]),
            "side_a": [np.array([[4, 5, 6, 7]])],
            "side_b": [np.array([[8, 11, 10, 9]])],
            "along": np.array([1.0, 0.0, 0.0]),
            "weighting": "dual",
            "largest_gap": 0.1,
        },
    ),
    "element_mass": (elasticity.element_mass, {"corners": CUBE[None], "density": 7800.0}),
    "tabulate_divisions": (
        convergence.tabulate_divisions,
        {
            "joint": JOINT,
            "preload": make_preload(JOINT),
            "counts": [2],
            "reference": pd.DataFrame(
                {"force_N": [1.0], "peak_frequency_Hz": [70.0], "peak_mm_per_N": [1.0]}
            ),
            "damping": 0.01,
        },
    ),
}

#: two masses on springs, each with three displacements, that touch
SIDES = np.arange(6).reshape(2, 1, 3)
PAIR = {
    "side_a": SIDES[0],
    "side_b": SIDES[1],
    "dofs": 6,
    "position": np.zeros((1, 3)),
    "area": np.array([1e-4]),
    "friction_coefficient": 0.1,
}
MATRICES = {
    "stiffness": np.diag([1e6, 1e6, 2e6, 3e6, 3e6, 4e6]),
    "mass": np.eye(6),
    "contact": boltjoint.ContactPoints.of_pairs(**PAIR),
    "bolts": {"bolt": np.array([0.0, 0.0, 1.0, 0.0, 0.0, -1.0])},
    "inputs": {"shaker": 2},
    "outputs": {"sensor": 2},
    "support": np.ones((3, 6)),
}
STRUCTURE = boltjoint.Structure.from_matrices(**MATRICES)
CALLS |= {
    "ContactPoints": (boltjoint.ContactPoints.of_pairs, PAIR),
    "Structure": (boltjoint.Structure.from_matrices, MATRICES),
    "apply_preload": (
        boltjoint.apply_preload,
        {"assembly": STRUCTURE, "preload": 10.0, "tolerance": 1e-9, "maximum_iterations": 20},
    ),
    "find_modes": (
        boltjoint.find_modes,
        {"assembly": STRUCTURE, "family": "free-1", "pod_modes": None},
    ),
}


SLIDING = boltjoint.Structure.from_matrices(
    **MATRICES
    | {
        "stiffness": np.diag(np.arange(1, 7) * 1e6),
        "inputs": {"shaker": 0},
        "outputs": {"sensor": 0},
    }
)


def connect(preload):
    """The joint of two masses that slide on each other."""
    return boltjoint.connect_nodes(boltjoint.find_modes(SLIDING, "all-6"), preload, 1e6, 0.3)


BOLTS = {
    "structure": SLIDING,
    "preload": 10.0,
    "connect": connect,
    "damping": 0.01,
    "levels": (0.5, 1.0),
    "around": (0.9,),
}
OF_BOLT = boltjoint.BoltPreloads(**BOLTS)
SOFT = boltjoint.MeasuredBackbone([1e-6, 1e-5], [200.0, 190.0], 50.0, [0.01, 0.02], 1.0)
FEW = CalibrationOptions(starts=1, maximum_evaluations=2)
FITTED = {"model": OF_BOLT, "measured": SOFT, "repetitions": 0, "options": FEW}
CALLS |= {
    "BoltPreloads": (boltjoint.BoltPreloads, BOLTS),
    "fit_preloads": (boltjoint.fit_preloads, FITTED),
    "loosest_bolt": (
        boltjoint.loosest_bolt,
        {"found": boltjoint.fit_preloads(**FITTED), "count": 20, "seed": 1},
    ),
}

#: two bodies of twelve nodes each, of which the first ten are in contact
BODIES = np.arange(72).reshape(2, 12, 3)
NODES = np.column_stack([np.arange(10.0), np.zeros((10, 2))])
TWO_BODIES = boltjoint.Structure.from_matrices(
    stiffness=np.diag(np.linspace(1e6, 3e7, 73)) - 1e4 * (np.ones((73, 73)) - np.eye(73)),
    mass=np.diag(np.append(np.ones(72), 1e-3)),
    contact=boltjoint.ContactPoints.of_pairs(
        BODIES[0, :10], BODIES[1, :10], 73, position=NODES, area=1e-4, friction_coefficient=0.1
    ),
    bolts={"bolt": np.eye(73)[2] - np.eye(73)[38]},
    inputs={"shaker": 30},
    outputs={"sensor": 30},
)
LOADED = boltjoint.apply_preload(TWO_BODIES, 10.0)
COULOMB = {"law": "constant", "tangential_stiffness_N_per_m": 1e6, "friction_coefficient": 0.3}
CALLS |= {
    "ContactCondition": (boltjoint.ContactCondition.of, {"contact": COULOMB, "damping": 0.01}),
    "find_pod_modes": (
        # a preload that is not finite is refused with what it spoils, by a RuntimeError
        partial(boltjoint.find_pod_modes, preload=LOADED),
        {
            "assembly": TWO_BODIES,
            "conditions": [boltjoint.ContactCondition.of(COULOMB, 0.01)],
        },
    ),
    "find_converged_peaks": (boltjoint.find_converged_peaks, {"joint": JOINT, **FORCES_ALONE}),
}

#: calls of each, of which every one has another argument
NUMBER = 40


def test_all_public_names_are_called():
    assert set(boltjoint._NAMES) <= set(CALLS)


@pytest.mark.parametrize("name", CALLS)
def test_hostile_arguments_are_refused_by_a_value_error(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    dataset.save(STORED, tmp_path / "joint.nc")
    (tmp_path / "signals.csv").write_text("time_s,velocity_m_per_s\n0,1\n1,-1\n2,0.5\n")
    assert_refused(*CALLS[name], name, NUMBER)
