"""The interactive page of a sweep: one file that opens without a network, and what it draws.

Of many designs some are drawn, so that the page stays small. Arrays of numbers are packed.
"""

import json
import posixpath
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
import xarray as xr
from markupsafe import Markup
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from boltjoint.config.sweep import Sweep, words_of_harmonics
from boltjoint.dynamics.response.branch import ErrorLimits
from boltjoint.number_format import number
from boltjoint.report.figures.style import MM
from boltjoint.report.pages.document import TEMPLATES, pack
from boltjoint.structure.model_limits import LIMITS
from boltjoint.study import layout
from boltjoint.study.errors_of_sweep import error_of_sweep, peak_variable
from boltjoint.study.stage_inputs import Results
from boltjoint.study.tables.html import html_table
from boltjoint.study.tables.sobol_indices import tabulate_sensitivity
from boltjoint.study.tables.sweeps import drawn_designs, response_quantiles, values_of_keys

Array = NDArray[np.float64]

#: shares of the designs below the lines of a band: the median in the middle
_SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)
#: a key with a larger ratio of its ends has a logarithmic axis, if its values are positive
_WIDE = 5
#: yellow is left out as it is faint on white paper
_COLOURS = ("viridis", 0.0, 0.9, 10)
#: what is told of a peak: quantity, words, unit, factor of it, whether its axis is logarithmic
_PEAKS = {
    "peak_frequency_Hz": ("frequency", "peak frequency", "Hz", 1.0, False),
    "peak_mm": ("amplitude", "peak amplitude", "mm", MM, True),
}


@dataclass(frozen=True)
class Limits:
    """How much the page holds.

    Parameters
    ----------
    designs
        Designs with their keys and peaks, from which means are found.
    numbers
        Keys and peaks of all these designs together: four bytes each, which are 16/3 letters.
    lines
        Designs in the parallel coordinates.
    responses
        Designs with responses: browsers draw some hundred without delay.
    amplitudes
        Amplitudes of all these responses together.
    frequencies
        Frequencies of these responses.
    """

    designs: int = 10_000
    numbers: int = 300_000
    lines: int = 2_000
    responses: int = 300
    amplitudes: int = 500_000
    frequencies: int = 1_000


DEFAULT_LIMITS = Limits()


@dataclass(frozen=True)
class SweepData:
    """The designs of a sweep, as its page draws them.

    Parameters
    ----------
    sweep
        ``sweep.nc``.
    indices
        Its Sobol indices as ``tabulate_sensitivity`` returns them; None of other designs.
    limits
        How much the page holds.
    """

    sweep: xr.Dataset
    indices: pd.DataFrame | None = None
    limits: Limits = DEFAULT_LIMITS

    @cached_property
    def designs(self) -> NDArray[np.int64]:
        """Numbers of the designs on the page, from 0; the first of them are drawn as lines.

        They are in random order, so that the first are spread over all.
        """
        columns = 1 + len(self.keys) + len(_PEAKS) * max(1, len(self.levels))
        most = min(self.limits.designs, max(1, self.limits.numbers // columns))
        return np.random.default_rng(0).permutation(drawn_designs(self.sweep))[:most]

    @cached_property
    def keys(self) -> dict[str, xr.DataArray]:
        """Values of the keys that vary, of all designs."""
        return values_of_keys(self.sweep)

    @cached_property
    def levels(self) -> list[float]:
        """Excitation levels that each design is solved at; none where they vary."""
        if "force" not in self.sweep.dims:
            return []
        return self.sweep["force_level"].to_numpy().tolist()

    @property
    def unit_of_level(self) -> str:
        """Unit of the levels."""
        return self.sweep["force_level"].attrs["units"].replace("m/s2", "m/s²")

    @property
    def lines(self) -> int:
        """Designs in the parallel coordinates."""
        return min(self.designs.size, self.limits.lines)

    @property
    def has_responses(self) -> bool:
        """Whether responses were observed."""
        return "response_amplitude" in self.sweep

    @cached_property
    def frequencies(self) -> NDArray[np.int64]:
        """Which frequencies of the responses are on the page."""
        count = self.sweep.sizes["frequency"]
        return np.linspace(0, count - 1, min(count, self.limits.frequencies)).astype(int)

    @property
    def responses(self) -> int:
        """Designs with responses on the page."""
        if not self.has_responses:
            return 0
        values = max(1, len(self.levels)) * self.frequencies.size
        most = max(1, min(self.limits.responses, self.limits.amplitudes // values))
        return min(self.designs.size, most)

    def packed(self) -> dict[str, Any]:
        """All that the page draws, as JSON can hold it."""
        return {
            "colours": _colours(),
            "designs": pack(self.designs, "<i4"),
            "lines": self.lines,
            "keys": [_key(name, key, self.designs) for name, key in self.keys.items()],
            "peaks": [
                {"words": words, "unit": unit, "log": log, "values": pack(factor * part)}
                for what, words, unit, factor, log in _PEAKS.values()
                for part in [by_level(self.sweep, peak_variable(self.sweep, what))[:, self.designs]]
            ],
            "levels": [f"{level:g} {self.unit_of_level}" for level in self.levels],
            "responses": self._responses() if self.has_responses else None,
            "indices": self._indices(),
        }

    def _responses(self) -> dict[str, Any]:
        drawn = self.designs[: self.responses]
        amplitude = by_level(self.sweep, "response_amplitude")[:, drawn][..., self.frequencies]
        bands = response_quantiles(self.sweep, _SHARES)[..., self.frequencies]
        return {
            "designs": drawn.size,
            "frequency": pack(self.sweep["frequency"].to_numpy()[self.frequencies]),
            "amplitude": pack(MM * amplitude),
            "bands": pack(MM * bands),
        }

    def _indices(self) -> list[Mapping[str, Any]]:
        """Rows of the table, the peaks and levels by their places."""
        if self.indices is None:
            return []
        rows = self.indices.astype(object).where(self.indices.notna(), None)
        places = {name: place for place, name in enumerate(_PEAKS)}
        # the rows of a peak are in the order of the levels, and then of the keys
        number = self.indices.groupby(["observed", "key"], sort=False).cumcount()
        return [
            {
                "peak": places[row["observed"]],
                "level": level,
                "key": row["key"].replace("_", " "),
                "samples": row["samples"],
                **{
                    order: [row[order], row[f"{order}_low"], row[f"{order}_high"]]
                    for order in ("first_order", "total")
                },
            }
            for level, row in zip(number.tolist(), rows.to_dict("records"), strict=True)
        ]


def by_level(sweep: xr.Dataset, name: str) -> Array:
    """Values by level and design, (levels, designs, ...); of a sweep over levels it has one."""
    along = ("force", *sweep["reason"].dims)
    values = sweep[name]
    if "force" not in values.dims:
        values = values.expand_dims("force")
    values = values.transpose(*along, ...)
    rest = values.shape[len(along) :]
    return values.to_numpy().reshape(values.sizes["force"], -1, *rest)


def _key(
    name: str, values: xr.DataArray, designs: NDArray[np.int64] | Sequence[int]
) -> dict[str, Any]:
    """A key that varies, with its values."""
    unit = values.attrs["units"]
    return {
        "words": name.replace("_", " "),
        "unit": "" if unit == "1" else unit.replace("m/s2", "m/s²"),
        "log": bool(values.min() > 0 and values.max() > _WIDE * values.min()),
        "values": pack(values.to_numpy()[designs]),
    }


def _colours() -> list[str]:
    """Colours from the lowest to the highest value of a quantity."""
    name, darkest, lightest, count = _COLOURS
    return [to_hex(c) for c in matplotlib.colormaps[name](np.linspace(darkest, lightest, count))]


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
    with_peaks = np.asarray(np.isfinite(by_level(sweep, "peak_frequency")).all(axis=0))
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
    largest_error: float = ErrorLimits.of_peak,
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
    largest_error
        Relative error of amplitudes beyond which the page says that they are too far off.
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
        harmonics=sweep.harmonics_in_words,
        largest_error=largest_error,
        is_predicted="is_predicted" in content,
        check=sweep.check,
        check_harmonics=words_of_harmonics(sweep.check.harmonics) if sweep.check else "",
        has_bars=sweep.error_bars,
        percent=lambda share: number(100 * share, 2),
        sweep=data,
        designs=content["reason"].size,
        distributed=drawn_designs(content),
        beyond=_beyond_limits(content),
        failed=int((content["reason"] != "").sum()),
        failures=html_table(failures) if len(failures) else None,
        plotly=Markup(get_plotlyjs()),
        # nothing in it ends the script that holds it
        data=Markup(text.replace("<", "\\u003c")),
    )


def _beyond_limits(sweep: xr.Dataset) -> list[tuple[int, str]]:
    """Designs with a peak beyond a limit of the model at any level, and what the largest means."""
    beyond = []
    for limit in LIMITS:
        if (name := f"peak_{limit.name}") not in sweep:
            continue
        reached = sweep[name].max([dim for dim in sweep[name].dims if dim == "force"])
        if problem := limit.told(float(reached.max())):
            beyond.append((int((reached > limit.tolerated).sum()), problem))
    return beyond


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
