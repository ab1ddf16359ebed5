"""Frequency window of a resonance: from below its lowest to above its highest frequency."""

import numpy as np

from boltjoint import checks
from boltjoint.joint.model import Joint


def frequency_window(
    *joints: Joint, resonance: int = 1, given: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Frequency window of a resonance: from 0.85 of the contact-free to 1.05 of the stuck one.

    Parameters
    ----------
    *joints
        One joint, or several on the same structure: the window spans those of all.
    resonance
        Which natural frequency, counted from 1.
    given
        A window [Hz] to use instead, if the resonance can lie in it.

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
    return window_around(float(ranges[:, 0].min()), float(ranges[:, 1].max()), resonance, given)


def window_around(
    lowest: float, highest: float, resonance: int, given: tuple[float, float] | None = None
) -> tuple[float, float]:
    """Frequency window of a resonance between two frequencies, as ``frequency_window``."""
    if given is None:
        return 0.85 * lowest, 1.05 * highest
    given = checks.interval("given", given)
    if given[1] < lowest or given[0] > highest:
        raise ValueError(
            f"the window from {given[0]:g} to {given[1]:g} Hz contains no resonance {resonance}: "
            f"it lies between {lowest:.5g} Hz without contact and {highest:.5g} Hz stuck"
        )
    return given
