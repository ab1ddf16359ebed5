"""Studies of structures that are no half laps: matrices, and a maker of another package."""

import os
from pathlib import Path

import modal_files
import numpy as np
import pytest
import yaml
from deck_of_assembly import deck_of
from matrix_files import exported, keys, write_npz
from small_study import ASSEMBLY, CASE, COMMAND, ROOT, SETTINGS, mesh_of, run, snakemake, write
from started import run_snakemake

from boltjoint import dataset
from boltjoint.config.makers import maker_names
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload

JOINTS = ["node-to-node", "regions=2/elements=2"]
OF_CASE = {
    "assembly": "two_bolt",
    "outputs": ["tip"],
    "excitation": {"kind": "inputs", "inputs": [{"name": "shaker"}]},
    "solve": [{"resonance": 1, "joints": JOINTS}],
    # whatever a joint is from, it is integrated in time alike
    "verification_forces_N": [],
}
SWEEP = {
    "case": "small",
    "vary": {"assembly.contact.penalty_N_per_m3": [1e14, 1e15], "preload_N": [10000, 12000]},
    "design": {"kind": "grid"},
    "basis": "free-2",
    "joint": "regions=2",
}
LINEAR = "results/cases/small/free-2/{joint}/linear/resonance=1/response.nc"


@pytest.fixture
def of_matrices(tmp_path):
    """A study of the structure of the small one, which another program has written."""
    folder = tmp_path / "study"
    structure = structure_of(mesh_of(ASSEMBLY))
    (folder / "config/matrices").mkdir(parents=True)
    write_npz(folder / "config/matrices/joint.npz", exported(structure))
    tip = [{"name": "tip", "row": "tip", "direction": "z"}]
    described = keys(structure, file="config/matrices/joint.npz", outputs=tip)
    write(folder / "config/assemblies/two_bolt.yaml", described)
    write(folder / "config/cases/small.yaml", {**CASE, **OF_CASE})
    write(folder / "config/sweeps/penalty.yaml", SWEEP)
    used = {"cases": ["small"], "sweeps": ["penalty"], "omit": ["timing"]}
    write(folder / "config/config.yaml", {**SETTINGS, **used, "convergence": {}})
    for name in ("workflow", "Snakefile"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def test_matrices_give_what_the_mesh_does_that_they_are_from(of_matrices, finished):
    said = run(of_matrices)
    assert "small (free-2): With the structure as modelled, whose error is not tested, " in said
    assert "in a basis whose error is not tested." in said
    assert "Open results/report/overview.html" in said.splitlines()
    for joint in JOINTS:
        mine, of_mesh = (
            dataset.load(folder / LINEAR.format(joint=joint)) for folder in (of_matrices, finished)
        )
        for name in ("peak_frequency", "peak_amplitude", "harmonic_peak_amplitude"):
            np.testing.assert_allclose(mine[name], of_mesh[name], rtol=1e-8, err_msg=name)
        assert mine["sensor"].to_numpy().tolist() == ["tip"]
    preload = "results/assemblies/two_bolt/preload=10000/preload.nc"
    loads = [dataset.load(folder / preload)["normal_load"] for folder in (of_matrices, finished)]
    np.testing.assert_allclose(*loads, atol=1e-9 * loads[1].max())
    sweep = dataset.load(of_matrices / "results/sweeps/penalty/sweep.nc")
    assert sweep["complete"].to_numpy().all()
    # softer contact, lower frequency; higher preload, less slip
    assert np.all(np.isfinite(sweep["peak_frequency"]))
    page = (of_matrices / "results/report/structure.html").read_text(encoding="utf-8")
    assert "there are no pictures" in page
    assert "two bars" not in page.lower()
    figures = {path.name for path in (of_matrices / "results/figures").iterdir()}
    assert "contact_two_bolt_preload=10000.svg" in figures
    assert not [name for name in figures if name.startswith(("mesh", "modes", "deformation"))]
    view = of_matrices / "results/assemblies/two_bolt/preload=10000/preload.vtu"
    assert b"normal_load" in view.read_bytes()
    assert "Nothing to be done" in run(of_matrices, "--dry-run")
    # the content of the files counts, whatever their dates
    other = exported(structure_of(mesh_of(ASSEMBLY)))
    other["M"] = 1.01 * other["M"]
    write_npz(of_matrices / "config/matrices/joint.npz", other)
    assert "build_assembly" in run(of_matrices, "--dry-run")


def test_a_deck_gives_what_the_mesh_does_that_it_is_of(tmp_path, finished):
    folder = tmp_path / "study"
    mesh, deck = mesh_of(ASSEMBLY), folder / "config/joint.inp"
    deck.parent.mkdir(parents=True)
    deck.write_text(deck_of(mesh, 10e3))
    lap = {"name": "lap", "surfaces": ["lap_a", "lap_b"], "points": "nodes"}
    described = {
        "type": "deck",
        "file": "config/joint.inp",
        "units": {"length": "mm", "mass": "t"},
        "elements": [{"kind": "C3D8R", "read_as": "C3D8I"}],
        "contact": [lap],
        "points": [{"name": "tip", "near_mm": [182, 0, 10], "direction": "z"}],
    }
    write(folder / "config/assemblies/two_bolt.yaml", described)
    tip = {"kind": "inputs", "inputs": [{"name": "tip"}]}
    solved = {"excitation": tip, "solve": [{"resonance": 1, "joints": JOINTS[:1]}]}
    write(folder / "config/cases/small.yaml", {**CASE, **OF_CASE, **solved})
    used = {"omit": ["timing"], "convergence": {}}
    write(folder / "config/config.yaml", {**SETTINGS, **used})
    for name in ("workflow", "Snakefile"):
        (folder / name).symlink_to(ROOT / name)
    assert "small (free-2): With the structure as modelled, whose error is not tested, " in run(
        folder
    )
    mine, of_mesh = (
        dataset.load(each / LINEAR.format(joint=JOINTS[0])) for each in (folder, finished)
    )
    for name in ("peak_frequency", "peak_amplitude", "peak_amplitude_converged"):
        np.testing.assert_allclose(mine[name], of_mesh[name], rtol=1e-6, err_msg=name)
    # stresses and displacements of its nodes are known, holes are not
    for name in ("peak_displacement_over_length", "peak_stress_over_strength"):
        np.testing.assert_allclose(mine[name], of_mesh[name], rtol=1e-3, err_msg=name)
    assert "peak_slip_over_clearance" not in mine
    page = (folder / "results/report/structure.html").read_text(encoding="utf-8")
    assert "section of 41 nodes" in page
    figures = {path.name for path in (folder / "results/figures").iterdir()}
    pictures = ("solids_two_bolt.svg", "solid_modes_two_bolt_free-2.svg")
    assert {*pictures, "contact_two_bolt_preload=10000.svg"} <= figures
    assert "Nothing to be done" in run(folder, "--dry-run")
    # the content of a deck counts, whatever its date
    deck.write_text(deck.read_text() + "** a word\n")
    assert "build_assembly" in run(folder, "--dry-run")


def test_modal_data_give_what_the_mesh_does_that_they_are_from(tmp_path, finished):
    """Responses, all harmonics, backbone, sweep and pages of modes at contact points alone."""
    folder = tmp_path / "study"
    structure = structure_of(mesh_of(ASSEMBLY))
    preload, modes = apply_preload(structure, 10000), find_modes(structure, "free-2")
    (folder / "config").mkdir(parents=True)
    write_npz(folder / "config/modes.npz", modal_files.variables(modes, preload))
    contact = modal_files.KEYS["contact"] | {"preload_N": 10000}
    tip = [{"name": "tip", "row": "tip", "direction": "z"}]
    described = {"file": "config/modes.npz", "contact": contact, "outputs": tip}
    write(folder / "config/assemblies/two_bolt.yaml", modal_files.KEYS | described)
    coordinates = {"coordinates": ["linear", "backbone"]}
    write(folder / "config/cases/small.yaml", {**CASE, **OF_CASE, **coordinates})
    vary = {"contact.friction_coefficient": [0.1, 0.2]}
    write(folder / "config/sweeps/friction.yaml", SWEEP | {"vary": vary})
    used = {"cases": ["small"], "sweeps": ["friction"], "omit": ["timing"]}
    write(folder / "config/config.yaml", {**SETTINGS, **used, "convergence": {}})
    for name in ("workflow", "Snakefile"):
        (folder / name).symlink_to(ROOT / name)
    assert "small (free-2): With the structure as modelled, whose error is not tested, " in run(
        folder
    )
    mine, of_mesh = (
        dataset.load(each / LINEAR.format(joint="node-to-node")) for each in (folder, finished)
    )
    for name in ("peak_frequency", "peak_amplitude", "peak_frequency_converged"):
        np.testing.assert_allclose(mine[name], of_mesh[name], rtol=1e-9, err_msg=name)
    backbone = LINEAR.format(joint="node-to-node").replace("linear", "backbone")
    np.testing.assert_allclose(
        dataset.load(folder / backbone)["peak_frequency"], mine["peak_frequency"], rtol=1e-3
    )
    sweep = dataset.load(folder / "results/sweeps/friction/sweep.nc")
    assert sweep["complete"].to_numpy().all()
    page = (folder / "results/report/structure.html").read_text(encoding="utf-8")
    assert "none, since normal loads are given" in page
    changed = {**CASE, **OF_CASE, "preload_N": 12000}
    write(folder / "config/cases/small.yaml", changed)
    ran = snakemake(folder, "--dry-run")
    expected = "preload_N: 12000 must be 10000, that of contact.normal_load of two_bolt"
    assert expected in ran.stdout + ran.stderr


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"type": "matrix"}, f'type: "matrix" must be {" or ".join(maker_names())}'),
        ({"stiffness": "KK"}, "config/matrices/joint.npz: KK is not there; did you mean K?"),
        ({"file": "config/none.npz"}, "config/none.npz: there is no such file"),
    ],
)
def test_what_is_no_structure_is_said_in_one_line(of_matrices, changes, line):
    path = of_matrices / "config/assemblies/two_bolt.yaml"
    write(path, yaml.safe_load(path.read_text()) | changes)
    ran = snakemake(of_matrices, "--dry-run")
    assert ran.returncode != 0
    said = ran.stdout + ran.stderr
    lines = [each for each in said.splitlines() if "config/assemblies/two_bolt.yaml: " in each]
    assert len(lines) == 1, said
    assert line in lines[0]
    assert "Traceback" not in said


CUBES = {
    "type": "cubes",
    "edge_mm": 40,
    "elements": 3,
    "bolt_stiffness": 1e8,
}


def test_a_maker_of_another_package_is_used_as_those_of_this_one(tmp_path):
    """With a friction law and a table: modules that entry points name."""
    package = Path(__file__).with_name("maker_of_cubes")
    environment = os.environ | {"PYTHONPATH": f"{package}:{ROOT / 'src'}"}
    folder = tmp_path / "study"
    case = {**CASE, **OF_CASE, "assembly": "cubes", "outputs": ["top"], "preload_N": 2000}
    case["excitation"] = {"kind": "inputs", "inputs": [{"name": "top"}]}
    case["contact"] = {**case["contact"], "law": "rough"}
    write(folder / "config/assemblies/cubes.yaml", CUBES)
    write(folder / "config/cases/small.yaml", case)
    used = {"cases": ["small"], "omit": ["timing"], "convergence": {}}
    write(folder / "config/config.yaml", {**SETTINGS, **used})
    for name in ("workflow", "Snakefile"):
        (folder / name).symlink_to(ROOT / name)
    ran = run_snakemake(COMMAND[3:], folder, environment)
    assert ran.returncode == 0, ran.stderr
    preload = dataset.load(folder / "results/assemblies/cubes/preload=2000/preload.nc")
    # the bolts are tightened against the ground: the contact carries what their springs do not
    carried = preload["normal_load"].sum().item()
    assert 0 < carried < 8000
    response = dataset.load(folder / LINEAR.format(joint="node-to-node"))
    assert response["complete"].all()
    page = (folder / "results/report/structure.html").read_text(encoding="utf-8")
    assert "edge of the cubes (mm)" in page
    # twice the friction coefficient of the case, which is that of all elements
    joint = dataset.load(folder / "results/cases/small/free-2/node-to-node/joint.nc")
    loaded = preload["normal_load"].to_numpy()
    loaded = loaded[loaded > 0]
    friction = 2 * case["contact"]["friction_coefficient"]
    np.testing.assert_allclose(joint["slip_force"], friction * loaded, rtol=1e-12)
    (table,) = (folder / "results/tables").glob("rows_of_cubes*.csv")
    assert table.read_text().splitlines()[1] == f"rough,{loaded.size}"
