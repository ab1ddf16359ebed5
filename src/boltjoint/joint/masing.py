"""Loading curves and hysteresis loops of Jenkins elements in parallel (Masing)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks

#: what of the hysteresis is to agree
Method = Literal["loops", "describing-function"]


#: points along each loop at which forces are compared, evenly in phase over half a period
_SAMPLES = 64


#: amplitudes at which harmonics are compared, and at which loops are when a fit is judged
COMPARED_AMPLITUDES = 120


#: loss, over the total stiffness, below which the structure's own damping hides the contact's
HIDDEN_LOSS = 1e-3


@dataclass(frozen=True)
class Fit:
    """A few elements that stand for many.

    ``tangential_stiffness`` [N/m] and ``slip_force`` [N] have the shape (elements,), ``amplitude``
    [m] that of the loops of eq. 3.3; ``cost`` [N^2] is that equation, minimised or not.
    """

    tangential_stiffness: NDArray[np.float64]
    slip_force: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    cost: float


def loading_curve(
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Force of elements in parallel on first loading by ``displacement`` [N], of its shape."""
    displacement = checks.array("displacement", displacement)
    return force_on_loading_curve(
        displacement, *checked_elements("stiffness", stiffness, slip_force)
    )


def force_on_loading_curve(
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    stuck = np.multiply.outer(displacement, stiffness)
    return np.minimum(stuck, slip_force).sum(axis=-1)


def unloading_branch(
    amplitude: float,
    displacement: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Force on the way from ``amplitude`` down to ``displacement`` in the steady loop [N].

    Masing's rule: the branch is the loading curve, twice as large and turned around. The other half
    of the loop is the same with both signs changed.
    """
    amplitude = checks.number("amplitude", amplitude, above=0)
    displacement = checks.array(
        "displacement", displacement, at_least=-amplitude, at_most=amplitude
    )
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    top = force_on_loading_curve(np.array(amplitude), stiffness, slip_force)
    return top - 2 * force_on_loading_curve((amplitude - displacement) / 2, stiffness, slip_force)


def amplitude_of_load(
    fraction: float, stiffness: NDArray[np.float64], slip_force: NDArray[np.float64]
) -> float:
    """Displacement [m] at which first loading reaches a fraction of the total slip force."""
    fraction = checks.number("fraction", fraction, above=0, at_most=1)
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    corners = np.append(0.0, np.sort(slip_force / stiffness))
    load = force_on_loading_curve(corners, stiffness, slip_force)
    return float(np.interp(fraction * slip_force.sum(), load, corners))


@dataclass(frozen=True)
class LoopError:
    """Force differences between loops over the total slip force: largest, and root mean square."""

    largest: float
    rms: float


def loop_error(
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    fitted_stiffness: NDArray[np.float64],
    fitted_slip_force: NDArray[np.float64],
) -> LoopError:
    """How far the loops of fitted elements are from those of a region, at all amplitudes.

    Parameters
    ----------
    stiffness, slip_force
        Of the elements of a region [N/m], [N], shape (many,).
    fitted_stiffness, fitted_slip_force
        Of those that stand for them, with the same total slip force, shape (few,).

    Returns
    -------
    LoopError
        The largest of all loops, exact; and the mean over amplitudes from that of the first slip to
        that of full slip, evenly in their logarithm, and over the loop, evenly in phase.

    Raises
    ------
    ValueError
        If stiffnesses and slip forces differ in number or are not positive.
    """
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    fitted_stiffness, fitted_slip_force = checked_elements(
        "fitted_stiffness", fitted_stiffness, fitted_slip_force
    )
    onset = slip_force / stiffness
    corner = np.unique(np.concatenate([[0.0], onset, fitted_slip_force / fitted_stiffness]))
    few = force_on_loading_curve(corner, fitted_stiffness, fitted_slip_force)
    difference = (few - force_on_loading_curve(corner, stiffness, slip_force)) / slip_force.sum()
    # d(A) - 2 d(v) with v up to A (Masing) is linear in both between corners
    above = difference - 2 * np.minimum.accumulate(difference)
    below = 2 * np.maximum.accumulate(difference) - difference
    amplitude = np.geomspace(onset.min(), onset.max(), COMPARED_AMPLITUDES)
    phase = np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    half_drop = np.outer(amplitude, (1 - np.cos(phase)) / 2)
    top = np.interp(amplitude, corner, difference)[:, None]
    along = top - 2 * np.interp(half_drop, corner, difference)
    return LoopError(float(max(above.max(), below.max())), float(np.sqrt(np.mean(along**2))))


def checked_elements(
    name: str, stiffness: NDArray[np.float64], slip_force: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness, by its name, and slip force of at least one element."""
    stiffness = checks.array(name, stiffness, ("elements",), above=0)
    if not stiffness.size:
        raise ValueError(f"{name} is empty: there must be at least one element")
    slip_name = name.replace("stiffness", "slip_force")
    return stiffness, checks.array(slip_name, slip_force, stiffness.shape, above=0)


def check_fit_options(
    method: Method, load_fractions: Sequence[float], starts: int
) -> NDArray[np.float64]:
    """Refuse options of a fit; the fractions of the load as an array."""
    checks.choice("method", method, get_args(Method))
    checks.whole("starts", starts, at_least=1)
    return checks.array("load_fractions", load_fractions, ("loops",), above=0, at_most=1)
