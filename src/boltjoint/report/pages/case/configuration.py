"""The configuration of a case in words: its points, excitation, contact, damping and models."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.contact import ContactEntry, SurfaceEntry
from boltjoint.config.numerical_options import Solver
from boltjoint.damping import Damping, LossFactor
from boltjoint.friction.declarations import DECLARATIONS
from boltjoint.names import JointName, Preload
from boltjoint.number_format import number
from boltjoint.report.pages.content import PageContent
from boltjoint.report.pages.document import table_with_caption
from boltjoint.study.stage_inputs import Results

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


_DIVISIONS = {"equal-load": "equal loads", "equal-middle-load": "equal pressure along the middle"}
_MOTIONS = {"mean": "mean of its pairs", "load-weighted": "mean of its pairs, weighted by load"}

#: of counts, where there are none
_NONE = "none"

#: what the stiffness of a pair and that per area are called, and the factor of their unit there
_STIFFNESSES = {"N/m": ("of a pair (kN/mm)", 1e-6), "N/m3": ("per area (N/m³)", 1.0)}


def facts(name: str, case: Case, solver: Solver, content: PageContent) -> Markup:
    """The table of a case of this name, beside the source that it is compared with."""
    rows = list(_quantities(name, case, solver, content))
    columns = {"quantity": [row[0] for row in rows], "here": [row[1] for row in rows]}
    beside = content.comparison.configuration(rows)
    frame = pd.DataFrame({**columns, **beside.columns})
    table = table_with_caption(frame, "Configuration", beside.notes, "case-table", verbatim=True)
    return table + beside.statement


def _of_bolts(preload: Preload) -> str:
    """Preload of all bolts, or of each."""
    of_bolts = preload.of_bolts
    return number(of_bolts) if isinstance(of_bolts, float) else preload.replace(",", ", ")


def _quantities(
    name: str, case: Case, solver: Solver, content: PageContent
) -> Iterator[tuple[str, str, str | None]]:
    """Quantities of a case, their values and keys."""
    yield "assembly", case.assembly, "assembly"
    yield "preload per bolt (N)", _of_bolts(case.preload), "preload_N"
    yield "contact", DECLARATIONS[case.contact.law].label, "law"
    for key, words, value in _contact(case.contact):
        yield words, value, key
    for surface in case.contact.surfaces:
        if surface.law is not None:
            yield f"{surface.name}: contact", DECLARATIONS[surface.law].label, None
        for _, words, value in _contact(surface):
            yield f"{surface.name}: {words}", value, None
    if elements := content.friction_elements(name, case.bases[0]):
        yield "friction elements, node to node", str(elements), "friction_elements"
    yield from _damping(case.structural_damping)
    if case.is_base_excited:
        yield "accelerations of the supports (m/s²)", ", ".join(map(number, case.levels)), None
    else:
        yield "forces (N)", ", ".join(map(number, case.levels)), "forces_N"
    yield "excitation", excitation_in_words(case, content.results), None
    yield "output point", output_in_words(case, content.results), None
    if sensors := (*(sensor.name for sensor in case.sensors), *case.outputs):
        yield "sensors", ", ".join(sensors), None
    friction = "closed form (analytic)" if solver.sampling is None else "AFT, sampled in time"
    yield "friction forces", friction, None
    chosen = f"as many as change a peak by less than {100 * solver.harmonic_tolerance:g} %"
    harmonics = chosen if solver.harmonics == "auto" else str(solver.harmonics)
    yield "harmonics of the response", harmonics, None
    if solver.sampling is not None:
        yield "time samples per period", str(solver.time_samples), None
    yield "basis", ", ".join(case.bases), None
    joints = [JointName(joint) for joint in case.joints(case.bases[0])]
    of_division = {
        division: _counts(joint.count for joint in joints if joint.division == division)
        for division in ("regions", "clusters")
    }
    if of_division["clusters"] != _NONE:
        yield "clusters", of_division["clusters"], None
    if of_division["regions"] != _NONE or content.comparison.has_case:
        yield "regions", of_division["regions"], "regions"
        yield "division into regions", _DIVISIONS[case.regions.division], None
        yield "motion of a region", _MOTIONS[case.regions.motion], None
    in_region = _counts(joint.elements for joint in joints)
    if in_region != _NONE or content.comparison.has_case:
        yield "elements in a region", in_region, "elements"


def _contact(contact: ContactEntry | SurfaceEntry) -> Iterator[tuple[str, str, str]]:
    """Keys, words and values of what is given of the contact of all surfaces, or of one."""
    for quantity in contact.quantities:
        words, value = quantity.words, getattr(contact, quantity.key)
        if quantity.unit in _STIFFNESSES:
            what, factor = _STIFFNESSES[quantity.unit]
            yield quantity.key, f"{words} {what}", number(value * factor)
        else:
            yield quantity.key, words, str(value)


def _damping(damping: Damping) -> Iterator[tuple[str, str, None]]:
    """Parameters of the damping of the structure."""
    for name, (unit, _) in damping.quantities.items():
        words = name.replace("_", " ") + (f" ({unit})" if unit != "1" else "")
        words = words if isinstance(damping, LossFactor) else f"{damping.name} damping: {words}"
        values = np.atleast_1d(getattr(damping, name))
        yield words, ", ".join(map(number, values.tolist())), None


def _counts(counts: Iterable[int | str | None]) -> str:
    """Different counts in ascending order, then ``auto``, for which a tolerance decides."""
    texts = {str(count) for count in counts if count is not None}
    return ", ".join(sorted(texts, key=lambda n: (not n.isdigit(), len(n), n))) or _NONE
