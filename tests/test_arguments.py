"""Wrong arguments of public functions and classes: each is refused by its name.

The first ones used to write outside arrays and to abort the process, or to change what was asked
for without a word.
"""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from small_joint import make_joint, make_preload, make_two_pairs

from boltjoint import dataset
from boltjoint.dynamics.backbone.backbone import find_backbone, trace_backbone
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.backbone.modal_synthesis import synthesise_response
from boltjoint.dynamics.balance.balance_equations import BalanceEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import PeriodicMotion
from boltjoint.dynamics.response import folds, response_file
from boltjoint.dynamics.response.complex_rdnm import ComplexRDNM
from boltjoint.dynamics.response.frequency_response import method_of, solve_branch, solve_response
from boltjoint.dynamics.response.methods import LinearModes, ResponseDependentModes
from boltjoint.dynamics.response.rdnm import SelfConsistentRDNM
from boltjoint.dynamics.response.windows import Resonance, frequency_window
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.friction.tabulated import TabulatedLoad
from boltjoint.joint.bands import (
    bands_of_equal_load,
    bands_of_equal_middle_load,
    inner_and_outer_bands,
)
from boltjoint.joint.clusters import cluster_by_motion
from boltjoint.joint.derived import merge_points
from boltjoint.joint.fit_jenkins import fit_elements
from boltjoint.joint.hysteresis import (
    amplitude_of_load,
    loading_curve,
    loop_error,
    minimax_loading_curve,
    unloading_branch,
)
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset, load_joint
from boltjoint.joint.node_to_node import connect_nodes
from boltjoint.joint.partition import choose_count, partition_regions
from boltjoint.joint.reduced import fit_reduced_joint, tabulate_joint
from boltjoint.names import Coordinates
from boltjoint.solvers.step_control import StepControl
from boltjoint.study import convergence
from boltjoint.study.timing import Timed
from boltjoint.verification import residual_in_time
from boltjoint.verification.multi_harmonic import solve_periodic
from boltjoint.verification.time_integration import steady_state

JOINT, VARIABLE = make_joint(), make_joint(law="variable")
PRELOAD = make_preload(JOINT)
CONSTANT_LAW, VARIABLE_LAW = JOINT.law, VARIABLE.law
TABULATED = TabulatedLoad(
    CONSTANT_LAW.point_of_element, CONSTANT_LAW.tangential_stiffness, CONSTANT_LAW.slip_force
)
IWAN = FourParameterIwan([0], [1.0], [1.0], [-0.5], [0.0])
SAMPLED = AlternatingFrequencyTime(VARIABLE_LAW, 2, 16)
BALANCE = HarmonicBalance(JOINT, 0.01, 1.0)
MODE = EPMCEquations(JOINT, 0.01)
PERIODIC = PeriodicMotion(("sin", "cos"), np.zeros((2, 3)))
STORED = joint_to_dataset(JOINT)
REFERENCE = pd.DataFrame({"force_N": [1.0], "peak_frequency_Hz": [70.0], "peak_mm_per_N": [1.0]})
K, SLIP = np.array([1e6, 2e6, 4e6]), np.array([1.0, 2.0, 3.0])
NAN = np.nan


def spoiled(values, value=NAN):
    """The same values but for the first one."""
    changed = np.array(values, dtype=float)
    changed.flat[0] = value
    return changed


def objects_of(*, coordinates="linear", loss_factor=0.01, resonance=1, window=None, **words):
    """Arguments of ``solve_branch`` and ``solve_response`` by the words of files."""
    own = {name: words.pop(name) for name in ("control", "start") if name in words}
    method = method_of(coordinates, **words)
    around = resonance if window is None else Resonance(resonance, window)
    return {"method": method, "damping": loss_factor, "resonance": around, **own}


def solved(joint=JOINT, force=1.0, **words):
    return solve_branch(joint, force, **objects_of(**words))


def responses(forces=(1.0,), **words):
    return solve_response(JOINT, forces, **objects_of(**words))


def backbones(joint=JOINT, forces=(1.0,), loss_factor=0.01, window=(60.0, 200.0), **options):
    return find_backbone(joint, forces, damping=loss_factor, window=window, **options)


def regions(count=4, **options):
    return partition_regions(JOINT, options.pop("preload", PRELOAD), count, **options)


def fitted(stiffness=K, slip_force=SLIP, count=2, **options):
    return fit_elements(stiffness, slip_force, count, **options)


def steady(joint=JOINT, frequency=70.0, force=1.0, loss_factor=0.01, **options):
    return steady_state(joint, frequency, force, loss_factor, **options)


def periodic(joint=JOINT, frequency=70.0, force=1.0, loss_factor=0.01, **options):
    return solve_periodic(joint, frequency, force, loss_factor, **{"harmonics": 3} | options)


def connected(modes=None, preload=None, k=1e8, mu=0.1, normal=None):
    """A joint of two pairs."""
    shapes, carried = make_two_pairs()
    return connect_nodes(shapes.assign(modes or {}), carried.assign(preload or {}), k, mu, normal)


ATTACKS = {
    "motion": [
        lambda: CONSTANT_LAW.force(np.zeros((59, 2))),
        lambda: CONSTANT_LAW.force_and_tangent(np.zeros((0, 2))),
        lambda: CONSTANT_LAW.contact_state(np.zeros((1, 2))),
        lambda: CONSTANT_LAW.force(np.zeros((60, 3))),
        lambda: CONSTANT_LAW.force(np.zeros(120)),
        lambda: CONSTANT_LAW.force(spoiled(np.zeros((60, 2)))),
        lambda: CONSTANT_LAW.force("nope"),
        lambda: CONSTANT_LAW.force(np.zeros((60, 2), dtype=complex)),
        lambda: VARIABLE_LAW.force(np.zeros((59, 6))),
        lambda: VARIABLE_LAW.force_and_tangent(np.zeros((1, 6))),
        lambda: VARIABLE_LAW.contact_state(np.zeros((1, 6))),
        lambda: VARIABLE_LAW.force(np.zeros((60, 2))),
        lambda: VARIABLE_LAW.force(spoiled(np.zeros((60, 6)), np.inf)),
        lambda: TABULATED.force(np.zeros((59, 2))),
        lambda: TABULATED.force_and_tangent(np.zeros((1, 2))),
        lambda: TABULATED.contact_state(np.zeros((1, 2))),
        lambda: SAMPLED.force(np.zeros((59, 10))),
        lambda: SAMPLED.force_and_tangent(np.zeros((60, 6))),
        lambda: SAMPLED.contact_state(np.zeros((1, 10))),
        lambda: VARIABLE_LAW.forces_in_time(np.zeros((60, 2)), 8),
        lambda: VARIABLE_LAW.forces_in_time(np.full((60, 6), NAN), 8),
        lambda: VARIABLE_LAW.forces_in_time(np.zeros((59, 6)), 8),
        lambda: CONSTANT_LAW.forces_in_time(np.zeros((60, 2)), 8),
        lambda: IWAN.forces_in_time(np.zeros((1, 2)), 8),
        lambda: IWAN.forces_in_time(np.zeros((0, 6)), 8),
        lambda: regions(motion="nope"),
        lambda: choose_count(JOINT, PRELOAD, 0.1, motion="nope"),
        lambda: partition_regions(JOINT, PRELOAD, 2, motion=None),
    ],
    "point_of_element": [
        lambda: ConstantLoad([0.0], [1.0], [1.0]),
        lambda: ConstantLoad([-1], [1.0], [1.0]),
        lambda: ConstantLoad([[0]], [1.0], [1.0]),
        lambda: replace(VARIABLE_LAW, point_of_element=VARIABLE_LAW.point_of_element - 1),
        lambda: VARIABLE_LAW.replaced_by([60], [1.0], [1.0]),
        lambda: replace(VARIABLE_LAW, point_of_element=np.arange(60.0)),
        lambda: replace(JOINT, law=replace(CONSTANT_LAW, point_of_element=np.full(60, 60))),
    ],
    "tangential_stiffness": [
        lambda: ConstantLoad([0], [0.0], [1.0]),
        lambda: ConstantLoad([0], [np.inf], [1.0]),
        lambda: ConstantLoad([0], ["nope"], [1.0]),
        lambda: ConstantLoad([0], np.ma.array([1.0], mask=[True]), [1.0]),
        lambda: ConstantLoad([0], [np.ma.array(1.0, mask=True)], [1.0]),
        lambda: replace(VARIABLE_LAW, tangential_stiffness=np.ones(59)),
        lambda: replace(VARIABLE_LAW, tangential_stiffness=np.full(60, -1.0)),
        lambda: connected(k=0.0),
        lambda: connected(k=NAN),
    ],
    "slip_force": [
        lambda: ConstantLoad([0], [1.0], [NAN]),
        lambda: ConstantLoad([0], [1.0], [-1.0]),
        lambda: ConstantLoad([0], [1.0], [1.0, 2.0]),
        lambda: fitted(slip_force=SLIP[:2]),
        lambda: fitted(slip_force=spoiled(SLIP, 0.0)),
        lambda: ConstantLoad([0], [1.0], [0.0]),
    ],
    "normal_stiffness": [
        lambda: replace(VARIABLE_LAW, normal_stiffness=np.zeros(60)),
        lambda: replace(VARIABLE_LAW, normal_stiffness=np.full(60, NAN)),
        lambda: connected(normal=-1.0),
    ],
    "normal_load": [
        lambda: replace(VARIABLE_LAW, normal_load=spoiled(VARIABLE_LAW.normal_load)),
        lambda: replace(VARIABLE_LAW, normal_load=np.full(60, np.inf)),
        lambda: connected(preload={"normal_load": ("pair", [1.0, NAN])}),
        lambda: connected(preload={"normal_load": ("pair", [1.0, -1.0])}),
    ],
    "friction_coefficient": [
        lambda: replace(VARIABLE_LAW, friction_coefficient=np.full(60, -0.1)),
        lambda: replace(VARIABLE_LAW, friction_coefficient=[1.0]),
        lambda: connected(mu=0.0),
        lambda: connected(mu="nope"),
    ],
    "points": [
        lambda: CONSTANT_LAW.stuck_stiffness(59),
        lambda: VARIABLE_LAW.stuck_stiffness(60.0),
    ],
    "elements": [
        lambda: AlternatingFrequencyTime(SAMPLED),
        lambda: AlternatingFrequencyTime("nope"),
    ],
    "harmonics": [
        lambda: AlternatingFrequencyTime(CONSTANT_LAW, 0),
        lambda: AlternatingFrequencyTime(CONSTANT_LAW, 1.5),
        lambda: periodic(harmonics=0),
        lambda: steady(harmonics=0),
    ],
    "samples": [
        lambda: AlternatingFrequencyTime(CONSTANT_LAW, 4, 8),
        lambda: AlternatingFrequencyTime(CONSTANT_LAW, 1, NAN),
        lambda: VARIABLE_LAW.forces_in_time(np.zeros((60, 6)), 2),
        lambda: CONSTANT_LAW.forces_in_time(np.zeros((60, 6)), 8.0),
        lambda: IWAN.forces_in_time(np.zeros((1, 6)), 0),
        lambda: periodic(samples=6),
        lambda: PERIODIC.in_time(0),
        lambda: convergence.tabulate_sampling({}, samples=[2]),
        lambda: residual_in_time.residuals_in_time(STORED, STORED, samples=0),
    ],
    "amplitude": [
        lambda: SAMPLED.modal_force_and_tangent(VARIABLE.rows, np.zeros((3, 3)), 0.0),
        lambda: unloading_branch(0.0, [0.0], K, SLIP),
    ],
    "rows": [
        lambda: SAMPLED.modal_force_and_tangent(JOINT.rows, np.zeros((5, 3)), 0.0),
        lambda: SAMPLED.modal_force_and_tangent((np.zeros((1, 3)),) * 2, np.zeros((5, 3)), 0.0),
        lambda: SAMPLED.modal_force_and_tangent(VARIABLE.rows, np.zeros((5, 2)), 0.0),
    ],
    "natural_frequency": [
        lambda: replace(JOINT, natural_frequency=[NAN, 360.0, 950.0]),
        lambda: replace(JOINT, natural_frequency=[-70.0, 360.0, 950.0]),
        lambda: replace(JOINT, natural_frequency=70.0),
        lambda: replace(JOINT, natural_frequency=[]),
        lambda: joint_from_dataset(STORED.drop_vars("natural_frequency")),
        lambda: connected(modes={"natural_frequency": ("mode", [NAN])}),
    ],
    "excitation_mode": [
        lambda: replace(JOINT, excitation_mode=[1.0, NAN, 1.0]),
        lambda: replace(JOINT, excitation_mode=[1.0, 1.0]),
        lambda: solved(replace(JOINT, excitation_mode=np.zeros(3))),
        lambda: backbones(replace(JOINT, excitation_mode=np.full(3, 1e-12))),
    ],
    "response_mode": [
        lambda: replace(JOINT, response_mode=["a", "b", "c"]),
        lambda: solved(replace(JOINT, response_mode=np.zeros(3))),
        lambda: backbones(replace(JOINT, response_mode=np.full(3, 1e-12))),
    ],
    "tangential_mode": [
        lambda: replace(JOINT, tangential_mode=spoiled(JOINT.tangential_mode)),
        lambda: replace(JOINT, tangential_mode=JOINT.tangential_mode.T),
        lambda: joint_from_dataset(STORED.assign(tangential_mode=("element", np.ones(60)))),
    ],
    "normal_mode": [
        lambda: replace(VARIABLE, normal_mode=spoiled(VARIABLE.normal_mode, np.inf)),
        lambda: replace(VARIABLE, normal_mode=VARIABLE.normal_mode[:1]),
    ],
    "position": [
        lambda: replace(JOINT, position=spoiled(JOINT.position)),
        lambda: replace(JOINT, position=JOINT.position[:, :2]),
        lambda: bands_of_equal_load(np.zeros((3, 1)), np.ones(3), 1),
        lambda: connected(modes={"position": (("pair", "axis"), np.full((2, 3), NAN))}),
    ],
    "element_position": [lambda: replace(JOINT, element_position=JOINT.position[1:])],
    "relative_mode": [
        lambda: connected({"relative_mode": (("axis", "pair", "mode"), np.full((3, 2, 1), NAN))})
    ],
    "gap": [
        lambda: connected(normal=1.0, preload={"gap": ("pair", [0.0, NAN])}),
        lambda: connected(normal=1.0, preload={"gap": ("pair", [0.0, -1.0])}),
    ],
    "law": [
        lambda: replace(JOINT, law="constant"),
        lambda: joint_from_dataset(STORED.assign_attrs(law="nope")),
        lambda: joint_to_dataset(replace(JOINT, law=AlternatingFrequencyTime(CONSTANT_LAW))),
        lambda: steady(replace(JOINT, law=AlternatingFrequencyTime(CONSTANT_LAW))),
        lambda: tabulate_joint(VARIABLE),
    ],
    "stored": [
        lambda: joint_from_dataset({}),
        lambda: joint_from_dataset(STORED.drop_vars("slip_force")),
    ],
    "region": [
        lambda: merge_points(JOINT, np.zeros(60)),
        lambda: merge_points(JOINT, np.zeros(59, dtype=int)),
        lambda: merge_points(JOINT, np.full(60, -1)),
        lambda: merge_points(JOINT, np.full(60, 1)),
    ],
    "weight": [
        lambda: merge_points(JOINT, np.zeros(60, dtype=int), np.full(60, NAN)),
        lambda: merge_points(JOINT, np.zeros(60, dtype=int), np.zeros(60)),
    ],
    "joint": [
        lambda: merge_points("nope", [0]),
        lambda: frequency_window(None),
        lambda: solved("nope"),
        lambda: backbones(CONSTANT_LAW),
        lambda: HarmonicBalance(None, 0.0, 1.0),
        lambda: regions_of(None),
        lambda: steady(None),
        lambda: periodic(None),
        lambda: fit_reduced_joint(None, 2),
        lambda: residual_in_time.residuals_in_time(JOINT, STORED),
    ],
    "joints": [lambda: frequency_window()],
    "loss_factor": [
        lambda: HarmonicBalance(JOINT, -0.01, 1.0),
        lambda: solved(loss_factor=-1e-9),
        lambda: solved(loss_factor=NAN),
        lambda: solved(loss_factor=np.ma.masked),
        lambda: solved(loss_factor="nope"),
        lambda: responses(loss_factor=-0.01),
        lambda: backbones(loss_factor=-0.01),
        lambda: steady(loss_factor=-0.01),
        lambda: periodic(loss_factor=-0.01),
        lambda: response_file.to_dataset(JOINT, [solved()], -0.01),
    ],
    "excitation_force": [lambda: HarmonicBalance(JOINT, 0.01, np.inf)],
    "basis": [
        lambda: replace(BALANCE, basis=np.eye(2)),
        lambda: replace(BALANCE, basis=np.full((3, 1), NAN)),
    ],
    "x": [lambda: BALANCE.residual(np.zeros(5), 1.0), lambda: BALANCE.motion(np.zeros((2, 3)))],
    "w": [lambda: BALANCE.stuck_solution(NAN), lambda: BALANCE.stuck_solution(-1.0)],
    "force": [
        lambda: solved(force=0.0),
        lambda: solved(force=5e-324),
        lambda: solved(force=1e200),
        lambda: solved(force=-1.0),
        lambda: solved(force=NAN),
        lambda: solved(force=[1.0]),
        lambda: synthesise_response(trace_backbone(MODE, (1e-8, 1e-7)), -1.0, (60.0, 200.0)),
        lambda: steady(force=0.0),
        lambda: periodic(force=np.inf),
    ],
    "forces": [
        lambda: responses([]),
        lambda: responses([1.0, -1.0]),
        lambda: responses([1.0, 1e-310]),
        lambda: backbones(forces=[1e-160]),
        lambda: responses(1.0),
        lambda: backbones(forces=[NAN]),
        lambda: MODE.amplitudes_for([0.0], (60.0, 200.0)),
        lambda: convergence.peaks_near(JOINT, [], 0.01),
    ],
    "window": [
        lambda: solved(window=(200.0, 60.0)),
        lambda: solved(window=np.ma.array([60.0, 200.0], mask=[False, True])),
        lambda: solved(window=(-60.0, 200.0)),
        lambda: solved(window=(0.0, 200.0)),
        lambda: solved(window=(60.0, NAN)),
        lambda: solved(window=(60.0,)),
        lambda: solved(window="nope"),
        lambda: responses(window=(60.0, 60.0)),
        lambda: backbones(window=(200.0, 60.0)),
    ],
    "given": [
        lambda: frequency_window(JOINT, given=(200.0, 60.0)),
        lambda: frequency_window(JOINT, given=(-1.0, 60.0)),
    ],
    "frequency": [
        lambda: steady(frequency=0.0),
        lambda: periodic(frequency=-70.0),
        lambda: folds.find_folds([1.0, NAN]),
    ],
    "resonance": [
        lambda: solved(resonance=0),
        lambda: solved(resonance=4),
        lambda: solved(resonance=1.5),
        lambda: responses(resonance="1"),
        lambda: backbones(resonance=-1),
        lambda: frequency_window(JOINT, resonance=True),
        lambda: method_of("linear").formulate(BALANCE, 0),
    ],
    "coordinates": [
        lambda: solved(coordinates="nope"),
        lambda: solved(coordinates=None),
        lambda: responses(coordinates="rdnm-0"),
        lambda: method_of("nope"),
        lambda: Coordinates(1),
    ],
    "jacobian": [
        lambda: solved(jacobian="nope"),
        lambda: solved(jacobian="nope", coordinates="backbone"),
        lambda: responses(jacobian=None),
        lambda: BalanceEquations(BALANCE, "nope"),
        lambda: ResponseDependentModes(1, jacobian="nope"),
    ],
    "is_lagged": [lambda: ResponseDependentModes(1, is_lagged="lagged")],
    "is_complex": [lambda: ResponseDependentModes(1, is_complex=1)],
    "has_fallback": [lambda: LinearModes(has_fallback="none")],
    "repeats": [lambda: LinearModes(repeats=1)],
    "basis_update": [
        lambda: solved(basis_update="nope", coordinates="complex-rdnm-1"),
        lambda: solved(basis_update="nope"),
    ],
    "quasi_static_correction": [
        lambda: solved(quasi_static_correction="x", coordinates="complex-rdnm-1"),
        lambda: solved(quasi_static_correction="x"),
        lambda: ResponseDependentModes(1, quasi_static_correction=1),
    ],
    "fallback": [lambda: responses(fallback="nope"), lambda: responses(fallback=True)],
    "largest_error": [lambda: responses(largest_error=0.0), lambda: responses(largest_error=NAN)],
    "control": [lambda: solved(control={}), lambda: periodic(control="nope")],
    "balance": [lambda: BalanceEquations(JOINT)],
    "count": [
        lambda: SelfConsistentRDNM(BALANCE, 1.0),
        lambda: regions(0, division="equal-middle-load"),
        lambda: regions(2.0),
        lambda: regions("two", division="clusters"),
        lambda: fitted(count=0),
        lambda: fitted(count=2.0),
        lambda: minimax_loading_curve(K, SLIP, 0),
    ],
    "counts": [lambda: convergence.tabulate_divisions(JOINT, PRELOAD, [0.5], REFERENCE, 0.01)],
    "target": [lambda: SelfConsistentRDNM(BALANCE, 1, 3), lambda: ComplexRDNM(BALANCE, 1, -1)],
    "start": [
        lambda: solved(start=np.zeros(5)),
        lambda: solved(start=np.full(6, NAN)),
        lambda: steady(start=np.zeros((8, 2))),
        lambda: steady(start=np.zeros((0, 3))),
        lambda: periodic(start=np.zeros((2, 3))),
        lambda: periodic(start=PeriodicMotion(("sin", "cos"), np.zeros((2, 2)))),
    ],
    "branches": [lambda: response_file.to_dataset(JOINT, [], 0.01)],
    "errors": [lambda: response_file.to_dataset(JOINT, [solved()], 0.01, [])],
    "amplitudes": [
        lambda: trace_backbone(MODE, (1e-7, 1e-8)),
        lambda: trace_backbone(MODE, (0.0, 1.0)),
    ],
    "equations": [lambda: trace_backbone(BALANCE, (1e-8, 1e-7))],
    "backbone": [lambda: synthesise_response(MODE, 1.0, (60.0, 200.0))],
    "tolerance": [
        lambda: StepControl(tolerance=NAN),
        lambda: StepControl(tolerance="nope"),
        lambda: StepControl(tolerance=1e-300),
        lambda: steady(tolerance=0.0),
        lambda: choose_count(JOINT, PRELOAD, NAN),
        lambda: residual_in_time.residuals_in_time(STORED, STORED, tolerance=-1.0),
    ],
    "largest_step": [lambda: StepControl(largest_step=np.inf)],
    "smallest_step": [lambda: StepControl(smallest_step=1e-300)],
    "maximum_iterations": [
        lambda: StepControl(maximum_iterations=2.5),
        lambda: StepControl(maximum_iterations=10**9),
    ],
    "maximum_solutions": [
        lambda: StepControl(maximum_solutions=0),
        lambda: StepControl(maximum_solutions=10**19),
    ],
    "division": [
        lambda: regions(division="nope"),
        lambda: choose_count(JOINT, PRELOAD, 0.1, "nope"),
        lambda: convergence.tabulate_divisions(
            JOINT, PRELOAD, [2], REFERENCE, 0.01, division="nope"
        ),
    ],
    "resonances": [lambda: regions(resonances=0), lambda: regions(resonances=1.0)],
    "load": [
        lambda: bands_of_equal_load(np.zeros((3, 2)), np.zeros(3), 1),
        lambda: bands_of_equal_load(np.zeros((3, 2)), [1.0, NAN, 1.0], 1),
        lambda: inner_and_outer_bands(np.zeros((3, 2)), np.ones(2), 2),
    ],
    "pressure": [lambda: bands_of_equal_middle_load(np.zeros((3, 2)), [1.0, -1.0, 1.0], 1)],
    "preload": [
        lambda: regions(preload=None),
        lambda: regions(preload="nope", division="clusters"),
        lambda: regions(preload=PRELOAD.drop_vars("normal_load")),
        lambda: regions(preload=None, division="equal-middle-load"),
        lambda: choose_count(JOINT, None, 0.1),
        lambda: regions(preload=PRELOAD.drop_vars("area"), division="equal-middle-load"),
    ],
    "stiffness": [
        lambda: fitted(spoiled(K)),
        lambda: fitted(spoiled(K, -1.0)),
        lambda: fitted([], []),
        lambda: loop_error(K[None], SLIP, K, SLIP),
        lambda: minimax_loading_curve(spoiled(K), SLIP, 1),
        lambda: loading_curve([0.0], spoiled(K, 0.0), SLIP),
    ],
    "fitted_stiffness": [lambda: loop_error(K, SLIP, spoiled(K), SLIP)],
    "displacement": [lambda: loading_curve([NAN], K, SLIP)],
    "fraction": [lambda: amplitude_of_load(1.5, K, SLIP)],
    "load_fractions": [lambda: fitted(load_fractions=(0.0, 0.5))],
    "starts": [lambda: fitted(starts=0)],
    "sharpness": [lambda: minimax_loading_curve(K, SLIP, 1, NAN)],
    "method": [
        lambda: solve_branch(JOINT, 1.0, 1, damping=0.01),
        lambda: Timed.of("linear"),
        lambda: fitted(method="nope"),
        lambda: fit_reduced_joint(merge_points(JOINT, [0] * 60), 2, method="nope"),
    ],
    "ramp": [lambda: steady(ramp=-1)],
    "steps": [lambda: steady(steps=100.5)],
    "maximum_periods": [lambda: steady(ramp=10, maximum_periods=10)],
    "modal_coordinate": [lambda: PeriodicMotion(("sin", "cos"), np.zeros((3, 3)))],
    "mode": [lambda: PERIODIC.amplitude([1.0, 2.0])],
}


def regions_of(joint):
    return cluster_by_motion(joint, 2)


DESCRIBED = [
    pytest.param(name, call, id=f"{name}-{i}")
    for name, calls in ATTACKS.items()
    for i, call in enumerate(calls)
]


@pytest.mark.parametrize(("name", "call"), DESCRIBED)
def test_a_wrong_argument_is_refused_by_its_name(name, call):
    with pytest.raises(ValueError, match=rf"(?<!\w){re.escape(name)}(?!\w)"):
        call()


def test_sampling_of_a_joint_file_is_refused_by_its_name(tmp_path):
    dataset.save(STORED, tmp_path / "joint.nc")
    for sampling in ({"nope": 1}, {"samples": 2}, {"harmonics": 0.5}):
        with pytest.raises(ValueError, match=r"sampling|samples|harmonics"):
            load_joint(tmp_path / "joint.nc", sampling)


@pytest.mark.parametrize("law", [CONSTANT_LAW, VARIABLE_LAW, TABULATED, SAMPLED])
def test_whole_numbers_and_lists_count_as_the_same_motion(law):
    motion = np.ones((60, len(law.directions) * len(law.components)))
    for same in (motion.astype(int), motion.tolist(), np.asfortranarray(motion)):
        np.testing.assert_array_equal(law.force(same), law.force(motion))
        for found, expected in zip(
            law.force_and_tangent(same), law.force_and_tangent(motion), strict=True
        ):
            np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(law.contact_state(same), law.contact_state(motion))


def test_a_joint_may_be_made_of_lists():
    listed = replace(
        JOINT,
        **{
            name: getattr(JOINT, name).tolist()
            for name in ("natural_frequency", "tangential_mode", "position", "element_position")
        },
        law=ConstantLoad(
            *(
                getattr(CONSTANT_LAW, name).tolist()
                for name in ("point_of_element", *CONSTANT_LAW.quantities)
            )
        ),
    )
    found, expected = solved(listed), solved()
    np.testing.assert_array_equal(found.modal_coordinate, expected.modal_coordinate)


def test_iterations_may_overflow():
    for law in (CONSTANT_LAW, VARIABLE_LAW, TABULATED, SAMPLED):
        motion = np.full((60, len(law.directions) * len(law.components)), NAN)
        force, tangent = law.evaluate_with_tangent(motion, 0.0)
        assert force.shape == motion.shape
        assert tangent.shape == (*motion.shape, motion.shape[1])
