"""What a study needs, against meshes that were built and memory that was measured."""

import pytest
import yaml
from small_study import ASSEMBLY, CASE, ROOT, SALTELLI, SETTINGS, mesh_of, write

from boltjoint.config.described import mesh_size
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.study import load_study
from boltjoint.study import memory_and_time_of_study as needs
from boltjoint.study.artefact_list import Contents
from boltjoint.study.memory_and_time_of_jobs import jobs_on

GIB = 2**30


def changed(content, **of_mesh):
    return content | {"mesh": content["mesh"] | of_mesh}


@pytest.fixture
def study(tmp_path):
    """The small study with other keys of its assembly, its case or its options."""

    def read(assembly=ASSEMBLY, case=CASE, **settings):
        write(tmp_path / "config/assemblies/two_bolt.yaml", assembly)
        write(tmp_path / "config/cases/small.yaml", case)
        write(tmp_path / "config/config.yaml", SETTINGS | settings)
        return load_study(tmp_path)

    return read


@pytest.mark.parametrize(
    "divisions",
    [
        {},
        {"ring_cells_across_width": 6, "ring_cells_along_bar": 7},
        {"rings_under_head": 2, "rings_head_to_cell_edge": 3},
        {"columns_between_bolt_cells": 3, "columns_at_each_lap_end": 2},
        {"layers_per_half_height": 3, "element_length_free_mm": 7},
        {"element_length_free_mm": 1000, "rings_in_shank": 2, "layers_in_head": 3},
    ],
)
def test_a_mesh_is_counted_as_it_is_built(divisions):
    content = changed(ASSEMBLY, **divisions)
    configured = LapJoint.model_validate(content)
    built = mesh_of(content).sizes
    assert mesh_size(configured) == (built["node"], built["element"], built["pair"])


@pytest.mark.parametrize(
    ("case", "measured"), [("three_bolt_constant", 1.684), ("four_bolt_constant", 2.422)]
)
def test_memory_is_what_was_measured(case, measured):
    settings = yaml.safe_load((ROOT / "config/config.yaml").read_text()) | {"cases": [case]}
    found = needs.estimate(load_study(ROOT, settings))
    # the formulas are that near to all measurements of the finite elements
    assert found.memory / GIB == pytest.approx(measured, rel=0.15)


def test_a_small_study_needs_little(study):
    found = needs.estimate(study())
    # the machine that it was measured on took 163 s
    assert 50 < found.seconds < 500
    assert found.responses == 18  # nine of two forces
    # 97 harmonics of its eight vectors take 25 MB, and 99 of its peaks
    convergence = SETTINGS["convergence"] | {"time_integration_N": []}
    without = needs.estimate(study(convergence=convergence))
    assert without.memory < 0.52 * GIB
    assert needs.shortage(without, 0.52 * GIB) is None
    assert found.memory < without.memory + 30e6
    assert needs.summary(found, 8 * GIB, 2).startswith("Estimate: 18 frequency responses in ")


@pytest.mark.parametrize(
    "divisions",
    [
        {"ring_cells_across_width": 400, "layers_per_half_height": 300},
        {"ring_cells_along_bar": 10**6},
        {"layers_per_half_height": 10**30},
        {"layers_in_head": 10**9},
        {"element_length_free_mm": 1e-9},
        {"element_length_free_mm": 1e-30},
    ],
)
def test_a_mesh_that_no_machine_holds_is_refused_by_its_key(study, divisions):
    found = needs.estimate(study(changed(ASSEMBLY, **divisions)))
    line = needs.shortage(found, 1000 * GIB)
    assert line.startswith("config/assemblies/two_bolt.yaml: mesh: needs some ")
    assert line.endswith(" and this machine has 1e+03 GiB: must be smaller")
    assert "\n" not in line


def test_layers_of_washers_are_refused_as_other_divisions(study):
    washers = ASSEMBLY["bolts"] | {"washer": {"thickness_mm": 1.6, "diameter_mm": 16}}
    with_washers = ASSEMBLY | {"bolts": washers}
    thick = {"thickness_mm": 1e9, "diameter_mm": 16}
    for content in (
        changed(with_washers, layers_in_washer=10**9),
        with_washers | {"bolts": ASSEMBLY["bolts"] | {"washer": thick}},
    ):
        line = needs.shortage(needs.estimate(study(content)), 1000 * GIB)
        assert line.startswith("config/assemblies/two_bolt.yaml: mesh: needs some ")


def test_yield_is_told_by_the_modulus_of_the_bolts(study):
    aluminium = {"youngs_modulus_GPa": 70, "poissons_ratio": 0.33, "density_kg_per_m3": 2700}
    steel = {"youngs_modulus_GPa": 206, "poissons_ratio": 0.3, "density_kg_per_m3": 7850}
    bars = ASSEMBLY | {"material": aluminium}
    own = bars | {"bolts": ASSEMBLY["bolts"] | {"material": steel}}
    case = CASE | {"preload_N": 13723}  # 0.39 % of aluminium, 0.13 % of steel in M8
    (line,) = needs.overstrained(study(bars, case))
    assert "strains the shanks by 0.39%" in line
    assert line.endswith("and has no steel bolts: bolts.material gives them")
    assert not needs.overstrained(study(own, case))
    (line,) = needs.overstrained(study(own, case | {"preload_N": 3 * 13723}))
    assert "strains the shanks by 0.40%" in line
    assert line.endswith("the model stays elastic")
    stronger = ASSEMBLY["bolts"] | {"material": {**steel, "yield_strength_MPa": 940}}
    assert not needs.overstrained(
        study(bars | {"bolts": stronger}, case | {"preload_N": 3 * 13723})
    )


def test_many_harmonics_are_refused_by_their_key(study):
    solver = {"friction_force": "aft", "harmonics": 10**4, "time_samples": 10**5}
    case = CASE | {"coordinates": ["linear"], "solve": CASE["solve"][:1]}
    found = needs.estimate(study(case=case, solver=solver))
    line = needs.shortage(found, 16 * GIB)
    assert line.startswith("config/config.yaml: solver.harmonics: needs some ")
    # so are many samples of few harmonics
    samples = {"friction_force": "aft", "time_samples": 10**8}
    line = needs.shortage(needs.estimate(study(case=case, solver=samples)), 16 * GIB)
    assert line.startswith("config/config.yaml: solver.time_samples: needs some ")
    # sampled friction with as many harmonics as it had in closed form is as small
    few = needs.estimate(study(case=case, solver={"friction_force": "aft"}))
    assert few.memory < 0.5 * GIB
    assert found.seconds > 1e4 * few.seconds


def test_what_fills_the_memory_is_refused_by_its_key(study, tmp_path):
    found = needs.estimate(study(fitting={"initial_guesses": 10**9}))
    line = needs.shortage(found, 16 * GIB)
    assert line.startswith("config/config.yaml: fitting.initial_guesses: needs some ")
    for key, observed in (("amplitudes", "backbone"), ("frequencies", "responses")):
        sweep = SALTELLI | {"observe": [observed], key: 10**9}
        write(tmp_path / "config/sweeps/shares.yaml", sweep)
        found = needs.estimate(study(sweeps=["shares"]))
        line = needs.shortage(found, 16 * GIB)
        assert line.startswith(f"config/sweeps/shares.yaml: {key}: needs some ")


def test_short_steps_take_as_many_solutions_as_there_may_be(study):
    default = needs.estimate(study()).seconds
    few = needs.estimate(study(solver={"largest_step": 1e-5})).seconds
    many = needs.estimate(
        study(solver={"largest_step": 1e-5, "smallest_step": 1e-9, "maximum_solutions": 10**6})
    )
    # up to 5000 solutions, and up to a million
    assert default < few < many.seconds


def test_a_march_in_a_large_basis_is_refused_by_its_case(study):
    case = CASE | {"modes": ["free-100"], "coordinates": ["linear"], "solve": CASE["solve"][:1]}
    line = needs.shortage(needs.estimate(study(case=case)), 8 * GIB)
    assert line.startswith("config/cases/small.yaml: ")
    assert "verification_forces_N" in line and "201 harmonics" in line
    without = needs.estimate(study(case=case | {"verification_forces_N": []}))
    assert needs.shortage(without, 8 * GIB) is None


def test_peaks_that_are_integrated_in_time_have_the_memory_that_was_measured():
    settings = yaml.safe_load((ROOT / "config/convergence.yaml").read_text())
    case = {"cases": ["three_bolt_variable"]}
    resources = needs.Resources(load_study(ROOT, settings | case))
    # 97 harmonics of 40 vectors: 2.8 GB
    needed = resources.of("steady_states", "three_bolt_variable")["mem_mb"]
    assert 2800 < needed < 2 * 2800
    # 33 of 80 vectors, and 99 of 40 for the truncation error of converged peaks
    assert 2400 < resources.of("larger_basis", "three_bolt_variable")["mem_mb"] < 2 * 2400
    assert 2800 < resources.of("responses", "three_bolt_variable")["mem_mb"] - 290 < 2 * 2800


def test_nothing_is_known_of_the_nodes_of_a_cluster(study):
    found = needs.estimate(study())
    assert needs.shortage(found, None) is None
    line = needs.summary(found, None, None)
    assert " of one core, starting from scratch" in line and line.endswith(")")


def test_jobs_of_a_sweep_have_room_for_what_they_take_and_no_more(study, tmp_path):
    def declare(sweep, jobs):
        # ten levels of nine thousand designs: a quarter of an hour
        content = SALTELLI | {"design": {"kind": "sobol", "number": 9000}}
        content |= {"levels": list(range(1, 11)), "designs_per_job": 9000 // jobs}
        write(tmp_path / f"config/sweeps/{sweep}.yaml", content)

    declare("one", 1)
    declare("ten", 10)
    resources = needs.Resources(study(sweeps=["one", "ten"]))
    one, ten = (resources.of("designs", sweep) for sweep in ("one", "ten"))
    # beside ten minutes that all jobs have
    assert one["runtime"] - 10 == pytest.approx(10 * (ten["runtime"] - 10), abs=10)
    assert one["mem_mb"] > ten["mem_mb"]
    # tasks of one job array have the same
    assert resources.of_any("designs") == one
    assert resources.of_any("unknown") == resources.SMALL
    # measured: a job with its two Snakemakes, where it compiles
    assert ten["mem_mb"] > 396 + 138 + 135


def test_weights_of_a_sweep_are_jobs_of_their_own(study, tmp_path):
    for name in ("one", "two"):
        write(tmp_path / f"config/sweeps/{name}.yaml", SALTELLI)
    write(tmp_path / "config/sweeps/all_pairs.yaml", SALTELLI | {"joint": "node-to-node"})
    sweeps = ["one"], ["one", "two"], ["one", "all_pairs"]
    assert [needs.estimate(study(sweeps=names)).joints for names in sweeps] == [1, 2, 2]

    def seconds(name):
        of_sweep = jobs_on(Contents(study(sweeps=[name])), name)
        return sum(job.seconds for job in of_sweep if job.stage == "weights")

    of_one = seconds("one")
    assert of_one > 0 == seconds("all_pairs")
    # those of the basis in which designs are checked are others
    check = {"basis": "free-4", "joint": SALTELLI["joint"]}
    write(tmp_path / "config/sweeps/one.yaml", SALTELLI | {"check": check})
    assert seconds("one") == pytest.approx(3 * of_one, rel=1e-12)  # four vectors beside two


def test_a_job_asks_for_the_time_of_its_own_basis_or_joint(study):
    """Times of all jobs of a case were asked for by each of them."""
    resources = needs.Resources(study(convergence=SETTINGS["convergence"]))

    def seconds(*arguments, **options):
        return needs.seconds_of_runtime(resources.of(*arguments, **options)["runtime"])

    bases = [seconds("responses", "small", basis) for basis in ("free-2", "enriched-8")]
    assert min(bases) > 0
    # each is rounded up to a minute of a machine of a third the speed
    assert seconds("responses", "small") == pytest.approx(sum(bases), abs=20)
    assert seconds("responses", "small", "free-4") == 0
    many = needs.Resources(study(fitting={"initial_guesses": 10**5}))
    # one of two that have as many elements
    parts = "free-2/regions=2/elements=2", ""
    one, both = (many.of("fit", "small", part)["runtime"] for part in parts)
    assert one - 10 == pytest.approx((both - 10) / 2, abs=1)


def test_the_machine_has_memory():
    assert 0.1 * GIB < needs.machine_memory() < 1e6 * GIB


def test_preloads_that_no_bolt_bears_are_told(study, tmp_path):
    assert needs.overstrained(study()) == []
    # 190 GPa, 8 mm: 0.42 %
    (line,) = needs.overstrained(study(case=CASE | {"preload_N": 40000}))
    assert line.startswith("config/cases/small.yaml: preload_N: a preload of 40000 N strains ")
    assert "by 0.42%" in line
    # an assembly that no case uses has a preload of its own
    write(tmp_path / "config/assemblies/spare.yaml", ASSEMBLY | {"preload_N": 50000})
    (line,) = needs.overstrained(study(assemblies=["spare"]))
    assert line.startswith("config/assemblies/spare.yaml: preload_N: a preload of 50000 N strains ")
