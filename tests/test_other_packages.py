"""Friction laws, displays and a maker of a package that is made in a temporary folder."""

import subprocess
import sys
import textwrap
from dataclasses import replace

import numpy as np
import pytest
from glue_law import glue_law
from pydantic import TypeAdapter, ValidationError
from small_joint import connect_small

from boltjoint import other_packages
from boltjoint.config.contact import Contact
from boltjoint.dynamics.response.frequency_response import solve_branch
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.constant import ConstantLoad
from boltjoint.friction.declarations import DECLARATIONS, OWN_DECLARATIONS
from boltjoint.friction.registry import LAWS
from boltjoint.joint.io import joint_from_dataset, joint_to_dataset
from boltjoint.other_packages import WithOtherPackages

#: a law of another package: springs that never slip, and dashpots beside them
LAW = """
from boltjoint.friction.declarations import CONSTANT, ContactKey, LawDeclaration

DECLARATION = LawDeclaration(
    name="glue", label="glue", meaning="Glue.",
    keys=(CONSTANT.keys[0], ContactKey("viscosity", "N s/m", "Viscosity of each pair.")),
    capabilities=(), has_closed_form=False,
)


def law():
    from law_of_glue import Glue

    return Glue
"""
DISPLAY = '''
from boltjoint.study.display import table


@table("glue", of=lambda contents: [{}], reads=(), job="glue", page="overview", title="glue")
def glue(artefact, results):
    """Nothing."""
'''
#: a maker, of which no more is asked than its figures and tables
MAKER = 'DISPLAYS = "displays_of_glued"'
KEYS = {"tangential_stiffness": 5e6, "viscosity": 300.0}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The folder of a package with a law, a display, and a maker with another."""
    information = tmp_path / "glue-1.0.dist-info"
    information.mkdir()
    points = "[boltjoint.laws]\nglue = glue\n[boltjoint.displays]\nglue = displays_of_glue\n"
    points += "[boltjoint.makers]\nglued = glued\n"
    (information / "entry_points.txt").write_text(points)
    (information / "METADATA").write_text("Name: glue\nVersion: 1.0\n")
    for name, text in (
        ("glue", LAW),
        ("law_of_glue", glue_law("from glue import DECLARATION")),
        ("displays_of_glue", DISPLAY),
        ("glued", MAKER),
        ("displays_of_glued", DISPLAY.replace("glue", "glued")),
    ):
        (tmp_path / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    other_packages.entries.cache_clear()
    yield tmp_path
    other_packages.entries.cache_clear()
    for known in (LAWS, DECLARATIONS):
        known._loaded.clear()
    for name in ("glue", "law_of_glue", "displays_of_glue"):
        sys.modules.pop(name, None)


@pytest.mark.usefixtures("package")
def test_a_law_of_another_package_is_configured_connected_solved_and_stored():
    contact = TypeAdapter(Contact).validate_python(
        {"law": "glue", "tangential_stiffness_N_per_m": 5e6, "viscosity_N_s_per_m": 300.0}
    )
    assert contact.options == {"law": "glue", **KEYS}
    assert contact.declaration.label == "glue"
    joint = connect_small("glue", KEYS)[0]
    assert list(LAWS)[-1] == "glue"
    sampled = replace(joint, law=AlternatingFrequencyTime(joint.law, samples=32))
    branch = solve_branch(sampled, 5.0, damping=2e-3)
    w, B = 2 * np.pi * branch.peak_frequency, joint.tangential_mode
    k = joint.law.tangential_stiffness + 1j * w * joint.law.viscosity
    stiffness = np.diag((2 * np.pi * joint.natural_frequency) ** 2) * (1 + 2e-3j)
    q = np.linalg.solve(
        stiffness + B.T @ (k[:, None] * B) - w**2 * np.eye(3), 5.0 * joint.excitation_mode
    )
    assert branch.peak_amplitude == pytest.approx(abs(q @ joint.response_mode), rel=1e-6)
    again = joint_from_dataset(joint_to_dataset(joint)).law
    assert type(again) is LAWS["glue"]
    np.testing.assert_array_equal(again.viscosity, joint.law.viscosity)


@pytest.mark.usefixtures("package")
def test_a_surface_may_have_a_law_of_another_package():
    surface = {"name": "pad", "law": "glue", "viscosity_N_s_per_m": 300.0}
    content = {
        "law": "constant",
        "tangential_stiffness_N_per_m": 5e6,
        "friction_coefficient": 0.1,
        "surfaces": [surface],
    }
    contact = TypeAdapter(Contact).validate_python(content)
    assert contact.declaration.name == "constant + glue"
    of_all = {"tangential_stiffness": 5e6, "friction_coefficient": 0.1}
    keys = of_all | {"surfaces": {"pad": {"law": "glue", "viscosity": 300.0}}}
    joint = connect_small("constant", keys, surface=["pad"] * 20 + ["flange"] * 40)[0]
    assert [type(part).__name__ for part in joint.law.parts] == ["ConstantLoad", "Glue"]
    # the sum of both, at samples
    assert joint.law.closed_form is None
    assert joint.law.dashpots.damping.sum() == pytest.approx(20 * 300.0)
    elements = joint.law.dashpots.element
    assert (joint.law.part_of_element[elements] == 1).all()


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize(
    ("change", "location"),
    [
        ({"viscosity_N_s_per_m": -1.0}, "viscosity_N_s_per_m"),
        ({"friction_coefficient": 0.1}, "friction_coefficient"),
    ],
)
def test_keys_of_such_a_law_are_checked_where_they_stand(change, location):
    content = {"law": "glue", "tangential_stiffness_N_per_m": 5e6, "viscosity_N_s_per_m": 300.0}
    with pytest.raises(ValidationError) as raised:
        TypeAdapter(Contact).validate_python(content | change)
    assert [error["loc"][-1] for error in raised.value.errors()] == [location]


def test_displays_of_another_package_and_its_makers_stand_after_those_of_this_one(package):
    script = "from boltjoint.report.displays import DISPLAYS; print(*[d.kind for d in DISPLAYS])"
    run = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(package)!r}); {script}"]
    ran = subprocess.run(run, capture_output=True, text=True, check=True)
    *own, of_makers, of_entry_points = ran.stdout.split()
    assert len(own) > 20
    assert (of_makers, of_entry_points) == ("glued", "glue")


def test_a_law_lacks_nothing_that_all_have():
    with pytest.raises(TypeError, match="no quantities and no tangential_stiffness"):
        exec(
            textwrap.dedent(
                """
                from boltjoint.friction.element_law import ElementLaw
                class Incomplete(ElementLaw):
                    declaration = None
                    slip_force = None
                """
            )
        )


def test_other_packages_are_asked_only_for_names_that_are_none_of_this_one(monkeypatch):
    monkeypatch.setattr(other_packages, "entries", lambda group: pytest.fail(group))
    assert LAWS["constant"] is ConstantLoad
    assert DECLARATIONS["constant"] is OWN_DECLARATIONS["constant"]
    monkeypatch.undo()
    assert WithOtherPackages({"a": 1}, "boltjoint.none", lambda module: module)["a"] == 1
    with pytest.raises(KeyError):
        LAWS["of nobody"]
