"""The configuration of a case beside that of the source."""

from collections.abc import Iterable, Iterator

import numpy as np
import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.config.contact import ContactEntry, SurfaceEntry
from boltjoint.config.solver import Solver
from boltjoint.damping import Damping, LossFactor
from boltjoint.friction.declarations import DECLARATIONS
from boltjoint.names import JointName, Preload
from boltjoint.report.pages.case.points import excitation_in_words, output_in_words
from boltjoint.report.pages.content import PageContent, select
from boltjoint.report.pages.markup import prose, source_reference, table_with_caption
from boltjoint.study.tables.html import number

_DIVISIONS = {"equal-load": "equal loads", "equal-middle-load": "equal pressure along the middle"}
_MOTIONS = {"mean": "mean of its pairs", "load-weighted": "mean of its pairs, weighted by load"}

#: of counts, where there are none
_NONE = "none"

#: keys of the contact and the columns of the source's table of cases
_CONTACT = {
    "law": "contact_law",
    "tangential_stiffness_N_per_m": "k_u_kN_per_mm",
    "normal_stiffness_N_per_m": "k_v_kN_per_mm",
    "friction_coefficient": "mu",
}

#: what the stiffness of a pair and that per area are called, and the factor of their unit there
_STIFFNESSES = {"N/m": ("of a pair (kN/mm)", 1e-6), "N/m3": ("per area (N/mm³)", 1e-9)}

#: values of the source that stand in none of its tables, by quantity
_IN_SOURCE = {
    "basis": "the first four bending modes",
    "friction forces": "–",
    "harmonics of the response": "–",
    "motion of a region": "mean of its pairs",
}
_DIVISIONS_IN_SOURCE = {"constant": "similar loads", "variable": "by the load along the middle"}


def facts(name: str, case: Case, solver: Solver, content: PageContent) -> Markup:
    """The table of a case of this name; its last column has the values of the source."""
    rows = list(_quantities(name, case, solver, content))
    columns = {"quantity": [row[0] for row in rows], "here": [row[1] for row in rows]}
    published = content.published.case_study()
    if published:
        printed = {key: value.replace(" ", ", ") for key, value in published.items()}
        law = published["contact_law"]
        printed["contact_law"] = DECLARATIONS[law].label if law in DECLARATIONS else law
        stated = _IN_SOURCE | {"division into regions": _DIVISIONS_IN_SOURCE.get(law, "not given")}
        columns["in the source"] = [
            stated.get(quantity) or printed.get(key or "") or "not given"
            for quantity, _, key in rows
        ]
    tables = content.published.tables()
    of_case = select(tables, case=content.published.case or "", kind="stiffness")
    notes = [source_reference("Table", list(of_case["table"]))]
    frame = pd.DataFrame(columns)
    table = table_with_caption(frame, "Configuration", notes, "case-table", verbatim=True)
    implied = content.published.implied_preload()
    return table + (prose("case").implied_preload(published, implied) if implied else "")


def _of_bolts(preload: Preload) -> str:
    """Preload of all bolts, or of each."""
    of_bolts = preload.of_bolts
    return number(of_bolts) if isinstance(of_bolts, float) else preload.replace(",", ", ")


def _quantities(
    name: str, case: Case, solver: Solver, content: PageContent
) -> Iterator[tuple[str, str, str | None]]:
    """Quantities of a case, their values, and the columns of the source's table of cases."""
    yield "assembly", case.assembly, "assembly"
    yield "preload per bolt (N)", _of_bolts(case.preload), "preload_per_bolt_N"
    yield "contact", DECLARATIONS[case.contact.law].label, _CONTACT["law"]
    for key, words, value in _contact(case.contact):
        yield words, value, _CONTACT.get(key)
    for surface in case.contact.surfaces:
        if surface.law is not None:
            yield f"{surface.name}: contact", DECLARATIONS[surface.law].label, None
        for _, words, value in _contact(surface):
            yield f"{surface.name}: {words}", value, None
    if elements := content.friction_elements(name, case.bases[0]):
        yield "friction elements, node to node", str(elements), "contact_nodes"
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
    if of_division["regions"] != _NONE or content.published.case is not None:
        yield "regions", of_division["regions"], "regions"
        yield "division into regions", _DIVISIONS[case.regions.division], None
        yield "motion of a region", _MOTIONS[case.regions.motion], None
    elements = _counts(joint.elements for joint in joints)
    if elements != _NONE or content.published.case is not None:
        yield "elements in a region", elements, "elements_per_region"


def _contact(contact: ContactEntry | SurfaceEntry) -> Iterator[tuple[str, str, str]]:
    """Keys, words and values of what is given of the contact of all surfaces, or of one."""
    for each in contact.quantities:
        words, value = each.words, getattr(contact, each.key)
        if each.unit in _STIFFNESSES:
            what, factor = _STIFFNESSES[each.unit]
            yield each.key, f"{words} {what}", number(value * factor)
        else:
            yield each.key, words, str(value)


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
