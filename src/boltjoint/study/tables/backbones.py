"""Tables of backbones: the power law of microslip.

In microslip the dissipation in a period grows with a power of the amplitude, a straight line in
logarithmic axes. The power is 3 for two spheres or cylinders pressed together, and ``3 + chi`` for
an Iwan element, ``-1 < chi <= 0``; measured joints have 2 to 3. In macroslip it is 1.

References
----------
R. D. Mindlin, H. Deresiewicz: Elastic spheres in contact under varying oblique forces. Journal of
Applied Mechanics 20 (1953) 327-344.
D. J. Segalman: A four-parameter Iwan model for lap-type joints. Journal of Applied Mechanics 72
(2005) 752-760.
M. R. W. Brake (ed.): The Mechanics of Jointed Structures. Springer, 2018.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from boltjoint.dynamics.balance.harmonic_balance import HarmonicBalance
from boltjoint.dynamics.balance.periodic_motion import energy_per_period, motion_at_peak
from boltjoint.joint.model import Joint
from boltjoint.options import Options


@dataclass(frozen=True)
class MicroslipOptions(Options):
    """Range of amplitudes in which the power law is fitted, and points in it.

    The damping ratio by friction rises in microslip, is largest where macroslip begins, and falls
    beyond. The range lies below that maximum.

    Parameters
    ----------
    from_share, to_share
        That ratio at its ends, over the maximum. Below the first, single pairs slip and the curve
        has steps; above the second it bends towards macroslip. In the cases of the default study
        twice or half of either moves the power by at most 0.26 in ``enriched-40``, and by 0.49 in
        ``free-4``, whose range is less than a decade.
    points
        Points of the fit, evenly spaced over the logarithm of the amplitude. Twice or half as many
        move the power by at most 5e-3.
    """

    from_share: float = 0.01
    to_share: float = 0.1
    points: int = 200


def tabulate_microslip(
    backbones: Mapping[str, xr.Dataset], options: MicroslipOptions | None = None
) -> pd.DataFrame:
    """The power law of microslip, and where macroslip begins, of each joint.

    Parameters
    ----------
    backbones
        ``backbone.nc`` by the joint's name.
    options
        Range and points of the fit.

    Returns
    -------
    DataFrame
        A row for each joint: ``power``, the slope of the friction dissipation over the amplitude of
        the output point in logarithmic axes; the range ``from_amplitude_mm`` to
        ``to_amplitude_mm`` of the fit; ``dissipation_at_end_J``, by the fit; ``rms_error_percent``,
        the root-mean-square of the dissipation's logarithm less the line's; the largest friction
        damping ratio and its amplitude; the natural frequencies of the stuck joint and at that
        amplitude. Empty where friction dissipates nothing, or the range has fewer than two
        states.
    """
    options = MicroslipOptions() if options is None else options
    return pd.DataFrame(
        [{"joint": name, **_fit(backbone, options)} for name, backbone in backbones.items()]
    )


def peak_dissipation(
    joint: Joint, response: xr.Dataset
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Amplitude [m], frequency [Hz] and friction dissipation [J] at the peaks of responses.

    Parameters
    ----------
    joint
        That was solved.
    response
        Its ``response.nc``; forces whose branch is not complete are left out.

    Returns
    -------
    tuple of ndarray
        Each of shape (complete forces,).
    """
    balance = HarmonicBalance(joint, 0.0, 0.0)
    at = response.isel(force=np.flatnonzero(response["complete"]))
    friction = []
    for force in at["force_level"].to_numpy():
        at_peak = motion_at_peak(response, force)
        if at_peak is None:
            raise ValueError(f"the response to {force:g} has no solution")
        frequency, motion = at_peak
        x = motion.in_components(balance.components).ravel()
        friction.append(energy_per_period(balance, x, 2 * np.pi * frequency)[2])
    return at["peak_amplitude"].to_numpy(), at["peak_frequency"].to_numpy(), np.array(friction)


def _fit(backbone: xr.Dataset, options: MicroslipOptions) -> dict[str, float]:
    fit = dict.fromkeys(_COLUMNS_OF_MICROSLIP, np.nan)
    amplitude = backbone["response_amplitude"].to_numpy()
    dissipation = backbone["friction_dissipation"].to_numpy()
    frequency = backbone["natural_frequency"].to_numpy()
    damping = _friction_damping(backbone)
    if not damping.size or damping.max() <= 0:
        return fit
    top = int(damping.argmax())
    fit |= {
        "largest_friction_damping_percent": 100 * damping[top],
        "macroslip_amplitude_mm": 1e3 * amplitude[top],
        "stuck_frequency_Hz": frequency[0],
        "macroslip_frequency_Hz": frequency[top],
    }
    share = damping[: top + 1] / damping[top]
    if (ends := _range_of_microslip(np.log(amplitude[: top + 1]), share, options)) is None:
        return fit
    grid = np.linspace(*ends, options.points)
    slips = dissipation > 0
    curve = np.interp(grid, np.log(amplitude[slips]), np.log(dissipation[slips]))
    power, at_end = np.polyfit(grid - grid[-1], curve, 1)
    error = np.sqrt(np.mean((curve - at_end - power * (grid - grid[-1])) ** 2))
    return fit | {
        "power": power,
        "from_amplitude_mm": 1e3 * np.exp(ends[0]),
        "to_amplitude_mm": 1e3 * np.exp(ends[1]),
        "dissipation_at_end_J": np.exp(at_end),
        "rms_error_percent": 100 * error,
    }


def _range_of_microslip(
    x: NDArray[np.float64], share: NDArray[np.float64], options: MicroslipOptions
) -> tuple[float, float] | None:
    """Logarithms x of the amplitudes between which the damping has its shares of the maximum.

    Of several such ranges that next to the maximum, which is last; None with less than two states.
    """
    last = int(np.flatnonzero(share <= options.to_share).max(initial=-1))
    first = int(np.flatnonzero(share[: last + 1] < options.from_share).max(initial=-1)) + 1
    if last - first < 1:
        return None

    def between(before: int, value: float) -> float:
        ends = np.log(share[before : before + 2])
        return float(np.interp(np.log(value), ends, x[before : before + 2]))

    # a joint that has only just begun to slip has no curve below
    begins = first == 0 or share[first - 1] < 0.1 * options.from_share
    low = float(x[first]) if begins else between(first - 1, options.from_share)
    return low, between(last, options.to_share)


def _friction_damping(backbone: xr.Dataset) -> NDArray[np.float64]:
    """Damping ratio by friction alone, by state: ``D / (2 pi a^2 w^2)``."""
    w, a = 2 * np.pi * backbone["natural_frequency"], backbone["modal_amplitude"]
    return (backbone["friction_dissipation"] / (2 * np.pi * (a * w) ** 2)).to_numpy()


_COLUMNS_OF_MICROSLIP = (
    *("power", "from_amplitude_mm", "to_amplitude_mm", "dissipation_at_end_J", "rms_error_percent"),
    *("largest_friction_damping_percent", "macroslip_amplitude_mm"),
    *("stuck_frequency_Hz", "macroslip_frequency_Hz"),
)
