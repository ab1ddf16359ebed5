"""Stages of a study before its responses: mesh, preload, modes, basis, joints."""

from functools import partial

import pytest
import yaml
from least_work import LOSS_FACTOR
from study_joints import RESULTS, joint_of

from boltjoint import dataset
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.numerical_options import ContactAdaptedBasis
from boltjoint.dynamics.reduction.basis_from_backbones import find_pod_modes
from boltjoint.dynamics.reduction.contact_condition import ContactCondition
from boltjoint.dynamics.reduction.hyper_reduction import weigh_pairs
from boltjoint.joint.partition import partition_regions
from boltjoint.joint.reductions import reduce_joint
from boltjoint.structure.makers.half_lap.mesh import build_assembly
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

ASSEMBLY = RESULTS / "assemblies/three_bolt"
CONFIG = RESULTS.parent / "config/assemblies/three_bolt.yaml"
CONTACT = {
    "law": "constant",
    "tangential_stiffness_N_per_m": 1e8,
    "friction_coefficient": 0.1,
}


def test_mesh(measure_once):
    assembly = LapJoint.model_validate(yaml.safe_load(CONFIG.read_text(encoding="utf-8")))
    measure_once(partial(build_assembly, assembly), kind="stage", stage="mesh")


@pytest.mark.parametrize("stage", ["preload", "free-4", "POD modes", "enriched-40"])
def test_structure(measure_once, stage):
    assembly = dataset.load(ASSEMBLY / "assembly.nc")
    if stage == "preload":
        work = partial(apply_preload, assembly, 10000.0)
    elif stage == "POD modes":
        condition = ContactCondition.of(CONTACT, LOSS_FACTOR)
        preload = dataset.load(ASSEMBLY / "preload=10000/preload.nc")
        work = partial(find_pod_modes, assembly, preload, [condition], ContactAdaptedBasis())
    else:
        pod_modes = dataset.load(ASSEMBLY / "pod_modes.nc")
        work = partial(find_modes, assembly, stage, pod_modes)
    measure_once(work, kind="stage", stage=stage)


@pytest.mark.parametrize("law", ["constant", "variable"])
def test_weights(measure_once, law):
    joint = joint_of(f"three_bolt_{law}", "enriched-40", "node-to-node")
    work = partial(weigh_pairs, joint, [1.0, 50.0], LOSS_FACTOR)
    measure_once(work, kind="stage", stage=f"weights of pairs, {law} load")


@pytest.mark.parametrize("reduction", ["elements=7", "harmonic=7", "iwan", "table"])
def test_reductions(measure_once, reduction):
    joint = joint_of("three_bolt_constant", "free-4", "node-to-node")
    regions = partition_regions(joint, dataset.load(ASSEMBLY / "preload=10000/preload.nc"), 6)
    name, _, count = reduction.partition("=")
    keys = {"count": int(count)} if count else {}
    measure_once(
        lambda: reduce_joint(regions, name, **keys), kind="stage", stage=f"regions=6/{reduction}"
    )
