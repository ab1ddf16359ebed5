"""The configuration: what is shipped is right, and what is wrong is said in words."""

import csv
import doctest
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Literal, get_args, get_origin

import jsonschema
import pytest
import yaml
from pydantic import ValidationError

import boltjoint.config as sections
from boltjoint import names
from boltjoint.config.assembly import Assembly, Bar, Bolts, Material, Mesh, Point, StaticContact
from boltjoint.config.case import (
    Case,
    ConstantLoadContact,
    Regions,
    SolveBlock,
    VariableLoadContact,
)
from boltjoint.config.entries import Entry
from boltjoint.config.options import (
    ContactAdaptedBasis,
    Convergence,
    Fitting,
    Settings,
    Solver,
    Timing,
)
from boltjoint.config.schema import SCHEMAS, schema_text
from boltjoint.config.strict_yaml import parse_mapping
from boltjoint.config.study import Study, load_study
from boltjoint.config.types import ConfigError
from boltjoint.names import (
    Coordinates,
    coordinates_in_words,
    is_enriched,
    joint_in_words,
    parse_coordinates,
    parse_joint,
    parse_modes,
)
from boltjoint.study import layout
from boltjoint.study.published import BASIS

ROOT = Path(__file__).parents[1]
CONFIG = "config/config.yaml"
CASE = "config/cases/three_bolt_constant.yaml"
HIGH = "config/cases/three_bolt_constant_38kN.yaml"
VARIABLE = "config/cases/three_bolt_variable.yaml"
ASSEMBLY = "config/assemblies/three_bolt.yaml"
FOUR = "config/assemblies/four_bolt.yaml"


@pytest.fixture
def study(tmp_path):
    """A copy of the shipped study."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    return tmp_path


def edit(study, file, old, new):
    path = study / file
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{old!r} is no longer in {file}"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def shipped(name):
    """The study with the keys of another file of ``config/`` in place of its own."""
    return load_study(ROOT, {"study": f"config/{name}.yaml"})


def problems_of(study, changes=None):
    with pytest.raises(ConfigError) as caught:
        load_study(study, changes)
    assert str(caught.value).splitlines() == list(caught.value.problems)
    return list(caught.value.problems)


# ---- what is shipped


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
        assert all(map(is_enriched, case.bases[1:])), name
        for family in case.bases:
            solved = {which[2] for which in case.solved() if which[:2] == (family, "node-to-node")}
            assert {"linear", "backbone"} <= solved, name


def test_shipped_cases_that_differ_in_one_thing_differ_in_nothing_else():
    study = load_study(ROOT)
    stated, implied = (study.case(f"three_bolt_constant{end}") for end in ("", "_38kN"))
    assert (stated.preload_N, implied.preload_N) == (10000, 37976)
    # of two that differ so little, one has more to it
    same = {"preload_N", "verification_forces_N", "solve"}
    assert stated.model_dump(exclude=same) == implied.model_dump(exclude=same)
    assert set(implied.solved()) < set(stated.solved())

    stiff, soft = (study.case(f"three_bolt_variable{end}") for end in ("", "_soft"))
    for stiffness in ("tangential_stiffness_N_per_m", "normal_stiffness_N_per_m"):
        assert getattr(soft.contact, stiffness) == getattr(stiff.contact, stiffness) / 2
    same = {"published", "contact", "verification_forces_N", "solve"}
    assert set(soft.solved()) < set(stiff.solved())
    assert stiff.model_dump(exclude=same) == soft.model_dump(exclude=same)


def test_every_shipped_file_is_valid_even_if_unused():
    for model, folder in ((Case, "cases"), (Assembly, "assemblies")):
        files = sorted((ROOT / "config" / folder).glob("*.yaml"))
        assert files
        for file in files:
            model.model_validate(parse_mapping(file.read_text(encoding="utf-8")))


def test_shipped_options_are_the_defaults(study):
    shipped = load_study(study)
    (study / CONFIG).write_text("cases: [three_bolt_constant]\n", encoding="utf-8")
    bare = load_study(study)
    for options in ("contact_adapted_basis", "solver", "fitting", "timing"):
        assert getattr(bare, options) == getattr(shipped, options), options
    assert list(bare.assemblies) == ["three_bolt"]


def test_joints_are_listed_once_in_the_order_of_the_file():
    case = load_study(ROOT).case("three_bolt_constant")
    assert case.joints("free-4") == (
        "node-to-node",
        "regions=4",
        "regions=6",
        "regions=6/elements=4",
        "regions=6/elements=7",
        "regions=6/harmonic=7",
        "regions=6/table",
        "clusters=auto",
    )
    assert case.joints("enriched-40")[0] == "node-to-node"
    assert case.joints("free-16") == ()


def test_reduced_joint_needs_no_listed_regions(study):
    edit(study, CASE, "      - regions=6\n", "")
    assert "regions=6" not in load_study(study).case("three_bolt_constant").joints("free-4")


def test_window_of_a_resonance(study):
    edit(study, CASE, "# window_Hz: [low, high]", "window_Hz: [300, 5e2]")
    case = load_study(study).case("three_bolt_constant")
    assert case.window_around(1) is None
    assert case.window_around(2) == (300.0, 500.0)


def only_linear(study):
    """The study of one case, with nothing but responses in linear modes."""
    case = parse_mapping((study / CASE).read_text(encoding="utf-8"))
    case |= {"coordinates": ["linear"], "solve": case["solve"][:2]}
    (study / CASE).write_text(yaml.safe_dump(case), encoding="utf-8")
    text = (study / CONFIG).read_text(encoding="utf-8")
    first = text.index("  - three_bolt_constant_38kN")
    last = text.index("\n\n", first)
    (study / CONFIG).write_text(text[:first] + text[last:], encoding="utf-8")


def test_friction_sampled_in_time_may_have_more_harmonics(study):
    only_linear(study)
    edit(study, CONFIG, "friction: exact ", "friction: sampled ")
    edit(study, CONFIG, "harmonics: 1 ", "harmonics: 3 ")
    solver = load_study(study).solver
    assert solver.sampling == {"harmonics": 3, "samples": 256}
    assert solver.steps == load_study(ROOT).solver.steps
    edit(study, CONFIG, "harmonics: 3 ", "harmonics: 33 ")
    assert problems_of(study) == [
        f"{CONFIG}: solver.samples: 256 must be at least 264, 8 for each harmonic"
    ]


def test_too_few_samples_for_the_harmonics_are_seen_though_left_to_the_default(study):
    only_linear(study)
    edit(study, CONFIG, "  samples: 256 ", "  # samples: 256 ")
    assert problems_of(study, {"solver": {"friction": "sampled", "harmonics": 33}}) == [
        "command line: solver.samples: must be at least 264, 8 for each harmonic"
    ]


def test_a_case_may_leave_the_division_into_regions_to_its_default(study):
    edit(study, VARIABLE, "regions:\n  division: equal-middle-load ", "#")
    assert load_study(study).case("three_bolt_variable").regions.division == "equal-load"


def test_points_default_to_the_free_end(study):
    edit(study, ASSEMBLY, "# response: {x_mm: 403.5", "response: {x_mm: 100")
    assembly = load_study(study).assemblies["three_bolt"]
    free_end = Point(x_mm=403.5, y_mm=0, z_mm=10, direction="z")
    assert assembly.excitation_point == free_end
    assert assembly.response_point == free_end.model_copy(update={"x_mm": 100.0})


def test_a_dump_holds_what_results_depend_on():
    assembly = load_study(ROOT).assemblies["three_bolt"]
    renamed = assembly.model_copy(update={"description": "other words"})
    longer = assembly.model_copy(update={"bar": assembly.bar.model_copy(update={"lap_mm": 111.0})})
    assert renamed.model_dump() == assembly.model_dump()
    assert longer.model_dump() != assembly.model_dump()
    assert Assembly.model_validate(longer.model_dump()).bar.lap_mm == 111.0


def test_models_do_not_change_once_read():
    case = load_study(ROOT).case("three_bolt_constant")
    with pytest.raises(ValidationError, match="frozen"):
        case.preload_N = 1.0


def test_unknown_case_of_a_study_is_named():
    with pytest.raises(KeyError, match="did you mean three_bolt_constant"):
        load_study(ROOT).case("three_bolt_constnat")


# ---- names


@pytest.mark.parametrize(
    ("name", "parts", "words"),
    [
        ("node-to-node", (None, None, None, None), "node-to-node"),
        ("regions=1", ("regions", 1, None, None), "1 region"),
        ("regions=auto", ("regions", "auto", None, None), "regions to tolerance"),
        ("clusters=12", ("clusters", 12, None, None), "12 clusters"),
        ("clusters=auto", ("clusters", "auto", None, None), "clusters to tolerance"),
        ("regions=6/elements=7", ("regions", 6, "elements", 7), "6 regions of 7 elements"),
        ("clusters=1/elements=1", ("clusters", 1, "elements", 1), "1 cluster of 1 element"),
        (
            "clusters=12/harmonic=7",
            ("clusters", 12, "harmonic", 7),
            "12 clusters of 7 elements, harmonic fit",
        ),
        (
            "regions=auto/harmonic=1",
            ("regions", "auto", "harmonic", 1),
            "regions to tolerance of 1 element, harmonic fit",
        ),
        ("regions=6/table", ("regions", 6, "table", None), "6 regions, tabulated"),
    ],
)
def test_a_joint_is_parsed_and_said_in_words(name, parts, words):
    parsed = parse_joint(name)
    assert tuple(parsed) == parts
    assert joint_in_words(name) == words
    if parsed.division is not None:
        # which is the folder above that of what stands for the elements
        assert parsed.regions == name.split("/")[0]
    # its name in tables and figures is told back
    assert layout.unflat(layout.flat(name)) == name


@pytest.mark.parametrize(
    "name",
    [
        "",
        "regions=0",
        "regions=6/",
        "regions=6/elements=0",
        "regions=06",
        "regions=6\n",
        "clusters",
        "clusters=",
        "clusters=automatic",
        "bands=6",
        "node-to-node/table",
        "regions=6/table=1",
        "regions=6/harmonic",
        "regions=6/elements=auto",
        "regions=6/elements=4/table",
        "regions=6/loops=4",
    ],
)
def test_other_names_of_joints_are_refused(name):
    with pytest.raises(ValueError, match=re.escape(repr(name))) as refused:
        parse_joint(name)
    for part in ("node-to-node", "regions=N", "clusters=N", "auto", "/elements=M", "/table"):
        assert part in str(refused.value)


def test_names_of_modes():
    assert [parse_modes(name) for name in ("free-16", "enriched-40")] == [16, 40]
    assert [is_enriched(name) for name in ("free-16", "enriched-40")] == [False, True]
    for name in ("free", "free-0", "enriched-", "enriched-04", "enrich-4", "free-4\n"):
        with pytest.raises(ValueError, match="must be free-N or enriched-N"):
            parse_modes(name)


@pytest.mark.parametrize(
    ("name", "parts", "words", "short"),
    [
        ("linear", ("linear", None), "linear modes", "linear modes"),
        ("backbone", ("backbone", None), "backbone", "backbone"),
        ("rdnm-1", ("real", 1), "1 response-dependent mode", "1 RDNM"),
        ("rdnm-2", ("real", 2), "2 response-dependent modes", "2 RDNM"),
        (
            "complex-rdnm-3",
            ("complex", 3),
            "3 complex response-dependent modes",
            "3 complex RDNM",
        ),
    ],
)
def test_coordinates_are_parsed_and_said_in_words(name, parts, words, short):
    assert parse_coordinates(name) == Coordinates(*parts)
    assert coordinates_in_words(name) == words
    assert coordinates_in_words(name, short=True) == short


@pytest.mark.parametrize(
    "name", ["", "linear-1", "backbone-1", "rdnm", "rdnm-0", "complex", "complex-rdnm", "rdnm-1\n"]
)
def test_other_names_of_coordinates_are_refused(name):
    with pytest.raises(ValueError, match="must be linear, backbone, rdnm-N or complex-rdnm-N"):
        parse_coordinates(name)


def test_examples_in_the_names_hold():
    ran = doctest.testmod(names)
    assert ran.attempted >= 6
    assert ran.failed == 0


# ---- blocks


def changed(**keys):
    """The shipped case of three bolts under constant load, other in some keys."""
    text = (ROOT / CASE).read_text(encoding="utf-8")
    return Case.model_validate(parse_mapping(text) | keys)


def test_a_block_may_have_its_own_modes_and_coordinates():
    case = changed(
        modes=["free-4", "free-8"],
        coordinates=["linear", "rdnm-1"],
        solve=[
            {"resonance": 2, "joints": ["node-to-node"]},
            {
                "resonance": 1,
                "modes": ["enriched-8", "free-8"],
                "coordinates": ["backbone"],
                "joints": ["clusters=2/table", "node-to-node"],
            },
        ],
    )
    assert case.bases == ("free-4", "free-8", "enriched-8")
    assert list(case.solved()) == [
        ("free-4", "node-to-node", "linear", 2),
        ("free-4", "node-to-node", "rdnm-1", 2),
        ("free-8", "node-to-node", "linear", 2),
        ("free-8", "node-to-node", "rdnm-1", 2),
        ("enriched-8", "clusters=2/table", "backbone", 1),
        ("enriched-8", "node-to-node", "backbone", 1),
        ("free-8", "clusters=2/table", "backbone", 1),
        ("free-8", "node-to-node", "backbone", 1),
    ]
    assert case.joints("free-4") == ("node-to-node",)
    assert case.joints("free-8") == ("node-to-node", "clusters=2/table")
    assert case.joints("enriched-8") == ("clusters=2/table", "node-to-node")
    assert [case.resonances(family) for family in case.bases] == [(2,), (2, 1), (1,)]


def test_a_basis_that_no_block_uses_is_not_made():
    block = {"resonance": 1, "joints": ["node-to-node"], "modes": ["enriched-8"]}
    assert changed(solve=[block]).bases == ("enriched-8",)


@pytest.mark.parametrize("name", ["three_bolt_constant", "four_bolt_variable"])
def test_nothing_is_solved_twice(name):
    solved = list(load_study(ROOT).case(name).solved())
    assert len(solved) == len(set(solved)) > 4


def test_blocks_of_a_resonance_share_its_window():
    first = {"resonance": 1, "joints": ["node-to-node"]}
    second = {"resonance": 1, "joints": ["regions=4"], "window_Hz": [60, 90]}
    assert changed(solve=[first, second]).window_around(1) == (60, 90)
    same = first | {"window_Hz": [60, 90]}
    assert changed(solve=[same, second]).window_around(1) == (60, 90)
    other = {"resonance": 2, "joints": ["node-to-node"], "window_Hz": [300, 500]}
    assert changed(solve=[other, second]).window_around(1) == (60, 90)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("regions=6", {"division": "equal-middle-load", "motion": "load-weighted", "count": 6}),
        (
            "regions=auto",
            {
                "division": "equal-middle-load",
                "motion": "load-weighted",
                "resonances": 2,
                "count": None,
                "tolerance": 0.02,
            },
        ),
        # clusters are divided by how pairs move, and their pairs move alike
        (
            "clusters=6",
            {"division": "clusters", "motion": "mean", "resonances": 2, "count": 6},
        ),
        (
            "clusters=auto",
            {
                "division": "clusters",
                "motion": "mean",
                "resonances": 2,
                "count": None,
                "tolerance": 0.02,
            },
        ),
    ],
)
def test_how_pairs_are_gathered(name, expected):
    regions = {"division": "equal-middle-load", "motion": "load-weighted", "tolerance": 0.02}
    case = changed(regions=regions)
    assert case.partition(name) == expected
    # of whatever stands for the elements
    assert case.partition(f"{name}/harmonic=3") == expected


def test_how_elements_are_fitted():
    fitting = Fitting(starts=3)
    loops = {"starts": 3, "load_fractions": (0.3, 0.6, 0.9)}
    assert fitting.fit("regions=6/elements=7") == {"count": 7, "method": "loops", **loops}
    # at all amplitudes, and from one start
    assert fitting.fit("clusters=auto/harmonic=4") == {"count": 4, "method": "describing-function"}


@pytest.mark.parametrize(
    ("modes", "joint", "coordinates", "expected"),
    [
        ("free-4", "node-to-node", "linear", ["analytic", "forward-difference"]),
        ("free-4", "regions=6", "rdnm-1", ["analytic", "forward-difference"]),
        ("free-4", "regions=6/elements=7", "linear", ["analytic", "forward-difference"]),
        ("free-4", "regions=6/harmonic=7", "linear", ["analytic"]),
        ("free-4", "clusters=auto", "linear", ["analytic"]),
        ("free-4", "node-to-node", "backbone", ["analytic"]),
        ("free-4", "node-to-node", "complex-rdnm-1", ["analytic"]),
        ("enriched-40", "node-to-node", "linear", ["analytic"]),
        ("enriched-40", "node-to-node", "backbone", ["analytic"]),
    ],
)
def test_forward_differences_are_timed_where_the_source_solves(modes, joint, coordinates, expected):
    assert layout.jacobians(modes, joint, coordinates) == expected


# ---- where results lie


def test_every_basis_is_found_once_and_tabulated_for_every_assembly():
    study = load_study(ROOT)
    assert layout.families(study) == ["free-4", "enriched-40"]
    targets = layout.targets(study)
    assert len(targets) == len(set(targets))
    for name in study.assemblies:
        assert f"results/assemblies/{name}/enriched-40/modes.nc" in targets
        assert layout.contact_of_basis(study, name) == (
            f"results/assemblies/{name}/preload=10000/preload.nc"
        )


def test_what_is_solved_is_shown_in_its_own_basis():
    targets = set(layout.targets(load_study(ROOT)))
    where = "three_bolt_constant_enriched-40"
    for path in (
        f"tables/accuracy_{where}.csv",
        f"tables/regions_{where}_clusters=12.csv",
        f"tables/elements_{where}_clusters=12_harmonic=7.csv",
        f"figures/loops_{where}_clusters=12_harmonic=7.svg",
        f"figures/response_{where}_node-to-node_complex-rdnm-1_resonance=1.svg",
        f"figures/states_{where}_node-to-node_complex-rdnm-1_resonance=1.svg",
        f"figures/backbone_{where}_resonance=1.svg",
    ):
        assert f"results/{path}" in targets, path
    for basis in ("free-4", "enriched-40"):
        assert f"results/tables/fits_three_bolt_constant_{basis}.csv" in targets
    # no states are drawn of what is rebuilt
    assert f"results/figures/states_{where}_node-to-node_backbone_resonance=1.svg" not in targets
    # resonance 2 is solved in the source's basis only
    assert "results/figures/times_three_bolt_constant_free-4_resonance=2.svg" in targets
    assert f"results/figures/times_{where}_resonance=2.svg" not in targets
    # a table has no elements to list, nor loops to compare
    case = "three_bolt_constant_free-4_regions=6_table"
    assert f"results/figures/response_{case}_linear_resonance=1.svg" in targets
    assert not [path for path in targets if path.startswith((f"results/tables/elements_{case}",))]
    assert not [path for path in targets if path.startswith((f"results/figures/loops_{case}",))]


def test_frequencies_and_shapes_are_shown_of_modes_not_of_vectors_that_hold_the_contact():
    targets = layout.targets(shipped("convergence"))
    shown = [path for path in targets if re.search("/(natural_frequencies|modes)_", path)]
    assert "results/tables/natural_frequencies_free-4.csv" in shown
    assert "results/figures/modes_four_bolt_free-4.svg" in shown
    assert not [path for path in shown if "enriched" in path]


def test_bases_and_regions_are_compared_with_converged_ones_only_where_asked_for(study):
    usual = layout.targets(load_study(study))
    assert "results/tables/models_three_bolt_constant.csv" in usual
    for kind in ("bases", "divisions", "patterns"):
        assert not [path for path in usual if f"/{kind}_" in path]
    asked_for = shipped("convergence")
    added = {path for path in layout.targets(asked_for) if path not in usual}
    subjects = {
        "bases": list(asked_for.cases),
        "divisions": [f"{case}_enriched-40" for case in asked_for.cases],
        "patterns": list(asked_for.assemblies),
    }
    for kind, of in subjects.items():
        for path in (f"tables/{kind}_{{}}.csv", f"figures/{kind}_{{}}.svg"):
            assert {f"results/{path.format(name)}" for name in of} <= added
    assert set(usual) <= set(layout.targets(asked_for))


def test_the_short_study_has_both_laws_and_both_assemblies_and_all_kinds_of_tables():
    short, whole = shipped("short"), shipped("convergence")
    assert {case.contact.law for case in short.cases.values()} == {"constant", "variable"}
    assert list(short.assemblies) == list(whole.assemblies)
    kinds = [
        {re.split("[_.]", Path(path).name)[0] for path in layout.targets(study)}
        for study in (short, whole)
    ]
    assert kinds[0] == kinds[1]


def test_a_march_in_time_checks_responses_in_all_modes_of_the_basis(study):
    found = load_study(study)
    names_of = ("linear", "rdnm-1", "complex-rdnm-1", "backbone")
    assert [layout.is_checked(found, name) for name in names_of] == [True, False, False, False]
    sampled = load_study(study, {"cases": list(found.cases), "solver": {"friction": "sampled"}})
    assert not layout.is_checked(sampled, "linear")


# ---- numbers


@pytest.mark.parametrize(
    "number",
    ["1e8", "1E+8", "100000000", "1.0e+8", "+1e8", "1.e8", "0x5f5e100"],
)
def test_numbers_as_people_write_them(study, number):
    edit(study, CASE, "N_per_m: 1.0e+8", f"N_per_m: {number}")
    case = load_study(study).case("three_bolt_constant")
    assert case.contact.tangential_stiffness_N_per_m == 1e8


def test_whole_numbers_as_people_write_them(study):
    edit(study, CONFIG, "maximum_solutions: 5000", "maximum_solutions: 5e3")
    most = load_study(study).solver.maximum_solutions
    assert most == 5000
    assert isinstance(most, int)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("true", "true"),
        ("yes", '"yes"'),
        ("1_000", '"1_000"'),
        ("1:30", '"1:30"'),
        ("10 kN", '"10 kN"'),
        ('"1e8"', '"1e8"'),
        ("0b11", '"0b11"'),
        ("null", "null"),
        ("[1]", "[1]"),
    ],
)
def test_what_is_no_number(study, text, shown):
    edit(study, CASE, "preload_N: 10000", f"preload_N: {text}")
    assert problems_of(study) == [f"{CASE}: preload_N: {shown} must be a number"]


# ---- one problem, one line with its exact words

A_JOINT = (
    "must be node-to-node, regions=N or clusters=N, N being a number below 1000000 or auto, "
    "alone or with /elements=M, /harmonic=M or /table"
)


@pytest.mark.parametrize(
    ("file", "old", "new", "line"),
    [
        # keys
        (
            CASE,
            "loss_factor:",
            "loss_facter:",
            "loss_facter: is not a known key; did you mean loss_factor? there are: description, "
            "published, assembly, preload_N, contact, regions, loss_factor, forces_N, "
            "verification_forces_N, modes, coordinates, solve",
        ),
        (
            CASE,
            "  law: constant",
            "  stiffness: 1\n  law: constant",
            "contact.stiffness: is not a known key; there are: law, "
            "tangential_stiffness_N_per_m, friction_coefficient",
        ),
        (
            CASE,
            "  law: constant",
            "  normal_stiffness_N_per_m: 1\n  law: constant",
            "contact.normal_stiffness_N_per_m: is a key only with law: variable",
        ),
        (
            VARIABLE,
            "  law: variable",
            "  gap_mm: 1\n  law: variable",
            "contact.gap_mm: is not a known key; there are: law, tangential_stiffness_N_per_m, "
            "normal_stiffness_N_per_m, friction_coefficient",
        ),
        (
            VARIABLE,
            "  division: equal-middle-load",
            "  divison: equal-middle-load",
            "regions.divison: is not a known key; did you mean division? "
            "there are: division, motion, tolerance",
        ),
        (
            CASE,
            "law: constant",
            "law: variable",
            "contact.normal_stiffness_N_per_m: is missing: Normal stiffness of each contact pair, "
            "in N/m.",
        ),
        (
            CASE,
            "    # window_Hz: [low, high]",
            "    window_hz: [1, 2]\n   #",
            "solve[1].window_hz: is not a known key; did you mean window_Hz? "
            "there are: resonance, joints, modes, coordinates, window_Hz",
        ),
        (CASE, "preload_N: 10000", "#", "preload_N: is missing: Preload of each bolt, in N."),
        (
            ASSEMBLY,
            "  width_mm: 20",
            "  #",
            "bar.width_mm: is missing: Width of both bars (y).",
        ),
        (ASSEMBLY, "[146.5, 146.5]", "[146.5]", "bar.free_length_mm[1]: is missing"),
        (
            ASSEMBLY,
            "[146.5, 146.5]",
            "[1, 2, 3]",
            "bar.free_length_mm: [1, 2, 3] must have at most 2 entries",
        ),
        # bases and regions that are compared
        (
            CONFIG,
            "\ntiming:",
            "\nconvergence: {bases: [free-4, enriched-81]}\ntiming:",
            'convergence.bases[1]: "enriched-81" must have at most 80 vectors, as contact_adapted_basis.most '  # noqa: E501
            "in config/config.yaml",
        ),
        (
            CONFIG,
            "\ntiming:",
            "\nconvergence: {bases: [enriched-40, free-80]}\ntiming:",
            'convergence.bases[1]: "free-80" must be enriched-N: all are compared with it',
        ),
        (
            CONFIG,
            "\ntiming:",
            "\nconvergence: {bases: [free-1, enriched-40]}\ntiming:",
            'convergence.bases[0]: "free-1" must be free-N or enriched-N, N being the number of '
            "modes, from 2 to 100",
        ),
        (
            CONFIG,
            "\ntiming:",
            "\nconvergence: {regions: [4, 4]}\ntiming:",
            "convergence.regions[1]: 4 must not appear twice",
        ),
        # single values
        (CASE, "preload_N: 10000", "preload_N: 0", "preload_N: 0 must be greater than 0"),
        (CASE, "0.001, 1,", "-1, 1,", "forces_N[0]: -1 must be greater than 0"),
        (CASE, "0.001, 1,", "0.0, 1,", "forces_N[0]: 0.0 must be greater than 0"),
        (CASE, "forces_N: [0.001,", "forces_N: 5 # [", "forces_N: 5 must be a list, as in [1, 2]"),
        (CASE, "[free-4]", "[]", "modes: [] must have at least 1 entry"),
        (CASE, "loss_factor: 0.002", "loss_factor: 0", "loss_factor: 0 must be greater than 0"),
        (CASE, "loss_factor: 0.002", "loss_factor: 1", "loss_factor: 1 must be less than 1"),
        (
            CASE,
            "[free-4]",
            "[free-0]",
            'modes[0]: "free-0" must be free-N or enriched-N, N being the number of modes, '
            "at most 100",
        ),
        (
            CASE,
            "rdnm-1]",
            "rdnm]",
            'coordinates[1]: "rdnm" must be linear, backbone, rdnm-N or complex-rdnm-N, '
            "N being the number of response-dependent modes, at most 100",
        ),
        (
            CASE,
            "- regions=4",
            "- regions=4/elements",
            f'solve[0].joints[1]: "regions=4/elements" {A_JOINT}',
        ),
        (
            CASE,
            "assembly: three_bolt ",
            "assembly: ../three_bolt ",
            'assembly: "../three_bolt" must be a file name without .yaml, '
            "of at most 64 letters, digits, _ and -",
        ),
        (CASE, "resonance: 1", "resonance: 1.5", "solve[0].resonance: 1.5 must be a whole number"),
        (
            CASE,
            "resonance: 1",
            "resonance: true",
            "solve[0].resonance: true must be a whole number",
        ),
        (CASE, "resonance: 1", "resonance: 0", "solve[0].resonance: 0 must be at least 1"),
        (CASE, "description: Three", "description: 3 #", "description: 3 must be text"),
        (
            CASE,
            "law: constant",
            "law: magic",
            'contact.law: "magic" must be constant or variable',
        ),
        (CASE, "law: constant", "law: 1", "contact.law: 1 must be constant or variable"),
        (
            CASE,
            "  law: constant",
            "  #",
            "contact.law: is missing: The contact law: constant or variable normal load.",
        ),
        (
            VARIABLE,
            "normal_stiffness_N_per_m: 1.0e+8",
            "normal_stiffness_N_per_m: 0",
            "contact.normal_stiffness_N_per_m: 0 must be greater than 0",
        ),
        (
            VARIABLE,
            "division: equal-middle-load",
            "division: equal-width",
            'regions.division: "equal-width" must be equal-load or equal-middle-load',
        ),
        (
            VARIABLE,
            "  division: equal-middle-load",
            "  motion: median",
            'regions.motion: "median" must be mean or load-weighted',
        ),
        (
            VARIABLE,
            "  division: equal-middle-load",
            "  tolerance: 0",
            "regions.tolerance: 0 must be greater than 0",
        ),
        (
            VARIABLE,
            "  division: equal-middle-load",
            "  tolerance: 1 %",
            'regions.tolerance: "1 %" must be a number',
        ),
        (
            VARIABLE,
            "regions:\n  division: equal-middle-load",
            "regions: equal-load\n ",
            'regions: "equal-load" must hold keys with values',
        ),
        (
            CONFIG,
            "friction: exact ",
            "friction: marched ",
            'solver.friction: "marched" must be exact or sampled',
        ),
        (
            CONFIG,
            "quasi_static_correction: true",
            "quasi_static_correction: yes",
            'solver.quasi_static_correction: "yes" must be true or false',
        ),
        (
            CONFIG,
            "basis_update: implicit ",
            "basis_update: before ",
            'solver.basis_update: "before" must be implicit or lagged',
        ),
        (
            CONFIG,
            "  levels: 14",
            "  steps: 15",
            "contact_adapted_basis.steps: is not a known key; there are: contact_stiffness_N_per_m, "  # noqa: E501
            "friction_coefficient, loss_factor, free_modes, resonances, levels, most",
        ),
        (
            CONFIG,
            "contact_stiffness_N_per_m: 1.0e+8",
            "contact_stiffness_N_per_m: 0",
            "contact_adapted_basis.contact_stiffness_N_per_m: 0 must be greater than 0",
        ),
        (
            CONFIG,
            "  levels: 14",
            "  levels: 0",
            "contact_adapted_basis.levels: 0 must be at least 1",
        ),
        (
            CONFIG,
            "free_modes: 12",
            "free_modes: 1",
            "contact_adapted_basis.resonances: 2 must be at most free_modes, 1",
        ),
        (CONFIG, "harmonics: 1 ", "harmonics: 0 ", "solver.harmonics: 0 must be at least 1"),
        (
            CONFIG,
            "samples: 256",
            "samples: 2.5",
            "solver.samples: 2.5 must be a whole number",
        ),
        (
            ASSEMBLY,
            "poissons_ratio: 0.3",
            "poissons_ratio: 0.5",
            "material.poissons_ratio: 0.5 must be less than 0.5",
        ),
        (
            ASSEMBLY,
            "ring_cells_across_width: 12",
            "ring_cells_across_width: 11",
            "mesh.ring_cells_across_width: 11 must be a multiple of 2",
        ),
        (
            ASSEMBLY,
            "# response: {x_mm: 403.5, y_mm: 0, z_mm: 10, direction: z}",
            "response: {x_mm: 403.5, y_mm: 0, z_mm: 10, direction: up}",
            'response.direction: "up" must be x, y or z',
        ),
        (
            CONFIG,
            "jacobian: analytic ",
            "jacobian: finite ",
            'solver.jacobian: "finite" must be analytic or forward-difference',
        ),
        (CONFIG, "repeats: 3", "repeats: 0", "timing.repeats: 0 must be at least 1"),
        (
            CONFIG,
            "0.6, 0.9]",
            "0.6, 1]",
            "fitting.load_fractions[2]: 1 must be less than 1",
        ),
        (
            VARIABLE,
            "regions:\n  division:",
            "regions:\n  #",
            "regions: null must hold keys with values",
        ),
        # values that contradict each other
        (CASE, "5, 10, 15", "5, 10, 5.0", "forces_N[4]: 5.0 must not appear twice"),
        (CASE, "5, 10, 15", "5, 10, 5e0", "forces_N[4]: 5.0 must not appear twice"),
        (
            CASE,
            "verification_forces_N: [1, 5",
            "verification_forces_N: [1, 6",
            "verification_forces_N[1]: 6 must be one of forces_N: 0.001, 1, 5, 10, 15, 25, 50",
        ),
        (
            CASE,
            "verification_forces_N: [1, 5",
            "verification_forces_N: [1, 1",
            "verification_forces_N[1]: 1 must not appear twice",
        ),
        (CASE, "[free-4]", "[free-4, free-4]", 'modes[1]: "free-4" must not appear twice'),
        (
            CASE,
            "[linear, rdnm-1]",
            "[linear, linear]",
            'coordinates[1]: "linear" must not appear twice',
        ),
        (
            CASE,
            "- regions=6\n",
            "- regions=4\n",
            'solve[0].joints[2]: "regions=4" must not appear twice',
        ),
        (
            CASE,
            "    joints: [node-to-node]",
            "    joints: [node-to-node, regions=4, node-to-node]",
            'solve[2].joints[2]: "node-to-node" must not appear twice',
        ),
        (
            CASE,
            "    modes: [enriched-40]",
            "    modes: [enriched-40, enriched-40]",
            'solve[4].modes[1]: "enriched-40" must not appear twice',
        ),
        (
            CASE,
            "[complex-rdnm-1, backbone]",
            "[backbone, backbone]",
            'solve[2].coordinates[1]: "backbone" must not appear twice',
        ),
        (
            CASE,
            "[complex-rdnm-1, backbone]",
            "[complex-rdnm-1, rdnm-1]",
            'solve[2].joints[0]: "node-to-node" must not be solved twice: a block before solves it '
            "around resonance 1 in the same basis and coordinates",
        ),
        (
            CASE,
            "resonance: 2\n    joints:\n      - node-to-node\n",
            "resonance: 1\n    joints:\n",
            'solve[1].joints[0]: "regions=6/elements=7" must not be solved twice: a block before '
            "solves it around resonance 1 in the same basis and coordinates",
        ),
        (
            CASE,
            "resonance: 2",
            "resonance: 5",
            "solve[1].resonance: 5 must be at most 4, the modes of the basis free-4",
        ),
        (
            CASE,
            "coordinates: [complex-rdnm-1, backbone]",
            "coordinates: [complex-rdnm-5, backbone]",
            'solve[2].coordinates[0]: "complex-rdnm-5" must not have more modes than the basis '
            "free-4",
        ),
        (
            CASE,
            "modes: [enriched-40]\n    coordinates: [linear,",
            "modes: [enriched-40, enriched-2]\n    coordinates: [rdnm-3,",
            'solve[4].coordinates[0]: "rdnm-3" must not have more modes than the basis enriched-2',
        ),
        (
            CASE,
            "modes: [enriched-40]",
            "modes: [enriched-81]",
            'solve[4].modes: "enriched-81" must have at most 80 vectors, as contact_adapted_basis.most '  # noqa: E501
            "in config/config.yaml",
        ),
        (
            CASE,
            "modes: [free-4]",
            "modes: [free-4, enriched-90]",
            'modes: "enriched-90" must have at most 80 vectors, as contact_adapted_basis.most in '
            "config/config.yaml",
        ),
        (CONFIG, "  most: 80", "  most: 0", "contact_adapted_basis.most: 0 must be at least 1"),
        (
            CASE,
            "resonance: 1            # in a basis that holds",
            "resonance: 3 #",
            "solve[4].resonance: 3 must be at most 2, contact_adapted_basis.resonances, in enriched-40",  # noqa: E501
        ),
        (
            CASE,
            "resonance: 1            # in the same basis",
            "resonance: 5 #",
            "solve[2].resonance: 5 must be at most 4, the modes of the basis free-4",
        ),
        (
            CASE,
            "modes: [enriched-40]",
            "modes: [enriched-101]",
            'solve[4].modes[0]: "enriched-101" must be free-N or enriched-N, '
            "N being the number of modes, at most 100",
        ),
        (
            CASE,
            "modes: [enriched-40]",
            "modes: [rich-40]",
            'solve[4].modes[0]: "rich-40" must be free-N or enriched-N, '
            "N being the number of modes, at most 100",
        ),
        (
            CASE,
            "modes: [enriched-40]",
            "modes: []",
            "solve[4].modes: [] must have at least 1 entry",
        ),
        (
            CASE,
            "modes: [enriched-40]",
            "modes: enriched-40",
            'solve[4].modes: "enriched-40" must be a list, as in [1, 2]',
        ),
        (
            CASE,
            "[complex-rdnm-1, backbone]",
            "[complex-rdnm-1, backbones]",
            'solve[2].coordinates[1]: "backbones" must be linear, backbone, rdnm-N or '
            "complex-rdnm-N, N being the number of response-dependent modes, at most 100",
        ),
        (
            VARIABLE,
            "joints: [clusters=auto]",
            "joints: [clusters=4, clusters=4/table]",
            'solve[2].joints[1]: "clusters=4/table" must not be tabulated: a table needs a '
            "constant normal load",
        ),
        (
            CASE,
            "coordinates: [linear, rdnm-1]",
            "coordinates: [linear, rdnm-5]",
            'coordinates[1]: "rdnm-5" must not have more modes than the basis free-4',
        ),
        (
            CASE,
            "# window_Hz: [low, high]",
            "window_Hz: [90, 90]",
            "solve[1].window_Hz: [90, 90] must be the lower frequency, then the higher one",
        ),
        (
            CASE,
            "- regions=4",
            "- regions=1371",
            'solve[0].joints[1]: "regions=1371" must have at most 719 regions, '
            "the contact pairs of three_bolt on one side of the centre line and on it",
        ),
        (
            ASSEMBLY,
            "hole_diameter_mm: 9",
            "hole_diameter_mm: 8",
            "bolts.hole_diameter_mm: 8 must be greater than the shank's diameter of 8 mm",
        ),
        (
            ASSEMBLY,
            "head_diameter_mm: 13",
            "head_diameter_mm: 9",
            "bolts.head_diameter_mm: 9 must be greater than the hole's diameter of 9 mm",
        ),
        (
            ASSEMBLY,
            "head_diameter_mm: 13",
            "head_diameter_mm: 20",
            "bolts.head_diameter_mm: 20 must be less than the bar's width of 20 mm",
        ),
        (
            ASSEMBLY,
            "bolt_cell_length_mm: 25",
            "bolt_cell_length_mm: 13",
            "bolts.head_diameter_mm: 13 must be less than the bolt cell's length of 13 mm",
        ),
        (
            ASSEMBLY,
            "25.25, 55.25,",
            "55.25, 25.25,",
            "bolts.positions_from_lap_start_mm: [55.25, 25.25, 85.25] must be ascending",
        ),
        (
            ASSEMBLY,
            "25.25, 55.25,",
            "47, 55.25,",
            "bolts.positions_from_lap_start_mm[1]: 55.25 is 8.25 mm from the bolt before it, where "
            "holes of 9 mm overlap or touch: must be more than 25 mm from it",
        ),
        (
            ASSEMBLY,
            "25.25, 55.25,",
            "45.25, 55.25,",
            "bolts.positions_from_lap_start_mm[1]: 55.25 is 10 mm from the bolt before it, where "
            "heads of 13 mm overlap or touch: must be more than 25 mm from it",
        ),
        (
            ASSEMBLY,
            "25.25, 55.25,",
            "30.25, 55.25,",
            "bolts.positions_from_lap_start_mm[1]: 55.25 is 25 mm from the bolt before it, where "
            "bolt cells of 25 mm overlap or touch: must be more than 25 mm from it",
        ),
        (
            ASSEMBLY,
            "25.25, 55.25,",
            "12.5, 55.25,",
            "bolts.positions_from_lap_start_mm[0]: 12.5 puts the bolt's cell outside the "
            "lap: must be more than 12.5 mm (half a bolt cell) from both ends of the lap "
            "of 110.5 mm",
        ),
        (
            ASSEMBLY,
            "lap_mm: 110.5",
            "lap_mm: 90",
            "bolts.positions_from_lap_start_mm[2]: 85.25 puts the bolt's cell outside the "
            "lap: must be more than 12.5 mm (half a bolt cell) from both ends of the lap of 90 mm",
        ),
        (
            ASSEMBLY,
            "# response: {x_mm: 403.5, y_mm: 0,",
            "excitation: {x_mm: 403.5, y_mm: -10.1,",
            "excitation.y_mm: -10.1 must lie in the assembly, from -10 to 10 mm",
        ),
        (
            CONFIG,
            "smallest_step: 1.0e-9",
            "smallest_step: 0.02",
            "solver.smallest_step: 0.02 must be less than 0.02",
        ),
        (
            CONFIG,
            "target_iterations: 4",
            "target_iterations: 12",
            "solver.target_iterations: 12 must be less than maximum_iterations, 12",
        ),
        (
            CONFIG,
            "[0.3, 0.6, 0.9]",
            "[0.3, 0.6, 0.6]",
            "fitting.load_fractions[2]: 0.6 must not appear twice",
        ),
        (
            CONFIG,
            "- three_bolt_constant_38kN",
            "- three_bolt_constant",
            'cases[1]: "three_bolt_constant" must not appear twice',
        ),
        (
            CONFIG,
            "\nsolver: ",
            "\nassemblies: [three_bolt, three_bolt]\nsolver: ",
            'assemblies[1]: "three_bolt" must not appear twice',
        ),
        (
            CONFIG,
            "harmonics: 1 ",
            "harmonics: 3 ",
            "solver.harmonics: 3 must be 1 with friction: exact; more need friction: sampled",
        ),
        (
            CONFIG,
            "harmonics: 1 ",
            "harmonics: 40 ",
            "solver.harmonics: 40 must be 1 with friction: exact; more need friction: sampled",
        ),
        (
            CONFIG,
            "samples: 256",
            "samples: 7",
            "solver.samples: 7 must be at least 8",
        ),
        # files
        (
            CONFIG,
            "- four_bolt_variable\n",
            "- four_bolt_varible\n",
            'cases[5]: "four_bolt_varible" is not in config/cases; did you mean '
            "four_bolt_variable? there are: four_bolt_constant, four_bolt_variable, "
            "three_bolt_constant, three_bolt_constant_38kN, three_bolt_variable, "
            "three_bolt_variable_soft",
        ),
        (
            CONFIG,
            "\nsolver: ",
            "\nassemblies: [six_screws]\nsolver: ",
            'assemblies[0]: "six_screws" is not in config/assemblies; '
            "there are: four_bolt, three_bolt",
        ),
        (
            CASE,
            "assembly: three_bolt ",
            "assembly: three_bolts ",
            'assembly: "three_bolts" is not in config/assemblies; did you mean three_bolt? '
            "there are: four_bolt, three_bolt",
        ),
    ],
)
def test_problem_is_said_in_one_line(study, file, old, new, line):
    edit(study, file, old, new)
    assert problems_of(study) == [f"{file}: {line}"]


# ---- files that are missing


def test_folder_without_a_study(tmp_path):
    assert problems_of(tmp_path) == [f"{CONFIG}: there is no such file in {tmp_path.resolve()}"]


# ---- several problems


def test_problems_of_several_files_are_reported_together(study):
    edit(study, CONFIG, "repeats: 3", "repeats: 0")
    edit(study, CASE, "preload_N: 10000", "preload_N: -1")
    edit(study, CASE, "- regions=4", "- regions=x")
    edit(study, HIGH, "resonance: 2", "resonance: 9")
    edit(study, FOUR, "lap_mm: 132", "lap_mm: 100")
    edit(study, FOUR, "head_diameter_mm: 13", "head_diameter_mm: 25")
    problems = problems_of(study)
    assert [problem.split(": ")[:2] for problem in problems] == [
        [CONFIG, "timing.repeats"],
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


def test_more_harmonics_need_coordinates_that_have_them(study):
    edit(study, CASE, "[linear, rdnm-1]", "[linear, complex-rdnm-2]")
    settings = {
        "cases": ["three_bolt_constant"],
        "solver": {"friction": "sampled", "harmonics": 3},
    }
    must = "must be linear or rdnm-N with solver.harmonics: 3"
    assert problems_of(study, settings) == [
        f'{CASE}: coordinates[1]: "complex-rdnm-2" {must}',
        f'{CASE}: solve[2].coordinates[0]: "complex-rdnm-1" {must}',
        f'{CASE}: solve[2].coordinates[1]: "backbone" {must}',
        f'{CASE}: solve[4].coordinates[1]: "complex-rdnm-1" {must}',
        f'{CASE}: solve[4].coordinates[2]: "backbone" {must}',
    ]
    settings["solver"]["harmonics"] = 1
    load_study(study, settings)


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


# ---- a study file and the command line


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
        ("timing: {repeats: 0}", {}, "mine.yaml: timing.repeats: 0 must be at least 1"),
        ("solver: 5", {}, "mine.yaml: solver: 5 must hold keys with values"),
        ("timings: {}", {}, "mine.yaml: timings: is not a known key; did you mean timing?"),
        ("cases: [three]", {}, 'mine.yaml: cases[0]: "three" is not in config/cases;'),
        (
            "timing: {repeats: 5}",
            {"timing": {"repeats": "no"}},
            'command line: timing.repeats: "no" must be a whole number',
        ),
        (
            "timing: {repeats: 0}",
            {"timing": {"time_budget_s": "1"}},
            "mine.yaml: timing.repeats: 0 must be at least 1",
        ),
        (
            "solver: {maximum_iterations: 3}",
            {},
            f"{CONFIG}: solver.target_iterations: 4 must be less than maximum_iterations, 3",
        ),
        (
            "timing: {}",
            {"timing": {"time_budget_s": ".inf"}},
            'command line: ".inf" must be a finite number',
        ),
        (
            "timing: {}",
            {"study": "a\0b"},
            'command line: study: "a\\u0000b" must be the name of a file',
        ),
        ("timing: {}", {"study": 5}, "command line: study: 5 must be the name of a file"),
        ("timing: {}", {"study": None}, "command line: study: null must be the name of a file"),
        ("timing: {}", {"study": "no.yaml"}, "no.yaml: there is no such file in "),
        ("timing: {}", {"study": "config"}, "config: cannot be read: Is a directory"),
        ("timing: {}", {"study": 300 * "a"}, f'"{56 * "a"}...: cannot be read: File name too long'),
        ("study: other.yaml", {}, "mine.yaml: study: is not a known key; there are: cases,"),
    ],
)
def test_a_problem_is_said_of_the_place_that_gives_the_value(study, text, changes, line):
    (study / "mine.yaml").write_text(text, encoding="utf-8")
    (problem,) = problems_of(study, {"study": "mine.yaml", **changes})
    assert problem.startswith(line)


# ---- a model made in code is checked like a file


def test_model_made_in_code_is_checked():
    with pytest.raises(ValidationError, match="must be greater than the shank's diameter"):
        Bolts(
            positions_from_lap_start_mm=(10,),
            shank_diameter_mm=9,
            hole_diameter_mm=9,
            head_diameter_mm=13,
            head_height_mm=5,
            nut_height_mm=6,
        )
    with pytest.raises(ValidationError, match="valid number"):
        Material(youngs_modulus_GPa=True, poissons_ratio=0.3, density_kg_per_m3=7900)


@pytest.mark.parametrize("bolts", [1, 2, 5])
def test_contact_pairs_count_the_nodes_of_the_plane(bolts):
    """Nodes counted cell by cell: each column of nodes once, rings once for each circle."""
    shipped = load_study(ROOT).assemblies["three_bolt"].model_dump()
    shipped["bar"]["lap_mm"] = 30.0 * bolts + 30
    shipped["bolts"]["positions_from_lap_start_mm"] = [30.0 * (i + 1) for i in range(bolts)]
    shipped["mesh"] |= {"columns_between_bolt_cells": 3, "columns_at_each_lap_end": 2}
    assembly = Assembly.model_validate(shipped)

    along, across = 10, 12
    inner_rings = 2 + 6  # the outermost ring of nodes is the edge of the cell
    on_circles = 2 * (along + across) * inner_rings
    on_cell_edges = 2 * (along + 1) + 2 * (across - 1)
    columns = 2 * (bolts - 1) + 2 * 2  # without those that are cell edges
    expected = bolts * (on_circles + on_cell_edges) + columns * (across + 1)
    assert assembly.contact_pairs == expected


# ---- schemas and README


@pytest.mark.parametrize("name", SCHEMAS)
def test_schema_is_that_of_the_model(name):
    kept = (ROOT / "config/schemas" / f"{name}.schema.json").read_text(encoding="utf-8")
    assert kept == schema_text(SCHEMAS[name]), "run: python -m boltjoint.config"


def test_command_writes_the_schemas(tmp_path):
    subprocess.run([sys.executable, "-m", "boltjoint.config.schema", str(tmp_path)], check=True)
    written = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()}
    assert written == {f"{name}.schema.json": schema_text(model) for name, model in SCHEMAS.items()}


def test_yaml_files_name_a_schema_that_accepts_them():
    files = [ROOT / CONFIG, *(ROOT / "config").glob("*/*.yaml")]
    assert len(files) >= 5
    for file in files:
        text = file.read_text(encoding="utf-8")
        named = re.match(r"# yaml-language-server: \$schema=(\S+)\n", text)
        assert named, f"{file} names no schema in its first line"
        schema = json.loads((file.parent / named[1]).read_text(encoding="utf-8"))
        jsonschema.validate(parse_mapping(text), schema)


def test_schema_refuses_what_the_model_refuses():
    text = (ROOT / CASE).read_text(encoding="utf-8")
    schema = json.loads(schema_text(Case))
    for old, new in (("1.0e+8", "true"), ("regions=4", "regons=4"), ("loss_factor", "loss")):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(parse_mapping(text.replace(old, new)), schema)


def readme_tables():
    """Rows of README by heading and bold section: meaning, unit, default and allowed by key."""
    tables = {}
    heading = section = ""
    for line in (ROOT / "config/README.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            heading, section = line.removeprefix("## "), ""
        elif line.startswith("**"):
            section = line.split("**")[1]
        elif row := re.match(r"\| `(\w+)` \|", line):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            tables.setdefault((heading, section), {})[row[1]] = cells[1:]
    return tables


TABLES = {
    ("config.yaml", ""): Settings,
    ("config.yaml", "contact_adapted_basis"): ContactAdaptedBasis,
    ("config.yaml", "solver"): Solver,
    ("config.yaml", "fitting"): Fitting,
    ("config.yaml", "timing"): Timing,
    ("config.yaml", "convergence"): Convergence,
    ("assemblies/*.yaml", ""): Assembly,
    ("assemblies/*.yaml", "bar"): Bar,
    ("assemblies/*.yaml", "material"): Material,
    ("assemblies/*.yaml", "bolts"): Bolts,
    ("assemblies/*.yaml", "mesh"): Mesh,
    ("assemblies/*.yaml", "contact"): StaticContact,
    ("assemblies/*.yaml", "excitation"): Point,
    ("cases/*.yaml", ""): Case,
    ("cases/*.yaml", "contact"): VariableLoadContact,
    ("cases/*.yaml", "regions"): Regions,
    ("cases/*.yaml", "solve"): SolveBlock,
}


@pytest.mark.parametrize("place", TABLES, ids="-".join)
def test_readme_has_every_key_and_its_default(place):
    fields = TABLES[place].model_fields
    written = readme_tables()[place]
    assert list(written) == list(fields)
    for key, field in fields.items():
        _, _, default, _ = written[key]
        assert (default == "required") == field.is_required(), key
        if isinstance(field.default, int | float | str | tuple) and field.default:
            assert parse_mapping(f"{key}: {default.strip('`')}") == {
                key: list(field.default) if isinstance(field.default, tuple) else field.default
            }


@pytest.mark.parametrize("place", TABLES, ids="-".join)
def test_readme_has_the_unit_in_the_key_and_every_word_to_choose_from(place):
    units = {"_mm": "mm", "_N": "N", "_s": "s", "_Hz": "Hz", "_GPa": "GPa", "_N_per_m": "N/m"}
    units |= {"_N_per_m3": "N/m³", "_kg_per_m3": "kg/m³"}
    for key, (_, unit, _, allowed) in readme_tables()[place].items():
        ends = [end for end in units if key.endswith(end)]
        assert unit in ([units[max(ends, key=len)]] if ends else ["", "1"]), key
        annotation = TABLES[place].model_fields[key].annotation
        if get_origin(annotation) is Literal and key != "law":
            named = re.findall("`([a-z-]+)`", allowed)
            assert named == list(get_args(annotation)), key


def test_readme_tells_which_keys_of_the_contact_only_one_law_has():
    constant, variable = ConstantLoadContact, VariableLoadContact
    written = readme_tables()["cases/*.yaml", "contact"]
    assert set(constant.model_fields) < set(variable.model_fields)
    for key, (meaning, _, _, _) in written.items():
        assert ("only with `law: variable`" in meaning) == (key not in constant.model_fields), key
    assert re.findall("`([a-z-]+)`", written["law"][3]) == ["constant", "variable"]


def test_readme_has_a_table_for_every_model():
    assert set(readme_tables()) == set(TABLES)
    models = {
        model
        for module in (sections.assembly, sections.case, sections.options, sections.study)
        for model in vars(module).values()
        if is_entry(model)
    }
    assert models - set(TABLES.values()) == {Study, ConstantLoadContact}


def is_entry(value):
    return isinstance(value, type) and issubclass(value, Entry) and value is not Entry


@pytest.mark.parametrize(
    ("new", "line"),
    [
        (
            "regions=1371",
            'solve[0].joints[1]: "regions=1371" must have at most 719 regions, '
            "the contact pairs of three_bolt on one side of the centre line and on it",
        ),
        (
            "clusters=1371/table",
            'solve[0].joints[1]: "clusters=1371/table" must have at most 1370 clusters, '
            "the contact pairs of three_bolt",
        ),
        (
            "clusters=auto/harmonic=1371",
            'solve[0].joints[1]: "clusters=auto/harmonic=1371" must have at most 1370 elements in '
            "all, the contact pairs of three_bolt",
        ),
        (
            "regions=6/elements=229",
            'solve[0].joints[1]: "regions=6/elements=229" must have at most 1370 elements in all, '
            "the contact pairs of three_bolt",
        ),
    ],
)
def test_a_joint_has_no_more_than_the_contact_pairs(study, new, line):
    edit(study, CASE, "- regions=4", f"- {new}")
    assert problems_of(study) == [f"{CASE}: {line}"]


def test_a_basis_has_a_bound(study):
    edit(study, CASE, "modes: [free-4]", "modes: [free-101]")
    assert problems_of(study) == [
        f'{CASE}: modes[0]: "free-101" must be free-N or enriched-N, N being the number of modes, '
        f"at most {names.MOST_MODES}"
    ]
    edit(study, CASE, "modes: [free-101]", "modes: [free-100]")
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
