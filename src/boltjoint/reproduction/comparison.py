"""A study beside the thesis: what its tables, figures and pages ask of the source, in words."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
from markupsafe import Markup

from boltjoint.config.bolts import MATERIAL_WORDS
from boltjoint.friction.declarations import DECLARATIONS
from boltjoint.number_format import number
from boltjoint.report.comparison import Beside, BesideElements, Comparison
from boltjoint.reproduction.published import BASIS, Published
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.tables.html import template_environment

if TYPE_CHECKING:
    from boltjoint.study.artefact_list import Artefact


_TEMPLATES = template_environment(Path(__file__).parent / "templates")


#: fields by which a figure is found among the published ones, by its kind
_FIELDS = {
    **dict.fromkeys(("regions", "weighted_pairs", "loops"), ("joint",)),
    **dict.fromkeys(("response", "states"), ("joint", "coordinates", "resonance")),
    **dict.fromkeys(("mesh", "modes", "all_modes", "initial_gap"), ("assembly",)),
    **dict.fromkeys(("contact", "deformation"), ("assembly", "preload_N")),
}


def thesis() -> Any:  # noqa: ANN401
    """The macros of the template about the source, each of which returns HTML."""
    return _TEMPLATES.get_template("thesis.html.j2").module


def numbers_in_source(what: str, numbers: Sequence[str]) -> Markup:
    """The paragraph of a caption with the numbers that the source gives the same; may be empty.

    >>> print(numbers_in_source("Figure", ["3.3", "3.4", "3.44"]))
    <span class="source">Figures 3.3, 3.4 and 3.44</span> of the source
    >>> print(numbers_in_source("Figure", ["3.46", "3.47", "3.48", "3.49"]))
    <span class="source">Figures 3.46 to 3.49</span> of the source
    """
    return thesis().numbered(what, list(numbers)) if numbers else Markup()


def numbers_of_figures(artefact: Artefact, published: Published) -> list[str]:
    """Numbers of the source's figures that show the same, in its one basis."""
    fields = _FIELDS.get(artefact.kind, ())
    if artefact.form != "figure" or artefact.basis not in (None, BASIS) or not fields:
        return []
    values = {name: getattr(artefact, name) for name in fields}
    return list(published.figures_of(artefact.kind, **values)["figure"])


def _runs(numbers: Sequence[str]) -> str:
    """Numbers such as 3.46 in a sentence, three or more that follow each other as a range."""
    runs: list[list[str]] = []
    for one in numbers:
        if runs and int(one.split(".")[1]) == int(runs[-1][-1].split(".")[1]) + 1:
            runs[-1].append(one)
        else:
            runs.append([one])
    parts = [part for run in runs for part in (run if len(run) < 3 else [f"{run[0]} to {run[-1]}"])]
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


_TEMPLATES.filters |= {"runs": _runs, "number": number}


#: columns beside those called ``published_...`` that hold or compare published values
_COMPARISONS = ("source_table", "k_ratio", "slip_force_ratio", "difference_points")


def frequencies_beside(table: pd.DataFrame, published: Published) -> pd.DataFrame:
    """Natural frequencies beside the published ones, by assembly and bending mode.

    Parameters
    ----------
    table
        As ``tabulate_frequencies`` returns it.
    published
        The published tables; without any there are no columns for them.
    """
    if published.is_empty:
        return table
    printed = published.natural_frequencies().rename(columns={"frequency_Hz": "published_Hz"})
    table = table.merge(printed, how="left", on=["assembly", "bending_mode"])
    table["difference_percent"] = 100 * (table["frequency_Hz"] / table["published_Hz"] - 1)
    return table


def contact_beside(table: pd.DataFrame, published: Published) -> pd.DataFrame:
    """Numbers of pairs and of loaded pairs beside those of published friction elements.

    Parameters
    ----------
    table
        As ``tabulate_contact`` returns it.
    published
        The published tables; without any there are no columns for them.
    """
    if published.is_empty:
        return table
    printed = published.contact_nodes().set_index(["assembly", "contact_law"])["contact_nodes"]
    table = table.copy()
    for law, column in (("variable", "pairs"), ("constant", "loaded_pairs")):
        numbers = [printed.get((assembly, law)) for assembly in table["assembly"]]
        table.insert(int(table.columns.get_loc(column)) + 1, f"published_{column}", numbers)
    return table


def elements_beside(table: pd.DataFrame, joint: str, published: Published) -> pd.DataFrame:
    """Fitted elements beside the published ones, both in the order in which they slip.

    The source takes normal stiffnesses equal to the tangential ones.

    Parameters
    ----------
    table
        As ``tabulate_elements`` returns it.
    joint
        Name of the joint, ``regions=N/elements=M``.
    published
        The published tables.
    """
    printed = published.parameters(joint)
    if printed.empty:
        return table
    # imported here: other tables need no joints
    from boltjoint.study.tables.joints import in_order_of_slip

    theirs = in_order_of_slip(
        printed["joint"].to_numpy(),
        {"k_kN_per_mm": printed["k_kN_per_mm"], "slip_force_N": printed["mu_n_N"]},
    ).rename(columns={name: f"published_{name}" for name in ("k_kN_per_mm", "slip_force_N")})
    table = table.merge(theirs, how="left", on=["region", "element"])
    table["k_ratio"] = table["k_kN_per_mm"] / table["published_k_kN_per_mm"]
    table["slip_force_ratio"] = table["slip_force_N"] / table["published_slip_force_N"]
    return table.assign(source_table=printed["source_table"].iloc[0])


def times_beside(table: pd.DataFrame, published: Published) -> pd.DataFrame:
    """Solution times beside the published ones, which are about the first resonance.

    Parameters
    ----------
    table
        As ``tabulate_times`` returns it.
    published
        The published tables; without a case study there are no columns for them.
    """
    if published.case is None:
        return table
    printed = published.time_reductions().assign(resonance=1)
    on = ["joint", "coordinates", "resonance", "force_N"]
    table = table.merge(printed, how="left", on=on)
    table["difference_points"] = (
        table["reduction_forward_difference_percent"] - table["published_reduction_percent"]
    )
    return table


def without_published(table: pd.DataFrame) -> pd.DataFrame:
    """A table without columns of published values and of comparisons with them."""
    published = [column for column in table if column.startswith("published_")]
    return table.drop(columns=[*published, *_COMPARISONS], errors="ignore")


#: columns of the source's table of cases, by the keys of a case
_COLUMNS = {
    "assembly": "assembly",
    "preload_N": "preload_per_bolt_N",
    "law": "contact_law",
    "tangential_stiffness_N_per_m": "k_u_kN_per_mm",
    "normal_stiffness_N_per_m": "k_v_kN_per_mm",
    "friction_coefficient": "mu",
    "friction_elements": "contact_nodes",
    "forces_N": "forces_N",
    "regions": "regions",
    "elements": "elements_per_region",
}

#: values of the source that stand in none of its tables, by quantity
_STATED = {
    "basis": "the first four bending modes",
    "friction forces": "–",
    "harmonics of the response": "–",
    "motion of a region": "mean of its pairs",
}
_DIVISIONS = {"constant": "similar loads", "variable": "by the load along the middle"}

#: keys of a case without which it is another joint than that of the source
_OF_JOINT = (
    *("assembly", "preload_N", "law", "friction_coefficient"),
    *("tangential_stiffness_N_per_m", "normal_stiffness_N_per_m"),
)


def _differs(value: str, printed: str) -> bool:
    """Whether a quantity is not that which the source prints, if it does."""
    try:
        return abs(float(value) - float(printed)) > _SAME * abs(float(printed))
    except ValueError:
        return bool(printed) and value != printed


#: what sets published values beside those of a table, by its kind
_TABLES = {
    "natural_frequencies": frequencies_beside,
    "contact": contact_beside,
    "times": times_beside,
}

#: difference of preloads, relative, by which one was computed from the other
_SAME = 1e-3


class ThesisComparison(Comparison):
    """A study that is compared with the thesis.

    Parameters
    ----------
    published
        The published tables, of a case study or of none.
    """

    def __init__(self, published: Published) -> None:
        self.published = published

    @classmethod
    def among(cls, paths: Iterable[str], case: str | None = None) -> Comparison:
        """With the published tables among some files; where they are not, with no source.

        Parameters
        ----------
        paths
            The files that may be read.
        case
            Name of a case study of the source, of which tables and pages are.
        """
        published = Published.among(map(str, paths), case)
        return Comparison() if published.is_empty else cls(published)

    @property
    def is_empty(self) -> bool:
        """False: there is a source."""
        return self.published.is_empty

    @property
    def has_case(self) -> bool:
        """Whether the case at hand is compared with a case study."""
        return self.published.case is not None

    @property
    def reductions_of_time(self) -> tuple[str, str] | None:
        """Name and column of the published reductions, where the case is compared."""
        return ("published", "published_reduction_percent") if self.has_case else None

    def words(self, place: str) -> Markup:
        """What is said of the source at a place of a page: a macro of the template."""
        return getattr(thesis(), place)(self.published)

    def same_figures(self, artefact: "Artefact") -> Markup:
        """The paragraph of a caption with the numbers of the same figures of the source."""
        return numbers_in_source("Figure", numbers_of_figures(artefact, self.published))

    def region_of_loops(self, joint: str) -> int:
        """The region whose hysteresis loops the source shows; the first where it shows none."""
        return self.published.region_of_loops(joint)

    def beside(self, artefact: "Artefact", table: pd.DataFrame) -> pd.DataFrame:
        """A table of the study with published values beside its own."""
        if artefact.kind == "elements":
            return elements_beside(table, str(artefact.joint), self.published)
        return _TABLES[artefact.kind](table, self.published)

    def on_page(self, basis: str, table: pd.DataFrame) -> pd.DataFrame:
        """A table without published values, unless the source has the basis."""
        return table if basis == BASIS else without_published(table)

    def configuration(self, quantities: Iterable[tuple[str, str, str | None]]) -> Beside:
        """The column of the source beside the configuration of a case.

        Parameters
        ----------
        quantities
            Words, value and key of each quantity of the case.
        """
        quantities = list(quantities)
        facts = self.published.case_study()
        columns: dict[str, list[str]] = {}
        if facts:
            printed = {key: value.replace(" ", ", ") for key, value in facts.items()}
            law = facts["contact_law"]
            printed["contact_law"] = DECLARATIONS[law].label if law in DECLARATIONS else law
            stated = _STATED | {"division into regions": _DIVISIONS.get(law, "not given")}
            columns["in the source"] = [
                stated.get(quantity) or printed.get(_COLUMNS.get(key or "", "")) or "not given"
                for quantity, _, key in quantities
            ]
        tables = self.published.tables()
        is_of_case = (tables["case"] == (self.published.case or "")) & (
            tables["kind"] == "stiffness"
        )
        notes = [numbers_in_source("Table", list(tables["table"][is_of_case]))]
        implied = self.published.implied_preload()
        statement = thesis().implied_preload(facts, implied) if implied else Markup()
        others = [
            (words, value, printed[_COLUMNS[key]])
            for words, value, key in quantities
            if facts and key in _OF_JOINT and _differs(value, printed[_COLUMNS[key]])
        ]
        if others:
            statement = thesis().another_joint(others) + statement
        return Beside(columns, notes, statement)

    def dimensions(self, assemblies: Iterable[str]) -> Beside:
        """The printed material beside the dimensions of assemblies, where they are the source's."""
        names = [name for name in assemblies if name in self.published.assemblies]
        if not names:
            return Beside()
        material = {
            MATERIAL_WORDS[key]: number(value) for key, value in self.published.material().items()
        }
        notes = [thesis().dimensions(" and ".join(names)), numbers_in_source("Table", ["3.1"])]
        return Beside({"in the source": material}, notes)

    def note(self, kind: str, table: pd.DataFrame) -> str:
        """How near frequencies are to the published ones, and what published pairs are."""
        if kind == "natural_frequencies":
            differences = table.get("difference_percent", pd.Series(dtype=float))
            largest = differences.abs().max()
            return (
                "" if pd.isna(largest) else f"Within {largest:.2f} % of the published frequencies."
            )
        is_published = table.get("published_pairs", pd.Series(dtype=float)).notna().any()
        return thesis().pairs() if is_published else ""

    def elements(self, artefact: "Artefact", table: pd.DataFrame, preload: float) -> BesideElements:
        """Fitted elements beside the published ones, and the sums of both."""
        frame = self.on_page(str(artefact.basis), table)
        if "source_table" not in frame:
            return BesideElements(frame)
        printed = frame["source_table"].iloc[0].split(" and ")
        sums = [
            (frame[name].sum(), frame[f"published_{name}"].sum())
            for name in ("k_kN_per_mm", "slip_force_N")
        ]
        implied = self.published.implied_preload()
        is_circular = implied is not None and abs(preload / implied - 1) < _SAME
        return BesideElements(
            frame.drop(columns="source_table"),
            [thesis().sums(*sums, is_circular), numbers_in_source("Table", printed)],
            f"table-{'-'.join(printed)}-{artefact.basis}",
        )
