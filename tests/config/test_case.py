"""A case: what its blocks solve, and how its contact pairs are divided."""

import pytest
from mutations import ROOT
from pydantic import ValidationError

from boltjoint.config.case import Case
from boltjoint.config.conflicts import conflicts_of_case
from boltjoint.config.contact import ContactOfSurface
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.strict_yaml import parse_mapping
from boltjoint.config.study import load_study
from boltjoint.config.varied_case import with_values
from boltjoint.config.varied_keys import rescaled_keys
from boltjoint.damping import LossFactor, RayleighDamping

CASE = "config/cases/three_bolt_constant.yaml"


def changed(**keys):
    """The shipped case of three bolts under constant load, other in some keys."""
    text = (ROOT / CASE).read_text(encoding="utf-8")
    return Case.model_validate(parse_mapping(text) | keys)


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
        "regions=6/iwan",
        "clusters=auto",
    )
    assert case.joints("enriched-40")[0] == "node-to-node"
    assert case.joints("free-16") == ()


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
    assert list(case.responses) == [
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
    solved = list(load_study(ROOT).case(name).responses)
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


def test_models_do_not_change_once_read():
    case = load_study(ROOT).case("three_bolt_constant")
    with pytest.raises(ValidationError, match="frozen"):
        case.preload_N = 1.0


def test_a_reduced_joint_needs_no_listed_regions():
    block = {"resonance": 1, "joints": ["regions=6/elements=4"]}
    assert changed(solve=[block]).joints("free-4") == ("regions=6/elements=4",)


def test_the_division_into_regions_has_a_default():
    content = parse_mapping((ROOT / CASE).read_text(encoding="utf-8"))
    content.pop("regions", None)
    assert Case.model_validate(content).regions.division == "equal-load"


def test_the_window_of_a_resonance():
    blocks = [{"resonance": n, "joints": ["node-to-node"]} for n in (1, 2)]
    case = changed(solve=[blocks[0], blocks[1] | {"window_Hz": [300, 5e2]}])
    assert case.window_around(1) is None
    assert case.window_around(2) == (300.0, 500.0)


def test_levels_are_forces_or_accelerations_of_the_clamp():
    case = changed()
    assert case.levels == case.forces_N
    text = parse_mapping((ROOT / CASE).read_text(encoding="utf-8"))
    del text["forces_N"]
    shaken = text | {
        "excitation": {"kind": "base", "direction": "z"},
        "accelerations_m_per_s2": [1, 5, 10, 50],
    }
    case = Case.model_validate(shaken)
    assert case.is_base_excited and case.levels == (1, 5, 10, 50)
    with pytest.raises(ValidationError, match="its levels are accelerations_m_per_s2"):
        Case.model_validate(shaken | {"forces_N": [1, 5]})


def test_damping_is_a_loss_factor_unless_a_model_is_given():
    text = parse_mapping((ROOT / CASE).read_text(encoding="utf-8"))
    assert changed(loss_factor=0.003).structural_damping == LossFactor(0.003)
    del text["loss_factor"]
    assert Case.model_validate(text).structural_damping == LossFactor(0.002)
    rayleigh = {"model": "rayleigh", "mass_coefficient_1_per_s": 2, "stiffness_coefficient_s": 1e-6}
    found = Case.model_validate(text | {"damping": rayleigh}).structural_damping
    assert found == RayleighDamping(2.0, 1e-6)


def test_a_dump_of_a_case_is_the_same_case():
    """Jobs of the workflow get dumps."""
    text = parse_mapping((ROOT / CASE).read_text(encoding="utf-8"))
    del text["loss_factor"], text["forces_N"]
    point = {"x_mm": 100, "y_mm": 0, "z_mm": 10, "direction": "z", "name": "lap"}
    text |= {
        "damping": {"model": "modal", "damping_ratios": [0.001]},
        "excitation": {"kind": "base", "direction": "z"},
        "accelerations_m_per_s2": [1, 5, 10, 50],
        "sensors": [point],
    }
    case = Case.model_validate(text)
    again = Case.model_validate(case.model_dump())
    assert again.model_dump() == case.model_dump()
    assert again.structural_damping == case.structural_damping


def test_friction_in_both_directions_is_refused_where_its_methods_end():
    contact = {
        "law": "coupled-constant",
        "tangential_stiffness_N_per_m": 1e8,
        "friction_coefficient": 0.1,
    }
    joints = ["node-to-node", "regions=4", "clusters=auto", "hyper=20", "regions=4/table"]
    with pytest.raises(ValidationError) as caught:
        changed(
            contact=contact,
            modes=["free-4", "enriched-8"],
            solve=[{"resonance": 1, "joints": joints}],
        )
    (error,) = caught.value.errors()
    said = {path: sentence for path, sentence in error["ctx"]["problems"]}
    assert set(said) == {
        ("verification_forces_N",),
        *(("solve", 0, "joints", place) for place in (2, 3, 4)),
    }
    assert "move in the plane" in said["verification_forces_N",]
    assert "needs a closed form" in said["solve", 0, "joints", 3]
    # contact-adapted bases hold the second tangents
    allowed = {"verification_forces_N": (), "solve": [{"resonance": 1, "joints": joints[:2]}]}
    assert changed(contact=contact, modes=["free-4", "enriched-8"], **allowed).bases[1].vectors == 8


def test_a_circular_limit_needs_aft():
    study = {"study": "config/lateral.yaml"}
    assert load_study(ROOT, study).case("three_bolt_lateral_coupled").bases == ("all-16",)
    with pytest.raises(
        ValueError, match=r"contact\.law: .*coupled-constant, which has no closed form"
    ):
        load_study(ROOT, study | {"solver": {"friction_force": "analytic"}})


@pytest.mark.parametrize(
    ("ratios", "sentence"),
    [
        (21 * [1, 0.5], "must not end in a pattern that stands 20 times or more"),
        (
            [1 - 1 / n for n in range(3, 30)],
            "makes names of files of 375 characters with the assembly: must make at most 200",
        ),
    ],
)
def test_preloads_that_cannot_name_a_folder_are_refused(ratios, sentence):
    with pytest.raises(ValidationError, match=sentence):
        changed(preload_N=10, preload_ratios=ratios)
    assert changed(preload_N=10, preload_ratios=ratios[:10]).preload.of_bolts[1] > 0


class _TwoSurfaces(LapJoint):
    """An assembly with two surfaces in contact."""

    @property
    def surface_names(self):
        return "lap", "flange"


def test_each_surface_has_a_region_and_values_of_its_own():
    study = load_study(ROOT)
    case = study.case("three_bolt_constant").model_dump()
    case["contact"]["surfaces"] = [{"name": "flange", "friction_coefficient": 0.3}]
    case["solve"] = [{"resonance": 1, "joints": ["clusters=1", "regions=2", "node-to-node"]}]
    case = Case.model_validate(case)
    two = _TwoSurfaces.model_validate(study.assembly("three_bolt").model_dump())
    found = list(conflicts_of_case(case, two, study, None))
    assert found == [
        (("solve", 0, "joints", 0), "must have at least 2 clusters, one on each surface")
    ]
    stiff = {"name": "flange", "tangential_stiffness_N_per_m": 3e8}
    own = case.contact.model_copy(update={"surfaces": (ContactOfSurface(**stiff),)})
    stiffer = {"cases": {"one": case.model_copy(update={"contact": own})}, "base_cases": {}}
    assert study.stuck_stiffness("three_bolt") == {"stiffness": 1e8}
    changed = study.model_copy(update=stiffer)
    assert changed.stuck_stiffness("three_bolt") == {"stiffness": 3e8}
    key = "contact.surfaces[0].friction_coefficient"
    assert rescaled_keys(case)[key].meaning.endswith("of surface flange")
    changed = Case.model_validate(with_values(case.model_dump(), {key: 0.4}))
    assert changed.contact.options["surfaces"] == {"flange": {"friction_coefficient": 0.4}}


def test_a_surface_has_its_own_law_and_what_it_lacks_of_all():
    own = {"name": "flange", "law": "variable", "normal_stiffness_N_per_m": 3e8}
    case = load_study(ROOT).case("three_bolt_constant").model_dump()
    case["contact"]["surfaces"] = [own]
    case["solve"] = [{"resonance": 1, "joints": ["regions=2", "node-to-node"]}]
    case = Case.model_validate(case)
    assert case.contact.options == {
        "law": "constant",
        "tangential_stiffness": 1e8,
        "friction_coefficient": 0.1,
        "surfaces": {"flange": {"law": "variable", "normal_stiffness": 3e8}},
    }
    found = case.contact.declaration
    assert found.name == "constant + variable"
    assert found.directions == ("tangential", "normal")
    assert found.components == ("bias", "sin", "cos")
    assert Case.model_validate(case.model_dump()) == case
    # a reduction needs what all laws have
    case = case.model_dump()
    case["solve"] = [{"resonance": 1, "joints": ["regions=2/table"]}]
    with pytest.raises(ValidationError, match="must not have /table, which needs"):
        Case.model_validate(case)
