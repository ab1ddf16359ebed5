"""Do solutions hold when friction is marched in time? A check that shares nothing with the solver.

Every element is followed sample by sample through its motion from rest, its force is brought back
to harmonic coefficients by the trapezoidal rule, and the modal equations are written down anew.
"""

import numpy as np
import pandas as pd
import xarray as xr
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def forces_in_time(
    point_of_element: NDArray[np.int64],
    stiffness: NDArray[np.float64],
    slip_force: NDArray[np.float64],
    motion: NDArray[np.float64],
    samples: int,
) -> NDArray[np.float64]:
    """Harmonic force on each point of elements that are marched in time, side by side.

    The force of an element follows its spring and is cut off at the slip force. From rest, the
    points are led to where the period begins, marched through one period, and observed over the
    next.

    Parameters
    ----------
    point_of_element
        The point each element acts on, shape (elements,).
    stiffness, slip_force
        Of each element [N/m], [N], shape (elements,).
    motion
        Sine and cosine coefficients of the points' displacement [m], shape (points, 2).
    samples
        Steps a period.

    Returns
    -------
    ndarray
        Sine and cosine coefficients of the force [N], shape (points, 2).
    """
    force = np.zeros(motion.shape)
    # on first loading the force only depends on how far the element was led
    before = motion[:, 1].copy()
    traction = np.empty(point_of_element.size)
    for e in range(traction.size):
        led = stiffness[e] * before[point_of_element[e]]
        traction[e] = min(max(led, -slip_force[e]), slip_force[e])
    step = np.empty(before.size)
    for i in range(1, 2 * samples + 1):
        phase = 2 * np.pi * (i % samples) / samples
        sin, cos = np.sin(phase), np.cos(phase)
        for p in range(before.size):
            now = motion[p, 0] * sin + motion[p, 1] * cos
            step[p] = now - before[p]
            before[p] = now
        for e in range(traction.size):
            trial = traction[e] + stiffness[e] * step[point_of_element[e]]
            traction[e] = min(max(trial, -slip_force[e]), slip_force[e])
        if i > samples:
            for e in range(traction.size):
                force[point_of_element[e], 0] += 2 / samples * traction[e] * sin
                force[point_of_element[e], 1] += 2 / samples * traction[e] * cos
    return force


def residuals_in_time(
    joint: xr.Dataset,
    response: xr.Dataset,
    *,
    samples: int = 4000,
    tolerance: float = 1e-6,
    most_samples: int = 64000,
) -> NDArray[np.float64]:
    """What is left of the modal equations at every stored solution, relative to their largest term.

    Parameters
    ----------
    joint, response
        ``joint.nc`` with the constant law, and a ``response.nc`` of that joint.
    samples
        Samples a period; the trapezoidal rule errs by their inverse square.
    tolerance, most_samples
        Where the residual is larger than this, the samples are doubled until it is not, or until
        there are this many: what then remains belongs to the solution, not to the march.

    Returns
    -------
    ndarray
        Shape (solutions,); the largest term is that of elasticity, inertia, damping, friction or
        excitation in the Euclidean norm over modes and over sine and cosine.
    """
    equations = _ModalEquations(joint, response.attrs["loss_factor"])
    amplitude = response["modal_coordinate"].transpose("solution", "mode", "component")
    motion = amplitude.sel(component=["sin", "cos"]).to_numpy()
    frequency = response["frequency"].to_numpy()
    excitation = response["excitation_force"].to_numpy()
    left = np.empty(frequency.size)
    for i in range(left.size):
        count = samples
        left[i] = equations.residual(motion[i], frequency[i], excitation[i], count)
        while left[i] > tolerance and count < most_samples:
            count *= 2
            left[i] = equations.residual(motion[i], frequency[i], excitation[i], count)
    return left


class _ModalEquations:
    """The balance of one joint, with friction marched in time."""

    def __init__(self, joint: xr.Dataset, loss_factor: float) -> None:
        self.L = (2 * np.pi * joint["natural_frequency"].to_numpy()[:, None]) ** 2
        self.R = joint["tangential_mode"].transpose("point", "mode").to_numpy()
        self.phi = joint["excitation_mode"].to_numpy()
        self.loss_factor = loss_factor
        names = ("point_of_element", "tangential_stiffness", "slip_force")
        self.elements = tuple(joint[name].to_numpy() for name in names)

    def residual(
        self, motion: NDArray[np.float64], frequency: float, excitation: float, samples: int
    ) -> float:
        """Norm of what is left over the norm of the largest term."""
        friction = forces_in_time(*self.elements, self.R @ motion, samples)
        turned = np.column_stack([-motion[:, 1], motion[:, 0]])
        terms = (
            self.L * motion,
            -((2 * np.pi * frequency) ** 2) * motion,
            self.loss_factor * self.L * turned,
            self.R.T @ friction,
            -np.column_stack([self.phi * excitation, np.zeros(self.phi.size)]),
        )
        return float(np.linalg.norm(sum(terms)) / max(np.linalg.norm(term) for term in terms))


def check_solutions(
    joint: xr.Dataset, response: xr.Dataset, *, samples: int = 4000
) -> pd.DataFrame:
    """Largest residual in time of the converged solutions at every force level.

    Parameters
    ----------
    joint, response
        As for ``residuals_in_time``.

    Returns
    -------
    DataFrame
        Columns ``force_N, solutions, residual_in_time``.
    """
    converged = response.isel(solution=response["converged"].to_numpy() == 1)
    found = pd.DataFrame(
        {
            "force_N": converged["excitation_force"].to_numpy(),
            "residual_in_time": residuals_in_time(joint, converged),
        }
    )
    by_force = found.groupby("force_N", sort=False)["residual_in_time"]
    return by_force.agg(solutions="size", residual_in_time="max").reset_index()
