"""The list of all files of a study, and what it says of each."""

import re
from pathlib import Path

import pytest

from boltjoint.config.study import load_study
from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.report.displays import DISPLAYS
from boltjoint.reproduction.case_studies import INDEX, name_timed_joints
from boltjoint.study import layout
from boltjoint.study.artefact_list import Artefact, Contents
from boltjoint.study.response_list import Response

ROOT = Path(__file__).parents[2]
INDEX_OF_TABLES = ROOT / "resources/source" / INDEX


@pytest.fixture(scope="module")
def contents():
    """The default study with the convergence of bases and regions."""
    return Contents(load_study(ROOT, {"study": "config/convergence.yaml"}), DISPLAYS)


def test_every_file_has_one_artefact(contents):
    files = contents.files()
    assert len(files) == len(set(files)) > 800
    assert all(path.startswith("results/") for path in files)


def test_files_lie_where_the_contract_says(contents):
    files = set(contents.files(form="data"))
    case = "results/cases/three_bolt_constant/free-4"
    assert {
        "results/assemblies/three_bolt/assembly.nc",
        "results/assemblies/three_bolt/free-4/modes.nc",
        "results/assemblies/three_bolt/preload=10000/preload.nc",
        f"{case}/node-to-node/joint.nc",
        f"{case}/regions=6/elements=7/joint.nc",
        f"{case}/regions=6/elements=7/linear/resonance=2/response.nc",
        f"{case}/regions=6/elements=7/linear/resonance=2/timing.csv",
    } <= files


def test_whatever_a_reduced_joint_is_made_from_is_made(contents):
    for artefact in contents.select("joint"):
        if artefact.joint.reduction is not None:
            which = artefact.fields | {"joint": artefact.joint.regions}
            assert contents.select("joint", **which)


def test_data_are_found_by_the_wildcards_of_their_kind(contents):
    for artefact in contents.select(form="data"):
        assert artefact.path == layout.PATHS[artefact.kind].format(**artefact.fields)


def test_every_table_has_a_title_and_every_figure_a_page(contents):
    for artefact in contents.select(form="table"):
        assert DISPLAYS.of(artefact).title_of(artefact)
        assert artefact.paths[1] == artefact.path.removesuffix("csv") + "html"
    # the overview has pictures of other pages
    pages = {artefact.kind for artefact in contents.select(form="page")} - {"overview"}
    figures = contents.select(form="figure")
    assert {DISPLAYS.of(each).page_of(each) for each in figures} == pages
    assert {each.case for each in DISPLAYS.on_page(contents, "three_bolt_variable")} == {
        "three_bolt_variable"
    }


def test_the_converged_response_is_that_of_the_largest_contact_adapted_basis(contents):
    assert contents.converged("three_bolt_constant") == Response("enriched-40", *REFERENCE, 1)


def test_forward_differences_are_timed_of_what_the_source_solves(contents):
    case = "three_bolt_constant"
    solved, timed = contents.responses(case), contents.by_differences(case)
    assert Response("free-4", "regions=6/elements=7", "rdnm-1", 1) in timed
    for model in (
        ("free-4", "regions=6/harmonic=7", "linear", 1),
        ("free-4", "node-to-node", "complex-rdnm-1", 1),
        ("enriched-40", "node-to-node", "linear", 1),
    ):
        assert model in solved
        assert model not in timed
    # of all that it solves, some have times of its own
    printed = Contents(load_study(ROOT), DISPLAYS, name_timed_joints(INDEX_OF_TABLES))
    assert {one[1:] for one in printed.by_differences(case)} == {
        (joint, coordinates, 1)
        for joint in ("node-to-node", "regions=6", "regions=6/elements=7")
        for coordinates in ("linear", "rdnm-1")
    }
    assert printed.by_differences("three_bolt_variable_soft") == []
    left_out = Contents(load_study(ROOT, {"omit": ["timing"]}), DISPLAYS)
    assert left_out.by_differences(case) == []
    by_differences = {"solver": {"jacobian": "forward-difference"}}
    assert Contents(load_study(ROOT, by_differences), DISPLAYS).by_differences(case) == []


def test_names_are_parsed(contents):
    for artefact in contents.select("response", form="data"):
        assert isinstance(artefact.joint, JointName)
        assert isinstance(artefact.coordinates, Coordinates)


def test_a_file_is_named_by_all_that_it_is_of():
    shown = Artefact("regions", "table", case="a", basis="free-4", joint=JointName("regions=6"))
    assert shown.paths == (
        "results/tables/regions_a_free-4_regions=6.csv",
        "results/tables/regions_a_free-4_regions=6.html",
        "results/tables/regions_a_free-4_regions=6.csv.b2",
    )


def shipped(name):
    """Contents of the study with the keys of another file of ``config/`` in place of its own."""
    return Contents(load_study(ROOT, {"study": f"config/{name}.yaml"}), DISPLAYS)


def test_every_basis_is_found_once_and_for_every_assembly():
    contents = Contents(load_study(ROOT), DISPLAYS)
    assert contents.bases() == ["free-4", "enriched-40"]
    files = contents.files()
    assert len(files) == len(set(files))
    for name in contents.study.assemblies:
        assert f"results/assemblies/{name}/enriched-40/modes.nc" in files
        assert f"results/assemblies/{name}/preload=10000/preload.nc" in files


def test_converged_peaks_are_found_in_a_larger_basis_if_there_is_one():
    contents = shipped("convergence")
    assert contents.bases_of_integration("three_bolt_variable") == ["enriched-40", "enriched-80"]
    found = contents.select("larger_basis")
    assert [each.case for each in found] == list(contents.study.cases)
    (shown,) = contents.select("larger_basis", case="three_bolt_variable")
    read = [path for each in DISPLAYS.of(shown).reads for path in each(contents, shown)]
    assert [(each.kind, each.basis) for each in read] == [
        ("joint", "enriched-80"),
        ("response", "enriched-40"),
    ]
    # the last basis is the one of the responses
    bases = {"convergence": {"bases": ["enriched-40"], "time_integration_N": [10]}}
    contents = Contents(load_study(ROOT, bases), DISPLAYS)
    assert contents.bases_of_integration("three_bolt_variable") == ["enriched-40"]
    assert contents.select("steady_states") and not contents.select("larger_basis")


def test_what_is_solved_is_shown_in_its_own_basis():
    files = set(Contents(load_study(ROOT), DISPLAYS).files())
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
        assert f"results/{path}" in files, path
    for basis in ("free-4", "enriched-40"):
        assert f"results/tables/fits_three_bolt_constant_{basis}.csv" in files
    # no contact states are drawn of synthesised responses
    assert f"results/figures/states_{where}_node-to-node_backbone_resonance=1.svg" not in files
    # resonance 2 is solved in the source's basis only
    assert "results/figures/times_three_bolt_constant_free-4_resonance=2.svg" in files
    assert f"results/figures/times_{where}_resonance=2.svg" not in files
    # a table has no elements to list, nor loops to compare
    case = "three_bolt_constant_free-4_regions=6_table"
    assert f"results/figures/response_{case}_linear_resonance=1.svg" in files
    assert not [path for path in files if path.startswith((f"results/tables/elements_{case}",))]
    assert not [path for path in files if path.startswith((f"results/figures/loops_{case}",))]


def test_frequencies_and_shapes_are_shown_of_modes_not_of_vectors_that_hold_the_contact():
    files = shipped("convergence").files()
    shown = [path for path in files if re.search("/(natural_frequencies|modes)_", path)]
    assert "results/tables/natural_frequencies_free-4.csv" in shown
    assert "results/figures/modes_four_bolt_free-4.svg" in shown
    assert not [path for path in shown if "enriched" in path]


def test_bases_and_regions_are_compared_with_converged_ones_only_where_asked_for():
    usual = Contents(load_study(ROOT), DISPLAYS).files()
    assert "results/tables/models_three_bolt_constant.csv" in usual
    for kind in ("bases", "divisions", "patterns", "reductions"):
        assert not [path for path in usual if f"/{kind}_" in path]
    asked_for = shipped("convergence")
    added = {path for path in asked_for.files() if path not in usual}
    subjects = {
        "bases": list(asked_for.study.cases),
        "divisions": [f"{case}_enriched-40" for case in asked_for.study.cases],
        "patterns": list(asked_for.study.assemblies),
    }
    assert "results/figures/reductions.svg" in added
    reduced = {
        f"results/tables/reductions_{case}_enriched-40.csv" for case in asked_for.study.cases
    }
    assert reduced <= added
    # tables and Iwan elements stand for a force that depends on one amplitude only
    joints = {case: asked_for.reduced(case) for case in asked_for.study.cases}
    assert "clusters=12/table" in joints["three_bolt_constant"]
    assert "clusters=12/elements=4" in joints["three_bolt_variable"]
    assert not {"clusters=12/table", "clusters=12/iwan"} & set(joints["three_bolt_variable"])
    for kind, of in subjects.items():
        for path in (f"tables/{kind}_{{}}.csv", f"figures/{kind}_{{}}.svg"):
            assert {f"results/{path.format(name)}" for name in of} <= added
    assert set(usual) <= set(asked_for.files())


def test_the_short_study_has_both_laws_and_all_but_times_and_checks():
    short, whole = shipped("short"), shipped("convergence")
    assert {case.contact.law for case in short.study.cases.values()} == {"constant", "variable"}
    kinds = [
        {re.split("[_.]", Path(path).name)[0] for path in contents.files()}
        for contents in (short, whole)
    ]
    assert kinds[1] - kinds[0] == {"check", "forward", "four", "models", "times"}


def test_the_residual_in_time_is_found_of_responses_in_all_modes_of_the_basis():
    found = Contents(load_study(ROOT), DISPLAYS)
    for case in found.study.cases:
        kinds = {response.coordinates.kind for response in found.checked(case)}
        assert kinds == {"linear"}
        aft = Contents(load_study(ROOT, {"solver": {"friction_force": "aft"}}), DISPLAYS)
        assert aft.checked(case) == []


def test_parts_can_be_left_out():
    left = {}
    for part in ("timing", "checks", "harmonics"):
        study = load_study(ROOT, {"omit": [part]})
        left[part] = {each.kind for each in Contents(study, DISPLAYS).artefacts}
    kinds = {each.kind for each in Contents(load_study(ROOT), DISPLAYS).artefacts}
    assert kinds - left["timing"] == {"forward_differences", "times", "models"}
    assert kinds - left["checks"] == {"check"}
    assert kinds - left["harmonics"] == {"harmonics"}
    study = load_study(ROOT, {"converged_peaks": False})
    one_harmonic = {each.kind for each in Contents(study, DISPLAYS).artefacts}
    assert kinds - one_harmonic == {"harmonic_peaks", "peak_motions"}
