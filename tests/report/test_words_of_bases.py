"""What pages say of a joint: where it is excited, and where slip shows."""

import numpy as np
import pytest
import xarray as xr
from page_examples import CASE

from boltjoint import dataset
from boltjoint.config.case import Case
from boltjoint.report.answer_values import SHOWS, NonlinearMode
from boltjoint.report.pages.case.configuration import excitation_in_words, output_in_words
from boltjoint.study import layout
from boltjoint.study.stage_inputs import Results


def backbone_of(frequency, damping, force):
    return xr.Dataset(
        {
            "natural_frequency": ("state", frequency),
            "damping_ratio": ("state", damping),
            "peak_force": ("state", force),
            "response_amplitude": ("state", np.array(force) * 1e-4),
        }
    )


def test_landmarks_of_a_backbone():
    # the frequency falls by a power of the force from 80 Hz towards 70 Hz
    force = np.geomspace(1e-3, 1e2, 400)
    gone = 0.02 * force**0.5
    damping = 0.001 + 0.02 * np.exp(-(np.log(force / 8.0) ** 2))
    mode = NonlinearMode.of(backbone_of(80 - 10 * gone, damping, force), (70.0, 80.0))
    assert mode.slip_level == pytest.approx((SHOWS / 0.02) ** 2, rel=1e-3)
    assert mode.largest_damping == pytest.approx(0.021, rel=1e-3)
    assert mode.level == pytest.approx(8.0, rel=0.02)
    assert mode.amplitude == pytest.approx(mode.level * 1e-4)


def test_a_backbone_that_slips_nowhere_or_from_its_start_tells_no_force():
    sticks = backbone_of([80.0, 80.0], [1e-3, 2e-3], [1.0, 10.0])
    slips = backbone_of([75.0, 74.0], [1e-3, 2e-3], [1.0, 10.0])
    for found in (sticks, slips):
        assert NonlinearMode.of(found, (70.0, 80.0)).slip_level is None
    assert NonlinearMode.of(sticks.isel(state=slice(0)), (70.0, 80.0)) is None


@pytest.mark.parametrize(
    ("excitation", "words"),
    [
        ({"kind": "base", "direction": "z"}, "supports, along z"),
        (
            {"kind": "distributed", "surface": "top", "direction": "z"},
            "spread over the surface top, along z",
        ),
        ({"kind": "inputs", "inputs": [{"name": "shaker"}]}, "shaker"),
        (
            {
                "kind": "forces",
                "points": [{"x_mm": 403.5, "y_mm": 0, "z_mm": 10, "direction": "z"}],
            },
            "(403.5, 0, 10) mm, along z",
        ),
    ],
)
def test_the_excitation_in_words(excitation, words):
    levels = {"forces_N": [1.0]}
    if excitation["kind"] == "base":
        levels = {"forces_N": None, "accelerations_m_per_s2": [1.0]}
    case = Case.model_validate(CASE | levels | {"excitation": excitation})
    assert excitation_in_words(case, Results([])) == words


def test_points_that_a_case_does_not_give_are_those_of_the_assembly(
    tmp_path, monkeypatch, assembly
):
    monkeypatch.chdir(tmp_path)
    case = Case.model_validate(CASE)
    assert output_in_words(case, Results([])) == "that of the assembly"
    path = layout.path("assembly", assembly=case.assembly)
    node = xr.Variable((), 20, {"units": "1", "direction": "z"})
    stored = assembly.assign(excitation_node=node, response_node=node)
    for name in set(stored.data_vars) - {"excitation_node", "response_node"}:
        stored[name].attrs["units"] = "1"
    dataset.save(stored.drop_vars("axis").assign_coords(axis=assembly["axis"]), path)
    results = Results([path])
    assert excitation_in_words(case, results) == "(60, 10, −10) mm, along z"
    sensors = [{"name": "tip", "x_mm": 60, "y_mm": 0, "z_mm": 0, "direction": "y"}]
    observed = Case.model_validate(CASE | {"sensors": sensors})
    assert output_in_words(observed, results) == "tip: (60, 0, 0) mm, along y"
