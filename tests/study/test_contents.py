"""The list of all files of a study, and what it says of each."""

from pathlib import Path

import pytest

from boltjoint.config.study import load_study
from boltjoint.names import REFERENCE, Coordinates, JointName
from boltjoint.study import layout
from boltjoint.study.contents import Artefact, Contents, Response

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def contents():
    """The default study with the convergence of bases and regions."""
    return Contents(load_study(ROOT, {"study": "config/convergence.yaml"}))


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
            which = artefact.which | {"joint": artefact.joint.regions}
            assert contents.select("joint", **which)


def test_data_are_found_by_the_wildcards_of_their_kind(contents):
    for artefact in contents.select(form="data"):
        assert artefact.path == layout.PATHS[artefact.kind].format(
            **artefact.which
            | ({"preload_N": "10000"} if artefact.preload_N == 10000 else {})
            | ({"preload_N": "37976"} if artefact.preload_N == 37976 else {})
        )


def test_every_table_has_a_label_and_every_figure_a_page(contents):
    for artefact in contents.select(form="table"):
        assert artefact.label
        assert artefact.paths[1] == artefact.path.removesuffix("csv") + "html"
    pages = {artefact.kind for artefact in contents.select(form="page")}
    assert {each.page for each in contents.select(form="figure")} == pages


def test_the_converged_response_is_that_of_the_largest_contact_adapted_basis(contents):
    assert contents.converged("three_bolt_constant") == Response("enriched-40", *REFERENCE, 1)


def test_checks_are_of_linear_modes_only(contents):
    kinds = {each.coordinates for each in contents.select("check")}
    assert kinds == {"linear"}


def test_forward_differences_are_timed_of_what_the_source_solves(contents):
    def jacobians(joint, coordinates, basis="free-4"):
        (which,) = (
            each
            for each in contents.responses("three_bolt_constant", basis)
            if each == (basis, joint, coordinates, 1)
        )
        return contents.jacobians(which)

    both = ["analytic", "forward-difference"]
    assert jacobians("regions=6/elements=7", "rdnm-1") == both
    assert jacobians("regions=6/harmonic=7", "linear") == ["analytic"]
    assert jacobians("node-to-node", "complex-rdnm-1") == ["analytic"]
    assert jacobians("node-to-node", "linear", "enriched-40") == ["analytic"]


def test_names_are_parsed(contents):
    for artefact in contents.select("response", form="data"):
        assert isinstance(artefact.joint, JointName)
        assert isinstance(artefact.coordinates, Coordinates)


def test_a_file_is_named_by_all_that_it_is_of():
    shown = Artefact("regions", "table", case="a", basis="free-4", joint=JointName("regions=6"))
    assert shown.paths == (
        "results/tables/regions_a_free-4_regions=6.csv",
        "results/tables/regions_a_free-4_regions=6.html",
    )
