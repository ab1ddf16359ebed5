"""Let a few contact pairs, with weights, stand for all."""

import xarray as xr

from boltjoint import dataset
from boltjoint.dynamics.reduction.hyper_reduction import weigh_pairs
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset, save_joint
from boltjoint.provenance import logs
from boltjoint.solvers.step_control import StepControl

logs.write_to(snakemake.log[0])
params = snakemake.params
stored, problem = dataset.load(snakemake.input.joint), params.problem


def weigh() -> xr.Dataset:
    weighted, fit = weigh_pairs(
        joint_from_dataset(stored),
        problem["forces"],
        problem["damping"],
        windows=problem["windows"],
        control=StepControl(**problem["steps"]),
        **params.accuracy,
    )
    return joint_to_dataset(weighted, stored, fit)


save_joint(weigh, snakemake.output.joint, params)
