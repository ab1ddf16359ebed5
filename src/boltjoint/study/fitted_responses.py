"""Measured responses beside those of a fitted joint, as variables of ``calibration.nc``."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from boltjoint.calibration.calibration import Calibration
from boltjoint.calibration.measured_response import MeasuredResponse
from boltjoint.dataset import quantity
from boltjoint.number_format import number

Array = NDArray[np.float64]

#: what is compared of a response
_COMPARED = ("excitation", "phase")


def of_responses(
    calibration: Calibration, units: Sequence[str], level: str
) -> dict[str, xr.Variable]:
    """Names, points and errors of measured responses; nothing without any.

    Parameters
    ----------
    calibration
        A fit.
    units, level
        Of the amplitudes of all its curves, and of the excitation.

    Returns
    -------
    dict
        By dimensions ``response`` and ``response_point``; values that are not compared are NaN.
    """
    found = {
        n: curve
        for n, curve in enumerate(calibration.compared.measured)
        if isinstance(curve, MeasuredResponse)
    }
    if not found:
        return {}
    places, measured = list(found), list(found.values())
    curves, errors = calibration.curves(), calibration.rms_errors
    tests = calibration.checks_of_curves
    of = ("response", "response_quantity")
    statistics = {
        "response_rms_error": (
            [errors[n] for n in places],
            "root mean square, relative and of phases in rad",
        ),
        "response_reduced_chi2": (
            [tests[n].reduced_chi2 for n in places],
            "mean square residual",
        ),
        "response_size_probability": (
            [tests[n].size_probability for n in places],
            "of residuals so large",
        ),
        "response_runs_probability": (
            [tests[n].runs_probability for n in places],
            "of so few changes of sign",
        ),
    }
    return {
        **{
            name: xr.Variable("response", np.array(words, dtype=object))
            for name, words in (
                ("response", [curve.name for curve in measured]),
                ("response_amplitude_quantity", [curve.quantity for curve in measured]),
                ("response_amplitude_unit", [units[n] for n in places]),
            )
        },
        "response_quantity": xr.Variable("response_quantity", np.array(_COMPARED, dtype=object)),
        **{
            name: quantity(of, [_both(values) for values in all_values], "1", words)
            for name, (all_values, words) in statistics.items()
        },
        **_points(measured, [curves[n] for n in places], level),
    }


def _points(
    measured: Sequence[MeasuredResponse], curves: Sequence[Array], level: str
) -> dict[str, xr.Variable]:
    """Measured points of all responses, and what the model needs there."""
    own = np.repeat(np.arange(len(measured)), [curve.points for curve in measured])

    def joined(name: str) -> Array:
        parts = (getattr(curve, name) for curve in measured)
        return np.concatenate(
            [
                np.full(curve.points, np.nan if part is None else part)
                for curve, part in zip(measured, parts, strict=True)
            ]
        )

    phases = [
        (curve.values + curve.difference(model))[:, 1]
        if curve.phase is not None
        else np.full(curve.points, np.nan)
        for curve, model in zip(measured, curves, strict=True)
    ]
    columns = {
        "response_frequency": (joined("frequency"), "Hz", "of the excitation"),
        "response_amplitude": (joined("amplitude"), "unit of each response", "as measured"),
        "response_excitation": (joined("excitation"), level, "as measured"),
        "response_excitation_deviation": (
            joined("excitation_deviation"),
            level,
            "standard deviation",
        ),
        "response_phase": (joined("phase"), "rad", "of the response from the excitation"),
        "response_phase_deviation": (joined("phase_deviation"), "rad", "standard deviation"),
        "model_excitation": (
            np.exp(np.concatenate([model[:, 0] for model in curves])),
            level,
            "which the model needs for the measured amplitude",
        ),
        "model_phase": (np.concatenate(phases), "rad", "of the model"),
    }
    return {
        "response_of_point": quantity("response_point", own, "1", "place of its response"),
        **{
            name: quantity("response_point", values, unit, words)
            for name, (values, unit, words) in columns.items()
        },
    }


def _both(values: Sequence[float]) -> list[float]:
    """Excitation and phase; NaN where that is not compared."""
    return [*values, np.nan][: len(_COMPARED)]


def errors_in_words(calibration: xr.Dataset) -> list[str]:
    """What a fit is off by at each response; none without any."""
    if "response" not in calibration:
        return []
    told = []
    for n, name in enumerate(map(str, calibration["response"].to_numpy())):
        excitation, phase = calibration["response_rms_error"].to_numpy()[n]
        words = f"{number(100 * excitation, 2)} % in excitation"
        if not np.isnan(phase):
            words += f" and {number(np.rad2deg(phase), 2)}° in phase"
        told.append(f"{words} ({name})")
    return told
