"""Where a case is excited and observed, in words."""

from collections.abc import Sequence

import xarray as xr

from boltjoint.config.case import Case
from boltjoint.study.results import Results
from boltjoint.study.tables.html import number

_MM = 1e3


def excitation_in_words(case: Case, results: Results) -> str:
    """Where and in which direction a case is excited."""
    excitation = case.excitation
    if excitation is None:
        return _default(case, results, "excitation_node")
    if excitation.kind == "base":
        return f"supports, along {excitation.direction}"
    if excitation.kind == "distributed":
        return f"spread over the surface {excitation.surface}, along {excitation.direction}"
    if excitation.kind == "inputs":
        return ", ".join(point.name for point in excitation.inputs)
    return "; ".join(
        _place((point.x_mm, point.y_mm, point.z_mm), point.direction) for point in excitation.points
    )


def output_in_words(case: Case, results: Results) -> str:
    """The output point, whose amplitude is the response, and its direction."""
    if case.sensors:
        first = case.sensors[0]
        place = _place((first.x_mm, first.y_mm, first.z_mm), first.direction)
        return f"{first.name}: {place}"
    if case.outputs:
        return str(case.outputs[0])
    return _default(case, results, "response_node")


def _default(case: Case, results: Results, name: str) -> str:
    """A point of the assembly, which a case that gives none has."""
    if not results.has("assembly", assembly=case.assembly):
        return "that of the assembly"
    assembly: xr.Dataset = results.dataset("assembly", assembly=case.assembly)
    if name not in assembly or "coordinate" not in assembly:
        return "that of the assembly"
    place = assembly["coordinate"].isel(node=int(assembly[name])).to_numpy() * _MM
    return _place(place.tolist(), assembly[name].attrs["direction"])


def _place(place: Sequence[float], direction: str) -> str:
    """A place [mm] and a direction in words."""
    at = ", ".join(number(round(coordinate, 3) + 0.0) for coordinate in place)
    return f"({at}) mm, along {direction}"
