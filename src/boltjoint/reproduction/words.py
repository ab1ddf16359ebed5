"""Statements about the source and numbers of its tables and figures, as HTML."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup

from boltjoint.reproduction.published import BASIS, Published
from boltjoint.study.artefact_list import Artefact
from boltjoint.study.tables.html import number, template_environment

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
