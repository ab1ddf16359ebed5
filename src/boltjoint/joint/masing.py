"""Loading curves and hysteresis loops of Jenkins elements in parallel.

The elements of a region see one displacement, so their forces add up (Iwan model): on first loading
they carry ``F(u) = sum min(k u, mu N)``. Their steady loops follow from this curve (Masing's rule):
each half of a loop is the loading curve, twice as large and turned around.

References
----------
G. Masing: Eigenspannungen und Verfestigung beim Messing. Proceedings of the Second International
Congress of Applied Mechanics, Zurich (1926) 332-335.
W. D. Iwan: A distributed-element model for hysteresis and its steady-state dynamic response.
Journal of Applied Mechanics 33 (1966) 893-900.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.joint.fit_options import FitOptions

Array = NDArray[np.float64]


def loading_curve(displacement: Array, stiffness: Array, slip_force: Array) -> Array:
    """Force of elements in parallel on first loading by ``displacement`` [N], of its shape."""
    displacement = checks.array("displacement", displacement)
    return force_on_loading_curve(
        displacement, *checked_elements("stiffness", stiffness, slip_force)
    )


def force_on_loading_curve(displacement: Array, stiffness: Array, slip_force: Array) -> Array:
    """As ``loading_curve``, of arguments that were checked before."""
    stuck = np.multiply.outer(displacement, stiffness)
    return np.minimum(stuck, slip_force).sum(axis=-1)


def unloading_branch(
    amplitude: float, displacement: Array, stiffness: Array, slip_force: Array
) -> Array:
    """Force on the branch from ``amplitude`` down to ``displacement`` of the steady loop [N].

    By Masing's rule; the other half of the loop is the same with both signs changed.
    """
    amplitude = checks.number("amplitude", amplitude, above=0)
    displacement = checks.array(
        "displacement", displacement, at_least=-amplitude, at_most=amplitude
    )
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    top = force_on_loading_curve(np.array(amplitude), stiffness, slip_force)
    return top - 2 * force_on_loading_curve((amplitude - displacement) / 2, stiffness, slip_force)


def amplitude_of_load(fraction: float, stiffness: Array, slip_force: Array) -> float:
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
    stiffness: Array,
    slip_force: Array,
    fitted_stiffness: Array,
    fitted_slip_force: Array,
    options: FitOptions = FitOptions(),
) -> LoopError:
    """Error of the loops of fitted elements against those of a region, at all amplitudes.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    fitted_stiffness, fitted_slip_force
        Stiffness and slip force of the fitted elements, with the same total slip force, shape
        (few,).
    options
        Amplitudes and points of the loops whose mean error is found.

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
    return loop_error_of_curve(corner, few, stiffness, slip_force, options)


def loop_error_of_curve(
    corner: Array,
    force: Array,
    stiffness: Array,
    slip_force: Array,
    options: FitOptions = FitOptions(),
) -> LoopError:
    """As ``loop_error``, of a loading curve that is straight between displacements.

    Parameters
    ----------
    corner, force
        Displacements from 0 that hold all corners of both curves [m], and the force there [N].
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    options
        As for ``loop_error``.
    """
    checks.instance("options", options, FitOptions)
    onset = slip_force / stiffness
    difference = (force - force_on_loading_curve(corner, stiffness, slip_force)) / slip_force.sum()
    # d(A) - 2 d(v) with v up to A (Masing) is linear in both between corners
    above = difference - 2 * np.minimum.accumulate(difference)
    below = 2 * np.maximum.accumulate(difference) - difference
    amplitude = np.geomspace(onset.min(), onset.max(), options.compared_amplitudes)
    phase = np.pi * (np.arange(options.loop_samples) + 0.5) / options.loop_samples
    half_drop = np.outer(amplitude, (1 - np.cos(phase)) / 2)
    top = np.interp(amplitude, corner, difference)[:, None]
    along = top - 2 * np.interp(half_drop, corner, difference)
    return LoopError(float(max(above.max(), below.max())), float(np.sqrt(np.mean(along**2))))


def checked_elements(name: str, stiffness: Array, slip_force: Array) -> tuple[Array, Array]:
    """Stiffness, by its name, and slip force of at least one element."""
    stiffness = checks.array(name, stiffness, ("elements",), above=0)
    if not stiffness.size:
        raise ValueError(f"{name} is empty: there must be at least one element")
    slip_name = name.replace("stiffness", "slip_force")
    return stiffness, checks.array(slip_name, slip_force, stiffness.shape, above=0)
