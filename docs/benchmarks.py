"""Write the page of benchmarks, its figure and its table, and name regressions: ``make benchmark``.

Times are compared with those of the last table over the time of one loop of the same run, the
yardstick: so machines of different speed can be compared, roughly.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from boltjoint.report.figures.style import REGION_COLOURS, figure_style, save_figure

HERE = Path(__file__).parent
MEASURED = HERE.parent / "results/benchmarks/speed.json"
PAGE, TABLE, FIGURE = HERE / "benchmarks.md", HERE / "benchmarks.csv", HERE / "figures/growth.svg"

#: the benchmark by whose time all others are divided
YARDSTICK = "response three_bolt_constant free-4 node-to-node, 10 N: least work"
#: slower by this factor is a regression, if the spread of the times is not as large
REGRESSION = 1.3
#: growth is fitted from here on: below, what does not grow counts
FIRST_FITTED = {"elements": 1000, "vectors": 8, "forces": 4}
AXES = {
    "elements": "elements",
    "vectors": "vectors of the basis",
    "forces": "forces",
}


def measured() -> tuple[pd.DataFrame, dict[str, object]]:
    """A row for each benchmark of the last run, and the machine."""
    run = json.loads(MEASURED.read_text(encoding="utf-8"))
    table = pd.DataFrame([each["extra_info"] for each in run["benchmarks"]])
    table.insert(0, "benchmark", [_name(row) for row in table.to_dict("records")])
    yardstick = table.set_index("benchmark")["processor_s"][YARDSTICK]
    table["relative"] = table["processor_s"] / yardstick
    return table, run["machine_info"]


def _name(row: dict[str, object]) -> str:
    kind = row["kind"]
    if kind == "stage":
        return f"stage {row['stage']}"
    if kind == "growth":
        return f"growth {row['what']}: {row['number']:g} {row['by']}"
    of_joint = f"{kind} {row['case']} {row['basis']} {row['joint']}"
    return of_joint if kind == "backbone" else f"{of_joint}, {row['force_N']:g} N: {row['solver']}"


def regressions(new: pd.DataFrame, old: pd.DataFrame) -> pd.DataFrame:
    """Benchmarks that are slower than in the last table by more than they scatter."""
    both = new.merge(old, on="benchmark", suffixes=("", "_before"))
    both["factor"] = both["relative"] / both["relative_before"]
    limit = REGRESSION + 2 * both[["spread", "spread_before"]].fillna(0.0).max(axis=1)
    return both[both["factor"] > limit].sort_values("factor", ascending=False)


def exponents(table: pd.DataFrame) -> pd.DataFrame:
    """Exponent of growth of each curve: the slope in logarithmic axes."""
    rows = []
    for (by, what), curve in table[table["kind"] == "growth"].groupby(["by", "what"], sort=False):
        fitted = curve[curve["number"] >= FIRST_FITTED[by]]
        slope = np.polyfit(np.log(fitted["number"]), np.log(fitted["wall_s"]), 1)[0]
        first, last = fitted["number"].iloc[[0, -1]].astype(int)
        rows.append({"by": by, "what": what, "first": first, "last": last, "exponent": slope})
    return pd.DataFrame(rows)


@figure_style
def plot_growth(table: pd.DataFrame, slopes: pd.DataFrame) -> Figure:
    """Wall time over elements, vectors and forces."""
    figure = Figure(figsize=(11, 3.4), layout="constrained")
    of_curve = slopes.set_index(["by", "what"])["exponent"]
    for axes, (by, label) in zip(figure.subplots(1, 3), AXES.items(), strict=True):
        of_axis = table[(table["kind"] == "growth") & (table["by"] == by)]
        for (what, curve), colour in zip(
            of_axis.groupby("what", sort=False), REGION_COLOURS, strict=False
        ):
            text = f"{what}: exponent {of_curve[by, what]:.2f}"
            style = {"color": colour, "marker": "o", "markersize": 4, "linewidth": 1.1}
            axes.loglog("number", "wall_s", data=curve, label=text, **style)
        _finish(axes, label, of_axis["number"].astype(int).unique())
    return figure


def _finish(axes: Axes, label: str, numbers: np.ndarray) -> None:
    axes.set(xlabel=label, ylabel="wall time (s)")
    if numbers.max() < 1000:
        axes.set_xticks(numbers, numbers)
    axes.xaxis.set_minor_locator(NullLocator())
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * (high / low) ** 0.35)
    axes.legend(loc="upper left", fontsize=8)
    axes.grid(True)


def _responses(table: pd.DataFrame) -> str:
    responses = table[table["kind"] == "response"]
    wide = responses.pivot_table(
        index=["case", "basis", "joint", "elements", "force_N"],
        columns="solver",
        values="processor_s",
        sort=False,
    )
    lines = [
        "| case | basis | joint | elements | force (N) | least work | compiled | ratio | general |"
        " AFT in NumPy | backbone | one complex mode |",
        "|" + "---|" * 12,
    ]
    for index, row in wide.iterrows():
        case, basis, joint, elements, force = index
        solvers = ("least work", "compiled", "general", "aft", "backbone", "complex-rdnm-1")
        times = {name: row.get(name, np.nan) for name in solvers}
        ratio = times["compiled"] / times["least work"]
        cells = [_ms(times["least work"]), _ms(times["compiled"]), _number(ratio)]
        cells += [_ms(times[name]) for name in solvers[2:]]
        lines.append(
            f"| `{case}` | {basis} | `{joint}` | {elements:.0f} | {force:g} | "
            + " | ".join(cells)
            + " |"
        )
    return "\n".join(lines)


def _others(table: pd.DataFrame) -> str:
    lines = ["| | wall time (s) | processor time (s) |", "|---|---|---|"]
    for kind in ("stage", "backbone"):
        for row in table[table["kind"] == kind].to_dict("records"):
            name = row["benchmark"].removeprefix("stage ")
            lines.append(f"| {name} | {row['wall_s']:.3g} | {row['processor_s']:.3g} |")
    return "\n".join(lines)


def _growth(table: pd.DataFrame, slopes: pd.DataFrame) -> str:
    lines = ["| over | what | from | to | exponent |", "|---|---|---|---|---|"]
    lines += [
        f"| {row.by} | {row.what} | {row.first} | {row.last} | {row.exponent:.2f} |"
        for row in slopes.itertuples(index=False)
    ]
    memory = table.dropna(subset=["bytes_per_element"]).groupby("what")["bytes_per_element"].last()
    lines.append("")
    for what, found in memory.items():
        lines.append(f"- {what}: {found:.0f} bytes an element beyond the model.")
    return "\n".join(lines)


def _ms(seconds: float) -> str:
    if np.isnan(seconds):
        return "–"
    return f"{1e3 * seconds:.0f}" if seconds >= 1 else f"{1e3 * seconds:.3g}"


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.2f}"


def page(table: pd.DataFrame, slower: pd.DataFrame, machine: dict[str, object]) -> str:
    """The page."""
    slopes = exponents(table)
    processor = machine["cpu"].get("brand_raw", "unknown processor")
    found = (
        "None."
        if slower.empty
        else "\n".join(
            f"- {row.benchmark}: {row.factor:.2f} times the time" for row in slower.itertuples()
        )
    )
    return f"""# Benchmarks

What the solvers cost, beside the least that they could. Made by `make benchmark` on the joints of
the study ({processor}, one thread unless said otherwise); medians of repeated calls. The
table with their spread and memory is [benchmarks.csv](benchmarks.csv).

## Against the last table

Slower by more than {REGRESSION:g} times, and by more than they scatter, over the time of the
yardstick ({YARDSTICK}):

{found}

## Responses

Processor time of one response, peak located, to 1e-9 [ms]. *Least work* is a compiled loop for one
law with nothing else in it (`benchmarks/least_work.py`): the same window, steps and tolerance, the
transcendental functions of slipping elements, one read of the modal rows, multiply-adds of the
tangent; elements that move and slip alike are there once in both. *Compiled* is `solve_branch`;
*general* the path that complex modes and AFT take, in NumPy; *AFT in NumPy* the field's usual way,
128 samples a period, in the same continuation.

{_responses(table)}

## Stages

{_others(table)}

## Growth

![Growth of cost](figures/growth.svg)

{_growth(table, slopes)}
"""


def main() -> None:
    """Compare with the last table, then write table, figure and page."""
    table, machine = measured()
    slower = regressions(table, pd.read_csv(TABLE)) if TABLE.exists() else table[:0]
    columns = ["benchmark", "wall_s", "processor_s", "spread", "memory_bytes", "relative"]
    table[columns].to_csv(TABLE, index=False, float_format="%.4g")
    save_figure(plot_growth(table, exponents(table)), FIGURE)
    PAGE.write_text(page(table, slower, machine), encoding="utf-8")
    for row in slower.itertuples():
        print(f"slower: {row.benchmark}, {row.factor:.2f} times")


if __name__ == "__main__":
    main()
