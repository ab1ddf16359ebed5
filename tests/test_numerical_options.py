"""Numerical options: described, listed, stored."""

import json
import runpy
from dataclasses import dataclass, fields
from pathlib import Path

import pytest

from boltjoint.dynamics.backbone import find_backbone
from boltjoint.dynamics.frequency_response import solve_response
from boltjoint.dynamics.windows import WindowMargins, frequency_window
from boltjoint.options import Options
from boltjoint.solvers.equations import LaggedControl, StepControl

DOCS = Path(__file__).parents[1] / "docs"


@dataclass(frozen=True)
class _Example(Options):
    """An example.

    Parameters
    ----------
    first, second
        Two numbers,
        on two lines.
    third
        One.

    Raises
    ------
    ValueError
        Never.
    """

    first: float = 1.0
    second: int = 2
    third: str = "x"


def test_descriptions_are_those_of_the_docstring():
    assert list(_Example.descriptions()) == [
        (["first", "second"], "Two numbers, on two lines."),
        (["third"], "One."),
    ]


@pytest.mark.parametrize("options", runpy.run_path(str(DOCS / "options.py"))["classes"]())
def test_every_option_is_described(options):
    described = [name for names, _ in options.descriptions() for name in names]
    assert described == [field.name for field in fields(options)]


def test_the_page_lists_every_option_of_the_library():
    written = (DOCS / "options.md").read_text(encoding="utf-8")
    made = runpy.run_path(str(DOCS / "options.py"))["page"]()
    assert written == made, "run: make reference"


@pytest.mark.parametrize("coordinates", ["linear", "backbone"])
def test_a_response_stores_what_it_was_solved_with(joint, coordinates):
    control = StepControl(peak_tolerance=1e-5, lagged=LaggedControl(full_steps=7))
    found = solve_response(joint, [1.0], loss_factor=0.01, coordinates=coordinates, control=control)
    stored = json.loads(found.attrs["options"])
    assert stored["peak_tolerance"] == 1e-5
    assert stored["lagged"]["full_steps"] == 7
    assert set(stored) == {field.name for field in fields(StepControl)}


def test_a_backbone_stores_what_it_was_traced_with(joint):
    control = StepControl(amplitude_scale=4.0)
    window = frequency_window(joint)
    found = find_backbone(joint, [1.0], loss_factor=0.01, window=window, control=control)
    assert json.loads(found.attrs["options"])["amplitude_scale"] == 4.0


def test_margins_of_a_window(joint):
    low, high = frequency_window(joint)
    wider = frequency_window(joint, margins=WindowMargins(below=0.5, above=1.5))
    assert wider == pytest.approx((low / 0.85 * 0.5, high / 1.05 * 1.5))


@pytest.mark.parametrize("name", [field.name for field in fields(LaggedControl)])
def test_options_of_a_lagged_basis_are_positive(name):
    with pytest.raises(ValueError, match=name):
        LaggedControl(**{name: 0})
