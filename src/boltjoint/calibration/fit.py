"""Calibration: least squares of measured curves from several starts, with exact derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from boltjoint import checks
from boltjoint.calibration.calibration import Calibration
from boltjoint.calibration.measured_backbone import Measurement, curves_of
from boltjoint.calibration.model_curves import Evaluator, Model, ModelCurves
from boltjoint.calibration.parameters import JointParameters, Parameter, ParameterSpace
from boltjoint.config.measured import AMPLITUDE_SCALE, Loss
from boltjoint.damping import Damping
from boltjoint.joint.model import Joint
from boltjoint.options import Options

Array = NDArray[np.float64]

#: losses of ``scipy.optimize.least_squares``
LOSSES = get_args(Loss)


@dataclass(frozen=True)
class CalibrationOptions(Options):
    """Starts and ends of a calibration.

    Parameters
    ----------
    starts
        Points of a Sobol sequence within the bounds at which least squares begin: a fit of one
        joint may have several minima.
    seed
        Of the sequence.
    tolerance
        Relative change of the sum of squares, and of the parameters, at which a fit ends.
    maximum_evaluations
        Of each fit.
    robust_scale
        Residual [standard deviations] beyond which a robust loss counts it less.
    determined_share
        A parameter is determined where its 95 % interval is narrower than this share of its
        bounds; what is wider is what the bounds say.
    """

    starts: int = 8
    seed: int = 1
    tolerance: float = 1e-9
    maximum_evaluations: int = 200
    robust_scale: float = 3.0
    determined_share: float = 0.5


def fit(
    model: Joint | JointParameters | Model,
    measured: Sequence[Measurement] | Measurement,
    parameters: Sequence[Parameter],
    *,
    damping: Damping | float = 0.0,
    loss: str = "linear",
    options: CalibrationOptions | None = None,
) -> Calibration:
    """Fit parameters of a joint to measured backbones and responses.

    Parameters
    ----------
    model
        A joint, whose parameters are those of ``JointParameters``; or a function that takes values
        by name and returns a joint and the damping of its structure, in the same coordinates for
        all values (as ``joint.derived.rescale_contact`` does).
    measured
        One or several curves.
    parameters
        What is fitted.
    damping
        Of the structure of a joint; a number is a loss factor.
    loss
        ``linear``, or a robust one of ``scipy.optimize.least_squares``.
    options
        Number of starts, tolerance.

    Returns
    -------
    Calibration
        Parameters with their uncertainty, curves and bands, and why the model cannot be right.

    Raises
    ------
    ValueError
        If an argument is out of range, a mode is not in the model, there are fewer values than
        parameters, or the model cannot be solved at any start.
    """
    options = CalibrationOptions() if options is None else options
    checks.instance("options", options, CalibrationOptions)
    checks.choice("loss", loss, LOSSES)
    curves = curves_of(measured)
    if isinstance(model, Joint):
        model = JointParameters(model, damping)
    checks.sequence("parameters", parameters, Parameter)
    space = ParameterSpace(tuple(parameters))
    _require_values(curves, space)
    compared = ModelCurves(model, curves, space)
    ends = [
        _least_squares(compared, start, loss, options)
        for start in compared.space.starts(options.starts, options.seed)
    ]
    reached = [end for end in ends if end is not None]
    if not reached:
        raise ValueError(
            "the model cannot be solved at any start: bounds may reach where it has no mode"
        )
    best = min(reached, key=lambda end: end.cost)
    costs = np.array([np.inf if end is None else end.cost for end in ends])
    return Calibration(
        compared, best.x, costs, loss, options.robust_scale, options.determined_share
    )


def _require_values(curves: Sequence[Measurement], space: ParameterSpace) -> None:
    """Refuse parameters that the curves do not tell."""
    names = [curve.name for curve in curves]
    points = sum(curve.points for curve in curves)
    values = sum(curve.points * len(curve.quantities) for curve in curves)
    if values < len(space.names):
        raise ValueError(
            f"measured has {points} points, {values} values: "
            f"too few for {len(space.names)} parameters"
        )
    for name in space.names:
        scale, _, curve = name.partition("[")
        if scale == AMPLITUDE_SCALE and curve and curve.removesuffix("]") not in names:
            raise ValueError(f"parameter {name} is of no curve: there are {', '.join(names)}")


def _least_squares(
    compared: ModelCurves, start: Array, loss: str, options: CalibrationOptions
) -> OptimizeResult | None:
    """The fit from one start; None where the model cannot be solved there."""
    evaluator = Evaluator(compared)
    try:
        evaluator.at(start)
    except ValueError:
        return None
    return least_squares(
        evaluator.residual,
        start,
        jac=evaluator.jacobian,
        bounds=compared.space.bounds,
        x_scale="jac",
        loss=loss,
        f_scale=options.robust_scale,
        ftol=options.tolerance,
        xtol=options.tolerance,
        gtol=None,
        max_nfev=options.maximum_evaluations,
    )
