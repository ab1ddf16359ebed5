"""Preload of each bolt as parameters of a calibration: which bolt is loose.

Normal loads and gaps of all contact pairs are those of one state of the bolts, and the change by
each bolt alone, interpolated over its preload. What several bolts change together is left out. It
is the smaller, the nearer that state is to the result, so that a fit is repeated around its result.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from boltjoint import checks
from boltjoint.calibration.parameters import Parameter
from boltjoint.damping import Damping, as_damping
from boltjoint.joint.model import Joint
from boltjoint.structure.model import Structure
from boltjoint.structure.preload import apply_preload

Array = NDArray[np.float64]

#: preloads of a bolt over the full one at which the contact is solved, up to one that is tighter
LEVELS = (0.02, 0.1, 0.25, 0.5, 0.75, 1.0, 1.25)

#: load, over the largest, of a pair that carries none but would at another preload: so all states
#: have the same elements
_LEAST_LOAD = 1e-9

#: distance, over the full preload, of two levels beside a state, by which slopes are right there
_NEAR = 0.02

#: distance of a start from the bounds, and of values beyond these that are still answered, over
#: their distance from each other
_INSIDE = 1e-3

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
        return [
            started(Parameter(name, low, high, logarithmic=False), ratio)
            for name, ratio in zip(self.names, self.state.tolist(), strict=True)
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


def _loads_and_gaps(preload: xr.Dataset) -> Array:
    """Normal loads [N] and gaps [m] of all pairs, shape (2, pairs)."""
    return np.array([preload["normal_load"].to_numpy(), preload["gap"].to_numpy()])


def bolt_of(name: str) -> int | None:
    """Place of the bolt of a parameter ``preload_ratios[N]``; None of others."""
    named = re.fullmatch(rf"{_NAME}\[(\d+)\]", name)
    return None if named is None else int(named[1])


def started(parameter: Parameter, value: float) -> Parameter:
    """A parameter that begins at a value, or as near to it as its bounds let it."""
    room = _INSIDE * (parameter.high - parameter.low)
    return replace(
        parameter, start=float(np.clip(value, parameter.low + room, parameter.high - room))
    )
