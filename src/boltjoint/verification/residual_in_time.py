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
from boltjoint.damping import Damping, damping_of_attributes
from boltjoint.joint.io import joint_from_dataset
from boltjoint.joint.model import MODES


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
    finest = max(maximum_samples // 2, 1)

    def needed(count: int, residual: float) -> int:
        """Samples with which a residual of the integration falls just below the tolerance."""
        more = float(np.clip(1.1 * np.sqrt(residual / tolerance), 0.1, 8.0))
        return ceil(min(max(more * count, samples), finest))

    count = min(samples, finest)
    for i in range(residual.size):
        # a solution needs about as many as the one before
        residual[i] = equations.extrapolated(motion[i], frequency[i], excitation[i], count)
        while residual[i] > tolerance and count < finest:
            count = max(needed(count, residual[i]), min(ceil(1.25 * count), finest))
            residual[i] = equations.extrapolated(motion[i], frequency[i], excitation[i], count)
        count = needed(count, residual[i])
    return residual


class _ModalEquations:
    """Modal equations of one joint, with contact forces integrated in time."""

    def __init__(self, joint: xr.Dataset, damping: Damping) -> None:
        model = joint_from_dataset(joint).distinct
        self.L = (2 * np.pi * model.natural_frequency[:, None]) ** 2
        excitation = model.excitation.modes
        self.phi, self.phi_cos = excitation.real, excitation.imag
        # forces in time are those of the normal direction too, whether the law needs it or not
        self.law = model.contact.element_law
        modes = (getattr(model, MODES[direction]) for direction in self.law.directions_in_time)
        self.rows = [np.zeros_like(model.rows[0]) if B is None else B for B in modes]
        self.damping = damping.matrix(model.structure())

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
        point_motion = np.hstack([B @ motion for B in self.rows])
        contact = self.law.in_time.evaluate(point_motion, 2 * np.pi * frequency, samples)
        bias, sine, cosine = motion.T
        zero = np.zeros_like(bias)
        of_directions = (B.T @ contact[:, 3 * d : 3 * d + 3] for d, B in enumerate(self.rows))
        terms = (
            self.L * motion,
            -((2 * np.pi * frequency) ** 2) * np.column_stack([zero, sine, cosine]),
            self.damping.at(2 * np.pi * frequency) @ np.column_stack([zero, -cosine, sine]),
            sum(of_directions, np.zeros(())),
            -np.column_stack([zero, self.phi * excitation, self.phi_cos * excitation]),
        )
        largest = float(max(np.linalg.norm(term) for term in terms))
        return sum(terms, np.zeros(())) / largest


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
