"""Frequency window of a resonance: from below its lowest to above its highest frequency."""

from dataclasses import dataclass

import numpy as np

from boltjoint import checks
from boltjoint.joint.model import Joint
from boltjoint.options import Options


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
        If there is no joint, the structure has fewer modes, or the resonance lies outside the
        given window from no to full slip.
    """
    if not joints:
        raise ValueError("joints is empty: a window is that of at least one joint")
    for joint in joints:
        checks.instance("joint", joint, Joint)
        joint.check_resonance(resonance)
    ranges = np.array([joint.resonance_range()[resonance - 1] for joint in joints])
    return window_around(
        float(ranges[:, 0].min()), float(ranges[:, 1].max()), resonance, given, margins
    )


def window_around(
    lowest: float,
    highest: float,
    resonance: int,
    given: tuple[float, float] | None = None,
    margins: WindowMargins = WindowMargins(),
) -> tuple[float, float]:
    """Frequency window of a resonance between two frequencies, as ``frequency_window``."""
    if given is None:
        return margins.below * lowest, margins.above * highest
    given = checks.interval("given", given)
    if given[1] < lowest or given[0] > highest:
        raise ValueError(
            f"the window from {given[0]:g} to {given[1]:g} Hz contains no resonance {resonance}: "
            f"it lies between {lowest:.5g} Hz without contact and {highest:.5g} Hz stuck"
        )
    return given
