"""Sweeps whose peaks and responses are known functions of their keys."""

import numpy as np
import xarray as xr

from boltjoint.config.sampling import exchanged
from boltjoint.config.sweep import Sweep

LEVELS = (1.0, 10.0, 100.0)
FREQUENCY = np.linspace(60, 80, 41)
#: by name, the ends, the unit and the key
KEYS = {
    "preload": (8e3, 12e3, "N", "preload_N"),
    "friction_coefficient": (0.05, 0.5, "1", "contact.friction_coefficient"),
    "loss_factor": (0.002, 0.01, "1", "loss_factor"),
}
GRID_SIZES = (5, 4, 3)


def sweep_of(kind, number=64):
    """A sweep as it is configured."""
    design = {"kind": kind} if kind in ("grid", "table") else {"kind": kind, "number": number}
    keys = KEYS.values()
    if kind == "table":
        design["file"] = "designs.csv"
        vary = {}
    else:
        vary = {
            key: {"kind": "linear", "lowest": low, "highest": high}
            | ({"number": size} if kind == "grid" else {})
            for (low, high, _, key), size in zip(keys, GRID_SIZES, strict=True)
        }
    return Sweep.model_validate(
        {
            "case": "mine",
            "vary": vary,
            "design": design,
            "basis": "free-4",
            "joint": "regions=6/elements=7",
            "observe": ["peaks", "responses"],
        }
    )


def content_of(kind, number=64, failed=0, responses=True):
    """``sweep.nc`` of it; the last designs are impossible, or lack the peaks of the first level."""
    shares = _shares(kind, number)
    values = [
        low + share * (high - low)
        for share, (low, high, _, _) in zip(shares, KEYS.values(), strict=True)
    ]
    load, friction, loss = values
    level = np.array(LEVELS)
    # in designs along the first dimensions, then levels, then frequencies
    slip = (level / 100) ** 0.5 / (1 + 10 * friction[..., None])
    peak = 70 + load[..., None] / 1e3 * (1 - slip)
    width = peak * (loss[..., None] + 0.02 * slip)
    distance = FREQUENCY - peak[..., None]
    response = 1e-5 * level[:, None] / np.hypot(distance, width[..., None])
    reason = np.full(load.shape, "", dtype=object)
    complete = np.ones(peak.shape, dtype=np.int8)
    amplitude = 1e-5 * level / width
    flat = reason.reshape(-1)
    for place in range(reason.size - failed, reason.size):
        at = np.unravel_index(place, reason.shape)
        lost = slice(None) if place % 2 else 0
        flat[place] = (
            f"preload_N: {-place} must be > 0" if place % 2 else "<step length> below 1e-9"
        )
        for each in (peak, amplitude, response):
            each[(*at, lost)] = np.nan
        complete[(*at, lost)] = 0
    dims = tuple(KEYS) if kind == "grid" else ("design",)
    coordinates = {
        name: (
            (name, low + np.linspace(0, 1, size) * (high - low))
            if kind == "grid"
            else ("design", column)
        )
        + ({"units": unit, "key": key},)
        for (name, (low, high, unit, key)), size, column in zip(
            KEYS.items(), GRID_SIZES, values, strict=True
        )
    }
    found = {
        "peak_frequency": ((*dims, "force"), peak, {"units": "Hz"}),
        "peak_amplitude": ((*dims, "force"), amplitude, {"units": "m"}),
        "complete": ((*dims, "force"), complete, {"units": "1"}),
        "reason": (dims, reason.astype(str), {"units": "1"}),
        "force_level": ("force", level, {"units": "N"}),
    }
    if responses:
        found["response_amplitude"] = ((*dims, "force", "frequency"), response, {"units": "m"})
        coordinates["frequency"] = ("frequency", FREQUENCY, {"units": "Hz"})
    attributes = {"varied": " ".join(KEYS)}
    if kind == "saltelli":
        attributes["saltelli_samples"] = number
    return xr.Dataset(found, coordinates, attributes)


def _shares(kind, number):
    """Values of the keys as shares of their ranges."""
    if kind == "grid":
        return np.meshgrid(*(np.linspace(0, 1, size) for size in GRID_SIZES), indexing="ij")
    random = np.random.default_rng(7)
    if kind == "saltelli":
        return exchanged(*random.random((2, len(KEYS), number)))
    return random.random((len(KEYS), number))
