"""What CONTRIBUTING says about where to add is followed to the letter, in a copy of the library."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from glue_law import glue_law

ROOT = Path(__file__).parents[1]
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
ROWS = dict(re.findall(r"^\| ([\w ,]+?) \| (.*) \|$", CONTRIBUTING, re.MULTILINE))


class Copy:
    """A copy of the library, to which a row of the table is applied."""

    def __init__(self, folder, addition):
        self.folder, self.row = folder, ROWS[addition]
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / "src/boltjoint", folder / "src/boltjoint", ignore=ignored)
        shutil.copytree(ROOT / "config", folder / "config")

    def _path(self, file):
        return self.folder / "src/boltjoint" / file

    def add(self, file, text):
        """A new file, whose folder the row names."""
        assert f"`{Path(file).parent}/`" in self.row
        assert not self._path(file).exists()
        self._path(file).write_text(text, encoding="utf-8")

    def edit(self, file, before, after):
        """One place of a file that the row names."""
        assert f"`{file}`" in self.row
        text = self._path(file).read_text(encoding="utf-8")
        assert text.count(before) == 1, (file, before)
        self._path(file).write_text(text.replace(before, after), encoding="utf-8")

    def run(self, *arguments):
        """What Python says with this copy."""
        ran = subprocess.run(
            [sys.executable, *arguments],
            cwd=self.folder,
            # compiling takes longer than all of it
            env=os.environ | {"PYTHONPATH": str(self.folder / "src"), "NUMBA_DISABLE_JIT": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert ran.returncode == 0, ran.stderr
        return ran.stdout

    def make_reference(self):
        """The tables and schemas of keys, as ``make reference`` writes them."""
        assert "then `make reference`" in self.row
        self.run("-m", "boltjoint.config.reference")
        schema = (self.folder / "config/schemas/case.schema.json").read_text(encoding="utf-8")
        return (self.folder / "config/README.md").read_text(encoding="utf-8"), schema


@pytest.fixture
def copy(tmp_path):
    return lambda addition: Copy(tmp_path, addition)


def test_files_that_the_table_names_exist():
    named = {
        name
        for row in ROWS.values()
        for name in re.findall(r"`([a-z_]+/[a-z_/]*(?:\.py)?|[a-z]+\.py)`", row)
    }
    assert len(named) > 10
    assert {name for name in named if not (ROOT / "src/boltjoint" / name).exists()} == set()


JOINT = """
import numpy as np
from boltjoint import Joint
def joint_of(law):
    one, place = np.ones(1), np.zeros((1, 3))
    return Joint(70 * one, 2 * one, 2 * one, np.array([[0.5]]), place, law, place)
"""

SOLVE_GLUE = (
    JOINT
    + """
from pydantic import TypeAdapter
from boltjoint import solve_branch
from boltjoint.config.contact import Contact
from boltjoint.friction.aft import AlternatingFrequencyTime
from boltjoint.friction.registry import LAWS
given = {"law": "glue", "tangential_stiffness_N_per_m": 1e5, "viscosity_N_s_per_m": 20.0}
assert TypeAdapter(Contact).validate_python(given).options["viscosity"] == 20.0
law = LAWS["glue"]([0], np.array([1e5]), np.array([20.0]))
peak = solve_branch(joint_of(AlternatingFrequencyTime(law, samples=64)), 1.0, damping=0.002)
print(peak.peak_frequency, peak.peak_amplitude)
"""
)


def test_a_friction_law(copy):
    made = copy("friction law")
    declaration = "from boltjoint.friction.declarations import GLUE as DECLARATION"
    made.add("friction/glue.py", glue_law(declaration))
    made.edit(
        "friction/declarations.py",
        "OWN_DECLARATIONS = {\n    law.name: law\n    for law in (\n",
        'GLUE = LawDeclaration(name="glue", label="glue", meaning="Glue.", capabilities=(),\n'
        "    has_closed_form=False, keys=(_TANGENTIAL_STIFFNESS,\n"
        '    ContactKey("viscosity", "N s/m", "Viscosity of each pair.")))\n'
        "OWN_DECLARATIONS = {\n    law.name: law\n    for law in (\n        GLUE,\n",
    )
    made.edit("friction/registry.py", "    for law in (\n", "    for law in (\n        Glue,\n")
    made.edit(
        "friction/registry.py",
        "from boltjoint.friction.iwan ",
        "from boltjoint.friction.glue import Glue\nfrom boltjoint.friction.iwan ",
    )
    frequency, amplitude = map(float, made.run("-c", SOLVE_GLUE).split())
    # one mode with a spring and a dashpot, whose response has its peak where it is in closed form
    w = 2 * 3.141592653589793 * frequency
    L = (2 * 3.141592653589793 * 70.0) ** 2
    compliance = 1 / (L * (1 + 0.002j) + 0.25 * (1e5 + 20j * w) - w**2)
    assert amplitude == pytest.approx(4 * abs(compliance), rel=1e-6)
    page, schema = made.make_reference()
    assert "viscosity_N_s_per_m" in page
    assert "viscosity_N_s_per_m" in schema


DAMPED = """
import numpy as np
from boltjoint.config.case import Case
from boltjoint.damping import ModalStructure, make_damping
matrix = make_damping("fractional", factor=0.5).matrix(ModalStructure(np.array([3.0, 5.0])))
print(*np.diag(matrix.at(4.0)))
"""


def test_a_damping_model(copy):
    made = copy("damping model")
    made.edit(
        "damping.py",
        "#: the models by their name\n",
        """@dataclass(frozen=True)
class FractionalDamping(Damping):
    \"\"\"Damping by half a derivative, proportional to the stiffness.\"\"\"

    name: ClassVar[str] = "fractional"
    quantities: ClassVar[Mapping[str, tuple[str, str]]] = {
        "factor": ("s^1/2", "factor of the stiffness")
    }
    factor: float

    def terms(self, structure: ModalStructure) -> tuple[Term, ...]:
        \"\"\"``factor w^1/2 L``.\"\"\"
        return (Term(0.5, self.factor, structure.stiffness),)


#: the models by their name
""",
    )
    made.edit(
        "damping.py",
        "(LossFactor, ModalDamping, RayleighDamping)",
        "(LossFactor, ModalDamping, RayleighDamping, FractionalDamping)",
    )
    made.edit("config/damping.py", '"1/s": "_1_per_s"', '"1/s": "_1_per_s", "s^1/2": "_root_s"')
    # half the root of the frequency times the stiffness
    assert list(map(float, made.run("-c", DAMPED).split())) == [9.0, 25.0]
    page, schema = made.make_reference()
    assert "factor_root_s" in page
    assert "factor_root_s" in schema


REDUCE = """
import numpy as np
from boltjoint import ConstantLoad, Joint
from boltjoint.joint.reductions import reduce_joint
from boltjoint.names import JointName
assert JointName("regions=2/single").reduction == "single"
place = np.zeros((2, 3))
law = ConstantLoad([0, 0, 1], [1e6, 2e6, 4e6], [1.0, 2.0, 5.0])
joint = Joint([70.0], [1.0], [1.0], np.ones((2, 1)), place, law, place[[0, 0, 1]])
reduced, _ = reduce_joint(joint, "single")
print(*reduced.law.tangential_stiffness, *reduced.law.slip_force)
"""


def test_a_joint_reduction(copy):
    made = copy("joint reduction")
    made.add(
        "joint/single.py",
        '''"""One element in place of those of a region."""

from dataclasses import replace

import numpy as np
import xarray as xr

from boltjoint.friction.constant import ConstantLoad
from boltjoint.joint.model import Joint


def single_element(joint: Joint) -> tuple[Joint, xr.Dataset]:
    """One element of the total stiffness and slip force in each region."""
    point = joint.law.point_of_element
    k, s = (np.bincount(point, joint.law.quantity(name)) for name in joint.law.quantities)
    law = ConstantLoad(np.arange(joint.points), k, s)
    return replace(joint, law=law, element_position=joint.position), xr.Dataset()
''',
    )
    made.edit(
        "names.py",
        '        Reduction("harmonic",',
        '        Reduction("single", " of one element", is_fitted=False),\n'
        '        Reduction("harmonic",',
    )
    made.edit(
        "joint/reductions.py",
        '    "iwan": fit_iwan_joint,\n',
        '    "iwan": fit_iwan_joint,\n    "single": single_element,\n',
    )
    made.edit(
        "joint/reductions.py",
        "\n#: each takes",
        "from boltjoint.joint.single import single_element\n\n#: each takes",
    )
    assert made.run("-c", REDUCE).split() == ["3000000.0", "4000000.0", "3.0", "5.0"]


TABULATE = """
import pandas as pd
from boltjoint.report.displays import DISPLAYS
from boltjoint.study.artefact_list import Contents
from boltjoint.config.study import load_study
contents = Contents(load_study(".", {}), DISPLAYS)
print(*sorted(each.case for each in contents.select(form="table") if each.kind == "elements_of"))
print(next(each.title for each in DISPLAYS if each.kind == "elements_of"))
"""


def test_a_table(copy):
    made = copy("figure or table")
    made.add(
        "report/displays/elements_of.py",
        '''"""Numbers of friction elements."""

from boltjoint.study.display import data_of, table


@table(
    "elements_of",
    of=lambda contents: [{"case": case} for case in contents.study.cases],
    reads=(data_of("joint", by=["case"]),),
    job="elements_of_{case}",
    title="numbers of elements",
)
def elements_of(artefact, results):
    """Number of friction elements."""
    from boltjoint.study.tables.elements_of import count

    return count(results.dataset("joint", case=artefact.case, joint="node-to-node"))
''',
    )
    made.add(
        "study/tables/elements_of.py",
        '"""Numbers of friction elements."""\n\n\n'
        'def count(joint):\n    return joint.sizes["element"]\n',
    )
    cases, title = made.run("-c", TABULATE).splitlines()
    assert "three_bolt_constant" in cases.split()
    assert title == "numbers of elements"


MAKE = """
from pathlib import Path
from boltjoint import apply_preload
from boltjoint.config.makers import description_of
from boltjoint.structure.makers.registry import make
content = {"type": "cubes", "edge_mm": 20, "elements": 2, "bolt_stiffness": 1e6}
assembly, structure = make(description_of(content), Path())
print(assembly.attrs["maker"], apply_preload(structure, 1e3)["normal_load"].sum().item())
"""


def test_a_maker_of_assemblies(copy):
    made = copy("maker of assemblies")
    cubes = (ROOT / "tests/workflow/maker_of_cubes/cubes.py").read_text(encoding="utf-8")
    made.add("structure/makers/cubes.py", cubes)
    made.edit(
        "config/makers.py",
        "_MODULES = {\n",
        '_MODULES = {\n    "cubes": "boltjoint.structure.makers.cubes",\n',
    )
    name, total = made.run("-c", MAKE).split()
    assert name == "cubes"
    # springs of the heads bear a part of the tension of the four bolts
    assert 3e3 < float(total) < 4e3


METHOD = """
import numpy as np
from boltjoint import ConstantLoad, LinearModes, solve_branch
from boltjoint.dynamics.response.others import Others
from boltjoint.friction.aft import AlternatingFrequencyTime
exec(open("joint.py").read())
joint = joint_of(AlternatingFrequencyTime(ConstantLoad([0], [1e5], [10.0]), samples=64))
methods = LinearModes(), Others()
one, other = (solve_branch(joint, 1.0, method, damping=0.01) for method in methods)
print(one.peak_amplitude, other.peak_amplitude, Others().name)
"""


def test_a_way_to_find_responses(copy, tmp_path):
    made = copy("way to find responses")
    made.add(
        "dynamics/response/others.py",
        '''"""Responses in linear modes with Jacobians by differences."""

from dataclasses import dataclass

from boltjoint.dynamics.response.methods import LinearModes, Method


@dataclass(frozen=True)
class Others(LinearModes):
    """All linear modes as coordinates, under another name."""

    @property
    def name(self):
        return "others"


assert issubclass(Others, Method)
''',
    )
    (tmp_path / "joint.py").write_text(JOINT)
    one, other, name = made.run("-c", METHOD).split()
    assert float(other) == pytest.approx(float(one), rel=1e-9)
    assert name == "others"
