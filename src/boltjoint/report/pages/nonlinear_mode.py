"""What the backbone of a joint says of it: where slip shows, and where damping is largest."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from boltjoint.names import REFERENCE
from boltjoint.study.results import Results

#: share of the way from sticking to no contact by which slip shows in the natural frequency
SHOWS = 0.01


@dataclass(frozen=True)
class NonlinearMode:
    """Landmarks of a backbone.

    Parameters
    ----------
    slip_level
        Excitation level from which slip shows: the natural frequency has left that of the sticking
        joint by ``SHOWS`` of the way to that without contact; None where it never does, or already
        at the first state.
    largest_damping
        The largest damping ratio.
    amplitude
        Amplitude of the output point at that damping [m].
    level
        Excitation level whose peak has that amplitude.
    """

    slip_level: float | None
    largest_damping: float
    amplitude: float
    level: float

    @classmethod
    def of(cls, backbone: xr.Dataset, between: tuple[float, float]) -> "NonlinearMode | None":
        """The landmarks of ``backbone.nc``; None where it has no states.

        Parameters
        ----------
        backbone
            ``backbone.nc``.
        between
            Resonance without contact and while nothing slips [Hz].
        """
        frequency = backbone["natural_frequency"].to_numpy()
        level = backbone["peak_force"].to_numpy()
        damping = backbone["damping_ratio"].to_numpy()
        if not frequency.size:
            return None
        gone = np.abs(frequency - between[1]) / abs(between[1] - between[0])
        slips = np.flatnonzero(gone > SHOWS)
        slip_level = None
        if slips.size and slips[0] > 0:
            ends = slice(slips[0] - 1, slips[0] + 1)
            slip_level = float(np.exp(np.interp(SHOWS, gone[ends], np.log(level[ends]))))
        most = int(np.argmax(damping))
        amplitude = float(backbone["response_amplitude"][most])
        return cls(slip_level, float(damping[most]), amplitude, float(level[most]))


def nonlinear_mode(
    results: Results, case: str, basis: str, resonance: int, between: tuple[float, float] | None
) -> NonlinearMode | None:
    """The landmarks of the node-to-node joint of a case; None where its backbone is not known."""
    fields = {"case": case, "basis": basis, "joint": REFERENCE[0], "resonance": resonance}
    if between is None or not results.has("backbone", **fields):
        return None
    return NonlinearMode.of(results.dataset("backbone", **fields), between)
