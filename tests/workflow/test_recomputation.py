"""What is computed anew after a change of the configuration or of the code, found by dry runs.

Changes of different cases share a run: a result lies in the folder of its case.
"""

import os
import re
import shutil
from importlib import import_module
from pathlib import Path

import pytest
from planned import among, planned
from small_study import (
    CASE,
    CHECKS,
    RESPONSES,
    ROOT,
    SALTELLI,
    SETTINGS,
    SWEEP,
    VARIABLE,
    write,
    write_config,
)

from boltjoint.config import makers
from boltjoint.config.study import load_study
from boltjoint.provenance.code_dependencies import Sources
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Contents

STRUCTURE = "assemblies/*"
FREE, ENRICHED = SETTINGS["convergence"]["bases"]
NODES = "node-to-node/joint.nc"


def with_contact(case, **values):
    return case | {"contact": case["contact"] | values}


def test_a_new_force_leaves_the_joints_and_a_new_stiffness_the_structure_alone(copied):
    small = CASE | {"forces_N": [0.01, 5, 20]}
    write_config(copied, {"small": small, "variable": with_contact(VARIABLE, **STIFFER_NORMAL)})
    found = planned(copied)
    for case, responses in RESPONSES.items():
        assert len(among(found, f"cases/{case}/*/response.nc")) == responses
        assert len(among(found, f"cases/{case}/*/timing.csv")) == responses
        assert len(among(found, f"cases/{case}/*/check.csv")) == CHECKS[case]
    of_free = f"cases/small/{FREE}"
    assert among(found, f"{of_free}/*joint.nc", f"{of_free}/*/fit_timing.csv") == []
    assert len(among(found, f"cases/variable/*/{NODES}")) == len([FREE, ENRICHED])
    # contact-adapted bases are made for the contact of all cases
    assert among(found, "assemblies/*.nc") == [BASIS, POD_MODES]


def test_a_moved_shaker_leaves_the_structure_alone(copied):
    point = {"x_mm": 100, "y_mm": 0, "z_mm": 10, "direction": "z"}
    moved = {
        "excitation": {"kind": "forces", "points": [point]},
        "sensors": [point | {"name": "lap"}, point | {"name": "tip", "x_mm": 182}],
    }
    write_config(copied, {"small": CASE | moved, "variable": VARIABLE})
    found = planned(copied)
    assert among(found, STRUCTURE) == []
    assert len(among(found, f"cases/small/*/{NODES}")) == len([FREE, ENRICHED, "free-4"])
    assert len(among(found, "cases/small/*/response.nc")) == RESPONSES["small"]
    assert among(found, "cases/variable/*") == []


def test_other_damping_makes_only_the_bases_anew_that_are_made_for_it(copied):
    damped = {key: value for key, value in VARIABLE.items() if key != "loss_factor"}
    damped |= {"damping": {"model": "modal", "damping_ratios": [0.001]}}
    write_config(copied, {"small": CASE, "variable": damped})
    found = planned(copied)
    assert among(found, "assemblies/*.nc") == [BASIS, POD_MODES]
    assert among(found, f"cases/*/{FREE}/*joint.nc") == []
    assert among(found, f"cases/small/{FREE}/*/response.nc") == []
    assert len(among(found, "cases/variable/*/response.nc")) == RESPONSES["variable"]


BASIS = f"results/assemblies/two_bolt/{ENRICHED}/modes.nc"
POD_MODES = "results/assemblies/two_bolt/pod_modes.nc"
STIFFER_NORMAL = {"normal_stiffness_N_per_m": 5e7}


def test_another_division_leaves_the_nodes_alone(copied):
    small = with_contact(CASE, tangential_stiffness_N_per_m=5e8)
    write_config(copied, {"small": small, "variable": VARIABLE | EQUAL_LOAD})
    found = planned(copied)
    assert len(among(found, f"cases/small/*/{NODES}")) == len([FREE, ENRICHED, "free-4"])
    folder = f"cases/variable/{FREE}/regions=2"
    assert among(found, f"cases/variable/{FREE}/*/joint.nc") == among(
        [f"results/{folder}/joint.nc", f"results/{folder}/elements=2/joint.nc"], "*"
    )
    assert among(found, f"{folder}/linear/*/response.nc", f"{folder}/elements=2/linear/*.nc")
    patterns = "results/assemblies/two_bolt/patterns.nc"
    assert among(found, "assemblies/*.nc") == sorted([BASIS, patterns, POD_MODES])


EQUAL_LOAD = {"regions": {"division": "equal-load"}}


def test_another_motion_of_regions_leaves_clusters_and_other_cases_alone(copied):
    small = CASE | {"regions": {"motion": "load-weighted"}}
    write_config(copied, {"small": small, "variable": VARIABLE, "third": VARIABLE})
    found = planned(copied)
    folder = f"results/cases/small/{FREE}/regions=2"
    assert among(found, "cases/small/*/joint.nc") == [
        f"{folder}/elements=2/joint.nc",
        f"{folder}/joint.nc",
        f"{folder}/table/joint.nc",
        # of the sweep
        f"results/cases/small/{FREE}/regions=3/elements=2/joint.nc",
        f"results/cases/small/{FREE}/regions=3/joint.nc",
    ]
    assert among(found, "cases/variable/*") == []
    # a further case computes only what is its own
    assert len(among(found, "cases/third/*/response.nc")) == RESPONSES["variable"]
    assert len(among(found, f"cases/third/*/{NODES}")) == len([FREE, ENRICHED])
    assert among(found, STRUCTURE) == []


def test_a_tolerance_and_numbers_of_regions_to_compare_leave_the_cases_alone(copied):
    # joints of a given number of regions meet no tolerance: only pages tell of it
    write(copied / "config/cases/small.yaml", CASE | {"regions": {"tolerance": 0.02}})
    found = planned(copied, "--config", "convergence={regions: [2, 3]}")
    assert len(among(found, "tables/divisions_*.csv")) == 1
    assert among(found, STRUCTURE, "cases/*") == []


def test_options_of_fits_and_of_the_contact_adapted_basis_leave_the_rest_alone(copied):
    options = ["fitting={initial_guesses: 3}", "contact_adapted_basis={states: 7}"]
    found = planned(copied, "--config", *options)
    assert among(found, "assemblies/*.nc") == [
        f"results/assemblies/two_bolt/{ENRICHED}/modes.nc",
        "results/assemblies/two_bolt/pod_modes.nc",
    ]
    # the fit to loops has starts, that of harmonics has none
    of_both = [
        f"results/cases/{case}/{joint}/joint.nc"
        for case in RESPONSES
        for joint in (f"{FREE}/regions=2/elements=2", f"{ENRICHED}/node-to-node")
    ]
    compared = [
        f"results/cases/small/{ENRICHED}/{joint}/joint.nc"
        for joint in SETTINGS["convergence"]["reductions"] + ["clusters=2"]
    ]
    swept = [f"results/cases/small/{FREE}/{SWEEP['joint']}/joint.nc"]
    assert among(found, "cases/*/joint.nc") == sorted(of_both + compared + swept)
    assert len(among(found, f"cases/*/{ENRICHED}/*/response.nc")) == 3


def test_sampled_friction_solves_anew_and_leaves_the_joints_alone(copied):
    found = planned(copied, "--config", "solver={friction_force: aft}")
    for name in ("response.nc", "timing.csv"):
        assert len(among(found, f"cases/*/{name}")) == sum(RESPONSES.values())
    assert among(found, "cases/*/joint.nc", STRUCTURE) == []
    # residuals in time are of analytic forces only
    assert among(found, "cases/*/check.csv") == []


def test_code_of_another_date_or_without_a_use_and_a_description_run_nothing(copied):
    folder = with_library(copied)
    write(folder / "config/cases/small.yaml", CASE | {"description": "Other words"})
    for path in (*folder.rglob("src/**/*.py"), *folder.rglob("workflow/**/*.py")):
        os.utime(path)
    edit(folder / "src/boltjoint/study/memory_and_time_of_study.py")
    assert planned(folder) == []


def test_edited_code_runs_what_uses_it_whatever_its_date(copied):
    folder = with_library(copied)
    edit(folder / "src/boltjoint/study/tables/accuracy.py", date=0)
    edit(folder / "workflow/scripts/draw_figures.py")
    found = planned(folder)
    assert among(found, "tables/accuracy_*.csv") and among(found, "figures/mesh_two_bolt.svg")
    assert among(found, STRUCTURE, "cases/*") == []


(DECLARING,) = makers.displays_of_makers()
#: what declares the figures of a maker, and what draws them
DECLARED = Path(DECLARING.__file__)
DRAWN = DECLARED.with_name("figures.py")


@pytest.mark.parametrize("module", [DECLARED, DRAWN])
def test_edited_figures_of_a_maker_are_drawn_anew_and_leave_its_structures_alone(copied, module):
    folder = with_library(copied)
    edit(folder / module.relative_to(ROOT))
    found = planned(folder)
    drawn_together = ("contact", "deformation", "mesh", "modes")
    patterns = [f"figures/{kind}_two_bolt*.svg" for kind in drawn_together]
    assert among(found, "figures/*") == among(figures_of(folder), *patterns)
    assert among(found, "report/structure.html")
    assert among(found, STRUCTURE, "cases/*", "sweeps/*", "tables/*") == []


def figures_of(folder):
    """The figures that a study has drawn."""
    drawn = (folder / "results/figures").iterdir()
    return [path.relative_to(folder).as_posix() for path in drawn]


def with_library(folder):
    """A study with a library of its own, for tests that edit it."""
    shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def edit(path, date=None):
    path.write_text(path.read_text() + "\n# edited\n")
    if date is not None:
        os.utime(path, (date, date))


SOURCES = Sources(ROOT / "src/boltjoint")
RULES = "".join(path.read_text() for path in sorted(ROOT.glob("workflow/rules/*.smk")))


def test_every_job_knows_the_content_of_its_own_script():
    scripts = re.findall(r'^ +"\.\./scripts/(\w+\.py)"$', RULES, flags=re.MULTILINE)
    known = r'^ +library=(?:lambda w: )?library\(\s*"(\w+\.py)"'
    assert re.findall(known, RULES, flags=re.MULTILINE) == scripts
    assert set(scripts) == {path.name for path in ROOT.glob("workflow/scripts/*.py")}


STRUCTURE_SCRIPTS = {"build_assembly", "apply_preload", "find_modes", "find_pod_modes"}
JOINT_SCRIPTS = {"connect_nodes", "partition_regions", "reduce_joint"}
SOLUTION_SCRIPTS = {"solve_responses", "time_by_differences", "find_peaks"}


@pytest.mark.parametrize(
    ("module", "used_by", "not_used_by"),
    [
        ("joint/fit_jenkins", {"reduce_joint"}, STRUCTURE_SCRIPTS | {"partition_regions"}),
        ("structure/preload", {"apply_preload"}, {"build_assembly"}),
        ("structure/adapted_basis/pod", {"find_pod_modes"}, {"apply_preload"}),
        (
            "solvers/arc_length",
            # contact-adapted bases are made from backbones
            SOLUTION_SCRIPTS | {"find_pod_modes"},
            (STRUCTURE_SCRIPTS | JOINT_SCRIPTS) - {"find_pod_modes"},
        ),
        (
            "report/figures/style",
            {"draw_figures"},
            STRUCTURE_SCRIPTS | JOINT_SCRIPTS | SOLUTION_SCRIPTS | {"check_responses", "tabulate"},
        ),
        (
            "study/memory_and_time_of_study",
            set(),
            {path.stem for path in ROOT.glob("workflow/scripts/*.py")},
        ),
    ],
)
def test_scripts_use_no_more_of_the_library_than_they_need(module, used_by, not_used_by):
    file = str(ROOT / f"src/boltjoint/{module}.py")
    assert Path(file).exists()
    users = {
        path.stem for path in ROOT.glob("workflow/scripts/*.py") if file in SOURCES.used_by(path)
    }
    assert used_by <= users
    assert not not_used_by & users


@pytest.mark.parametrize(
    ("module", "used_by", "not_used_by"),
    [
        ("study/tables/accuracy", {"responses"}, {"structure", "harmonics"}),
        ("report/figures/style", {"structure", "convergence_figures"}, {"convergence_tables"}),
        ("verification/time_integration", {"harmonics"}, {"responses", "structure"}),
    ],
)
def test_figures_and_tables_use_no_more_of_the_library_than_they_need(module, used_by, not_used_by):
    file = str(ROOT / f"src/boltjoint/{module}.py")
    assert Path(file).exists()
    users = {
        path.stem
        for path in ROOT.glob("src/boltjoint/report/displays/*.py")
        if file in SOURCES.used_by(path)
    }
    assert used_by <= users
    assert not not_used_by & users


@pytest.mark.parametrize("name", makers.maker_names())
def test_figures_and_decks_of_a_maker_are_no_code_of_its_structures(name):
    """Modules that a maker names are loaded by those who ask for them."""
    maker = makers.maker(name)
    named = {getattr(maker, door, None) for door in ("DISPLAYS", "CALCULIX")} - {None}
    files = {import_module(each).__file__ for each in named}
    assert not files & set(SOURCES.used_by(maker.__file__))


def test_figures_of_a_maker_are_code_of_the_jobs_that_draw_them():
    assert str(DRAWN) in SOURCES.used_by(DECLARED)
    for path in ROOT.glob("workflow/scripts/*.py"):
        assert not {str(DECLARED), str(DRAWN)} & set(SOURCES.used_by(path)), path
    jobs = DISPLAYS.jobs(Contents(load_study(ROOT), DISPLAYS), "figure")
    drawing = [job for job in jobs if DECLARING.__name__ in job.modules]
    assert {job.name for job in drawing} == {
        job.name for job in jobs if any(each.kind == "mesh" for each in job.artefacts)
    }
    assert len(drawing) < len(jobs)


def test_other_values_of_a_sweep_leave_its_joint_alone(copied):
    vary = SWEEP["vary"] | {"preload_N": [9000, 10000, 12000]}
    write(copied / "config/sweeps/grid.yaml", SWEEP | {"vary": vary, "description": "Other words"})
    found = planned(copied)
    assert among(found, "*.nc") == [
        "results/sweeps/grid/chunks/0.nc",
        "results/sweeps/grid/chunks/1.nc",
        "results/sweeps/grid/designs.nc",
        "results/sweeps/grid/sweep.nc",
    ]
    assert among(found, "*/explore.html") == ["results/sweeps/grid/explore.html"]


def test_words_of_a_sweep_run_nothing(copied):
    write(copied / "config/sweeps/grid.yaml", SWEEP | {"description": "Other words"})
    assert planned(copied) == []


def test_a_sweep_goes_on_with_the_chunk_that_is_missing(copied):
    (copied / "results/sweeps/grid/chunks/1.nc").unlink()
    (copied / "results/sweeps/grid/sweep.nc").unlink()
    assert among(planned(copied), "*.nc") == [
        "results/sweeps/grid/chunks/1.nc",
        "results/sweeps/grid/sweep.nc",
    ]


def test_other_designs_to_check_leave_the_designs_alone(copied):
    check = {"designs": 2, "basis": "free-4"}
    write(copied / "config/sweeps/shares.yaml", SALTELLI | {"check": check})
    assert among(planned(copied), "*.nc") == [
        "results/sweeps/shares/checked.nc",
        "results/sweeps/shares/sweep.nc",
    ]
