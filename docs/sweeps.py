"""What the page of the shipped sweeps quotes of them: ``python docs/write.py sweeps``.

They are those of ``make reproduce STUDY=config/sweeps.yaml``.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from boltjoint import dataset
from boltjoint.study.errors_of_sweep import SweepError, error_of_sweep, peak_variable
from boltjoint.study.tables.sobol_indices import tabulate_sensitivity
from boltjoint.study.tables.sweeps import tabulate_statistics, values_of_keys

RESULTS = Path(__file__).parents[1] / "results"
MM = 1e3


@cache
def load(name: str) -> xr.Dataset:
    """A finished sweep."""
    return dataset.load(RESULTS / f"sweeps/{name}/sweep.nc")


def solved_with(name: str) -> list[tuple[int, int]]:
    """Highest harmonics with which designs are solved, from the most, and how many are."""
    sweep = load(name)
    numbers = sweep["harmonic_peak_amplitude"].count("design").to_numpy().tolist()
    return list(zip(sweep["harmonics"].to_numpy().tolist(), numbers, strict=True))[::-1]


def statistics(name: str) -> pd.DataFrame:
    """Quantiles of the peaks, by what is observed."""
    return tabulate_statistics(load(name)).set_index("observed")


def error(name: str) -> SweepError | None:
    """How far the peaks are off; None where it is not known."""
    return error_of_sweep(load(name))


@cache
def _indices(name: str) -> pd.DataFrame:
    return tabulate_sensitivity(load(name)).set_index(["observed", "key"])


def shares(name: str, other: str) -> pd.DataFrame:
    """Sobol indices with their intervals, as text, by key and peak; total ones of another too."""
    found = {}
    for sweep, order, words in (
        (name, "first_order", "first order"),
        (name, "total", "total"),
        (other, "total", "total in four modes"),
    ):
        for observed, of_what in (("peak_frequency_Hz", "frequency"), ("peak_mm", "amplitude")):
            rows = _indices(sweep).loc[observed]
            found[f"{of_what}, {words}"] = [
                f"{row[order]:.2f} ({row[f'{order}_low']:.2f} to {row[f'{order}_high']:.2f})"
                for _, row in rows.iterrows()
            ]
    keys = [key.replace("_", " ") for key in rows.index]
    return pd.DataFrame(found, index=keys)


def ratios(name: str, other: str, what: str) -> np.ndarray:
    """Smallest, 5 %, median, 95 % and largest of the peaks of another sweep over those of one."""
    ratio = peaks_of(other, what) / peaks_of(name, what)
    return np.nanquantile(ratio, [0, 0.05, 0.5, 0.95, 1])


def share(name: str, observed: str, key: str, order: str = "total") -> float:
    """A Sobol index."""
    return float(_indices(name).loc[(observed, key), order])


def peaks_of(name: str, what: str) -> np.ndarray:
    """Frequency [Hz] or amplitude [m] of the peaks, with all harmonics if known, by design."""
    return load(name)[peak_variable(load(name), what)].to_numpy()


def loosened(name: str) -> list[dict[str, object]]:
    """Peaks of each bolt at each ratio against those of the tight joint: changes in percent."""
    sweep = load(name)
    keys = [key for key in sweep.attrs["varied"].split() if key.startswith("preload_ratio")]
    ratios = np.column_stack([sweep[key] for key in keys])
    (tight,) = np.flatnonzero((ratios == 1).all(axis=1))
    of_designs = {what: peaks_of(name, what) for what in ("frequency", "amplitude")}
    found = []
    for row in np.flatnonzero((ratios != 1).any(axis=1)):
        (bolt,) = np.flatnonzero(ratios[row] != 1)
        changes = {
            what: (100 * (peaks[row] / peaks[tight] - 1)).tolist()
            for what, peaks in of_designs.items()
        }
        found.append({"bolt": int(bolt) + 1, "ratio": float(ratios[row, bolt]), **changes})
    return found


def change(name: str, bolt: int, ratio: float, what: str, level: int) -> float:
    """One of ``loosened``."""
    (row,) = (each for each in loosened(name) if each["bolt"] == bolt and each["ratio"] == ratio)
    return row[what][level]


def tight(name: str, what: str, level: int) -> float:
    """Peak of the joint with all bolts tight: frequency [Hz] or amplitude [mm]."""
    values = peaks_of(name, what)[0, level]
    return float(values * (MM if what == "amplitude" else 1.0))


def dimensions(name: str, amplitudes_mm: tuple[float, ...]) -> list[dict[str, object]]:
    """Keys of each design, its natural frequency and damping ratio [%] at amplitudes, and peaks."""
    sweep = load(name)
    keys, at = values_of_keys(sweep), np.log(sweep["amplitude"].to_numpy() * MM)
    curves = zip(
        sweep["natural_frequency"].to_numpy(),
        100 * sweep["damping_ratio"].to_numpy(),
        MM * peaks_of(name, "amplitude"),
        strict=True,
    )
    wanted = np.log(amplitudes_mm)
    return [
        {
            "values": {key: float(values[row]) for key, values in keys.items()},
            "frequency": np.interp(wanted, at, frequency),
            "damping": np.interp(wanted, at, damping),
            "peaks": peaks,
        }
        for row, (frequency, damping, peaks) in enumerate(curves)
    ]


@cache
def reduction_errors(name: str, case: str, basis: str) -> xr.Dataset:
    """Errors of peaks with all harmonics against all pairs [%], by the keys of a grid and force.

    Not a number where no peak with more than one harmonic was found.
    """
    sweep = load(name)
    path = RESULTS / f"cases/{case}/{basis}/node-to-node/linear/resonance=1/response.nc"
    whole = dataset.load(path)
    levels = whole["force_level"].to_numpy().tolist()
    at = [levels.index(level) for level in sweep["force_level"].to_numpy()]
    errors = {}
    for what in ("frequency", "amplitude"):
        peaks = f"peak_{what}_converged"
        expected = xr.DataArray(whole[peaks].to_numpy()[at], dims="force")
        errors[what] = abs(100 * (sweep[peaks] / expected - 1))
    return xr.Dataset(errors)
