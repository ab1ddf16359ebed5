"""Preload of each bolt as parameters of a calibration: which bolt is loose.

Normal loads and gaps of all contact pairs are those of one state of the bolts, and the change by
each bolt alone, interpolated over its preload. What several bolts change together is left out. It
is the smaller, the nearer that state is to the result, so that a fit is repeated around its result.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from boltjoint import checks
from boltjoint.calibration.calibration import Calibration
from boltjoint.calibration.fit import CalibrationOptions, fit
from boltjoint.calibration.measured_backbone import Measurement, curves_of
from boltjoint.calibration.model_curves import ModelCurves
from boltjoint.calibration.parameters import Parameter, ParameterSpace
from boltjoint.damping import Damping, as_damping
from boltjoint.joint.model import Joint
from boltjoint.structure.model import Structure
from boltjoint.structure.preload import apply_preload

Array = NDArray[np.float64]

#: preloads of a bolt over the full one at which the contact is solved, up to one that is tighter
LEVELS = (0.02, 0.1, 0.25, 0.5, 0.75, 1.0, 1.25)

#: preloads of one loose bolt over the full one, of states at which a fit may begin
_LOOSE = (0.05, 0.2, 0.5)

#: load, over the largest, of a pair that carries none but would at another preload: so all states
#: have the same elements
_LEAST_LOAD = 1e-9

#: distance, over the full preload, of two levels beside a state, by which slopes are right there
_NEAR = 0.02

#: distance of a start from the bounds, and of values beyond these that are still answered, over
#: their distance from each other
_INSIDE = 1e-3

#: change by a repeated fit, over the standard error, at which it is the last
_SETTLED = 0.2

_NAME = "preload_ratios"


class BoltPreloads:
    """A joint as a function of the preload of each bolt, a model for ``fit``.

    Parameters are ``preload_ratios[0]`` and so on: the preload of a bolt over the full one.

    Parameters
    ----------
    structure
        With its bolts.
    preload
        Tension of a tight bolt [N].
    connect
        The joint of a ``preload.nc``, in the same modes for all: ``partial(connect_nodes, modes,
        tangential_stiffness=...)``.
    damping
        Damping of the structure; a number is a loss factor.
    levels
        Ascending preloads of a bolt over the full one at which the contact is solved: bounds of
        what is fitted, and points between.
    around
        Preload of each bolt over the full one, within the levels: the state beside which others
        vary. By default all bolts are tight.

    Raises
    ------
    ValueError
        If the levels do not ascend or are not positive, there are not as many preloads as bolts, or
        one is beyond the levels; as for ``apply_preload``.
    RuntimeError
        As for ``apply_preload``.
    """

    def __init__(
        self,
        structure: Structure,
        preload: float,
        connect: Callable[[xr.Dataset], Joint],
        damping: Damping | float,
        levels: Sequence[float] = LEVELS,
        around: Sequence[float] | Array | None = None,
    ) -> None:
        checks.instance("structure", structure, Structure)
        self._structure, self._connect = structure, connect
        self._preload = checks.number("preload", preload, above=0)
        self._damping = as_damping(damping)
        self._levels = checks.ascending("levels", levels)
        if self._levels[0] <= 0:
            raise ValueError(f"levels are {self._levels}: all must be above 0")
        count = len(structure.bolts)
        state = np.ones(count) if around is None else around
        #: preload of each bolt over the full one, beside which others vary, shape (bolts,)
        self.state = checks.array("around", state, (count,))
        low, high = self._levels[[0, -1]]
        if np.any((self.state < low) | (self.state > high)):
            raise ValueError(f"around is {self.state}: it must lie within the levels")
        self._contact = apply_preload(structure, self._preload * self.state)
        self._loads = _loads_and_gaps(self._contact)
        solved = [self._solved(bolt) for bolt in range(count)]
        self._closed = np.any([np.any(loads[:, 0] > 0, axis=0) for _, loads in solved], axis=0)
        self._changes = [PchipInterpolator(ratios, loads - self._loads) for ratios, loads in solved]

    def _solved(self, bolt: int) -> tuple[Array, Array]:
        """Preloads of one bolt over the full one, and loads and gaps with each of them."""
        at = self.state[bolt]
        near = np.clip(at + np.array([-_NEAR, _NEAR]), *self._levels[[0, -1]])
        apart = abs(self._levels - at) > 2 * _NEAR
        apart[[0, -1]] = True
        ratios = np.union1d(self._levels[apart], [*near, at])
        loads = np.array([self._loads] * ratios.size)
        for place in np.flatnonzero(ratios != at):
            of_all = self.state.copy()
            of_all[bolt] = ratios[place]
            contact = apply_preload(self._structure, self._preload * of_all)
            loads[place] = _loads_and_gaps(contact)
        return ratios, loads

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters, in the order of the bolts."""
        return tuple(f"{_NAME}[{bolt}]" for bolt in range(len(self._changes)))

    def parameters(self) -> list[Parameter]:
        """The preload of each bolt within the levels, starting at the state of the model."""
        low, high = (float(level) for level in self._levels[[0, -1]])
        room = _INSIDE * (high - low)
        return [
            Parameter(
                name,
                low,
                high,
                logarithmic=False,
                start=float(np.clip(ratio, low + room, high - room)),
            )
            for name, ratio in zip(self.names, self.state, strict=True)
        ]

    def at_state(self, state: Sequence[float] | Array) -> "BoltPreloads":
        """The same model around another state; itself where it is its own.

        Raises
        ------
        ValueError, RuntimeError
            As for the model.
        """
        if np.array_equal(state, self.state):
            return self
        of_all = self._structure, self._preload, self._connect, self._damping
        return BoltPreloads(*of_all, levels=self._levels.tolist(), around=state)

    def __call__(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        """The joint with these preloads, all others as in the state of the model, and the damping.

        Raises
        ------
        ValueError
            If there is no such bolt, or a preload is beyond the levels.
        """
        low, high = self._levels[[0, -1]]
        # derivatives at a bound ask for values beyond it
        room = _INSIDE * (high - low)
        loads = self._loads.copy()
        for name, value in values.items():
            bolt = self.names.index(checks.choice("parameter", name, self.names))
            value = checks.number(name, value, at_least=low - room, at_most=high + room)
            loads += self._changes[bolt](value)
        load, gap = np.maximum(loads, 0.0)
        load[self._closed] = np.maximum(load[self._closed], _LEAST_LOAD * load.max())
        with_loads = self._contact.assign(
            normal_load=self._contact["normal_load"].copy(data=load),
            gap=self._contact["gap"].copy(data=gap),
        )
        return self._connect(with_loads), self._damping


def fit_preloads(
    model: BoltPreloads,
    measured: Sequence[Measurement] | Measurement,
    *,
    starts: int = 6,
    repetitions: int = 3,
    options: CalibrationOptions | None = None,
) -> Calibration:
    """Fit the preload of every bolt to measured backbones.

    There are several minima where bolts act alike. So it begins at states with all bolts tight or
    one loose, first at those that meet the curves best, until the model can be right.

    Parameters
    ----------
    model
        The joint by its preloads.
    measured
        One or several curves: of as many modes as tell the bolts apart, three of a half lap with
        four bolts.
    starts
        States at which it begins, at most.
    repetitions
        How often the fit is repeated around its result, at most: less where that changes no preload
        by more than a fifth of its standard error.
    options
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
    checks.instance("model", model, BoltPreloads)
    checks.whole("starts", starts, at_least=1)
    checks.whole("repetitions", repetitions, at_least=0)
    options = CalibrationOptions() if options is None else options
    options = replace(checks.instance("options", options, CalibrationOptions), starts=1)
    curves = curves_of(measured)
    ends: list[Calibration] = []
    for state in _states(model, curves)[:starts]:
        ends.append(_settled(model, curves, state, repetitions, options))
        if not ends[-1].refusals:
            break
    return min(ends, key=lambda end: float(end.costs.min()))


def _settled(
    model: BoltPreloads,
    curves: tuple[Measurement, ...],
    state: Array,
    repetitions: int,
    options: CalibrationOptions,
) -> Calibration:
    """The fit that begins at a state, repeated around its result."""
    model = model.at_state(state)
    found = fit(model, curves, model.parameters(), options=options)
    for _ in range(repetitions):
        last, model = found, model.at_state(found.scaled)
        found = fit(model, curves, model.parameters(), options=options)
        if np.all(abs(found.scaled - last.scaled) <= _SETTLED * found.standard_error):
            break
    return found


def _states(model: BoltPreloads, curves: tuple[Measurement, ...]) -> list[Array]:
    """The state of the model and those with one loose bolt, that which meets curves best first."""
    compared = ModelCurves(model, curves, ParameterSpace(tuple(model.parameters())))
    states = [model.state]
    for bolt, ratio in product(range(model.state.size), _LOOSE):
        states.append(model.state.copy())
        states[-1][bolt] = ratio

    def square(state: Array) -> float:
        try:
            residual = compared.residual(state)
        except ValueError:
            # a mode is not reached at an amplitude
            return np.inf
        return float(residual @ residual)

    return sorted(states, key=square)


def loosest_bolt(found: Calibration, count: int = 4000, seed: int = 1) -> dict[str, float]:
    """Probability of each bolt that its preload is the lowest, by the covariance of a calibration.

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
    places = [n for n, name in enumerate(found.names) if name.partition("[")[0] == _NAME]
    if not places:
        raise ValueError(f"no {_NAME} are among the parameters {', '.join(found.names)}")
    if found.refusals:
        raise ValueError(f"the model cannot be right: {found.refusals[0]}")
    _, jacobian = found.residual_and_jacobian
    if not jacobian[:, places].any():
        raise ValueError("the measurement does not depend on any preload: nothing slips in it")
    drawn = random.standard_normal((count, found.scaled.size)) @ found.covariance_root.T
    lowest = (found.scaled + drawn)[:, places].argmin(axis=1)
    shares = np.bincount(lowest, minlength=len(places)) / count
    return {found.names[n]: float(share) for n, share in zip(places, shares, strict=True)}


def _loads_and_gaps(preload: xr.Dataset) -> Array:
    """Normal loads [N] and gaps [m] of all pairs, shape (2, pairs)."""
    return np.array([preload["normal_load"].to_numpy(), preload["gap"].to_numpy()])
