"""Residuals of a fit: curves of a model beside measured ones, and whether a model can be right.

References
----------
A. Wald, J. Wolfowitz: On a test whether two samples are from the same population. Annals of
Mathematical Statistics 11 (1940) 147-162.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from inspect import signature

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from boltjoint import checks
from boltjoint.calibration.backbone_points import SensedMode, neighbours_of, solve_points
from boltjoint.calibration.measured_backbone import MODAL, MeasuredBackbone
from boltjoint.calibration.parameters import ParameterSpace
from boltjoint.config.measured import AMPLITUDE_SCALE
from boltjoint.damping import Damping
from boltjoint.dynamics.backbone.epmc import EPMCEquations
from boltjoint.joint.model import Joint
from boltjoint.measurement.signals import MOTIONS

Array = NDArray[np.float64]

#: a model: joint and damping of its structure by values of the parameters
Model = Callable[[Mapping[str, float]], tuple[Joint, Damping]]

#: a mode whose frequency is off by more than this factor is not that of the measurement
_FARTHEST = 2.0


@dataclass(frozen=True)
class ModelCurves:
    """A model and the measured backbones it is compared with.

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
    measured: tuple[MeasuredBackbone, ...]
    space: ParameterSpace

    def __post_init__(self) -> None:
        """Refuse what cannot be fitted, before anything is solved."""
        if isinstance(self.model, type) or not callable(self.model):
            raise ValueError(f"model is {self.model!r:.100}: it must be a joint or a function")
        try:
            signature(self.model).bind({})
        except TypeError:
            raise ValueError("model must be a function of one argument, values by name") from None
        checks.sequence("measured", self.measured, MeasuredBackbone)
        checks.instance("space", self.space, ParameterSpace)
        names = [curve.name for curve in self.measured]
        if len(set(names)) < len(names):
            raise ValueError(f"measured curves must have names of their own: {', '.join(names)}")
        _ = self.resonances

    @cached_property
    def resonances(self) -> tuple[int, ...]:
        """Number of the mode of each curve: the nearest, at middle or ends of the bounds."""
        low, high = self.space.bounds
        joints = [self._joint(values)[0] for values in ((low + high) / 2, low, high)]
        joint = joints[0]
        ranges = np.array([other.resonance_range() for other in joints])
        lowest, highest = ranges[..., 0], ranges[..., 1]
        paired = []
        for curve in self.measured:
            frequency = float(np.median(curve.frequency))
            if curve.sensor is not None and curve.sensor not in joint.sensors.by_name:
                names = ", ".join(joint.sensors.by_name)
                raise ValueError(f"{curve.name}: sensor {curve.sensor} is none of {names}")
            if curve.resonance is not None and curve.resonance > joint.elastic_modes:
                raise ValueError(
                    f"{curve.name}: mode {curve.resonance} is not in the model, which has "
                    f"{joint.elastic_modes} elastic modes"
                )
            # distance of ln(frequency) from the range between open and sticking contact
            distance = np.maximum(np.log(lowest / frequency), np.log(frequency / highest))
            distance = np.maximum(distance, 0).min(axis=0)
            place = int(np.argmin(distance)) if curve.resonance is None else curve.resonance - 1
            if distance[place] > np.log(_FARTHEST):
                sought = "nearest" if curve.resonance is None else f"mode {curve.resonance}"
                raise ValueError(
                    f"{curve.name}: mode at {frequency:.4g} Hz is not in the model, whose {sought} "
                    f"is from {lowest[:, place].min():.4g} to {highest[:, place].max():.4g} Hz"
                )
            paired.append(place + 1)
        return tuple(paired)

    def residual_and_jacobian(self, scaled: Array) -> tuple[Array, Array]:
        """Model less measurement over the standard deviations, then the priors.

        Parameters
        ----------
        scaled
            Parameters in their scales.

        Returns
        -------
        residual : ndarray
            By curve the frequencies of its points, then their damping ratios, (values,).
        jacobian : ndarray
            Shape (values, parameters).

        Raises
        ------
        ValueError
            If the model refuses the values, or a mode is not reached at an amplitude.
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
            ((model - curve.values) / curve.deviations).T.ravel() for curve, model in pairs
        ]
        return np.concatenate([*of_curves, self.space.prior_residual(scaled)])

    def curves_at(
        self, scaled: Array, amplitudes: Sequence[Array] | None = None, *, slopes: bool = True
    ) -> list[tuple[Array, Array]]:
        """Frequency and damping of each curve, (points, 2), and derivatives by all parameters.

        Parameters
        ----------
        scaled
            Parameters in their scales.
        amplitudes
            As measured, of each curve; by default the measured ones.
        slopes
            Whether derivatives are computed; empty otherwise.
        """
        measured = [curve.amplitude for curve in self.measured]
        curves = []
        for n, levels in enumerate(measured if amplitudes is None else amplitudes):
            curve = self.measured[n]

            def mode_of(at: Array, n: int = n) -> SensedMode:
                return self._mode(at, n)

            factor, places = self._amplitude_scale(scaled, curve.name)
            near = neighbours_of(mode_of, scaled, self.space.bounds) if slopes else ()
            points = solve_points(mode_of(scaled), factor * levels, near)
            by_parameter = points.by_parameter.copy()
            for place, by_scaled in places if slopes else ():
                by_parameter[:, :, place] += points.by_amplitude * by_scaled
            curves.append((points.curves, by_parameter))
        return curves

    def _joint(self, scaled: Array) -> tuple[Joint, Damping]:
        values = self.space.values(scaled)
        own = {n: x for n, x in values.items() if n.partition("[")[0] != AMPLITUDE_SCALE}
        made = self.model(own)
        if not (isinstance(made, tuple) and len(made) == 2):
            raise ValueError("model must return a joint and the damping of its structure")
        checks.instance("joint of model", made[0], Joint)
        checks.instance("damping of model", made[1], Damping)
        return made

    def _mode(self, scaled: Array, n: int) -> SensedMode:
        joint, damping = self._joint(scaled)
        curve = self.measured[n]
        equations = EPMCEquations(joint, damping, self.resonances[n])
        if curve.quantity == MODAL:
            return SensedMode(equations, None, MODAL)
        row = joint.response_mode if curve.sensor is None else joint.sensors.by_name[curve.sensor]
        return SensedMode(equations, row, curve.quantity)

    def _amplitude_scale(self, scaled: Array, curve: str) -> tuple[float, list[tuple[int, float]]]:
        """Factor of the amplitudes of a curve, and its logarithm's derivative by parameters."""
        factor, places = 1.0, []
        for n, parameter in enumerate(self.space.parameters):
            if parameter.name in (AMPLITUDE_SCALE, f"{AMPLITUDE_SCALE}[{curve}]"):
                value = parameter.value(scaled[n])
                factor *= value
                places.append((n, 1.0 if parameter.logarithmic else 1 / value))
        return factor, places


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


#: probability below which a residual is no chance
_LEAST_PROBABILITY = 1e-3

#: standard deviations by which a curve must rise to be said to
_RISE = 4.0


@dataclass(frozen=True)
class CurveCheck:
    """What speaks against a model of one curve.

    Attributes
    ----------
    reduced_chi2
        Mean square of the residuals of frequency and damping, in standard deviations.
    size_probability
        Of residuals so large, if the stated deviations hold, of both.
    runs_probability
        Of so few changes of sign over the amplitude, of both.
    stiffens
        Whether the measured frequency rises with the amplitude, which friction cannot make.
    loses_damping
        Whether the measured damping falls faster than that of full slip, and that of the model not.
    sentences
        What speaks against it, in words.
    """

    name: str
    reduced_chi2: tuple[float, float]
    size_probability: tuple[float, float]
    runs_probability: tuple[float, float]
    stiffens: bool
    loses_damping: bool
    sentences: tuple[str, ...]


def check_curve(curve: MeasuredBackbone, model: Array) -> CurveCheck:
    """Compare the residuals of a curve with its stated scatter.

    Parameters
    ----------
    curve
        Measured.
    model
        Frequency [Hz] and damping ratio at its amplitudes, (points, 2).
    """
    of_frequency = (model[:, 0] - curve.frequency) / curve.frequency_deviation
    of_damping = (model[:, 1] - curve.damping_ratio) / curve.damping_deviation
    of_size = _size_probability(of_frequency), _size_probability(of_damping)
    of_runs = runs_probability(of_frequency), runs_probability(of_damping)
    mean_square = float(np.mean(of_frequency**2)), float(np.mean(of_damping**2))
    sentences = []
    for word, square, size, runs in zip(
        ("frequency", "damping"), mean_square, of_size, of_runs, strict=True
    ):
        if size < _LEAST_PROBABILITY:
            times = f"{float(f'{np.sqrt(square):.2g}'):g}"
            sentences.append(f"{curve.name}: the {word} is off by {times} times its stated scatter")
        if runs < _LEAST_PROBABILITY:
            sentences.append(
                f"{curve.name}: the {word} errs on one side over long ranges of the amplitude"
            )
    rise = stiffening(curve)
    if rise is not None:
        sentences.append(
            f"{curve.name}: the frequency rises by {rise[1]:.3g} Hz from the amplitude "
            f"{rise[0]:.3g} on; friction only softens a joint"
        )
    fall = losing_damping(curve, model)
    if fall is not None:
        sentences.append(
            f"{curve.name}: from the amplitude {fall[0]:.3g} on the damping falls by "
            f"{100 * fall[1]:.2g} % more than over the amplitude, as in full slip; that of the "
            "joint does not"
        )
    return CurveCheck(
        curve.name,
        mean_square,
        of_size,
        of_runs,
        rise is not None,
        fall is not None,
        tuple(sentences),
    )


def _size_probability(residual: Array) -> float:
    """Probability of residuals so large, in standard deviations."""
    return float(chi2.sf(residual @ residual, residual.size))


def runs_probability(residual: Array) -> float:
    """Probability of so few runs of one sign, by the test of Wald and Wolfowitz."""
    sign = residual > 0
    n, above = sign.size, int(sign.sum())
    below = n - above
    if n < 8:
        return 1.0
    if above == 0 or below == 0:
        return float(2.0 ** (1 - n))
    runs = 1 + int(np.count_nonzero(np.diff(sign)))
    mean = 1 + 2 * above * below / n
    variance = (mean - 1) * (mean - 2) / (n - 1)
    return float(norm.cdf((runs + 0.5 - mean) / np.sqrt(variance)))


def stiffening(curve: MeasuredBackbone) -> tuple[float, float] | None:
    """Amplitude from which the measured frequency rises, and by how much [Hz]; None if it falls."""
    f, deviation = curve.frequency, curve.deviations[:, 0]
    lowest = int(np.argmin(f))
    rise = f[-1] - f[lowest]
    if rise > _RISE * np.hypot(deviation[-1], deviation[lowest]):
        return float(curve.amplitude[lowest]), float(rise)
    return None


def losing_damping(curve: MeasuredBackbone, model: Array) -> tuple[float, float] | None:
    """Amplitude from which the damping falls faster than in full slip, and by how much of it.

    The work of a slider under constant normal load is a convex function of the amplitude, and so is
    that of many: over the amplitude, as ``zeta f**2 a`` of displacements, it never falls. None
    where it does not, or where that of the model does so too.

    Parameters
    ----------
    curve, model
        As for ``check_curve``.
    """
    a, (f, zeta) = curve.amplitude, curve.values.T
    # accelerations have the square of the frequency in them
    power = 2 - MOTIONS.get(curve.quantity, 0)
    measured, modelled = a * f**power * zeta, a * model[:, 0] ** power * model[:, 1]
    highest = int(np.argmax(measured))
    fall = 1 - measured[-1] / measured[highest]
    relative = curve.deviations[[highest, -1]] / curve.values[[highest, -1]]
    scatter = np.hypot(power * relative[:, 0], relative[:, 1])
    of_model = 1 - modelled[-1] / modelled[highest]
    if fall > _RISE * np.linalg.norm(scatter) and of_model < fall / 20:
        return float(a[highest]), float(fall)
    return None
