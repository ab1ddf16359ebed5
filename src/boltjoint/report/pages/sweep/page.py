"""The interactive page of a sweep: one file that opens without a network."""

import json
import posixpath
import re

import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup

from boltjoint.config.sweep import Sweep
from boltjoint.report.pages.markup import TEMPLATES
from boltjoint.report.pages.sweep.data import DEFAULT_LIMITS, Limits, SweepData, by_level
from boltjoint.study import layout
from boltjoint.study.results import Results
from boltjoint.study.sweeps import error_of_sweep, has_all_harmonics
from boltjoint.study.tables.html import html_table, number
from boltjoint.study.tables.sweeps import drawn_designs, tabulate_sensitivity, values_of_keys

#: reasons in the table, from the most frequent one
_MOST = 30
_NUMBER = re.compile(r"(?<![\w.])[+-]?\d[\d.]*(?:e[+-]?\d+)?")


def tabulate_failures(sweep: xr.Dataset) -> pd.DataFrame:
    """Reasons why designs are impossible or a branch of theirs ends before.

    Parameters
    ----------
    sweep
        ``sweep.nc``.

    Returns
    -------
    DataFrame
        A row for each reason, from the most frequent one: the first design with it, how many have
        it, how many of these have a peak at every level nevertheless, and the keys of the first.
        Reasons that differ in numbers only count as one, told as of the first.
    """
    reasons = sweep["reason"].to_numpy().ravel().astype(str)
    with_peaks = np.isfinite(by_level(sweep, "peak_frequency")).all(axis=0)
    keys = values_of_keys(sweep)
    by_reason: dict[str, list[int]] = {}
    for design in np.flatnonzero(reasons != ""):
        by_reason.setdefault(_NUMBER.sub("…", reasons[design]), []).append(int(design))
    rows = [
        {
            "reason": reasons[designs[0]],
            "designs": len(designs),
            "with_peaks": int(with_peaks[designs].sum()),
            "first_design": designs[0],
            "keys_of_the_first": ", ".join(
                f"{name.replace('_', ' ')} {_with_unit(key, designs[0])}"
                for name, key in keys.items()
            ),
        }
        for designs in sorted(by_reason.values(), key=len, reverse=True)[:_MOST]
    ]
    names = ("reason", "designs", "with_peaks", "first_design", "keys_of_the_first")
    return pd.DataFrame(rows, columns=names)


def _with_unit(values: xr.DataArray, design: int) -> str:
    unit = values.attrs["units"]
    return number(float(values[design])) + ("" if unit == "1" else f" {unit}")


#: how designs are chosen, by their kind
_KINDS = {
    "grid": "all combinations of the values of the keys",
    "latin-hypercube": "a Latin hypercube",
    "sobol": "a scrambled Sobol sequence",
    "saltelli": "two samples, and the first again with each key of the second",
    "table": "the rows of a table",
}


def sweep_page(
    name: str,
    sweep: Sweep,
    content: xr.Dataset,
    indices: pd.DataFrame | None = None,
    *,
    reported: bool = True,
    limits: Limits = DEFAULT_LIMITS,
) -> str:
    """The interactive page of a sweep.

    Parameters
    ----------
    name, sweep
        The sweep and how it is configured.
    content
        ``sweep.nc``.
    indices
        As ``tabulate_sensitivity`` returns them; None of designs that have none.
    reported
        Whether the report has a page of its base case, to which it links.
    limits
        How much the page holds.
    """
    # it takes a tenth of a second to import
    from plotly.offline import get_plotlyjs

    data = SweepData(content, indices, limits)
    failures = tabulate_failures(content)
    text = json.dumps(data.packed(), separators=(",", ":"), allow_nan=False)
    template = TEMPLATES.get_template("sweep/templates/sweep.html.j2")
    return template.render(
        name=name,
        case=sweep.case,
        pages=_pages(name, sweep.case) if reported else {},
        kind=_KINDS[sweep.design.kind],
        joint=sweep.joint.label,
        basis=sweep.basis,
        error=error_of_sweep(content),
        has_all_harmonics=has_all_harmonics(content),
        check=sweep.check,
        percent=lambda share: number(100 * share, 2),
        sweep=data,
        designs=content["reason"].size,
        distributed=drawn_designs(content),
        failed=int((content["reason"] != "").sum()),
        failures=html_table(failures) if len(failures) else None,
        plotly=Markup(get_plotlyjs()),
        # nothing in it ends the script that holds it
        data=Markup(text.replace("<", "\\u003c")),
    )


def indices_of(name: str, sweep: Sweep, results: Results, reported: bool) -> pd.DataFrame | None:
    """Sobol indices of a sweep whose designs have them: of the report, or else of ``sweep.nc``.

    Parameters
    ----------
    name, sweep, reported
        As for ``sweep_page``.
    results
        ``sweep.nc``, and where the sweep is reported the table of its indices.
    """
    if sweep.design.kind != "saltelli":
        return None
    if reported:
        return results.table("sweep_sensitivity", case=sweep.case, sweep=name)
    return tabulate_sensitivity(results.dataset("sweep", sweep=name))


def _pages(name: str, case: str) -> dict[str, str]:
    """Pages of the report, seen from that of the sweep, with their names."""
    here = posixpath.dirname(layout.path("sweep_page", sweep=name))
    overview, of_case = (posixpath.relpath(layout.page(page), here) for page in ("overview", case))
    return {overview: "Overview", f"{of_case}#sweeps": case}
