"""What a study asks of an assembly from matrices before any job."""

import pytest
from matrix_files import exported, keys, write_npz
from small_study import ASSEMBLY, CASE, SETTINGS, mesh_of, write

from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.config.varied_keys import keys_that_vary
from boltjoint.names import JointName
from boltjoint.structure.makers.registry import structure_of
from boltjoint.study import estimate

OF_CASE = {"excitation": {"kind": "inputs", "inputs": [{"name": "shaker"}]}, "outputs": ["sensor"]}


@pytest.fixture(scope="module")
def made():
    return structure_of(mesh_of(ASSEMBLY))


@pytest.fixture
def study(made, tmp_path):
    """A study of the structure of the small one, with other keys of its assembly or case."""
    write_npz(tmp_path / "joint.npz", exported(made))

    def read(case=OF_CASE, **changes):
        write(tmp_path / "config/assemblies/two_bolt.yaml", keys(made) | changes)
        write(tmp_path / "config/cases/small.yaml", CASE | case)
        write(tmp_path / "config/config.yaml", SETTINGS)
        return load_study(tmp_path)

    return read


def test_the_estimate_counts_the_whole_where_no_symmetry_halves_it(study, tmp_path):
    of_matrices = study()
    write(tmp_path / "config/assemblies/two_bolt.yaml", ASSEMBLY)
    write(tmp_path / "config/cases/small.yaml", CASE)
    of_mesh = load_study(tmp_path)
    memory = [
        estimate.Resources(each).of("preload", "two_bolt")["mem_mb"]
        for each in (of_matrices, of_mesh)
    ]
    assert memory[0] > memory[1]
    small = estimate.Resources.SMALL
    assert estimate.Resources(of_mesh).of("build", "two_bolt") == small
    assert estimate.Resources(of_matrices).of("build", "two_bolt") != small


def test_numbers_that_name_something_do_not_vary(study):
    found = study()
    varied = keys_that_vary(
        found.cases["small"], found.assemblies["two_bolt"], JointName("node-to-node")
    )
    assert "assembly.contact.penalty_N_per_m3" in varied
    assert not [key for key in varied if key.endswith(("locked", "numbered_from", "dof"))]


@pytest.mark.parametrize(
    ("changes", "case", "line"),
    [
        ({"mass": "MM"}, {}, "joint.npz: MM is not there; did you mean M?"),
        (
            {"outputs": [{"name": "sensor", "dof": 10**6}]},
            {},
            "joint.npz: K has degrees of freedom from 0 to 5176: dof of sensor is 1000000",
        ),
        (
            {},
            {"sensors": [{"name": "a", "x_mm": 1, "y_mm": 0, "z_mm": 0, "direction": "z"}]},
            "is no place of matrices, which have no nodes: name an input or an output",
        ),
        (
            {},
            {"excitation": {"kind": "distributed", "surface": "top", "direction": "z"}},
            'excitation.surface: "top" is no surface of two_bolt',
        ),
    ],
)
def test_what_matrices_do_not_have_is_said_before_any_job(study, changes, case, line):
    with pytest.raises(ConfigError, match=r"^config/") as refused:
        study(OF_CASE | case, **changes)
    assert line in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1
