"""What a study asks of an assembly from matrices before any job."""

import modal_files
import pytest
from matrix_files import exported, keys, write_npz
from small_study import ASSEMBLY, CASE, SETTINGS, mesh_of, write

from boltjoint.config.study import load_study
from boltjoint.config.types import ConfigError
from boltjoint.config.varied_keys import keys_that_vary
from boltjoint.damping import LossFactor, ModalDamping
from boltjoint.names import JointName
from boltjoint.structure.makers.registry import structure_of
from boltjoint.structure.modes import find_modes
from boltjoint.structure.preload import apply_preload
from boltjoint.study import memory_and_time_of_study as needs

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
        needs.Resources(each).of("preload", "two_bolt")["mem_mb"] for each in (of_matrices, of_mesh)
    ]
    assert memory[0] > memory[1]
    small = needs.Resources.SMALL
    assert needs.Resources(of_mesh).of("build", "two_bolt") == small
    assert needs.Resources(of_matrices).of("build", "two_bolt") != small


def test_numbers_that_name_something_do_not_vary(study):
    found = study()
    varied = keys_that_vary(
        found.cases["small"], found.assemblies["two_bolt"], JointName("node-to-node")
    )
    assert "assembly.contact.penalty_N_per_m3" in varied
    assert not [key for key in varied if key.endswith(("locked", "numbered_from", "dof"))]


@pytest.fixture
def modal_study(made, tmp_path):
    """The same of its modes, with other keys of its case, sweeps and damping ratios."""
    basis, preload = find_modes(made, "free-2"), apply_preload(made, 10000)
    ratios = {"zeta": [1e-3, 3e-3]}
    write_npz(tmp_path / "joint.npz", modal_files.variables(basis, preload) | ratios)

    def read(case, **changes):
        contact = modal_files.KEYS["contact"] | {"preload_N": 10000}
        keys = modal_files.KEYS | {"contact": contact} | changes
        write(tmp_path / "config/assemblies/two_bolt.yaml", keys)
        solve = [{"resonance": 1, "joints": ["node-to-node"]}]
        of_case = CASE | OF_CASE | {"solve": solve, "coordinates": ["linear"]} | case
        of_case = {key: value for key, value in of_case.items() if value is not None}
        swept = of_case.pop("sweeps", [])
        write(tmp_path / "config/cases/small.yaml", of_case)
        sweep = {"case": "small", "vary": {"preload_N": [1e4, 2e4]}, "design": {"kind": "grid"}}
        of_sweep = sweep | {"basis": "free-2", "joint": "node-to-node"}
        write(tmp_path / "config/sweeps/loads.yaml", of_sweep)
        settings = SETTINGS | {"convergence": {}, "sweeps": swept}
        write(tmp_path / "config/config.yaml", settings)
        return load_study(tmp_path)

    return read


def test_a_case_has_the_damping_and_the_preload_that_come_with_the_modes(modal_study):
    modes = {"damping_ratio": "zeta"}
    undamped = {"loss_factor": None}
    of_modes = modal_study(undamped, modes=modes).case("small").structural_damping
    assert of_modes == ModalDamping((1e-3, 3e-3))
    own = modal_study({}, modes=modes).case("small").structural_damping
    assert own == LossFactor(CASE["loss_factor"])
    study = modal_study(undamped | {"preload_N": None})
    assert study.case("small").preload == "10000"
    assert study.case("small").structural_damping == LossFactor(0.002)
    # the preload of given loads says what they are
    varied = keys_that_vary(
        study.cases["small"], study.assemblies["two_bolt"], JointName("node-to-node")
    )
    assert "assembly.contact.friction_coefficient" in varied
    assert not [key for key in varied if key.startswith("assembly.") and "preload" in key]


@pytest.mark.parametrize(
    ("case", "line"),
    [
        ({"bolt_preloads_N": {"bolt 1": 9000}}, "is no bolt of two_bolt; there are: none"),
        ({"preload_N": 9000}, "preload_N: 9000 must be 10000, that of contact.normal_load of "),
        ({"modes": ["enriched-4"]}, "must be free-N or all-N: nothing but modes is known of "),
        ({"sweeps": ["loads"]}, "must not vary with contact.normal_load of two_bolt: loads that "),
    ],
)
def test_what_modal_data_do_not_have_is_said_before_any_job(modal_study, case, line):
    with pytest.raises(ConfigError, match=r"^config/") as refused:
        modal_study(case)
    assert line in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


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
