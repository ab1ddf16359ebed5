"""Fit of a few Jenkins elements to the hysteresis of the many of a region.

The elements of a region see one displacement, so their loops add up. A few elements are sought with
the same total stiffness and the same total slip force, and either the same loops at three
amplitudes or the same describing function at all amplitudes.

References
----------
Nonlinear vibrations and reduced order modeling of bolted joints. Thesis, Middle East Technical
University: section 3.1.1.4.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from boltjoint import checks
from boltjoint.joint import fit_describing_function, fit_loops
from boltjoint.joint.element_shares import rounded_shares
from boltjoint.joint.fit_options import FitOptions
from boltjoint.joint.masing import amplitude_of_load, checked_elements

Array = NDArray[np.float64]

#: what of the hysteresis is fitted
Method = Literal["loops", "describing-function"]


@dataclass(frozen=True)
class Fit:
    """Elements fitted to those of a region.

    ``tangential_stiffness`` [N/m] and ``slip_force`` [N] have the shape (elements,), ``amplitude``
    [m] that of the loops of eq. 3.3; ``cost`` [N^2] is that equation, minimised or not.
    """

    tangential_stiffness: Array
    slip_force: Array
    amplitude: Array
    cost: float


def fit_elements(
    stiffness: Array,
    slip_force: Array,
    count: int,
    *,
    method: Method = "loops",
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    starts: int = 16,
    options: FitOptions = FitOptions(),
) -> Fit:
    """Fit ``count`` elements to the hysteresis of many.

    ``loops`` minimises the squared force difference over the loops at the amplitudes where the
    region carries ``load_fractions`` of its slip force (eq. 3.3).

    ``describing-function`` minimises the squared difference of the first-harmonic force at all
    amplitudes up to full slip, evenly in their logarithm, over the slip force; its part in phase
    with velocity also over the loss itself where that is small, since small losses limit a
    resonance too. The search starts from minimax loading curves (``nearest_loading_curve``).

    Both are local least squares with the analytic Jacobian. Stiffness and slip force are shares
    (softmax) of the region's totals, so the totals hold and every parameter stays positive.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    count
        Number of elements to fit.
    method
        ``loops`` or ``describing-function``.
    load_fractions
        One for each loop of eq. 3.3, between 0 and 1.
    starts
        Number of deterministic initial guesses of ``loops``, of which the best result is taken.
    options
        What of the hysteresis is compared.

    Returns
    -------
    Fit
        Elements in the order in which they start to slip.

    Raises
    ------
    ValueError
        If the region has fewer than ``count`` elements, a stiffness or slip force is not positive,
        a fraction is not between 0 and 1, or the method is not known.
    """
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    if not 1 <= checks.whole("count", count) <= stiffness.size:
        raise ValueError(
            f"count is {count}: cannot fit {count} elements to the {stiffness.size} of a region"
        )
    load_fractions = check_fit_options(method, load_fractions, starts)
    checks.instance("options", options, FitOptions)
    amplitude = np.array([amplitude_of_load(f, stiffness, slip_force) for f in load_fractions])
    loops = fit_loops.LoopMisfit(stiffness, slip_force, amplitude, options.loop_samples)
    shares = rounded_shares(stiffness), rounded_shares(slip_force)
    if method == "loops":
        at = np.array([amplitude_of_load(f, *shares) for f in load_fractions])
        misfit = fit_loops.LoopMisfit(*shares, at, options.loop_samples)
        guesses = fit_loops.initial_guesses(*shares, count, starts)
    else:
        weight = options.loss_weight * count**2
        misfit = fit_describing_function.DescribingFunctionMisfit(*shares, weight, options)
        guesses = fit_describing_function.initial_guesses(*shares, count, options)
    tolerances = {"xtol": 1e-12, "ftol": 1e-12, "gtol": 1e-12}
    best = min(
        (least_squares(misfit.residual, guess, misfit.jacobian, **tolerances) for guess in guesses),
        key=lambda result: result.cost,
    )
    k, s = loops.elements(best.x)
    order = np.argsort(s / k, kind="stable")
    # both halves of a loop are compared in eq. 3.3, one is computed
    difference = loops.residual(best.x)
    cost = 2 * (difference @ difference) * slip_force.sum() ** 2
    return Fit(k[order], s[order], amplitude, float(cost))


def check_fit_options(method: Method, load_fractions: Sequence[float], starts: int) -> Array:
    """Refuse options of a fit; the fractions of the load as an array."""
    checks.choice("method", method, get_args(Method))
    checks.whole("starts", starts, at_least=1)
    return checks.array("load_fractions", load_fractions, ("loops",), above=0, at_most=1)
