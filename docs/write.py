"""Write the pages of this folder that quote results: ``make docs``.

They quote those of ``make reproduce STUDY=config/convergence.yaml``, or of another study:
``python docs/write.py --study config/short.yaml accuracy``. ``README`` stands for its figure.

A template that quotes a result names table, row and column, or the quantity computed from results.
"""

import argparse
import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import jinja2
import numpy as np
import pandas as pd
import sweeps

from boltjoint.config.study import Study, load_study
from boltjoint.joint.io import load_joint
from boltjoint.names import Basis
from boltjoint.report.pages import accuracy

HERE = Path(__file__).parent
RESULTS = HERE.parent / "results"
#: figures by the page that goes with their results; that of the README has a shorter name here
FIGURES = {
    "README": ("response_three_bolt_constant_enriched-40_node-to-node_linear_resonance=1",),
    "accuracy": ("reductions", "sampling"),
    "sweeps": (
        "sweep_peaks_three_bolt_variable_three_bolt_uncertainty",
        "sweep_backbones_three_bolt_constant_three_bolt_loosened",
        "sweep_backbones_three_bolt_constant_three_bolt_pitch_and_lap",
    ),
}
SHORTER = {FIGURES["README"][0]: "response"}


class Tables:
    """The tables of a finished study, by the values that select a row."""

    def __init__(self, study: Study) -> None:
        self.study = study

    def rows(self, table: str, **which: object) -> pd.DataFrame:
        """All rows of a table whose columns have these values."""
        found = pd.read_csv(RESULTS / f"tables/{table}.csv")
        for column, value in which.items():
            found = found[found[column] == value]
        if found.empty:
            raise LookupError(f"{table}.csv has no row with {which}")
        return found

    def value(self, table: str, column: str, **which: object) -> object:
        """The value in the one row of a table with these values."""
        found = self.rows(table, **which)
        if len(found) != 1:
            raise LookupError(f"{table}.csv has {len(found)} rows with {which}")
        return found[column].iloc[0]

    def accuracy(self, case: str, joint: str, coordinates: str, force: float, column: str) -> float:
        """A value of a response around the first resonance."""
        which = {"joint": joint, "coordinates": coordinates, "resonance": 1, "force_N": force}
        return self.value(f"accuracy_{case}_free-4", column, **which)

    def converged(self, case: str, force: float, column: str) -> float:
        """A value of the converged peak of all pairs in 40 vectors around the first resonance."""
        which = {"joint": "node-to-node", "coordinates": "linear", "resonance": 1, "force_N": force}
        return self.value(f"accuracy_{case}_enriched-40", f"converged_{column}", **which)

    def model_error(self, case: str, force: float, column: str) -> float:
        """Error of a peak of the source's model against the converged one [%]."""
        peak = self.accuracy(case, "node-to-node", "linear", force, column)
        return 100 * (peak / self.converged(case, force, column) - 1)

    def largest(self, case: str, joint: str, coordinates: str, column: str) -> float:
        """The value of a column that is farthest from zero, over all forces and resonances."""
        found = self.rows(f"accuracy_{case}_free-4", joint=joint, coordinates=coordinates)[column]
        return found[found.abs().idxmax()]

    def broken(self, case: str, coordinates: str) -> str:
        """How many branches broke off, of how many."""
        found = self.rows(f"accuracy_{case}_free-4", coordinates=coordinates)["complete"]
        return f"{(~found).sum()} of {found.size}"

    def lagged_broken(self, case: str) -> str:
        """How many paths of one mode with a lagged basis, of all pairs, broke off, of how many."""
        which = {"joint": "node-to-node", "coordinates": "rdnm-1", "resonance": 1}
        timed = self.rows(f"times_{case}_free-4", **which).dropna(subset="cpu_forward_difference_s")
        return f"{(~timed['complete_forward_difference']).sum()} of {len(timed)}"

    def state(self, case: str, coordinates: str, force: float, state: str) -> float:
        """Share of a contact state at the first peak of the node-to-node joint [%]."""
        which = {"coordinates": coordinates, "resonance": 1, "force_N": force}
        column = f"elements_in_{state}_percent"
        return self.value(f"states_{case}_free-4", column, joint="node-to-node", **which)

    def saving(self, case: str, joint: str, coordinates: str, jacobian: str) -> float:
        """Median reduction of the processor time around the first resonance [%].

        A published one is over the forces at which no path breaks off here.
        """
        columns = {
            "analytic": "reduction_percent",
            "forward-difference": "reduction_forward_difference_percent",
            "published": "published_reduction_percent",
        }
        which = {"joint": joint, "coordinates": coordinates, "resonance": 1}
        times = self.rows(f"times_{case}_free-4", **which)
        if jacobian == "published":
            times = times.dropna(subset=columns["forward-difference"])
        return times[columns[jacobian]].median()

    def cases(self, kind: str) -> list[str]:
        """The cases that have a table of a kind; at least one must, unless it holds times."""
        found = [case for case in self.study.cases if self._path(kind, case).exists()]
        # a study may leave out the timing
        if not found and kind != "models":
            raise LookupError(f"no {kind}_*.csv: make reproduce STUDY=config/convergence.yaml")
        return found

    def models(self, case: str) -> list[dict[str, object]]:
        """Largest errors and cost of every model of a case."""
        return accuracy.summary(pd.read_csv(self._path("models", case))).to_dict("records")

    def apart(self, what: str, **model: str) -> float:
        """Largest difference [%] of a model's peak in the converged basis from the full one's."""
        found = self._of_converged_basis(**model)
        full = self._of_converged_basis(joint="node-to-node", coordinates="linear")
        ratio = (100 + found) / (100 + full)
        return 100 * (ratio[f"peak_{what}_error_percent"] - 1).abs().max()

    def cost(self, **model: str) -> str:
        """Least and most time [s] of a model in the converged basis, of any case."""
        times = self._of_converged_basis(**model)["cpu_s"].groupby("case").sum()
        return " to ".join(_digits(time, 2) for time in (times.min(), times.max()))

    def _of_converged_basis(self, **model: str) -> pd.DataFrame:
        """The rows of a model in the converged basis, by case and force."""
        found = self._of_cases("models")
        for column, value in {"modes": "enriched-40", **model}.items():
            found = found[found[column] == value]
        columns = ["peak_frequency_error_percent", "peak_amplitude_error_percent", "cpu_s"]
        return found.set_index(["case", "force_N"])[columns]

    def harmonics(self, case: str) -> pd.DataFrame:
        """Error of the first harmonic [%] by force and number of harmonics."""
        frame = pd.read_csv(self._path("harmonics", case))
        return frame.pivot_table(index="force_N", columns="harmonics", values="difference_percent")

    def harmonic_peaks(self, case: str) -> pd.DataFrame:
        """Errors of frequency and amplitude [%], as text, by force and number of harmonics."""
        frame = pd.read_csv(self._path("harmonic_peaks", case))
        errors = frame[["peak_frequency_error_percent", "peak_amplitude_error_percent"]]
        errors = errors.round(5) + 0.0  # below that is the tolerance of the solver
        frame["errors"] = errors.apply(
            lambda row: "–" if row.isna().any() else " / ".join(_digits(e, 2) for e in row), axis=1
        )
        by_force = frame.pivot(index="force_N", columns="harmonics", values="errors")  # noqa: PD010
        return by_force.fillna("–")

    def one_harmonic(self, what: str, sign: int) -> float:
        """The largest error of this sign of a peak [%] with one harmonic, of any case and force."""
        found = self._of_cases("harmonic_peaks")
        errors = found[found["harmonics"] == 1][f"peak_{what}_error_percent"]
        return abs((sign * errors).max())

    def superharmonics(self) -> list[dict[str, object]]:
        """Cases and forces [N] of peaks at which a harmonic is in resonance, and which one."""
        return self._of_cases("harmonic_peaks").dropna(subset="superharmonic").to_dict("records")

    def steady_states(self) -> list[dict[str, object]]:
        """Differences from time integration [%] of converged peaks, by case and force."""
        rows = []
        for (case, _), found in self._of_cases("steady_states").groupby(["case", "force_N"]):
            first, last = found.iloc[0], found.iloc[-1]
            most = {
                "most_harmonics": last["harmonics"],
                "difference_of_most_percent": last["difference_percent"],
            }
            rows.append({"case": case, **first, **most})
        return rows

    def most_harmonics_in_time(self) -> float:
        """Largest difference from time integration [%] with the most harmonics tried."""
        return max(abs(row["difference_of_most_percent"]) for row in self.steady_states())

    def larger_basis(self) -> list[dict[str, object]]:
        """Errors of peaks against a larger basis [%], with one harmonic and the most."""
        rows = []
        for (case, _), found in self._of_cases("larger_basis").groupby(["case", "force_N"]):
            one = found.iloc[0].filter(like="error").add_suffix("_of_one")
            rows.append({"case": case, **found.iloc[-1], **one})
        return rows

    def in_larger_basis(self, what: str, law: str | None = None) -> float:
        """Largest error against a larger basis [%] with the most harmonics, of cases of a law."""
        laws = {name: case.contact.law for name, case in self.study.cases.items()}
        found = [row for row in self.larger_basis() if law in (None, laws[row["case"]])]
        return max(abs(row[f"peak_{what}_error_percent"]) for row in found)

    def steps(self) -> str:
        """Steps a period of the coarser and of the finer time integration."""
        (steps,) = self._of_cases("steady_states")["steps_per_period"].unique()
        return f"{steps // 2} and {steps}"

    def _of_cases(self, kind: str) -> pd.DataFrame:
        """The tables of a kind of all cases that have one, one after another."""
        tables = ((case, pd.read_csv(self._path(kind, case))) for case in self.cases(kind))
        return pd.concat(frame.assign(case=case) for case, frame in tables)

    def assemblies(self) -> list[str]:
        """The assemblies whose resonances are compared with the full model."""
        return [name for name in self.study.assemblies if self._path("patterns", name).exists()]

    def patterns(self, assembly: str) -> pd.DataFrame:
        """Largest error of a resonance [%] by basis, and by springs and resonance."""
        frame = pd.read_csv(self._path("patterns", assembly))
        keys = {"index": "basis", "columns": ["springs", "resonance"], "values": "error_percent"}
        return frame.pivot_table(**keys, aggfunc="max", sort=False)

    def bases(self, case: str) -> pd.DataFrame:
        """Largest errors of the peaks [%] by basis."""
        return accuracy.largest(pd.read_csv(self._path("bases", case)), ["basis"])

    def doubled(self, basis: str, what: str, least_force: float = 0.0) -> float:
        """Largest change of a peak of any case, from a force [N] on, in the largest basis [%]."""
        found = self._of_cases("bases")
        found = found[(found["basis"] == basis) & (found["force_N"] >= least_force)]
        return found[f"peak_{what}_error_percent"].abs().max()

    def divisions(self, case: str) -> pd.DataFrame:
        """Largest errors of frequency and amplitude [%], as text, by division and number."""
        found = accuracy.largest(
            pd.read_csv(self._path("divisions", case)), ["division", "motion", "regions"]
        )
        texts = found.apply(lambda errors: " / ".join(_digits(e, 2) for e in errors), axis=1)
        return texts.unstack(fill_value="–")  # noqa: PD010 - texts cannot be aggregated

    def reductions(self) -> pd.DataFrame:
        """Largest errors of frequency and amplitude [%] and time [s], by joint and case."""
        found, joints = {}, {}
        for case in self.cases("reductions"):
            frame = pd.read_csv(self._path("reductions", case))
            largest = accuracy.largest(frame, ["joint"])
            by_joint = frame.groupby("joint", sort=False)
            largest["cpu_s"] = by_joint["cpu_s"].sum()
            texts = largest.apply(
                lambda row: " / ".join(_digits(value, 2) for value in row), axis=1
            )
            lost = by_joint["peak_mm_per_N"].apply(lambda peaks: peaks.isna().sum())
            found[case] = texts + lost.map(lambda count: f" ({count} lost)" if count else "")
            joints = dict.fromkeys([*joints, *frame["joint"]])
        return pd.DataFrame(found).reindex(list(joints)).fillna("–")

    def lost(self, case: str) -> str:
        """How many of the peaks of regions were not found, and at which forces [N]; or nothing."""
        frame = pd.read_csv(self._path("divisions", case))
        found = frame[frame["peak_mm_per_N"].isna()]
        if found.empty:
            return ""
        forces = ", ".join(f"{force:g}" for force in found["force_N"].unique())
        return (
            f"{len(found)} of {len(frame)} peaks, at {forces} N, were not found and do not count."
        )

    def fits(self) -> list[dict[str, object]]:
        """Cost of fitted elements and their errors against their regions, in all cases."""
        parts = []
        for case in self.study.cases:
            for path in sorted(RESULTS.glob(f"tables/fits_{case}_*-*.csv"), reverse=True):
                basis = path.stem.removeprefix(f"fits_{case}_")
                if re.fullmatch(Basis.PATTERN, basis):
                    parts.append(pd.read_csv(path).assign(case=case, basis=basis))
        return pd.concat(parts).to_dict("records")

    @staticmethod
    def _path(kind: str, subject: str) -> Path:
        bases = {"harmonics": "_free-4"} | dict.fromkeys(
            ("divisions", "harmonic_peaks", "larger_basis", "reductions", "steady_states"),
            "_enriched-40",
        )
        basis = bases.get(kind, "")
        return RESULTS / f"tables/{kind}_{subject}{basis}.csv"

    def stuck_error_of_loaded_means(self, case: str, regions: str) -> float:
        """Error of the first stuck frequency [%] if regions moved as the mean of loaded pairs."""
        folder = RESULTS / f"cases/{case}/free-4"
        nodes, divided = (
            load_joint(folder / name / "joint.nc") for name in ("node-to-node", regions)
        )
        loaded = nodes.law.slip_force > 0
        region = divided.law.point_of_element
        size = np.bincount(region, loaded)[region, None]
        means = [
            np.stack([np.bincount(region, column) for column in (row * loaded[:, None] / size).T]).T
            for row in nodes.rows
        ]
        by_loaded = replace(divided, tangential_mode=means[0], normal_mode=means[1])
        L = np.diag((2 * np.pi * nodes.natural_frequency) ** 2)
        whole, reduced = (
            np.sqrt(np.linalg.eigvalsh(L + one.stuck_stiffness())[0]) for one in (nodes, by_loaded)
        )
        return 100 * (reduced / whole - 1)


def _digits(value: float, digits: int) -> str:
    """Significant digits; never fewer than those before the point, and no powers of ten."""
    text = format(value, f".{digits}g")
    return format(value, ".0f") if "e+" in text else text


def _formatted(form: str, value: float, digits: int) -> str:
    if pd.isna(value):
        raise ValueError("a page quotes a value that the study does not have")
    return format(value, form.format(digits)) if form else _digits(value, digits)


def write(study: str, pages: Sequence[str] = ()) -> None:
    """Fill the templates of some pages, or of all, and copy the figures that they show."""
    tables = Tables(load_study(HERE.parent, {"study": study}))
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
    )
    for name, form in (("digits", ""), ("places", ".{}f"), ("signed", "+.{}f")):
        environment.filters[name] = partial(_formatted, form)
    environment.filters["digits_or_dash"] = lambda value, digits: (
        "–" if pd.isna(value) else _digits(value, digits)
    )
    for template in sorted(HERE.glob("*.md.j2")):
        if pages and template.name.removesuffix(".md.j2") not in pages:
            continue
        text = environment.get_template(template.name).render(t=tables, sweeps=sweeps)
        template.with_suffix("").write_text(text, encoding="utf-8")
    (HERE / "figures").mkdir(exist_ok=True)
    for page in pages or FIGURES:
        for name in FIGURES.get(page, ()):
            copied = HERE / f"figures/{SHORTER.get(name, name)}.svg"
            shutil.copy(RESULTS / f"figures/{name}.svg", copied)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the pages that quote results.")
    parser.add_argument("pages", nargs="*")
    parser.add_argument("--study", default="config/convergence.yaml")
    arguments = parser.parse_args()
    write(arguments.study, arguments.pages)
