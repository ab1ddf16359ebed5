"""Fits of preloads of bolts, and which bolt is loose by their result.

What several bolts change together is the better known, the nearer the state of a model is to the
result: so a fit is repeated around its result.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.calibration.bolt_preloads import BoltPreloads, bolt_of, started
from boltjoint.calibration.calibration import Calibration
from boltjoint.calibration.fit import CalibrationOptions, fit
from boltjoint.calibration.measured_backbone import Measurement, curves_of
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import Parameter, ParameterSpace
from boltjoint.damping import Damping
from boltjoint.joint.model import Joint

Array = NDArray[np.float64]

#: preloads of one loose bolt over the full one, of states at which a fit may begin
_LOOSE = (0.05, 0.2, 0.5)

#: how often a fit is repeated around its result, at most
REPETITIONS = 3

#: change by a repeated fit, over the standard error, at which it is the last
_SETTLED = 0.2


class ModelOfBolts(Protocol):
    """A joint as a function of preloads of bolts, and of other parameters if it has any."""

    @property
    def state(self) -> Array:
        """Preload of each bolt over the full one, beside which others vary, shape (bolts,)."""
        ...

    def at_state(self, state: Sequence[float] | Array) -> "ModelOfBolts":
        """The same model around another state."""
        ...

    def __call__(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        """The joint and the damping of its structure with these values."""
        ...


def fit_preloads(
    model: ModelOfBolts,
    measured: Sequence[Measurement] | Measurement,
    parameters: Sequence[Parameter] | None = None,
    *,
    starts: int = 6,
    repetitions: int = REPETITIONS,
    loss: str = "linear",
    options: CalibrationOptions | None = None,
) -> Calibration:
    """Fit preloads of bolts, and other parameters beside them, to measured curves.

    There are several minima where bolts act alike. So it begins at states with all bolts tight or
    one loose, first at those that meet the curves best, until the model can be right.

    Parameters
    ----------
    model
        The joint by its preloads, ``BoltPreloads`` or another one around a state of the bolts.
    measured
        One or several curves: of as many modes as tell the bolts apart, three of a half lap with
        four bolts.
    parameters
        What is fitted: preloads by their names, and others with starts; by default the preload of
        each bolt within the levels of ``BoltPreloads``.
    starts
        States at which it begins, at most.
    repetitions
        How often the fit is repeated around its result, at most: less where that changes no preload
        by more than a fifth of its standard error.
    loss, options
        Of each fit, which has one start.

    Returns
    -------
    Calibration
        That with the least sum of squares.

    Raises
    ------
    ValueError
        As for ``fit``.
    RuntimeError
        As for ``apply_preload``.
    """
    if parameters is None:
        parameters = checks.instance("model", model, BoltPreloads).parameters()
    checks.sequence("parameters", parameters, Parameter)
    checks.whole("starts", starts, at_least=1)
    checks.whole("repetitions", repetitions, at_least=0)
    options = CalibrationOptions() if options is None else options
    options = replace(checks.instance("options", options, CalibrationOptions), starts=1)
    curves, fitted = curves_of(measured), _Preloads(tuple(parameters))
    ends: list[Calibration] = []
    refused = ValueError("the model cannot be solved at any state of its bolts")
    for state in _states(model, curves, fitted)[:starts]:
        begun = model.at_state(state), curves, fitted.at(state)
        try:
            ends.append(_settled(*begun, repetitions, loss, options))
        except ValueError as error:
            # no mode at the amplitudes: other states may have one
            refused = error
            continue
        if not ends[-1].refusals:
            break
    if not ends:
        raise refused
    return min(ends, key=lambda end: float(end.costs.min()))


@dataclass(frozen=True)
class _Preloads:
    """Parameters of which some are preloads of bolts."""

    parameters: tuple[Parameter, ...]

    @cached_property
    def bolts(self) -> dict[int, int]:
        """Bolts by the places of their parameters."""
        named = ((n, bolt_of(p.name)) for n, p in enumerate(self.parameters))
        return {n: bolt for n, bolt in named if bolt is not None}

    def at(self, state: Array) -> "_Preloads":
        """The same, of which fits begin at a state of the bolts."""
        begun = list(self.parameters)
        for n, bolt in self.bolts.items():
            begun[n] = started(begun[n], float(state[bolt]))
        return _Preloads(tuple(begun))

    def after(self, found: Calibration) -> "_Preloads":
        """The same, of which a fit begins where another ended."""
        pairs = zip(self.parameters, found.best_values.values(), strict=True)
        return _Preloads(tuple(started(parameter, value) for parameter, value in pairs))

    def state(self, before: Array, scaled: Array) -> Array:
        """The state of the bolts with parameters in their scales."""
        state = before.copy()
        for n, bolt in self.bolts.items():
            state[bolt] = self.parameters[n].value(scaled[n])
        return state


def _settled(
    model: ModelOfBolts,
    curves: tuple[Measurement, ...],
    fitted: _Preloads,
    repetitions: int,
    loss: str,
    options: CalibrationOptions,
) -> Calibration:
    """The fit that begins at the state of a model, repeated around its result."""
    found = fit(model, curves, fitted.parameters, loss=loss, options=options)
    preloads = list(fitted.bolts)
    for _ in range(repetitions):
        last, model = found, model.at_state(fitted.state(model.state, found.scaled))
        again = fitted.after(found).parameters
        try:
            found = fit(model, curves, again, loss=loss, options=options)
        except ValueError:
            # around its own result the model does not reach an amplitude: that before is kept
            break
        change = abs(found.scaled - last.scaled)[preloads]
        if np.all(change <= _SETTLED * found.standard_error[preloads]):
            break
    return found


def _states(model: ModelOfBolts, curves: tuple[Measurement, ...], fitted: _Preloads) -> list[Array]:
    """The state of the model and those with one loose bolt, that which meets curves best first."""
    compared = ModelCurves(model, curves, ParameterSpace(fitted.parameters))
    states = [model.state]
    for (n, bolt), ratio in product(fitted.bolts.items(), _LOOSE):
        if fitted.parameters[n].low <= ratio <= fitted.parameters[n].high:
            states.append(model.state.copy())
            states[-1][bolt] = ratio

    def square(state: Array) -> float:
        try:
            residual = compared.residual(
                ParameterSpace(fitted.at(state).parameters).starts(1, 1)[0]
            )
        except ValueError:
            # a mode is not reached at an amplitude
            return np.inf
        return float(residual @ residual)

    return sorted(states, key=square)


def loosest_bolt(found: Calibration, count: int = 4000, seed: int = 1) -> dict[str, float]:
    """Probability of each fitted preload to be the lowest, by the covariance of a calibration.

    Parameters
    ----------
    found
        As from ``fit_preloads``.
    count, seed
        Of draws from the normal distribution of the parameters.

    Returns
    -------
    dict
        By the names of the parameters; 1 in all.

    Raises
    ------
    ValueError
        If no preload is among the parameters, the measurement does not depend on any, or the model
        cannot be right (``Calibration.refusals``): probabilities would mean nothing then.
    """
    checks.instance("found", found, Calibration)
    count = checks.whole("count", count, at_least=1)
    random = np.random.default_rng(checks.whole("seed", seed, at_least=0))
    places = [n for n, name in enumerate(found.names) if bolt_of(name) is not None]
    if not places:
        raise ValueError(f"no preload_ratios are among the parameters {', '.join(found.names)}")
    if found.refusals:
        raise ValueError(f"the model cannot be right: {found.refusals[0]}")
    residual, jacobian = found.residual_and_jacobian
    space = found.compared.space
    # priors know of preloads without a measurement
    measured = residual.size - space.prior_residual(found.scaled).size
    if not jacobian[:measured, places].any():
        raise ValueError("the measurement does not depend on any preload: nothing slips in it")
    drawn = random.standard_normal((count, found.scaled.size)) @ found.covariance_root.T
    preloads = (found.scaled + drawn)[:, places]
    for column, n in zip(preloads.T, places, strict=True):
        # of a logarithm, whatever the scale of others
        column[:] = np.exp(column) if space.parameters[n].logarithmic else column
    lowest = preloads.argmin(axis=1)
    shares = np.bincount(lowest, minlength=len(places)) / count
    return {found.names[n]: float(share) for n, share in zip(places, shares, strict=True)}
