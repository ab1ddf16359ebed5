"""Runs that are interrupted or repeated, that meet bad input, damaged files or broken branches."""

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from planned import planned
from small_study import (
    ASSEMBLY,
    CASE,
    COMMAND,
    SWEEP,
    environment,
    run,
    snakemake,
    write,
    write_config,
)

from boltjoint import dataset
from boltjoint.structure.model_limits import LIMITS

#: what is made of every sort of file: basis, joint, response, table, figure, page and sweep
REPEATED = [
    "results/assemblies/two_bolt/enriched-8/modes.nc",
    "results/cases/small/free-2/clusters=2/harmonic=2/joint.nc",
    "results/figures/loops_variable_free-2_regions=2_elements=2.svg",
    "results/report/structure.html",
    "results/sweeps/grid/sweep.nc",
    "results/sweeps/shares/explore.html",
]
#: what depends on the clock, or records the machine
TIMED = ("timing.csv", "fit_timing.csv", "times_", "fits_")


@pytest.fixture(scope="module")
def again(project, tmp_path_factory):
    """Part of the small study, killed as by a power cut after its first result, and made again."""
    folder = shutil.copytree(project, tmp_path_factory.mktemp("again") / "study")
    write_config(folder)
    first = folder / "results/assemblies/two_bolt/assembly.nc"
    with subprocess.Popen(
        [*COMMAND, *REPEATED],
        cwd=folder,
        env=environment(folder),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as running:
        while not first.exists():
            assert running.poll() is None, "the run ended before its first result"
            time.sleep(0.1)
        os.killpg(running.pid, signal.SIGKILL)
    assert not (folder / REPEATED[-1]).exists()
    assert "cannot be locked" in snakemake(folder, *REPEATED).stderr
    run(folder, "--unlock", *REPEATED)
    # sets of strings have another order
    run(folder, *REPEATED, seed=2)
    return folder


def test_a_killed_run_goes_on_and_two_runs_give_the_same_bytes(again, finished):
    made = {path.relative_to(again) for path in (again / "results").rglob("*.*") if path.is_file()}
    compared = [
        path
        for path in sorted(made)
        if path.parts[1] not in ("logs", "benchmarks") and not path.name.startswith(TIMED)
    ]
    suffixes = {".nc", ".vtu", ".csv", ".b2", ".svg", ".html"}
    assert suffixes == {path.suffix for path in compared}
    for path in compared:
        assert (again / path).read_bytes() == (finished / path).read_bytes(), path


@pytest.mark.parametrize(
    ("damaged", "made_of_it", "rule"),
    [
        ("cases/small/free-2/clusters=2/joint.nc", "harmonic=2/joint.nc", "reduce_joint"),
        ("sweeps/grid/chunks/1.nc", "../sweep.nc", "gather_sweep"),
        (
            "cases/small/free-2/node-to-node/linear/resonance=1/check.csv",
            f"{6 * '../'}tables/accuracy_small_free-2.csv",
            "tabulate",
        ),
        ("environment.json", "report/overview.html", "write_overview"),
    ],
)
def test_a_damaged_result_is_named_and_made_again_once_it_is_deleted(
    copied, damaged, made_of_it, rule
):
    made_of_it = os.path.normpath(f"results/{Path(damaged).parent}/{made_of_it}")
    damaged = copied / "results" / damaged
    kept = damaged.read_bytes(), (copied / made_of_it).read_bytes()
    damaged.write_bytes(kept[0][: len(kept[0]) // 2])
    ran = snakemake(copied, made_of_it)
    assert ran.returncode != 0
    told = [each for each in ran.stderr.splitlines() if "delete it and run again" in each]
    (line,) = [each for each in told if each.startswith("     error: ")]
    # and again at the end, above its log
    *_, reason, where = ran.stderr.splitlines()
    assert [reason] == [each for each in told if each.startswith("failed: ")]
    assert where.startswith("  log: results/logs/") and rule in where
    assert str(damaged.relative_to(copied)) in line and "checksum" in line
    assert "Traceback" not in ran.stderr
    logs = {path: path.read_text() for path in (copied / "results/logs").rglob("*.log")}
    said = line.split(": ", 2)[2]
    ((path, log),) = [each for each in logs.items() if said in each[1]]
    assert rule in str(path.relative_to(copied))
    assert "Traceback" in log
    # what it would have written is gone, and comes back with what it is made from
    assert not (copied / made_of_it).exists()
    damaged.unlink()
    run(copied, made_of_it)
    assert kept == (damaged.read_bytes(), (copied / made_of_it).read_bytes())


def test_peaks_have_all_harmonics_where_these_are_asked_for(copied):
    where = "results/cases/variable/free-2/regions=2/linear/resonance=1/response.nc"
    before = dataset.load(copied / where)
    assert (before["peak_harmonics"] >= 9).all()
    for name in ("peak_frequency", "peak_amplitude"):
        ratio = before[f"{name}_converged"] / before[name]
        assert ((ratio > 0.5) & (ratio < 2) & (ratio != 1)).all()
        assert (abs(1 / ratio - 1) <= before[f"{name}_error"]).all()
    run(copied, where, "--config", "cases=[variable]", "sweeps=[]", "converged_peaks=false")
    found = dataset.load(copied / where)
    assert "peak_harmonics" not in found
    for name in ("peak_frequency", "peak_amplitude"):
        np.testing.assert_array_equal(found[name], before[name])


def test_responses_have_as_many_harmonics_as_their_peaks_need(copied):
    where = "results/cases/variable/free-2/regions=2/linear/resonance=1/response.nc"
    chosen = "{friction_force: aft, harmonics: auto, harmonic_tolerance: 0.2, time_samples: 64}"
    options = ["cases=[variable]", "sweeps=[]", "omit=[timing, checks]", f"solver={chosen}"]
    run(copied, where, "--config", *options)
    found = dataset.load(copied / where)
    np.testing.assert_array_equal(found["response_harmonics"], found["peak_harmonics"])
    np.testing.assert_allclose(
        found["peak_amplitude"], found["peak_amplitude_converged"], rtol=0.01
    )
    highest = int(found["response_harmonics"].max())
    assert highest > 9
    assert found["component"].to_numpy()[-1] == f"cos{highest}"


def test_sampled_friction_has_as_many_harmonics_as_are_asked_for(copied, finished):
    where = "results/cases/variable/free-2/regions=2/linear/resonance=1/response.nc"
    # the backbone and the complex mode of the other case have one harmonic
    options = ["cases=[variable]", "solver={friction_force: aft, harmonics: 3, time_samples: 64}"]
    run(copied, where, "--config", *options)
    with xr.open_dataset(copied / where) as response:
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


def test_a_branch_that_breaks_off_is_flagged_and_the_study_goes_on(copied):
    table = "results/tables/accuracy_variable_free-2.csv"
    options = ["cases=[variable]", "omit=[timing, checks]", "solver={maximum_solutions: 3}"]
    run(copied, table, "--config", *options)
    broken = pd.read_csv(copied / table)
    assert not broken["complete"].any()
    assert set(broken["reason"]) == {"the branch has more solutions than allowed"}
    # without that option they are solved as before
    assert table in planned(copied, table)


def test_what_a_run_needs_and_bolts_that_yield_are_told_once(copied):
    preload = "results/assemblies/two_bolt/preload=40000/preload.nc"
    write(copied / "config/cases/small.yaml", CASE | {"preload_N": 40000})
    said = run(copied, preload)
    assert said.count("Estimate: ") == 1
    by_file = "config/cases/small.yaml: preload_N: a preload of 40000 N strains the shanks"
    assert said.count(by_file) == 1
    log = copied / "results/logs/apply_preload/two_bolt_40000.log"
    assert "WARNING boltjoint.structure.preload: a preload of 40000 N strains" in log.read_text()


#: keys of a case that are wrong, and what is said of each
BAD_KEYS = {
    "a": ({"preload_N": -1}, "preload_N: -1 must be greater than 0"),
    "b": ({"forces": [1]}, "forces: is not a known key; did you mean forces_N?"),
    "c": ({"assembly": "six_bolt"}, 'assembly: "six_bolt" is not in config/assemblies'),
    "d": ({"published": "five_bolt"}, 'published: "five_bolt" is no case study of the source'),
    "e": ({"coordinates": ["rdnm-3"]}, 'coordinates[0]: "rdnm-3" must not have more modes than'),
}


def test_bad_input_stops_before_any_job(project, tmp_path):
    folder = shutil.copytree(project, tmp_path / "study")
    write_config(folder, {name: CASE | keys for name, (keys, _) in BAD_KEYS.items()})
    said = refused(folder)
    for name, (_, words) in BAD_KEYS.items():
        assert f"config/cases/{name}.yaml: {words}" in said


def test_a_mesh_too_large_for_the_machine_stops_before_any_job(project, tmp_path):
    folder = shutil.copytree(project, tmp_path / "study")
    mesh = ASSEMBLY["mesh"] | {"layers_per_half_height": 10**7}
    write(folder / "config/assemblies/two_bolt.yaml", ASSEMBLY | {"mesh": mesh})
    (line,) = [each for each in refused(folder).splitlines() if "GiB" in each]
    assert line.startswith("config/assemblies/two_bolt.yaml: mesh: needs some ")


def refused(folder):
    """What a run says that stops before any job."""
    ran = snakemake(folder)
    assert ran.returncode != 0
    said = ran.stdout + ran.stderr
    assert "Traceback" not in said
    assert "rule " not in said and "job " not in said
    return said


REACHED = [f"peak_{limit.name}" for limit in LIMITS]


def test_a_design_is_what_it_is_as_a_case_of_its_own(copied):
    # with a preload of its own, which a sweep takes from that of the base case
    contact = CASE["contact"] | {"friction_coefficient": 0.3}
    solve = [{"resonance": 1, "joints": [SWEEP["joint"]]}]
    alone = CASE | {"preload_N": 12000, "contact": contact, "coordinates": ["linear"]}
    write_config(copied, {"small": CASE, "alone": alone | {"modes": ["free-2"], "solve": solve}})
    where = f"results/cases/alone/free-2/{SWEEP['joint']}/linear/resonance=1/response.nc"
    run(copied, where)
    sweep = dataset.load(copied / "results/sweeps/grid/sweep.nc")
    design = sweep.sel(preload=12000, friction_coefficient=0.3)
    response = dataset.load(copied / where)
    np.testing.assert_allclose(design["force_level"], response["force_level"])
    for name in ("peak_frequency", "peak_amplitude"):
        np.testing.assert_allclose(design[name], response[name], rtol=1e-9)
    # the sweep does not observe amplitudes with all harmonics, by which shares of a response are
    scale = response["peak_amplitude"] / response["peak_amplitude_converged"]
    for name in REACHED:
        np.testing.assert_allclose(design[name], scale * response[name], rtol=1e-9)
    np.testing.assert_array_equal(design["contact_state"], response["contact_state"])
