"""Fit the joint of a case to its measurement."""

from boltjoint import dataset
from boltjoint.config.csv_table import read_file
from boltjoint.config.measured import Measured
from boltjoint.joint.io import load_joint
from boltjoint.provenance import logs
from boltjoint.study.calibrated_joint import bolts_of_case
from boltjoint.study.calibration_of_case import calibrate

logs.write_to(snakemake.log[0])
params = snakemake.params
joint, measured = load_joint(snakemake.input.joint), Measured.model_validate(params.measured)
texts = {file: read_file(file) for file in params.files}
bolts = bolts_of_case(snakemake.input.tightened, params.case, *params.bolts)
calibration = calibrate(joint, params.case, measured, texts, bolts)
dataset.save(calibration, snakemake.output[0], params)
