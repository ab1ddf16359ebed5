"""Turning points of a response over frequency, and what a slow sweep shows of it.

Where a branch folds, several solutions belong to one frequency. A sweep follows the branch while
its frequency moves on, and at a turning point jumps to where the branch next passes that frequency
in the sense of the sweep: it shows the solutions whose frequency is the highest so far. That is a
convention: where several stable solutions lie beyond the jump, the motion before it decides which
one is reached. Which solutions are stable is found in ``dynamics.response.stability``.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

#: a smaller relative change of the frequency between two solutions is rounding
_ROUNDING = 1e-12


class Folds(NamedTuple):
    """Turning points of a branch, and which of its solutions sweeps show.

    ``at``: solutions at which it turns, shape (turning points,); ``frequency_range``: lowest and
    highest frequency [Hz] between which there are several solutions, NaN where the branch does not
    fold; ``on_sweep_up``, ``on_sweep_down``: shape (solutions,).
    """

    at: NDArray[np.int64]
    frequency_range: tuple[float, float]
    on_sweep_up: NDArray[np.bool_]
    on_sweep_down: NDArray[np.bool_]

    @property
    def turning_points(self) -> int:
        """How many there are."""
        return self.at.size


def find_folds(frequency: NDArray[np.float64], complete: bool = True) -> Folds:
    """Folds of a branch by the frequencies along it.

    Parameters
    ----------
    frequency
        Frequencies of the solutions in the order of the branch [Hz], shape (solutions,); the branch
        runs from low to high.
    complete
        Whether it does to the end. Else a sweep down, which would begin beyond, shows none of it.

    Raises
    ------
    ValueError
        If a frequency is not finite.
    """
    frequency = checks.array("frequency", frequency, ("solutions",))
    complete = checks.flag("complete", complete)
    change = np.diff(frequency)
    moving = np.flatnonzero(np.abs(change) > _ROUNDING * np.abs(frequency[:-1]))
    direction = np.sign(change[moving])
    at = moving[1:][direction[1:] != direction[:-1]]
    backward = np.flatnonzero(change < -_ROUNDING * np.abs(frequency[:-1]))
    folded = np.nan, np.nan
    if backward.size:
        folded = float(frequency[backward + 1].min()), float(frequency[backward].max())
    tolerance = _ROUNDING * np.abs(frequency)
    on_sweep_down = frequency <= np.minimum.accumulate(frequency[::-1])[::-1] + tolerance
    return Folds(
        at,
        folded,
        on_sweep_up=frequency >= np.maximum.accumulate(frequency) - tolerance,
        on_sweep_down=on_sweep_down & complete,
    )
