"""Predict measured backbones that were held aside from the fit of a case."""

from boltjoint import dataset
from boltjoint.config.csv_table import read_file
from boltjoint.config.measured import Measured
from boltjoint.joint.io import load_joint
from boltjoint.provenance import logs
from boltjoint.study.calibrated_joint import bolts_of_case
from boltjoint.study.prediction_of_case import predict

logs.write_to(snakemake.log[0])
params, files = snakemake.params, snakemake.input
joint, measured = load_joint(files.joint), Measured.model_validate(params.measured)
texts = {file: read_file(file) for file in params.files}
calibration = dataset.load(files.calibration)
bolts = bolts_of_case(files.tightened, params.case, *params.bolts)
prediction = predict(joint, params.case, measured, texts, calibration, bolts)
dataset.save(prediction, snakemake.output[0], params)
