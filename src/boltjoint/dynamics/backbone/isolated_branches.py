"""Isolated branches of the response (isolas), by the excitation along a backbone.

A response to the excitation F reaches those amplitudes a of the backbone whose peak needs no more,
``F(a) <= F``: they are one interval where F(a) rises. Where it falls and rises again, an excitation
between the lowest and the highest there has several: the first belongs to the branch that
continuation from low frequencies follows, each further one to a closed branch of its own.

References
----------
R. J. Kuether, L. Renson, T. Detroux, C. Grappasonni, G. Kerschen, M. S. Allen: Nonlinear normal
modes, modal interactions and isolated resonance curves. Journal of Sound and Vibration 351 (2015)
299-310.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

#: a smaller relative fall of the excitation between states is within the tolerance of their modes
_ROUNDING = 1e-6


class IsolatedBranches(NamedTuple):
    """Excitations with isolated branches, shape (ranges,).

    Between ``lowest`` and ``highest`` there is one or more; they appear at the state ``first``.
    """

    lowest: NDArray[np.float64]
    highest: NDArray[np.float64]
    first: NDArray[np.int64]

    def variables(
        self, amplitude: NDArray[np.float64], unit: str
    ) -> tuple[tuple[str, str, NDArray[np.float64], str, str], ...]:
        """Variables of ``backbone.nc`` by the response amplitude of its states [m]."""
        at = amplitude[self.first]
        return (
            ("isolated_from", "isola", self.lowest, unit, "lowest excitation with isolated branch"),
            ("isolated_to", "isola", self.highest, unit, "highest excitation with that branch"),
            ("isolated_amplitude", "isola", at, "m", "response_amplitude where the branch appears"),
        )


def find_isolated_branches(force: NDArray[np.float64]) -> IsolatedBranches:
    """Excitations that reach several intervals of amplitudes of a backbone.

    Parameters
    ----------
    force
        Excitation whose response has its peak at each state, in the order of rising amplitude,
        shape (states,).

    Raises
    ------
    ValueError
        If an excitation is not finite.
    """
    force = checks.array("force", force, ("states",))
    highest = np.maximum.accumulate(force)
    below = force < highest * (1 - _ROUNDING)
    edges = np.flatnonzero(np.diff(below, prepend=False, append=False))
    runs = edges.reshape(-1, 2)
    first = np.array([begin + np.argmin(force[begin:end]) for begin, end in runs], dtype=np.int64)
    return IsolatedBranches(force[first], highest[first], first)
