"""Preload of each bolt as parameters of a calibration: which bolt is loose.

Normal loads and gaps of all contact pairs are those of one state, and the change by each bolt
alone, interpolated over its preload. What two bolts do together beyond that is left out: less, the
nearer the state is to what is sought, so that a fit is repeated around its result.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from boltjoint import checks
from boltjoint.calibration.calibration import Calibration
from boltjoint.calibration.fit import CalibrationOptions, fit
from boltjoint.calibration.measured_backbone import MeasuredBackbone
from boltjoint.calibration.parameters import Parameter
from boltjoint.damping import Damping, as_damping
from boltjoint.joint.model import Joint
from boltjoint.structure.model import Structure
from boltjoint.structure.preload import apply_preload

Array = NDArray[np.float64]

#: preloads of a bolt over the full one at which the contact is solved, up to one that is tighter
LEVELS = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.25)

#: load of a pair that some preload closes, at least, over the largest: as none, but it has elements
_LEAST_LOAD = 1e-9

#: distance of preloads over the full one that tell the slope by them
_NEAR = 0.02

#: distance of a start from the bounds, over these
_INSIDE = 1e-3

#: change by a repeated fit, over the standard error, that counts no more
_SETTLED = 0.2

_NAME = "preload_ratios"


class BoltPreloads:
    """A joint by the preload of each bolt, a model for ``fit``.

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
        Ascending preloads of a bolt over the full one at which the contact is solved.
    around
        Preload of each bolt over the full one, beside which others vary; by default all are full.

    Raises
    ------
    ValueError
        If the levels do not ascend or reach below 0, or there are not as many preloads as bolts;
        as for ``apply_preload``.
    """

    def __init__(
        self,
        structure: Structure,
        preload: float,
        connect: Callable[[xr.Dataset], Joint],
        damping: Damping | float,
        levels: Sequence[float] = LEVELS,
        around: Sequence[float] | None = None,
    ) -> None:
        checks.instance("structure", structure, Structure)
        self._structure, self._connect = structure, connect
        self._preload = checks.number("preload", preload, above=0)
        self._damping = as_damping(damping)
        self._levels = checks.ascending("levels", levels)
        if self._levels[0] < 0:
            raise ValueError(f"levels are {self._levels}: none may be below 0")
        count = len(structure.bolts)
        ratios = checks.array("around", np.ones(count) if around is None else around, (count,))
        self._state = apply_preload(structure, self._preload * ratios)
        self._loads = _loads_and_gaps(self._state)
        self._closed = self._loads[0] > 0
        self._changes = [self._change_by(bolt, ratios) for bolt in range(count)]

    def _change_by(self, bolt: int, around: Array) -> PchipInterpolator:
        """Change of loads and gaps by the preload of one bolt over the full one."""
        # on both sides of the state too, so that slopes are right there
        near = np.clip(around[bolt] + np.array([-_NEAR, 0.0, _NEAR]), *self._levels[[0, -1]])
        apart = abs(self._levels - around[bolt]) > 2 * _NEAR
        apart[[0, -1]] = True
        ratios = np.union1d(self._levels[apart], near)
        states = []
        for ratio in ratios:
            of_all = around.copy()
            of_all[bolt] = ratio
            states.append(_loads_and_gaps(apply_preload(self._structure, self._preload * of_all)))
        self._closed |= np.any([loads > 0 for loads, _ in states], axis=0)
        return PchipInterpolator(ratios, np.array(states) - self._loads, extrapolate=False)

    def parameters(self, start: Mapping[str, float] = MappingProxyType({})) -> list[Parameter]:
        """The preloads over the full one within the levels, from starts inside; full by default."""
        low, high = (float(level) for level in self._levels[[0, -1]])
        room = _INSIDE * (high - low)
        return [
            Parameter(
                name,
                low,
                high,
                logarithmic=False,
                start=float(np.clip(start.get(name, 1.0), low + room, high - room)),
            )
            for name in self.names
        ]

    def around(self, found: Calibration) -> "BoltPreloads":
        """The same model around the preloads of a calibration.

        Raises
        ------
        ValueError
            As for the model.
        """
        ratios = [found.best_values.get(name, 1.0) for name in self.names]
        of_all = self._structure, self._preload, self._connect, self._damping
        return BoltPreloads(*of_all, levels=self._levels.tolist(), around=ratios)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters, in the order of the bolts."""
        return tuple(f"{_NAME}[{bolt}]" for bolt in range(len(self._changes)))

    def __call__(self, values: Mapping[str, float]) -> tuple[Joint, Damping]:
        """The joint with these preloads, all others as ``around``, and the damping.

        Raises
        ------
        ValueError
            If there is no such bolt, or a preload is beyond the levels.
        """
        low, high = self._levels[[0, -1]]
        loads = self._loads.copy()
        for name, value in values.items():
            bolt = self.names.index(checks.choice("parameter", name, self.names))
            loads += self._changes[bolt](checks.number(name, value, at_least=low, at_most=high))
        load, gap = np.maximum(loads, 0.0)
        load[self._closed] = np.maximum(load[self._closed], _LEAST_LOAD * load.max())
        with_loads = self._state.assign(
            normal_load=self._state["normal_load"].copy(data=load),
            gap=self._state["gap"].copy(data=gap),
        )
        return self._connect(with_loads), self._damping


def fit_preloads(
    model: BoltPreloads,
    measured: Sequence[MeasuredBackbone] | MeasuredBackbone,
    *,
    repetitions: int = 3,
    options: CalibrationOptions | None = None,
) -> Calibration:
    """Fit the preload of every bolt to measured backbones.

    Parameters
    ----------
    model
        The joint by its preloads.
    measured
        One or several curves: three modes tell the bolts of a half lap apart.
    repetitions
        How often the fit is repeated around its result, at most: less where that changes no preload
        by more than a fifth of its standard error.
    options
        Number of starts, tolerance; of the first fit. Its first start has all bolts tight.

    Returns
    -------
    Calibration
        Of the last fit.

    Raises
    ------
    ValueError
        As for ``fit``.
    """
    checks.instance("model", model, BoltPreloads)
    checks.whole("repetitions", repetitions, at_least=0)
    options = CalibrationOptions(starts=2) if options is None else options
    found = fit(model, measured, model.parameters(), options=options)
    for _ in range(repetitions):
        last, model = found, model.around(found)
        parameters = model.parameters(last.best_values)
        found = fit(model, measured, parameters, options=replace(options, starts=1))
        if np.all(abs(found.scaled - last.scaled) <= _SETTLED * found.standard_error):
            break
    return found


def loosest_bolt(found: Calibration, count: int = 4000, seed: int = 1) -> dict[str, float]:
    """Probability of each bolt that its preload is the lowest, by the covariance of a calibration.

    Preloads are drawn from the normal distribution of the parameters; those beyond the bounds are
    at these.

    Parameters
    ----------
    found
        As from ``fit_preloads``.
    count, seed
        Of the draws.

    Raises
    ------
    ValueError
        If no preload is among the parameters, or the measurement does not depend on any.
    """
    checks.instance("found", found, Calibration)
    count = checks.whole("count", count, at_least=1)
    random = np.random.default_rng(checks.whole("seed", seed, at_least=0))
    places = [n for n, name in enumerate(found.names) if name.partition("[")[0] == _NAME]
    if not places:
        raise ValueError(f"no {_NAME} are among the parameters {', '.join(found.names)}")
    _, jacobian = found.residual_and_jacobian
    if not jacobian[:, places].any():
        raise ValueError("the measurement does not depend on any preload: nothing slips in it")
    drawn = random.standard_normal((count, found.scaled.size)) @ found.covariance_root.T
    within = np.clip(found.scaled + drawn, *found.compared.space.bounds)
    shares = np.bincount(within[:, places].argmin(axis=1), minlength=len(places)) / count
    return {found.names[n]: float(share) for n, share in zip(places, shares, strict=True)}


def _loads_and_gaps(preload: xr.Dataset) -> Array:
    """Normal loads [N] and gaps [m] of all pairs, shape (2, pairs)."""
    return np.array([preload["normal_load"].to_numpy(), preload["gap"].to_numpy()])
