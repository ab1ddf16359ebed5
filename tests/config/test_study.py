"""The study: what is shipped, and what is said where files do not go together."""

import csv
import shutil

import pytest
import yaml
from mutations import ROOT

from boltjoint import names
from boltjoint.config.case import Case
from boltjoint.config.makers import description_of
from boltjoint.config.strict_yaml import parse_mapping
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.reproduction.published import BASIS

CONFIG = "config/config.yaml"
CASE = "config/cases/three_bolt_constant.yaml"
HIGH = "config/cases/three_bolt_constant_38kN.yaml"
ASSEMBLY = "config/assemblies/three_bolt.yaml"
FOUR = "config/assemblies/four_bolt.yaml"
THREE = "config/assemblies/three_bolt.yaml"


def edit(study, file, old, new):
    path = study / file
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{old!r} is no longer in {file}"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def problems_of(study, changes=None):
    with pytest.raises(ConfigError) as caught:
        load_study(study, changes)
    assert str(caught.value).splitlines() == list(caught.value.problems)
    return list(caught.value.problems)


@pytest.mark.parametrize("file", sorted((ROOT / "config").glob("*.yaml")), ids=lambda f: f.stem)
def test_sweeps_of_shipped_studies_are_on_the_page_of_a_case(file):
    study = load_study(ROOT, {"study": f"config/{file.name}"})
    assert {sweep.case for sweep in study.sweeps.values()} <= set(study.cases)


def test_shipped_study_is_the_source_study():
    study = load_study(ROOT)
    assert list(study.cases) == [
        "three_bolt_constant",
        "three_bolt_constant_38kN",
        "four_bolt_constant",
        "three_bolt_variable",
        "three_bolt_variable_soft",
        "four_bolt_variable",
    ]
    assert set(study.assemblies) == {"three_bolt", "four_bolt"}
    # the published numbers of contact nodes
    assert study.assemblies["three_bolt"].contact_pairs == 1370
    assert study.assemblies["four_bolt"].contact_pairs == 1693
    assert study.solver.sampling is None

    with (ROOT / "resources/source/case_studies.csv").open(encoding="utf-8", newline="") as file:
        source = {row["case"]: row for row in csv.DictReader(file)}
    assert {case.published for case in study.cases.values()} == set(source)
    for name, case in study.cases.items():
        row, contact = source[case.published], case.contact
        assert (case.assembly, contact.law) == (row["assembly"], row["contact_law"]), name
        assert contact.tangential_stiffness_N_per_m == 1e6 * float(row["k_u_kN_per_mm"]), name
        normal = getattr(contact, "normal_stiffness_N_per_m", None)
        assert normal == (1e6 * float(row["k_v_kN_per_mm"]) if row["k_v_kN_per_mm"] else None)
        assert contact.friction_coefficient == float(row["mu"]), name
        if name != "three_bolt_constant_38kN":
            assert case.preload_N == float(row["preload_per_bolt_N"]), name
        assert case.forces_N == tuple(float(force) for force in row["forces_N"].split()), name
        regions = {f"regions={count}" for count in row["regions"].split()}
        assert {"node-to-node", *regions} <= set(case.joints(BASIS)), name
        division = "equal-load" if contact.law == "constant" else "equal-middle-load"
        assert (case.regions.division, case.regions.motion) == (division, "mean"), name
        # beside the source's basis may stand one that holds the contact
        assert case.bases[0] == BASIS, name
        assert all(basis.is_contact_adapted for basis in case.bases[1:]), name
        for family in case.bases:
            solved = {which[2] for which in case.responses if which[:2] == (family, "node-to-node")}
            assert {"linear", "backbone"} <= solved, name


def test_shipped_cases_that_differ_in_one_thing_differ_in_nothing_else():
    study = load_study(ROOT)
    stated, implied = (study.case(f"three_bolt_constant{end}") for end in ("", "_38kN"))
    assert (stated.preload_N, implied.preload_N) == (10000, 37976)
    # of two that differ so little, one has more to it
    same = {"preload_N", "verification_forces_N", "solve"}
    assert stated.model_dump(exclude=same) == implied.model_dump(exclude=same)
    assert set(implied.responses) < set(stated.responses)

    stiff, soft = (study.case(f"three_bolt_variable{end}") for end in ("", "_soft"))
    for stiffness in ("tangential_stiffness_N_per_m", "normal_stiffness_N_per_m"):
        assert getattr(soft.contact, stiffness) == getattr(stiff.contact, stiffness) / 2
    same = {"published", "contact", "verification_forces_N", "solve"}
    assert set(soft.responses) < set(stiff.responses)
    assert stiff.model_dump(exclude=same) == soft.model_dump(exclude=same)


def test_every_shipped_file_is_valid_even_if_unused():
    for validate, folder in ((Case.model_validate, "cases"), (description_of, "assemblies")):
        files = sorted((ROOT / "config" / folder).glob("*.yaml"))
        assert files
        for file in files:
            validate(parse_mapping(file.read_text(encoding="utf-8")))


def only_linear(study):
    """The study of one case, with nothing but responses in linear modes."""
    case = parse_mapping((study / CASE).read_text(encoding="utf-8"))
    case |= {"coordinates": ["linear"], "solve": case["solve"][:2]}
    (study / CASE).write_text(yaml.safe_dump(case), encoding="utf-8")
    text = (study / CONFIG).read_text(encoding="utf-8")
    first = text.index("  - three_bolt_constant_38kN")
    last = text.index("\n\n", first)
    (study / CONFIG).write_text(text[:first] + text[last:], encoding="utf-8")


def test_too_few_samples_for_the_harmonics_are_seen_though_left_to_the_default(study):
    only_linear(study)
    assert problems_of(study, {"solver": {"friction_force": "aft", "harmonics": 33}}) == [
        "command line: solver.time_samples: must be at least 264, 8 for each harmonic"
    ]


def test_unknown_case_of_a_study_is_named():
    with pytest.raises(KeyError, match="did you mean three_bolt_constant"):
        load_study(ROOT).case("three_bolt_constnat")


def test_folder_without_a_study(tmp_path):
    assert problems_of(tmp_path) == [f"{CONFIG}: there is no such file in {tmp_path.resolve()}"]


def test_problems_of_several_files_are_reported_together(study):
    edit(study, CONFIG, "cases:", "fitting: {initial_guesses: 0}\ncases:")
    edit(study, CASE, "preload_N: 10000", "preload_N: -1")
    edit(study, CASE, "- regions=4", "- regions=x")
    edit(study, HIGH, "resonance: 2", "resonance: 9")
    edit(study, FOUR, "lap_mm: 132", "lap_mm: 100")
    edit(study, FOUR, "head_diameter_mm: 13", "head_diameter_mm: 25")
    problems = problems_of(study)
    assert [problem.split(": ")[:2] for problem in problems] == [
        [CONFIG, "fitting.initial_guesses"],
        [CASE, "preload_N"],
        [CASE, "solve[0].joints[1]"],
        [HIGH, "solve[1].resonance"],
        [FOUR, "bolts.head_diameter_mm"],  # wider than the bar
        [FOUR, "bolts.head_diameter_mm"],  # longer than the bolt cell
        [FOUR, "bolts.positions_from_lap_start_mm[3]"],
    ]


def test_assembly_shared_by_cases_is_reported_once(study):
    edit(study, ASSEMBLY, "lap_mm: 110.5", "lap_mm: -1")
    assert problems_of(study) == [f"{ASSEMBLY}: bar.lap_mm: -1 must be greater than 0"]


def test_assembly_of_a_faulty_case_is_checked_too(study):
    edit(study, CASE, "preload_N: 10000", "preload_N: -1")
    edit(study, ASSEMBLY, "lap_mm: 110.5", "lap_mm: -1")
    problems = problems_of(study, {"cases": ["three_bolt_constant"]})
    assert [problem.split(":")[0] for problem in problems] == [CASE, ASSEMBLY]


def test_smallest_basis_bounds_the_coordinates_and_resonances(study):
    edit(study, CASE, "[free-4]", "[free-16, free-2]")
    edit(study, CASE, "rdnm-1]", "rdnm-2, rdnm-3]")
    edit(study, CASE, "resonance: 2", "resonance: 3")
    assert problems_of(study) == [
        f'{CASE}: coordinates[2]: "rdnm-3" must not have more modes than the basis free-2',
        f"{CASE}: solve[1].resonance: 3 must be at most 2, the modes of the basis free-2",
    ]


def test_windows_of_a_resonance_must_not_differ(study):
    given = "    coordinates: [linear, complex-rdnm-1, backbone]\n    window_Hz: [50, 90]\n"
    edit(study, CASE, "    coordinates: [complex-rdnm-1, backbone]\n", "    window_Hz: [60, 90]\n")
    edit(study, CASE, "    joints: [node-to-node]", "    joints: [regions=2]")
    edit(study, CASE, "    coordinates: [linear, complex-rdnm-1, backbone]\n", given)
    assert problems_of(study) == [
        f"{CASE}: solve[4].window_Hz: [50, 90] must be [60, 90], as of the block before it around "
        "resonance 1"
    ]


def test_a_problem_of_the_case_in_several_blocks_is_reported_once(study):
    edit(study, CASE, "[linear, rdnm-1]", "[linear, rdnm-9]")
    assert problems_of(study) == [
        f'{CASE}: coordinates[1]: "rdnm-9" must not have more modes than the basis free-4'
    ]


def test_chosen_harmonics_are_for_responses_alone(study):
    solver = {"friction_force": "aft", "harmonics": "auto"}
    settings = {"cases": ["three_bolt_constant"], "solver": solver, "sweeps": []}
    (timed,) = problems_of(study, settings)
    assert timed == "config/config.yaml: omit: must hold timing with solver.harmonics: auto"
    settings |= {"omit": ["timing"], "sweeps": ["three_bolt_uncertainty"]}
    assert [each.partition(" must ")[2] for each in problems_of(study, settings)] == [
        "be empty with solver.harmonics: auto"
    ]
    found = problems_of(study, settings | {"sweeps": []})
    assert f"{CASE}: solve[2].coordinates[0]: " in found[0]
    assert found[0].endswith("must be linear or rdnm-N with solver.harmonics: auto")


def test_more_harmonics_need_coordinates_that_have_them(study):
    edit(study, CASE, "[linear, rdnm-1]", "[linear, complex-rdnm-2]")
    settings = {
        "cases": ["three_bolt_constant"],
        "solver": {"friction_force": "aft", "harmonics": 3},
    }
    must = "must be linear, rdnm-N or backbone with solver.harmonics: 3"
    assert problems_of(study, settings) == [
        f'{CASE}: coordinates[1]: "complex-rdnm-2" {must}',
        f'{CASE}: solve[2].coordinates[0]: "complex-rdnm-1" {must}',
        f'{CASE}: solve[4].coordinates[1]: "complex-rdnm-1" {must}',
    ]
    settings["solver"]["harmonics"] = 1
    load_study(study, settings)


def test_bolts_without_names_have_numbers(study):
    only = {"cases": ["three_bolt_constant"], "sweeps": []}
    by_name = "preload_N: 10000\nbolt_preloads_N: {bolt 2: 2500, bolt 3: 0}"
    edit(study, CASE, "preload_N: 10000", by_name)
    case = load_study(study, only).cases["three_bolt_constant"]
    assert (case.preload, case.preload_ratios) == ("10000,2500,0", (1.0, 0.25, 0.0))
    # the assembly has a preload for cases without
    edit(study, CASE, by_name, "")
    assert load_study(study, only).cases["three_bolt_constant"].preload == "10000"
    edit(study, THREE, "preload_N: 10000", "")
    assert problems_of(study, only) == [
        f"{CASE}: preload_N: is missing: three_bolt gives its bolts none"
    ]


def test_an_assembly_that_no_case_tightens_needs_a_preload_for_an_enriched_basis(study):
    settings = {"cases": ["three_bolt_constant"], "assemblies": ["four_bolt"]}
    edit(study, FOUR, "preload_N:", "# preload_N:")
    assert problems_of(study, settings) == [
        f"{FOUR}: preload_N: is missing: enriched-40 is made from the contact under preload"
    ]
    only_linear(study)
    load_study(study, settings)


def test_unused_files_are_not_read(study):
    (study / "config/cases/draft.yaml").write_text("not: finished", encoding="utf-8")
    load_study(study)


def test_keys_of_a_study_file_and_of_the_command_line_replace_those_below(study):
    (study / "mine.yaml").write_text(
        "cases: [three_bolt_constant, four_bolt_constant]\n"
        "solver: {tolerance: 1e-6, maximum_iterations: 20}\n",
        encoding="utf-8",
    )
    usual = load_study(study)
    mine = load_study(study, {"study": "mine.yaml"})
    assert list(mine.cases) == ["three_bolt_constant", "four_bolt_constant"]
    assert (mine.solver.tolerance, mine.solver.maximum_iterations) == (1e-6, 20)
    assert mine.solver.target_iterations == usual.solver.target_iterations
    # the command line gives words
    changes = {"solver": {"tolerance": "1e-7", "quasi_static_correction": "false"}}
    changes["cases"] = ["four_bolt_constant"]
    over = load_study(study, {"study": str(study / "mine.yaml"), **changes})
    assert list(over.cases) == ["four_bolt_constant"]
    assert (over.solver.tolerance, over.solver.maximum_iterations) == (1e-7, 20)
    assert over.solver.quasi_static_correction is False


@pytest.mark.parametrize(
    ("text", "changes", "line"),
    [
        (
            "fitting: {initial_guesses: 0}",
            {},
            "mine.yaml: fitting.initial_guesses: 0 must be at least 1",
        ),
        ("solver: 5", {}, "mine.yaml: solver: 5 must hold keys with values"),
        ("fittings: {}", {}, "mine.yaml: fittings: is not a known key; did you mean fitting?"),
        ("cases: [three]", {}, 'mine.yaml: cases[0]: "three" is not in config/cases;'),
        (
            "fitting: {initial_guesses: 5}",
            {"fitting": {"initial_guesses": "no"}},
            'command line: fitting.initial_guesses: "no" must be a whole number',
        ),
        (
            "convergence: {regions: [0]}",
            {"convergence": {"time_integration_N": ["1"]}},
            "mine.yaml: convergence.regions[0]: 0 must be at least 1",
        ),
        (
            "solver: {maximum_iterations: 3}",
            {},
            f"{CONFIG}: solver.target_iterations: 5 must be less than maximum_iterations, 3",
        ),
        (
            "solver: {}",
            {"solver": {"tolerance": ".inf"}},
            'command line: solver.tolerance: ".inf" must be a finite number',
        ),
        (
            "fitting: {}",
            {"study": "a\0b"},
            'command line: study: "a\\u0000b" must be the name of a file',
        ),
        ("fitting: {}", {"study": 5}, "command line: study: 5 must be the name of a file"),
        ("fitting: {}", {"study": None}, "command line: study: null must be the name of a file"),
        ("fitting: {}", {"study": "no.yaml"}, "no.yaml: there is no such file in "),
        ("fitting: {}", {"study": "config"}, "config: cannot be read: Is a directory"),
        (
            "fitting: {}",
            {"study": 300 * "a"},
            f'"{56 * "a"}...: cannot be read: File name too long',
        ),
        ("study: other.yaml", {}, "mine.yaml: study: is not a known key; there are: cases,"),
    ],
)
def test_a_problem_is_said_of_the_place_that_gives_the_value(study, text, changes, line):
    edit(study, CONFIG, "cases:", "solver: {target_iterations: 5}\ncases:")
    (study / "mine.yaml").write_text(text, encoding="utf-8")
    (problem,) = problems_of(study, {"study": "mine.yaml", **changes})
    assert problem.startswith(line)


def test_a_basis_has_a_bound(study):
    edit(study, CASE, "modes: [free-4]", "modes: [free-301]")
    assert problems_of(study) == [
        f'{CASE}: modes[0]: "free-301" must be free-N, all-N, enriched-N or enriched-auto, N being '
        f"the number of modes, at most {names.MOST_MODES}"
    ]
    edit(study, CASE, "modes: [free-301]", "modes: [free-300]")
    load_study(study)


def test_published_case_must_be_one_of_the_source(study):
    edit(study, CASE, "published: three_bolt_constant", "published: three_bolt_constat")
    load_study(study)  # without a list any name will do
    published = [case.published for case in load_study(ROOT).cases.values()]
    with pytest.raises(ConfigError) as error:
        load_study(study, published=published)
    (problem,) = error.value.problems
    assert problem.startswith(f'{CASE}: published: "three_bolt_constat" is no case study')
    assert "did you mean three_bolt_constant" in problem


def test_a_case_cannot_be_called_as_a_page_of_the_report(study):
    shutil.copy(study / CASE, study / "config/cases/overview.yaml")
    edit(study, CONFIG, "- three_bolt_constant_38kN", "- overview")
    assert problems_of(study) == [
        f'{CONFIG}: cases[1]: "overview" must be another name: the report has a page called so'
    ]
