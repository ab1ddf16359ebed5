"""A wrong value is said in one line: file, key path, value and what is allowed."""

import json

import pytest
from mutations import ROOT
from pydantic import ValidationError

from boltjoint.config.lap_joint import Bolts, Material
from boltjoint.config.reference import SCHEMAS
from boltjoint.config.strict_yaml import parse_mapping
from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError

CONFIG = "config/config.yaml"
CASE = "config/cases/three_bolt_constant.yaml"
PROBLEMS = parse_mapping((ROOT / "tests/config/problems.yaml").read_text(encoding="utf-8"))


def content_of(file):
    return parse_mapping((ROOT / file).read_text(encoding="utf-8"))


def changed(content, path, value=None, *, remove=False):
    """The content with another value under a key path as it stands in the lines, or without it."""
    *above, last = [
        int(part) if part.isdigit() else part
        for part in path.replace("[", ".").replace("]", "").split(".")
    ]
    content = holder = json.loads(json.dumps(content))
    for part in above:
        if isinstance(holder, dict):
            holder.setdefault(part, {})
        holder = holder[part]
    if remove:
        del holder[last]
    else:
        holder[last] = value
    return content


def problems_of(study, file, content):
    (study / file).write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(ConfigError) as refused:
        load_study(study, {"study": "config/sweeps.yaml"})
    return list(refused.value.problems)


@pytest.mark.parametrize("file", PROBLEMS)
def test_a_problem_is_said_in_one_line(study, file):
    text = (study / file).read_text(encoding="utf-8")
    others = []
    for problem in PROBLEMS[file]:
        content = parse_mapping(text)
        for path, value in problem.get("set", {}).items():
            content = changed(content, path, value)
        for path in problem.get("remove", []):
            content = changed(content, path, remove=True)
        expected, said = [f"{file}: {problem['line']}"], problems_of(study, file, content)
        others += [(expected, said)] if said != expected else []
        (study / file).write_text(text, encoding="utf-8")
    assert others == []


def test_the_problems_are_of_every_kind():
    lines = [problem["line"] for problems in PROBLEMS.values() for problem in problems]
    assert len(set(lines)) > 100
    for words in ("is missing", "is not a known key", "is a key only with", "must be greater than"):
        assert any(words in line for line in lines), words


def test_a_model_made_in_code_is_checked():
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


@pytest.mark.parametrize(
    "number",
    ["1e8", "1E+8", "100000000", "1.0e+8", "+1e8", "1.e8", "0x5f5e100"],
)
def test_numbers_as_people_write_them(number):
    content = changed(content_of(CASE), "contact", parse_mapping(f"k: {number}")["k"])
    content["contact"] = content_of(CASE)["contact"] | {
        "tangential_stiffness_N_per_m": content["contact"]
    }
    case = SCHEMAS["case"].model_validate(content)
    assert case.contact.tangential_stiffness_N_per_m == 1e8


def test_whole_numbers_as_people_write_them():
    content = content_of(CONFIG) | parse_mapping("solver: {maximum_solutions: 5e3}")
    most = SCHEMAS["config"].model_validate(content).solver.maximum_solutions
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
    key = "contact.friction_coefficient"
    content = changed(content_of(CASE), key, parse_mapping(f"k: {text}")["k"])
    assert problems_of(study, CASE, content) == [f"{CASE}: {key}: {shown} must be a number"]
