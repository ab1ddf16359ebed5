"""A case in one basis: figures of its joints and responses, with statements on their peaks."""

from dataclasses import dataclass
from typing import Any

import pandas as pd
from markupsafe import Markup

from boltjoint.config.case import Case
from boltjoint.harmonics import in_words
from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.number_format import number
from boltjoint.report.pages.content import PageContent, StudyTable, capitalize, select
from boltjoint.report.pages.document import prose, table_with_caption
from boltjoint.report.pages.peaks import ALL, SOLVED, peaks_of_coordinates, statement_of


@dataclass(frozen=True)
class CaseBasis:
    """A case in one modal basis.

    Parameters
    ----------
    case
        As configured.
    name
        Name of the basis, such as ``free-4``.
    content
        Figures and tables of the page.
    accuracy, times
        Tables of all responses in this basis, None where the study has none.
    """

    case: Case
    name: str
    content: PageContent
    accuracy: StudyTable | None
    times: StudyTable | None

    @classmethod
    def of(cls, case: Case, name: str, content: PageContent) -> "CaseBasis":
        """The case in the basis of this name; it takes two tables from the content."""
        accuracy, times = (content.table(kind, basis=name) for kind in ("accuracy", "times"))
        return cls(case, name, content, accuracy, times)

    def coordinates_by_joint(self, resonance: int) -> dict[str, list[str]]:
        """The joints solved around a resonance, and the coordinates in which each is solved."""
        coordinates_of: dict[str, list[str]] = {}
        for basis, joint, coordinates, at in self.case.responses:
            if (basis, at) == (self.name, resonance):
                coordinates_of.setdefault(joint, []).append(coordinates)
        return coordinates_of


_TEXT = prose("case")


def joint_figures(basis: CaseBasis, joint: str) -> Markup:
    """Weighted pairs or regions of a joint on the contact, and the fit of its elements."""
    name = JointName(joint)
    content = basis.content
    body = Markup()
    if name.pairs is not None:
        body += content.figures("weighted_pairs", basis=basis.name, joint=joint)
    if name.division is not None:
        values = {"basis": basis.name, "joint": name.regions}
        body += content.figures("regions", **values)
        if table := content.table("regions", **values):
            body += table.html(capitalize(name.regions.label))
    if name.is_fitted:
        values = {"basis": basis.name, "joint": joint}
        region = content.comparison.region_of_loops(joint)
        body += content.figures("loops", title=f"Hysteresis loops of region {region}", **values)
        if table := content.table("elements", **values):
            body += _elements(table, basis)
    return body


def _elements(table: StudyTable, basis: CaseBasis) -> Markup:
    comparison = basis.content.comparison
    beside = comparison.elements(table.artefact, table.frame, basis.case.nominal_preload)
    return table.html(
        f"Fitted elements: {table.artefact.fields['joint'].label}",
        ["In the order in which they start to slip.", *beside.notes],
        ["region"],
        frame=beside.frame,
        anchor=beside.anchor,
    )


def responses(basis: CaseBasis, joint: str, resonance: int) -> Markup:
    """Responses of a joint around a resonance, and the contact states at their peaks."""
    body = Markup()
    for coordinates in basis.coordinates_by_joint(resonance)[joint]:
        values: dict[str, Any] = {
            "joint": joint,
            "coordinates": coordinates,
            "resonance": resonance,
        }
        note = statement_of_response(basis, **values)
        body += basis.content.figures("response", note, basis=basis.name, **values)
        body += basis.content.figures("states", basis=basis.name, **values)
    return body


def peaks(basis: CaseBasis, resonance: int) -> Markup:
    """Peaks of the node-to-node joint, all kinds of coordinates side by side."""
    if basis.accuracy is None:
        return Markup()
    nodes = select(basis.accuracy.frame, joint=REFERENCE[0], resonance=resonance)
    if nodes.empty:
        return Markup()
    parts: dict[str, pd.DataFrame] = {}
    for coordinates, rows in nodes.groupby("coordinates", sort=False):
        peaks = peaks_of_coordinates(rows).set_index(("", "force_N"))
        if ALL in peaks and not parts:
            # the bars stand in the first table of the page
            parts[ALL] = peaks[ALL][["frequency_Hz", "response_mm_per_N"]]
        parts[Coordinates(coordinates).label] = peaks[SOLVED].drop(columns="harmonics")
    title = f"Peaks of the node-to-node joint around resonance {resonance} in {basis.name}"
    return table_with_caption(side_by_side(parts), title, [_TEXT.peaks(ALL in parts)])


def side_by_side(parts: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Tables over force beside each other, each under its name."""
    frame = pd.concat(parts, axis=1)
    frame.insert(0, ("", "force_N"), frame.index)
    return frame


def statement_of_response(basis: CaseBasis, joint: str, coordinates: str, resonance: int) -> str:
    """Peaks or errors of a response, its folds, and where it is replaced, wrong or broken off."""
    if basis.accuracy is None:
        return ""
    values = {"joint": joint, "coordinates": coordinates, "resonance": resonance}
    rows = select(basis.accuracy.frame, **values)
    is_reference = (joint, coordinates) == REFERENCE
    about_peaks = statement_of(rows) if is_reference else _errors_of_peaks(rows)
    about_folds = _folds(rows), _isolated(rows)
    statements = (about_peaks, *about_folds, _replaced(rows), _wrong(rows), _broken_off(rows))
    return Markup(" ").join(filter(None, statements))


def _errors_of_peaks(rows: pd.DataFrame) -> str:
    complete = rows[rows["complete"]].set_index("force_N")
    errors = {
        quantity: complete[f"peak_{quantity}_error_percent"].abs()
        for quantity in ("frequency", "amplitude")
    }
    if any(error.isna().all() for error in errors.values()):
        return ""
    largest = " and ".join(
        f"{number(error.max(), 2)} % in {quantity} (at {error.idxmax():g} N)"
        for quantity, error in errors.items()
    )
    medians = " and ".join(f"{number(error.median(), 2)} %" for error in errors.values())
    return f"Errors of the peak against the reference: at most {largest}; medians {medians}."


def _folds(rows: pd.DataFrame) -> str:
    """Where there are several solutions at one frequency."""
    folded = rows[rows["turning_points"] > 0]
    if folded.empty:
        return ""
    ranges = ", ".join(
        f"at {one.force_N:g} N between {one.folded_from_Hz:.2f} and {one.folded_to_Hz:.2f} Hz "
        f"({one.turning_points} turning points)"
        for one in folded.itertuples()
    )
    words = (
        f"There are several solutions at the same frequency: {ranges}. Sweeps with rising and with "
        "falling frequency follow different ones."
    )
    for harmonics, rows_of in folded.groupby("stability_harmonics"):
        words += _stability(rows_of, int(harmonics))
    return words


def _stability(folded: pd.DataFrame, harmonics: int) -> str:
    """Which motions with a number of harmonics are unstable; nothing where it was not found."""
    if not harmonics:
        return ""
    motions = f"motions with {in_words([harmonics])}"
    multiplier, words = folded["largest_multiplier"], ""
    if not (unstable := folded[multiplier > 1]).empty:
        words += (
            f" At {_forces(unstable)} N {motions} are unstable, where the line is broken, with "
            f"Floquet multipliers up to {multiplier.max():.4g}."
        )
    several = ", ".join(
        f"between {one.folded_from_converged_Hz:.2f} and {one.folded_to_converged_Hz:.2f} Hz at "
        f"{one.force_N:g} N"
        for one in folded.dropna(subset="folded_from_converged_Hz").itertuples()
    )
    if several and harmonics > 1:
        words += f" There are several such motions {several}."
    if not (stable := folded[multiplier <= 1]).empty:
        words += f" At {_forces(stable)} N no {motions} are unstable."
    return words


def _isolated(rows: pd.DataFrame) -> str:
    """Where the backbone has higher amplitudes on a branch of their own."""
    isolated = rows[rows["isolated_branch"].eq(True)]
    if isolated.empty:
        return ""
    return (
        f"At {_forces(isolated)} N there is an isolated branch too, with a higher peak, which "
        "sweeps of the frequency do not reach."
    )


def _replaced(rows: pd.DataFrame) -> str:
    """Where the response in linear modes takes its place."""
    replaced = rows[rows["fell_back"]]
    if replaced.empty:
        return ""
    return f"At {_forces(replaced)} N it is replaced by the response in linear modes."


def _wrong(rows: pd.DataFrame) -> str:
    """Where the error estimated in all linear modes is too large."""
    wrong = rows[rows["wrong"]]
    if wrong.empty:
        return ""
    at_peak = wrong["estimated_peak_error_percent"].max()
    return _TEXT.wrong(
        _forces(wrong),
        number(wrong["estimated_largest_error_percent"].max(), 2),
        "" if pd.isna(at_peak) else number(at_peak, 2),
    )


def _broken_off(rows: pd.DataFrame) -> str:
    lost = rows[~rows["complete"]]
    if lost.empty:
        return ""
    reasons = "; ".join(lost["reason"].dropna().unique())
    return f"Broken off at {_forces(lost)} N{f': {reasons}' if reasons else ''}."


def _forces(rows: pd.DataFrame) -> str:
    return ", ".join(f"{force:g}" for force in rows["force_N"])
