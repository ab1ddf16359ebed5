"""What `make verify` compares of a deck with CalculiX, and what cannot be compared."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from deck_of_assembly import deck_of
from small_study import ASSEMBLY, CASE, ROOT, SETTINGS, mesh_of, snakemake, write

from boltjoint.config.makers import description_of
from boltjoint.structure.calculix_comparison import (
    Verified,
    compare_frequencies,
    elastic,
    prestressed_frequencies,
    row,
)
from boltjoint.structure.makers.registry import make
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

#: a half lap as a deck with parts, turned instances, sets in pieces and ties
DECK = {
    **{"type": "deck", "file": "config/joint.inp", "units": {"length": "mm", "mass": "t"}},
    "elements": [{"kind": "C3D8R", "read_as": "C3D8I"}],
    "contact": [{"name": "lap", "surfaces": ["lap_a", "lap_b"], "points": "nodes"}],
    "points": [{"name": "tip", "near_mm": [122, 0, 10], "direction": "z"}],
}


@pytest.fixture(scope="module")
def text():
    return deck_of(mesh_of(ASSEMBLY), 10e3)


def verified(folder, text, **changes):
    (folder / "config").mkdir(exist_ok=True)
    (folder / "config/joint.inp").write_text(text)
    described = description_of(DECK | changes).in_folder(folder)
    return Verified(described, folder, *make(described, folder))


@pytest.mark.usefixtures("installed")
def test_workflow_runs_a_deck_and_compares(text, tmp_path):
    """Parts, units, sections and contact of the deck are written anew, in SI units."""
    (tmp_path / "config").mkdir()
    (tmp_path / "config/joint.inp").write_text(text)
    for name in ("workflow", "Snakefile"):
        (tmp_path / name).symlink_to(ROOT / name)
    write(tmp_path / "config/assemblies/joint.yaml", DECK)
    of_tip = {"excitation": {"kind": "inputs", "inputs": [{"name": "tip"}]}, "outputs": ["tip"]}
    write(tmp_path / "config/cases/small.yaml", CASE | of_tip | {"assembly": "joint"})
    write(tmp_path / "config/config.yaml", SETTINGS)
    path = "results/verification/joint/calculix.csv"
    done = snakemake(tmp_path, path)
    assert done.returncode == 0, done.stdout + done.stderr
    table = pd.read_csv(tmp_path / path, index_col="quantity")
    names = table.index.str.rsplit(" ", n=1).str[0]
    assert sum(names == "natural frequency") >= 4
    assert sum(names == "frequency under preload") == 6
    # ties move nodes, contact is face to face and bricks are distorted, which high modes feel
    difference = abs(table["difference_percent"])
    assert difference[names == "natural frequency"].iloc[:6].max() < 0.5
    assert difference[names == "frequency under preload"].max() < 1
    assert table.loc["normal force of lap", "boltjoint"] == pytest.approx(2e4)
    assert difference["normal force of lap"] < 1e-3


def test_what_calculix_did_not_solve_has_no_number(text, tmp_path):
    model = verified(tmp_path, text)
    modes, preload = find_modes(model.structure, "free-2"), apply_preload(model.structure, 1e4)
    printed = {name: tmp_path / f"{name}.dat" for name in ("modes", "preload", "prestressed")}
    for path in printed.values():
        path.touch()
    table = model.calculix.compare(model, modes, preload, printed).set_index("quantity")
    assert table["calculix"].isna().all()
    assert set(table["measured_by"]) == {"CalculiX found none, see its log"}
    assert table.loc["normal force of lap", "boltjoint"] == pytest.approx(2e4)
    ours = prestressed_frequencies(model.structure, 1e4)
    assert table.loc["frequency under preload 1", "boltjoint"] == ours[0]
    # springs of the contact, in modes that slide along it
    assert ours[0] > modes["natural_frequency"][0]


def test_masses_are_refused_with_their_line(text, tmp_path):
    lump = (
        "*NODE\n90001, 0., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=LUMP\n90001, 90001\n"
        "*MASS, ELSET=LUMP\n0.001\n"
    )
    start = text.index("*Material")
    model = verified(tmp_path, text[:start] + lump + text[start:])
    with pytest.raises(ValueError, match=r"joint.inp, line \d+: elements MASS cannot be written"):
        model.calculix.write_decks(model, xr.Dataset(), 1e4, {})


def test_matrices_have_no_mesh_for_calculix(tmp_path):
    content = {"type": "matrices", "file": "a.npz", "contact": {"side_a": "a", "side_b": "b"}}
    described = description_of(content | {"bolts": [{"name": "one", "load": "F"}]})
    with pytest.raises(
        ValueError, match="no decks for CalculiX are written of an assembly of type matrices"
    ):
        _ = Verified(described, tmp_path, None, None).calculix


def test_rigid_body_modes_are_left_out_and_bounds_hold_or_not():
    frequency = elastic(np.array([50.0, 1e-4, 0.0, 20.0, np.nan]))
    assert frequency.tolist() == [20, 50]
    rows = list(compare_frequencies("mode", frequency, np.array([20.1]), 1e-2))
    assert [each["holds"] for each in rows] == [True, False]
    assert rows[0]["difference_percent"] == pytest.approx(0.5)
    assert np.isnan(rows[1]["calculix"])
    assert row("force", "N", 2.0, 1.0)["holds"] is None
