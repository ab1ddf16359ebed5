"""Errors of reduced models and the time that they save, of every case and basis."""

from collections.abc import Mapping

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.report.pages.content import PageContent, select
from boltjoint.report.pages.markup import link, prose, table_with_caption
from boltjoint.study.response_list import by_trust

_TEXT = prose("accuracy")

#: time saved with numeric Jacobians
_NUMERIC = ("time saved", "numeric_percent")


def reduced_models(cases: Mapping[str, Case], content: PageContent) -> Markup:
    """Tables of the errors of reduced models against all elements, and of the time they save.

    Parameters
    ----------
    cases
        By name.
    content
        Content of a page with the tables of accuracy and times of all, which it takes.
    """
    rows, times_of = [], {}
    for name, case in cases.items():
        for family in by_trust(case.bases):
            accuracy = content.table("accuracy", case=name, basis=family)
            times = content.table("times", case=name, basis=family)
            row = identity(cases, name, family)
            if accuracy is None and times is None:
                continue
            if accuracy is not None:
                row |= _errors(case, family, accuracy.frame)
            if times is not None:
                row |= _time_saved(case, family, times.frame)
                times_of[name, family] = times.frame
            rows.append(row)
    if not rows:
        return Markup()
    frame = pd.DataFrame(rows)
    frame.columns = pd.MultiIndex.from_tuples(frame.columns)
    if not (has_numeric := not content.comparison.is_empty):
        frame = frame.drop(columns=[_NUMERIC], errors="ignore")
    body = table_with_caption(
        frame, "Errors of reduced models and time saved", [_TEXT.reduced_models(has_numeric)]
    )
    return body + content.comparison.time_saved(times_of)


def identity(cases: Mapping[str, Case], name: str, family: str) -> dict[tuple[str, str], object]:
    """The columns that tell a case in a basis from others, with a link to its page."""
    row: dict[tuple[str, str], object] = {("", "case"): link(f"{name}.html", name)}
    if any(len(case.bases) > 1 for case in cases.values()):
        row[("", "basis")] = family
    return row


def _errors(case: Case, family: str, accuracy: pd.DataFrame) -> dict[tuple[str, str], object]:
    row: dict[tuple[str, str], object] = {}
    resonance = case.resonances(family)[0]
    nodes = select(accuracy, joint=REFERENCE[0], resonance=resonance)
    kinds = nodes["coordinates"].map(lambda name: Coordinates(name).kind)
    for kind, title in (("real", "RDNM"), ("complex", "complex RDNM"), ("backbone", "backbone")):
        rows = nodes[kinds == kind]
        row[(title, "amplitude_error_percent")] = rows["peak_amplitude_error_percent"].abs().max()
        broken_off = f"{int((~rows['complete']).sum())} of {len(rows)}"
        row[(title, "broken_off")] = broken_off if len(rows) else None
    return row


def _time_saved(case: Case, family: str, times: pd.DataFrame) -> dict[tuple[str, str], object]:
    first = case.resonances(family)[0]
    joints = dict.fromkeys(
        joint
        for basis, joint, _, resonance in case.responses
        if (basis, resonance) == (family, first)
    )
    fitted = [joint for joint in joints if JointName(joint).elements is not None]
    smallest = min(fitted, key=_elements_in_all, default=None)
    saved = select(times, joint=smallest, coordinates=REFERENCE[1], resonance=first)
    return {
        ("time saved", "analytic_percent"): saved["reduction_percent"].median(),
        _NUMERIC: saved["reduction_forward_difference_percent"].median(),
    }


def _elements_in_all(joint: str) -> int:
    name = JointName(joint)
    # how many regions a tolerance asks for is not known here: it makes no difference to the order
    return (1 if name.count == "auto" else name.count or 0) * (name.elements or 0)
