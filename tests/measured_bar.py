"""The small joint as a case with a measured backbone, and what is simulated of it."""

from functools import cache

import numpy as np
from small_joint import make_joint

from boltjoint import backbone_at
from boltjoint.config.case import Case
from boltjoint.config.conflicts_of_measured import calibrated_content
from boltjoint.config.measured import Measured
from boltjoint.study.calibrated_joint import CalibratedJoint
from boltjoint.study.calibration_of_case import calibrate
from boltjoint.study.prediction_of_case import predict

FILE = "config/bar.csv"
FRICTION, STIFFNESS = "contact.friction_coefficient", "contact.tangential_stiffness_N_per_m"
CASE = {
    "description": "A bar",
    "assembly": "bar",
    "preload_N": 1000,
    "contact": {
        "law": "constant",
        "tangential_stiffness_N_per_m": 5e6,
        "friction_coefficient": 0.1,
    },
    "forces_N": [1],
    "modes": ["free-3"],
    "coordinates": ["linear"],
    "solve": [{"resonance": 1, "joints": ["node-to-node"]}],
}
MEASURED = {
    "curves": [
        {
            "file": FILE,
            "resonance": 1,
            "frequency_error_percent": 0.02,
            "damping_error_percent": 1,
        }
    ],
    "parameters": {
        FRICTION: {"low": 0.02, "high": 0.5},
        STIFFNESS: {"low": 1e6, "high": 1e8},
        "loss_factor": {"low": 1e-4, "high": 0.02},
    },
    "starts": 2,
}
#: of the second mode, which is held aside
SECOND = MEASURED["curves"][0] | {"file": "config/second.csv", "resonance": 2}
TRUTH = {FRICTION: 0.25, STIFFNESS: 8e6, "loss_factor": 0.004}
AMPLITUDES = np.geomspace(1e-6, 2e-4, 20)
OF_SECOND = AMPLITUDES / 20


def case_with(**changes):
    return CASE | {"measured": MEASURED | changes}


def content_of(case):
    return calibrated_content(Case.model_validate(case))


MODEL = CalibratedJoint(make_joint(), content_of(case_with()))


def written(curves, seed=None, amplitudes=AMPLITUDES):
    """The file of a backbone, with noise of the stated scatter."""
    noise = np.zeros((2, AMPLITUDES.size))
    if seed is not None:
        noise = np.random.default_rng(seed).standard_normal(noise.shape) * [[2e-4], [0.01]]
    f, z = np.array(curves) * (1 + noise)
    rows = [f"{1e3 * a},{x},{y}" for a, x, y in zip(amplitudes, f, z, strict=True)]
    return "\n".join(["displacement_mm,frequency_Hz,damping_ratio", *rows]) + "\n"


def backbone(values, resonance=1, amplitudes=AMPLITUDES):
    joint, damping = MODEL(values)
    return backbone_at(joint, amplitudes, resonance=resonance, damping=damping)


def fitted(case, text):
    """The calibration of a case by the text of its file."""
    measured = Measured.model_validate(case["measured"])
    return calibrate(make_joint(), content_of(case), measured, {FILE: text})


@cache
def calibration_of_truth():
    """The case fitted to its own backbone with other parameters, under noise."""
    return fitted(case_with(), written(backbone(TRUTH), seed=3))


def predicted(case, calibration, text):
    """The prediction of a case by the text of the file of its second mode."""
    measured = Measured.model_validate(case["measured"])
    texts = {SECOND["file"]: text}
    return predict(make_joint(), content_of(case), measured, texts, calibration)


@cache
def prediction_of_truth():
    """The second mode, by the fit of the first."""
    text = written(backbone(TRUTH, 2, OF_SECOND), seed=5, amplitudes=OF_SECOND)
    return predicted(case_with(predicted=[SECOND]), calibration_of_truth(), text)
