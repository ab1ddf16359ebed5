"""The page of a case: its joints from node-to-node down to a few elements, stage by stage."""

import html
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import pandas as pd

from boltjoint import dataset
from boltjoint.config.case import Case
from boltjoint.config.solver import Solver
from boltjoint.names import REFERENCE, coordinates_in_words, joint_in_words, parse_joint
from boltjoint.report.pages import markup
from boltjoint.report.pages.markup import Section, in_time, number, source, table
from boltjoint.report.pages.shown import (
    LAWS,
    Shelf,
    Shown,
    capitalized,
    errors_in_words,
    harmonics_in_words,
    menu,
    those,
)
from boltjoint.study.published import BASIS, Published

_DIVISIONS = {
    "equal-load": "equal loads",
    "equal-middle-load": "equal pressure along the middle",
}

_MOTIONS = {"mean": "mean of its pairs", "load-weighted": "mean of its pairs, weighted by load"}

_FRICTION_FORCE = {
    "analytic": "analytic describing function",
    "aft": "alternating frequency/time (AFT)",
}

_GROUPS = ["joint", "coordinates", "resonance"]


def page(
    name: str,
    case: Case,
    solver: Solver,
    files: Sequence[str],
    published: Published,
    cases: Sequence[str],
) -> str:
    """Node-to-node joint, regions and few elements of a case, in the order of the source.

    Parameters
    ----------
    name, case
        The case and how it is configured.
    solver
        Friction force (analytic or AFT) and number of harmonics of the responses.
    files
        Figures and tables (CSV) to show, and the node-to-node joint (``joint.nc``) of every basis.
    published
        The source's tables, of the case study that this case is compared with.
    cases
        Names of the study's cases, to which the page links.
    """
    shelf = Shelf(files, published)
    sections = [Section("case", "What is computed", _facts(case, solver, shelf))]
    for family in case.bases:
        sections += _Basis(case, family, shelf).sections()
    sections += shelf.rest()
    theirs = published.case_study()
    compared = f"Section {theirs['section']} of the source. " if theirs else ""
    lead = (
        f"<p>{compared}The assembly <i>{case.assembly}</i> with {number(case.preload_N)} N in "
        f"every bolt and {_law(case.contact.law)} on its contact. {_answered(solver)}</p>"
        "<p>In all figures colour is the level of force or displacement, from dark to light; a "
        "thin line is the reference, a broad pale one the model that stands in for it; a dot is a "
        "peak, and a cross the place where a branch broke off; dashed are solutions that a slow "
        "sweep of the frequency passes over.</p>"
    )
    return markup.page(name, "Case study", lead, sections, menu(cases), f"{name}.html")


def _law(name: str) -> str:
    return LAWS.get(name, name)


def _answered(solver: Solver) -> str:
    """What stands for a motion of several harmonics."""
    if solver.harmonics == 1:
        return ""
    return (
        f"The motion has {solver.harmonics} harmonics; response, peak and error are those of its "
        "first-harmonic amplitude."
    )


def _facts(case: Case, solver: Solver, shelf: Shelf) -> str:
    """How the case is configured, beside what the source says of its own."""
    theirs = shelf.published.case_study()
    rows = [
        ("assembly", case.assembly, "assembly"),
        ("preload per bolt (N)", number(case.preload_N), "preload_per_bolt_N"),
        *_contact_facts(case),
    ]
    for path in shelf.data("joint.nc")[:1]:
        elements = dataset.load(path).sizes["element"]
        rows.append(("friction elements, node to node", str(elements), "contact_nodes"))
    in_source = case.bases[0]
    parsed = [parse_joint(joint) for joint in case.joints(in_source)]
    rows += [
        ("loss factor", number(case.loss_factor), None),
        ("forces (N)", ", ".join(map(number, case.forces_N)), "forces_N"),
        ("friction forces", _FRICTION_FORCE[solver.friction_force], None),
        ("harmonics of the response", str(solver.harmonics), None),
    ]
    if solver.friction_force == "aft":
        rows.append(("time samples of a period", str(solver.time_samples), None))
    rows += [
        ("basis", ", ".join(case.bases), None),
        (
            "regions",
            _counts(joint.count for joint in parsed if joint.division == "regions"),
            "regions",
        ),
        ("division into regions", _DIVISIONS[case.regions.division], None),
        ("motion of a region", _MOTIONS[case.regions.motion], None),
        (
            "elements in a region",
            _counts(joint.elements for joint in parsed),
            "elements_per_region",
        ),
    ]
    columns = {"quantity": [row[0] for row in rows], "here": [row[1] for row in rows]}
    if theirs:
        printed = {key: value.replace(" ", ", ") for key, value in theirs.items()}
        printed["contact_law"] = _law(theirs["contact_law"])
        columns["in the source"] = [printed.get(row[2] or "") or "not given" for row in rows]
        in_words = {
            "basis": "the first four bending modes",
            "friction forces": "–",
            "harmonics of the response": "–",
            "division into regions": "similar loads"
            if theirs["contact_law"] == "constant"
            else "by the load along the middle",
            "motion of a region": "mean of its pairs",
        }
        for quantity, words in in_words.items():
            columns["in the source"][columns["quantity"].index(quantity)] = words
    tables = shelf.published.tables()
    mine = those(tables, case=shelf.published.case or "", kind="stiffness")
    numbers = source("Table", list(mine["table"]))
    body = table(pd.DataFrame(columns), "The case", [numbers], "case-table", verbatim=True)
    if implied := shelf.published.implied_preload():
        body += (
            f"<p>The source states {theirs['preload_per_bolt_N']} N per bolt, but the slip forces "
            f"that it prints for its fitted elements add up to what {number(implied)} N per bolt "
            "would give.</p>\n"
        )
    return body


def _contact_facts(case: Case) -> Iterator[tuple[str, str, str]]:
    printed = {
        "law": "contact_law",
        "tangential_stiffness_N_per_m": "k_u_kN_per_mm",
        "normal_stiffness_N_per_m": "k_v_kN_per_mm",
        "friction_coefficient": "mu",
    }
    for key, value in case.contact.model_dump().items():
        words = key.replace("_", " ")
        if key == "law":
            yield "contact", _law(value), printed[key]
        elif key.endswith("_N_per_m"):
            words = f"{words.removesuffix(' N per m')} of a pair (kN/mm)"
            yield words, number(value / 1e6), printed.get(key, "")
        else:
            yield words, str(value), printed.get(key, "")


def _counts(numbers: Iterable[int | str | None]) -> str:
    """Numbers in ascending order, after these what a tolerance decides."""
    different = {number for number in numbers if number is not None}
    return (
        ", ".join(sorted(map(str, different), key=lambda n: (not n.isdigit(), len(n), n))) or "none"
    )


@dataclass(frozen=True)
class _Stage:
    name: str
    title: str
    words: str


_STAGES = (
    _Stage(
        "nodes",
        "Node-to-node joint",
        "One friction element on every contact pair that can carry load. Its responses in linear "
        "modes are the reference for all that follows. The peak falls in frequency while slip "
        "spreads over the contact. Where the normal load is constant and all of it slips, the "
        "structure is near to that without contact again.",
    ),
    _Stage(
        "regions",
        "Regions",
        "Pairs are gathered in regions along the bar, from the clamped side, or in clusters of "
        "pairs that move alike. Each moves as one point, but keeps all elements of its pairs. "
        "Where the source divides the contact is not known.",
    ),
    _Stage(
        "elements",
        "Few elements in each region",
        "The elements of each region are replaced by a few, fitted so that the hysteresis loops "
        "agree at three displacement amplitudes, or, in a harmonic fit, the harmonic force at all; "
        "or by one whose harmonic force is tabulated.",
    ),
)


def _stage_of(joint: str) -> str:
    parsed = parse_joint(joint)
    if parsed.division is None:
        return "nodes"
    return "regions" if parsed.reduction is None else "elements"


#: further columns of tables in which published values stand
_BESIDE_PUBLISHED = ("source_table", "k_ratio", "slip_force_ratio", "difference_points")


class _Basis:
    """All that a case has in one modal basis."""

    def __init__(self, case: Case, family: str, shelf: Shelf) -> None:
        self.case, self.family, self.shelf = case, family, shelf
        self.accuracy = shelf.table("accuracy", modes=family)
        self.times = shelf.table("times", modes=family)
        self.states = shelf.table("states", modes=family)
        self.in_source = family == BASIS
        self.where = "" if len(case.bases) == 1 else f" in {family}"

    def sections(self) -> Iterator[Section]:
        first, *others = self.case.resonances(self.family)
        for stage in _STAGES:
            joints = [joint for joint in self._solved(first) if _stage_of(joint) == stage.name]
            parts = {joint: self._stage_of_joint(joint, first) for joint in joints}
            if not joints:
                continue
            words = f"<p>{stage.words}</p>\n"
            if stage.name == "nodes":
                words += self._peaks(first) + "".join(parts.values())
            yield self._section(stage.name, stage.title, words)
            if stage.name != "nodes":
                for joint, body in parts.items():
                    title = capitalized(joint_in_words(joint))
                    yield self._section(joint.replace("/", "_"), title, body, level=3)
        for resonance in others:
            body = "".join(
                self._joint(joint) + self._responses(joint, resonance)
                for joint in self._solved(resonance)
            )
            yield self._section(f"resonance-{resonance}", f"Resonance {resonance}", body)
        if found := self.shelf.table("fits", modes=self.family):
            yield self._section("fits", "Fits of elements", _fits(*found))
        if drawn := self._backbones():
            yield self._section("backbones", "Backbones", drawn)
        peaks = self.shelf.table("harmonic_peaks", modes=self.family)
        marched = self.shelf.table("harmonics", modes=self.family)
        if peaks or marched:
            body = (_harmonic_peaks(*peaks) if peaks else "") + (
                _harmonics(*marched) if marched else ""
            )
            title = "More harmonics, and time" if marched else "More harmonics"
            yield self._section("harmonics", title, body)
        if self.states is not None:
            yield self._section("states", "Contact at the peaks", _states(*self.states))
        if self.accuracy is not None:
            yield self._section("accuracy", "Accuracy", _accuracy(*self.accuracy))
        if self.times is not None:
            drawn = "".join(
                self.shelf.draw(
                    "times",
                    f"Solution times around resonance {resonance}",
                    "Above, the times; below, their ratios to those of the node-to-node joint in "
                    "linear modes.",
                    modes=self.family,
                    resonance=resonance,
                )
                for resonance in self.case.resonances(self.family)
            )
            shown, frame = self.times
            yield self._section("times", "Solution times", _times(shown, self._own(frame), drawn))

    def _solved(self, resonance: int) -> dict[str, list[str]]:
        """The joints around a resonance, and the coordinates in which each is solved."""
        found: dict[str, list[str]] = {}
        for family, joint, coordinates, at in self.case.responses:
            if (family, at) == (self.family, resonance):
                found.setdefault(joint, []).append(coordinates)
        return found

    def _section(self, anchor: str, title: str, body: str, level: int = 2) -> Section:
        return Section(f"{anchor}-{self.family}", title + self.where, body, level)

    def _stage_of_joint(self, joint: str, resonance: int) -> str:
        body = self._joint(joint) + self._responses(joint, resonance)
        return body + self._published_times(joint)

    def _joint(self, joint: str) -> str:
        """How a joint is made: where its regions lie, and how its elements were fitted."""
        parsed = parse_joint(joint)
        body = ""
        if parsed.division is not None:
            mine = {"modes": self.family, "joint": parsed.regions}
            words = capitalized(joint_in_words(parsed.regions))
            body += self.shelf.draw(
                "regions",
                f"{words} on the contact",
                "With the number of elements and the share of the load of each. Pairs that are "
                "grey have no element.",
                **mine,
            )
            if found := self.shelf.table("regions", **mine):
                shown, frame = found
                body += table(frame, words, (), shown.anchor, shown.from_page)
        if parsed.elements is not None:
            region = self.shelf.published.region_of_loops(joint)
            of_fit = " of the fit" if parsed.reduction == "elements" else ""
            mine = {"modes": self.family, "joint": joint}
            body += self.shelf.draw(
                "loops",
                f"Hysteresis loops of region {region}",
                f"Over one period, at three amplitudes{of_fit}. Where the thin "
                f"line leaves the broad one, {parsed.elements} elements do not stand for all. Both "
                "have the same stiffness while nothing slips, and the same force once all does.",
                **mine,
            )
            if found := self.shelf.table("elements", **mine):
                shown, frame = found
                body += _elements(shown, self._own(frame))
        return body

    def _backbones(self) -> str:
        return "".join(
            self.shelf.draw(
                "backbone",
                f"Backbones of resonance {resonance}",
                "Natural frequency and damping ratio of the first mode in contact over the "
                "amplitude of the observed point, from all stuck to all slipping; a dot is the "
                "peak under a force of this case.",
                modes=self.family,
                resonance=resonance,
            )
            for resonance in self.case.resonances(self.family)
        )

    def _own(self, frame: pd.DataFrame) -> pd.DataFrame:
        """A table without what the source printed, unless it is in the source's basis."""
        if self.in_source:
            return frame
        theirs = [column for column in frame if column.startswith("published_")]
        return frame.drop(columns=[*theirs, *_BESIDE_PUBLISHED], errors="ignore")

    def _responses(self, joint: str, resonance: int) -> str:
        """Responses of a joint around a resonance, and the states of the contact at their peaks."""
        body = ""
        around = f" around resonance {resonance}" if resonance > 1 else ""
        for coordinates in self._solved(resonance)[joint]:
            which = {"joint": joint, "coordinates": coordinates, "resonance": resonance}
            what = f"{joint_in_words(joint)}, {coordinates_in_words(coordinates)}{around}"
            body += self.shelf.draw(
                "response", capitalized(what), self._verdict(**which), modes=self.family, **which
            )
            body += self.shelf.draw(
                "states",
                f"Contact at the peaks: {what}",
                "What every pair does over one period, at the peak of each response.",
                modes=self.family,
                **which,
            )
        return body

    def _verdict(self, joint: str, coordinates: str, resonance: int) -> str:
        """What the table of accuracy says of a response."""
        if self.accuracy is None:
            return ""
        rows = those(self.accuracy[1], joint=joint, coordinates=coordinates, resonance=resonance)
        done = rows[rows["complete"]]
        remarks = _folded(rows) + _doubtful(rows) + _broken_off(rows)
        if done.empty:
            return remarks
        if (joint, coordinates) == REFERENCE:
            low, high = done.iloc[0], done.iloc[-1]
            said = (
                f"The peak lies at {low['peak_frequency_Hz']:.1f} Hz with {low['force_N']:g} N and "
                f"at {high['peak_frequency_Hz']:.1f} Hz with {high['force_N']:g} N."
            )
            return said + remarks
        errors = {
            "frequency": done.set_index("force_N")["peak_frequency_error_percent"].abs(),
            "amplitude": done.set_index("force_N")["peak_amplitude_error_percent"].abs(),
        }
        if any(error.isna().all() for error in errors.values()):
            return remarks
        worst = " and ".join(
            f"{number(error.max(), 2)} % in {what} (at {error.idxmax():g} N)"
            for what, error in errors.items()
        )
        middle = " and ".join(f"{number(error.median(), 2)} %" for error in errors.values())
        said = f"Peaks differ from the reference's by at most {worst}; by the median, {middle}."
        return said + remarks

    def _peaks(self, resonance: int) -> str:
        """Peaks of the node-to-node joint, all kinds of coordinates side by side."""
        if self.accuracy is None:
            return ""
        nodes = those(self.accuracy[1], joint=REFERENCE[0], resonance=resonance)
        columns = {"peak_frequency_Hz": "frequency_Hz", "peak_mm_per_N": "response_mm_per_N"}
        # the largest response of a part of a path need not be the peak
        nodes = nodes.assign(**{name: nodes[name].where(nodes["complete"]) for name in columns})
        parts = {
            coordinates_in_words(coordinates): rows.set_index("force_N")[list(columns)].rename(
                columns=columns
            )
            for coordinates, rows in nodes.groupby("coordinates", sort=False)
        }
        if not parts:
            return ""
        return table(
            _side_by_side(parts),
            "Peaks of the node-to-node joint",
            ["Response divided by force. A dash stands where the branch broke off."],
        )

    def _published_times(self, joint: str) -> str:
        """Times of a joint beside those that the source printed, in the source's arrangement."""
        if not self.in_source or self.times is None or "source_table" not in self.times[1]:
            return ""
        mine = those(self.times[1], joint=joint).dropna(subset="source_table")
        body = ""
        for printed, rows in mine.groupby("source_table", sort=False):
            parts = {
                coordinates_in_words(coordinates): _published_beside_ours(
                    some.set_index("force_N"), (joint, coordinates) == REFERENCE
                )
                for coordinates, some in rows.groupby("coordinates", sort=False)
            }
            body += table(
                _side_by_side(parts),
                f"Solution times: {joint_in_words(joint)}",
                [
                    "Processor time with forward differences, as in the source, and its reduction "
                    "against the node-to-node joint in linear modes. The seconds are of different "
                    "machines and programs; the reductions can be compared.",
                    source("Table", [str(printed)]),
                ],
                anchor=f"table-{printed}-{self.family}",
            )
        return body


def _published_beside_ours(times: pd.DataFrame, is_reference: bool) -> pd.DataFrame:
    columns = {}
    if times["published_s"].notna().any():
        columns |= {"here_s": times["cpu_forward_difference_s"], "source_s": times["published_s"]}
    if not is_reference:
        columns |= {
            "reduction_here_percent": times["reduction_forward_difference_percent"],
            "reduction_in_source_percent": times["published_reduction_percent"],
        }
    return pd.DataFrame(columns)


def _side_by_side(parts: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Tables over force beside each other, each under its name."""
    frame = pd.concat(parts, axis=1)
    frame.insert(0, ("", "force_N"), frame.index)
    return frame


def _broken_off(rows: pd.DataFrame) -> str:
    lost = rows[~rows["complete"]]
    if lost.empty:
        return ""
    reasons = "; ".join(lost["reason"].dropna().unique())
    return f" Broken off at {_forces(lost)} N{f': {html.escape(reasons)}' if reasons else ''}."


def _folded(rows: pd.DataFrame) -> str:
    """Where there are several solutions at one frequency."""
    folded = rows[rows["turning_points"] > 0]
    if folded.empty:
        return ""
    each = ", ".join(
        f"at {one.force_N:g} N between {one.folded_from_Hz:.2f} and {one.folded_to_Hz:.2f} Hz "
        f"({one.turning_points} turning points)"
        for one in folded.itertuples()
    )
    return (
        f" Several solutions belong to one frequency {each}: sweeps up and down the frequency show "
        "different ones."
    )


def _doubtful(rows: pd.DataFrame) -> str:
    """Where the balance in all linear modes says that a response is wrong."""
    said = ""
    instead = rows[rows["fell_back"]]
    if not instead.empty:
        said += f" At {_forces(instead)} N the response in linear modes stands in its place."
    wrong = rows[rows["wrong"]]
    if not wrong.empty:
        worst = number(wrong["estimated_largest_error_percent"].max(), 2)
        said += (
            f" <strong>The response to {_forces(wrong)} N is wrong</strong>: by the balance in all "
            f"linear modes it is off by up to {worst} % of the peak"
        )
        at_peak = wrong["estimated_peak_error_percent"].max()
        said += "." if pd.isna(at_peak) else f", the peak by up to {number(at_peak, 2)} %."
    return said


def _forces(rows: pd.DataFrame) -> str:
    return ", ".join(f"{force:g}" for force in rows["force_N"])


def _elements(shown: Shown, frame: pd.DataFrame) -> str:
    notes = ["In the order in which they start to slip."]
    printed: list[str] = []
    if "source_table" in frame:
        printed = frame["source_table"].iloc[0].split(" and ")
        ours, theirs = frame["slip_force_N"].sum(), frame["published_slip_force_N"].sum()
        notes += [
            "Many sets of elements have nearly the same loops, and where the source divides the "
            "contact is not known, so single ratios mean little. What can be compared is the sum "
            f"of the slip forces: {number(ours)} N here, {number(theirs)} N in the source.",
            source("Table", printed),
        ]
        frame = frame.drop(columns="source_table")
    anchor = f"table-{'-'.join(printed)}-{shown.modes}" if printed else shown.anchor
    return table(frame, "Fitted elements", notes, anchor, shown.from_page, groups=["region"])


def _states(shown: Shown, frame: pd.DataFrame) -> str:
    return (
        "<p>Which part of the elements, and of the load that they carry at rest, is in which state "
        "at the peak of each response.</p>\n"
        + table(frame, "Every response", (), shown.anchor, shown.from_page, _GROUPS)
    )


def _harmonic_peaks(shown: Shown, frame: pd.DataFrame) -> str:
    few = frame[frame["harmonics"] == frame["harmonics"].min()]
    said = ""
    if off := errors_in_words(few):
        said = (
            f" With {harmonics_in_words(few)}, as in all other results, it is off by up to {off}."
        )
    return (
        "<p>Peaks of the node-to-node joint with more and more harmonics, each sought anew at its "
        f"own frequency; errors are against the most harmonics with which one was found.{said}</p>"
        "\n" + table(frame, "Peaks by harmonics", (), shown.anchor, shown.from_page, ["force_N"])
    )


def _harmonics(shown: Shown, frame: pd.DataFrame) -> str:
    if frame.empty:
        return "<p>There is no response to march in time.</p>\n"
    largest = frame.groupby("harmonics")["difference_percent"].agg(lambda d: d.abs().max())
    highest = largest.index.max()
    return (
        "<p>The node-to-node joint marched in time to its steady state at the frequency of each "
        "peak, by code that shares nothing with the solver, and balanced with more and more "
        f"harmonics. With {highest} harmonics the two differ by at most "
        f"{largest[highest]:.2g} %; the one harmonic of all other results is off by up to "
        f"{largest[largest.index.min()]:.3g} %, at frequencies near resonance. Damping is viscous, "
        "of the same loss in the first harmonic.</p>\n"
        + table(frame, "First harmonic of the response", (), shown.anchor, shown.from_page)
    )


def _fits(shown: Shown, frame: pd.DataFrame) -> str:
    frame = frame.assign(joint=frame["joint"].map(joint_in_words))
    return (
        "<p>What the elements of all regions cost to find, and how near they come. The cost is "
        "that of the source (eq. 3.3), the squared force difference over three loops, which "
        "harmonic fits do not minimise. Errors of the loops are those at any amplitude up to full "
        "slip, the largest of all regions, over the slip force; those of peaks are against the "
        "same regions with all their elements, the largest over all forces.</p>\n"
        + table(frame, "Fits of elements", (), shown.anchor, shown.from_page)
    )


def _accuracy(shown: Shown, frame: pd.DataFrame) -> str:
    rows = []
    for key, some in frame.groupby(_GROUPS, sort=False):
        row = dict(zip(_GROUPS, key, strict=True))
        row["branches_solved"] = f"{int(some['complete'].sum())} of {len(some)}"
        row["branches_folded"] = int((some["turning_points"] > 0).sum())
        for column in (
            "peak_frequency_error_percent",
            "peak_amplitude_error_percent",
            "curve_error_dB",
            "estimated_peak_error_percent",
            "residual",
            "energy_error",
        ):
            row[f"largest_{column.removeprefix('estimated_')}"] = some[column].abs().max()
        if "residual_in_time" in some:
            row["residual_in_time"] = in_time(some["residual_in_time"].max())
        rows.append(row)
    if "residual_in_time" in frame:
        frame = frame.assign(residual_in_time=frame["residual_in_time"].map(in_time))
    return (
        "<p>Every response against that of the node-to-node joint in linear modes: its peak, and "
        "the whole curve by the root-mean-square distance in decibels (1 dB is 12 %). A branch "
        "that broke off has no errors. Errors are estimated without any reference, too, by one "
        "correction of each solution in all linear modes: at the peak, and the largest anywhere "
        "over the peak's amplitude. The residual is what is left of the balance in all linear "
        "modes over the force, and the energy error what of the excitation's work over a period "
        "structure and friction do not take: in linear modes nothing but the solver's tolerance is "
        "left of them, in one mode they tell how far the solution is from balance. The residual in "
        "time is what is left of the equations, relative to their largest term, when friction is "
        "marched in time by code that shares nothing with the solver, and worst where the table "
        "says; below 10⁻⁶ it is the march that errs.</p>\n"
        + table(pd.DataFrame(rows), "Largest errors over all forces", groups=_GROUPS[:2])
        + table(frame, "Every response", (), shown.anchor, shown.from_page, _GROUPS)
    )


def _times(shown: Shown, frame: pd.DataFrame, drawn: str) -> str:
    return (
        "<p>Median processor time of one frequency response on one thread, with the analytic "
        "Jacobian and with forward differences as in the source. Regions alone leave every element "
        "in place; few elements replace them. One response-dependent mode "
        "saves evaluations where the Jacobian is taken by differences, and costs a renewal of the "
        "mode where it is exact.</p>\n"
        + drawn
        + table(frame, "Every response", (), shown.anchor, shown.from_page, _GROUPS)
    )
