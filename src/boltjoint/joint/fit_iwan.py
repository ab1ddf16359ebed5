"""Fit of one four-parameter Iwan element to the friction elements of each region.

Stiffness and slip force are those of the region; exponent and weight of the distribution are fitted
to the describing function at all amplitudes, weighted as that of a single element
(``joint.fit_jenkins``). An Iwan element slips at any amplitude, where the elements of a
region do not until the first of them slips.

References
----------
D. J. Segalman: A four-parameter Iwan model for lap-type joints. Journal of Applied Mechanics 72
(2005) 752-760.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import TypedDict

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares

from boltjoint import checks
from boltjoint.friction.iwan import FourParameterIwan
from boltjoint.joint.fit_jenkins import DescribingFunctionMisfit, rounded_shares
from boltjoint.joint.hysteresis import (
    FitOptions,
    LoopError,
    amplitude_of_load,
    checked_elements,
    loop_error_of_curve,
    unloading_branch,
)
from boltjoint.joint.model import Joint
from boltjoint.joint.reduced import check_capabilities, fit_dataset
from boltjoint.names import CONSTANT_NORMAL_LOAD, COULOMB_ELEMENTS

Array = NDArray[np.float64]

#: bounds of chi and of the logarithm of beta: the law itself goes on to -1 and 0
_LOWER, _UPPER = (-0.99, -12.0), (0.0, 8.0)

#: initial guesses of chi and of the logarithm of beta; from 1 to 25 of them find the same element,
#: whose peaks differ by less than 4e-9
_GUESSES = tuple(product((-0.9, -0.5, -0.1), (-2.0, 1.0, 2.5)))


def fit_iwan_element(
    stiffness: Array, slip_force: Array, options: FitOptions = FitOptions()
) -> FourParameterIwan:
    """Four-parameter Iwan element with the totals of many elements and the nearest harmonic force.

    Parameters
    ----------
    stiffness, slip_force
        Stiffness and slip force of the elements of a region [N/m], [N], shape (many,).
    options
        Amplitudes and losses of the describing functions that are compared.

    Returns
    -------
    FourParameterIwan
        One element on point 0.

    Raises
    ------
    ValueError
        If a stiffness or slip force is not positive.
    """
    stiffness, slip_force = checked_elements("stiffness", stiffness, slip_force)
    checks.instance("options", options, FitOptions)
    shares = rounded_shares(stiffness), rounded_shares(slip_force)
    misfit = DescribingFunctionMisfit(*shares, options.loss_weight, options)
    # an element and a point for each amplitude
    motion = np.column_stack([misfit.amplitude, np.zeros_like(misfit.amplitude)])
    ones, on = np.ones(len(motion)), np.arange(len(motion))

    def residual(unknown: Array) -> Array:
        chi, beta = unknown[0], np.exp(unknown[1])
        law = FourParameterIwan(on, ones, ones, chi * ones, beta * ones)
        return misfit.difference((law.evaluate(motion, 0.0) / misfit.amplitude[:, None]).T.ravel())

    how = {
        "jac": "3-point",
        "bounds": (_LOWER, _UPPER),
        "xtol": 1e-12,
        "ftol": 1e-12,
        "gtol": 1e-12,
    }
    best = min(
        (least_squares(residual, guess, **how) for guess in _GUESSES),
        key=lambda result: result.cost,
    )
    quantities = stiffness.sum(), slip_force.sum(), best.x[0], np.exp(best.x[1])
    return FourParameterIwan(np.zeros(1, dtype=np.int64), *np.reshape(quantities, (4, 1)))


def fit_iwan_joint(
    joint: Joint,
    *,
    load_fractions: Sequence[float] = (0.3, 0.6, 0.9),
    options: FitOptions = FitOptions(),
) -> tuple[Joint, xr.Dataset]:
    """Replace the elements of every region by one four-parameter Iwan element.

    Parameters
    ----------
    joint
        A joint of regions of Coulomb friction elements under constant normal load.
    load_fractions
        The loops of the dataset are those at which a region carries these fractions of its slip
        force.
    options
        What of the hysteresis is compared.

    Returns
    -------
    joint : Joint
        On the same points, with one element each.
    fit : Dataset
        As from ``joint.reduced.fit_reduced_joint``.

    Raises
    ------
    ValueError
        If the law of the joint is another one, a region has no element, or a fraction is not
        between 0 and 1.
    """
    law = check_capabilities(joint, COULOMB_ELEMENTS, CONSTANT_NORMAL_LOAD)
    fractions = checks.array("load_fractions", load_fractions, ("loops",), above=0, at_most=1)
    fits, qualities = [], []
    for point in range(joint.points):
        mine = law.point_of_element == point
        k, s = law.tangential_stiffness[mine], law.slip_force[mine]
        if not k.size:
            raise ValueError(f"region {point + 1} of the joint has no element")
        fits.append(fit_iwan_element(k, s, options))
        qualities.append(_quality(k, s, fits[-1], fractions, options))
    quantities = {
        name: np.concatenate([getattr(fit, name) for fit in fits])
        for name in FourParameterIwan.quantities
    }
    reduced = replace(
        joint,
        law=FourParameterIwan(np.arange(joint.points), **quantities),
        element_position=joint.position,
    )
    return reduced, fit_dataset(
        cost=[quality["cost"] for quality in qualities],
        error=[quality["error"] for quality in qualities],
        amplitude=[quality["amplitude"] for quality in qualities],
        displacement=[quality["displacement"] for quality in qualities],
        force_of_region=[quality["force_of_region"] for quality in qualities],
        force_of_fit=[quality["force_of_fit"] for quality in qualities],
        options=options,
    )


class _Quality(TypedDict):
    """Cost, error and loops of the fit of a region, as for ``fit_dataset``."""

    cost: float
    error: LoopError
    amplitude: Array
    displacement: Array
    force_of_region: Array
    force_of_fit: Array


def _quality(
    k: Array, s: Array, fit: FourParameterIwan, fractions: Array, options: FitOptions
) -> _Quality:
    """Quality of the fit of a region."""
    amplitude = np.array([amplitude_of_load(fraction, k, s) for fraction in fractions])
    u = np.outer(amplitude, np.cos(np.linspace(0, np.pi, options.loop_samples)))
    of_region = np.array([unloading_branch(a, v, k, s) for a, v in zip(amplitude, u, strict=True)])
    drop = (amplitude[:, None] - u) / 2
    top = fit.loading_curve(amplitude)
    of_fit = top - 2 * fit.loading_curve(drop)[..., 0]
    onset = s / k
    last = max(onset.max(), fit.largest_slip_displacement[0])
    samples = np.geomspace(1e-2 * onset.min(), last, options.curve_samples)
    corner = np.unique(np.concatenate([[0.0], onset, samples]))
    error = loop_error_of_curve(corner, fit.loading_curve(corner)[:, 0], k, s, options)
    return {
        # both halves of a loop are compared in eq. 3.3, one is computed
        "cost": float(2 * np.sum((of_fit - of_region) ** 2)),
        "error": error,
        "amplitude": amplitude,
        "displacement": u,
        "force_of_region": of_region,
        "force_of_fit": of_fit,
    }
