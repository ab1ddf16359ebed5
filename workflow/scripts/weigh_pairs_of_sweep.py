"""Let a few contact pairs, with weights, stand for all in the designs of a sweep."""

import xarray as xr

from boltjoint import dataset
from boltjoint.config.varied_case import with_values
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset, save_joint
from boltjoint.provenance import logs
from boltjoint.solvers.step_control import StepControl
from boltjoint.study.weights_of_sweep import weigh_pairs_of_designs

logs.write_to(snakemake.log[0])
params = snakemake.params
stored = dataset.load(snakemake.input.joint)


def weigh() -> xr.Dataset:
    weighted, fit = weigh_pairs_of_designs(
        joint_from_dataset(stored),
        dataset.load(snakemake.input.designs),
        with_values(params.case, params.values),
        params.variants,
        control=StepControl(**params.steps),
        **params.accuracy,
    )
    return joint_to_dataset(weighted, stored, fit)


save_joint(weigh, snakemake.output.joint, params, of_sweep=True)
