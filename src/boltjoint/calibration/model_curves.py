"""Curves of a model beside measured ones: residuals of a fit with their derivatives."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from inspect import signature

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.backbone_points import SensedMode, solve_points
from boltjoint.calibration.level_path import (
    LevelCurve,
    Neighbours,
    SensedBalance,
    neighbours_of,
)
from boltjoint.calibration.measured_backbone import MODAL, MeasuredBackbone, Measurement
from boltjoint.calibration.measured_response import MeasuredResponse
from boltjoint.calibration.mode_pairing import paired_mode
from boltjoint.calibration.parameters import ParameterSpace
from boltjoint.calibration.response_points import solve_motions
from boltjoint.config.measured import AMPLITUDE_SCALE
from boltjoint.damping import Damping
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]

#: a model: joint and damping of its structure by values of the parameters
Model = Callable[[Mapping[str, float]], tuple[Joint, Damping]]
#: the same by parameters in their scales, in the configuration of a curve
JointAt = Callable[[Array, Measurement], tuple[Joint, Damping]]


@dataclass(frozen=True)
class ModelCurves:
    """A model and the measured backbones and responses it is compared with.

    Parameters
    ----------
    model
        By values in the units of the parameters.
    measured
        The curves.
    space
        The parameters; ``amplitude_scale``, or ``amplitude_scale[name]`` of a curve, multiplies
        measured amplitudes and is not given to the model.

    Raises
    ------
    ValueError
        If a mode is not in the model, or a sensor not known.
    """

    model: Model
    measured: tuple[Measurement, ...]
    space: ParameterSpace

    def __post_init__(self) -> None:
        """Refuse what cannot be fitted, before anything is solved."""
        if isinstance(self.model, type) or not callable(self.model):
            raise ValueError(f"model is {self.model!r:.100}: it must be a joint or a function")
        try:
            signature(self.model).bind({})
        except TypeError:
            raise ValueError("model must be a function of one argument, values by name") from None
        checks.sequence("measured", self.measured, MeasuredBackbone, MeasuredResponse)
        checks.instance("space", self.space, ParameterSpace)
        names = [curve.name for curve in self.measured]
        if len(set(names)) < len(names):
            raise ValueError(f"measured curves must have names of their own: {', '.join(names)}")
        _ = self.resonances

    @cached_property
    def resonances(self) -> tuple[int | None, ...]:
        """Number of the mode of each backbone in the model; None of responses."""
        return tuple(self._paired(curve) for curve in self.measured)

    def _paired(self, curve: Measurement) -> int | None:
        """The mode of a curve, at middle or ends of the bounds; its sensors are of the model."""
        low, high = self.space.bounds
        at_bounds = ((low + high) / 2, low, high)
        joint, *others = (self._made(self._values(at, curve))[0] for at in at_bounds)
        for other in others:
            _refuse_other_sizes(joint, other)
        known = joint.sensors.by_name
        for sensor in curve.sensors:
            if sensor not in known:
                raise ValueError(f"{curve.name}: sensor {sensor} is none of {', '.join(known)}")
        if isinstance(curve, MeasuredResponse):
            return None
        return paired_mode(curve, (joint, *others))

    def residual_and_jacobian(self, scaled: Array) -> tuple[Array, Array]:
        """Model less measurement over the standard deviations, then the priors.

        Parameters
        ----------
        scaled
            Parameters in their scales.

        Returns
        -------
        residual : ndarray
            By curve the frequencies of its points, then their damping ratios; or the logarithms of
            its excitations, then phases, (values,).
        jacobian : ndarray
            Shape (values, parameters).

        Raises
        ------
        ValueError
            If the model refuses the values, or a motion is not found at an amplitude.
        """
        points = self.curves_at(scaled)
        jacobians = [
            (slopes / curve.deviations[:, :, None]).transpose(1, 0, 2).reshape(-1, scaled.size)
            for curve, (_, slopes) in zip(self.measured, points, strict=True)
        ]
        jacobian = np.concatenate([*jacobians, self.space.prior_jacobian()])
        return self._residual(scaled, [curves for curves, _ in points]), jacobian

    def residual(self, scaled: Array) -> Array:
        """The residual alone, as of ``residual_and_jacobian``."""
        points = self.curves_at(scaled, slopes=False)
        return self._residual(scaled, [curves for curves, _ in points])

    def _residual(self, scaled: Array, curves: Sequence[Array]) -> Array:
        pairs = zip(self.measured, curves, strict=True)
        of_curves = [
            (curve.difference(model) / curve.deviations).T.ravel() for curve, model in pairs
        ]
        return np.concatenate([*of_curves, self.space.prior_residual(scaled)])

    def curves_at(
        self, scaled: Array, amplitudes: Sequence[Array] | None = None, *, slopes: bool = True
    ) -> list[tuple[Array, Array]]:
        """Values of each curve, (points, quantities), and derivatives by all parameters.

        Those of a backbone are frequency [Hz] and damping ratio, those of a response as of
        ``MeasuredResponse.values``.

        Parameters
        ----------
        scaled
            Parameters in their scales.
        amplitudes
            As measured, of each curve; by default the measured ones. Those of responses mean
            nothing: theirs are at frequencies.
        slopes
            Whether derivatives are computed; empty otherwise.
        """
        curves, joint_at = [], self._once()
        for n, curve in enumerate(self.measured):
            is_backbone = isinstance(curve, MeasuredBackbone)
            given = amplitudes[n] if is_backbone and amplitudes is not None else curve.amplitude
            levels = np.asarray(given)
            factor, places = self._amplitude_scale(scaled, curve.name)
            solve = self._backbone if is_backbone else self._response
            solved = solve(joint_at, scaled, n, factor * levels, slopes)
            values, by_amplitude, by_parameter = solved
            for place, by_scaled in places if slopes else ():
                by_parameter[:, :, place] += by_amplitude * by_scaled
            curves.append((values, by_parameter))
        return curves

    def _backbone(
        self, joint_at: JointAt, scaled: Array, n: int, levels: Array, slopes: bool
    ) -> LevelCurve:
        """Frequency and damping of a mode at amplitudes, and derivatives."""
        curve = self.measured[n]
        joint, damping = joint_at(scaled, curve)
        equations = EPMCEquations(joint, damping, self.resonances[n] or 1)
        near = self._neighbours(joint_at, scaled, curve, 0.0) if slopes else ()
        mode = SensedMode(equations, _row(joint, curve), curve.quantity)
        return solve_points(mode, levels, near)

    def _response(
        self, joint_at: JointAt, scaled: Array, n: int, levels: Array, slopes: bool
    ) -> LevelCurve:
        """Logarithm of the excitation, and phase if it is compared, and derivatives."""
        curve = checks.instance("measured", self.measured[n], MeasuredResponse)
        balance = HarmonicBalance(*joint_at(scaled, curve), 1.0)
        row = _modes_at(balance.joint, curve.sensor)
        near = self._neighbours(joint_at, scaled, curve, 1.0) if slopes else ()
        solved = solve_motions(balance, row, curve.quantity, curve.frequency, levels, near)
        compared = slice(len(curve.quantities))
        return LevelCurve(*(values[:, compared] for values in solved))

    def _neighbours(
        self, joint_at: JointAt, scaled: Array, curve: Measurement, force: float
    ) -> list[Neighbours]:
        """Balances under a force on both sides of each parameter."""
        own, _ = joint_at(scaled, curve)

        def sensed_at(at: Array) -> SensedBalance:
            joint, damping = joint_at(at, curve)
            _refuse_other_sizes(own, joint)
            return SensedBalance(HarmonicBalance(joint, damping, force), _row(joint, curve))

        return neighbours_of(sensed_at, scaled, self.space.bounds)

    def _once(self) -> JointAt:
        """The model by parameters in their scales, made once for curves that have it in common.

        Parameters that are none of the joint leave it the same object.
        """
        made: dict[tuple[tuple[str, float], ...], tuple[Joint, Damping]] = {}

        def joint_at(scaled: Array, curve: Measurement) -> tuple[Joint, Damping]:
            values = self._values(scaled, curve)
            key = tuple(sorted(values.items()))
            if key not in made:
                made[key] = self._made(values)
            return made[key]

        return joint_at

    def _values(self, scaled: Array, curve: Measurement) -> dict[str, float]:
        """Fitted values of the model, in the configuration of a curve."""
        values = self.space.values(scaled)
        own = {n: x for n, x in values.items() if n.partition("[")[0] != AMPLITUDE_SCALE}
        return {**own, **curve.configuration}

    def _made(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        made = self.model(values)
        if not (isinstance(made, tuple) and len(made) == 2):
            raise ValueError("model must return a joint and the damping of its structure")
        checks.instance("joint of model", made[0], Joint)
        checks.instance("damping of model", made[1], Damping)
        return made

    def _amplitude_scale(self, scaled: Array, curve: str) -> tuple[float, list[tuple[int, float]]]:
        """Factor of the amplitudes of a curve, and its logarithm's derivative by parameters."""
        factor, places = 1.0, []
        for n, parameter in enumerate(self.space.parameters):
            if parameter.name in (AMPLITUDE_SCALE, f"{AMPLITUDE_SCALE}[{curve}]"):
                value = parameter.value(scaled[n])
                factor *= value
                places.append((n, 1.0 if parameter.logarithmic else 1 / value))
        return factor, places


def _row(joint: Joint, curve: Measurement) -> Array | None:
    """Modes at the sensor of a curve; None of a modal amplitude."""
    return None if curve.quantity == MODAL else _modes_at(joint, curve.sensor)


def _modes_at(joint: Joint, sensor: str | None) -> Array:
    """Modes at a sensor; at the output point by default."""
    return joint.response_mode if sensor is None else joint.sensors.by_name[sensor]


def _refuse_other_sizes(joint: Joint, other: Joint) -> None:
    """Refuse joints whose motions do not have the same unknowns."""
    sizes = [(each.natural_frequency.size, *each.law.components) for each in (joint, other)]
    if sizes[0] != sizes[1]:
        raise ValueError(
            "model must return joints of as many modes and harmonics whatever its parameters are"
        )


#: residual, in standard deviations, of a model that refuses its parameters
_REFUSED = 1e6


class Evaluator:
    """Residual and Jacobian at the same parameters, computed once, for least squares."""

    def __init__(self, compared: ModelCurves) -> None:
        self._compared = compared
        self._x: Array | None = None
        self._last: tuple[Array, Array] = np.zeros(0), np.zeros((0, 0))

    def at(self, x: Array) -> tuple[Array, Array]:
        """Both; a ``ValueError`` where the model refuses the parameters."""
        if self._x is None or not np.array_equal(x, self._x):
            self._last = self._compared.residual_and_jacobian(x)
            self._x = x.copy()
        return self._last

    def residual(self, x: Array) -> Array:
        """The residual, too large to be accepted where the model refuses the parameters."""
        try:
            return self.at(x)[0]
        except ValueError:
            # a step beyond where the model has a mode is rejected
            return np.full(self._last[0].size, _REFUSED)

    def jacobian(self, x: Array) -> Array:
        """Its Jacobian, of parameters that were accepted."""
        return self.at(x)[1]
