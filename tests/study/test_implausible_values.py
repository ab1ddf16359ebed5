"""Values that are plausible, and those that are likely in another unit."""

from pathlib import Path

import pytest

from boltjoint.config.case import Case
from boltjoint.config.lap_joint import LapJoint
from boltjoint.config.study import load_study
from boltjoint.study.implausible_values import implausible

ROOT = Path(__file__).parents[2]
STUDIES = sorted(path.name for path in (ROOT / "config").glob("*.yaml"))


@pytest.mark.parametrize("file", STUDIES)
def test_all_that_is_shipped_is_plausible(file):
    config = {} if file == "config.yaml" else {"study": f"config/{file}"}
    assert not list(implausible(load_study(ROOT, config)))


def edited(content, path, value):
    """A mapping in which the value at a path of keys is another one."""
    first, *rest = path
    return {**content, first: edited(content[first], rest, value) if rest else value}


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("material.youngs_modulus_GPa", 210000, "is this in MPa?"),
        ("material.density_kg_per_m3", 7.85, "is this in g/cm³?"),
        ("material.density_kg_per_m3", 7.85e-9, "is this in t/mm³?"),
        ("mesh.element_length_free_mm", 100, "is this coarse on purpose?"),
    ],
)
def test_an_assembly_in_another_unit_is_told(path, value, said):
    study = load_study(ROOT)
    content = edited(study.assembly("three_bolt").model_dump(), path.split("."), value)
    changed = {**study.assemblies, "three_bolt": LapJoint.model_validate(content)}
    (line,) = implausible(study.model_copy(update={"assemblies": changed}))
    assert line.startswith(f"config/assemblies/three_bolt.yaml: {path}: ")
    assert said in line and "unusual for a bolted joint" in line


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("preload_N", 30, "is this in kN?"),
        ("contact.friction_coefficient", 15, "is this in percent?"),
        ("contact.tangential_stiffness_N_per_m", 20, "is this in N/mm or kN/mm?"),
        ("loss_factor", 0.9, "is this in percent?"),
        ("forces_N", [1, 20e3], "forces_N[1]: 20000 is unusual"),
    ],
)
def test_a_case_in_another_unit_is_told(path, value, said):
    study = load_study(ROOT)
    name = "three_bolt_constant"
    content = edited(study.case(name).model_dump(), path.split("."), value)
    case = Case.model_validate({**content, "verification_forces_N": []})
    (line,) = implausible(study.model_copy(update={"cases": {name: case}}))
    assert line.startswith(f"config/cases/{name}.yaml: ")
    assert said in line
