"""The workflow itself, on a study small enough to run in two minutes."""

import os
import shutil

import pandas as pd
import pytest
import xarray as xr
from small_study import (
    ASSEMBLY,
    CASE,
    SETTINGS,
    SOLVED,
    SOLVED_VARIABLE,
    VARIABLE,
    snakemake,
    write,
)

from boltjoint.config.study import load_study
from boltjoint.study import layout

CASES = {"small": CASE, "variable": VARIABLE}
SOLVED_OF = {"small": SOLVED, "variable": SOLVED_VARIABLE}
#: bases that are solved or compared
BASES = SETTINGS["convergence"]["bases"]
#: responses in linear modes, which are checked in time: five joints and one in the enriched basis
CHECKED_OF = {"small": 6, "variable": 3}


@pytest.fixture(scope="module")
def finished(finished, tmp_path_factory):
    """A copy of the finished study, finished again with a second case."""
    folder = tmp_path_factory.mktemp("both") / "project"
    shutil.copytree(finished, folder)
    assert planned(folder) == {}
    write(folder / "config/cases/variable.yaml", VARIABLE)
    write(folder / "config/config.yaml", SETTINGS | {"cases": list(CASES)})
    counts = planned(folder)
    assert counts["solve_response"] == counts["time_solver"] == SOLVED_VARIABLE
    assert counts["connect_nodes"] == counts["find_peaks"] == len(BASES)
    assert not {"build_assembly", "apply_preload", "find_modes"} & set(counts)
    ran = snakemake(folder)
    assert ran.returncode == 0, ran.stderr
    return folder


def planned(folder, *options):
    """How often each rule would run."""
    ran = snakemake(folder, "--dry-run", *options)
    assert ran.returncode == 0, ran.stderr
    lines = (ran.stdout + ran.stderr).splitlines()
    starts = [i for i, line in enumerate(lines) if line.startswith("job ")]
    if not starts:
        return {}
    counts = {}
    for line in lines[starts[0] + 2 :]:
        if not line.strip():
            break
        rule, count = line.split()
        counts[rule] = int(count)
    counts.pop("total", None)
    counts.pop("all", None)
    return counts


def test_every_result_is_there_and_nothing_is_left_to_do(finished):
    results = finished / "results"
    tables = {path.name for path in (results / "tables").iterdir()}
    assert {
        "contact.csv",
        "accuracy_small_free-2.csv",
        "times_small_free-2.html",
        "accuracy_small_enriched-8.csv",
        "regions_small_free-2_clusters=2.csv",
        "elements_small_free-2_clusters=2_harmonic=2.csv",
        "harmonic_peaks_small_enriched-8.csv",
        "harmonics_small_free-2.csv",
        "patterns_two_bolt.csv",
        "bases_variable.csv",
        "divisions_small_enriched-8.csv",
        "fits_small_free-2.csv",
    } <= tables
    for case, solved in SOLVED_OF.items():
        assert len(list((results / "cases" / case).rglob("response.nc"))) == solved
        assert len(list((results / "cases" / case).rglob("timing.csv"))) == solved
        # of linear coordinates only
        assert len(list((results / "cases" / case).rglob("check.csv"))) == CHECKED_OF[case]
    assert (results / "assemblies/two_bolt/preload=10000/preload.nc").exists()
    assert list((results / "figures").glob("response_small_*.svg"))
    assert planned(finished) == {}


@pytest.mark.parametrize("case", CASES)
def test_tables_hold_the_responses(finished, case):
    tables = {
        path.stem: pd.read_csv(path)
        for path in (finished / "results/tables").glob(f"accuracy_{case}_*.csv")
    }
    rows = SOLVED_OF[case] * len(CASES[case]["forces_N"])
    assert sum(map(len, tables.values())) == rows
    table = tables[f"accuracy_{case}_free-2"]
    where = finished / f"results/cases/{case}/free-2/regions=2/linear/resonance=1/response.nc"
    with xr.open_dataset(where) as response:
        row = table.query("joint == 'regions=2' and coordinates == 'linear' and force_N == 20")
        # the table is written with nine digits
        assert row["peak_frequency_Hz"].item() == pytest.approx(
            float(response["peak_frequency"][-1]), rel=1e-8
        )


def test_ways_to_the_same_answer_agree(finished):
    def peaks(table, joint, coordinates):
        found = pd.read_csv(finished / f"results/tables/accuracy_small_{table}.csv")
        rows = found.query("joint == @joint and coordinates == @coordinates")
        assert rows["complete"].all()
        return rows[["peak_frequency_Hz", "peak_mm_per_N"]].to_numpy()

    # the table is interpolated to 1e-6 of the force
    every, tabulated = (
        peaks("free-2", joint, "linear") for joint in ("regions=2", "regions=2/table")
    )
    assert tabulated == pytest.approx(every, rel=1e-5)
    # one complex mode leaves out what the others do dynamically, the backbone what they do at all
    linear, complex_mode, backbone = (
        peaks("enriched-8", "node-to-node", coordinates)
        for coordinates in ("linear", "complex-rdnm-1", "backbone")
    )
    assert complex_mode == pytest.approx(linear, rel=0.01)
    assert backbone == pytest.approx(linear, rel=0.01)
    # two modes without contact are too stiff for it
    assert (linear[:, 0] < 0.96 * peaks("free-2", "clusters=2/harmonic=2", "linear")[:, 0]).any()


def test_files_tell_their_units_and_parameters(finished):
    for path in (finished / "results").rglob("*.nc"):
        with xr.open_dataset(path) as dataset:
            assert dataset.attrs["boltjoint_version"]
            assert "parameters" in dataset.attrs
            for name, variable in dataset.variables.items():
                assert variable.dtype.kind in "UOST" or variable.attrs.get("units"), (path, name)


def test_two_runs_give_the_same_bytes(finished, tmp_path):
    for name in ("workflow", "profiles", "resources", "src", "config"):
        shutil.copytree(finished / name, tmp_path / name)
    shutil.copy(finished / "Snakefile", tmp_path)
    ran = snakemake(tmp_path)
    assert ran.returncode == 0, ran.stderr
    # what depends on the clock, or records the machine
    timed = ("timing.csv", "fit_timing.csv", "environment.json")
    tables = ("times_", "models_", "fits_")
    for path in sorted((finished / "results").rglob("*")):
        where = path.relative_to(finished)
        if path.is_dir() or path.name in timed or path.name.startswith(tables):
            continue
        if where.parts[1] in ("logs", "benchmarks"):
            continue
        if where.parts[1] == "report" and path.stem != "structure":
            continue
        assert path.read_bytes() == (tmp_path / where).read_bytes(), where


def test_a_new_force_runs_only_solves_and_what_follows(finished):
    case = finished / "config/cases/small.yaml"
    write(case, CASE | {"forces_N": [0.01, 5, 20]})
    counts = planned(finished)
    write(case, CASE)
    assert counts["solve_response"] == counts["time_solver"] == SOLVED
    assert not {"build_assembly", "apply_preload", "find_modes", "connect_nodes"} & set(counts)
    assert not {"partition_regions", "fit_reduced_joint", "tabulate_joint"} & set(counts)
    assert planned(finished) == {}


@pytest.mark.parametrize(
    ("case", "key", "value"),
    [
        ("small", "tangential_stiffness_N_per_m", 5e8),
        ("variable", "normal_stiffness_N_per_m", 5e7),
    ],
)
def test_a_new_stiffness_leaves_the_structure_alone(finished, case, key, value):
    path, content = finished / f"config/cases/{case}.yaml", CASES[case]
    write(path, content | {"contact": content["contact"] | {key: value}})
    counts = planned(finished)
    write(path, content)
    assert counts["connect_nodes"] == len(BASES)
    assert counts["solve_response"] == SOLVED_OF[case]
    assert not {"build_assembly", "apply_preload", "find_modes"} & set(counts)


def test_another_number_of_regions_to_compare_leaves_the_rest_alone(finished):
    counts = planned(finished, "--config", "convergence={regions: [2, 3]}")
    assert counts["tabulate_divisions"] == 1
    assert not {"find_peaks", "find_patterns", "partition_regions", "solve_response"} & set(counts)


def test_another_contact_adapted_basis_leaves_other_bases_alone(finished):
    counts = planned(finished, "--config", "contact_adapted_basis={levels: 6}")
    assert counts["find_pod_modes"] == 1
    assert counts["find_modes"] == 1
    assert counts["connect_nodes"] == len(CASES)
    assert counts["solve_response"] == 3
    assert not {"apply_preload", "partition_regions"} & set(counts)


def test_another_tolerance_or_fit_leaves_joints_of_a_number_alone(finished):
    path = finished / "config/cases/small.yaml"
    write(path, CASE | {"regions": {"tolerance": 0.02}})
    # only pages tell of it
    assert not {"partition_regions", "solve_response"} & set(planned(finished))
    write(path, CASE | {"regions": {"motion": "load-weighted"}})
    counts = planned(finished)
    write(path, CASE)
    # clusters move as they did
    assert counts["partition_regions"] == 1
    assert counts["tabulate_joint"] == counts["fit_reduced_joint"] == 1
    # the source's fit, not the harmonic one
    counts = planned(finished, "--config", "fitting={starts: 3}")
    assert counts["fit_reduced_joint"] == len(CASES)


def test_another_division_leaves_the_nodes_alone(finished):
    path = finished / "config/cases/variable.yaml"
    write(path, VARIABLE | {"regions": {"division": "equal-load"}})
    counts = planned(finished)
    write(path, VARIABLE)
    assert counts["partition_regions"] == counts["fit_reduced_joint"] == 1
    # in one kind of coordinates, of the two joints that are divided
    assert counts["solve_response"] == 2
    assert not {"connect_nodes", "build_assembly", "apply_preload", "find_modes"} & set(counts)


def test_sampled_friction_solves_anew_and_leaves_the_joints_alone(finished):
    counts = planned(finished, "--config", "solver={friction: sampled}")
    assert counts["solve_response"] == counts["time_solver"] == sum(SOLVED_OF.values())
    joints = {"connect_nodes", "partition_regions", "fit_reduced_joint", "tabulate_joint"}
    assert not (joints | {"build_assembly", "apply_preload", "find_modes"}) & set(counts)
    # a march in time checks exact forces only, of which it checks those of linear coordinates
    assert "check_solutions" not in counts
    counts = planned(finished, "--config", "solver={largest_step: 0.06}")
    assert counts["check_solutions"] == sum(CHECKED_OF.values())


def test_sampled_friction_has_as_many_harmonics_as_are_asked_for(finished, tmp_path):
    where = "results/cases/variable/free-2/regions=2/linear/resonance=1/response.nc"
    shutil.copytree(finished, tmp_path / "project")
    # the backbone and the complex mode of the other case have one harmonic
    options = ["--config", "cases=[variable]"]
    options += ["solver={friction: sampled, harmonics: 3, samples: 64}"]
    table = "results/tables/accuracy_variable_free-2.csv"
    assert "check_solutions" not in planned(tmp_path / "project", table, *options)
    ran = snakemake(tmp_path / "project", where, *options)
    assert ran.returncode == 0, ran.stderr
    with xr.open_dataset(tmp_path / "project" / where) as response:
        components = response["component"].to_numpy().tolist()
        assert components == ["bias", "sin", "cos", "sin2", "cos2", "sin3", "cos3"]
        assert response["complete"].all()
        for harmonic in (2, 3):
            parts = [f"sin{harmonic}", f"cos{harmonic}"]
            assert response["modal_coordinate"].sel(component=parts).any()
        with xr.open_dataset(finished / where) as exact:
            assert exact["component"].to_numpy().tolist() == components[:3]
            # the further harmonics change little of the first
            assert float(response["peak_frequency"][0]) == pytest.approx(
                float(exact["peak_frequency"][0]), rel=1e-2
            )


def test_another_description_runs_nothing(finished):
    case = finished / "config/cases/small.yaml"
    write(case, CASE | {"description": "Other words"})
    counts = planned(finished)
    write(case, CASE)
    assert counts == {}


STRUCTURE = {"build_assembly", "apply_preload", "find_modes", "find_pod_modes"}
JOINTS = {"connect_nodes", "partition_regions", "fit_reduced_joint", "tabulate_joint"}
SOLVES = {"solve_response", "time_solver", "find_backbone", "check_solutions"}


@pytest.mark.parametrize(
    ("file", "runs", "rests"),
    [
        ("src/boltjoint/joint/fitting.py", "fit_reduced_joint", STRUCTURE | {"partition_regions"}),
        ("src/boltjoint/structure/preload.py", "apply_preload", {"build_assembly"}),
        ("src/boltjoint/structure/basis/pod.py", "find_pod_modes", {"apply_preload"}),
        ("src/boltjoint/solvers/arc_length.py", "solve_response", STRUCTURE | JOINTS),
        ("src/boltjoint/tables.py", "compare_accuracy", STRUCTURE | JOINTS | SOLVES),
        ("src/boltjoint/estimate.py", None, STRUCTURE | JOINTS | SOLVES),
        ("workflow/scripts/plot_mesh.py", "plot_mesh", STRUCTURE | JOINTS | SOLVES),
    ],
)
@pytest.mark.parametrize("date", ["older", "newer"])
def test_editing_the_code_runs_what_uses_it(finished, file, runs, rests, date):
    path = finished / file
    text, times = path.read_text(), (path.stat().st_atime, path.stat().st_mtime)
    path.write_text(text + "\n# edited\n")
    if date == "older":
        os.utime(path, (0, 0))
    counts = planned(finished)
    path.write_text(text)
    os.utime(path, times)
    assert not rests & set(counts)
    assert runs in counts if runs else counts == {}


def test_code_of_another_date_runs_nothing(finished):
    for folder in ("src", "workflow"):
        for path in (finished / folder).rglob("*.py"):
            os.utime(path)
    assert planned(finished) == {}


def test_a_damaged_result_is_named_and_its_job_leaves_a_traceback(finished):
    damaged = finished / "results/cases/small/free-2/regions=2/joint.nc"
    table = "results/tables/regions_small_free-2_regions=2.csv"
    kept = damaged.read_bytes()
    damaged.write_bytes(kept[: len(kept) // 2])
    ran = snakemake(finished, table)
    damaged.write_bytes(kept)
    assert ran.returncode != 0
    (line,) = [each for each in ran.stderr.splitlines() if "delete it and run again" in each]
    assert str(damaged.relative_to(finished)) in line and "cannot be read" in line
    assert "Traceback" not in ran.stderr
    log = finished / "results/logs/tabulate_regions/small_free-2_regions=2.log"
    assert "Traceback" in log.read_text() and line in log.read_text()
    # what it would have written is gone, and comes back with what it is made from
    assert snakemake(finished).returncode == 0
    assert planned(finished) == {}


def test_whatever_is_written_is_asked_for_so_that_it_is_made_again_once_lost(finished):
    written = {
        path.relative_to(finished).as_posix()
        for path in (finished / "results").rglob("*")
        if path.is_file() and path.relative_to(finished).parts[1] not in ("logs", "benchmarks")
    }
    # the report is asked for by another command
    written.discard("results/report.html")
    assert written == set(layout.targets(load_study(finished)))


def test_a_lost_result_is_made_again(finished):
    lost = finished / "results/cases/small/free-2/regions=2/joint.nc"
    kept = lost.read_bytes()
    lost.unlink()
    assert planned(finished).get("partition_regions") == 1
    assert snakemake(finished, str(lost.relative_to(finished))).returncode == 0
    assert lost.read_bytes() == kept


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("preload_N", -1, ["config/cases/small.yaml", "preload_N", "must be greater than 0"]),
        ("forces", [1], ["config/cases/small.yaml", "forces: is not a known key", "forces_N"]),
        ("assembly", "six_bolt", ['"six_bolt"', "config/assemblies", "two_bolt"]),
        ("published", "five_bolt", ["published", '"five_bolt"', "three_bolt_constant"]),
        ("coordinates", ["rdnm-3"], ["coordinates[0]", "must not have more modes", "free-2"]),
    ],
)
def test_bad_input_stops_before_any_job(finished, key, value, words):
    case = finished / "config/cases/small.yaml"
    write(case, CASE | {key: value})
    ran = snakemake(finished)
    write(case, CASE)
    assert ran.returncode != 0
    for word in words:
        assert word in ran.stderr
    assert "Traceback" not in ran.stderr
    assert "rule " not in ran.stderr


def test_a_mesh_too_large_for_the_machine_stops_before_any_job(finished):
    assembly = finished / "config/assemblies/two_bolt.yaml"
    write(assembly, ASSEMBLY | {"mesh": ASSEMBLY["mesh"] | {"layers_per_half_height": 10**7}})
    ran = snakemake(finished, "--dry-run")
    write(assembly, ASSEMBLY)
    assert ran.returncode != 0
    # a dry run says everything on its standard output
    said = ran.stdout + ran.stderr
    (line,) = [each for each in said.splitlines() if "GiB" in each]
    assert line.startswith("config/assemblies/two_bolt.yaml: mesh: needs some ")
    assert "Traceback" not in said
    assert "rule " not in said and "job " not in said


def test_what_a_run_needs_and_bolts_that_yield_are_told_once(finished):
    case = finished / "config/cases/small.yaml"
    preload = "results/assemblies/two_bolt/preload=40000/preload.nc"
    write(case, CASE | {"preload_N": 40000})
    ran = snakemake(finished, preload)
    write(case, CASE)
    shutil.rmtree((finished / preload).parent)
    assert ran.returncode == 0, ran.stderr
    assert ran.stderr.count("Estimate: ") == 1
    by_file = "config/cases/small.yaml: preload_N: a preload of 40000 N strains the shanks"
    assert ran.stderr.count(by_file) == 1
    log = finished / "results/logs/apply_preload/two_bolt_40000.log"
    assert "WARNING boltjoint.structure.statics: a preload of 40000 N strains" in log.read_text()


def test_a_solve_that_breaks_off_is_flagged_and_the_study_goes_on(finished):
    options = ["--config", "cases=[variable]", "solver={maximum_solutions: 3}"]
    table = finished / "results/tables/accuracy_variable_free-2.csv"
    ran = snakemake(finished, str(table.relative_to(finished)), *options)
    assert ran.returncode == 0, ran.stderr
    broken = pd.read_csv(table)
    assert not broken["complete"].any()
    assert set(broken["reason"]) == {"the branch has more solutions than allowed"}
    assert snakemake(finished, str(table.relative_to(finished))).returncode == 0
    assert pd.read_csv(table)["complete"].any()
