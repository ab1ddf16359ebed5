"""Sweeps: their base cases, and what is said where a sweep does not suit its own."""

import time

import pytest
import yaml
from mutations import ROOT

from boltjoint.config.case import Case
from boltjoint.config.csv_table import CsvTable
from boltjoint.config.study import load_study
from boltjoint.config.sweep import Sweep
from boltjoint.config.types import ConfigError
from boltjoint.config.varied_case import BaseOfVariants, read_table, with_values
from boltjoint.config.varied_keys import keys_that_vary
from boltjoint.damping import LossFactor
from boltjoint.names import JointName
from boltjoint.report.displays import DISPLAYS
from boltjoint.study import memory_and_time_of_study as needs
from boltjoint.study.artefact_list import Contents

NAME = "three_bolt_uncertainty"
FILE = f"config/sweeps/{NAME}.yaml"
SWEPT = {"sweeps": [NAME]}
#: a sweep of the case with the shortest list of keys
CONSTANT = {
    "case": "three_bolt_constant",
    "vary": {
        "preload_N": {"kind": "normal", "mean": 10000, "standard_deviation": 1500},
        "loss_factor": {"kind": "linear", "lowest": 0.001, "highest": 0.004},
    },
    "levels": [10],
    "design": {"kind": "saltelli", "number": 1024},
    "basis": "free-4",
    "joint": "regions=6/elements=7",
}
KEYS = (
    "preload_N, forces_N, loss_factor, contact.tangential_stiffness_N_per_m, "
    "contact.friction_coefficient, joint.regions, joint.elements, and other numbers of the case "
    "and its assembly by their paths, as preload_ratios[0] or assembly.bar.lap_mm"
)


@pytest.fixture
def changed(study):
    """Changes the shipped sweep, and gives what is said of it."""

    def change(without=(), **keys):
        content = CONSTANT | keys
        content = {key: value for key, value in content.items() if key not in without}
        (study / FILE).write_text(yaml.safe_dump(content), encoding="utf-8")
        try:
            return load_study(study, SWEPT)
        except ConfigError as error:
            return list(error.problems)

    return change


@pytest.mark.parametrize(
    "joint", ["node-to-node", "clusters=48", "regions=6", "regions=6/elements=7", "hyper=auto"]
)
def test_the_last_joint_of_a_sweep_is_the_one_that_it_asks_for(changed, joint):
    (files,) = Contents(changed(joint=joint)).joints_of_sweep(NAME)
    # limits of the model are those of the first
    assert files[0].endswith("/node-to-node/joint.nc")
    assert files[-1].endswith(f"/{joint}/joint.nc")
    # weights are made for the designs of the sweep
    assert files[-1].startswith(f"results/sweeps/{NAME}/") == joint.startswith("hyper")


def test_a_base_case_need_not_run(changed):
    assert list(changed(case="three_bolt_variable", joint="node-to-node").base_cases) == []
    shorter = {"cases": ["four_bolt_constant"], "sweeps": [NAME]}
    study = load_study(ROOT, shorter)
    assert (list(study.cases), list(study.base_cases)) == (
        ["four_bolt_constant"],
        ["three_bolt_variable"],
    )
    assert study.case("three_bolt_variable").assembly in study.assemblies
    assert study.designs == {NAME: 1024 * (6 + 2)}


def test_a_regression_has_designs_for_each_of_its_variables():
    keys = {"case": "mine", "basis": "free-4", "joint": "regions=2", "observe": ["converged-peaks"]}
    vary = {f"preload_ratios[{n}]": [0.5, 1] for n in range(9)}
    design = {"kind": "sobol", "number": 1000}
    sweep = Sweep.model_validate(keys | {"vary": vary, "design": design, "converged_designs": 36})
    assert sweep.harmonics_in_words.endswith("in 36 designs and by regression in all others")
    with pytest.raises(ValueError, match="must be at least 36 with so many keys that vary"):
        few = {"vary": vary, "design": design, "converged_designs": 35}
        Sweep.model_validate(keys | few)
    several = [{"harmonics": 17, "number": 80}, {"harmonics": 33, "number": 40}]
    by_harmonics = Sweep.model_validate(
        keys | {"vary": vary, "design": design, "converged_designs": several}
    )
    assert by_harmonics.designs_by_harmonics == {17: 80, 33: 40}
    assert by_harmonics.harmonics_in_words.startswith("with all harmonics in 40 designs")
    assert sweep.designs_by_harmonics == {33: 36}


def test_a_base_case_is_solved_as_the_sweep_asks_for(changed):
    study = changed()
    content = study.base_of_sweep(NAME)
    (block,) = content["solve"]
    assert (block["joints"], content["modes"]) == (("regions=6/elements=7",), ("free-4",))
    assert Case.model_validate(content).levels == (10.0,)


def test_the_levels_are_those_of_the_case_unless_the_sweep_has_its_own(changed):
    study = changed(without=["levels"])
    levels = Case.model_validate(study.base_of_sweep(NAME)).levels
    assert levels == study.case("three_bolt_constant").levels


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (
            {"vary": {"contact.friction": [1]}},
            f"vary.contact.friction: [1] is no key that varies; did you mean "
            f"contact.friction_coefficient? there are: {KEYS}",
        ),
        (
            {"vary": {"preload_N": {"kind": "normal", "mean": 1000, "standard_deviation": 500}}},
            'vary.preload_N: {"kind": "normal", "mean": 1000, "standard_deviation": 500} reaches '
            "too far: preload_N: -1377.0 must be greater than 0",
        ),
        (
            {"vary": {"loss_factor": {"kind": "linear", "lowest": 0.5, "highest": 1}}},
            'vary.loss_factor: {"highest": 1, "kind": "linear", "lowest": 0.5} reaches too far: '
            "loss_factor: 1.0 must be less than 1",
        ),
        (
            {"joint": "regions=600/elements=7"},
            'joint: "regions=600/elements=7" must have at most 1370 elements in all, the contact '
            "pairs of three_bolt",
        ),
        (
            {"vary": {"assembly.bar.lap": [100]}},
            "vary.assembly.bar.lap: [100] is no key that varies; did you mean "
            f"assembly.bar.lap_mm? there are: {KEYS}",
        ),
        (
            {"vary": {"preload_ratios[3]": [1, 0.5]}},
            "vary.preload_ratios[3]: [1, 0.5] is no key that varies; did you mean "
            f"preload_ratios[2]? there are: {KEYS}",
        ),
        (
            {"vary": {"assembly.bolts.pitch_mm": [50, 60]}},
            'vary: {"assembly.bolts.pitch_mm": [50, 60]} makes no possible design: '
            "assembly.bolts.pitch_mm: 50.0 puts the outermost bolt cells outside the lap: must be "
            "less than 42.75 mm in the lap of 110.5 mm",
        ),
        ({"resonance": 7}, "resonance: 7 must be at most 4, the modes of the basis free-4"),
        (
            {"basis": "enriched-299"},
            'basis: "enriched-299" must have at most 128 vectors, as '
            "contact_adapted_basis.maximum_vectors in config/config.yaml",
        ),
        (
            {"case": "three_bolt_variable", "joint": "regions=6/table"},
            'joint: "regions=6/table" must not have /table, which needs constant normal load',
        ),
    ],
)
def test_what_does_not_suit_the_base_case_is_said(changed, keys, line):
    assert changed(**keys) == [f"{FILE}: {line}"]


VARIED = {
    "assembly.bar.lap_mm": [110.5, 120, 50],
    "preload_ratios[1]": [1, 0, 0.5],
    "joint.regions": [4, 6.5],
    "sensors[0].x_mm": [100],
    "preload_N": [1e4, 2e4],
}


def test_designs_that_need_another_joint_are_variants(study, changed):
    case = study / "config/cases/three_bolt_constant.yaml"
    sensor = {"name": "tip", "x_mm": 50, "y_mm": 0, "z_mm": 10, "direction": "z"}
    content = yaml.safe_load(case.read_text(encoding="utf-8")) | {"sensors": [sensor]}
    case.write_text(yaml.safe_dump(content), encoding="utf-8")
    found = changed(vary=VARIED, design={"kind": "grid"})
    variants = found.variants[NAME]
    assert (found.designs[NAME], len(variants)) == (36, 18)
    # that with a lap of 50 mm is impossible
    names = {each.assembly_name for each in found.possible_variants(NAME)}
    assert names == {"three_bolt", "three_bolt,bar.lap_mm=120"}
    assert [each.joint for each in variants[:1]] == ["regions=4/elements=7"]
    possible = found.possible_variants(NAME)
    assert len(possible) == 6
    loosened = next(each for each in possible if each.values["preload_ratios[1]"] == 0)
    assert loosened.case.preload == "10000,0,10000"
    assert loosened.case.sensors[0].x_mm == 100
    assert found.case(loosened.case_name) == loosened.case
    assert found.assembly("three_bolt,bar.lap_mm=120").bar.lap_mm == 120
    short, *_, half = [each.reason for each in variants if each.reason]
    assert short == "joint.regions: 6.5 must be a whole number of at least 1"
    assert half.startswith("assembly.bolts.pitch_mm: 30.0 puts the outermost bolt cells outside")


@pytest.mark.parametrize("check", [None, {"basis": "enriched-24", "designs": 2}])
def test_a_contact_adapted_basis_is_made_for_each_ratio_of_preloads(changed, check):
    ratios = "preload_ratios[1]"
    basis = "enriched-16" if check is None else "free-4"
    found = changed(vary={ratios: [1, 0.5]}, design={"kind": "grid"}, basis=basis, check=check)
    tight, loosened = found.possible_variants(NAME)
    assert tight.assembly_name == tight.case.assembly == "three_bolt"
    own = "three_bolt,preload_ratios.1=0.5"
    assert loosened.assembly_name == loosened.case.assembly == own
    assert found.assembly(own) == found.assembly("three_bolt")
    # of its own case alone
    (condition,) = found.contact_conditions(own)
    assert condition["contact"] == loosened.case.contact.model_dump()


def test_modes_without_contact_serve_all_ratios_of_preloads(changed):
    found = changed(vary={"preload_ratios[1]": [1, 0.5]}, design={"kind": "grid"})
    assert {each.assembly_name for each in found.possible_variants(NAME)} == {"three_bolt"}


LAPS = {"kind": "linear", "lowest": 110.5, "highest": 120}


@pytest.fixture
def unchecked(monkeypatch):
    """Variants of which none may be checked."""

    def refuse(self, values):
        raise AssertionError(f"{values} is checked")

    monkeypatch.setattr(BaseOfVariants, "checked", refuse)


@pytest.mark.parametrize(
    ("number", "design", "told"),
    [
        (20_000, "grid", "20000"),
        (10**6, "grid", "1000000"),
        (10**5, "latin-hypercube", "more than 10000"),
    ],
)
def test_variants_are_counted_before_they_are_checked(changed, unchecked, number, design, told):
    vary = {"assembly.bar.lap_mm": LAPS | ({"number": number} if design == "grid" else {})}
    how = {"kind": design} | ({} if design == "grid" else {"number": number})
    begun = time.process_time()
    (line,) = changed(vary=vary, design=how, designs_per_job=10**6)
    taken = time.process_time() - begun
    assert line.startswith(f"{FILE}: vary: ")
    sentence = f"makes {told} joints of other dimensions, preloads or divisions: must make at most"
    assert f"{sentence} 10000" in line
    # a check of each takes 9 s for twenty thousand
    assert taken < 2


def test_other_keys_of_a_grid_make_no_further_variants(changed):
    vary = {"joint.regions": [4, 6], "preload_N": LAPS | {"number": 10**6}}
    study = changed(vary=vary, design={"kind": "grid"}, designs_per_job=10**6)
    assert (study.designs[NAME], len(study.variants[NAME])) == (2 * 10**6, 2)


def test_a_job_checks_the_variant_it_needs_and_no_other(study, changed, monkeypatch):
    changed(vary={"assembly.bar.lap_mm": LAPS | {"number": 2000}}, design={"kind": "grid"})
    checked, check = [], BaseOfVariants.checked
    monkeypatch.setattr(
        BaseOfVariants, "checked", lambda *args: checked.append(args[1]) or check(*args)
    )
    loaded = load_study(study, SWEPT, before=True)
    contents = Contents(loaded, DISPLAYS)
    contents.select("joint", case="three_bolt_constant")
    DISPLAYS.jobs(contents, "figure")
    needs.Resources(loaded).of("responses", "three_bolt_constant")
    assert checked == []
    name = "three_bolt_constant,assembly.bar.lap_mm=120"
    assert loaded.case(name).assembly == "three_bolt,bar.lap_mm=120"
    assert loaded.assembly("three_bolt,bar.lap_mm=120").bar.lap_mm == 120
    assert checked == [{"assembly.bar.lap_mm": 120}]


def test_a_job_that_needs_no_table_reads_none(study, changed, monkeypatch):
    rows = "\n".join(f"{5000 + n},0.002" for n in range(300))
    (study / "designs.csv").write_text(f"preload_N,loss_factor\n{rows}\n\n", encoding="utf-8")
    changed(design={"kind": "table", "file": "designs.csv"}, without=["vary"], designs_per_job=100)

    def refuse(self):
        raise AssertionError("the numbers are read")

    monkeypatch.setattr(CsvTable, "columns", refuse)
    loaded = load_study(study, SWEPT, before=True)
    contents = Contents(loaded, DISPLAYS)
    # their keys are in the first line, and lines are designs
    assert loaded.swept[NAME].keys == ("preload_N", "loss_factor")
    assert loaded.designs == {NAME: 300}
    assert contents.chunk(NAME, 2) == (200, 300)
    assert len(contents.select("chunk", sweep=NAME)) == 3
    assert len(loaded.hashes["designs.csv"]) == 16


@pytest.mark.parametrize(
    ("vary", "reason"),
    [
        ({"preload_N": [0, -5]}, "preload_N: 0.0 must be greater than 0"),
        (
            {"preload_N": [1000, -5], "loss_factor": [2, 3]},
            "loss_factor: 2.0 must be less than 1",
        ),
        ({"joint.regions": [0, 6.5]}, "joint.regions: 0 must be a whole number of at least 1"),
    ],
)
@pytest.mark.parametrize("design", ["grid", "latin-hypercube", "table"])
def test_a_sweep_without_a_possible_design_is_refused(study, changed, vary, reason, design):
    if design != "table":
        how = {"kind": design} | ({} if design == "grid" else {"number": 4})
        (line,) = changed(vary=vary, design=how, observe=["responses"])
        assert line.startswith(f"{FILE}: vary: ")
    else:
        rows = zip(*vary.values(), strict=True)
        lines = [",".join(vary), *(",".join(map(str, row)) for row in rows)]
        (study / "designs.csv").write_text("\n".join(lines), encoding="utf-8")
        how = {"kind": "table", "file": "designs.csv"}
        (line,) = changed(design=how, without=["vary"], observe=["responses"])
        assert line.startswith(f'{FILE}: design.file: "designs.csv" ')
    assert line.endswith(f" makes no possible design: {reason}")


def test_one_possible_design_is_enough(study, changed):
    assert changed(vary={"preload_N": [0, 1000]}, design={"kind": "grid"}).designs == {NAME: 2}
    (study / "designs.csv").write_text("preload_N,joint.regions\n0,6\n1,6.5\n1,6\n")
    found = changed(design={"kind": "table", "file": "designs.csv"}, without=["vary"])
    assert found.designs == {NAME: 3}


def test_long_names_of_variants_are_hashes(changed):
    vary = {f"assembly.mesh.{key}": [2] for key in ("rings_under_head", "rings_head_to_cell_edge")}
    vary |= {f"assembly.bolts.{key}_diameter_mm": [v] for key, v in (("shank", 8), ("hole", 9.5))}
    (variant,) = changed(vary=vary, design={"kind": "grid"}).variants[NAME]
    name, _, told = variant.case_name.partition(",")
    assert (name, len(told)) == ("three_bolt_constant", 16)


def test_a_sweep_of_a_case_that_is_not_there(changed):
    (line,) = changed(case="three_bolt")
    assert line.startswith(f'{FILE}: case: "three_bolt" is not in config/cases; did you mean')


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "preload_N,loss_facter\n1,0.1\n",
            'designs.csv: column "loss_facter" is no key that varies; did you mean loss_factor? '
            f"there are: {KEYS}",
        ),
        ("preload_N,preload_N\n1,2\n", "designs.csv: column preload_N must not appear twice"),
        ("preload_N,loss_factor\n1\n", "designs.csv:2: must have 2 values, as many as keys"),
        ("preload_N\n1\nnan\n", 'designs.csv:3: preload_N: "nan" must be a number'),
        ("preload_N\n", "designs.csv: must have a line of keys, and one for each design"),
        ("", "designs.csv: must have a line of keys, and one for each design"),
        (None, "designs.csv: cannot be read: No such file or directory"),
    ],
)
def test_what_is_wrong_with_a_table_is_said(study, changed, text, line):
    if text is not None:
        (study / "designs.csv").write_text(text, encoding="utf-8")
    design = {"kind": "table", "file": "designs.csv"}
    assert changed(design=design, without=["vary"]) == [line]


def test_rows_of_a_table_are_counted_before_they_are_read(study, changed):
    # beside a word, which is not read
    (study / "designs.csv").write_text("preload_N\nnone\n" + 20_000 * "1\n", encoding="utf-8")
    design = {"kind": "table", "file": "designs.csv"}
    (line,) = changed(design=design, without=["vary"], designs_per_job=2)
    assert line == f"{FILE}: designs_per_job: 2 makes 1e+04 jobs: must make at most 10000"


def test_impossible_designs_of_a_table_are_none_of_its_problems(study, changed):
    (study / "designs.csv").write_text("preload_N,loss_factor\n-1,0.1\n1,0.2\n")
    design = {"kind": "table", "file": "designs.csv"}
    assert changed(design=design, without=["vary"]).designs == {NAME: 2}


def test_values_of_keys_replace_those_of_the_case():
    case = load_study(ROOT).case("three_bolt_variable")
    content = case.model_dump()
    values = {
        "preload_N": 5e3,
        "forces_N": 3.0,
        "contact.normal_stiffness_N_per_m": 2e8,
        "loss_factor": 0.01,
    }
    found = Case.model_validate(with_values(content, values))
    assert (found.preload_N, found.levels) == (5e3, (3.0,))
    assert found.contact.normal_stiffness_N_per_m == 2e8
    assert found.contact.friction_coefficient == case.contact.friction_coefficient
    assert found.structural_damping == LossFactor(0.01)
    assert content == case.model_dump()


def test_bolts_and_washers_vary(study, changed):
    path = study / "config/assemblies/three_bolt.yaml"
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    content["bolts"] |= {
        "material": dict(content["material"]),
        "washer": {"thickness_mm": 1.6, "diameter_mm": 16},
    }
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    modulus, width = (
        "assembly.bolts.material.youngs_modulus_GPa",
        "assembly.bolts.washer.diameter_mm",
    )
    vary = {modulus: [110, 206], width: [12, 16, 20]}
    found = changed(vary=vary, design={"kind": "grid"})
    quantity = found.quantities(NAME)
    assert quantity[modulus][:2] == ("bolts_material_youngs_modulus", "Pa")
    assert quantity[width][:2] == ("bolts_washer_diameter", "m")
    variants = found.variants[NAME]
    reasons = {each.values[width]: each.reason for each in variants}
    assert not reasons[16]
    assert "12.0 must be at least the head's diameter of 13 mm" in reasons[12]
    assert "20.0 must be less than the bar's width of 20 mm" in reasons[20]
    possible = [found.assembly(each.assembly_name) for each in found.possible_variants(NAME)]
    assert [each.bolt_material.youngs_modulus_GPa for each in possible] == [110, 206]
    assert [each.material.youngs_modulus_GPa for each in possible] == [190, 190]


def test_every_key_that_varies_has_a_name_of_its_own():
    study = load_study(ROOT)
    for case in study.cases.values():
        keys = keys_that_vary(case, study.assembly(case.assembly), JointName("regions=6/table"))
        assert len({each.name for each in keys.values()}) == len(keys)
        columns = read_table(",".join(keys) + "\n" + ",".join("1" * len(keys)), "", keys)
        assert list(columns) == list(keys)


def test_a_sweep_reads_what_it_writes():
    sweep = load_study(ROOT, SWEPT).sweeps[NAME]
    content = sweep.model_dump()
    assert Sweep.model_validate(content) == sweep.model_copy(update={"description": ""})


def test_a_check_solves_a_larger_model(changed):
    study = changed(check={"basis": "enriched-40"})
    content = study.base_of_sweep(NAME, checking=True)
    (block,) = content["solve"]
    assert (block["joints"], content["modes"]) == (("node-to-node",), ("enriched-40",))
    assert content["coordinates"] == ("linear",)
    assert Case.model_validate(content).levels == (10.0,)
    assert study.sweeps[NAME].check.designs == 20


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        ({"check": {"basis": "enriched-40", "joint": "clusters=1000000"}}, "check.joint: "),
        ({"check": {"basis": "enriched-40", "joint": "clusters=9999"}}, "must have at most"),
        ({"check": {"designs": 0, "basis": "free-4"}}, "check.designs: 0 must be"),
        ({"check": {}}, "check.basis: is missing"),
    ],
)
def test_a_check_that_is_impossible_is_refused(changed, keys, line):
    assert any(line in told for told in changed(**keys))
