"""The public assembly CD1: one Iwan element on one mode, from several starts."""

from pathlib import Path

import numpy as np
import pandas as pd

from boltjoint.calibration.fit import CalibrationOptions, fit
from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.calibration.parameters import Parameter
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint.model import Joint

TABLE = "resources/measured/four_bolt_and_three_bolt_assemblies_20Nm_backbones.csv"


def read_curve(configuration):
    table = pd.read_csv(Path(__file__).parents[2] / TABLE)
    columns = ["modal_amplitude", "frequency_Hz", "damping_ratio"]
    a, f, z = table[table["configuration"] == configuration][columns].to_numpy().T
    # 2 % of the range of the frequency
    deviations = 0.02 * np.ptp(f), 0.05 * z
    return MeasuredBackbone(a, f, deviations[0], z, deviations[1], quantity="modal", name="CD1")


def one_element(curve):
    """One mode with an Iwan element, and parameters whose bounds the measured curve tells.

    Friction makes the measured shift of the squared frequency, and up to ten times as much; all of
    it slips from a hundredth to ten times the largest amplitude on.
    """
    f, largest = curve.frequency, curve.amplitude.max()
    shift = (2 * np.pi) ** 2 * (f.max() ** 2 - f.min() ** 2)
    least = np.sqrt(f.max() ** 2 - 10 * shift / (2 * np.pi) ** 2)
    one, at = np.ones(1), np.zeros((1, 3))
    law = FourParameterIwan([0], [shift], [shift * largest], [-0.5], [1.0])
    joint = Joint(f.min() * one, one, one, one[:, None], at, law, at)
    return joint, (
        Parameter("natural_frequency[1]", least, f.min()),
        Parameter("tangential_stiffness", shift, 10 * shift),
        Parameter("slip_force", 0.01 * shift * largest, 10 * shift * largest),
        Parameter("chi", -0.99, 0, logarithmic=False),
        Parameter("beta", 0.01, 100),
        Parameter("loss_factor", 1e-5, 2 * curve.damping_ratio.min()),
    )


def test_one_element_meets_frequency_and_damping_at_once_from_most_starts():
    curve = read_curve("CD1")
    joint, parameters = one_element(curve)
    found = fit(joint, curve, parameters, options=CalibrationOptions(starts=8))
    ((of_frequency, of_damping),) = found.rms_errors
    # 0.0166 % and 4.1 % of least squares with differences; 0.02 % and 5 % are asked of 5 starts
    assert of_frequency < 2e-4
    assert of_damping < 0.05
    assert np.count_nonzero(found.costs < 1.01 * found.costs.min()) >= 5
    # the largest amplitude is beyond the knee, so that nothing is left open
    assert found.undetermined == ()
