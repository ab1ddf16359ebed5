"""Responses and backbones of a case under the pointer, and the parts of a page that answer it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.harmonics import highest_harmonic, in_words
from boltjoint.names import REFERENCE, Basis, Coordinates, JointName
from boltjoint.report.figures.curves import ResponseCurve, peaks_on_backbone, response_curves
from boltjoint.report.pages.document import compressed_json, compressed_plotly, pack, prose
from boltjoint.study.response_list import by_trust
from boltjoint.study.stage_inputs import Results

_MM = 1e3

#: a model is named by its basis, joint and coordinates
_Model = tuple[Basis, JointName, Coordinates]


def curves_of_case(name: str, case: Case, results: Results) -> dict[str, Any] | None:
    """Responses and backbones by resonance, as JSON can hold them; None without any.

    Parameters
    ----------
    name, case
        The case.
    results
        ``response.nc`` and ``backbone.nc`` of those to draw.
    """
    models = dict.fromkeys((basis, joint, at) for basis, joint, at, _ in _responses(case))
    resonances = sorted({entry[3] for entry in _responses(case)})
    by_resonance = [
        {
            "resonance": resonance,
            "models": [
                model_content
                for model in models
                if (model_content := _model(name, model, resonance, case.levels, results))
                is not None
            ],
        }
        for resonance in resonances
    ]
    drawn = [entry for entry in by_resonance if entry["models"]]
    if not drawn:
        return None
    return {
        "case": name,
        "unit": "m/s²" if case.is_base_excited else "N",
        "levels": list(case.levels),
        "colours": _colours(len(case.levels)),
        "resonances": drawn,
    }


def _responses(case: Case) -> list[tuple[Basis, JointName, Coordinates, int]]:
    """The responses of a case, those of the most trusted basis first."""
    bases = by_trust(case.bases)
    responses = [
        (Basis(basis), JointName(joint), Coordinates(coordinates), resonance)
        for basis, joint, coordinates, resonance in case.responses
    ]
    return sorted(responses, key=lambda response: bases.index(response[0]))


def _model(
    name: str, model: _Model, resonance: int, levels: Sequence[float], results: Results
) -> dict[str, Any] | None:
    """A model around a resonance: its curves, and of a backbone that; None without results."""
    basis, joint, coordinates = model
    fields = {"case": name, "basis": basis, "joint": joint, "resonance": resonance}
    if not results.has("response", **fields, coordinates=coordinates):
        return None
    response = results.dataset("response", **fields, coordinates=coordinates)
    content: dict[str, Any] = {
        "basis": basis,
        "words": f"{joint.label}, {coordinates.short_label}",
        "reference": (joint, coordinates) == REFERENCE,
        "curves": [_curve(curve) for curve in response_curves(response)],
    }
    if coordinates.kind == "backbone" and results.has("backbone", **fields):
        limits = [curve["limit"] for curve in content["curves"] if curve["limit"] is not None]
        backbone = results.dataset("backbone", **fields)
        content["backbone"] = _backbone(backbone, levels, min(limits, default=None))
    return content


def _curve(curve: ResponseCurve) -> dict[str, Any]:
    """A curve, as JSON can hold it."""
    peak = None
    if curve.peak is not None:
        peak = [float(curve.frequency[curve.peak]), float(curve.amplitude[curve.peak])]
    bars = [100 * bar if np.isfinite(bar) else None for bar in curve.error_bar]
    return {
        "x": pack(curve.frequency),
        "y": pack(curve.amplitude),
        "peak": peak,
        "converged": None if curve.converged is None else [*curve.converged, *bars],
        "unstable": list(_ranges(curve.unstable > 0)),
        "harmonics": in_words([curve.harmonics]),
        "brokenOff": curve.end if curve.broken_off else None,
        "limit": float(curve.model_limit) * curve.level if np.isfinite(curve.model_limit) else None,
    }


def _ranges(mask: np.ndarray) -> Iterator[list[int]]:
    """First and last place of each run of true values."""
    edges = np.flatnonzero(np.diff(mask.astype(int), prepend=0, append=0))
    for first, end in edges.reshape(-1, 2).tolist():
        yield [first, end - 1]


def _backbone(backbone: xr.Dataset, levels: Sequence[float], limit: float | None) -> dict[str, Any]:
    """A backbone, and its states at the peaks of the levels, as JSON can hold them."""
    amplitude = backbone["response_amplitude"].to_numpy() * _MM
    of_mode = {
        "frequency": backbone["natural_frequency"].to_numpy(),
        "damping": 100 * backbone["damping_ratio"].to_numpy(),
    }
    peaks = peaks_on_backbone(backbone, levels)
    at = np.log(list(peaks.values()))
    return {
        "harmonics": in_words([highest_harmonic(backbone)]),
        "amplitude": pack(amplitude),
        **{quantity: pack(values) for quantity, values in of_mode.items()},
        "peaks": [
            {"level": level, "amplitude": peak, "frequency": frequency, "damping": damping}
            for (level, peak), frequency, damping in zip(
                peaks.items(),
                *(np.interp(at, np.log(amplitude), values).tolist() for values in of_mode.values()),
                strict=True,
            )
        ],
        "limit": limit,
    }


def _colours(count: int) -> list[str]:
    """Colours of the levels, as in figures."""
    from matplotlib.colors import to_hex

    from boltjoint.report.figures.style import level_colours

    return [to_hex(colour) for colour in level_colours(count)]


@dataclass(frozen=True)
class InteractiveParts:
    """Drawings of a case that answer the pointer, each empty where there is nothing to draw.

    Parameters
    ----------
    responses
        Responses and backbones.
    view
        The joint in space.
    scripts
        Data and library, at the end of the page.
    """

    responses: Markup
    view: Markup
    scripts: Markup

    @classmethod
    def of_case(cls, name: str, case: Case, results: Results) -> "InteractiveParts":
        """Those of a case, of as many of its files as are among the results."""
        # what computes takes long to import
        from boltjoint.report.pages.interactive.view import view_of_case

        curves, view = curves_of_case(name, case, results), view_of_case(name, case, results)
        if curves is None and view is None:
            return cls(Markup(), Markup(), Markup())
        template = prose("interactive/templates/interactive")
        packed = (
            None if content is None else compressed_json(content) for content in (curves, view)
        )
        return cls(
            template.responses("m/s²" if case.is_base_excited else "N") if curves else Markup(),
            template.view() if view else Markup(),
            template.scripts(*packed, compressed_plotly()),
        )
