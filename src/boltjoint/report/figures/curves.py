"""Curves of frequency responses and backbones, as figures and pages draw them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.harmonics import harmonics_of_level
from boltjoint.structure.model_limits import LIMITS

#: millimetres of a metre
_MM = 1e3
#: where a limit of the model is reached (``structure.model_limits``)
LIMIT_LINE: Mapping[str, Any] = {"linestyle": (0, (5, 2)), "linewidth": 0.9, "marker": "none"}
LIMIT = "the model ends"


@dataclass(frozen=True)
class ResponseCurve:
    """Response at one excitation level: frequency and amplitude over the level, where solved.

    Parameters
    ----------
    level
        The excitation level [N or m/s^2].
    frequency, amplitude
        Frequencies [Hz] and amplitudes [mm per unit of the level] along the branch, (solutions,).
    unstable
        Harmonics of unstable motions, 0 at others, shape (solutions,).
    peak
        Index of the located peak, None where the branch has none.
    converged
        Frequency and amplitude of the peak with as many harmonics as change nothing, None where it
        was not found.
    error_bar
        Error bars of ``converged``, relative; not a number where it is not tested.
    broken_off
        Whether the branch ends within the window.
    fell_back
        Whether it is the response in linear modes instead.
    harmonics
        Harmonics of its motions.
    model_limit
        Amplitude, as above, beyond which the model does not hold, by the first of the limits that
        are proportional to it (``structure.model_limits``); not a number where none is known.
    """

    level: float
    frequency: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    unstable: NDArray[np.int64]
    peak: int | None
    converged: tuple[float, float] | None
    error_bar: tuple[float, float]
    broken_off: bool
    fell_back: bool
    harmonics: int
    model_limit: float = np.nan

    @property
    def end(self) -> str:
        """Where a branch that is broken off ends, in words."""
        if self.frequency.size == 0:
            return "no solution found"
        return f"breaks off at {self.frequency[-1]:.1f} Hz"


def response_curves(response: xr.Dataset) -> list[ResponseCurve]:
    """The curve of a response at each of its excitation levels.

    Parameters
    ----------
    response
        As ``solve_response`` returns it.
    """
    curves = []
    for place in range(response.sizes["force"]):
        at = response.isel(force=place)
        level = float(at["force_level"])
        of_level = (response["excitation_force"] == level) & (response["converged"] == 1)
        solutions = response.isel(solution=np.flatnonzero(of_level))
        peak = np.flatnonzero(solutions["response_amplitude"] == at["peak_amplitude"])
        is_unstable = solutions["stable"].to_numpy() == 0
        converged = None
        if np.isfinite(at.get("peak_harmonics", np.nan)):
            amplitude = float(at["peak_amplitude_converged"]) * _MM / level
            converged = float(at["peak_frequency_converged"]), amplitude
        # where the error of the basis is not known, a bar would hold too little
        is_tested = np.isfinite(at.get("basis_amplitude_error", np.nan))
        of_frequency, of_amplitude = (
            float(at[f"peak_{what}_converged_error"]) if is_tested else np.nan
            for what in ("frequency", "amplitude")
        )
        highest = converged[1] if converged else float(at["peak_amplitude"]) * _MM / level
        shares = [
            float(at.get(f"peak_{limit.name}", np.nan)) / limit.tolerated
            for limit in LIMITS
            if limit.is_proportional
        ]
        reached = np.nan_to_num(shares).max()
        curves.append(
            ResponseCurve(
                level=level,
                frequency=solutions["frequency"].to_numpy(),
                amplitude=solutions["response_amplitude"].to_numpy() * _MM / level,
                unstable=np.where(is_unstable, solutions["stability_harmonics"], 0),
                peak=int(peak[0]) if peak.size else None,
                converged=converged,
                error_bar=(of_frequency, of_amplitude),
                broken_off=not at["complete"],
                fell_back=bool(at["fell_back"]),
                harmonics=harmonics_of_level(response, place),
                model_limit=highest / reached if reached else np.nan,
            )
        )
    return curves


def peaks_on_backbone(backbone: xr.Dataset, forces: Sequence[float]) -> dict[float, float]:
    """Amplitude [mm] of the output point at the peak under each force that a backbone reaches.

    Parameters
    ----------
    backbone
        ``backbone.nc``.
    forces
        Excitation levels.
    """
    rising = np.argsort(backbone["peak_force"].to_numpy())
    force = backbone["peak_force"].to_numpy()[rising]
    amplitude = backbone["response_amplitude"].to_numpy()[rising] * _MM
    reached = [level for level in forces if force.size and force[0] <= level <= force[-1]]
    if not reached:
        return {}
    peaks = np.exp(np.interp(np.log(reached), np.log(force), np.log(amplitude)))
    return dict(zip(reached, peaks.tolist(), strict=True))
