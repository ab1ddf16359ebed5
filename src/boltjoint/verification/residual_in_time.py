"""Residual-in-time check of single-harmonic solutions, independent of the solver.

The friction of every element is integrated from rest along its motion, sample by sample, by the
rule of its law in time; harmonic coefficients of the forces follow by the trapezoidal rule. Neither
the describing functions of the laws nor the equations of the harmonic balance are shared, only the
definition of the damping model.
"""

from math import ceil

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint import checks
from boltjoint.damping import Damping, ModalStructure, damping_of_attributes
from boltjoint.friction.sliders_in_time import integrate_friction
from boltjoint.joint.io import joint_from_dataset


def forces_in_time(
    point_of_element: NDArray[np.int64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    motion: NDArray[np.float64],
    samples: int,
) -> NDArray[np.float64]:
    """Harmonic friction forces on points under constant normal load, as ``contact_forces_in_time``.

    The elements have the stiffness [N/m] and slip force [N]; motion [m] and force [N] have sine and
    cosine coefficients, shape (points, 2).
    """
    motion = checks.array("motion", motion, ("points", 2))
    slip_force = checks.array("slip_force", slip_force, ("elements",), above=0)
    stiffness = checks.array("stiffness", stiffness, slip_force.shape, above=0)
    both = np.zeros((len(motion), 6))
    both[:, 1:3] = motion
    elements = point_of_element, stiffness, None, np.ones_like(slip_force), slip_force
    return contact_forces_in_time(*elements, both, samples)[:, 1:3]


def contact_forces_in_time(
    point_of_element: NDArray[np.int64],
    tangential_stiffness: NDArray[np.float64],
    normal_stiffness: NDArray[np.float64] | None,
    normal_load: NDArray[np.float64],
    friction_coefficient: NDArray[np.float64],
    motion: NDArray[np.float64],
    samples: int,
) -> NDArray[np.float64]:
    """Harmonic contact forces on points under variable normal load, integrated in time.

    The normal load of an element is that of its spring and never negative; the friction force is
    that of its spring, bounded by mu times the normal load. From the assembled state the points
    move to the start of the period, through one period, and through that which is evaluated.

    Parameters
    ----------
    point_of_element
        The point each element acts on, shape (elements,).
    tangential_stiffness, normal_stiffness
        Of each element [N/m], shape (elements,); None under constant normal load, which must then
        be positive.
    normal_load
        Of each element in the assembled state [N], negative for a gap, shape (elements,).
    friction_coefficient
        Of each element [-], shape (elements,).
    motion
        Bias, sine and cosine coefficients of the points' tangential displacement, then of the
        normal one, positive when closing [m], shape (points, 6).
    samples
        Steps a period.

    Returns
    -------
    ndarray
        Coefficients of the friction force, then of the change of the normal load from the assembled
        state [N], shape (points, 6).

    Raises
    ------
    ValueError
        If the elements differ in length, act on points that do not move, or are not finite; if a
        stiffness or friction coefficient is not positive; or if there are fewer than three samples.
    """
    motion = checks.array("motion", motion, ("points", 6))
    samples = checks.whole("samples", samples, at_least=3)
    on = checks.indices("point_of_element", point_of_element, ("elements",), count=len(motion))
    k_u = checks.array("tangential_stiffness", tangential_stiffness, on.shape, above=0)
    k_v = normal_stiffness
    if k_v is not None:
        k_v = checks.array("normal_stiffness", k_v, on.shape, above=0)
    load = {"above": 0} if k_v is None else {}
    normal_load = checks.array("normal_load", normal_load, on.shape, **load)
    mu = checks.array("friction_coefficient", friction_coefficient, on.shape, above=0)
    return integrate_friction(on, k_u, k_v, normal_load, mu, motion, samples)


def residuals_in_time(
    joint: xr.Dataset,
    response: xr.Dataset,
    *,
    samples: int = 1000,
    tolerance: float = 1e-6,
    maximum_samples: int = 64000,
) -> NDArray[np.float64]:
    """Residual of the modal equations at every stored solution, relative to their largest term.

    The trapezoidal rule converges with the square of the number of samples, but for the kinks of
    friction between samples: Richardson extrapolation from two numbers of samples is used.

    Parameters
    ----------
    joint, response
        ``joint.nc`` of any law, and a ``response.nc`` of that joint.
    samples
        Samples a period of the coarser integration.
    tolerance, maximum_samples
        Where the residual exceeds the tolerance, the number of samples grows until it does not, or
        until the finer integration has the maximum: what then remains is an error of the solution.
        A residual below the tolerance may be an error of the integration.

    Returns
    -------
    ndarray
        Shape (solutions,); the largest term is that of elasticity, inertia, damping, contact or
        excitation in the Euclidean norm over modes and over bias, sine and cosine.

    Raises
    ------
    ValueError
        If the solutions have higher harmonics, or samples and tolerance are out of range.
    """
    checks.instance("joint", joint, xr.Dataset)
    checks.instance("response", response, xr.Dataset)
    samples = checks.whole("samples", samples, at_least=3)
    tolerance = checks.number("tolerance", tolerance, above=0)
    maximum_samples = checks.whole("maximum_samples", maximum_samples, at_least=3)
    components = ["bias", "sin", "cos"]
    further = [name for name in response["component"].to_numpy() if name not in components]
    if further:
        raise ValueError(f"the check knows the first harmonic only, not {', '.join(further)}")
    equations = _ModalEquations(joint, damping_of_attributes(response.attrs))
    amplitude = response["modal_coordinate"].transpose("solution", "mode", "component")
    motion = amplitude.sel(component=components).to_numpy()
    frequency = response["frequency"].to_numpy()
    excitation = response["excitation_force"].to_numpy()
    residual = np.empty(frequency.size)
    for i in range(residual.size):
        count, finest = samples, max(maximum_samples // 2, 1)
        residual[i] = equations.extrapolated(motion[i], frequency[i], excitation[i], count)
        while residual[i] > tolerance and count < finest:
            more = float(np.clip(1.1 * np.sqrt(residual[i] / tolerance), 1.25, 8.0))
            count = min(ceil(more * count), finest)
            residual[i] = equations.extrapolated(motion[i], frequency[i], excitation[i], count)
    return residual


class _ModalEquations:
    """Modal equations of one joint, with contact forces integrated in time."""

    def __init__(self, joint: xr.Dataset, damping: Damping) -> None:
        natural = 2 * np.pi * joint["natural_frequency"].to_numpy()
        self.L = natural[:, None] ** 2
        self.phi = joint["excitation_mode"].to_numpy()
        self.phi_cos = np.zeros_like(self.phi)
        if "excitation_mode_cos" in joint:
            self.phi_cos = joint["excitation_mode_cos"].to_numpy()
        self.damping = damping.matrix(ModalStructure(natural))
        self.R = joint["tangential_mode"].transpose("point", "mode").to_numpy()
        self.N = np.zeros_like(self.R)
        if "normal_mode" in joint:
            self.N = joint["normal_mode"].transpose("point", "mode").to_numpy()
        self.law = joint_from_dataset(joint).law

    def extrapolated(
        self, motion: NDArray[np.float64], frequency: float, excitation: float, samples: int
    ) -> float:
        """Norm of the residual by Richardson extrapolation from samples and twice as many."""
        coarse, fine = (
            self.residual(motion, frequency, excitation, count) for count in (samples, 2 * samples)
        )
        return float(np.linalg.norm(4 * fine - coarse) / 3)

    def residual(
        self, motion: NDArray[np.float64], frequency: float, excitation: float, samples: int
    ) -> NDArray[np.float64]:
        """Residual over the norm of the largest term, shape (modes, 3)."""
        point_motion = np.hstack([self.R @ motion, self.N @ motion])
        contact = self.law.forces_in_time(point_motion, samples)
        bias, sine, cosine = motion.T
        zero = np.zeros_like(bias)
        terms = (
            self.L * motion,
            -((2 * np.pi * frequency) ** 2) * np.column_stack([zero, sine, cosine]),
            self.damping.at(2 * np.pi * frequency) @ np.column_stack([zero, -cosine, sine]),
            self.R.T @ contact[:, :3] + self.N.T @ contact[:, 3:],
            -np.column_stack([zero, self.phi * excitation, self.phi_cos * excitation]),
        )
        return sum(terms) / max(np.linalg.norm(term) for term in terms)


def check_solutions(
    joint: xr.Dataset, response: xr.Dataset, *, samples: int = 1000
) -> pd.DataFrame:
    """Largest residual in time of the converged solutions of each force level.

    Parameters
    ----------
    joint, response, samples
        As for ``residuals_in_time``.

    Returns
    -------
    DataFrame
        Columns ``force_N, solutions, residual_in_time`` and ``frequency_Hz``, where it is largest.

    Raises
    ------
    ValueError
        As for ``residuals_in_time``.
    """
    checks.instance("response", response, xr.Dataset)
    converged = response.isel(solution=response["converged"].to_numpy() == 1)
    residuals = pd.DataFrame(
        {
            "force_N": converged["excitation_force"].to_numpy(),
            "residual_in_time": residuals_in_time(joint, converged, samples=samples),
            "frequency_Hz": converged["frequency"].to_numpy(),
        }
    )
    by_force = residuals.groupby("force_N", sort=False)
    largest = residuals.loc[by_force["residual_in_time"].idxmax()]
    largest.insert(1, "solutions", by_force.size().to_numpy())
    return largest.reset_index(drop=True)
