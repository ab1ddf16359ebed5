"""Files of the results of a study."""

import re
from pathlib import Path

import pytest

from boltjoint.config.study import load_study
from boltjoint.study import layout

ROOT = Path(__file__).parents[1]


def shipped(name):
    """The study with the keys of another file of ``config/`` in place of its own."""
    return load_study(ROOT, {"study": f"config/{name}.yaml"})


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


def test_bases_and_regions_are_compared_with_converged_ones_only_where_asked_for():
    usual = layout.targets(load_study(ROOT))
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


def test_time_integration_checks_responses_in_all_modes_of_the_basis():
    found = load_study(ROOT)
    names_of = ("linear", "rdnm-1", "complex-rdnm-1", "backbone")
    assert [layout.is_checked(found, name) for name in names_of] == [True, False, False, False]
    aft = load_study(ROOT, {"solver": {"friction_force": "aft"}})
    assert not layout.is_checked(aft, "linear")
