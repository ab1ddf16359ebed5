"""Tabulate the errors of forces by AFT."""

from boltjoint import dataset
from boltjoint.joint.io import load_joint
from boltjoint.study import convergence
from boltjoint.study.tables import files as tables
from boltjoint.workflow import logs

logs.write_to(snakemake.log[0])
joints = map(load_joint, snakemake.input.joints)
responses = map(dataset.load, snakemake.input.responses)
solved = zip(snakemake.params.cases, zip(joints, responses, strict=True), strict=True)
table = convergence.tabulate_sampling(dict(solved))
tables.write(
    table, snakemake.output.csv, snakemake.output.html, "Forces by AFT against the closed form"
)
