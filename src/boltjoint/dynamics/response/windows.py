"""Frequency window of a resonance: from below its lowest to above its highest frequency."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.joint.model import Joint
from boltjoint.options import Options

Array = NDArray[np.float64]

#: error of the square of a frequency by rounding of the largest one, relative
_LARGEST_ROUNDING = 1e-3
#: stuck resonance over that without contact: joints raise it by some percent, and vectors that
#: cannot move without the contact by the root of its stiffness
_LARGEST_RATIO = 1e4
#: highest over lowest frequency of a window: steps are a part of the frequency
_WIDEST = 1e9


@dataclass(frozen=True)
class WindowMargins(Options):
    """Ends of a window, over the lowest and the highest frequency of a resonance.

    Where a case gives its own window they have no effect. Peaks do not depend on them, since no
    resonance leaves its range.

    Parameters
    ----------
    below, above
        Over the frequency without contact, and over that in stick: wide enough to show the
        flanks of a response, narrow enough to leave the next resonance out.
    """

    below: float = 0.85
    above: float = 1.05


@dataclass(frozen=True)
class Resonance:
    """A resonance that is followed, and the frequency window of its responses.

    Parameters
    ----------
    number
        Number of the resonance, from 1.
    window
        Lowest and highest frequency [Hz]; by default ``frequency_window``.

    Raises
    ------
    ValueError
        If there is no such number, or the window is none or ends at more than 1e9 times its begin.
    """

    number: int = 1
    window: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        """Refuse impossible values."""
        checks.whole("resonance", self.number, at_least=1)
        if self.window is not None:
            low, high = checks.interval("window", self.window)
            checks.number("lower end of the window", low, at_least=high / _WIDEST)
            object.__setattr__(self, "window", (low, high))

    def around(self, joint: Joint) -> tuple[float, float]:
        """Window of the responses of a joint [Hz]."""
        if self.window is None:
            return frequency_window(joint, resonance=self.number)
        return self.window


def frequency_window(
    *joints: Joint,
    resonance: int = 1,
    given: tuple[float, float] | None = None,
    margins: WindowMargins = WindowMargins(),
) -> tuple[float, float]:
    """Frequency window of a resonance: from below its frequency without contact to above stick.

    Parameters
    ----------
    *joints
        One joint, or several on the same structure: the window spans those of all.
    resonance
        Which natural frequency, counted from 1.
    given
        A window [Hz] to use instead, if the resonance can lie in it.
    margins
        Ends of the window, over the frequencies of the resonance.

    Returns
    -------
    tuple of float
        Lowest and highest frequency [Hz].

    Raises
    ------
    ValueError
        If there is no joint, the structure has fewer modes, the contact is so stiff that the
        resonance has no window, or it lies outside the given window from no to full slip.
    """
    if not joints:
        raise ValueError("joints is empty: a window is that of at least one joint")
    for joint in joints:
        checks.instance("joint", joint, Joint)
        joint.check_resonance(resonance)
    ranges = np.array([_range(joint, resonance) for joint in joints])
    return window_around(
        float(ranges[:, 0].min()), float(ranges[:, 1].max()), resonance, given, margins
    )


def _range(joint: Joint, resonance: int) -> Array:
    """The resonance of a joint without contact and while nothing slips [Hz].

    Raises
    ------
    ValueError
        If it is lost in rounding beside the stiffest motion, or in a window of many decades.
    """
    with np.errstate(invalid="ignore"):
        ranges = joint.resonance_range()
    frequencies, highest = ranges[resonance - 1], ranges[-1, 1]
    rounding = np.finfo(float).eps * (highest / frequencies[1]) ** 2
    if not (rounding < _LARGEST_ROUNDING and frequencies[1] < _LARGEST_RATIO * frequencies[0]):
        raise ValueError(
            f"the contact is too stiff: it raises resonance {resonance} from {frequencies[0]:.5g} "
            f"to {frequencies[1]:.3g} Hz, and the last one to {highest:.3g} Hz"
        )
    return frequencies


def window_around(
    lowest: float,
    highest: float,
    resonance: int,
    given: tuple[float, float] | None = None,
    margins: WindowMargins = WindowMargins(),
) -> tuple[float, float]:
    """Frequency window of a resonance between two frequencies, as ``frequency_window``."""
    checks.instance("margins", margins, WindowMargins)
    if given is None:
        return margins.below * lowest, margins.above * highest
    given = checks.interval("given", given)
    if given[1] < lowest or given[0] > highest:
        raise ValueError(
            f"the window from {given[0]:g} to {given[1]:g} Hz contains no resonance {resonance}: "
            f"it lies between {lowest:.5g} Hz without contact and {highest:.5g} Hz stuck"
        )
    return given
