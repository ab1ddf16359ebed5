"""Designs of the sweeps of a study, when asked for, and what is refused of a sweep as a whole.

What contradicts within its own file is in ``sweep``.
"""

from collections.abc import Callable, Collection, Mapping
from functools import cached_property
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from boltjoint.config.case import Case
from boltjoint.config.conflicts import conflicts_when_solved
from boltjoint.config.csv_table import CsvTable
from boltjoint.config.described import Described
from boltjoint.config.numerical_options import Settings
from boltjoint.config.sampling import Table
from boltjoint.config.sweep import MOST_JOBS, Sweep
from boltjoint.config.types import Problems
from boltjoint.config.varied_case import (
    BaseOfVariants,
    TooManyVariants,
    Variant,
    find_variants,
    read_table,
    refused,
    solve_alone,
    solved_alone,
    with_values,
)
from boltjoint.config.varied_keys import Quantity, is_rescaled, not_varied

#: impossible designs of a table from the first after which a possible one is left to be found
_MOST_TRIED = 1000


class SweptDesigns:
    """The designs of a sweep, of which only that is read which is asked for.

    Parameters
    ----------
    base
        The base case, its assembly and its joint.
    allowed
        The keys that may vary.
    read
        Gives the text of the table of designs; None where there is none.
    """

    def __init__(
        self,
        base: BaseOfVariants,
        allowed: Mapping[str, Quantity],
        read: Callable[[], str] | None = None,
    ) -> None:
        self._base, self._allowed, self._read = base, allowed, read

    @property
    def file(self) -> str | None:
        """File of the table of designs; None where there is none."""
        design = self._base.sweep.design
        return design.file if isinstance(design, Table) and self._read is not None else None

    @cached_property
    def _table(self) -> CsvTable | None:
        """The table of designs; None where there is none."""
        if self._read is None or self.file is None:
            return None
        return CsvTable(self._read(), self.file)

    @cached_property
    def columns(self) -> dict[str, NDArray[np.float64]] | None:
        """Values of the keys by design, checked; None where they are those of no table."""
        if self._read is None or self.file is None:
            return None
        return read_table(self._read(), self.file, self._allowed)

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """Keys that vary."""
        vary = self._base.sweep.vary
        return tuple(vary) if vary or self._table is None else tuple(self._table.keys)

    @cached_property
    def number(self) -> int:
        """Number of designs."""
        designs = self._base.sweep.designs
        return designs or (0 if self._table is None else self._table.count())

    @cached_property
    def variants(self) -> tuple[Variant, ...]:
        """The base case under all values of those keys that need another joint."""
        columns = None if all(map(is_rescaled, self.keys)) else self.columns
        return tuple(find_variants(self._base, columns))

    @cached_property
    def possible_variants(self) -> tuple[Variant, ...]:
        """The variants that can be solved."""
        return tuple(variant for variant in self.variants if not variant.reason)

    def has_several(self, number: int) -> bool:
        """Whether that many variants can be solved: no more of them are checked."""
        possible = (variant for variant in self.variants if not variant.reason)
        return len(list(islice(possible, number))) == number

    def conflicts(self) -> Problems:
        """More variants than can be made, or no possible design."""
        of_table = isinstance(self._base.sweep.design, Table)
        where = ("design", "file") if of_table else ("vary",)
        try:
            reason = self._impossible
        except TooManyVariants as error:
            yield where, f"{error}: must make at most {MOST_JOBS}"
            return
        if reason:
            yield where, f"makes no possible design: {reason}"

    @property
    def _impossible(self) -> str:
        """Why no design is possible; empty where one is, or none is met soon in a table."""
        if all(variant.reason for variant in self.variants):
            return self.variants[0].reason
        base = self._base
        content = solved_alone(base.case, base.sweep)
        for key, values in base.sweep.vary.items():
            # ranges are possible at both ends; each value of a list meets all of the other keys
            if is_rescaled(key) and isinstance(values, tuple):
                reasons = (refused(with_values(content, {key: value}), Case) for value in values)
                first = next(reasons)
                if first and all(reasons):
                    return "; ".join(first)
        columns = self.columns
        if columns is None:
            return ""
        by_values = {tuple(variant.values.values()): variant for variant in self.variants}
        others = next(iter(by_values.values())).values
        met = ""
        for row in islice(zip(*columns.values(), strict=True), _MOST_TRIED):
            design = dict(zip(columns, map(float, row), strict=True))
            reason = by_values[tuple(design[key] for key in others)].reason
            rescaled = {key: value for key, value in design.items() if key not in others}
            reason = reason or "; ".join(refused(with_values(content, rescaled), Case))
            if not reason:
                return ""
            met = met or reason
        return met if self.number <= _MOST_TRIED else ""


def conflicts_of_sweep(
    sweep: Sweep,
    case: Case,
    assembly: Described,
    settings: Settings,
    allowed: Mapping[str, Quantity],
) -> Problems:
    """What the base case, its assembly and the settings do not allow in a sweep."""
    yield from _conflicts_of_keys(sweep, case, allowed)
    for path, sentence in conflicts_when_solved(solve_alone(case, sweep), assembly, settings):
        if path in (("joint",), ("basis",), ("resonance",)):
            yield path, sentence
    if sweep.check is not None:
        again = solve_alone(case, sweep.checking)
        for path, sentence in conflicts_when_solved(again, assembly, settings):
            if path in (("joint",), ("basis",)):
                yield ("check", *path), sentence


def _conflicts_of_keys(sweep: Sweep, case: Case, allowed: Collection[str]) -> Problems:
    """Keys that do not vary, and ranges that reach beyond what the base case allows."""
    content = case.model_dump()
    for key, values in sweep.vary.items():
        if key not in allowed:
            yield ("vary", key), not_varied(key, allowed)
        elif is_rescaled(key) and not isinstance(values, tuple):
            for value in values.extremes:
                changed = with_values(content, {key: float(f"{value:.4g}")})
                for sentence in refused(changed, Case):
                    yield ("vary", key), f"reaches too far: {sentence}"


def conflicts_of_preload_with_gap(
    sweep: Sweep, case: Case, assembly: Described, keys: Collection[str]
) -> Problems:
    """A preload that varies, with the keys of all designs, though loads do not grow with it."""
    if assembly.fixed_loads is not None and "preload_N" in keys:
        key, loads = assembly.fixed_loads
        reason = (
            f"with {key} of {case.assembly}: {loads} do not grow with the preload, and another "
            "preload is another case"
        )
        if "preload_N" in sweep.vary:
            yield ("vary", "preload_N"), f"must not vary {reason}"
        else:
            yield ("design", "file"), f"must not have the column preload_N {reason}"
