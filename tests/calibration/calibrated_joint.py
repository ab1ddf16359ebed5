"""A small joint with Iwan elements, and backbones that it has under noise."""

from functools import cache

import numpy as np

from boltjoint.calibration.fit import CalibrationOptions
from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import JointParameters, Parameter, ParameterSpace
from boltjoint.dynamics.backbone.backbone_at import backbone_at
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint.model import Joint

ELEMENTS = 6
PARAMETERS = (
    Parameter("tangential_stiffness", 2e5, 2e7),
    Parameter("slip_force", 3.0, 400.0),
    Parameter("chi", -0.95, -0.02, logarithmic=False),
    Parameter("loss_factor", 1e-4, 2e-2),
)
TRUTH = {"tangential_stiffness": 2e6, "slip_force": 36.0, "chi": -0.5, "loss_factor": 0.004}
#: microslip to macroslip of mode 1, of the output point [m]
AMPLITUDES = np.geomspace(1e-6, 2e-4, 20)
FAST = CalibrationOptions(starts=2)


def make_joint():
    x = np.linspace(0.0, 0.1, ELEMENTS)
    rows = np.column_stack([0.3 + 2 * x, -0.2 + 4 * x, 0.3 * np.sin(60 * x)])
    position = np.column_stack([x, 0 * x, 0 * x])
    at = np.array([2.0, -1.9, 1.8])
    each = np.ones(ELEMENTS)
    law = FourParameterIwan(
        np.arange(ELEMENTS), each, np.linspace(2.0, 10.0, ELEMENTS), -0.5 * each, each
    )
    return Joint(np.array([70.0, 360.0, 950.0]), at, at, rows, position, law, position)


MODEL = JointParameters(make_joint(), 0.002)


def curve_of(curves, amplitudes, noise=0.0, seed=0, **given):
    """A measured curve with relative noise, a tenth of it in the frequency."""
    random = np.random.default_rng(seed)
    deviation = np.array([0.1, 1.0]) * (noise or 0.01)
    values = curves * (1 + bool(noise) * deviation * random.standard_normal(curves.shape))
    f, z = (deviation * curves).T
    return MeasuredBackbone(amplitudes, values[:, 0], f, values[:, 1], z, **given)


def backbones_of(joint, damping, amplitudes, noise=0.0, seed=0):
    """Measured curves of the modes of a joint, by their numbers and amplitudes."""
    random = np.random.default_rng(seed)
    return [
        curve_of(
            np.column_stack(backbone_at(joint, levels, damping=damping, resonance=number)),
            levels,
            noise,
            random,
            resonance=number,
            name=f"mode {number}",
        )
        for number, levels in amplitudes.items()
    ]


@cache
def true_curves(resonance=1, quantity="displacement"):
    amplitudes = AMPLITUDES * (2 * np.pi * 100.0) ** (2 * (quantity == "acceleration"))
    any_curve = curve_of(
        np.tile([(110.0, 365.0)[resonance - 1], 0.01], (AMPLITUDES.size, 1)),
        amplitudes,
        resonance=resonance,
        quantity=quantity,
    )
    space = ParameterSpace(PARAMETERS)
    compared = ModelCurves(MODEL, (any_curve,), space)
    curves, _ = compared.curves_at(space.scaled(list(TRUTH.values())), slopes=False)[0]
    return curves, amplitudes


def synthetic(seed=None, **given):
    curves, amplitudes = true_curves(**given)
    return curve_of(curves, amplitudes, 0.01 if seed is not None else 0.0, seed or 0, **given)
